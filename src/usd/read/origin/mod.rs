//! Opening a stage, from a file or from memory.

mod composition;
mod content;
mod converted;
mod dependencies;
mod letters;
mod resolver;
mod text;

pub use content::ReadFiles;
pub use converted::{Converter, Foreign, Rewritten, set_converter};
pub use dependencies::{first_used, without_arguments};
pub use resolver::{Files, package_file};

use super::variants::{SESSION, Selection, session_layer};
use crate::assets::as_named;
use crate::codes;
use content::CHANGED;
use converted::{lacking, unread};
use openusd::usd::Stage;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor_mesh::error::{Error, plain};
use tailor_mesh::files::{folder_of, read, require_file};
use tailor_mesh::options::did_you_mean;

/// The file or bytes from which a stage is opened.
#[derive(Clone, Debug)]
pub struct StageOrigin {
    /// The file, or the source of `content`.
    pub file: PathBuf,
    /// A layer in memory, opened instead of the file.
    pub content: Option<Arc<[u8]>>,
    /// Variants that are selected over those of the stage.
    pub variants: Vec<Selection>,
    /// The content of each file, as it was first read.
    pub read: Arc<ReadFiles>,
}

impl StageOrigin {
    /// A file, or `content` that was flattened from it.
    pub fn new(file: &Path, content: Option<Arc<[u8]>>, variants: &[Selection]) -> Self {
        Self { file: file.to_path_buf(), content, variants: variants.to_vec(), read: Arc::default() }
    }

    /// Opens the stage.
    ///
    /// # Errors
    /// A file that is missing, a folder, empty or not USD.
    pub fn open(&self) -> Result<Stage, Error> {
        match &self.content {
            Some(content) => open_content(&self.file, content),
            None => self
                .until_read(|| {
                    let opened = open_file(&self.file, &self.variants, &self.read);
                    let fault = opened.as_ref().map_or_else(unread, lacking);
                    (opened, fault)
                })
                .or_else(|e| self.check_unchanged().and(Err(e))),
        }
    }

    /// The result of a step. While it has a fault of what the library cannot read, layers are converted, then the stage is flattened, and
    /// the step is done again. The first error stays where that does not help.
    fn until_read<T>(&self, step: impl Fn() -> (Result<T, Error>, Option<String>)) -> Result<T, Error> {
        let (mut found, mut fault) = step();
        while let Some(words) = fault.take().filter(|_| self.content.is_none()) {
            let Ok(file) = as_named(&self.file) else { break };
            if !self.read.convert(&file, words) {
                break;
            }
            let (next, next_fault) = step();
            fault = next_fault;
            found = next.or(found);
        }
        found.map_err(|e| match self.read.ended() {
            Some(ended) => e.remedy(format!("{ended}: write it again by `usdcat -o`, or `usdcat --flatten -o`")),
            None => e,
        })
    }

    /// The result of `read` on the stage. Where layers turn out to be unreadable as prims are composed, or by the `fault` of a result,
    /// they are converted, and the stage is opened and read again.
    ///
    /// # Errors
    /// As [`StageOrigin::open`], and those of `read`.
    pub fn with_stage<T>(
        &self,
        read: impl Fn(&Stage) -> Result<T, Error>,
        fault: impl Fn(&T) -> Option<&Error>,
    ) -> Result<T, Error> {
        self.until_read(|| match self.open() {
            Ok(stage) => {
                let found = read(&stage);
                let fault = found.as_ref().map_or_else(Some, &fault).and_then(unread).or_else(|| lacking(&stage));
                (found, fault)
            }
            Err(e) => (Err(e), None),
        })
    }

    /// Refuses files that had another content when they were read again.
    ///
    /// # Errors
    /// The first of them.
    pub fn check_unchanged(&self) -> Result<(), Error> {
        match self.read.changed() {
            Some(file) => Err(Error::usd(format!("cannot read {}: {CHANGED}", file.display()))
                .code(codes::UNREADABLE_FILE)
                .remedy("run again when the program that writes it has ended")),
            None => Ok(()),
        }
    }
}

/// Signs in the library's words of what only newer versions of USD have: edits of arrays, splines, later crates.
const NEWER: [&str; 3] = ["= edit [", "field \"spline\"", "version mismatch"];

/// The version of a crate from before 0.4.0.
fn obsolete_crate(content: &[u8]) -> Option<String> {
    let version = content.strip_prefix(b"PXR-USDC")?.get(..3)?;
    (version < [0, 4, 0].as_slice()).then(|| format!("{}.{}.{}", version[0], version[1], version[2]))
}

/// Identifier of the layer in memory. It names no file, so that relative paths are not resolved.
const IN_MEMORY: &str = "composed.usd";
/// Files of a folder that are looked at for a name.
const MOST_NAMES: usize = 10_000;

fn open_content(file: &Path, content: &Arc<[u8]>) -> Result<Stage, Error> {
    Stage::builder().resolver(Files::default().with_layer(IN_MEMORY, content)).open(IN_MEMORY).map_err(|e| {
        let words = e.to_string();
        Error::usd(format!("{} cannot be read once composed: {}", file.display(), words.trim_start_matches("error: ")))
            .code(codes::COMPOSITION_FAILED)
            .remedy("flatten it with another program and name the result instead")
    })
}

fn open_file(file: &Path, variants: &[Selection], read_files: &Arc<ReadFiles>) -> Result<Stage, Error> {
    let shown = file.display();
    let refused = |text: String, remedy: &str| Error::usd(text).code(codes::UNREADABLE_FILE).remedy(remedy);
    let unreadable = |e: io::Error| {
        let likely = if e.kind() == io::ErrorKind::NotFound { likely_name(file) } else { String::new() };
        let remedy = format!("{likely}check the path, and who may read the file");
        refused(format!("cannot read {shown}: {}", plain(&e)), &remedy)
    };
    if file.is_dir() {
        return Err(refused(format!("{shown} is a folder, not a USD file"), "name a file inside it"));
    }
    require_file(file).map_err(unreadable)?;
    // It is opened, as a file that nobody may read is not damaged.
    if fs::File::open(file).and_then(|file| file.metadata()).map_err(unreadable)?.len() == 0 {
        return Err(refused(format!("{shown} is empty"), "export the garment again"));
    }
    let extension = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if !["usd", "usda", "usdc", "usdz"].contains(&extension.as_str()) {
        let text = format!("{shown} is not a USD file: its name does not end in .usd, .usda, .usdc or .usdz");
        return Err(refused(text, "export the garment as USD"));
    }
    if file.to_str().is_none() {
        return Err(refused(format!("cannot read {shown}: its name is not UTF-8"), "rename the file"));
    }
    // The file that the system finds, whatever the text of its path would be without links.
    let path = as_named(file)?;
    composition::check_arcs(&path, read_files)?;
    let builder = Stage::builder();
    let builder = match variants {
        [] => builder.resolver(Files::of(read_files)),
        variants => {
            let text = session_layer(variants)?.into_bytes();
            builder.resolver(Files::of(read_files).with_layer(SESSION, &text.into())).session_layer(SESSION)
        }
    };
    builder.open(&path).map_err(|e| not_usd(file, &e.to_string()))
}

/// The start of a remedy that names the file whose name is nearest to one that is not there.
fn likely_name(file: &Path) -> String {
    let is_alike = |path: &PathBuf| path.extension() == file.extension();
    let there =
        fs::read_dir(folder_of(file)).into_iter().flatten().take(MOST_NAMES).flatten().map(|entry| entry.path());
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let names: Vec<String> = there.filter(is_alike).map(|path| name(&path)).collect();
    did_you_mean(&name(file), &names)
}

/// The error of a file that the library cannot read, in its words.
fn not_usd(file: &Path, words: &str) -> Error {
    let words = words.trim_start_matches("error: ").trim_end();
    let fault = Error::usd(format!("{} cannot be read as USD: {words}", file.display()));
    let unsupported = |remedy: &str| fault.clone().code(codes::NOT_SUPPORTED).remedy(remedy);
    let content = read(file).unwrap_or_default();
    if content.starts_with("\u{feff}".as_bytes()) {
        fault.remedy("it begins with a byte order mark, which USD does not have; save it as UTF-8 without one")
    } else if let Some(version) = obsolete_crate(&content) {
        unsupported(&format!(
            "it is a crate of version {version}, and versions before 0.4.0 are not read; convert it by the usdcat of an old OpenUSD"
        ))
    } else if words.contains(text::TOO_MANY) {
        fault
            .code(tailor::codes::TOO_LARGE)
            .remedy("save it as a crate, for example by `usdcat in.usda -o in.usdc`: this text takes too long to read")
    } else if NEWER.iter().any(|sign| words.contains(sign)) {
        unsupported("it has values of a newer version of USD; write it without them, for example by `usdcat --flatten`")
    } else {
        fault.remedy("the file is damaged, or is another format under this name; export it again")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_program_that_was_ended_is_told_and_not_started_again() {
        static STARTED: AtomicUsize = AtomicUsize::new(0);
        set_converter(|foreign| {
            let is_here = foreign.path.ends_with("slow.usda");
            STARTED.fetch_add(usize::from(is_here), Ordering::Relaxed);
            if is_here { Err(format!("it was ended for {}", foreign.path)) } else { Ok(None) }
        });
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("slow.usda");
        fs::write(&file, "#usda 1.0\n(((").expect("a file");
        let error = StageOrigin::new(&file, None, &[]).open().expect_err("it is damaged");
        assert_eq!(error.faults[0].code, tailor_mesh::codes::DAMAGED_FILE);
        assert!(error.faults[0].remedy.starts_with("it was ended for "), "{error}");
        assert_eq!(STARTED.load(Ordering::Relaxed), 1);
    }
}
