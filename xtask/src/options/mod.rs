//! What follows from the table of options that `usdtailor options` prints: the schemas, and the tables of docs/options.md.

mod documents;
mod schemas;

use serde::Deserialize;
use serde_json::Value;
use std::fs;

use crate::cargo::Profile;
use crate::process::{Failure, Outcome};
use crate::project::Project;
use crate::text::first_difference;

/// A group of options, such as those of a seam.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Group {
    name: String,
    about: String,
    /// The API schema, such as `TailorSeamAPI`.
    schema: String,
    /// True if a recipe has it for each of several names.
    has_instances: bool,
    options: Vec<Row>,
}

/// An option.
#[derive(Debug, Deserialize)]
struct Row {
    key: String,
    unit: String,
    meaning: String,
    default: Value,
    domain: Domain,
}

/// The part of an option's domain that files show.
#[derive(Debug, Deserialize)]
struct Domain {
    r#type: String,
    #[serde(default)]
    words: Vec<String>,
}

/// A file that follows from the table.
struct Generated {
    path: String,
    text: String,
}

/// Writes all files. The program of tests is built already.
pub fn write(project: &Project) -> Outcome {
    let groups = table(project)?;
    put(project, documents::generate(project, &groups)?)?;
    put(project, schemas::source(&groups))?;
    schemas::generate(project)?.into_iter().try_for_each(|file| put(project, file))
}

/// Compares all files with the table of the program of tests.
pub fn check(project: &Project) -> Outcome {
    let groups = table(project)?;
    compare(project, &documents::generate(project, &groups)?)?;
    compare(project, &schemas::source(&groups))?;
    schemas::generate(project)?.iter().try_for_each(|file| compare(project, file))
}

fn put(project: &Project, Generated { path, text }: Generated) -> Outcome {
    let file = project.root.join(&path);
    fs::write(&file, text).map_err(|error| Failure::new(format!("cannot write {}: {error}", file.display())))?;
    eprintln!("wrote {path}");
    Ok(())
}

fn compare(project: &Project, Generated { path, text }: &Generated) -> Outcome {
    match first_difference(&project.read(path)?, text) {
        None => Ok(()),
        Some(line) => Err(Failure::new(format!("{path}, line {line}: an option has changed"))
            .hint("run cargo xtask options, and read the notes of docs/options.md")),
    }
}

fn table(project: &Project) -> Outcome<Vec<Group>> {
    let program = Profile::Tested.program(project);
    let output = project
        .command(&program)
        .arg("options")
        .output()
        .map_err(|error| Failure::new(format!("cannot run {}: {error}", program.display())))?;
    serde_json::from_slice(&output.stdout)
        .map_err(|error| Failure::new(format!("`usdtailor options` prints no table: {error}")))
}

#[cfg(test)]
fn example() -> Vec<Group> {
    let text = r#"[
        {"name": "a", "about": "About a. More of it.", "schema": "TailorAAPI", "hasInstances": false, "options": [
            {"key": "length", "unit": "mesh units", "meaning": "Length", "default": 0.5, "domain": {"type": "length"}},
            {"key": "sets", "unit": "names", "meaning": "Sets", "default": [], "domain": {"type": "sets"}}]},
        {"name": "b", "about": "About b.", "schema": "TailorBAPI", "hasInstances": true, "options": [
            {"key": "side", "unit": "side", "meaning": "Side", "default": "in",
             "domain": {"type": "choice", "words": ["in", "out"]}}]}]"#;
    serde_json::from_str(text).unwrap()
}
