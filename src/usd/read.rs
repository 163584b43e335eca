//! An opened garment.

use super::choose::choose_mesh;
use super::facts::{Facts, gather};
use super::geometry::read_mesh;
use super::model::Model;
use super::names;
use super::origin::Origin;
use super::primvars::read_normals;
use super::recipe::read_recipe;
use super::shapes::read_shapes;
use super::{UsdError, on_large_stack};
use crate::error::{Warning, Warnings};
use crate::garment::{GarmentInput, PrimvarRole, Scheme};
use openusd::usd::TimeCode;
use serde_json::{Map, Value as Json};
use std::path::Path;
use std::sync::Arc;

/// What is read of a stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Path of the mesh; the only one of the stage when not given.
    pub prim: Option<String>,
    /// The time at which values are taken; their value that does not vary over time when not given. [time codes]
    pub time: Option<f64>,
}

/// A mesh of a stage, with all that is needed to work on it and to write beside it. Nothing refers to the stage any
/// more, so that a source can be shared between threads.
#[derive(Clone, Debug)]
pub struct Source {
    pub(super) model: Model,
    garment: Result<GarmentInput, UsdError>,
    recipe: Result<Map<String, Json>, UsdError>,
    facts: Facts,
    warnings: Vec<Warning>,
}

impl Source {
    /// Opens `path` (`.usd`, `.usda`, `.usdc` or `.usdz`), composes it and takes the mesh that `options` choose.
    ///
    /// # Errors
    /// A file that is missing or is not USD, and a stage without exactly one mesh when none is named. Faults of the
    /// mesh's own attributes are reported where they matter: by [`Source::garment`] and [`Source::recipe`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, UsdError> {
        Self::of(Origin { file: path.to_path_buf(), content: None }, options)
    }

    /// As [`Source::open`], from a layer in memory (crate or text) that is all of the stage: `content`, composed from
    /// `file` by another program. Paths that are relative in it lead nowhere.
    ///
    /// # Errors
    /// As [`Source::open`].
    pub fn from_layer(content: Arc<[u8]>, file: &Path, options: &ReadOptions) -> Result<Self, UsdError> {
        Self::of(Origin { file: file.to_path_buf(), content: Some(content) }, options)
    }

    fn of(origin: Origin, options: &ReadOptions) -> Result<Self, UsdError> {
        if options.time.is_some_and(|t| !t.is_finite()) {
            return Err(UsdError::new("the time is not a number").hint("give a time code, such as 1 or 24.5"));
        }
        on_large_stack(|| Self::take(origin, options))
    }

    fn take(origin: Origin, options: &ReadOptions) -> Result<Self, UsdError> {
        let stage = origin.open()?;
        let prim = choose_mesh(&stage, &origin.file, options)?;
        let time = options.time.map(TimeCode::new);
        let mut warnings = Vec::new();
        let garment = read_mesh(&prim, time, &mut warnings);
        let mut model = Model::take(&prim, origin, time, &mut warnings)?;
        let mut offsets = Vec::new();
        // Without points there is nothing to move, and the mesh says so itself.
        if garment.is_ok() {
            (model.shapes, offsets) = read_shapes(&prim, time, &mut warnings)?;
        }
        let garment = garment.map(|mut g| {
            g.primvars.extend(offsets);
            // A subdivision surface has normals of its own, whatever is authored.
            if g.rules.scheme == Scheme::None {
                let elements = [g.face_vertex_counts.len(), g.points.len(), g.face_vertex_indices.len()];
                g.primvars.extend(read_normals(&prim, time, elements));
            }
            let is_carried = g.primvars.iter().any(|p| p.role == PrimvarRole::Normals);
            let of_normals = format!("{}.{}", prim.path(), names::NORMALS);
            warnings.retain(|w| !is_carried || !matches!(w, Warning::NotCarried { what, .. } if *what == of_normals));
            g
        });
        let facts = gather(&prim, &model, time)?;
        let recipe = read_recipe(&prim, time);
        let faults = stage.composition_errors();
        warnings.splice(0..0, faults.iter().map(|e| Warning::Composition { fault: e.to_string() }));
        Ok(Self { model, garment, recipe, facts, warnings })
    }

    /// The mesh as authored. What was met while reading and is not carried, or failed to compose, becomes a warning.
    ///
    /// # Errors
    /// An attribute that is needed and is missing, of the wrong type or unreadable.
    pub fn garment(&self, warnings: &mut Warnings) -> Result<GarmentInput, UsdError> {
        self.warnings.iter().for_each(|w| warnings.push(w.clone()));
        self.garment.clone()
    }

    /// The recipe that the model's own properties hold (namespace `tailor:`), as nested objects; relationships become
    /// arrays of subset names.
    ///
    /// # Errors
    /// A property that is not of a recipe's type, or that targets something else than a subset of the mesh.
    pub fn recipe(&self) -> Result<Map<String, Json>, UsdError> {
        self.recipe.clone()
    }

    /// What there is to know about the model and its surroundings.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The file that was opened, as it was named.
    pub fn file(&self) -> &Path {
        &self.model.origin.file
    }

    /// Path of the mesh.
    pub fn prim(&self) -> &str {
        self.model.path.as_str()
    }
}
