//! From a recipe and a composed source to a layer, with what the crate [`tailor`] offers.

use crate::ffi::{Argument, Field, Generated};
use std::io::Write;
use tailor::error::Warnings;
use tailor::pipeline::{DEFAULT_MAX_FACES, Limits, Prepared, Products};
use tailor::recipe::{KEYS, Layers, RecipeFile};
use tailor::usd::{Format, Product, ReadOptions, Role, Source, WriteOptions, layer_bytes};
use tempfile::NamedTempFile;

/// A `.tailor` file with the arguments it was opened with.
#[derive(Debug)]
pub struct Document {
    path: String,
    source: String,
    recipe: RecipeFile,
    /// As `key=value`.
    arguments: Vec<String>,
}

impl Document {
    pub fn read(path: &str, text: &[u8], arguments: &[Argument]) -> Result<Self, String> {
        // The crate reads recipes from files, whose name then is in its messages.
        let file = stored(text, ".tailor")?;
        let recipe = RecipeFile::read(file.path())
            .map_err(|e| e.to_string().replace(&file.path().display().to_string(), path))?;
        let source = recipe.source.clone().filter(|source| !source.is_empty()).ok_or_else(|| {
            "there is no \"source\"\n  hint: name the USD file of the garment, such as {\"source\": \"coat.usda\"}"
                .to_owned()
        })?;
        let arguments: Vec<String> = arguments.iter().map(|a| format!("{}={}", a.key, a.value)).collect();
        add_arguments(&mut Layers::default(), &arguments)?;
        Ok(Self { path: path.into(), source, recipe, arguments })
    }

    pub fn path(&self) -> &str {
        &self.path
    }

    pub fn source(&self) -> &str {
        &self.source
    }

    pub fn generate(&self, flattened: &[u8], metadata_only: bool) -> Result<Generated, String> {
        let file = stored(flattened, ".usdc")?;
        let source = Source::open(file.path(), &ReadOptions { prim: self.recipe.prim.clone(), time: None })
            .map_err(|e| e.to_string().replace(&file.path().display().to_string(), &self.source))?;
        let mut warnings = Warnings::default();
        // The metadata are those of the source, whatever the meshes are.
        let products = if metadata_only { None } else { Some(self.build(&source, &mut warnings)?) };
        let meshes: Vec<Product<'_>> = products.iter().flat_map(meshes).collect();
        let options = WriteOptions { flatten: true, ..WriteOptions::default() };
        let layer =
            layer_bytes(&source, &meshes, Format::Usdc, None, &options, &mut warnings).map_err(|e| e.to_string())?;
        Ok(Generated { layer, warnings: warnings.iter().map(ToString::to_string).collect() })
    }

    fn build(&self, source: &Source, warnings: &mut Warnings) -> Result<Products, String> {
        let text = |e: tailor::error::Error| e.to_string();
        let mut layers = Layers::default();
        layers.add_attributes(source.recipe().map_err(|e| e.to_string())?, warnings);
        layers.add(self.recipe.clone().into_layer());
        add_arguments(&mut layers, &self.arguments)?;
        let garment = source.garment(warnings).map_err(|e| e.to_string())?;
        let prepared = Prepared::new(garment, &layers, warnings).map_err(text)?;
        prepared.build(&Limits { max_faces: DEFAULT_MAX_FACES, progress: &|_| () }, warnings).map_err(text)
    }
}

fn add_arguments(layers: &mut Layers, arguments: &[String]) -> Result<(), String> {
    let text = |e: tailor::error::Error| e.to_string().replace("--set ", "the file-format argument ");
    arguments.iter().try_for_each(|argument| layers.add_override(argument).map_err(text))
}

fn meshes(products: &Products) -> [Product<'_>; 2] {
    [
        Product { name: Role::Sim.name(), role: Role::Sim, mesh: &products.sim },
        Product { name: Role::Render.name(), role: Role::Render, mesh: &products.render },
    ]
}

pub fn fields() -> Vec<Field> {
    let field = |key: &str| Field { attribute: format!("tailor:{}", key.replace('.', ":")), argument: key.into() };
    KEYS.iter().map(|key| field(key.0)).collect()
}

fn stored(bytes: &[u8], suffix: &str) -> Result<NamedTempFile, String> {
    let fault = |e: std::io::Error| format!("cannot write a temporary file: {e}\n  hint: TMPDIR names the folder");
    let mut file = tempfile::Builder::new().suffix(suffix).tempfile().map_err(fault)?;
    file.write_all(bytes).map_err(fault)?;
    Ok(file)
}
