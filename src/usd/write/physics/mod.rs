//! Cloth as physics: schemas and attributes on both products, and prims below a scope beside them.
//!
//! ```text
//! /Coat              body
//!   /sim             simulation mesh, rest shape, bind pose
//!   /render          bind pose
//!   /physics         Scope
//!     /cotton        Material
//!     /anchor        rigid body that holds pins to the world, with a joint
//!     /pins          attachment
//!     /piece_0 …     attachments of loose pieces
//!     /doubled       collision filter
//!     /scene         PhysicsScene, if asked
//! ```
//!
//! Numbers are in units of the stage: solvers such as Newton take no account of `metersPerUnit`.

mod attach;
mod chaos;
mod dialect;

use super::product::Author;
use super::role::{Product, ProductRole};
use super::scope::beside;
use crate::codes;
use crate::names;
use crate::read::world_of;
use dialect::{DIALECTS, Dialect};
use glam::{DMat4, Vec3};
use openusd::gf::{Vec2i, Vec3i};
use openusd::sdf::{self, AbstractData, FieldKey, Path, PrimSpec, Specifier, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use tailor_costume::binding::Binding;
use tailor_costume::cloth::{Cloth, FABRICS, Fabric};
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::Mesh;

/// Name of the scope.
pub const SCOPE: &str = "physics";
/// Name of the mesh of flat panels.
pub const PANELS: &str = "panels";
/// Poisson's ratio of fabrics.
const POISSON: f32 = 0.3;
/// Standard gravity. \[m/s²\]
const GRAVITY: f64 = 9.81;

/// The attributes of a mesh's points in the bind pose, in each dialect.
pub fn pose_points() -> impl Iterator<Item = String> {
    DIALECTS.iter().map(Dialect::pose_points)
}

/// The cloth of one garment, with its meshes and the prims that get its physics.
struct Physics<'a> {
    cloth: &'a Cloth,
    sim: &'a Mesh,
    sim_path: Path,
    /// The render mesh, or those of the panels.
    renders: Vec<BoundRender<'a>>,
    scope: Path,
    panels: Path,
    /// Metres in a unit of the stage.
    meters: f64,
}

/// A render mesh and the places of its points.
struct BoundRender<'a> {
    path: Path,
    mesh: &'a Mesh,
    binding: Option<&'a Binding>,
}

impl Author<'_> {
    /// Authors the physics of the simulation mesh among `products`, if it is cloth. Warns where a mean of fabrics is written.
    ///
    /// # Errors
    /// A prim to pin to that the stage lacks; a name or type that the layer does not admit.
    pub fn physics(&mut self, products: &[Product]) -> Result<Option<Warning>, Error> {
        let fault =
            |e: openusd::Error| Error::usd(format!("the physics cannot be written: {e}")).code(codes::WRITE_FAILED);
        let path = |name: &str| self.model.sibling_path(name).map_err(|e| fault(e.into()));
        let sim = products.iter().find(|product| product.role == ProductRole::Sim);
        let Some((product, cloth)) = sim.and_then(|product| Some((product, product.cloth?))) else {
            return self.remove_physics(products).map(|()| None).map_err(fault);
        };
        let renders = products.iter().filter(|product| product.role == ProductRole::Render);
        let renders = renders.map(|render| {
            Ok::<_, Error>(BoundRender { path: path(render.name)?, mesh: render.mesh, binding: render.binding })
        });
        let physics = Physics {
            cloth,
            sim: product.mesh,
            sim_path: path(product.name)?,
            renders: renders.collect::<Result<_, _>>()?,
            scope: path(&beside(SCOPE, product.name))?,
            panels: path(&beside(PANELS, product.name))?,
            meters: product.mesh.units.meters_per_unit,
        };
        let held = self.held(&physics)?;
        self.author_physics(&physics, &held).map_err(fault)?;
        Ok((cloth.fabrics.len() > 1).then(|| physics.mean_fabric()))
    }

    /// The frame that holds the pins: the transform from the mesh to it, and its path; none for a new anchor beside the mesh.
    fn held(&self, physics: &Physics<'_>) -> Result<(DMat4, Option<Path>), Error> {
        let target = &physics.cloth.pin_target;
        if target.is_empty() || physics.cloth.pins.is_empty() {
            return Ok((self.model.transforms.to_parent, None));
        }
        let (path, world) = world_of(&self.model.origin, target)?;
        Ok((world.inverse() * self.model.transforms.to_world, Some(path)))
    }

    fn author_physics(&mut self, physics: &Physics<'_>, held: &(DMat4, Option<Path>)) -> openusd::Result<()> {
        self.scope(&physics.scope, SCOPE)?;
        self.remove_bodies(|name| physics.has(name))?;
        if !self.binds_physics_material() {
            self.material(physics)?;
        }
        for dialect in DIALECTS.iter().filter(|dialect| physics.has(dialect.name)) {
            self.body(physics, dialect)?;
            self.sim_mesh(physics, dialect)?;
            self.pose(&physics.sim_path, physics.sim, dialect, dialect.sim_purposes)?;
            for render in &physics.renders {
                self.pose(&render.path, render.mesh, dialect, &["bindPose"])?;
            }
            self.pins(physics, dialect, held)?;
            self.pieces(physics, dialect)?;
            self.filter(physics, dialect)?;
        }
        if physics.has("chaos") {
            self.chaos(physics)?;
        }
        self.plain_attachments(physics)?;
        self.panels(physics)?;
        if physics.cloth.scene { self.scene(physics) } else { Ok(()) }
    }

    /// Deactivates what an earlier build wrote beside `products`.
    fn remove_physics(&mut self, products: &[Product]) -> openusd::Result<()> {
        if !self.has_built_physics() {
            return Ok(());
        }
        for product in products {
            self.deactivate(&beside(SCOPE, product.name))?;
            self.deactivate(&beside(PANELS, product.name))?;
        }
        self.remove_bodies(|_| false)
    }

    /// Whether an earlier build wrote physics over the same model into the input.
    fn has_built_physics(&self) -> bool {
        let is_scope = |name: &str| name == SCOPE || name.ends_with("_physics");
        self.is_overlay && self.model.siblings.iter().any(|(name, sibling)| is_scope(name) && sibling.product)
    }

    /// Removes the schemas that an earlier build gave to the prim above both meshes, except for dialects that are `kept`.
    fn remove_bodies(&mut self, kept: impl Fn(&str) -> bool) -> openusd::Result<()> {
        let root = Some(self.model.parent.clone()).filter(|root| *root != Path::abs_root());
        let Some(root) = root.filter(|_| self.has_built_physics()) else { return Ok(()) };
        PrimSpec::over(self.data, &root)?;
        let of_dialects = DIALECTS.iter().filter(|dialect| !kept(dialect.name)).flat_map(|dialect| dialect.body);
        let all = of_dialects.chain(chaos::BODY.iter().filter(|_| !kept("chaos")));
        let deleted: Vec<Token> = all.map(|name| Token::from(*name)).collect();
        // Another garment of this layer may have given schemas to the same prim. They win over what is deleted.
        let mut list = self.schema_list(&root)?;
        list.deleted_items.extend(deleted);
        self.data.set_field(&root, FieldKey::ApiSchemas.as_str(), list.into());
        Ok(())
    }

    /// Adds schemas to a prim, after those that it has.
    fn apply(&mut self, prim: &Path, schemas: &[&str]) -> openusd::Result<()> {
        if !self.data.has_spec(prim) {
            PrimSpec::over(self.data, prim)?;
        }
        let mut list = self.schema_list(prim)?;
        let items = if list.explicit { &mut list.explicit_items } else { &mut list.prepended_items };
        for schema in schemas.iter().map(|name| Token::from(*name)) {
            if !items.contains(&schema) {
                items.push(schema);
            }
        }
        self.data.set_field(prim, FieldKey::ApiSchemas.as_str(), list.into());
        Ok(())
    }

    fn schema_list(&self, prim: &Path) -> openusd::Result<sdf::TokenListOp> {
        let list = self.data.try_field(prim, FieldKey::ApiSchemas.as_str())?;
        Ok(list.and_then(|list| list.into_owned().try_as_token_list_op()).unwrap_or_default())
    }

    fn body(&mut self, physics: &Physics<'_>, dialect: &Dialect) -> openusd::Result<()> {
        let root = Some(self.model.parent.clone()).filter(|root| *root != Path::abs_root());
        self.apply(root.as_ref().unwrap_or(&physics.sim_path), dialect.body)
    }

    fn sim_mesh(&mut self, physics: &Physics<'_>, dialect: &Dialect) -> openusd::Result<()> {
        let (path, cloth) = (&physics.sim_path, physics.cloth);
        self.apply(path, dialect.sim)?;
        let rest = cloth.rest.as_ref().filter(|_| dialect.free_rest);
        let (points, triangles) = match rest {
            Some(rest) => (rest.points.as_slice(), rest.triangles.clone()),
            None => (physics.sim.points.as_slice(), physics.triangles()),
        };
        self.points(path, &format!("{}restShapePoints", dialect.space), points)?;
        let triangles = triangles.iter().map(|t| Vec3i::from(t.map(|v| v as i32))).collect();
        let name = format!("{}{}", dialect.space, dialect.rest_triangles);
        self.attribute(path, &name, ValueTypeName::INT3_ARRAY, Variability::Varying, Value::Vec3iVec(triangles))?;
        self.token(path, &format!("{}restBendAnglesDefault", dialect.space), dialect.rest_angles)?;
        if let Some(rest) = rest {
            self.flat_seams(path, dialect, &rest.flat_seams)?;
        }
        if !dialect.thickness_on_material {
            self.elements(physics, "thicknesses", |fabric| f64::from(fabric.thickness) / physics.meters)?;
            if cloth.fabrics.len() > 1 {
                self.floats(path, "physics:masses", cloth.masses.iter().map(|m| *m as f32).collect())?;
                self.token(path, "physics:masses:elementType", "face")?;
            }
        }
        Ok(())
    }

    /// Rest angles of 0 at the edges between pairs of triangles.
    fn flat_seams(&mut self, sim: &Path, dialect: &Dialect, pairs: &[[FaceId; 2]]) -> openusd::Result<()> {
        if pairs.is_empty() {
            return Ok(());
        }
        let indices = pairs.iter().map(|pair| Vec2i::from(pair.map(|face| face.index() as i32))).collect();
        let name = format!("{}restAdjTriPairs", dialect.space);
        self.attribute(sim, &name, ValueTypeName::INT2_ARRAY, Variability::Varying, Value::Vec2iVec(indices))?;
        self.floats(sim, &format!("{}restBendAngles", dialect.space), vec![0.0; pairs.len()])
    }

    /// A value of the fabric of each triangle; one where all have the same.
    fn elements(&mut self, physics: &Physics<'_>, name: &str, value: impl Fn(&Fabric) -> f64) -> openusd::Result<()> {
        let of: Vec<f32> = physics.cloth.fabrics.iter().map(|named| value(&named.fabric) as f32).collect();
        let each = physics.cloth.fabric_of.iter().map(|&i| of[i as usize]);
        let (values, kind) = match of.as_slice() {
            [one] => (vec![*one], "constant"),
            _ => (each.collect(), "face"),
        };
        self.floats(&physics.sim_path, &format!("physics:{name}"), values)?;
        self.token(&physics.sim_path, &format!("physics:{name}:elementType"), kind)
    }

    fn pose(&mut self, prim: &Path, mesh: &Mesh, dialect: &Dialect, purposes: &[&str]) -> openusd::Result<()> {
        let (schema, space) = dialect.pose;
        self.apply(prim, &[schema])?;
        self.points(prim, &dialect.pose_points(), mesh.points.as_slice())?;
        let purposes = Value::TokenVec(purposes.iter().map(|purpose| Token::from(*purpose)).collect());
        self.attribute(prim, &format!("{space}purposes"), ValueTypeName::TOKEN_ARRAY, Variability::Uniform, purposes)
    }

    fn points(&mut self, prim: &Path, name: &str, points: &[Vec3]) -> openusd::Result<()> {
        self.vectors(prim, name, ValueTypeName::POINT3F_ARRAY, points)
    }

    fn float(&mut self, prim: &Path, name: &str, value: f64) -> openusd::Result<()> {
        self.attribute(prim, name, ValueTypeName::FLOAT, Variability::Varying, Value::Float(value as f32))
    }

    /// Whether the model binds a physics material of its own, which products have too.
    fn binds_physics_material(&self) -> bool {
        self.model.carried.iter().any(|record| record.name == names::PHYSICS_MATERIAL && record.has_value())
    }

    fn material(&mut self, physics: &Physics<'_>) -> openusd::Result<()> {
        if !DIALECTS.iter().any(|dialect| physics.has(dialect.name)) {
            return Ok(());
        }
        let path = self.in_scope(&physics.scope, physics.material_name(), "Material")?;
        let (fabric, meters) = (physics.cloth.mean, physics.meters);
        for dialect in DIALECTS.iter().filter(|dialect| physics.has(dialect.name)) {
            self.apply(&path, dialect.material)?;
            let thickness = f64::from(fabric.thickness);
            let stretch = f64::from(fabric.stretch());
            let modulus = stretch / thickness * (1.0 - f64::from(POISSON * POISSON));
            // Of mass, length and time, only lengths have other units.
            for (name, value) in [
                ("density", f64::from(fabric.density) / thickness * meters.powi(3)),
                ("staticFriction", f64::from(fabric.friction)),
                ("dynamicFriction", f64::from(fabric.friction)),
                ("youngsModulus", modulus * meters),
                ("poissonsRatio", f64::from(POISSON)),
                ("surfaceStretchStiffness", stretch),
                ("surfaceShearStiffness", f64::from(fabric.shear)),
                ("surfaceBendStiffness", f64::from(fabric.bend()) / (meters * meters)),
            ] {
                self.float(&path, &format!("{}{name}", dialect.space), value)?;
            }
            if dialect.thickness_on_material {
                self.float(&path, &format!("{}surfaceThickness", dialect.space), thickness / meters)?;
            }
        }
        self.apply(&physics.sim_path, &[names::MATERIAL_BINDING_API])?;
        self.target(&physics.sim_path, names::PHYSICS_MATERIAL, &path)
    }

    /// The shape at rest as a mesh beside the simulation mesh, if that is asked for and there is one.
    fn panels(&mut self, physics: &Physics<'_>) -> openusd::Result<()> {
        let Some(rest) = physics.cloth.rest.as_ref().filter(|_| physics.cloth.panels) else {
            return self.deactivate(physics.panels.name().unwrap_or(PANELS));
        };
        let path = physics.panels.clone();
        PrimSpec::new(self.data, &path, Specifier::Def, names::MESH)?;
        let mark = self.mark(PANELS);
        self.data.set_field(&path, names::CUSTOM_DATA, mark);
        self.data.set_field(&path, FieldKey::Active.as_str(), Value::Bool(true));
        self.points(&path, names::POINTS, &rest.points)?;
        let corners = rest.triangles.as_flattened().iter().map(|v| *v as i32).collect();
        self.ints(&path, names::FACE_VERTEX_INDICES, corners)?;
        self.ints(&path, names::FACE_VERTEX_COUNTS, vec![3; rest.triangles.len()])?;
        self.token(&path, names::SUBDIVISION_SCHEME, "none")?;
        self.token(&path, names::PURPOSE, ProductRole::Sim.purpose(None))?;
        let extent = Value::Vec3fVec(super::product::extent(&rest.points));
        self.attribute(&path, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, extent)
    }

    fn scene(&mut self, physics: &Physics<'_>) -> openusd::Result<()> {
        let path = self.in_scope(&physics.scope, "scene", "PhysicsScene")?;
        let up = self.model.stage_metadata.iter().find(|(key, _)| key == names::UP_AXIS).map(|(_, value)| value);
        let is_z = matches!(up, Some(Value::Token(axis)) if axis.as_str() == "Z");
        let down = if is_z { [0.0, 0.0, -1.0] } else { [0.0, -1.0, 0.0] };
        let down = Value::Vec3f(down.into());
        self.attribute(&path, "physics:gravityDirection", ValueTypeName::VECTOR3F, Variability::Varying, down)?;
        self.float(&path, "physics:gravityMagnitude", GRAVITY / physics.meters)
    }
}

impl Physics<'_> {
    fn has(&self, dialect: &str) -> bool {
        self.cloth.physics.iter().any(|name| name == dialect)
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let corners = self.sim.faces.corners().as_slice();
        corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v.index() as u32)).collect()
    }

    /// The name of the material: that of its only fabric, if it is a preset. Any other may be that of a prim beside it.
    fn material_name(&self) -> &str {
        match self.cloth.fabrics.as_slice() {
            [one] if FABRICS.contains(&one.name.as_str()) => &one.name,
            _ => "fabric",
        }
    }

    /// The name of a prim of one dialect, where others have prims of the same kind.
    fn own_name(&self, dialect: &Dialect, name: &str) -> String {
        let is_first = DIALECTS.iter().find(|d| self.has(d.name)).is_some_and(|first| first.name == dialect.name);
        if is_first { name.to_owned() } else { format!("{}_{name}", dialect.name) }
    }

    fn mean_fabric(&self) -> Warning {
        let fabrics: Vec<String> = self.cloth.fabrics.iter().map(|named| named.name.clone()).collect();
        let problem = "aousd and omni take one material for a mesh: stretch, shear, bend and friction are means by area; \
                       aousd has thickness and mass for each face";
        let warning = Warning::of_sets(codes::MEAN_FABRIC, fabrics, problem.to_owned());
        warning.remedy("Model parts of other fabrics as meshes of their own, where that matters")
    }
}
