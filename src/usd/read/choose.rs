//! Choosing the mesh to work on.

use super::diagnostics::{in_words, recipe_of};
use super::query::{OrUnreadable, is_a, is_product, prim_at, property_names, value, with_ancestors};
use super::recipe::trim_prims;
use super::{ReadOptions, variants};
use crate::codes;
use crate::names;
use crate::values::text;
use openusd::sdf;
use openusd::usd::{Prim, PrimPredicate, Stage};
use serde_json::Value as Json;
use std::collections::BTreeSet;
use std::path::Path;
use tailor_mesh::error::Error;
use tailor_mesh::meter;

/// Paths that a message lists.
const LISTED: usize = 8;
/// Letters of a path of many levels that a message shows.
const SHOWN: usize = 60;
/// Levels of prims. The USD library takes time that grows with the square of them.
const MAX_DEPTH: usize = 256;
/// Prims of a stage that is searched or flattened. Sets of a film have some ten thousand, without instances.
const MAX_PRIMS: usize = 100_000;
/// Memory of the prims of a stage. 100,000 prims of a set take half of it; below references in references, a prim takes 40 kB. \[bytes\]
const MOST_MEMORY: isize = 1 << 30;

/// The mesh that `options` name, the only one below the prim that they name, or the only one of the stage.
///
/// # Errors
/// No mesh, several meshes, or a path that is not a mesh to which siblings can be added.
pub fn choose_mesh(stage: &Stage, file: &Path, options: &ReadOptions) -> Result<Prim, Error> {
    let prim = match &options.prim {
        Some(path) => named_mesh(stage, file, path)?,
        None => only_mesh(stage, file, &options.trims)?,
    };
    check_instance(&prim)?;
    Ok(prim)
}

/// Refuses a mesh inside an instance.
pub fn check_instance(prim: &Prim) -> Result<(), Error> {
    let instance = prim.is_instance_proxy().and_then(|proxy| Ok(proxy || prim.is_in_prototype()?));
    if instance.or_unreadable(prim.path())? {
        return Err(Error::usd(format!("{} is inside an instance, which takes no new prims", prim.path()))
            .code(codes::INSIDE_INSTANCE)
            .remedy("open the file that the instance refers to, or set instanceable = false on the instance"));
    }
    Ok(())
}

fn named_mesh(stage: &Stage, file: &Path, path: &str) -> Result<Prim, Error> {
    let parsed = sdf::Path::new(path).ok().filter(|p| p.is_abs() && p.is_prim_path() && !p.is_abs_root());
    let Some(parsed) = parsed else {
        return Err(Error::usd(format!("prim {path:?} is not the path of a prim"))
            .code(tailor_mesh::codes::WRONG_PRIM)
            .remedy("it looks like /Coat/model"));
    };
    check_depth(&parsed, file)?;
    let prim = prim_at(stage, &parsed)?;
    if !prim.is_valid().or_unreadable(&parsed)? {
        let found = all_meshes(stage, file)?;
        let variants = variants_in_words(stage, file)?;
        let remedy = [list(&found)].into_iter().chain(variants).collect::<Vec<_>>().join("; ");
        return Err(Error::usd(format!("{} has no prim {path}", file.display()))
            .code(tailor_mesh::codes::WRONG_PRIM)
            .remedy(remedy));
    }
    if !is_a(&prim, names::MESH)? {
        let mut found = all_meshes(stage, file)?;
        if found.iter().any(|p| p.has_prefix(prim.path())) {
            found.retain(|p| p.has_prefix(prim.path()));
            if let [one] = without_products(stage, &found)?.as_slice() {
                return prim_at(stage, one);
            }
        }
        let type_name = prim.type_name().or_unreadable(&parsed)?.filter(|t| !t.is_empty());
        let kind = type_name.as_ref().map_or("a prim without a type", |t| t.as_str());
        return Err(Error::usd(format!("{path} is {kind}, not a Mesh"))
            .code(tailor_mesh::codes::WRONG_PRIM)
            .remedy(list(&found)));
    }
    if !stage.prim_matches(&parsed, PrimPredicate::DEFAULT).or_unreadable(&parsed)? {
        return Err(Error::usd(format!("{path} is inactive, undefined, or a class (an abstract prim)"))
            .code(tailor_mesh::codes::WRONG_PRIM)
            .remedy("activate it, or name another mesh"));
    }
    Ok(prim)
}

/// The meshes that this program did not write.
fn without_products(stage: &Stage, meshes: &[sdf::Path]) -> Result<Vec<sdf::Path>, Error> {
    let mut found = Vec::new();
    for path in meshes {
        if !is_product(&prim_at(stage, path)?)? {
            found.push(path.clone());
        }
    }
    Ok(found)
}

fn only_mesh(stage: &Stage, file: &Path, trims: &[String]) -> Result<Prim, Error> {
    let all = all_meshes(stage, file)?;
    let mut garments = without_products(stage, &all)?;
    if garments.len() > 1 {
        let trims = named_trims(stage, &garments, trims)?;
        garments.retain(|path| !trims.iter().any(|trim| path.has_prefix(trim)));
        let repeated = prototypes(stage, file)?;
        let found = garments.clone();
        garments.retain(|path| instancer_of(path, &repeated).is_none());
        if garments.is_empty() {
            let text = format!("{} holds no mesh but prototypes of a PointInstancer", file.display());
            return Err(Error::usd(text).code(codes::NO_MESH).remedy(format!("name one by --prim: {}", list(&found))));
        }
    }
    match garments.as_slice() {
        [one] => prim_at(stage, one),
        [] if !all.is_empty() => {
            Err(Error::usd(format!("{} holds no mesh but products of usd-tailor", file.display()))
                .code(codes::NO_MESH)
                .remedy("open the file of the garment, or name a product by --prim or as \"prim\" in a .tailor file"))
        }
        [] => {
            let all = stage.composition_errors();
            let faults: Vec<_> = all.iter().map(|e| format!("\n  {}", in_words(e))).take(LISTED).collect();
            let because =
                if faults.is_empty() { String::new() } else { format!("; its composition fails:{}", faults.concat()) };
            let variants = variants_in_words(stage, file)?;
            let elsewhere = if variants.is_empty() {
                String::new()
            } else {
                format!("; it may be in a variant that is not selected: {}", variants.join("; "))
            };
            let wanted = match all.iter().find_map(recipe_of) {
                Some((_, recipe)) => format!("name {recipe} itself as the input"),
                None => format!("a garment is an active prim of type Mesh{elsewhere}"),
            };
            Err(Error::usd(format!("{} holds no mesh{because}", file.display())).code(codes::NO_MESH).remedy(wanted))
        }
        several => Err(Error::usd(format!("{} holds {} meshes", file.display(), several.len()))
            .code(codes::SEVERAL_MESHES)
            .remedy(format!("choose one by --prim, or as \"prim\" in a .tailor file: {}", list(several)))),
    }
}

/// The prims that options of meshes, or of prims above them, name as trims, and those that are `given` by path or by name beside a
/// mesh. All meshes below them are trims.
///
/// # Errors
/// A stage that cannot be queried.
pub fn named_trims(stage: &Stage, meshes: &[sdf::Path], given: &[String]) -> Result<BTreeSet<sdf::Path>, Error> {
    let (mut found, mut asked) = (BTreeSet::new(), BTreeSet::new());
    for mesh in meshes {
        let mut add = |name: &str| {
            let beside = mesh.parent().and_then(|parent| parent.append_path(name).ok());
            found.extend(sdf::Path::new(name).ok().filter(sdf::Path::is_abs).or(beside));
        };
        given.iter().for_each(|name| add(name));
        for path in with_ancestors(mesh).filter(|path| !path.is_abs_root()) {
            if asked.insert(path.clone()) {
                trims_of(&prim_at(stage, &path)?)?.iter().for_each(|name| add(name));
            }
        }
    }
    Ok(found)
}

/// The prims that the options of one prim name, as text.
fn trims_of(prim: &Prim) -> Result<Vec<String>, Error> {
    let mut found = Vec::new();
    for name in property_names(prim)?.iter().filter(|name| names::is_trim_prims(name)) {
        match trim_prims(prim, name, None)? {
            Some(Json::Array(all)) => found.extend(all.iter().filter_map(Json::as_str).map(str::to_owned)),
            Some(Json::String(list)) => found.extend(list.split(',').map(|name| name.trim().to_owned())),
            _ => {}
        }
    }
    Ok(found)
}

/// The variant sets of a stage, as a message lists them.
fn variants_in_words(stage: &Stage, file: &Path) -> Result<Vec<String>, Error> {
    let mut all = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        all.extend(variants::in_words(&prim_at(stage, &path)?)?);
    }
    all.truncate(LISTED);
    Ok(all)
}

/// The paths of all active, defined meshes, including those inside instances.
pub fn all_meshes(stage: &Stage, file: &Path) -> Result<Vec<sdf::Path>, Error> {
    let mut meshes = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, true)? {
        if is_a(&prim_at(stage, &path)?, names::MESH)? {
            meshes.push(path);
        }
    }
    Ok(meshes)
}

/// The paths of all prims that match, parents before children. Prims below others that do not match are left out; so are those
/// inside instances, unless `in_instances`.
///
/// # Errors
/// A stage that cannot be composed, and one of too many prims or levels: references multiply prims, so that a small file
/// may hold any number of them.
pub fn all_prims(
    stage: &Stage,
    file: &Path,
    predicate: PrimPredicate,
    in_instances: bool,
) -> Result<Vec<sdf::Path>, Error> {
    prims_below(stage, &sdf::Path::abs_root(), file, predicate, in_instances)
}

/// As [`all_prims`], of the prim `root` and of those below it.
///
/// # Errors
/// As [`all_prims`].
pub fn prims_below(
    stage: &Stage,
    root: &sdf::Path,
    file: &Path,
    predicate: PrimPredicate,
    in_instances: bool,
) -> Result<Vec<sdf::Path>, Error> {
    let fault = |e: openusd::Error| Error::usd(format!("{} cannot be composed: {e}", file.display()));
    let (mut found, mut open) = (Vec::new(), vec![root.clone()]);
    let begin = meter::of_thread();
    while let Some(path) = open.pop() {
        meter::check();
        if meter::of_thread() - begin > MOST_MEMORY {
            let text = format!("{} takes more than 1 GB to compose, for {} of its prims", file.display(), found.len());
            let remedy = "references to prims with references multiply: open the file of the garment alone";
            return Err(Error::usd(text).code(tailor::codes::TOO_LARGE).remedy(remedy));
        }
        let prim = prim_at(stage, &path)?;
        if !path.is_abs_root() {
            if !stage.prim_matches(&path, predicate).map_err(fault)? {
                continue;
            }
            check_depth(&path, file)?;
            found.push(path.clone());
            if !in_instances && prim.is_instance().map_err(fault)? {
                continue;
            }
        }
        let children = prim.child_names().map_err(fault)?;
        if found.len() + open.len() + children.len() > MAX_PRIMS {
            return Err(Error::usd(format!("{} holds more than {MAX_PRIMS} prims", file.display()))
                .remedy("open the file of the garment alone, or name its mesh by --prim"));
        }
        open.extend(children.iter().rev().filter_map(|name| path.append_path(name.as_str()).ok()));
    }
    Ok(found)
}

/// Refuses prims of too many levels.
fn check_depth(path: &sdf::Path, file: &Path) -> Result<(), Error> {
    let depth = path.as_str().matches('/').count();
    if depth > MAX_DEPTH {
        let start: String = path.as_str().chars().take(SHOWN).collect();
        return Err(Error::usd(format!("{} has prims at more than {MAX_DEPTH} levels, at {start}...", file.display()))
            .remedy("open a file in which the garment is nearer to the root"));
    }
    Ok(())
}

/// The purpose of a prim: its own, or that of the nearest prim above with one.
pub fn purpose_of(prim: &Prim) -> Result<Option<String>, Error> {
    for path in with_ancestors(prim.path()) {
        let own = value(&prim_at(prim.stage(), &path)?, names::PURPOSE, None).ok().flatten();
        if let Some(purpose) = own.as_ref().and_then(text) {
            return Ok(Some(purpose.to_owned()));
        }
    }
    Ok(None)
}

/// The prims nearest below a mesh that have a type and no purpose of their own, except for its subsets.
pub fn without_purpose(mesh: &Prim) -> Result<Vec<sdf::Path>, Error> {
    let (mut found, mut left) = (Vec::new(), vec![mesh.clone()]);
    while let Some(above) = left.pop() {
        for child in above.children().or_unreadable(above.path())? {
            let path = child.path();
            // A prim without a type has no purpose, and those below it inherit from above.
            if child.type_name().or_unreadable(path)?.is_none_or(|kind| kind.is_empty()) {
                left.push(child);
            } else if !is_a(&child, names::GEOM_SUBSET)?
                && !child.attribute(names::PURPOSE).has_authored_value().or_unreadable(path)?
            {
                found.push(path.clone());
            }
        }
    }
    found.sort();
    Ok(found)
}

/// A prim that a PointInstancer repeats, with all below it, and the PointInstancer.
pub type Repeated = (sdf::Path, sdf::Path);

/// What the PointInstancers of a stage repeat: the prims that they name, and all that is below themselves.
pub fn prototypes(stage: &Stage, file: &Path) -> Result<Vec<Repeated>, Error> {
    let mut found = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        let prim = prim_at(stage, &path)?;
        if is_a(&prim, names::POINT_INSTANCER)? {
            let named = prim.relationship(names::PROTOTYPES).targets().or_unreadable(&path)?;
            found.extend(named.into_iter().map(|root| (root, path.clone())));
            found.push((path.clone(), path));
        }
    }
    Ok(found)
}

/// The PointInstancer that repeats a prim.
pub fn instancer_of<'a>(path: &sdf::Path, repeated: &'a [Repeated]) -> Option<&'a sdf::Path> {
    repeated.iter().find(|(root, _)| path.has_prefix(root)).map(|(_, instancer)| instancer)
}

pub fn list(paths: &[sdf::Path]) -> String {
    if paths.is_empty() {
        return "it holds no mesh".into();
    }
    let shown: Vec<_> = paths.iter().take(LISTED).map(sdf::Path::as_str).collect();
    let more = if paths.len() > LISTED { format!(" and {} more", paths.len() - LISTED) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}
