//! The garment that is shown, and what the page shows of it.

use super::document::{Options, changed};
use super::messages::{GarmentMessage, PrimvarInfo, SaveTargets, ServerMessage, SetInfo, UpAxis, VariantSet};
use crate::error::Error;
use crate::garment::{Garment, PrimvarRole};
use crate::pipeline::Builder;
use crate::recipe::{Layers, Recipe, table};
use crate::session::{Input, OpenGarment, is_usd};
use crate::usd::{Source, decimal};
use serde_json::Value;
use std::path::PathBuf;

/// A stage that was read.
pub struct Stage {
    /// The stage.
    pub source: Source,
    /// The mesh as authored.
    pub mesh: Garment,
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
        let OpenGarment { source, mesh, authored, given, warnings } = input.open_one()?;
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
        self.layers(edits).recipe_for(self.checks.garment())
    }

    /// The options of the stage with `edits`.
    pub fn layers(&self, edits: &Options) -> Layers {
        let mut layers = Layers::default();
        layers.add(self.upstream.clone());
        layers.add(edits.clone());
        layers
    }

    /// The edits without a list of operators that says what holds without it.
    pub fn tidied(&self, mut edits: Options) -> Options {
        let has_list = self.upstream.get("render").is_some_and(|render| render.get("operators").is_some());
        if !has_list && self.layers(&edits).lists_default_order() {
            if let Some(render) = edits.get_mut("render").and_then(Value::as_object_mut) {
                render.remove("operators");
            }
            edits.retain(|_, group| group.as_object().is_none_or(|fields| !fields.is_empty()));
        }
        edits
    }

    /// Files of the stage.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.source.facts().layers.iter().map(PathBuf::from)
    }
}

fn message(source: &Source, checks: &Builder, input: &Input) -> String {
    let (facts, garment) = (source.facts(), checks.garment());
    let primvars = garment.primvars.iter().filter(|primvar| primvar.role == PrimvarRole::Primvar);
    ServerMessage::Garment(GarmentMessage {
        version: env!("CARGO_PKG_VERSION"),
        file: source.file().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        prim: &facts.prim,
        up_axis: UpAxis::named(&facts.up_axis),
        meters_per_unit: facts.meters_per_unit,
        points: garment.points.len(),
        faces: garment.faces.len(),
        mean_edge: decimal(checks.mean_edge_length()),
        sets: garment.subsets.iter().map(SetInfo::from).collect(),
        primvars: primvars.map(PrimvarInfo::from).collect(),
        variants: facts.variants.iter().map(VariantSet::from).collect(),
        groups: table(),
        suggested: suggested(source, input),
        warnings: checks.warnings().iter().collect(),
    })
    .to_text()
}

fn suggested(source: &Source, input: &Input) -> SaveTargets {
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
    SaveTargets { layer: (!source.is_sewn()).then_some(layer), recipe }
}
