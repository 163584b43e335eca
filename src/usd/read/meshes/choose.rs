//! Choosing the meshes that are garments.

use super::exclude::Exclusions;
use crate::codes;
use crate::names;
use crate::read::choose::{
    all_meshes, all_prims, check_instance, instancer_of, list, named_trims, prototypes, purpose_of,
};
use crate::read::query::{OrUnreadable, is_a, is_below_product, made_from, prim_at, value};
use crate::read::source::ReadOptions;
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, PrimPredicate, Stage};
use std::collections::HashSet;
use std::path::Path as FilePath;
use tailor_mesh::error::{Error, Warning, Warnings};

/// Meshes that are read together. More are hardly one costume.
const MAX_MESHES: usize = 2000;

/// The meshes that are garments, in namespace order; none where `options` name one mesh, or a prim that holds no more than one.
///
/// # Errors
/// No mesh or too many, a mesh inside an instance, and a pattern that matches no prim.
pub fn meshes(stage: &Stage, file: &FilePath, options: &ReadOptions) -> Result<Option<(Vec<Path>, Warnings)>, Error> {
    let root = match &options.prim {
        None => Path::abs_root(),
        Some(prim) => match Path::new(prim.as_str()).ok().filter(|p| p.is_abs() && p.is_prim_path()) {
            Some(path) if holds_meshes(stage, &path)? => path,
            _ => return Ok(None),
        },
    };
    let below: Vec<Path> = all_meshes(stage, file)?.into_iter().filter(|path| path.has_prefix(&root)).collect();
    let is_asked = options.all || !options.exclude.is_empty();
    if below.is_empty() || (below.len() == 1 && !is_asked) {
        return Ok(None);
    }
    let excluded = Exclusions::new(stage, file, &options.exclude)?;
    let models = models(stage, file)?;
    let repeated = prototypes(stage, file)?;
    let trims = named_trims(stage, &below, &options.trims)?;
    let (mut found, mut warnings) = (Vec::new(), Warnings::default());
    for path in &below {
        if trims.iter().any(|trim| path.has_prefix(trim))
            || excluded.holds(path)
            || (!models.contains(path) && is_other(stage, path)?)
        {
            continue;
        }
        let prim = prim_at(stage, path)?;
        if let Err(error) = check_instance(&prim) {
            warnings.push(left_out(path, &error.faults[0].text));
        } else if let Some(instancer) = instancer_of(path, &repeated) {
            warnings.push(left_out(path, &format!("the PointInstancer {instancer} repeats it")));
        } else if has_no_faces(&prim) {
            warnings.push(left_out(path, "it has no points or no faces"));
        } else {
            found.push(path.clone());
        }
    }
    match found.len() {
        0 => Err(none_is_a_garment(file, &below, &warnings)),
        1..=MAX_MESHES => Ok(Some((found, warnings))),
        count => Err(Error::usd(format!("{} holds {count} meshes, more than {MAX_MESHES}", file.display()))
            .code(codes::SEVERAL_MESHES)
            .remedy("name the prim of one garment by --prim, or leave meshes out by --exclude")),
    }
}

/// The error of a stage none of whose meshes is a garment; `left_out` has the reasons for some.
fn none_is_a_garment(file: &FilePath, meshes: &[Path], left_out: &Warnings) -> Error {
    let fault = Error::usd(format!("{} holds no mesh that is a garment", file.display())).code(codes::NO_MESH);
    match left_out.iter().next() {
        Some(first) => fault.remedy(format!(
            "name a prototype of a PointInstancer by --prim, set instanceable = false on the prim above others, or give the \
             mesh its points and faces; of {}: {}",
            first.place, first.problem
        )),
        None => fault.remedy(format!(
            "products, guides, proxies and excluded prims were skipped; name a mesh by --prim. The meshes are: {}",
            list(meshes)
        )),
    }
}

fn left_out(path: &Path, why: &str) -> Warning {
    Warning::not_carried(path, format!("{why}; it is left out"))
        .remedy("Name it in --exclude to build without this warning")
}

fn has_no_faces(prim: &Prim) -> bool {
    let is_missing = |name: &str| !prim.attribute(name).has_authored_value().unwrap_or(true);
    is_missing(names::FACE_VERTEX_COUNTS)
        || is_missing(names::POINTS)
        || matches!(value(prim, names::FACE_VERTEX_COUNTS, None), Ok(Some(Value::IntVec(counts))) if counts.is_empty())
}

/// Whether a prim of the stage is not a mesh itself.
fn holds_meshes(stage: &Stage, path: &Path) -> Result<bool, Error> {
    let prim = prim_at(stage, path)?;
    Ok(prim.is_valid().or_unreadable(path)? && !is_a(&prim, names::MESH)?)
}

/// The meshes from which products of the stage were made. A build gives them the purpose `guide`.
fn models(stage: &Stage, file: &FilePath) -> Result<HashSet<Path>, Error> {
    let mut found = HashSet::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        found.extend(made_from(&prim_at(stage, &path)?)?);
    }
    Ok(found)
}

/// Whether a mesh is a product, or below one, or is for something else than rendering.
pub fn is_other(stage: &Stage, path: &Path) -> Result<bool, Error> {
    if is_below_product(stage, path)? {
        return Ok(true);
    }
    Ok(matches!(purpose_of(&prim_at(stage, path)?)?.as_deref(), Some("guide" | "proxy")))
}
