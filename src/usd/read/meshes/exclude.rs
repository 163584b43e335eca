//! Meshes that are left out: by name, path or pattern, or by a collection of the stage (`UsdCollectionAPI`).

use crate::read::bindings::{COLLECTION, members};
use crate::read::choose::{all_meshes, list};
use crate::read::query::with_ancestors;
use openusd::sdf::Path;
use openusd::usd::{MembershipQuery, Stage};
use std::path::Path as FilePath;
use tailor_mesh::error::Error;

/// The meshes that `--exclude` leaves out.
pub struct Exclusions<'a> {
    patterns: Vec<&'a str>,
    collections: Vec<MembershipQuery>,
}

impl<'a> Exclusions<'a> {
    /// Reads the collections among the names.
    ///
    /// # Errors
    /// A collection that is not there, and names that no mesh has, which are mistyped.
    pub fn new(stage: &Stage, file: &FilePath, names: &'a [String]) -> Result<Self, Error> {
        let mut excluded = Self { patterns: Vec::new(), collections: Vec::new() };
        if names.is_empty() {
            return Ok(excluded);
        }
        let meshes = all_meshes(stage, file)?;
        for name in names {
            let is_used = if name.contains(COLLECTION) {
                let collection = members(stage, name)?;
                let is_used = meshes.iter().any(|path| collection.is_path_included(path));
                excluded.collections.push(collection);
                is_used
            } else {
                excluded.patterns.push(name);
                meshes.iter().any(|path| excludes(name, path))
            };
            if !is_used {
                return Err(Error::usd(format!("--exclude {name} matches no mesh of {}", file.display()))
                    .code(tailor_mesh::codes::WRONG_PRIM)
                    .remedy(list(&meshes)));
            }
        }
        Ok(excluded)
    }

    /// Whether a mesh is left out.
    pub fn holds(&self, path: &Path) -> bool {
        self.patterns.iter().any(|pattern| excludes(pattern, path))
            || self.collections.iter().any(|collection| collection.is_path_included(path))
    }
}

/// Whether a pattern matches the path or the name of a prim, or of one above it.
fn excludes(pattern: &str, path: &Path) -> bool {
    with_ancestors(path).any(|path| matches(pattern, path.as_str()) || path.name().is_some_and(|n| matches(pattern, n)))
}

/// Whether a pattern, in which `*` stands for any letters, matches a text. Time is at most the product of their lengths.
fn matches(pattern: &str, text: &str) -> bool {
    let (pattern, text) = (pattern.as_bytes(), text.as_bytes());
    let (mut p, mut t, mut star) = (0, 0, None);
    while t < text.len() {
        if pattern.get(p) == Some(&b'*') {
            star = Some((p, t));
            p += 1;
        } else if pattern.get(p) == Some(&text[t]) {
            (p, t) = (p + 1, t + 1);
        } else if let Some((at, from)) = star {
            star = Some((at, from + 1));
            (p, t) = (at + 1, from + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|&c| c == b'*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_stand_for_any_letters() {
        for (pattern, text, expected) in [
            ("body", "body", true),
            ("body", "body2", false),
            ("body*", "body_low", true),
            ("*_low", "body_low", true),
            ("/Char/*/eye*", "/Char/head/eye_left", true),
            ("b*d*y", "buddy", true),
            ("b*d*x", "buddy", false),
            ("*", "", true),
            ("", "a", false),
        ] {
            assert_eq!(matches(pattern, text), expected, "{pattern} {text}");
        }
    }

    #[test]
    fn a_prim_is_left_out_with_all_below_it() {
        let path = Path::new("/Char/body/skin").expect("a path");
        for (pattern, expected) in
            [("body", true), ("/Char/body", true), ("/Char/bod", false), ("skin", true), ("Body", false)]
        {
            assert_eq!(excludes(pattern, &path), expected, "{pattern}");
        }
    }
}
