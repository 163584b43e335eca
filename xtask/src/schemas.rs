//! The codeless schemas: `schema.usda` is written by hand, the other two files by OpenUSD's usdGenSchema.

use std::fs;

use crate::process::{self, Failure, Outcome};
use crate::project::Project;
use crate::venv;

const FOLDER: &str = "schemas";

/// The folder is a plugin by itself: the resources are beside plugInfo.json and there is no library.
const PLACES: [(&str, &str); 3] =
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
            return Err(Failure::new(format!("{path}, line {line}: not what {FOLDER}/schema.usda generates"))
                .hint("run cargo xtask schemas"));
        }
    }
    Ok(())
}

fn generate(project: &Project) -> Outcome<[Generated; 2]> {
    let python = venv::ensure(project)?;
    // usdGenSchema merges into a plugInfo.json that it finds: start from nothing.
    let folder = project.scratch("schemas")?;
    let mut command = project.command(python);
    command.args(["-m", "pxr.Usd.usdGenSchema", "schemas/schema.usda"]).arg(&folder);
    process::run_quietly(&mut command)?;
    let read = |name: &'static str| -> Outcome<Generated> {
        let text = fs::read_to_string(folder.join(name))
            .map_err(|error| Failure::new(format!("usdGenSchema made no {name}: {error}")))?;
        Ok(Generated { name, text: tidy(&text) })
    };
    Ok([read("generatedSchema.usda")?, read("plugInfo.json")?])
}

/// Fills in the places and drops the spaces that usdGenSchema leaves at line ends.
fn tidy(text: &str) -> String {
    let filled = PLACES.iter().fold(text.to_owned(), |text, (place, value)| text.replace(place, value));
    let mut lines = filled.trim_end().lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    lines.push('\n');
    lines
}

/// The number of the first line that differs.
fn first_difference(a: &str, b: &str) -> Option<usize> {
    let (mut a, mut b) = (a.lines(), b.lines());
    let mut line = 1;
    loop {
        match (a.next(), b.next()) {
            (None, None) => return None,
            (x, y) if x != y => return Some(line),
            _ => line += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tidy_fills_places_and_trims_lines() {
        assert_eq!(tidy("{ \n  \"Root\": \"@PLUG_INFO_ROOT@\", \n}\n\n"), "{\n  \"Root\": \".\",\n}\n");
    }

    #[test]
    fn first_difference_counts_from_one_and_sees_a_missing_end() {
        assert_eq!(first_difference("a\nb", "a\nb"), None);
        assert_eq!(first_difference("a\nb", "a\nc"), Some(2));
        assert_eq!(first_difference("a", "a\nb"), Some(2));
    }
}
