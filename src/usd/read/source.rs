//! An opened garment.

use super::choose::choose_mesh;
use super::diagnostics::in_words;
use super::facts::{Facts, gather};
use super::mesh::read_mesh;
use super::model::Model;
use super::origin::StageOrigin;
use super::primvars::Declarations;
use super::recipe::read_recipe;
use super::variants::Selection;
use crate::error::{Code, Error, ErrorCode, ErrorKind, Warning, Warnings};
use crate::garment::{GarmentInput, PrimvarInput, PrimvarRole};
use crate::usd::{BuildRecord, on_large_stack};
use openusd::usd::TimeCode;
use serde_json::{Map, Value as Json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The mesh and the time that are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Path of the mesh; by default the only one of the stage.
    pub prim: Option<String>,
    /// Time at which values are read; by default values without a time are. \[time codes\]
    pub time: Option<f64>,
    /// Variants to select in place of the stage's own selections.
    pub variants: Vec<Selection>,
}

/// A mesh of a stage, with all that is needed to work on it and to write products. It holds no stage, so that threads can
/// share it.
#[derive(Clone, Debug)]
pub struct Source {
    pub(in crate::usd) model: Model,
    garment: Result<GarmentInput, Error>,
    recipe: Result<Map<String, Json>, Error>,
    facts: Facts,
    warnings: Vec<Warning>,
    records: Vec<(PathBuf, BuildRecord)>,
}

impl Source {
    /// Opens `path` (`.usd`, `.usda`, `.usdc` or `.usdz`), composes it and reads the mesh that `options` choose.
    ///
    /// # Errors
    /// A file that is missing or is not USD, and a stage without exactly one mesh when none is named. Faults of the
    /// mesh's own attributes are reported where they matter: by [`Source::garment`] and [`Source::recipe`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, Error> {
        Self::of(StageOrigin::new(path, None, &options.variants), options)
    }

    /// As [`Source::open`], from `content`: a layer in memory (crate or text) to which another program flattened `file`.
    /// Relative paths in it are not resolved.
    ///
    /// # Errors
    /// As [`Source::open`].
    pub fn from_layer(content: Arc<[u8]>, file: &Path, options: &ReadOptions) -> Result<Self, Error> {
        Self::of(StageOrigin::new(file, Some(content), &options.variants), options)
    }

    fn of(origin: StageOrigin, options: &ReadOptions) -> Result<Self, Error> {
        if options.time.is_some_and(|t| !t.is_finite()) {
            return Err(Error::new(ErrorKind::Usage, "", "the time is not a number")
                .code(ErrorCode::CommandLine)
                .remedy("give a time code, such as 1 or 24.5"));
        }
        on_large_stack(|| Self::take(origin, options))
    }

    fn take(origin: StageOrigin, options: &ReadOptions) -> Result<Self, Error> {
        let stage = origin.open()?;
        let prim = choose_mesh(&stage, &origin.file, options)?;
        let time = options.time.map(TimeCode::new);
        let mut warnings = Vec::new();
        let (garment, declarations) = match read_mesh(&prim, time, &mut warnings) {
            Ok((garment, declarations)) => (Ok(garment), declarations),
            Err(e) => (Err(e), Declarations::default()),
        };
        let is_normals = |p: &PrimvarInput| p.role == PrimvarRole::Normals;
        let has_normals = garment.as_ref().is_ok_and(|g: &GarmentInput| g.primvars.iter().any(is_normals));
        let model = Model::take(&prim, time, origin, declarations, has_normals, &mut warnings)?;
        let facts = gather(&prim, &model, time)?;
        let recipe = read_recipe(&stage, &model.origin.file, &prim, time, &mut warnings);
        let faults = stage.composition_errors();
        warnings.splice(
            0..0,
            faults.iter().map(|e| {
                let problem = format!("the stage does not compose fully: {}", in_words(e));
                Warning::new(Code::Composition, model.origin.file.display(), problem)
                    .remedy("Mend the reference, or remove it")
            }),
        );
        let records = BuildRecord::in_layers(&stage);
        Ok(Self { model, garment, recipe, facts, warnings, records })
    }

    /// The mesh as authored. Attributes that are dropped and arcs that fail to compose become warnings.
    ///
    /// # Errors
    /// An attribute that is needed and is missing, of the wrong type or unreadable.
    pub fn garment(&self, warnings: &mut Warnings) -> Result<GarmentInput, Error> {
        self.warnings.iter().for_each(|w| warnings.push(w.clone()));
        self.garment.clone()
    }

    /// The recipe in the model's own properties (namespace `tailor:`), as nested objects; relationships become arrays of
    /// subset names.
    ///
    /// # Errors
    /// A property of a type that no recipe field has, or whose target is not a subset of the mesh.
    pub fn recipe(&self) -> Result<Map<String, Json>, Error> {
        self.recipe.clone()
    }

    /// Facts about the model and its surroundings.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The layers in use that this program built, and what they were made of.
    pub fn records(&self) -> &[(PathBuf, BuildRecord)] {
        &self.records
    }

    /// The file that was opened, as named.
    pub fn file(&self) -> &Path {
        &self.model.origin.file
    }

    /// Path of the mesh.
    pub fn prim(&self) -> &str {
        self.model.path.as_str()
    }
}
