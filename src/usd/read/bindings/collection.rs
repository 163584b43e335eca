//! Collections of prims (`UsdCollectionAPI`).

use crate::read::query::{OrUnreadable, prim_at, text_value, with_ancestors};
use openusd::sdf::Path;
use openusd::usd::Stage;
use std::collections::HashMap;
use tailor_mesh::error::Error;

/// The text between the prim of a collection and its name, as in `/Suit.collection:props`.
pub const COLLECTION: &str = ".collection:";
/// Collections that one may hold, and these in turn.
const MAX_COLLECTIONS: usize = 100;

/// The paths that decide about members, as `UsdCollectionAPI` resolves them: a collection takes over the paths of those that
/// it includes, and its own includes and excludes are stronger.
#[derive(Default)]
pub struct Collection {
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

impl Collection {
    /// The collection of a name such as `/Suit.collection:props`.
    ///
    /// # Errors
    /// One that is not there or includes nothing.
    pub fn read(stage: &Stage, name: &str) -> Result<Self, Error> {
        let mut collection = Self::default();
        collection.add(stage, name, &mut Vec::new())?;
        Ok(collection)
    }

    /// Adds the members of the collection `name`, those of collections that it includes first. `read` has the names of the
    /// collections that were read.
    fn add(&mut self, stage: &Stage, name: &str, read: &mut Vec<String>) -> Result<(), Error> {
        if read.iter().any(|known| known == name) {
            return Ok(());
        }
        read.push(name.to_owned());
        if read.len() > MAX_COLLECTIONS {
            return Err(Error::usd(format!("{} holds more than {MAX_COLLECTIONS} collections", read[0]))
                .code(tailor_mesh::codes::WRONG_PRIM)
                .remedy("name the prims themselves"));
        }
        let missing = || {
            Error::usd(format!("{name}: there is no such collection, or it includes nothing by path"))
                .code(tailor_mesh::codes::WRONG_PRIM)
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
    pub fn holds(&self, path: &Path) -> bool {
        let mut rules = with_ancestors(path).map(|path| self.members.get(&path));
        match rules.next().flatten() {
            Some(own) => *own != Membership::Exclusions,
            None => rules.flatten().next() == Some(&Membership::Expanded),
        }
    }
}
