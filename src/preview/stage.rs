//! The garment that is shown, and what the page is told of it.

use super::document::{Options, changed};
use crate::build::Builder;
use crate::error::Error;
use crate::garment::{GarmentInput, PrimvarRole, Values};
use crate::recipe::{Layers, Recipe, table};
use crate::session::{Input, Opened, is_usd};
use crate::usd::{Source, decimal, type_word};
use serde_json::json;
use std::path::{Path, PathBuf};

/// A stage that was read.
pub struct Stage {
    /// The stage.
    pub source: Source,
    /// The mesh as authored.
    pub mesh: GarmentInput,
    /// A builder that checks recipes and makes nothing.
    pub checks: Builder,
    /// The options that the stage holds.
    pub upstream: Options,
    /// The options of the recipe files, where they differ.
    pub given: Options,
    /// The message that describes the garment.
    pub message: String,
}

impl Stage {
    /// Reads the stage and checks its mesh.
    ///
    /// # Errors
    /// A file that cannot be read, faults of the mesh.
    pub fn open(input: &Input) -> Result<Self, Error> {
        let Opened { source, mesh, authored, given, warnings } = input.open_one()?;
        let checks = Builder::new(mesh.clone())?.with_warnings(warnings);
        let upstream = authored.into_map();
        let given = changed(&given.into_map(), &upstream);
        let message = message(&source, &checks, input);
        Ok(Self { source, mesh, checks, upstream, given, message })
    }

    /// The recipe of the stage with `edits`, with the lengths that replace 0.
    ///
    /// # Errors
    /// Faults of the recipe.
    pub fn recipe(&self, edits: &Options) -> Result<Recipe, Error> {
        let mut layers = Layers::default();
        layers.add(self.upstream.clone());
        layers.add(edits.clone());
        layers.recipe_for(self.checks.garment())
    }

    /// Files of the stage.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.source.facts().layers.iter().map(PathBuf::from)
    }
}

fn message(source: &Source, checks: &Builder, input: &Input) -> String {
    let (facts, garment) = (source.facts(), checks.garment());
    let mean_edge = checks.mean_edge_length();
    let sets = garment.subsets.iter().map(
        |set| json!({"name": set.name, "kind": set.elements.kind(), "family": set.family, "count": set.elements.len()}),
    );
    let primvars = garment.primvars.iter().filter(|p| p.role == PrimvarRole::Primvar).map(|p| {
        json!({
            "name": p.name, "type": type_word(p), "interpolation": p.interpolation, "width": p.width(),
            "isFloat": matches!(p.values, Values::F32(_)),
        })
    });
    let variants = facts.variants.iter().map(|v| {
        let selected = &v.selected;
        json!({"prim": selected.prim, "set": selected.set, "choices": v.choices, "selected": selected.choice})
    });
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (layer, recipe) = suggested(source, input);
    json!({
        "type": "garment",
        "version": env!("CARGO_PKG_VERSION"),
        "file": name(source.file()),
        "prim": facts.prim,
        "upAxis": facts.up_axis,
        "metersPerUnit": facts.meters_per_unit,
        "points": garment.points.len(),
        "faces": garment.faces.len(),
        "meanEdge": decimal(mean_edge),
        "sets": sets.collect::<Vec<_>>(),
        "primvars": primvars.collect::<Vec<_>>(),
        "variants": variants.collect::<Vec<_>>(),
        "groups": table(),
        "suggested": {"layer": layer, "recipe": recipe},
        "warnings": checks.warnings().iter().collect::<Vec<_>>(),
    })
    .to_string()
}

/// Files to save to: those of the input where it has one, else new ones beside the garment. Panels that are sewn together have no
/// layer.
fn suggested(source: &Source, input: &Input) -> (Option<String>, String) {
    let garment = source.file();
    let stem = garment.file_stem().unwrap_or_default().to_string_lossy();
    let beside = |name: String| garment.with_file_name(name).display().to_string();
    let (mut layer, mut recipe) = (beside(format!("{stem}_look.usda")), beside(format!("{stem}.tailor")));
    match &input.recipe {
        Some(path) if is_usd(path) => layer = path.display().to_string(),
        Some(path) => recipe = path.display().to_string(),
        None if !is_usd(&input.file) => recipe = input.file.display().to_string(),
        None => {}
    }
    ((!source.is_sewn()).then_some(layer), recipe)
}
