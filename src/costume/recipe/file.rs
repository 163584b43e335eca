//! Reads `.tailor` files: recipes as JSON.

use super::groups::Form;
use super::{in_words, is_file};
use crate::codes;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, plain};
use tailor_mesh::files;

/// The content of a `.tailor` file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub struct RecipeFile {
    /// The garment's USD file, relative to the `.tailor` file.
    pub source: Option<String>,
    /// Prim path of the mesh.
    pub prim: Option<String>,
    #[serde(flatten)]
    options: Map<String, Value>,
}

impl RecipeFile {
    /// Reads a `.tailor` file.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a recipe, with line and column.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = files::text(path).map_err(|e| {
            Error::recipe(path.display(), format!("cannot read recipe: {}", plain(&e)))
                .code(codes::RECIPE_FILE)
                .remedy("check the path")
                .caused_by(e)
        })?;
        Self::parse(path, &text)
    }

    /// Parses the text of the `.tailor` file at `path`, which errors name.
    ///
    /// # Errors
    /// A text that is not a recipe, with line and column.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let fault = |e: serde_json::Error| {
            let fault = Error::recipe(path.display(), in_words(&e)).code(codes::RECIPE_FILE);
            fault.remedy("a recipe is JSON, such as {\"sim\": {\"maxEdgeLength\": 2}}").caused_by(e)
        };
        // Some editors write a byte order mark.
        let text = text.trim_start_matches('\u{feff}');
        // The typed pass reports wrong keys and values with line and column; the second pass keeps only the keys given.
        serde_json::from_str::<Form>(text).map_err(fault)?;
        let mut file: Self = serde_json::from_str(text).map_err(fault)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        map_files(&mut file.options, |path| folder.join(path));
        Ok(file)
    }

    /// The `source` entry, which a `.tailor` file at `path` needs to be opened as an input.
    ///
    /// # Errors
    /// A missing source, or one that is itself a recipe.
    pub fn required_source(&self, path: &Path) -> Result<&str, Error> {
        let fault = |fault: &str, remedy: &str| {
            Err(Error::recipe(path.display(), fault).code(codes::RECIPE_FILE).remedy(remedy))
        };
        match self.source.as_deref() {
            None | Some("") => fault("it names no source", "add \"source\": \"coat.usda\", relative to the file"),
            Some(source) if is_recipe(Path::new(source)) => {
                fault("its source is a recipe too", "name the USD file of the garment")
            }
            Some(source) => Ok(source),
        }
    }

    /// The options in the file, as nested keys.
    pub fn into_layer(self) -> Map<String, Value> {
        self.options
    }
}

/// Replaces the paths of files in some options, except for empty ones.
pub fn map_files(options: &mut Map<String, Value>, path: impl Fn(&str) -> PathBuf) {
    for (group, fields) in options {
        for (key, value) in fields.as_object_mut().into_iter().flatten() {
            if let Value::String(text) = value
                && is_file(&format!("{group}.{key}"))
                && !text.is_empty()
            {
                *text = path(text).to_string_lossy().into_owned();
            }
        }
    }
}

/// `true` if the extension of `path` is `.tailor`.
pub fn is_recipe(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tailor"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_given_once() {
        for kind in ["seam", "fold", "fabric"] {
            let text = format!("{{\"{kind}\": {{\n\"a\": {{}}, \"b\": {{}},\n \"a\": {{}}}}}}");
            let fault = RecipeFile::parse(Path::new("my.tailor"), &text).expect_err(kind).to_string();
            assert!(fault.contains("the name `a` is given twice at line 3"), "{fault}");
            let text = text.replacen("\"a\"", "\"c\"", 1);
            assert!(RecipeFile::parse(Path::new("my.tailor"), &text).is_ok(), "{kind}");
        }
    }
}
