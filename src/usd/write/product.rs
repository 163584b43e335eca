//! One product as prims and properties of a layer.

use super::role::{Product, ProductRole, SetChoice, sims};
use crate::assets::Anchor;
use crate::codes;
use crate::names::{self, UsdToken};
use crate::read::{Model, Sibling};
use crate::record::{Content, Record};
use crate::values::array;
use glam::Vec3;
use openusd::gf::Vec3f;
use openusd::sdf::{self, AbstractData, FieldKey, Path, PrimSpec, Specifier, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use std::collections::HashMap;
use std::sync::Arc;
use tailor_costume::binding::Binding;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{Interpolation, Meaning, Mesh, Primvar, PrimvarRole, Values};
use tailor_mesh::meter;

/// Authors products in a layer.
pub struct Author<'a> {
    /// The layer.
    pub data: &'a mut sdf::Data,
    /// The model, whose siblings they are.
    pub model: &'a Model,
    /// The anchor of the layer's asset paths.
    pub anchor: Anchor<'a>,
    /// Whether the layer is over the stage, with the products that it has already.
    pub is_overlay: bool,
    /// The sets that products have.
    pub sets: SetChoice,
}

impl Author<'_> {
    /// Authors `product` as a sibling of the model. Warns of primvars that no file can hold.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn product(&mut self, product: &Product) -> openusd::Result<Warnings> {
        let path = self.model.sibling_path(product.name)?;
        let model = self.model;
        PrimSpec::new(self.data, &path, Specifier::Def, names::MESH)?;
        self.data.set_field(&path, FieldKey::Documentation.as_str(), Value::String(product.doc(&model.panels)));
        self.data.set_field(&path, names::CUSTOM_DATA, self.mark(product.role.name()));
        let before = model.siblings.get(product.name).filter(|_| self.is_overlay);
        self.schemas(&path, &model.applied, before.is_some());
        let rest = self.rest(product.mesh);
        for record in model.carried.iter().filter(|record| rest.is_none() || !names::is_drawn_material(&record.name)) {
            self.carry(record, &path)?;
        }
        self.mesh(&path, product.role, product.mesh)?;
        let of_role = |role| product.mesh.primvars.iter().filter(move |p| p.role == role);
        let mut warnings = Warnings::default();
        for primvar in of_role(PrimvarRole::Primvar) {
            warnings.extend(self.primvar(&path, primvar)?);
        }
        for normals in of_role(PrimvarRole::Normals) {
            warnings.extend(self.normals(&path, normals)?);
        }
        self.subsets(&path, product.mesh)?;
        if let Some(faces) = rest {
            self.bind_rest(&path, product.mesh, faces)?;
        }
        self.shapes(&path, product.mesh)?;
        if let Some(before) = before {
            self.block_earlier(&path, before)?;
        }
        Ok(warnings)
    }

    /// Authors what a product has as the model has it.
    pub(super) fn carry(&mut self, record: &Record, prim: &Path) -> openusd::Result<()> {
        match self.is_overlay {
            true => record.author_over(self.data, prim, self.anchor),
            false => record.author(self.data, prim, self.anchor),
        }
    }

    /// Authors where the points of a render mesh are bound, on the simulation meshes among `products`.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn render_bindings(&mut self, render: &Product, products: &[Product]) -> openusd::Result<()> {
        let path = self.model.sibling_path(render.name)?;
        for sim in sims(products) {
            let of_level = render.level_bindings.get(sim.level as usize).map(Arc::as_ref);
            let binding = of_level.or(render.binding);
            let target = self.model.sibling_path(sim.name)?;
            binding.map_or(Ok(()), |binding| self.binding(&path, binding, &target, sim.level))?;
        }
        Ok(())
    }

    /// Authors where the points of the model are bound on a simulation mesh.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn model_binding(&mut self, sim: &Product) -> openusd::Result<()> {
        let target = self.model.sibling_path(sim.name)?;
        let Some(binding) = sim.cage_binding else { return Ok(()) };
        let model = self.model;
        let [faces, coords, source] = names::MODEL_BINDING;
        if model.sewing.points.is_empty() {
            self.places(&target, [faces, coords], binding)?;
        } else {
            let points: Vec<VertexId> = model.sewing.points.iter().map(|&point| VertexId::new(point)).collect();
            self.places(&target, [faces, coords], &binding.of_points(&points))?;
        }
        self.targets(&target, source, &model.panels)
    }

    /// Authors the places of the points of a prim on the simulation mesh `target` of a level of detail.
    pub(super) fn binding(&mut self, prim: &Path, binding: &Binding, target: &Path, level: u32) -> openusd::Result<()> {
        let [faces, coords, sim] = &names::binding(level);
        self.places(prim, [faces, coords], binding)?;
        for name in [faces, coords] {
            let vertex = Value::Token(Token::from(Interpolation::Vertex.token()));
            self.data.set_field(&prim.append_property(name.as_str())?, names::INTERPOLATION, vertex);
        }
        self.target(prim, sim, target)
    }

    /// Faces and coordinates of a binding, by their names.
    fn places(&mut self, prim: &Path, names: [&str; 2], binding: &Binding) -> openusd::Result<()> {
        self.ints(prim, names[0], binding.faces.iter().map(|face| *face as i32).collect())?;
        self.vectors(prim, names[1], ValueTypeName::FLOAT3_ARRAY, &binding.coords)
    }

    /// Authors a relationship to one prim.
    pub(super) fn target(&mut self, prim: &Path, name: &str, target: &Path) -> openusd::Result<()> {
        self.targets(prim, name, std::slice::from_ref(target))
    }

    /// Authors a relationship to some prims.
    fn targets(&mut self, prim: &Path, name: &str, targets: &[Path]) -> openusd::Result<()> {
        let path = prim.append_property(name)?;
        if !self.data.has_spec(&path) {
            sdf::RelationshipSpec::new(self.data, &path, Variability::Uniform, false)?;
        }
        self.data.set_field(
            &path,
            FieldKey::TargetPaths.as_str(),
            sdf::PathListOp::explicit(targets.iter().cloned()).into(),
        );
        Ok(())
    }

    /// Authors the `purpose` of the model itself, or of all its panels.
    ///
    /// # Errors
    /// A layer that does not admit a spec for the model.
    pub fn model_purpose(&mut self, purpose: &str) -> openusd::Result<()> {
        for path in &self.model.panels {
            PrimSpec::over(self.data, path)?;
            self.token(path, names::PURPOSE, purpose)?;
        }
        for path in &self.model.below {
            PrimSpec::over(self.data, path)?;
            self.token(path, names::PURPOSE, self.model.purpose.as_deref().unwrap_or("default"))?;
        }
        Ok(())
    }

    pub(super) fn attribute(
        &mut self,
        prim: &Path,
        name: &str,
        type_name: ValueTypeName,
        variability: Variability,
        value: Value,
    ) -> openusd::Result<()> {
        meter::check();
        let path = prim.append_property(name)?;
        if !self.data.has_spec(&path) {
            sdf::AttributeSpec::new(self.data, &path, type_name, variability, false)?;
        }
        AbstractData::set_field(self.data, &path, FieldKey::Default.as_str(), value);
        Ok(())
    }

    pub(super) fn token(&mut self, prim: &Path, name: &str, token: &str) -> openusd::Result<()> {
        self.attribute(prim, name, ValueTypeName::TOKEN, Variability::Uniform, Value::Token(Token::from(token)))
    }

    pub(super) fn ints(&mut self, prim: &Path, name: &str, values: Vec<i32>) -> openusd::Result<()> {
        self.attribute(prim, name, ValueTypeName::INT_ARRAY, Variability::Varying, Value::IntVec(values))
    }

    pub(super) fn floats(&mut self, prim: &Path, name: &str, values: Vec<f32>) -> openusd::Result<()> {
        self.attribute(prim, name, ValueTypeName::FLOAT_ARRAY, Variability::Varying, Value::FloatVec(values))
    }

    pub(super) fn vectors(
        &mut self,
        prim: &Path,
        name: &str,
        kind: ValueTypeName,
        values: &[Vec3],
    ) -> openusd::Result<()> {
        let values = Value::Vec3fVec(bytemuck::cast_slice(values).to_vec());
        self.attribute(prim, name, kind, Variability::Varying, values)
    }

    /// Applied schemas; an explicit list where it replaces the one of an earlier product.
    pub(super) fn schemas(&mut self, prim: &Path, schemas: &[Token], replace: bool) {
        let list = match replace {
            true => sdf::TokenListOp::explicit(schemas.iter().cloned()),
            false if schemas.is_empty() => return,
            false => sdf::TokenListOp { prepended_items: schemas.to_vec(), ..Default::default() },
        };
        AbstractData::set_field(self.data, prim, FieldKey::ApiSchemas.as_str(), list.into());
    }

    fn mesh(&mut self, prim: &Path, role: ProductRole, mesh: &Mesh) -> openusd::Result<()> {
        let points = mesh.points.as_slice();
        let extent = Value::Vec3fVec(extent(points));
        self.attribute(prim, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, extent)?;
        self.vectors(prim, names::POINTS, ValueTypeName::POINT3F_ARRAY, points)?;
        let faces = &mesh.faces;
        let counts = faces.ids().map(|f| faces.valence(f) as i32).collect();
        self.ints(prim, names::FACE_VERTEX_COUNTS, counts)?;
        let corners = faces.corners().as_slice().iter().map(|v| v.index() as i32).collect();
        self.ints(prim, names::FACE_VERTEX_INDICES, corners)?;
        self.token(prim, names::ORIENTATION, mesh.orientation.token())?;
        self.token(prim, names::PURPOSE, role.purpose(self.model.purpose.as_deref()))?;
        match role {
            ProductRole::Sim => self.token(prim, names::SUBDIVISION_SCHEME, "none")?,
            ProductRole::Render => {
                self.token(prim, names::SUBDIVISION_SCHEME, mesh.rules.scheme.token())?;
                self.token(prim, names::INTERPOLATE_BOUNDARY, mesh.rules.boundary.token())?;
                self.token(prim, names::FACE_VARYING_LINEAR_INTERPOLATION, mesh.rules.face_varying.token())?;
                self.token(prim, names::TRIANGLE_SUBDIVISION_RULE, mesh.rules.triangles.token())?;
            }
        }
        self.sharpness(prim, mesh)
    }

    /// Holes, creases and corners.
    fn sharpness(&mut self, prim: &Path, mesh: &Mesh) -> openusd::Result<()> {
        if !mesh.holes.is_empty() {
            self.ints(prim, names::HOLE_INDICES, mesh.holes.iter().map(|f| f.index() as i32).collect())?;
        }
        if !mesh.creases.is_empty() {
            let creases = &mesh.creases;
            let vertices = creases.iter().flat_map(|c| &c.vertices).map(|v| v.index() as i32).collect();
            self.ints(prim, names::CREASE_INDICES, vertices)?;
            self.ints(prim, names::CREASE_LENGTHS, creases.iter().map(|c| c.vertices.len() as i32).collect())?;
            let uniform = creases.iter().all(|c| c.sharpnesses.windows(2).all(|w| w[0] == w[1]));
            let taken = if uniform { 1 } else { usize::MAX };
            let values = creases.iter().flat_map(|c| c.sharpnesses.iter().take(taken)).copied().collect();
            self.floats(prim, names::CREASE_SHARPNESSES, values)?;
        }
        if !mesh.corners.is_empty() {
            let vertices = mesh.corners.iter().map(|c| c.vertex.index() as i32).collect();
            self.ints(prim, names::CORNER_INDICES, vertices)?;
            self.floats(prim, names::CORNER_SHARPNESSES, mesh.corners.iter().map(|c| c.sharpness).collect())?;
        }
        Ok(())
    }

    fn primvar(&mut self, prim: &Path, primvar: &Primvar) -> openusd::Result<Option<Warning>> {
        let name = format!("{}{}", names::PRIMVARS, primvar.name);
        let Some((type_name, value)) = array(primvar, &self.restated(primvar)) else {
            return Ok(Some(misfit(prim, &name)));
        };
        let record = self.model.declarations.primvars.get(&primvar.name);
        let path = self.declare(prim, &name, type_name, record)?;
        self.data.set_field(&path, FieldKey::Default.as_str(), value);
        let interpolation = Value::Token(Token::from(primvar.interpolation.token()));
        self.data.set_field(&path, names::INTERPOLATION, interpolation);
        let stated = record.is_some_and(|r| r.metadata(names::ELEMENT_SIZE).is_some());
        if primvar.element_size != 1 || stated {
            self.data.set_field(&path, names::ELEMENT_SIZE, Value::Int(primvar.element_size as i32));
        }
        if let Some(Value::Int(row)) = record.and_then(|r| r.metadata(names::UNAUTHORED_VALUES_INDEX))
            && (primvar.indices.is_none() || *row >= primvar.rows() as i32)
        {
            self.data.erase_field(&path, names::UNAUTHORED_VALUES_INDEX);
        }
        if let Some(indices) = &primvar.indices {
            let record = self.model.declarations.primvars.get(&format!("{}{}", primvar.name, names::INDICES_SUFFIX));
            let name = format!("{name}{}", names::INDICES_SUFFIX);
            let path = self.declare(prim, &name, ValueTypeName::INT_ARRAY, record)?;
            let indices = indices.iter().map(|&i| i as i32).collect();
            self.data.set_field(&path, FieldKey::Default.as_str(), Value::IntVec(indices));
        }
        Ok(None)
    }

    /// Authors the attribute `normals`, which has no indices.
    fn normals(&mut self, prim: &Path, primvar: &Primvar) -> openusd::Result<Option<Warning>> {
        let rows = (0..primvar.elements()).map(|i| primvar.row(i));
        let Some((type_name, value)) = array(primvar, &primvar.values.gather(primvar.width(), rows)) else {
            return Ok(Some(misfit(prim, names::NORMALS)));
        };
        self.attribute(prim, names::NORMALS, type_name, Variability::Varying, value)?;
        let path = prim.append_property(names::NORMALS)?;
        let interpolation = Value::Token(Token::from(primvar.interpolation.token()));
        self.data.set_field(&path, names::INTERPOLATION, interpolation);
        Ok(None)
    }

    /// Declares an attribute as the model does, or, without a record of the same type, as a varying one.
    fn declare(
        &mut self,
        prim: &Path,
        name: &str,
        type_name: ValueTypeName,
        record: Option<&Record>,
    ) -> openusd::Result<Path> {
        match record.filter(|r| r.type_name() == Some(&type_name)) {
            Some(record) => record.declare(self.data, prim),
            None => {
                let path = prim.append_property(name)?;
                sdf::AttributeSpec::new(self.data, &path, type_name, Variability::Varying, false)?;
                Ok(path)
            }
        }
    }

    /// The values of a primvar, with asset paths for this layer.
    fn restated(&self, primvar: &Primvar) -> Values {
        match &primvar.values {
            Values::Text(texts) if primvar.meaning == Meaning::AssetPath => {
                let files = &self.model.declarations.assets;
                let restated = |text: &String| files.get(text).map_or(text.clone(), |file| self.anchor.path_to(file));
                Values::Text(texts.iter().map(restated).collect())
            }
            other => other.clone(),
        }
    }

    /// Blocks the properties and children of an earlier product of this name that this one does not have.
    fn block_earlier(&mut self, prim: &Path, before: &Sibling) -> openusd::Result<()> {
        for record in &before.properties {
            if self.data.has_spec(&prim.append_property(record.name.as_str())?) {
                continue;
            }
            let path = record.declare(self.data, prim)?;
            match record.content {
                Content::Attribute { .. } => {
                    self.data.set_field(&path, FieldKey::Default.as_str(), Value::ValueBlock);
                }
                Content::Relationship { .. } => {
                    self.data.set_field(&path, FieldKey::TargetPaths.as_str(), sdf::PathListOp::explicit([]).into());
                }
            }
        }
        for child in &before.children {
            let path = prim.append_path(child.as_str())?;
            if !self.data.has_spec(&path) {
                PrimSpec::over(self.data, &path)?.set_active(false);
            }
        }
        Ok(())
    }
}

/// The error of a layer that does not admit a name or type.
pub fn fault(error: impl std::fmt::Display) -> Error {
    Error::usd(format!("the layer cannot be composed: {error}")).code(codes::COMPOSITION_FAILED)
}

/// The warning of a primvar that no file can hold.
fn misfit(prim: &Path, name: &str) -> Warning {
    Warning::not_carried(format!("{prim}.{name}"), "USD has no type for its values")
}

impl Author<'_> {
    /// The mark by which this program knows what it wrote, and for which model.
    pub(super) fn mark(&self, role: &str) -> Value {
        let model = self.model;
        let mut ours = HashMap::from([
            (names::PRODUCT.to_owned(), Value::String(role.to_owned())),
            (names::PRODUCT_OF.to_owned(), Value::String(model.name())),
        ]);
        if model.is_sewn() {
            let panels = model.panels.iter().map(ToString::to_string).collect();
            ours.insert(names::PRODUCT_PANELS.to_owned(), Value::StringVec(panels));
        }
        Value::Dictionary(HashMap::from([(names::PRODUCT_SPACE.to_owned(), Value::Dictionary(ours))]))
    }
}

/// The bounding box of some points.
pub fn extent(points: &[Vec3]) -> Vec<Vec3f> {
    let Some(&first) = points.first() else { return vec![Vec3f::default(); 2] };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    vec![low.to_array().into(), high.to_array().into()]
}
