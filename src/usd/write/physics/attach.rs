//! Pins, attachments of loose pieces, and filters of collisions.

use super::Physics;
use super::dialect::Dialect;
use crate::names;
use crate::write::product::Author;
use glam::{DMat4, Vec3};
use openusd::sdf::{AbstractData, Path, Value, ValueTypeName, Variability};
use tailor_mesh::connectivity::VertexId;

impl Author<'_> {
    /// Pins to a prim, or to a rigid body of their own that a joint holds to the world.
    pub(super) fn pins(
        &mut self,
        physics: &Physics<'_>,
        dialect: &Dialect,
        held: &(DMat4, Option<Path>),
    ) -> openusd::Result<()> {
        let pins = &physics.cloth.pins;
        if pins.is_empty() {
            return Ok(());
        }
        let (to_target, target) = held;
        let target = match target {
            Some(path) => path.clone(),
            None => self.anchor(physics)?,
        };
        let at = |v: &VertexId| to_target.transform_point3(physics.sim.points[*v].as_dvec3()).as_vec3();
        let positions: Vec<Vec3> = pins.iter().map(at).collect();
        let path = self.attachment(physics, dialect, "pins", 0, pins)?;
        self.target(&path, &format!("{}src1", dialect.space), &target)?;
        let (name, kind) = dialect.attachment.positions.clone();
        self.vectors(&path, &format!("{}{name}", dialect.space), kind, &positions)
    }

    /// A kinematic body with a joint to the world: solvers attach particles to bodies alone.
    fn anchor(&mut self, physics: &Physics<'_>) -> openusd::Result<Path> {
        let path = physics.scope.append_path("anchor")?;
        if self.data.has_spec(&path.append_property("physics:kinematicEnabled")?) {
            return Ok(path);
        }
        let path = self.in_scope(&physics.scope, "anchor", "Xform")?;
        self.apply(&path, &["PhysicsRigidBodyAPI", "PhysicsMassAPI"])?;
        let kinematic = Value::Bool(true);
        self.attribute(&path, "physics:kinematicEnabled", ValueTypeName::BOOL, Variability::Varying, kinematic)?;
        self.float(&path, "physics:mass", 1.0)?;
        let inertia = Value::Vec3f([1.0, 1.0, 1.0].into());
        self.attribute(&path, "physics:diagonalInertia", ValueTypeName::FLOAT3, Variability::Varying, inertia)?;
        let axes = Value::Quatf(openusd::gf::Quatf { w: 1.0, x: 0.0, y: 0.0, z: 0.0 });
        self.attribute(&path, "physics:principalAxes", ValueTypeName::QUATF, Variability::Varying, axes)?;
        let joint = self.in_scope(&physics.scope, "anchor_joint", "PhysicsFixedJoint")?;
        self.target(&joint, "physics:body1", &path)?;
        let at = self.model.transforms.to_world * self.model.transforms.to_parent.inverse();
        let (_, turn, at) = at.to_scale_rotation_translation();
        let place = Value::Vec3f(at.as_vec3().to_array().into());
        self.attribute(&joint, "physics:localPos0", ValueTypeName::POINT3F, Variability::Varying, place)?;
        let [x, y, z, w] = turn.as_quat().to_array();
        let turn = Value::Quatf(openusd::gf::Quatf { w, x, y, z });
        self.attribute(&joint, "physics:localRot0", ValueTypeName::QUATF, Variability::Varying, turn)?;
        Ok(path)
    }

    /// An attachment of vertices, without its other end, which is a transform (0) or triangles (1).
    fn attachment(
        &mut self,
        physics: &Physics<'_>,
        dialect: &Dialect,
        name: &str,
        end: usize,
        vertices: &[VertexId],
    ) -> openusd::Result<Path> {
        let names = &dialect.attachment;
        let name = physics.own_name(dialect, name);
        let path = self.in_scope(&physics.scope, &name, names.types[end])?;
        self.target(&path, &format!("{}src0", dialect.space), &physics.sim_path)?;
        if let Some(kinds) = names.kinds {
            self.token(&path, &format!("{}type0", dialect.space), "point")?;
            self.token(&path, &format!("{}type1", dialect.space), kinds[end])?;
        }
        let vertices = vertices.iter().map(|v| v.index() as i32).collect();
        self.ints(&path, &format!("{}{}", dialect.space, names.vertices), vertices)?;
        Ok(path)
    }

    pub(super) fn pieces(&mut self, physics: &Physics<'_>, dialect: &Dialect) -> openusd::Result<()> {
        for (number, piece) in physics.cloth.attachments.iter().enumerate() {
            let path = self.attachment(physics, dialect, &format!("piece_{number}"), 1, &piece.points)?;
            let names = &dialect.attachment;
            self.target(&path, &format!("{}src1", dialect.space), &physics.sim_path)?;
            let faces = piece.faces.iter().map(|face| face.index() as i32).collect();
            self.ints(&path, &format!("{}{}", dialect.space, names.triangles), faces)?;
            // Heights are in units of the stage.
            let height = physics.sim.units.scale as f32;
            let coords: Vec<Vec3> = piece.coords.iter().map(|c| Vec3::new(c.x, c.y, c.z * height)).collect();
            let name = format!("{}{}", dialect.space, names.coords);
            self.vectors(&path, &name, ValueTypeName::VECTOR3F_ARRAY, &coords)?;
        }
        Ok(())
    }

    /// The attachments of loose pieces as data of the simulation mesh, for solvers that read no attachments of cloth to itself.
    pub(super) fn plain_attachments(&mut self, physics: &Physics<'_>) -> openusd::Result<()> {
        let all = || physics.cloth.attachments.iter();
        if all().next().is_none() {
            return Ok(());
        }
        let path = &physics.sim_path;
        let points = all().flat_map(|a| &a.points).map(|v| v.index() as i32).collect();
        self.ints(path, names::ATTACH_POINTS, points)?;
        self.ints(path, names::ATTACH_FACES, all().flat_map(|a| &a.faces).map(|f| f.index() as i32).collect())?;
        let coords: Vec<Vec3> = all().flat_map(|a| &a.coords).copied().collect();
        self.vectors(path, names::ATTACH_COORDS, ValueTypeName::VECTOR3F_ARRAY, &coords)
    }

    /// A filter of collisions between triangles that are nearer than the thickness.
    pub(super) fn filter(&mut self, physics: &Physics<'_>, dialect: &Dialect) -> openusd::Result<()> {
        let pairs = &physics.cloth.doubled;
        if pairs.is_empty() {
            return Ok(());
        }
        let path = self.in_scope(&physics.scope, &physics.own_name(dialect, "doubled"), dialect.filter)?;
        let groups = pairs.chunk_by(|a, b| a[0] == b[0]);
        let counts: [Vec<i32>; 2] =
            [groups.clone().map(|_| 1).collect(), groups.clone().map(|g| g.len() as i32).collect()];
        let index = |pair: &[tailor_mesh::connectivity::FaceId; 2], k: usize| pair[k].index() as i32;
        let indices: [Vec<i32>; 2] =
            [groups.map(|g| index(&g[0], 0)).collect(), pairs.iter().map(|pair| index(pair, 1)).collect()];
        for (k, (counts, indices)) in counts.into_iter().zip(indices).enumerate() {
            self.target(&path, &format!("{}src{k}", dialect.space), &physics.sim_path)?;
            for (name, values) in [("groupElemCounts", counts), ("groupElemIndices", indices)] {
                let name = format!("{}{name}{k}", dialect.space);
                match dialect.unsigned {
                    true => {
                        let values = Value::UintVec(values.into_iter().map(|v| v as u32).collect());
                        self.attribute(&path, &name, ValueTypeName::UINT_ARRAY, Variability::Varying, values)?;
                    }
                    false => self.ints(&path, &name, values)?,
                }
            }
        }
        Ok(())
    }
}
