//! The names of products.

use crate::names::{LOD, RENDER};
use crate::read::Source;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use tailor_mesh::garment::free_name;

/// How levels of detail are in a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum LodSchema {
    /// Variants of the set `LOD` of the prim above, each with one render mesh.
    #[default]
    Variants,
    /// Children of a prim with `LODRootAPI` (OpenUSD 26.11).
    UsdLod,
}

/// The names of the prims of one garment's products.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProductNames {
    /// The simulation mesh.
    pub sim: String,
    /// The render mesh, or those of the panels in their order.
    pub render: Vec<String>,
    /// The names at the coarser levels of detail.
    pub levels: Vec<Self>,
}

impl ProductNames {
    /// Of a garment with one render mesh.
    pub fn new(sim: impl Into<String>, render: impl Into<String>) -> Self {
        Self { sim: sim.into(), render: vec![render.into()], levels: Vec::new() }
    }

    /// With names for several levels of detail; the names themselves for one. Render meshes are called `LOD0`, `LOD1` and so on,
    /// as Unreal expects it, after a name of their own where they have one.
    #[must_use]
    pub fn with_levels(self, levels: u32, schema: LodSchema) -> Self {
        if levels <= 1 {
            return self;
        }
        let of_level = |level: u32| {
            let sim = if level == 0 { self.sim.clone() } else { format!("{}_{}", self.sim, level_name(level)) };
            let render = |name: &String| match schema {
                LodSchema::UsdLod => format!("{name}/{}", level_name(level)),
                LodSchema::Variants if name == RENDER => level_name(level),
                LodSchema::Variants => format!("{name}_{}", level_name(level)),
            };
            Self { sim, render: self.render.iter().map(render).collect(), levels: Vec::new() }
        };
        Self { levels: (1..levels).map(of_level).collect(), ..of_level(0) }
    }

    /// With a render mesh for each panel of a garment: `render_front` for the face set `front`.
    #[must_use]
    pub fn per_panel(self, source: &Source) -> Self {
        let sets = &source.model.sewing.sets;
        if sets.is_empty() {
            return self;
        }
        let [whole] = &self.render[..] else { return self };
        // The panels of a level are below it where levels have prims of their own.
        let between = if whole.contains('/') { '/' } else { '_' };
        let render = sets.iter().map(|set| format!("{whole}{between}{set}")).collect();
        Self { render, levels: self.levels.into_iter().map(|level| level.per_panel(source)).collect(), ..self }
    }

    /// All of them, the simulation mesh first, level by level.
    pub fn all(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self).chain(&self.levels).flat_map(Self::own).map(String::as_str)
    }

    fn own(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.sim).chain(&self.render)
    }
}

/// The name of a level of detail.
pub fn level_name(level: u32) -> String {
    format!("{LOD}{level}")
}

/// The names of the products of each garment: those given for the two meshes, or, where several garments are beside each other,
/// names with that of the garment before them.
pub fn product_names<'a>(sources: impl IntoIterator<Item = &'a Source>, given: [&str; 2]) -> Vec<ProductNames> {
    let sources: Vec<&Source> = sources.into_iter().collect();
    let mut taken = HashSet::new();
    let names = sources.iter().map(|source| {
        let [sim, render] = two_names(source, &sources, given, &mut taken);
        ProductNames::new(sim, render)
    });
    names.collect()
}

fn two_names<'a>(
    source: &'a Source,
    sources: &[&'a Source],
    given: [&str; 2],
    taken: &mut HashSet<(&'a openusd::sdf::Path, String)>,
) -> [String; 2] {
    let parent = &source.model.parent;
    if sources.iter().filter(|other| other.model.parent == *parent).count() == 1 {
        return given.map(str::to_owned);
    }
    let name = source.model.name().replace('/', "_");
    let name = free_name(&name, |name| taken.contains(&(parent, name.to_owned())));
    taken.insert((parent, name.clone()));
    given.map(|product| format!("{name}_{product}"))
}
