//! Collections of prims (`UsdCollectionAPI`).

use crate::names;
use crate::read::choose::all_prims;
use crate::read::query::{OrUnreadable, prim_at, property_names};
use openusd::sdf::Path;
use openusd::usd::{CollectionAPI, MembershipQuery, PrimPredicate, Stage};
use std::path::Path as FilePath;
use tailor_mesh::error::{Error, Warning};

/// The text between the prim of a collection and its name, as in `/Suit.collection:props`.
pub const COLLECTION: &str = ".collection:";
/// Collections that one may hold, and these in turn. The USD library goes from one to the next on the stack.
const MAX_COLLECTIONS: usize = 100;

/// The members of the collection of a name such as `/Suit.collection:props`.
///
/// # Errors
/// One that is not there or includes nothing.
pub fn members(stage: &Stage, name: &str) -> Result<MembershipQuery, Error> {
    let fault = |text: &str, remedy: &str| {
        Error::usd(format!("{name} {text}")).code(tailor_mesh::codes::WRONG_PRIM).remedy(remedy)
    };
    let example = "name it as /Suit.collection:props, with a relationship collection:props:includes";
    let missing = || fault("is not a collection, or includes nothing", example);
    let instance = |path: &Path| CollectionAPI::instance_at_path(path);
    let mut held: Vec<_> = Path::new(name).ok().as_ref().and_then(instance).into_iter().collect();
    let mut collections = Vec::new();
    while let Some((path, name)) = held.get(collections.len()).cloned() {
        let collection = CollectionAPI::from_prim_unchecked(prim_at(stage, &path)?, name);
        for nested in collection.includes().or_unreadable(&path)?.iter().filter_map(instance) {
            if !held.contains(&nested) {
                held.push(nested);
            }
        }
        if held.len() > MAX_COLLECTIONS {
            let text = format!("holds more than {MAX_COLLECTIONS} collections");
            return Err(fault(&text, "name the prims themselves"));
        }
        collections.push(collection);
    }
    let first = collections.first().ok_or_else(missing)?;
    let members = first.compute_membership_query().or_unreadable(first.path())?;
    if members.is_empty() { Err(missing()) } else { Ok(members) }
}

/// A relationship of a collection, or of pairs that do not collide, with its targets.
pub struct Naming {
    relationship: Path,
    targets: Vec<Path>,
}

/// The collections and collision filters of a stage, without the collections of materials: products follow those by themselves.
///
/// # Errors
/// A stage of too many prims.
pub fn namings(stage: &Stage, file: &FilePath) -> Result<Vec<Naming>, Error> {
    let (mut found, mut of_materials) = (Vec::new(), Vec::new());
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        let prim = prim_at(stage, &path)?;
        for name in property_names(&prim)? {
            let is_of_material = name.starts_with(names::MATERIAL_BINDING_COLLECTION);
            let is_members =
                name.starts_with("collection:") && (name.ends_with(":includes") || name.ends_with(":excludes"));
            if !is_of_material && !is_members && name != "physics:filteredPairs" {
                continue;
            }
            let targets = prim.relationship(name.as_str()).targets().or_unreadable(&path)?;
            if is_of_material {
                of_materials.extend(targets);
            } else {
                found.push(Naming { relationship: path.append_property(name.as_str()).or_unreadable(&path)?, targets });
            }
        }
    }
    let is_of_material = |naming: &Naming| {
        let collection = naming.relationship.as_str().rsplit_once(':').map(|(collection, _)| collection);
        of_materials.iter().any(|path| Some(path.as_str()) == collection)
    };
    found.retain(|naming| !is_of_material(naming));
    Ok(found)
}

impl Naming {
    /// The warning that it names a mesh, and none of the products beside it.
    pub fn misses_products(&self, mesh: &Path) -> Option<Warning> {
        let is_product = |path: &Path| {
            let role = path.name().and_then(|name| name.rsplit('_').next());
            path.parent() == mesh.parent() && role.is_some_and(|role| [names::SIM, names::RENDER].contains(&role))
        };
        let is_missing = self.targets.contains(mesh) && !self.targets.iter().any(is_product);
        let why = format!("it names {mesh}, and products are not added to it");
        let remedy = "Add them, such as render and sim beside the mesh, or name the prim above";
        is_missing.then(|| Warning::not_carried(&self.relationship, why).remedy(remedy))
    }
}
