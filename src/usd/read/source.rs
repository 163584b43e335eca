//! An opened garment.

use super::choose::{all_prims, choose_mesh};
use super::diagnostics::{in_words, remedy};
use super::facts::{Facts, gather, material_paths, materials};
use super::mesh::read_mesh;
use super::model::{Model, Sewing};
use super::origin::StageOrigin;
use super::primvars::Declarations;
use super::query::prim_at;
use super::recipe::{add_constraint, read_recipe};
use super::surroundings::KnownSurroundings;
use super::trims::FittedTrim;
use super::variants::{Selection, choices_of, frozen};
use crate::codes;
use crate::on_large_stack;
use glam::Vec3;
use openusd::sdf;
use openusd::usd::{Prim, PrimPredicate, Stage, TimeCode};
use serde_json::{Map, Value as Json};
use std::path::Path;
use std::sync::Arc;
use tailor_mesh::error::{Error, ErrorKind, Warning, Warnings};
use tailor_mesh::garment::sew::{MAX_TOLERANCE, TOLERANCE, edges, sew_own_borders};
use tailor_mesh::garment::{Garment, PrimvarInput, PrimvarRole};

/// The mesh and the time that are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Path of the mesh; by default the only one of the stage.
    pub prim: Option<String>,
    /// Time at which values are read; by default values without a time are. \[time codes\]
    pub time: Option<f64>,
    /// Variants to select in place of the stage's own selections.
    pub variants: Vec<Selection>,
    /// Read all meshes of the stage, or all below `prim`, where [`Source::open_all`] may. It does so without this, too, for a
    /// `prim` with several meshes below it.
    pub all: bool,
    /// Prims that are left out then, with all below them: names or paths, in which `*` stands for any letters.
    pub exclude: Vec<String>,
    /// Prims that are trims, by path or by name beside a mesh: no mesh below them is a garment.
    pub trims: Vec<String>,
    /// Distance at which borders are sewn; 0.001 by default. \[share of the mean edge length\]
    pub sew_tolerance: Option<f64>,
    /// Leave apart the borders of one mesh that coincide. Bodies are read so, as shapes of one body may meet themselves in other places.
    pub unsewn: bool,
}

impl ReadOptions {
    /// The distance at which borders are sewn.
    ///
    /// # Errors
    /// A share that is not from 0 to [`MAX_TOLERANCE`].
    pub(super) fn tolerance(&self) -> Result<f64, Error> {
        let tolerance = self.sew_tolerance.unwrap_or(TOLERANCE);
        if (0.0..=MAX_TOLERANCE).contains(&tolerance) {
            return Ok(tolerance);
        }
        let text = format!("--sew-tolerance {tolerance} is not from 0 to {MAX_TOLERANCE}");
        let fault = Error::new(ErrorKind::Usage, "", text).code(tailor_mesh::codes::COMMAND_LINE);
        Err(fault.remedy("give a share of the mean edge length, such as 0.001"))
    }
}

/// A seam between two panels of a garment, or of one mesh to itself.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelSeam {
    /// Paths of the panels.
    pub panels: [String; 2],
    /// How many border edges match.
    pub edges: usize,
    /// The largest distance of two points that are sewn. \[stage units\]
    pub gap: f64,
}

/// A mesh of a stage, with all that is needed to work on it and to write products. It holds no stage, so that threads can
/// share it.
#[derive(Clone, Debug)]
pub struct Source {
    pub(crate) model: Model,
    pub(crate) garment: Result<Garment, Error>,
    pub(super) recipe: Result<Map<String, Json>, Error>,
    pub(super) facts: Facts,
    pub(super) warnings: Warnings,
    pub(super) seams: Vec<PanelSeam>,
    /// The points on another body, which are written over those of the garment.
    pub(crate) fitted: Option<Arc<FittedPoints>>,
}

/// The points of a garment on another body, and its trims there.
#[derive(Debug, Default)]
pub struct FittedPoints {
    /// In the order of [`Source::garment`].
    pub points: Vec<Vec3>,
    /// The time at which the garment was read. \[time codes\]
    pub time: Option<f64>,
    /// The trims that ride on it.
    pub trims: Vec<FittedTrim>,
    /// Paths of trims whose option `on` names another mesh, with the path of that mesh.
    pub elsewhere: Vec<(sdf::Path, String)>,
}

impl Source {
    /// Opens `path` (`.usd`, `.usda`, `.usdc` or `.usdz`), composes it and reads the mesh that `options` choose.
    ///
    /// # Errors
    /// A file that is missing or is not USD, and a stage without exactly one mesh when none is named. Faults of the
    /// mesh's own attributes are reported where they matter: by [`Source::garment`] and [`Source::recipe`].
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, Error> {
        Self::of(&StageOrigin::new(path, None, &options.variants), options)
    }

    /// As [`Source::open`], of any stage.
    pub(super) fn of(origin: &StageOrigin, options: &ReadOptions) -> Result<Self, Error> {
        if options.time.is_some_and(|t| !t.is_finite()) {
            return Err(Error::new(ErrorKind::Usage, "", "the time is not a number")
                .code(tailor_mesh::codes::COMMAND_LINE)
                .remedy("give a time code, such as 1 or 24.5"));
        }
        let of_stage = |stage: &Stage| Self::of_stage(stage, origin.clone(), options);
        on_large_stack(|| origin.with_stage(of_stage, |source| source.garment.as_ref().err()))
    }

    /// Reads the one mesh of a stage that `options` choose.
    pub(super) fn of_stage(stage: &Stage, origin: StageOrigin, options: &ReadOptions) -> Result<Self, Error> {
        let prim = choose_mesh(stage, &origin.file, options)?;
        Self::of_mesh(stage, &prim, origin, options, &mut KnownSurroundings::default())
    }

    /// Reads one mesh of a stage.
    pub(super) fn of_mesh(
        stage: &Stage,
        prim: &Prim,
        origin: StageOrigin,
        options: &ReadOptions,
        known: &mut KnownSurroundings,
    ) -> Result<Self, Error> {
        let (time, tolerance) = (options.time.map(TimeCode::new), options.tolerance()?);
        let mut of_mesh = Warnings::default();
        let (garment, declarations) = match read_mesh(prim, time).map(|read| of_mesh.absorb(read)) {
            Ok((garment, declarations)) => (Ok(garment), declarations),
            Err(e) => (Err(e), Declarations::default()),
        };
        let is_normals = |p: &PrimvarInput| p.role == PrimvarRole::Normals;
        let has_normals = garment.as_ref().is_ok_and(|g: &Garment| g.primvars.iter().any(is_normals));
        let model = of_mesh.absorb(Model::take(prim, time, origin, declarations, has_normals, known)?);
        let facts = gather(prim, &model, time)?;
        let bound = material_paths(&model, &facts);
        let garment = garment.map(|garment| Garment { materials: materials(&bound), ..garment });
        let recipe = read_recipe(prim, time);
        // Prims are composed when they are read.
        let mut warnings = composition(stage, &model.origin.file);
        warnings.extend(of_mesh);
        warnings.extend(model.origin.read.warnings());
        warnings.extend(frozen(prim, &facts.variants, &options.variants)?);
        let mut source = Self { model, garment, recipe, facts, warnings, seams: Vec::new(), fitted: None };
        if !options.unsewn {
            source.sew_itself(tolerance);
        }
        Ok(source)
    }

    /// Sews the borders of the mesh that coincide with each other.
    fn sew_itself(&mut self, tolerance: f64) {
        let Ok(garment) = &mut self.garment else { return };
        let (found, warnings) = sew_own_borders(garment, tolerance);
        self.warnings.extend(warnings);
        let Some((mut sewn, seam)) = found else { return };
        self.warnings.extend(sewn.warnings);
        let panels = [(); 2].map(|()| garment.prim.clone());
        self.seams.push(PanelSeam { panels, edges: seam.edges, gap: seam.gap });
        if let Ok(options) = &mut self.recipe {
            add_constraint(options, &sewn.seams);
        }
        let edges = edges(&std::mem::replace(garment, sewn.mesh));
        self.model.sewing = Sewing { sets: Vec::new(), points: sewn.points.remove(0), edges };
    }

    /// The mesh as authored. Attributes that are dropped and arcs that fail to compose become warnings.
    ///
    /// # Errors
    /// An attribute that is needed and is missing, of the wrong type or unreadable.
    pub fn garment(&self) -> Result<(Garment, Warnings), Error> {
        Ok((self.garment.clone()?, self.warnings.clone()))
    }

    /// The recipe in the model's own properties (namespace `tailor:`), as nested objects; relationships become arrays of
    /// subset names.
    ///
    /// # Errors
    /// A property of a type that no recipe field has, or whose target is not a subset of the mesh.
    pub fn recipe(&self) -> Result<Map<String, Json>, Error> {
        self.recipe.clone()
    }

    /// The notes about its layers that were converted.
    pub fn notes(&self) -> Vec<Warning> {
        self.model.origin.read.notes()
    }

    /// Notes that the garment is made of files with bodies too.
    pub fn add_bodies(&mut self, bodies: &[Self; 2]) {
        self.model.layers.extend(bodies.iter().flat_map(|body| body.model.layers.iter().cloned()));
        self.model.layers.sort();
        self.model.layers.dedup();
    }

    /// Whether products of the mesh are beside it.
    pub fn has_products(&self) -> bool {
        self.model.siblings.values().any(|sibling| sibling.product)
    }

    /// Facts about the model and its surroundings.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The file that was opened, as named.
    pub fn file(&self) -> &Path {
        &self.model.origin.file
    }

    /// Path of the mesh; of the first of several panels.
    pub fn prim(&self) -> &str {
        self.model.path.as_str()
    }

    /// Whether it consists of panels that are sewn together.
    pub fn is_sewn(&self) -> bool {
        self.model.is_sewn()
    }

    /// Path of the mesh, or of the prim that has all panels below it.
    pub fn whole(&self) -> &str {
        let path = if self.is_sewn() { &self.model.parent } else { &self.model.path };
        path.as_str()
    }

    /// Paths of the meshes that are sewn together, or of the one mesh.
    pub fn panels(&self) -> impl Iterator<Item = &str> {
        self.model.panels.iter().map(|panel| panel.as_str())
    }

    /// The face sets that its panels become; none for a lone mesh.
    pub fn panel_sets(&self) -> &[String] {
        &self.model.sewing.sets
    }

    /// The seams between its panels.
    pub fn seams(&self) -> &[PanelSeam] {
        &self.seams
    }
}

/// All variants of the sets of a name, of all prims of a stage in namespace order, selected or not.
///
/// # Errors
/// A stage that cannot be opened or queried.
pub fn variants_of(file: &Path, options: &ReadOptions, set: &str) -> Result<Vec<Selection>, Error> {
    on_large_stack(|| {
        let stage = StageOrigin::new(file, None, &options.variants).open()?;
        let mut found = Vec::new();
        for path in all_prims(&stage, file, PrimPredicate::DEFAULT, false)? {
            found.extend(choices_of(&prim_at(&stage, &path)?, set)?);
        }
        Ok(found)
    })
}

/// Warnings of arcs that fail to compose.
pub fn composition(stage: &Stage, file: &Path) -> Warnings {
    let warning = |e| {
        let problem = format!("the stage does not compose fully: {}", in_words(e));
        Warning::new(codes::COMPOSITION, file.display(), problem).remedy(remedy(e))
    };
    stage.composition_errors().iter().map(warning).collect()
}
