//! Saves the edits: as a USD layer over the garment, or as a `.tailor` file.
//!
//! A file gets its name only after it was opened like any input and found to give the garment and the recipe that are on
//! screen, so that `usdtailor build` gives the same meshes.

pub mod presets;

use super::document::Options;
use super::hub::Hub;
use super::messages::{SaveMessage, SaveStatus};
use super::stage::Stage;
use serde_json::{Map, Value};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor::sets::painted_weights;
use tailor_costume::fit::BodyOptions;
use tailor_costume::recipe::{Domain, Recipe, all, find, group_with_instances, is_attribute, is_recipe, map_files};
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_mesh::files::{self, folder_of};
use tailor_mesh::garment::{Garment, free_name};
use tailor_usd::session::Input;
use tailor_usd::{
    EarlierRecipe, OptionValue, PAINTED, ReadOptions, RecipeOpinions, recipe_text, relative, temporary_beside,
    write_recipe,
};

/// The content of a save.
struct Content {
    stage: Arc<Stage>,
    edits: Options,
    read: ReadOptions,
}

/// The content that a save to `path` would write.
pub fn plan(hub: &Hub, path: &str) -> SaveMessage {
    let content = Content::of(hub);
    let file = PathBuf::from(path);
    answer(path, SaveStatus::Planned, content.text(&file), content.note(&file))
}

/// Saves to `path`; an existing file only with `overwrite`.
pub fn save(hub: &Hub, path: &str, overwrite: bool) -> SaveMessage {
    let content = Content::of(hub);
    let file = PathBuf::from(path);
    let text = content.text(&file);
    let note = content.note(&file);
    let result = content.write(&file, overwrite);
    if result.is_ok() {
        hub.note_saved(content.edits, &file);
        return answer(path, SaveStatus::Saved, text, String::new());
    }
    let shown = text.clone().unwrap_or_default();
    SaveMessage { text: shown, ..answer(path, SaveStatus::Saved, result.and(text), note) }
}

fn answer(path: &str, status: SaveStatus, text: Result<String, Error>, note: String) -> SaveMessage {
    let (status, text, fault) = match text {
        Ok(text) => (status, text, None),
        Err(error) => (SaveStatus::Refused, String::new(), error.faults.into_iter().next()),
    };
    SaveMessage { path: path.into(), status, exists: Path::new(path).exists(), text, note, fault }
}

impl Content {
    fn of(hub: &Hub) -> Self {
        let now = hub.snapshot();
        Self { stage: now.stage, edits: now.state.edits.clone(), read: hub.read_options() }
    }

    fn text(&self, file: &Path) -> Result<String, Error> {
        if is_recipe(file) {
            return self.recipe_file(file);
        }
        self.refuse_sewn(file)?;
        recipe_text(&self.stage.source, &self.opinions(file), file)
    }

    /// Options in a layer are of one mesh.
    fn refuse_sewn(&self, file: &Path) -> Result<(), Error> {
        if !self.stage.source.is_sewn() {
            return Ok(());
        }
        let text = "a layer has the options of single meshes, and panels are sewn together here";
        let fault = Error::new(ErrorKind::Usage, file.display(), text).code(tailor_usd::codes::OUTPUT_PATH);
        Err(fault.remedy("save a .tailor file"))
    }

    fn note(&self, file: &Path) -> String {
        if !file.exists() {
            String::new()
        } else if is_recipe(file) {
            "The file exists. All of it will be replaced.".into()
        } else {
            let lost = if has_comments(file) { "; comments in its text will be lost" } else { "" };
            format!(
                "The layer exists. Its options of this garment will be replaced by these; everything else in it stays{lost}."
            )
        }
    }

    fn write(&self, file: &Path, overwrite: bool) -> Result<(), Error> {
        // A recipe with a fault cannot be built from any file.
        self.stage.recipe(&self.edits).and_then(|recipe| self.stage.checks.resolve(&recipe))?;
        if is_recipe(file) {
            return self.write_recipe_file(file, overwrite);
        }
        self.refuse_sewn(file)?;
        let is_option = |name: &str| is_attribute(name) || name.starts_with(&format!("primvars:{PAINTED}"));
        let replaced = EarlierRecipe { is_option, is_schema };
        write_recipe(&self.stage.source, &self.opinions(file), file, overwrite, &replaced, |written| {
            self.verify(written)
        })
    }

    /// The text of a `.tailor` file.
    fn recipe_file(&self, file: &Path) -> Result<String, Error> {
        let fault =
            |text: &str| Error::new(ErrorKind::Usage, file.display(), text).code(tailor_usd::codes::OUTPUT_PATH);
        if !self.read.variants.is_empty() {
            return Err(fault("a .tailor file holds no variants, and variants were selected here")
                .remedy("save a USD layer, which holds them"));
        }
        let garment = self.stage.source.file();
        let target = files::target(file).unwrap_or_else(|_| file.to_path_buf());
        let [named, real] = [file, &target].map(|file| folder_of(file).canonicalize());
        let source = match (named, real, garment.canonicalize()) {
            // A path that holds from a link and from the file that it leads to is absolute.
            (Ok(named), Ok(real), Ok(garment)) => {
                let path = relative(&real, &garment).filter(|_| named == real);
                path.unwrap_or_else(|| garment.display().to_string())
            }
            _ => return Err(fault("its folder does not exist").remedy("create the folder first")),
        };
        let mut text = Map::new();
        text.insert("source".into(), Value::String(source));
        text.insert("prim".into(), Value::String(self.stage.source.whole().into()));
        text.extend(self.edits_beside(file));
        let text = serde_json::to_string_pretty(&Value::Object(text));
        text.map(|text| text + "\n").map_err(|e| Error::internal(e.to_string()))
    }

    /// The edits with paths relative to the folder of `file`, where they lead to files.
    fn edits_beside(&self, file: &Path) -> Options {
        let (mut edits, folder) = (self.edits.clone(), folder_of(file).canonicalize());
        map_files(&mut edits, |path| {
            let both = folder.as_ref().ok().zip(Path::new(path).canonicalize().ok());
            both.and_then(|(folder, file)| relative(folder, &file)).unwrap_or_else(|| path.to_owned()).into()
        });
        edits
    }

    fn write_recipe_file(&self, file: &Path, overwrite: bool) -> Result<(), Error> {
        let text = self.recipe_file(file)?;
        let fault = |e: std::io::Error| {
            Error::new(ErrorKind::Usage, file.display(), format!("cannot be written: {}", plain(&e)))
                .code(tailor_usd::codes::WRITE_FAILED)
                .caused_by(e)
        };
        let target = files::target(file).map_err(fault)?;
        let mut temporary = temporary_beside(&target).map_err(fault)?;
        temporary.write_all(text.as_bytes()).map_err(fault)?;
        self.verify(temporary.path())?;
        // A file that came up in the meantime is not lost either.
        temporary.persist(&target, overwrite).map_err(|e| match e.kind() {
            std::io::ErrorKind::AlreadyExists => {
                Error::new(ErrorKind::Usage, file.display(), "the file exists already")
                    .code(tailor_usd::codes::OUTPUT_EXISTS)
                    .remedy("choose overwrite, or another name")
            }
            _ => fault(e),
        })
    }

    /// Checks that a written file gives the garment and the recipe that are on screen.
    fn verify(&self, written: &Path) -> Result<(), Error> {
        let prim = Some(self.stage.source.whole().to_owned());
        let read = ReadOptions { prim, time: self.read.time, ..ReadOptions::default() };
        let opened = Input { file: written.to_path_buf(), read, ..Input::default() }.open_one()?;
        let fault = |text: &str| {
            Error::new(ErrorKind::Usd, "", format!("{text}, so nothing was written"))
                .code(tailor_usd::codes::NOT_WRITTEN_BACK)
                .remedy("save to a new file")
        };
        let [read, shown] = [&opened.mesh, &self.stage.mesh].map(without_painted);
        if read != shown {
            return Err(fault("the file would give another garment than the one on screen"));
        }
        let saved = opened.layers().recipe_for(self.stage.checks.garment())?;
        // Paths are written relative to the file. The garment is fitted by the same bodies, or it would be another one.
        let edits = if is_recipe(written) { self.edits.clone() } else { with_primvars(&self.edits).0 };
        let asked = self.stage.recipe(&edits)?;
        let BodyOptions { from, to, .. } = saved.fit.clone();
        if saved != (Recipe { fit: BodyOptions { from, to, ..asked.fit.clone() }, ..asked }) {
            return Err(fault("other layers of the file would change the recipe"));
        }
        Ok(())
    }

    fn opinions(&self, file: &Path) -> RecipeOpinions {
        let is_subset = |name: &str| self.stage.checks.garment().subset(name).is_some();
        let mut opinions = RecipeOpinions { variants: self.read.variants.clone(), ..RecipeOpinions::default() };
        let (edits, painted) = with_primvars(&self.edits_beside(file));
        let primvar = |(name, weights)| (format!("primvars:{name}"), OptionValue::Weights(weights));
        opinions.properties.extend(painted.into_iter().map(primvar));
        for (space, fields) in &edits {
            let Value::Object(fields) = fields else { continue };
            let groups = match group_with_instances(space) {
                None => vec![(None, fields)],
                Some(_) => {
                    fields.iter().filter_map(|(name, of)| Some((Some(name.as_str()), of.as_object()?))).collect()
                }
            };
            for (name, fields) in groups {
                let prefix = name.map_or_else(|| space.clone(), |name| format!("{space}.{name}"));
                let properties = properties(&prefix, fields, &is_subset);
                // The schemas declare lists of sets as relationships, which hold no expressions.
                let has_text = properties.iter().any(|(_, value)| matches!(value, OptionValue::Text(_)));
                opinions.schemas.extend(schema(space, name).filter(|_| !has_text));
                opinions.properties.extend(properties);
            }
        }
        opinions
    }
}

/// Edits with the names of primvars in place of painted weights, and these primvars.
fn with_primvars(edits: &Options) -> (Options, Vec<(String, Vec<f32>)>) {
    let mut found = Vec::new();
    let named = |(key, value): (&String, &Value)| (key.clone(), named(value, &format!("{PAINTED}{key}"), &mut found));
    (edits.iter().map(named).collect(), found)
}

/// A value with `name` in place of painted weights, which are moved to `found`.
fn named(value: &Value, name: &str, found: &mut Vec<(String, Vec<f32>)>) -> Value {
    match value {
        Value::Object(fields) => {
            let below = |(key, value): (&String, &Value)| (key.clone(), named(value, &format!("{name}_{key}"), found));
            Value::Object(fields.iter().map(below).collect())
        }
        Value::Array(all) => all.iter().map(|value| named(value, name, found)).collect(),
        _ => value.as_str().and_then(painted_weights).map_or_else(
            || value.clone(),
            |weights| {
                let name = free_name(name, |name| found.iter().any(|(known, _)| known == name));
                found.push((name.clone(), weights));
                Value::String(name)
            },
        ),
    }
}

/// A garment without the weights that a recipe paints.
fn without_painted(garment: &Garment) -> Garment {
    let mut garment = garment.clone();
    garment.primvars.retain(|primvar| !primvar.name.starts_with(PAINTED));
    garment
}

/// True for a text layer with lines of comment.
fn has_comments(file: &Path) -> bool {
    let text = files::text(file).unwrap_or_default();
    text.starts_with("#usda") && text.lines().skip(1).any(|line| line.trim_start().starts_with('#'))
}

/// The API schema of a group of options, such as `TailorSeamAPI:side`.
fn schema(name: &str, instance: Option<&str>) -> Option<String> {
    all().find(|group| group.name == name).map(|group| group.schema(instance))
}

fn is_schema(text: &str) -> bool {
    let class = text.split(':').next().unwrap_or(text);
    all().any(|group| class == group.schema(None))
}

/// Tells the subsets of the garment from expressions.
type IsSubset<'a> = &'a dyn Fn(&str) -> bool;

/// The properties of options below a key, such as `seam.side`.
fn properties(prefix: &str, fields: &Map<String, Value>, is_subset: IsSubset<'_>) -> Vec<(String, OptionValue)> {
    let known = |(field, value): (&String, &Value)| {
        let key = format!("{prefix}.{field}");
        let (group, option) = find(&key)?;
        let typed = typed(option.domain, (group.defaults)().get(field)?, value, is_subset)?;
        Some((format!("tailor:{}", key.replace('.', ":")), typed))
    };
    fields.iter().filter_map(known).collect()
}

fn typed(domain: Domain, default: &Value, value: &Value, is_subset: IsSubset<'_>) -> Option<OptionValue> {
    let names = || {
        let names = value.as_array()?.iter().map(|name| name.as_str().map(str::to_owned));
        names.collect::<Option<Vec<_>>>()
    };
    Some(match domain {
        Domain::Sets { .. } if names()?.iter().all(|name| is_subset(name)) => OptionValue::Subsets(names()?),
        Domain::Sets { .. } | Domain::Prims => OptionValue::Text(names()?.join(", ")),
        Domain::File => OptionValue::Asset(value.as_str()?.to_owned()),
        Domain::Operators | Domain::Words { .. } => OptionValue::Tokens(names()?),
        _ => match default {
            Value::Bool(_) => OptionValue::Bool(value.as_bool()?),
            Value::Number(n) if n.is_f64() => OptionValue::Float(value.as_f64()? as f32),
            Value::Number(_) => OptionValue::Int(value.as_i64()?.try_into().ok()?),
            _ => OptionValue::Token(value.as_str()?.to_owned()),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_has_a_property() {
        for group in all() {
            let defaults = (group.defaults)();
            for key in group.keys {
                let default = &defaults[key.key];
                assert!(typed(key.domain, default, default, &|_| true).is_some(), "{}.{}", group.name, key.key);
            }
        }
    }

    #[test]
    fn schemas_are_those_of_the_options() {
        assert_eq!(schema("seam", Some("left:hip")).as_deref(), Some("TailorSeamAPI:left:hip"));
        assert!(is_schema("TailorSimAPI") && is_schema("TailorFoldAPI:hem") && !is_schema("MaterialBindingAPI"));
    }
}
