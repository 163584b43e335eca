//! Generates the codeless schemas: OpenUSD's usdGenSchema writes two files from the hand-written `schema.usda`.

use std::fs;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::text::first_difference;
use crate::venv;

const FOLDER: &str = "schemas";

/// Values of usdGenSchema's placeholders: the resources are beside plugInfo.json, and there is no library.
const PLACEHOLDERS: [(&str, &str); 3] =
    [("@PLUG_INFO_LIBRARY_PATH@", ""), ("@PLUG_INFO_RESOURCE_PATH@", "."), ("@PLUG_INFO_ROOT@", ".")];

struct Generated {
    name: &'static str,
    text: String,
}

pub fn write(project: &Project) -> Outcome {
    for file in generate(project)? {
        let path = project.root.join(FOLDER).join(file.name);
        fs::write(&path, file.text)
            .map_err(|error| Failure::new(format!("cannot write {}: {error}", path.display())))?;
        eprintln!("wrote {FOLDER}/{}", file.name);
    }
    Ok(())
}

pub fn check(project: &Project) -> Outcome {
    for file in generate(project)? {
        let path = format!("{FOLDER}/{}", file.name);
        let present = project.read(&path)?;
        if let Some(line) = first_difference(&present, &file.text) {
            return Err(Failure::new(format!("{path}, line {line}: differs from the output of {FOLDER}/schema.usda"))
                .hint("run cargo xtask schemas"));
        }
    }
    Ok(())
}

fn generate(project: &Project) -> Outcome<[Generated; 2]> {
    let python = venv::ensure(project)?;
    // usdGenSchema merges into an existing plugInfo.json, so the folder must be empty.
    let folder = project.scratch("schemas")?;
    let mut command = project.command(python);
    command.args(["-m", "pxr.Usd.usdGenSchema", "schemas/schema.usda"]).arg(&folder);
    process::run_quietly(&mut command)?;
    let read = |name: &'static str| -> Outcome<Generated> {
        let text = fs::read_to_string(folder.join(name))
            .map_err(|error| Failure::new(format!("usdGenSchema wrote no {name}: {error}")))?;
        Ok(Generated { name, text: tidy(&text) })
    };
    Ok([read("generatedSchema.usda")?, read("plugInfo.json")?])
}

/// Replaces the placeholders and removes trailing spaces.
fn tidy(text: &str) -> String {
    let filled = PLACEHOLDERS.iter().fold(text.to_owned(), |text, (name, value)| text.replace(name, value));
    let mut lines = filled.trim_end().lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    lines.push('\n');
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tidy_fills_places_and_trims_lines() {
        assert_eq!(tidy("{ \n  \"Root\": \"@PLUG_INFO_ROOT@\", \n}\n\n"), "{\n  \"Root\": \".\",\n}\n");
    }
}
