//! A garment on disk with the recipes that are given for it, for the command and the preview.

use super::fitted::{FitWay, follow_body};
use crate::{PAINTED, ReadOptions, Selection, Source, variants_of};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use tailor::sets::painted_expression;
use tailor_costume::pipeline::Builder;
use tailor_costume::recipe::{Layers, Recipe, RecipeFile, is_recipe};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::{Garment, Values};

/// A garment and the options for it.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// A USD file, or a `.tailor` file that names one as its source.
    pub file: PathBuf,
    /// The part of the stage to read. A prim here overrides that of the recipes.
    pub read: ReadOptions,
    /// A `.tailor` file whose options are weaker than those of `recipe`: that of which `file` was built.
    pub base: Option<PathBuf>,
    /// A `.tailor` file, or a USD layer with `tailor:` attributes on the same prim.
    pub recipe: Option<PathBuf>,
    /// Options as `key=value`, stronger than all others.
    pub overrides: Vec<String>,
    /// The file of a body that is shown in the preview; by default the one that the recipe fits the garment to.
    pub body: Option<PathBuf>,
}

/// An opened input, before its mesh and its recipe are checked.
#[derive(Clone, Debug)]
pub struct OpenGarment {
    /// The stage.
    pub source: Source,
    /// The mesh as authored.
    pub mesh: Garment,
    /// The options that the stage itself holds.
    pub authored: Layers,
    /// The options of the recipes and overrides.
    pub given: Layers,
    /// The way of the garment to the body of the recipe, where it names one.
    pub way: Option<FitWay>,
    /// Warnings of the stage and of its options.
    pub warnings: Warnings,
}

impl OpenGarment {
    /// All options merged.
    pub fn layers(&self) -> Layers {
        let mut layers = self.authored.clone();
        layers.add(self.given.clone().into_map());
        layers
    }

    /// Checks the mesh, and the recipe against it. The builder has the warnings of both.
    ///
    /// # Errors
    /// Faults of the mesh or of the recipe.
    pub fn check(self) -> Result<(Source, Builder, Recipe), Error> {
        let layers = self.layers();
        let builder = Builder::new(self.mesh)?.with_warnings(self.warnings);
        let recipe = layers.recipe_for(builder.garment())?;
        Ok((self.source, builder, recipe))
    }
}

impl Input {
    /// Opens the one garment of the stage that [`Input::read`] chooses: a mesh, or panels that are sewn together.
    ///
    /// # Errors
    /// A file that cannot be read; a recipe with faults; several garments.
    pub fn open_one(&self) -> Result<OpenGarment, Error> {
        let recipes = self.recipes()?;
        let source = Source::only(Source::open_all(&recipes.file, &recipes.read)?)?;
        self.opened(source, &recipes)
    }

    /// Opens all garments of the stage that [`Input::read`] chooses, see [`Source::open_all`]. The recipes and overrides are
    /// options of each of them.
    ///
    /// # Errors
    /// A file that cannot be read; a recipe with faults; for any of the garments.
    pub fn open_all(&self) -> Result<Vec<OpenGarment>, Error> {
        let recipes = self.recipes()?;
        let sources = Source::open_all(&recipes.file, &recipes.read)?;
        sources.into_iter().map(|source| self.opened(source, &recipes)).collect()
    }

    /// All variants of the sets of a name in the stage, see [`variants_of`].
    ///
    /// # Errors
    /// A file that cannot be read; a recipe with faults.
    pub fn variants(&self, set: &str) -> Result<Vec<Selection>, Error> {
        let recipes = self.recipes()?;
        variants_of(&recipes.file, &recipes.read, set)
    }

    /// Reads the recipe files, and finds the stage.
    fn recipes(&self) -> Result<Recipes, Error> {
        let own = if is_recipe(&self.file) { Some(RecipeFile::read(&self.file)?) } else { None };
        let file = match &own {
            Some(own) => beside(&self.file, own.required_source(&self.file)?),
            None => self.file.clone(),
        };
        let base = self.base.as_deref().map(RecipeFile::read).transpose()?;
        let given = match &self.recipe {
            Some(path) if !is_usd(path) => Some(RecipeFile::read(path)?),
            _ => None,
        };
        let files: Vec<RecipeFile> = own.into_iter().chain(base).chain(given).collect();
        let named = files.iter().rev().find_map(|r| r.prim.clone());
        let mut given = Layers::default();
        files.iter().for_each(|recipe| given.add(recipe.clone().into_layer()));
        self.overrides.iter().try_for_each(|assignment| given.add_override(assignment))?;
        let (prim, trims) = (self.read.prim.clone().or(named), given.trims());
        let read = ReadOptions { prim, trims, ..self.read.clone() };
        Ok(Recipes { file, read, files })
    }

    fn opened(&self, mut source: Source, recipes: &Recipes) -> Result<OpenGarment, Error> {
        let mut warnings = Warnings::default();
        let (mut authored, mut given) = (Layers::default(), Layers::default());
        warnings.extend(authored.add_attributes(source.recipe()?));
        recipes.files.iter().for_each(|recipe| given.add(recipe.clone().into_layer()));
        if let Some(layer) = self.recipe.as_deref().filter(|path| is_usd(path)) {
            warnings.extend(given.add_attributes(attributes_of(layer, &source)?));
        }
        self.overrides.iter().try_for_each(|assignment| given.add_override(assignment))?;
        let mut mesh = warnings.absorb(source.garment()?);
        let mut all = authored.clone();
        all.add(given.clone().into_map());
        warnings.extend(all.check_schemas(source.prim(), &source.facts().api_schemas));
        [&mut authored, &mut given].into_iter().for_each(|layers| layers.convert_lengths(mesh.units));
        all.convert_lengths(mesh.units);
        // Faults of a recipe are those of its check.
        let mut way = None;
        if let Ok(recipe) = all.recipe() {
            way = warnings.absorb(follow_body(&mut source, &mut mesh, &recipe, self.read.time)?);
        }
        Ok(OpenGarment { source, mesh, authored, given, way, warnings })
    }
}

/// The recipe files of an input, weakest first, and the stage that they and the input name.
struct Recipes {
    file: PathBuf,
    read: ReadOptions,
    files: Vec<RecipeFile>,
}

/// The options on the prim of a stage. Weights that [`PAINTED`] names are in the options themselves, as the garment below lacks them.
fn attributes_of(layer: &Path, source: &Source) -> Result<Map<String, Value>, Error> {
    if source.is_sewn() {
        let fault = format!("{} has options of single meshes, and panels are sewn together", layer.display());
        return Err(Error::recipe("--recipe", fault)
            .remedy("give the options in a .tailor file, or build over the layer, which has the meshes"));
    }
    let layer = Source::open(layer, &ReadOptions { prim: Some(source.prim().to_owned()), ..ReadOptions::default() })?;
    let mut options = Value::Object(layer.recipe()?);
    let mut garment = layer.garment()?.0;
    garment.primvars.retain(|primvar| primvar.name.starts_with(PAINTED));
    if !garment.primvars.is_empty() {
        let builder = Builder::new(garment)?;
        for primvar in &*builder.garment().primvars {
            let Values::F32(weights) = &primvar.values else { continue };
            replace(&mut options, &primvar.name, &painted_expression(&builder.garment().faces, weights));
        }
    }
    Ok(options.as_object().cloned().unwrap_or_default())
}

/// Replaces a name in all texts of a value, which may be lists.
fn replace(value: &mut Value, name: &str, by: &str) {
    match value {
        Value::String(all) => {
            *all = all.split(", ").map(|one| if one == name { by } else { one }).collect::<Vec<_>>().join(", ");
        }
        Value::Array(all) => all.iter_mut().for_each(|value| replace(value, name, by)),
        Value::Object(fields) => fields.values_mut().for_each(|value| replace(value, name, by)),
        _ => {}
    }
}

/// True if the file is USD by its name.
pub fn is_usd(path: &Path) -> bool {
    let known = |e: &std::ffi::OsStr| ["usd", "usda", "usdc", "usdz"].iter().any(|usd| e.eq_ignore_ascii_case(usd));
    path.extension().is_some_and(known)
}

/// The path of `source`, which the recipe at `path` names relative to itself.
pub fn beside(path: &Path, source: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(source)
}
