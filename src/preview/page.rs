//! The page, which `cargo xtask page` bundles and `build.rs` embeds.

use std::borrow::Cow;

use crate::codes;
use tailor_mesh::error::{Error, ErrorKind};

/// A file of the page.
pub struct File {
    /// Its name in the address.
    pub name: &'static str,
    /// Its media type.
    pub media_type: &'static str,
    /// Its content.
    pub content: &'static [u8],
}

impl File {
    /// The content that is sent: the embedded one. In a debug build, the file in the folder that `USDTAILOR_PAGE` names comes
    /// first, so that an edit of the page needs no build of the program.
    pub fn sent(&self) -> Cow<'static, [u8]> {
        let folder = if cfg!(debug_assertions) { std::env::var_os("USDTAILOR_PAGE") } else { None };
        let edited = folder.and_then(|folder| std::fs::read(std::path::Path::new(&folder).join(self.name)).ok());
        edited.map_or(Cow::Borrowed(self.content), Cow::Owned)
    }
}

macro_rules! file {
    ($name:literal, $media_type:literal) => {
        File {
            name: $name,
            media_type: $media_type,
            content: include_bytes!(concat!(env!("OUT_DIR"), "/page/", $name)),
        }
    };
}

/// All files. They are empty in a program that was built without the page.
pub static FILES: [File; 3] = [
    file!("index.html", "text/html; charset=utf-8"),
    file!("page.js", "text/javascript; charset=utf-8"),
    file!("page.css", "text/css; charset=utf-8"),
];

/// Checks that the page is there.
///
/// # Errors
/// A program that was built without it.
pub fn check() -> Result<(), Error> {
    if FILES.iter().all(|file| !file.content.is_empty()) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Usage, "preview", "this program was built without the page")
        .code(codes::PREVIEW_SERVER)
        .remedy("run `cargo xtask page`, and build the program again; `cargo usdtailor preview` does both"))
}
