//! Inputs are never written over, whatever the path of an output.

use super::Task;
use crate::{Build, usage};
use std::path::{Path, PathBuf};
use tailor_costume::recipe::{RecipeFile, is_recipe};
use tailor_mesh::error::Error;
use tailor_usd::first_used;
use tailor_usd::session::beside;

/// Refuses outputs and a report that are recipes of this build, or files that one of its garments uses. The file that a garment
/// is written to is checked against the garment itself when it is opened.
///
/// # Errors
/// The first such file.
pub fn check(build: &Build, tasks: &[Task]) -> Result<(), Error> {
    let report: Vec<PathBuf> = build.report.iter().cloned().collect();
    let all: Vec<PathBuf> = tasks.iter().map(|task| &task.output).chain(&report).cloned().collect();
    let inputs = tasks.iter().map(|task| &task.input);
    let recipes = inputs.filter(|file| is_recipe(file)).chain(&build.inputs.recipe);
    for recipe in recipes {
        refuse_used(recipe, &all)?;
    }
    for task in tasks {
        let others: Vec<PathBuf> = all.iter().filter(|target| **target != task.output).cloned().collect();
        if let Some(stage) = stage(&task.input) {
            refuse_used(&stage, &others)?;
        }
    }
    Ok(())
}

/// The stage of an input; none where the build will say why it has none.
fn stage(file: &Path) -> Option<PathBuf> {
    if !is_recipe(file) {
        return Some(file.to_path_buf());
    }
    RecipeFile::read(file).ok()?.source.map(|source| beside(file, &source))
}

fn refuse_used(input: &Path, targets: &[PathBuf]) -> Result<(), Error> {
    match first_used(input, targets)? {
        Some(i) => {
            let shown = targets[i].display();
            Err(usage("", format!("{shown} is the input, or a file that the input uses"))
                .code(tailor_usd::codes::OUTPUT_IS_INPUT)
                .remedy("write to another file; the input is never changed"))
        }
        None => Ok(()),
    }
}
