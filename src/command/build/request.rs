//! The options of a build that shape its output, as its record has them.

use super::super::Build;
use super::super::strict::Strictness;
use super::Task;
use serde::{Deserialize, Serialize};
use std::path::Path;
use tailor_costume::recipe::is_file;
use tailor_mesh::error::Error;
use tailor_usd::{BuildRecord, LodSchema, SetChoice};

/// The options that shape an output. The record identifies the input files by their contents as well.
#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Request {
    /// Path of the input from the folder of the output.
    pub input: String,
    /// Path of the file of `--recipe` from there.
    pub recipe: Option<String>,
    pub prim: Option<String>,
    pub time: Option<f64>,
    pub set: Vec<String>,
    flatten: bool,
    names: [String; 2],
    keep_model_purpose: bool,
    pub max_faces: Option<usize>,
    render_per_panel: bool,
    sim_only: bool,
    mark: bool,
    #[serde(flatten)]
    strictness: Strictness,
    sets: SetChoice,
    #[serde(skip_serializing_if = "is_default")]
    lod_schema: LodSchema,
    pub variants: Option<String>,
    pub all: bool,
    pub exclude: Vec<String>,
    pub sew_tolerance: Option<f64>,
}

/// An option as `key=value`; one that is the path of a file has another path to it.
fn anchored(set: &str, path: impl Fn(&Path) -> Result<String, Error>) -> Result<String, Error> {
    match set.split_once('=') {
        Some((key, file)) if is_file(key.trim()) && !file.trim().is_empty() => {
            Ok(format!("{key}={}", path(Path::new(file.trim()))?))
        }
        _ => Ok(set.to_owned()),
    }
}

fn is_default(schema: &LodSchema) -> bool {
    *schema == LodSchema::default()
}

impl Request {
    /// The options of one task of a build.
    ///
    /// # Errors
    /// A path that has no form as text.
    pub fn of(build: &Build, task: &Task) -> Result<Self, Error> {
        let inputs = &build.inputs;
        let path = |file: &Path| BuildRecord::path_of(file, &task.output);
        Ok(Self {
            input: path(&task.input)?,
            recipe: inputs.recipe.as_deref().map(path).transpose()?,
            prim: inputs.prim.clone(),
            time: inputs.time,
            set: inputs.input(&task.input).overrides.iter().map(|set| anchored(set, path)).collect::<Result<_, _>>()?,
            flatten: build.flatten,
            names: [build.sim_name.clone(), build.render_name.clone()],
            keep_model_purpose: build.keep_model_purpose,
            max_faces: Some(build.max_faces),
            render_per_panel: build.render_per_panel,
            sim_only: build.sim_only,
            mark: build.mark,
            strictness: build.strictness.clone(),
            sets: build.sets,
            lod_schema: build.lod_schema,
            variants: build.variants.clone(),
            all: inputs.several.all,
            exclude: inputs.several.exclude.clone(),
            sew_tolerance: inputs.several.sew_tolerance,
        })
    }

    /// The record of the output of a task, if it was made by this program of these files with these options.
    pub fn fresh(build: &Build, task: &Task) -> Option<BuildRecord> {
        BuildRecord::fresh(&task.output, &Self::of(build, task).ok()?.text())
    }

    /// The options as `key=value`, for a command that runs anywhere; `output` has the request.
    pub fn overrides(&self, output: &Path) -> Result<Vec<String>, Error> {
        let path = |file: &Path| {
            BuildRecord::file_of(&file.to_string_lossy(), output).map(|file| file.to_string_lossy().into_owned())
        };
        self.set.iter().map(|set| anchored(set, path)).collect()
    }

    /// As text, equal for equal requests.
    pub fn text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    /// The input and the options as on the command line.
    pub fn in_words(&self) -> String {
        let one = |flag: &str, value: Option<String>| value.map(|value| format!("--{flag} {value}"));
        let flag = |flag: &str, is_set: bool| is_set.then(|| format!("--{flag}"));
        let mut words = vec![self.input.clone()];
        words.extend(one("recipe", self.recipe.clone()));
        words.extend(one("prim", self.prim.clone()));
        words.extend(one("time", self.time.map(|time| time.to_string())));
        words.extend(flag("all", self.all));
        words.extend(self.exclude.iter().map(|pattern| format!("--exclude {pattern}")));
        words.extend(one("sew-tolerance", self.sew_tolerance.map(|share| share.to_string())));
        words.extend(one("variants", self.variants.clone()));
        words.extend(flag("render-per-panel", self.render_per_panel));
        words.extend(flag("sim-only", self.sim_only));
        words.extend(self.set.iter().map(|option| format!("--set {option}")));
        words.join(" ")
    }
}
