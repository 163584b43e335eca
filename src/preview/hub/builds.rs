//! Builds that pages start: the command itself, in a process of its own, of what is saved.

use super::Hub;
use crate::messages::{BuildMessage, BuildStatus, ServerMessage};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::thread;
use std::{env, io};
use tailor_mesh::error::plain;
use tailor_usd::session::{Input, is_usd};
use tailor_usd::{Selection, garment_below};

/// The file that has what is on screen.
#[derive(Clone, Debug)]
pub struct SavedAs {
    /// The input of a build.
    pub file: PathBuf,
    /// Its `--recipe`.
    recipe: Option<PathBuf>,
    /// Its options as `--set`.
    overrides: Vec<String>,
    /// The variants that it selects.
    pub variants: Vec<Selection>,
}

impl SavedAs {
    /// The files that a preview began with. A layer that the preview wrote is the input itself, as it selects variants.
    pub fn opened(input: &Input) -> Self {
        let Input { file, recipe, overrides, read, .. } = input.clone();
        let over = recipe.clone().filter(|recipe| is_usd(recipe) && garment_below(recipe).as_ref() == Some(&file));
        let (file, recipe) = match over {
            Some(layer) => (layer, None),
            None => (file, recipe),
        };
        Self { file, recipe, overrides, variants: read.variants }
    }

    /// A file that was saved.
    pub fn saved(file: &Path, variants: &[Selection]) -> Self {
        Self { file: file.to_path_buf(), recipe: None, overrides: Vec::new(), variants: variants.to_vec() }
    }

    /// The arguments of a build to `output`.
    fn arguments(&self, input: &Input, output: &str, overwrite: bool) -> Vec<OsString> {
        let mut all: Vec<OsString> = vec!["build".into(), self.file.clone().into(), "-o".into(), output.into()];
        let mut add = |flag: &str, value: Option<OsString>| {
            if let Some(value) = value {
                // With `=`, a value may begin with a dash.
                let mut joined = OsString::from(format!("{flag}="));
                joined.push(value);
                all.push(joined);
            }
        };
        let read = &input.read;
        add("--recipe", self.recipe.clone().map(Into::into));
        // A `.tailor` file names its prim.
        add("--prim", read.prim.clone().filter(|_| is_usd(&self.file)).map(Into::into));
        add("--time", read.time.map(|time| time.to_string().into()));
        add("--sew-tolerance", read.sew_tolerance.map(|share| share.to_string().into()));
        self.overrides.iter().for_each(|assignment| add("--set", Some(assignment.into())));
        all.extend(["--color".into(), "never".into()]);
        all.extend(overwrite.then(|| "--force".into()));
        all
    }
}

impl Hub {
    /// Builds what is saved by the command, unless a build runs. The snapshot has its state.
    pub fn start_build(self: &Arc<Self>, output: &str, overwrite: bool) {
        let Some(arguments) = self.begin_build(output, overwrite) else { return };
        let hub = Arc::clone(self);
        let ended = |output: &str, status, text| BuildMessage { output: output.to_owned(), status, text };
        let of_work = output.to_owned();
        let work = move || {
            let (status, text) = match run(&arguments) {
                Ok(ended) => ended,
                Err(error) => (BuildStatus::Failed, format!("the build cannot run: {}", plain(&error))),
            };
            hub.show_build(&ended(&of_work, status, text));
        };
        if thread::Builder::new().name("build".into()).spawn(work).is_err() {
            self.show_build(&ended(output, BuildStatus::Failed, "the system starts no more threads".into()));
        }
    }

    /// Shows that a build runs, and returns its arguments; none if one runs already or nothing is saved.
    fn begin_build(&self, output: &str, overwrite: bool) -> Option<Vec<OsString>> {
        let mut arguments = None;
        self.change(|shared| {
            if shared.is_building || shared.saved_as().is_none() {
                return;
            }
            arguments = Some(shared.saved.arguments(&shared.input, output, overwrite));
            let message = BuildMessage { output: output.into(), status: BuildStatus::Running, text: String::new() };
            shared.is_building = true;
            shared.tell("build", &ServerMessage::Build(&message));
        });
        arguments
    }

    fn show_build(&self, message: &BuildMessage) {
        self.change(|shared| {
            shared.is_building = false;
            shared.tell("build", &ServerMessage::Build(message));
        });
    }
}

/// Runs this program and returns all that it says.
fn run(arguments: &[OsString]) -> io::Result<(BuildStatus, String)> {
    let ended = Command::new(env::current_exe()?).args(arguments).stdin(Stdio::null()).output()?;
    let status = if ended.status.success() { BuildStatus::Built } else { BuildStatus::Failed };
    let said = [ended.stdout, ended.stderr].map(|text| String::from_utf8_lossy(&text).trim_end().to_owned());
    Ok((status, said.iter().filter(|text| !text.is_empty()).cloned().collect::<Vec<_>>().join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tailor_usd::ReadOptions;

    #[test]
    fn a_build_takes_the_input_as_the_preview_did() {
        let read = ReadOptions { prim: Some("/Coat/model".into()), time: Some(-2.5), ..ReadOptions::default() };
        let input = Input {
            file: "coat.usda".into(),
            recipe: Some("look.tailor".into()),
            overrides: vec!["render.level=1".into()],
            read,
            ..Input::default()
        };
        let words = |saved: &SavedAs, overwrite| -> Vec<String> {
            let all = saved.arguments(&input, "out.usda", overwrite);
            all.iter().map(|word| word.to_string_lossy().into_owned()).collect()
        };
        let opened = words(&SavedAs::opened(&input), false);
        assert_eq!(opened[..4], ["build", "coat.usda", "-o", "out.usda"]);
        assert_eq!(opened[4..8], ["--recipe=look.tailor", "--prim=/Coat/model", "--time=-2.5", "--set=render.level=1"]);
        let saved = words(&SavedAs::saved(Path::new("my.tailor"), &[]), true);
        assert_eq!(
            saved[4..],
            ["--time=-2.5", "--color", "never", "--force"],
            "a .tailor file has its prim and options"
        );
    }
}
