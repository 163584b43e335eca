//! Levels of detail in a stage. Simulation meshes are beside each other, and the first one alone is cloth.
//!
//! ```text
//! /Coat                  variant set LOD                  /Coat
//!   /sim                                                    /sim
//!   /sim_LOD1                                               /sim_LOD1
//!   {LOD=LOD0} /LOD0     render mesh                        /render        LODRootAPI
//!              /physics                                       /LOD0        render mesh
//!   {LOD=LOD1} /LOD1     render mesh                          /LOD1        render mesh, invisible
//!                                                           /physics
//!                                                           /lod           LODScreenSizeHeuristic
//! ```
//!
//! A level has a name of its own, so that the points of a shot are never those of another level's faces.

use super::layer::name_fault;
use super::product::{Author, extent, fault};
use super::role::{GarmentProducts, Product, ProductRole, level_count, sims};
use super::scope::beside;
use super::variant::copy_into_variant;
use crate::names;
use crate::read::{LodSchema, Model, OrUnreadable, Selection, Sibling, level_name, select};
use glam::Vec3;
use openusd::sdf::{self, AbstractData as _, Path, PrimSpec, SpecType, Specifier, Value, ValueTypeName, Variability};
use openusd::tf::Token;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::Mesh;

/// Name of the prim that says which level is drawn.
pub const HEURISTIC: &str = "lod";
/// Share of the screen that a garment covers at most where the second level is drawn.
const SECOND_LEVEL: f32 = 0.25;

/// A variant of a level, and what is in it.
pub type LevelPart = (Selection, sdf::Data);

/// The variants that some products become a part of; none without levels.
pub fn level_variants(model: &Model, products: &[Product], schema: LodSchema) -> Vec<Selection> {
    let count = level_count(products);
    let selection = |level| Selection {
        prim: model.parent.as_str().to_owned(),
        set: names::LOD.to_owned(),
        choice: level_name(level),
    };
    if count > 1 && schema == LodSchema::Variants { (0..count).map(selection).collect() } else { Vec::new() }
}

/// Copies the content of variants of levels into a layer, within a variant of the garment if it is in one.
///
/// # Errors
/// Names that a variant cannot have.
pub fn copy_levels(data: &mut sdf::Data, variant: Option<&Selection>, levels: &[LevelPart]) -> Result<(), Error> {
    for (level, part) in levels {
        let selections: Vec<&Selection> = variant.into_iter().chain([level]).collect();
        copy_into_variant(data, part, &selections).map_err(fault)?;
    }
    Ok(())
}

/// Refuses levels where there is no prim for their variants, or the input has variants of this name.
///
/// # Errors
/// Such a model.
pub fn check_levels(garment: &GarmentProducts, all: &[GarmentProducts], schema: LodSchema) -> Result<(), Error> {
    let (model, products) = (&garment.source.model, garment.products);
    let count = level_count(products);
    let refused = |text: String, remedy: &str| Err(name_fault(text, remedy));
    let is_level = |(name, sibling): (&String, &Sibling)| sibling.product && name.ends_with(&level_name(1));
    if model.siblings.iter().any(is_level) {
        let text = format!("{} has levels of detail of an earlier build, which would stay", model.path);
        return refused(text, "name the garment that they were made from as the input");
    }
    let is_beside = |other: &&GarmentProducts| {
        other.source.model.parent == model.parent && other.variant == garment.variant && schema == LodSchema::Variants
    };
    let mut siblings = all.iter().filter(is_beside);
    if let Some(other) = siblings.find(|other| level_count(other.products) != count) {
        let (path, others) = (&other.source.model.path, level_count(other.products));
        let text =
            format!("{} has {count} levels of detail and {path} has {others}, with one variant for both", model.path);
        return refused(text, "give both the same lod.levels");
    }
    if count == 1 {
        return Ok(());
    }
    if schema == LodSchema::UsdLod {
        let sim = sims(products).next().map_or(ProductRole::Sim.name(), |sim| sim.name);
        let name = beside(HEURISTIC, sim);
        let is_taken = model.siblings.contains_key(&name) || model.has_panel(&name);
        let path = model.sibling_path(&name).or_unreadable(&model.path)?;
        return if is_taken {
            refused(format!("{path} is taken by another prim"), "rename that prim: the heuristic of levels is there")
        } else {
            Ok(())
        };
    }
    let parent = &model.parent;
    if *parent == Path::abs_root() {
        let text = format!("{} is a root prim, and levels of detail are variants of the prim above", model.path);
        return refused(text, "put the model below an Xform");
    }
    let sets = &garment.source.facts().variants;
    if sets.iter().any(|set| set.selected.set == names::LOD && set.selected.prim == parent.as_str()) {
        let text = format!("{parent} has variants of the set {} already", names::LOD);
        return refused(text, "name the garment without levels as the input, or write them with --lod-schema usdLod");
    }
    Ok(())
}

/// The render meshes of a level.
fn renders<'a>(products: &'a [Product<'a>], level: u32) -> impl Iterator<Item = &'a Product<'a>> {
    products.iter().filter(move |product| product.role == ProductRole::Render && product.level == level)
}

impl Author<'_> {
    /// Authors products of several levels, and returns what belongs in the variants of each.
    ///
    /// # Errors
    /// As [`Author::product`] and [`Author::physics`].
    pub fn levels(&mut self, products: &[Product], schema: LodSchema) -> Result<(Vec<LevelPart>, Warnings), Error> {
        let (mut variants, mut warnings) = (Vec::new(), Warnings::default());
        for sim in sims(products) {
            warnings.extend(self.product(sim).map_err(fault)?);
            self.model_binding(sim).map_err(fault)?;
        }
        match schema {
            LodSchema::Variants => variants = warnings.absorb(self.level_variants(products)?),
            LodSchema::UsdLod => {
                self.lod_root(products).map_err(fault)?;
                for level in 0..level_count(products) {
                    warnings.extend(self.level(products, level)?);
                    self.hide(products, level).map_err(fault)?;
                }
            }
        }
        Ok((variants, warnings))
    }

    /// The render meshes of each level for its variant, with the cloth for that of the first level, which is selected.
    fn level_variants(&mut self, products: &[Product]) -> Result<(Vec<LevelPart>, Warnings), Error> {
        let (mut variants, mut warnings) = (Vec::new(), Warnings::default());
        let all = level_variants(self.model, products, LodSchema::Variants);
        select(self.data, &all[..1]).map_err(fault)?;
        for (level, selection) in (0..).zip(all) {
            let mut part = sdf::Data::new();
            part.create_spec(Path::abs_root(), SpecType::PseudoRoot);
            let mut author = Author { data: &mut part, ..*self };
            warnings.extend(author.level(products, level)?);
            variants.push((selection, part));
        }
        Ok((variants, warnings))
    }

    /// Authors the render meshes of a level. The first one has the cloth.
    fn level(&mut self, products: &[Product], level: u32) -> Result<Warnings, Error> {
        let mut warnings = Warnings::default();
        for render in renders(products, level) {
            warnings.extend(self.product(render).map_err(fault)?);
            self.render_bindings(render, products).map_err(fault)?;
        }
        if level == 0 {
            let first: Vec<Product> = products.iter().filter(|product| product.level == 0).copied().collect();
            warnings.extend(self.physics(&first)?);
            self.stitches(&first).map_err(fault)?;
        }
        Ok(warnings)
    }

    /// The root of the levels, with the prim that says which one is drawn.
    fn lod_root(&mut self, products: &[Product]) -> openusd::Result<()> {
        let (Some(sim), Some(render)) = (sims(products).next(), renders(products, 0).next()) else { return Ok(()) };
        let root = self.model.sibling_path(render.sibling())?;
        let heuristic = self.model.sibling_path(&beside(HEURISTIC, sim.name))?;
        for (path, kind) in [(&root, "Xform"), (&heuristic, "LODScreenSizeHeuristic")] {
            PrimSpec::new(self.data, path, Specifier::Def, kind)?;
            let mark = self.mark(HEURISTIC);
            self.data.set_field(path, names::CUSTOM_DATA, mark);
        }
        self.schemas(&root, &[Token::from("LODRootAPI")], false);
        self.target(&root, "lod:heuristics", &heuristic)?;
        let index = Value::Int(0);
        self.attribute(&root, "lod:default:index", ValueTypeName::INT, Variability::Varying, index)?;
        self.token(&heuristic, "lod:domain", "imaging")?;
        let bounds = Value::Vec3fVec(self.bounds(renders(products, 0).map(|render| render.mesh)));
        self.attribute(&heuristic, names::EXTENT, ValueTypeName::FLOAT3_ARRAY, Variability::Varying, bounds)?;
        // The share of the screen is one of area.
        let thresholds = sims(products).map(|sim| SECOND_LEVEL / (sim.scale * sim.scale));
        let mut thresholds: Vec<f32> = thresholds.collect();
        thresholds.pop();
        let (name, value) = ("thresholds", Value::FloatVec(thresholds));
        self.attribute(&heuristic, name, ValueTypeName::FLOAT_ARRAY, Variability::Uniform, value)?;
        for level in 0..level_count(products) {
            let panels = renders(products, level).any(|render| render.panel.is_some());
            if panels {
                let path = root.append_path(level_name(level).as_str())?;
                PrimSpec::new(self.data, &path, Specifier::Def, "Xform")?;
            }
        }
        Ok(())
    }

    /// Readers that do not know levels draw all children, so all but the first level are invisible.
    fn hide(&mut self, products: &[Product], level: u32) -> openusd::Result<()> {
        if level == 0 {
            return Ok(());
        }
        for render in renders(products, level) {
            let path = self.model.sibling_path(render.name)?;
            let invisible = Value::Token(Token::from("invisible"));
            self.attribute(&path, names::VISIBILITY, ValueTypeName::TOKEN, Variability::Varying, invisible)?;
        }
        Ok(())
    }

    /// The bounding box of meshes in the space of the prim above them.
    fn bounds<'a>(&self, meshes: impl Iterator<Item = &'a Mesh>) -> Vec<openusd::gf::Vec3f> {
        let to_parent = self.model.transforms.to_parent;
        let points = meshes.flat_map(|mesh| mesh.points.as_slice());
        let points: Vec<Vec3> = points.map(|p| to_parent.transform_point3(p.as_dvec3()).as_vec3()).collect();
        extent(&points)
    }
}
