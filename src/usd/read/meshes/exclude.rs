//! Meshes that are left out: by name, path or pattern, or by a collection of the stage (`UsdCollectionAPI`).

use crate::error::{Error, ErrorCode};
use crate::usd::read::choose::with_ancestors;
use crate::usd::read::choose::{all_meshes, list};
use crate::usd::read::query::{OrUnreadable, prim_at, text_value};
use openusd::sdf::Path;
use openusd::usd::Stage;
use std::collections::HashMap;
use std::path::Path as FilePath;

/// The text between the prim of a collection and its name, as in `/Suit.collection:props`.
const COLLECTION: &str = ".collection:";
/// Collections that one may hold, and these in turn.
const MAX_COLLECTIONS: usize = 100;

/// The meshes that `--exclude` leaves out.
pub struct Exclusions<'a> {
    patterns: Vec<&'a str>,
    collections: Vec<Collection>,
}

/// The paths that decide about members, as `UsdCollectionAPI` resolves them: a collection takes over the paths of those that
/// it includes, and its own includes and excludes are stronger.
#[derive(Default)]
struct Collection {
    members: HashMap<Path, Membership>,
}

/// The rule of a path of a collection.
#[derive(Clone, Copy, PartialEq)]
enum Membership {
    /// The prim, and all below it.
    Expanded,
    /// The prim alone.
    Explicit,
    /// Neither the prim nor those below it.
    Exclusions,
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
                let mut collection = Collection::default();
                collection.add(stage, name, &mut Vec::new())?;
                let is_used = meshes.iter().any(|path| collection.holds(path));
                excluded.collections.push(collection);
                is_used
            } else {
                excluded.patterns.push(name);
                meshes.iter().any(|path| excludes(name, path))
            };
            if !is_used {
                return Err(Error::usd(format!("--exclude {name} matches no mesh of {}", file.display()))
                    .code(ErrorCode::WrongPrim)
                    .remedy(list(&meshes)));
            }
        }
        Ok(excluded)
    }

    /// Whether a mesh is left out.
    pub fn holds(&self, path: &Path) -> bool {
        self.patterns.iter().any(|pattern| excludes(pattern, path))
            || self.collections.iter().any(|collection| collection.holds(path))
    }
}

impl Collection {
    /// Adds the members of the collection `name`, those of collections that it includes first. `read` has the names of the
    /// collections that were read.
    fn add(&mut self, stage: &Stage, name: &str, read: &mut Vec<String>) -> Result<(), Error> {
        if read.iter().any(|known| known == name) {
            return Ok(());
        }
        read.push(name.to_owned());
        if read.len() > MAX_COLLECTIONS {
            return Err(Error::usd(format!("{} holds more than {MAX_COLLECTIONS} collections", read[0]))
                .code(ErrorCode::WrongPrim)
                .remedy("name the prims by --exclude"));
        }
        let missing = || {
            Error::usd(format!("--exclude {name}: there is no such collection, or it includes nothing by path"))
                .code(ErrorCode::WrongPrim)
                .remedy(
                    "a collection is named as /Suit.collection:props, and has a relationship collection:props:includes",
                )
        };
        let (prim, own) = name.split_once(COLLECTION).ok_or_else(missing)?;
        let path = Path::new(prim).ok().filter(|path| path.is_abs() && path.is_prim_path()).ok_or_else(missing)?;
        let prim = prim_at(stage, &path)?;
        let targets = |kind: &str| {
            let relationship = prim.relationship(format!("collection:{own}:{kind}").as_str());
            relationship.targets().or_unreadable(&path)
        };
        let rule = match text_value(&prim, &format!("collection:{own}:expansionRule"), None)?.as_deref() {
            Some("explicitOnly") => Membership::Explicit,
            _ => Membership::Expanded,
        };
        let includes = targets("includes")?;
        if includes.is_empty() {
            return Err(missing());
        }
        let (collections, prims): (Vec<Path>, Vec<Path>) =
            includes.into_iter().partition(|target| target.as_str().contains(COLLECTION));
        for collection in collections {
            self.add(stage, collection.as_str(), read)?;
        }
        self.members.extend(prims.into_iter().map(|prim| (prim, rule)));
        self.members.extend(targets("excludes")?.into_iter().map(|prim| (prim, Membership::Exclusions)));
        Ok(())
    }

    /// Whether a prim is a member: its own rule decides, or that of the nearest prim above it that has one.
    fn holds(&self, path: &Path) -> bool {
        let mut rules = with_ancestors(path).map(|path| self.members.get(&path));
        match rules.next().flatten() {
            Some(own) => *own != Membership::Exclusions,
            None => rules.flatten().next() == Some(&Membership::Expanded),
        }
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
