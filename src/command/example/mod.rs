//! `usdtailor example`: the shipped garments, for a tutorial without a clone.

use super::{Output, usage};
use clap::Args;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use tailor_mesh::error::{Error, plain};
use tailor_mesh::files::folder_of;
use tailor_mesh::options::did_you_mean;
use tailor_usd::write_whole;

#[derive(Args)]
pub struct Example {
    /// The example to write [default: list all]
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// The folder to write it into, which is made if it is missing
    #[arg(short, long, value_name = "FOLDER", default_value = ".")]
    output: PathBuf,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
}

/// Files that are written together, the first of which is used.
struct ExampleFiles {
    name: &'static str,
    about: &'static str,
    /// Paths in the folder, with the content.
    files: &'static [(&'static str, &'static str)],
}

/// A file of `examples/`.
macro_rules! file {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../examples/", $name)))
    };
}

const ALL: [ExampleFiles; 4] = [
    ExampleFiles {
        name: "tshirt",
        about: "a shirt, and a recipe with a seam and a folded neckband",
        files: &[file!("tshirt.tailor"), file!("tshirt.usda")],
    },
    ExampleFiles {
        name: "trousers",
        about: "trousers, and a recipe with seams and a folded waistband",
        files: &[file!("trousers.tailor"), file!("trousers.usda")],
    },
    ExampleFiles {
        name: "coat",
        about: "a coat, and a layer over it with nine seams and four folds",
        files: &[file!("sewn/coat.usda"), file!("coat.usda")],
    },
    ExampleFiles {
        name: "picture",
        about: "Python scripts that draw what a build wrote (with usd-core, numpy and pillow)",
        files: &[file!("picture.py"), file!("draw.py"), file!("meshes.py")],
    },
];

/// Writes an example, or lists all.
pub fn run(args: &Example) -> Result<Output, Error> {
    let text = match &args.name {
        Some(name) => written(find(name)?, &args.output, args.force)?,
        None => list(),
    };
    Ok(Output { text, code: 0 })
}

fn find(name: &str) -> Result<&'static ExampleFiles, Error> {
    ALL.iter().find(|example| example.name == name).ok_or_else(|| {
        let names = ALL.each_ref().map(|example| example.name);
        let remedy = format!("{}the examples are: {}", did_you_mean(name, &names), names.join(", "));
        usage("", format!("there is no example \"{name}\"")).remedy(remedy)
    })
}

fn list() -> String {
    let width = ALL.iter().map(|example| example.name.len()).max().unwrap_or(0);
    let line = |example: &ExampleFiles| format!("{:width$}  {}\n", example.name, example.about);
    ALL.iter().map(line).collect()
}

/// Writes the files into a folder, and tells them.
fn written(example: &ExampleFiles, folder: &Path, force: bool) -> Result<String, Error> {
    // All are checked before the first is written.
    let has_other = |(name, content): &&(&str, &str)| {
        let there = fs::read(folder.join(name));
        !force && there.map_or_else(|e| e.kind() != io::ErrorKind::NotFound, |there| there != content.as_bytes())
    };
    if let Some((name, _)) = example.files.iter().find(has_other) {
        let text = format!("{} exists already, and is another file", folder.join(name).display());
        let fault = usage("", text).code(tailor_usd::codes::OUTPUT_EXISTS);
        return Err(fault.remedy("use --force to overwrite it, or -o to name another folder"));
    }
    if let Some((name, _)) = example.files.iter().find(|(name, _)| folder.join(name).is_symlink()) {
        let fault = usage("", format!("{} is a link to another file", folder.join(name).display()));
        return Err(fault.code(tailor_usd::codes::OUTPUT_PATH).remedy("remove the link, or name another folder by -o"));
    }
    let mut text = String::new();
    for (name, content) in example.files {
        let file = folder.join(name);
        let write = || fs::create_dir_all(folder_of(&file)).and_then(|()| write_whole(&file, content.as_bytes(), true));
        write().map_err(|e| {
            let fault = usage("", format!("cannot write {}: {}", file.display(), plain(&e)));
            fault.code(tailor_usd::codes::WRITE_FAILED).remedy("name a folder by -o that you may write to").caused_by(e)
        })?;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", file.strip_prefix(".").unwrap_or(&file).display());
    }
    Ok(text)
}
