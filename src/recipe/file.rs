//! `.tailor` files.

use super::{Layers, in_words};
use crate::error::{Error, Warnings, plain};
use crate::render::{RenderOptions, SeamOptions, ThicknessOptions};
use crate::sim::SimOptions;
use crate::usd::{ReadOptions, Source};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A `.tailor` file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct RecipeFile {
    /// The USD file, relative to this one.
    pub source: Option<String>,
    /// Path of the mesh.
    pub prim: Option<String>,
    sim: Map<String, Value>,
    render: Map<String, Value>,
    #[serde(flatten)]
    instances: Map<String, Value>,
}

impl RecipeFile {
    /// Reads a `.tailor` file.
    ///
    /// # Errors
    /// A file that is missing or is not a recipe, with line and column.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|e| {
            let shown = path.display();
            Error::Recipe(format!("cannot read recipe {shown}: {}\n  hint: check the path", plain(&e)))
        })?;
        Self::parse(path, &text)
    }

    /// Reads the text of the `.tailor` file `path`.
    ///
    /// # Errors
    /// A text that is not a recipe, with line and column.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let fault = |e: serde_json::Error| {
            Error::Recipe(format!(
                "{}: {}\n  hint: a recipe is JSON, such as {{\"sim\": {{\"maxEdgeLength\": 2}}}}",
                path.display(),
                in_words(&e)
            ))
        };
        // Some editors put a byte order mark first.
        let text = text.trim_start_matches('\u{feff}');
        // Once for its form with unknown keys by line and column, once for what it says.
        serde_json::from_str::<Form>(text).map_err(fault)?;
        serde_json::from_str(text).map_err(fault)
    }

    /// The source that the file, which is at `path`, must name to be opened itself.
    ///
    /// # Errors
    /// No source, or one that is a recipe again.
    pub fn required_source(&self, path: &Path) -> Result<&str, Error> {
        let fault =
            |fault: &str, hint: &str| Err(Error::Recipe(format!("{}: {fault}\n  hint: {hint}", path.display())));
        match self.source.as_deref() {
            None | Some("") => fault("it names no source", "add \"source\": \"coat.usda\", relative to the file"),
            Some(source) if is_recipe(Path::new(source)) => {
                fault("its source is a recipe too", "name the USD file that is the garment")
            }
            Some(source) => Ok(source),
        }
    }

    /// What the file says about the products.
    pub fn into_layer(self) -> Map<String, Value> {
        let mut layer = Map::new();
        layer.insert("sim".into(), Value::Object(self.sim));
        layer.insert("render".into(), Value::Object(self.render));
        layer.extend(self.instances);
        layer
    }
}

/// The keys and types of a `.tailor` file.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
struct Form {
    #[serde(rename = "source")]
    _source: Option<String>,
    #[serde(rename = "prim")]
    _prim: Option<String>,
    #[serde(rename = "sim")]
    _sim: SimOptions,
    #[serde(rename = "render")]
    _render: RenderOptions,
    #[serde(rename = "seam")]
    _seam: BTreeMap<String, SeamOptions>,
    #[serde(rename = "thickness")]
    _thickness: BTreeMap<String, ThicknessOptions>,
}

/// Whether a file is a recipe, by its name.
pub fn is_recipe(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tailor"))
}

/// A `.tailor` file that is opened as a layer, with the arguments that it is opened with.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    source: String,
    options: ReadOptions,
    file: Map<String, Value>,
    arguments: Layers,
}

/// File-format arguments that OpenUSD itself adds.
const FOREIGN_ARGUMENTS: [&str; 1] = ["target"];

impl Document {
    /// Reads the text of the file `path` and the arguments: `prim`, `time`, and the options by their keys.
    ///
    /// # Errors
    /// A text that is not a recipe or names no source; arguments that are unknown or have values of another type.
    pub fn new<'a>(
        path: &Path,
        text: &str,
        arguments: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, Error> {
        let file = RecipeFile::parse(path, text)?;
        let source = file.required_source(path)?.to_owned();
        let options = ReadOptions { prim: file.prim.clone(), time: None };
        let (path, file) = (path.to_path_buf(), file.into_layer());
        let mut document = Self { path, source, options, file, arguments: Layers::default() };
        arguments.into_iter().try_for_each(|(key, text)| document.add_argument(key, text))?;
        Ok(document)
    }

    fn add_argument(&mut self, key: &str, text: &str) -> Result<(), Error> {
        match key {
            "prim" => self.options.prim = Some(text.to_owned()),
            "time" => {
                let time = text.parse().map_err(|_| {
                    Error::Usage(format!(
                        "argument time: \"{text}\" is no number\n  hint: give a time code, such as 24.5"
                    ))
                })?;
                self.options.time = Some(time);
            }
            _ if FOREIGN_ARGUMENTS.contains(&key) => {}
            _ => self.arguments.add_text("argument", key, text)?,
        }
        Ok(())
    }

    /// The source as the file names it.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The source as a file, relative to this one.
    pub fn source_file(&self) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(&self.source)
    }

    /// The folder that the file is in; none inside a package.
    pub fn folder(&self) -> Option<&Path> {
        let packed = self.path.to_str().is_some_and(|path| path.ends_with(']'));
        self.path.parent().filter(|_| !packed)
    }

    /// What is read of the source.
    pub fn options(&self) -> &ReadOptions {
        &self.options
    }

    /// The layers of the recipe over those of the source's own attributes.
    ///
    /// # Errors
    /// Attributes that are no recipe.
    pub fn layers(&self, source: &Source, warnings: &mut Warnings) -> Result<Layers, Error> {
        let mut layers = Layers::default();
        layers.add_attributes(source.recipe()?, warnings);
        layers.add(self.file.clone());
        layers.add(self.arguments.merged.clone());
        Ok(layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"source": "coat.usda", "prim": "/Coat/model", "sim": {"iterations": 3}}"#;

    fn document(text: &str, arguments: &[(&str, &str)]) -> Result<Document, Error> {
        Document::new(Path::new("/a/coat.tailor"), text, arguments.iter().copied())
    }

    #[test]
    fn arguments_are_stronger_than_the_file() {
        let arguments = [("sim.iterations", "4"), ("prim", "/Coat/other"), ("time", "2.5"), ("target", "usd")];
        let document = document(FILE, &arguments).expect("a good file");
        assert_eq!(document.source_file(), Path::new("/a/coat.usda"));
        assert_eq!(document.options(), &ReadOptions { prim: Some("/Coat/other".into()), time: Some(2.5) });
        let mut layers = Layers::default();
        layers.add(document.file);
        layers.add(document.arguments.merged);
        assert_eq!(layers.recipe().expect("a good recipe").sim.iterations, 4);
    }

    #[test]
    fn a_byte_order_mark_is_no_fault() {
        assert!(document(&format!("\u{feff}{FILE}"), &[]).is_ok());
    }

    #[test]
    fn faults_name_the_file_or_the_argument_and_the_remedy() {
        for (text, argument, expected) in [
            ("{}", ("time", "1"), "/a/coat.tailor: it names no source"),
            (r#"{"source": "b.tailor"}"#, ("time", "1"), "a recipe too"),
            (r#"{"source": "b.usda", "sims": {}}"#, ("time", "1"), "line 1 column"),
            (FILE, ("time", "noon"), "argument time"),
            (FILE, ("sim.maxEdge", "2"), "argument sim.maxEdge: there is no such option"),
            (FILE, ("render.level", "two"), "argument render.level: \"two\" is no whole number"),
        ] {
            let message = document(text, &[argument]).expect_err(text).to_string();
            assert!(message.contains(expected) && message.contains("hint:"), "{message}");
        }
    }
}
