//! A `.tailor` file opened as a USD layer, with its file-format arguments.

use super::input::beside;
use crate::codes;
use crate::{ReadOptions, Source};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use tailor_costume::recipe::{Layers, RecipeFile, is_file};
use tailor_mesh::error::{Error, ErrorKind, Warning, Warnings};

/// A `.tailor` file and the file-format arguments that it was opened with.
#[derive(Clone, Debug)]
pub struct PayloadRecipe {
    path: PathBuf,
    source: String,
    options: ReadOptions,
    file: Map<String, Value>,
    arguments: Layers,
    /// Warnings of arguments that are not options with a value of their type.
    ignored: Warnings,
}

/// Arguments that OpenUSD itself adds to any layer; they are ignored.
const FOREIGN_ARGUMENTS: [&str; 1] = ["target"];

impl PayloadRecipe {
    /// Parses the text of the file at `path` and its arguments: `prim`, `time`, and options by their keys.
    ///
    /// # Errors
    /// A text that is not a recipe or has no source; a time that is not a number. An option that cannot be one is left out with a
    /// warning: the garment stays while its user mends the value.
    pub fn new<'a>(
        path: &Path,
        text: &str,
        arguments: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, Error> {
        let file = RecipeFile::parse(path, text)?;
        let source = file.required_source(path)?.to_owned();
        let options = ReadOptions { prim: file.prim.clone(), ..ReadOptions::default() };
        let (path, file) = (path.to_path_buf(), file.into_layer());
        let mut document =
            Self { path, source, options, file, arguments: Layers::default(), ignored: Warnings::default() };
        arguments.into_iter().try_for_each(|(key, text)| document.add_argument(key, text))?;
        Ok(document)
    }

    fn add_argument(&mut self, key: &str, text: &str) -> Result<(), Error> {
        match key {
            "prim" => self.options.prim = Some(text.to_owned()),
            "time" => {
                let time = text.parse().map_err(|_| {
                    let fault = Error::new(ErrorKind::Usage, "argument time", format!("\"{text}\" is not a number"))
                        .code(tailor_mesh::codes::OPTION_VALUE);
                    fault.remedy("give a time code, such as 24.5")
                })?;
                self.options.time = Some(time);
            }
            _ if FOREIGN_ARGUMENTS.contains(&key) => {}
            _ => {
                let is_file = is_file(key) && !text.is_empty();
                let beside = is_file.then(|| beside(&self.path, text).to_string_lossy().into_owned());
                let added = self.arguments.add_text("argument", key, beside.as_deref().unwrap_or(text));
                self.ignored.extend(added.err().map(|error| ignored(&error)));
            }
        }
        Ok(())
    }

    /// The source's path as written in the file.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The source's path, resolved relative to the file.
    pub fn source_file(&self) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(&self.source)
    }

    /// The folder of the file; `None` inside a package.
    pub fn folder(&self) -> Option<&Path> {
        let packed = self.path.to_str().is_some_and(|path| path.ends_with(']'));
        self.path.parent().filter(|_| !packed)
    }

    /// The prim and time to read from the source.
    pub fn options(&self) -> &ReadOptions {
        &self.options
    }

    /// The options of the arguments, which are stronger than all others. Warns of those that are left out.
    pub fn arguments(&self) -> (Layers, Warnings) {
        (self.arguments.clone(), self.ignored.clone())
    }

    /// The source's attributes, overridden by the file. Warns of attributes that are left out.
    ///
    /// # Errors
    /// `tailor:` attributes of the source that cannot be read.
    pub fn layers(&self, source: &Source) -> Result<(Layers, Warnings), Error> {
        let mut layers = Layers::default();
        let warnings = layers.add_attributes(source.recipe()?);
        layers.add(self.file.clone());
        Ok((layers, warnings))
    }
}

/// The warning of an argument that is left out for an error.
pub fn ignored(error: &Error) -> Warning {
    let (place, remedy) = error.faults.first().map(|f| (f.place.clone(), f.remedy.clone())).unwrap_or_default();
    let faults: Vec<&str> = error.faults.iter().map(|fault| fault.text.as_str()).collect();
    let problem = format!("left out, as {}", faults.join("; "));
    Warning::new(codes::IGNORED_OPTION, place, problem).remedy(remedy)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"{"source": "coat.usda", "prim": "/Coat/model", "sim": {"iterations": 3}}"#;

    fn document(text: &str, arguments: &[(&str, &str)]) -> Result<PayloadRecipe, Error> {
        PayloadRecipe::new(Path::new("/a/coat.tailor"), text, arguments.iter().copied())
    }

    #[test]
    fn arguments_are_stronger_than_the_file() {
        let arguments = [("sim.iterations", "4"), ("prim", "/Coat/other"), ("time", "2.5"), ("target", "usd")];
        let document = document(FILE, &arguments).expect("a good file");
        assert_eq!(document.source_file(), Path::new("/a/coat.usda"));
        assert_eq!(
            document.options(),
            &ReadOptions { prim: Some("/Coat/other".into()), time: Some(2.5), ..ReadOptions::default() }
        );
        let mut layers = Layers::default();
        layers.add(document.file);
        layers.add(document.arguments.into_map());
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
        ] {
            let message = document(text, &[argument]).expect_err(text).to_string();
            assert!(message.contains(expected) && message.contains("hint:"), "{message}");
        }
    }

    #[test]
    fn an_argument_that_is_no_option_is_left_out_with_a_warning() {
        for (key, text, expected) in [
            (
                "sim.maxEdge",
                "2",
                "argument sim.maxEdge: left out, as there is no such option. did you mean sim.maxEdgeLength?",
            ),
            ("render.level", "two", "argument render.level: left out, as \"two\" is not a whole number"),
        ] {
            let document = document(FILE, &[(key, text), ("sim.iterations", "4")]).expect("a good file");
            let (arguments, warnings) = document.arguments();
            let texts: Vec<String> = warnings.iter().map(ToString::to_string).collect();
            assert!(texts.len() == 1 && texts[0].starts_with(expected), "{texts:?}");
            assert_eq!(arguments.recipe().expect("a good recipe").sim.iterations, 4);
        }
    }
}
