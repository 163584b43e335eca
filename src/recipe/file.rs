//! Reads `.tailor` files: recipes as JSON.

use super::in_words;
use crate::cloth::{ClothOptions, FabricOptions};
use crate::error::{Error, ErrorCode, plain};
use crate::files;
use crate::render::{RenderOptions, SeamOptions, ThicknessOptions};
use crate::sim::SimOptions;
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;

/// The content of a `.tailor` file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct RecipeFile {
    /// The garment's USD file, relative to the `.tailor` file.
    pub source: Option<String>,
    /// Prim path of the mesh.
    pub prim: Option<String>,
    sim: Map<String, Value>,
    render: Map<String, Value>,
    cloth: Map<String, Value>,
    #[serde(flatten)]
    instances: Map<String, Value>,
}

impl RecipeFile {
    /// Reads a `.tailor` file.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a recipe, with line and column.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = files::text(path).map_err(|e| {
            Error::recipe(path.display(), format!("cannot read recipe: {}", plain(&e)))
                .code(ErrorCode::RecipeFile)
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
            let fault = Error::recipe(path.display(), in_words(&e)).code(ErrorCode::RecipeFile);
            fault.remedy("a recipe is JSON, such as {\"sim\": {\"maxEdgeLength\": 2}}").caused_by(e)
        };
        // Some editors write a byte order mark.
        let text = text.trim_start_matches('\u{feff}');
        // The typed pass reports wrong keys and values with line and column; the second pass keeps only the keys given.
        serde_json::from_str::<Form>(text).map_err(fault)?;
        serde_json::from_str(text).map_err(fault)
    }

    /// The `source` entry, which a `.tailor` file at `path` needs to be opened as an input.
    ///
    /// # Errors
    /// A missing source, or one that is itself a recipe.
    pub fn required_source(&self, path: &Path) -> Result<&str, Error> {
        let fault = |fault: &str, remedy: &str| {
            Err(Error::recipe(path.display(), fault).code(ErrorCode::RecipeFile).remedy(remedy))
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
        let mut layer = Map::new();
        layer.insert("sim".into(), Value::Object(self.sim));
        layer.insert("render".into(), Value::Object(self.render));
        layer.insert("cloth".into(), Value::Object(self.cloth));
        layer.extend(self.instances);
        layer
    }
}

/// The allowed keys of a `.tailor` file and their types.
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
    #[serde(rename = "cloth")]
    _cloth: ClothOptions,
    #[serde(rename = "seam")]
    _seam: Named<SeamOptions>,
    #[serde(rename = "thickness")]
    _thickness: Named<ThicknessOptions>,
    #[serde(rename = "fabric")]
    _fabric: Named<FabricOptions>,
}

/// Options by name. A name that is given twice is an error, as the first options under it would be lost.
struct Named<T>(PhantomData<T>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Self::default())
    }
}

impl<'de, T: Deserialize<'de>> Visitor<'de> for Named<T> {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self, A::Error> {
        let mut names = BTreeSet::new();
        while let Some(name) = map.next_key::<String>()? {
            if names.contains(&name) {
                return Err(A::Error::custom(format!("the name `{name}` is given twice")));
            }
            names.insert(name);
            map.next_value::<T>()?;
        }
        Ok(self)
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
        for kind in ["seam", "thickness", "fabric"] {
            let text = format!("{{\"{kind}\": {{\n\"a\": {{}}, \"b\": {{}},\n \"a\": {{}}}}}}");
            let fault = RecipeFile::parse(Path::new("my.tailor"), &text).expect_err(kind).to_string();
            assert!(fault.contains("the name `a` is given twice at line 3"), "{fault}");
            let text = text.replacen("\"a\"", "\"c\"", 1);
            assert!(RecipeFile::parse(Path::new("my.tailor"), &text).is_ok(), "{kind}");
        }
    }
}
