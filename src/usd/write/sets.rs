//! Sets of elements as subsets: of products, and of the model in a layer over the stage.

use super::layer::{LayerContext, check_name, name_fault, overlay};
use super::product::{Author, fault};
use super::role::SetChoice;
use super::save::OutputFile;
use crate::codes;
use crate::names::{self, UsdToken, is_drawn_material, is_material};
use crate::on_large_stack;
use crate::read::{Sewing, Source, SubsetRecord};
use crate::record::Record;
use openusd::sdf::{self, AbstractData, Specifier, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;
use tailor_mesh::connectivity::{Elements, FaceId, IdVec, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{CONSTRAINTS, DERIVED, Family, FamilyType, Mesh, Subset, free_name};

impl Author<'_> {
    /// Authors the chosen subsets of a mesh and their families.
    pub(super) fn subsets(&mut self, prim: &sdf::Path, mesh: &Mesh) -> openusd::Result<()> {
        let mut chosen: Vec<&Subset> = mesh.subsets.iter().filter(|set| self.is_chosen(set)).collect();
        let has_sets = |family: &&Family| chosen.iter().any(|set| set.family == family.name);
        for family in mesh.families.iter().filter(has_sets) {
            self.family(prim, &family.name, family.kind)?;
        }
        // Where a program takes all subsets for materials, the last one wins.
        chosen.sort_by_key(|set| set.family == names::MATERIAL_FAMILY && self.is_bound(set));
        for subset in chosen {
            self.subset(prim, subset, mesh)?;
        }
        Ok(())
    }

    fn family(&mut self, prim: &sdf::Path, name: &str, kind: FamilyType) -> openusd::Result<()> {
        self.token(prim, &format!("{}{name}{}", names::SUBSET_FAMILY, names::FAMILY_TYPE_SUFFIX), kind.token())
    }

    fn subset(&mut self, prim: &sdf::Path, subset: &Subset, mesh: &Mesh) -> openusd::Result<()> {
        let path = prim.append_path(prim_name(subset, mesh).as_str())?;
        sdf::PrimSpec::new(self.data, &path, Specifier::Def, names::GEOM_SUBSET)?;
        let none = SubsetRecord::default();
        let record = self.model.subsets.get(&subset.name).unwrap_or(&none);
        for (key, value) in &record.metadata {
            self.data.set_field(&path, key, self.anchor.restated(value.clone()));
        }
        self.schemas(&path, &record.applied, false);
        self.token(&path, names::ELEMENT_TYPE, subset.elements.kind())?;
        if !subset.family.is_empty() && (subset.family != DERIVED || !subset.elements.is_empty()) {
            // The sets of a family are of one kind of elements, and have some.
            let of_kind = format!("{DERIVED}_{}", subset.elements.kind());
            self.token(&path, names::FAMILY_NAME, if subset.family == DERIVED { &of_kind } else { &subset.family })?;
        }
        self.ints(&path, names::INDICES, subset.elements.indices())?;
        for record in &record.carried {
            self.carry(record, &path)?;
        }
        if let Some(sharpness) = subset.sharpness {
            let (type_name, uniform) = (ValueTypeName::FLOAT, Variability::Uniform);
            self.attribute(&path, names::SHARPNESS, type_name, uniform, Value::Float(sharpness))?;
        }
        Ok(())
    }

    /// Whether a product has a subset.
    fn is_chosen(&self, set: &Subset) -> bool {
        let is_own = [CONSTRAINTS, DERIVED].contains(&set.family.as_str());
        match (self.sets, self.model.subsets.get(&set.name)) {
            (SetChoice::All, _) => true,
            (SetChoice::Authored, record) => !is_own || record.is_some(),
            (SetChoice::None, _) => self.is_bound(set),
        }
    }

    /// Whether a subset has a material of its own.
    fn is_bound(&self, set: &Subset) -> bool {
        self.model.subsets.get(&set.name).is_some_and(|set| set.carried.iter().any(|record| is_material(&record.name)))
    }

    /// The faces of a product that its own material is for, where face sets have others: those in none of these. None where the
    /// mesh keeps its material.
    ///
    /// Several programs take a mesh's material for that of each subset that has none, and lose the others.
    pub(super) fn rest(&self, mesh: &Mesh) -> Option<Vec<FaceId>> {
        // A material that is stronger than those of subsets, or is for one purpose, holds for their faces too.
        let [own] = drawn_materials(&self.model.carried)[..] else { return None };
        let is_stronger = own.metadata(names::BIND_MATERIAL_AS).is_some_and(names::is_stronger);
        if own.name != names::MATERIAL_BINDING || is_stronger {
            return None;
        }
        let (mut is_free, mut has_sets) = (IdVec::<FaceId, bool>::filled(true, mesh.faces.len()), false);
        for set in mesh.subsets.iter() {
            let materials = self.model.subsets.get(&set.name).map(|record| drawn_materials(&record.carried));
            let (Some([first, ..]), Elements::Faces(faces)) = (materials.as_deref(), &set.elements) else { continue };
            // Programs disagree on others: those of one purpose, or outside of the family. The one for all purposes is the first.
            if first.name != names::MATERIAL_BINDING || set.family != names::MATERIAL_FAMILY {
                return None;
            }
            has_sets = true;
            faces.iter().for_each(|&face| is_free[face] = false);
        }
        has_sets.then(|| mesh.faces.ids().filter(|&face| is_free[face]).collect())
    }

    /// Binds the material of the model to the rest of a product's faces, also where there are none, so that it is not lost.
    pub(super) fn bind_rest(&mut self, prim: &sdf::Path, mesh: &Mesh, faces: Vec<FaceId>) -> openusd::Result<()> {
        // The sets of the family, of which there are some, have brought its rule where the garment has one.
        if !mesh.families.iter().any(|family| family.name == names::MATERIAL_FAMILY) {
            self.family(prim, names::MATERIAL_FAMILY, FamilyType::NonOverlapping)?;
        }
        let name = free_name(REST, |name| mesh.subsets.iter().any(|set| set.name == name));
        let (family, elements) = (names::MATERIAL_FAMILY.to_owned(), Elements::Faces(faces));
        self.subset(prim, &Subset { name: name.clone(), family, elements, sharpness: None }, mesh)?;
        let path = prim.append_path(name.as_str())?;
        self.schemas(&path, &[Token::from(names::MATERIAL_BINDING_API)], false);
        let model = self.model;
        for record in model.carried.iter().filter(|record| is_drawn_material(&record.name)) {
            self.carry(record, &path)?;
        }
        Ok(())
    }
}

/// The face set of a product with the material of the garment's mesh.
const REST: &str = "tailorMaterial";

/// The bindings of materials that are drawn, by name.
fn drawn_materials(records: &[Record]) -> Vec<&Record> {
    let mut found: Vec<_> = records.iter().filter(|r| is_drawn_material(&r.name) && r.has_value()).collect();
    found.sort_by(|a, b| a.name.cmp(&b.name));
    found
}

/// The name of a subset as a prim; that of a derived set is made of its expression.
fn prim_name(set: &Subset, mesh: &Mesh) -> String {
    if sdf::Path::is_valid_identifier(&set.name) {
        return set.name.clone();
    }
    let base = words_of(&set.name).join("_");
    let base = if sdf::Path::is_valid_identifier(&base) { base } else { format!("set_{base}") };
    // Texts that differ in signs alone have different names by their place.
    let at = mesh.subsets.iter().position(|other| other.name == set.name).unwrap_or_default();
    let is_taken = |name: &str| mesh.subsets.iter().any(|other| other.name == name);
    let is_shared = mesh.subsets.iter().filter(|other| words_of(&other.name) == words_of(&set.name)).count() > 1;
    free_name(&if is_shared { format!("{base}_{at}") } else { base }, is_taken)
}

/// A set of a mesh that was sewn to itself, as elements of the mesh in the file: on a seam, those of both sides.
fn unsewn(set: Subset, sewing: &Sewing) -> Subset {
    let key = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
    let elements = match &set.elements {
        Elements::Points(all) if !sewing.points.is_empty() => {
            let is_in: HashSet<usize> = all.iter().map(|v| v.index()).collect();
            let own = sewing.points.iter().enumerate().filter(|(_, point)| is_in.contains(point));
            Elements::Points(own.map(|(own, _)| VertexId::new(own)).collect())
        }
        Elements::Edges(all) if !sewing.points.is_empty() => {
            let is_in: HashSet<[usize; 2]> = all.iter().map(|edge| key(edge.map(|v| v.index()))).collect();
            let own = sewing.edges.iter().filter(|edge| is_in.contains(&key(edge.map(|point| sewing.points[point]))));
            Elements::Edges(own.map(|edge| edge.map(VertexId::new)).collect())
        }
        _ => return set,
    };
    Subset { elements, ..set }
}

fn words_of(text: &str) -> Vec<&str> {
    text.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty()).collect()
}

/// Writes `sets` as subsets of the model of `source` into a layer over its file.
///
/// # Errors
/// Panels that are sewn together, a name that is taken or not valid, a file that may not or cannot be written.
pub fn write_sets(source: &Source, sets: Vec<Subset>, out: &Path, force: bool) -> Result<(), Error> {
    let model = &source.model;
    if model.is_sewn() {
        let text = format!("{} is sewn from several meshes, and a set belongs to one", source.whole());
        return Err(Error::usd(text).code(codes::SEVERAL_MESHES).remedy("name one of the meshes by --prim"));
    }
    for set in &sets {
        check_name("set", &set.name)?;
        if model.subsets.contains_key(&set.name) {
            return Err(name_fault(format!("{} has a subset {}", model.path, set.name), "choose another name"));
        }
    }
    let numbers = &source.garment.as_ref().map_err(Clone::clone)?.face_numbers;
    let in_file = |set: Subset| Subset { elements: numbers.in_file(set.elements), ..set };
    let sets = sets.into_iter().map(|set| in_file(unsewn(set, &model.sewing))).collect();
    let file = OutputFile::find(out, |file| model.uses(file), force)?;
    on_large_stack(|| {
        let anchor = file.anchor();
        let mut data = overlay(model, LayerContext { flatten: false, anchor, sublayer: None })?;
        let mesh = Mesh { subsets: Arc::new(sets), ..Mesh::default() };
        sdf::PrimSpec::over(&mut data, &model.path).map_err(|e| Error::usd(e.to_string()))?;
        let mut author = Author { data: &mut data, model, anchor, is_overlay: true, sets: SetChoice::All };
        author.subsets(&model.path, &mesh).map_err(fault)?;
        file.save(data).map(drop)
    })
}
