//! One product as prims and properties of a layer.

use super::layer::SetChoice;
use super::role::{Product, ProductRole};
use crate::binding::Binding;
use crate::error::{Warning, Warnings};
use crate::garment::{CONSTRAINTS, DERIVED};
use crate::garment::{Family, Interpolation, Meaning, Mesh, Primvar, PrimvarRole, Subset, Values, free_name};
use crate::mesh::VertexId;
use crate::usd::assets::Anchor;
use crate::usd::names::{self, UsdToken};
use crate::usd::read::{Model, Sibling, SubsetRecord};
use crate::usd::record::{Content, Record};
use crate::usd::values::array;
use glam::Vec3;
use openusd::gf::Vec3f;
use openusd::sdf::{self, AbstractData, FieldKey, Path, PrimSpec, Specifier, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use std::collections::HashMap;

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
        self.data.set_field(&path, FieldKey::Documentation.as_str(), Value::String(doc(product, &model.panels)));
        self.data.set_field(&path, names::CUSTOM_DATA, self.mark(product.role.name()));
        let before = model.siblings.get(product.name).filter(|_| self.is_overlay);
        self.schemas(&path, &model.applied, before.is_some());
        for record in &model.carried {
            record.author(self.data, &path, self.anchor)?;
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
        self.shapes(&path, product.mesh)?;
        if let Some(before) = before {
            self.block_earlier(&path, before)?;
        }
        Ok(warnings)
    }

    /// Authors where the points of the render mesh and of the model are bound.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn bindings(&mut self, products: &[Product]) -> openusd::Result<()> {
        let Some(sim) = products.iter().find(|product| product.role == ProductRole::Sim) else { return Ok(()) };
        let target = self.model.sibling_path(sim.name)?;
        for (product, binding) in products.iter().filter_map(|product| Some((product, product.binding?))) {
            self.binding(&self.model.sibling_path(product.name)?, binding, &target)?;
        }
        let Some(binding) = sim.cage_binding else { return Ok(()) };
        let model = self.model;
        let [.., source] = names::MODEL_BINDING;
        if model.is_sewn() {
            // Their points are those of the cage to which they are sewn, panel by panel.
            let points = model.sewing.points.iter().flatten();
            let points: Vec<VertexId> = points.map(|&point| VertexId::new(point)).collect();
            self.places(&target, names::MODEL_BINDING, &binding.of_points(&points))?;
        } else {
            self.places(&target, names::MODEL_BINDING, binding)?;
        }
        self.targets(&target, source, &model.panels)
    }

    fn binding(&mut self, prim: &Path, binding: &Binding, target: &Path) -> openusd::Result<()> {
        self.places(prim, names::BINDING, binding)?;
        for name in &names::BINDING[..2] {
            let vertex = Value::Token(Token::from(Interpolation::Vertex.token()));
            self.data.set_field(&prim.append_property(*name)?, names::INTERPOLATION, vertex);
        }
        self.target(prim, names::BINDING[2], target)
    }

    /// Faces and coordinates of a binding, by the first two names.
    fn places(&mut self, prim: &Path, names: [&str; 3], binding: &Binding) -> openusd::Result<()> {
        self.ints(prim, names[0], binding.faces.iter().map(|face| *face as i32).collect())?;
        let coords: &[Vec3f] = bytemuck::cast_slice(&binding.coords);
        let (type_name, value) = (ValueTypeName::FLOAT3_ARRAY, Value::Vec3fVec(coords.to_vec()));
        self.attribute(prim, names[1], type_name, Variability::Varying, value)
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

    /// Applied schemas; an explicit list where it replaces the one of an earlier product.
    fn schemas(&mut self, prim: &Path, schemas: &[Token], replace: bool) {
        let list = match replace {
            true => sdf::TokenListOp::explicit(schemas.iter().cloned()),
            false if schemas.is_empty() => return,
            false => sdf::TokenListOp { prepended_items: schemas.to_vec(), ..Default::default() },
        };
        AbstractData::set_field(self.data, prim, FieldKey::ApiSchemas.as_str(), list.into());
    }

    fn mesh(&mut self, prim: &Path, role: ProductRole, mesh: &Mesh) -> openusd::Result<()> {
        let points: &[Vec3f] = bytemuck::cast_slice(mesh.points.as_slice());
        let points = Value::Vec3fVec(points.to_vec());
        let extent = Value::Vec3fVec(extent(mesh.points.as_slice()));
        self.attribute(prim, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, extent)?;
        self.attribute(prim, names::POINTS, ValueTypeName::POINT3F_ARRAY, Variability::Varying, points)?;
        let faces = &mesh.faces;
        let counts = faces.ids().map(|f| faces.valence(f) as i32).collect();
        self.ints(prim, names::FACE_VERTEX_COUNTS, counts)?;
        let corners = faces.corners().as_slice().iter().map(|v| v.index() as i32).collect();
        self.ints(prim, names::FACE_VERTEX_INDICES, corners)?;
        self.token(prim, names::ORIENTATION, mesh.orientation.token())?;
        self.token(prim, names::PURPOSE, role.purpose())?;
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

    /// Authors the chosen subsets of a mesh and their families.
    pub(super) fn subsets(&mut self, prim: &Path, mesh: &Mesh) -> openusd::Result<()> {
        let chosen: Vec<&Subset> = mesh.subsets.iter().filter(|set| self.is_chosen(set)).collect();
        let is_left_out = |family: &&Family| {
            let is_member = |set: &&Subset| set.family == family.name;
            mesh.subsets.iter().any(|set| is_member(&set)) && !chosen.iter().any(is_member)
        };
        for family in mesh.families.iter().filter(|family| !is_left_out(family)) {
            let name = format!("{}{}{}", names::SUBSET_FAMILY, family.name, names::FAMILY_TYPE_SUFFIX);
            self.token(prim, &name, family.kind.token())?;
        }
        for subset in chosen {
            let path = prim.append_path(prim_name(subset, mesh).as_str())?;
            PrimSpec::new(self.data, &path, Specifier::Def, names::GEOM_SUBSET)?;
            let none = SubsetRecord::default();
            let record = self.model.subsets.get(&subset.name).unwrap_or(&none);
            for (key, value) in &record.metadata {
                self.data.set_field(&path, key, self.anchor.restated(value.clone()));
            }
            self.schemas(&path, &record.applied, false);
            self.token(&path, names::ELEMENT_TYPE, subset.elements.kind())?;
            if !subset.family.is_empty() {
                self.token(&path, names::FAMILY_NAME, &subset.family)?;
            }
            self.ints(&path, names::INDICES, subset.elements.indices())?;
            for record in &record.carried {
                record.author(self.data, &path, self.anchor)?;
            }
            if let Some(sharpness) = subset.sharpness {
                let (type_name, uniform) = (ValueTypeName::FLOAT, Variability::Uniform);
                self.attribute(&path, names::SHARPNESS, type_name, uniform, Value::Float(sharpness))?;
            }
        }
        Ok(())
    }

    /// Whether a product has a subset.
    fn is_chosen(&self, set: &Subset) -> bool {
        let is_own = [CONSTRAINTS, DERIVED].contains(&set.family.as_str());
        match (self.sets, self.model.subsets.get(&set.name)) {
            (SetChoice::All, _) => true,
            (SetChoice::Authored, record) => !is_own || record.is_some(),
            (SetChoice::None, record) => {
                record.is_some_and(|record| record.carried.iter().any(|r| r.name.starts_with(names::MATERIAL_BINDING)))
            }
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

/// The name of a subset as a prim; that of a derived set is made of its expression.
fn prim_name(set: &Subset, mesh: &Mesh) -> String {
    if Path::is_valid_identifier(&set.name) {
        return set.name.clone();
    }
    let base = words_of(&set.name).join("_");
    let base = if Path::is_valid_identifier(&base) { base } else { format!("set_{base}") };
    // Texts that differ in signs alone have different names by their place.
    let at = mesh.subsets.iter().position(|other| other.name == set.name).unwrap_or_default();
    let is_taken = |name: &str| mesh.subsets.iter().any(|other| other.name == name);
    let is_shared = mesh.subsets.iter().filter(|other| words_of(&other.name) == words_of(&set.name)).count() > 1;
    free_name(&if is_shared { format!("{base}_{at}") } else { base }, is_taken)
}

fn words_of(text: &str) -> Vec<&str> {
    text.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty()).collect()
}

/// The warning of a primvar that no file can hold.
fn misfit(prim: &Path, name: &str) -> Warning {
    Warning::not_carried(format!("{prim}.{name}"), "USD has no type for its values")
}

fn doc(product: &Product, panels: &[Path]) -> String {
    let panels = product.panel.and_then(|panel| panels.get(panel..=panel)).unwrap_or(panels);
    let what = match product.role {
        ProductRole::Sim => "Simulation mesh",
        ProductRole::Render => "Render mesh",
    };
    let panels: Vec<String> = panels.iter().map(|panel| format!("<{panel}>")).collect();
    format!("{what} made by usd-tailor from {}.", panels.join(", "))
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
