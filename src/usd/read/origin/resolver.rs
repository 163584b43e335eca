//! Finding and opening the files of a stage.

use super::content::ReadFiles;
use super::converted::is_layer;
use super::text::{Readable, Refused, readable};
use crate::assets::{BY_CONTENT, file_path, normalized, same_file};
use openusd::ar::{self, DefaultResolver, ResolvedPath, Resolver};
use openusd::sdf::FileFormat;
use openusd::usdc::{CrateData, CrateFile, CrateWriter};
use openusd::usdz::UsdzFileFormat;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tailor_mesh::files::{read, require_file, require_memory};

/// Begin of a layer that is text.
const TEXT: &[u8] = b"#usda";
/// Levels of braces in a text. Reading takes memory that grows with the square of the levels of prims.
const MAX_LEVELS: usize = 1000;

/// Kinds of values in a crate, `string`, `asset` and `pathExpression`, and the mark of a list of them.
const LISTS: [u8; 3] = [10, 12, 57];
const ARRAY: u8 = 0x80;
/// The place of unused bytes in the header of a crate, which are 0.
const NO_LENGTH: usize = 24;

/// Whether the bytes of a layer are text.
fn is_text(bytes: &[u8]) -> bool {
    bytes.starts_with(TEXT)
}

/// The bytes of a layer in a form that the library reads. `leave_out` hears of the metadata that it has no more.
///
/// # Errors
/// A text of too many levels, with what OpenUSD refuses, or with letters beyond ASCII that cannot be parsed.
fn readable_layer(bytes: Vec<u8>, leave_out: impl Fn(Vec<&'static str>)) -> io::Result<ar::AssetBuffer> {
    if !is_text(&bytes) {
        return Ok(with_empty_lists(bytes));
    }
    check_levels(&bytes)?;
    let mut readable = readable(&bytes);
    leave_out(std::mem::take(&mut readable.left_out));
    Ok(ar::AssetBuffer::Owned(match readable {
        Readable { refused: Some(Refused { line, what }), .. } => {
            return Err(io::Error::other(format!("line {line} has {what}")));
        }
        Readable { text, letters: Some(letters), .. } => letters.encode(&text)?,
        Readable { text: Cow::Owned(text), .. } => text,
        Readable { text: Cow::Borrowed(_), .. } => bytes,
    }))
}

/// A crate with a place for its empty lists of texts. OpenUSD gives them the place 0, where the library reads the first bytes of the
/// file as their length.
///
/// A value in a dictionary is the number of bytes up to its reference, and this reference: a kind and a place. As numbers, these
/// 16 bytes of an empty list are 8 and one that no garment has. References of fields are packed, so that a crate with such a
/// field is written anew by the library.
fn with_empty_lists(mut bytes: Vec<u8>) -> ar::AssetBuffer {
    if bytes.get(NO_LENGTH..NO_LENGTH + 8) != Some(&[0; 8]) {
        return ar::AssetBuffer::Owned(bytes);
    }
    let is_empty_list = |at: &[u8]| at[0] == 8 && at[1..14] == [0; 13] && LISTS.contains(&at[14]);
    for last in 15..bytes.len() {
        if bytes[last] == ARRAY && is_empty_list(&bytes[last - 15..last]) {
            bytes[last - 7] = NO_LENGTH as u8;
        }
    }
    let bytes = ar::AssetBuffer::Owned(bytes).into_shared();
    // A crate that cannot be read or written is left to be opened, which tells the fault.
    let written = CrateFile::open(bytes.clone()).ok().and_then(with_empty_fields);
    written.map_or(ar::AssetBuffer::Shared(bytes), ar::AssetBuffer::Owned)
}

/// A crate whose fields have empty lists of texts, written anew. None of other crates.
fn with_empty_fields(mut file: CrateFile) -> Option<Vec<u8>> {
    let is_empty_list = |rep: u64| LISTS.iter().any(|&kind| rep == u64::from_be_bytes([ARRAY, kind, 0, 0, 0, 0, 0, 0]));
    let reps = file.fields.iter_mut().map(|field| &mut field.value_rep.0).filter(|rep| is_empty_list(**rep));
    if reps.map(|rep| *rep |= NO_LENGTH as u64).count() == 0 {
        return None;
    }
    let mut written = Cursor::new(Vec::new());
    CrateWriter::write(&CrateData::from_file(file, true).ok()?, &mut written).ok()?;
    Some(written.into_inner())
}

/// Finds files where OpenUSD finds them, and opens regular files only.
///
/// [`DefaultResolver`] names a file by its path without links. OpenUSD keeps links, so that a layer which is opened through
/// a link has its neighbours beside the link.
#[derive(Default)]
pub struct Files {
    resolver: DefaultResolver,
    read: Arc<ReadFiles>,
    /// Whether each text layer that was found has letters beyond ASCII in its words.
    has_letters: RefCell<HashMap<String, bool>>,
    /// The last text that was read to find out, so that it is not read again to be opened.
    ahead: RefCell<Option<(PathBuf, Vec<u8>)>>,
    /// The identifier of a layer in memory, and its content.
    in_memory: Option<(&'static str, Arc<[u8]>)>,
}

impl Files {
    /// Reads the same content of each file as all others with this `read`.
    pub fn of(read: &Arc<ReadFiles>) -> Self {
        Self { read: Arc::clone(read), ..Self::default() }
    }

    /// Finds a layer in memory too.
    pub fn with_layer(self, identifier: &'static str, content: &Arc<[u8]>) -> Self {
        Self { in_memory: Some((identifier, Arc::clone(content))), ..self }
    }

    /// The content of a layer in memory.
    fn layer(&self, identifier: &Path) -> Option<&Arc<[u8]>> {
        self.in_memory.as_ref().filter(|(own, _)| Path::new(own) == identifier).map(|(_, content)| content)
    }

    /// The path of a file or of an entry of a package.
    fn find(&self, asset_path: &str) -> Option<ResolvedPath> {
        // A package is opened here already, to see what is in it.
        if asset_path.ends_with(']') {
            return require_file(&package_file(Path::new(asset_path)))
                .ok()
                .and_then(|()| self.resolver.resolve(asset_path));
        }
        let found = self.resolver.resolve(asset_path)?;
        let named = normalized(&std::path::absolute(asset_path).ok()?);
        Some(if same_file(&named, &found) { ResolvedPath::new(named) } else { found })
    }

    /// The path of a layer that is converted, or of a text with letters beyond ASCII in its words, under which it may be handed over
    /// as a crate. None of other layers. For a package, it is that of its first layer.
    fn by_content(&self, found: &ResolvedPath) -> Option<ResolvedPath> {
        if self.read.flattened(found).is_some() {
            return Some(ResolvedPath::new(format!("{}{BY_CONTENT}", found.to_str()?)));
        }
        let layer = if ends_with(found, ".usdz") {
            require_memory(&package_file(found)).ok()?;
            UsdzFileFormat.resolve_layer(&self.resolver, found)?
        } else {
            found.clone()
        };
        let path = layer.to_str().filter(|_| is_layer(&layer))?;
        let is_crate =
            self.read.converted(&layer).is_some() || ends_with(&layer, ".usda") && self.has_letters(path, &layer);
        let (path, brackets) = path.split_at(path.trim_end_matches(']').len());
        is_crate.then(|| ResolvedPath::new(format!("{path}{BY_CONTENT}{brackets}")))
    }

    fn has_letters(&self, path: &str, layer: &ResolvedPath) -> bool {
        let known = self.has_letters.borrow().get(path).copied();
        let has_letters = known.unwrap_or_else(|| self.reads_letters(layer));
        self.has_letters.borrow_mut().insert(path.to_owned(), has_letters);
        has_letters
    }

    fn read_file(&self, file: &Path) -> io::Result<Vec<u8>> {
        match self.ahead.take() {
            Some((ahead, bytes)) if ahead == file => self.read.keep(file, bytes),
            _ => self.read.read(file),
        }
    }

    /// Whether a text layer has letters beyond ASCII in its words.
    fn reads_letters(&self, layer: &ResolvedPath) -> bool {
        let is_file = package_file(layer) == **layer;
        let bytes =
            if is_file { read(layer) } else { self.resolver.open_asset(layer).and_then(|mut asset| asset.read_all()) };
        let Ok(text) = bytes else { return false };
        let has_letters = is_text(&text) && !text.is_ascii() && readable(&text).letters.is_some();
        if is_file {
            *self.ahead.borrow_mut() = Some((layer.to_path_buf(), text));
        }
        has_letters
    }
}

/// Whether a path, or the entry of a package that it names, ends with an extension.
fn ends_with(path: &Path, extension: &str) -> bool {
    path.to_str().is_some_and(|path| path.trim_end_matches(']').to_ascii_lowercase().ends_with(extension))
}

impl Resolver for Files {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        if self.layer(Path::new(asset_path)).is_some() {
            return asset_path.to_owned();
        }
        let found = self.resolver.create_identifier(asset_path, anchor);
        as_written(asset_path, anchor).filter(|path| Path::new(path).exists()).unwrap_or(found)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        if self.layer(Path::new(asset_path)).is_some() {
            return Some(ResolvedPath::new(asset_path));
        }
        let found = self.find(asset_path)?;
        Some(self.by_content(&found).unwrap_or(found))
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.resolver.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn ar::Asset>> {
        if let Some(content) = self.layer(resolved_path) {
            // The content of a crate is shared.
            return Ok(shared(match is_text(content) {
                true => readable_layer(content.to_vec(), |_| ())?,
                false => ar::AssetBuffer::from(Arc::clone(content)),
            }));
        }
        let resolved_path = &match resolved_path.to_str() {
            Some(path) if path.contains(BY_CONTENT) => ResolvedPath::new(file_path(path)),
            _ => resolved_path.clone(),
        };
        let package = package_file(resolved_path);
        if let Some(content) = self.read.flattened(resolved_path) {
            // As for layers below.
            self.read_file(&package)?;
            return Ok(shared(ar::AssetBuffer::from(content)));
        }
        let is_packed = package != **resolved_path;
        if is_packed || ends_with(&package, ".usdz") {
            // It is read whole.
            require_memory(&package)?;
            self.read.package(&package)?;
        }
        if ends_with(resolved_path, ".usdz") {
            return self.resolver.open_asset(resolved_path);
        }
        if let Some(content) = self.read.converted(resolved_path).filter(|_| is_layer(resolved_path)) {
            if !is_packed {
                // Its own content is what an output is made of.
                self.read_file(&package)?;
            }
            return Ok(shared(ar::AssetBuffer::from(content)));
        }
        let bytes =
            if is_packed { self.resolver.open_asset(resolved_path)?.read_all()? } else { self.read_file(&package)? };
        Ok(shared(readable_layer(bytes, |fields| self.read.leave_out(resolved_path, fields))?))
    }

    fn is_context_dependent_path(&self, asset_path: &str) -> bool {
        self.resolver.is_context_dependent_path(asset_path)
    }

    fn in_memory_identifier<'a>(&self, asset_path: &'a str) -> Cow<'a, str> {
        self.resolver.in_memory_identifier(asset_path)
    }

    fn identity(&self) -> String {
        self.resolver.identity()
    }

    fn cache_id(&self) -> Option<u64> {
        self.resolver.cache_id()
    }
}

fn shared(content: ar::AssetBuffer) -> Box<dyn ar::Asset> {
    Box::new(Cursor::new(ar::AssetBuffer::Shared(content.into_shared())))
}

/// Refuses a text of too many levels of braces.
fn check_levels(text: &[u8]) -> io::Result<()> {
    let mut level = 0_usize;
    for byte in text {
        match byte {
            b'{' => level += 1,
            b'}' => level = level.saturating_sub(1),
            _ => {}
        }
        if level > MAX_LEVELS {
            return Err(io::Error::other(format!("it is nested in more than {MAX_LEVELS} levels of braces")));
        }
    }
    Ok(())
}

/// The file of a path, which is the package for a path into one.
pub fn package_file(path: &Path) -> PathBuf {
    let Some(text) = path.to_str() else { return path.to_path_buf() };
    match text.strip_suffix(']').and_then(|path| path.split_once('[')) {
        Some((package, _)) => PathBuf::from(package),
        None => PathBuf::from(file_path(text)),
    }
}

/// The path that an asset path in the layer `anchor` is by its text; none in and into packages.
fn as_written(asset_path: &str, anchor: Option<&ResolvedPath>) -> Option<String> {
    let anchor = anchor.and_then(|anchor| anchor.to_str());
    let is_packed = |path: &str| path.ends_with(']') || path.to_ascii_lowercase().ends_with(".usdz");
    if asset_path.is_empty() || asset_path.ends_with(']') || anchor.is_some_and(is_packed) {
        return None;
    }
    // Separators of Windows in relative paths are read everywhere.
    let path = if Path::new(asset_path).is_absolute() { asset_path.to_owned() } else { asset_path.replace('\\', "/") };
    let path = match anchor.and_then(|anchor| Path::new(anchor).parent()) {
        Some(folder) => folder.join(path),
        None => std::path::absolute(path).ok()?,
    };
    normalized(&path).to_str().map(str::to_owned)
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn neighbours_of_a_link_are_beside_the_link() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().canonicalize().expect("it is there").join(name);
        for name in ["real", "shown"] {
            fs::create_dir(at(name)).expect("a folder");
            fs::write(at(name).join("layer.usda"), name).expect("a file");
        }
        fs::write(at("real/top.usda"), "#usda 1.0\n").expect("a file");
        symlink("../real/top.usda", at("shown/top.usda")).expect("a link");
        let files = Files::default();
        let top = files.resolve(at("shown/top.usda").to_str().expect("text")).expect("it is there");
        assert_eq!(&*top, at("shown/top.usda"));
        for path in ["./layer.usda", "layer.usda", "../shown/layer.usda"] {
            assert_eq!(Path::new(&files.create_identifier(path, Some(&top))), at("shown/layer.usda"), "{path}");
        }
    }

    #[test]
    fn levels_are_bounded() {
        let nested = |levels: usize| "{".repeat(levels) + &"}".repeat(levels) + "{}";
        assert!(check_levels(nested(MAX_LEVELS).as_bytes()).is_ok());
        assert!(check_levels(nested(MAX_LEVELS + 1).as_bytes()).is_err());
    }

    #[test]
    fn devices_are_not_opened() {
        let files = Files::default();
        assert!(files.open_asset(&ResolvedPath::new("/dev/zero")).is_err());
        assert!(files.resolve("/dev/zero[a.usda]").is_none());
    }
}
