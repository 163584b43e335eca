//! Choosing the mesh to work on.

use super::UsdError;
use super::names;
use super::read::ReadOptions;
use super::values::text;
use openusd::sdf::{self, Value};
use openusd::usd::{Prim, PrimPredicate, Stage};
use std::path::Path;

/// How many paths a message lists.
const LISTED: usize = 8;

/// The mesh to work on: the one named, or the only one.
///
/// # Errors
/// No mesh, several meshes, or a path that is not a mesh beside which another can be put.
pub fn choose_mesh(stage: &Stage, file: &Path, options: &ReadOptions) -> Result<Prim, UsdError> {
    let prim = match &options.prim {
        Some(path) => named_mesh(stage, file, path)?,
        None => only_mesh(stage, file)?,
    };
    let instance = prim.is_instance_proxy().and_then(|proxy| Ok(proxy || prim.is_in_prototype()?));
    if instance.map_err(|e| unreadable(&prim, &e))? {
        return Err(UsdError::new(format!(
            "{} is inside an instance, so that nothing can be put beside it",
            prim.path()
        ))
        .hint("open the file that the instance refers to, or set instanceable = false on the instance"));
    }
    Ok(prim)
}

fn named_mesh(stage: &Stage, file: &Path, path: &str) -> Result<Prim, UsdError> {
    let parsed = sdf::Path::new(path).ok().filter(|p| p.is_abs() && p.is_prim_path() && !p.is_abs_root());
    let Some(parsed) = parsed else {
        return Err(UsdError::new(format!("prim {path:?} is not the path of a prim")).hint("it looks like /Coat/model"));
    };
    let prim = prim_at(stage, &parsed)?;
    if !prim.is_valid().map_err(|e| unreadable(&prim, &e))? {
        let found = all_meshes(stage, file)?;
        return Err(UsdError::new(format!("{} has no prim {path}", file.display())).hint(list(&found)));
    }
    let type_name = prim.type_name().map_err(|e| unreadable(&prim, &e))?.unwrap_or_default();
    if type_name.as_str() != names::MESH {
        let mut found = all_meshes(stage, file)?;
        if found.iter().any(|p| p.has_prefix(prim.path())) {
            found.retain(|p| p.has_prefix(prim.path()));
        }
        let kind = if type_name.is_empty() { "a prim without a type" } else { type_name.as_str() };
        return Err(UsdError::new(format!("{path} is {kind}, not a Mesh")).hint(list(&found)));
    }
    let usable = stage.prim_matches(prim.path(), PrimPredicate::DEFAULT).map_err(|e| unreadable(&prim, &e))?;
    if !usable {
        return Err(UsdError::new(format!("{path} is inactive, undefined, or a class (an abstract prim)"))
            .hint("activate it, or name another mesh"));
    }
    Ok(prim)
}

fn only_mesh(stage: &Stage, file: &Path) -> Result<Prim, UsdError> {
    let all = all_meshes(stage, file)?;
    let mut found = Vec::new();
    for path in &all {
        if product_role(&prim_at(stage, path)?).is_none() {
            found.push(path.clone());
        }
    }
    match found.as_slice() {
        [one] => prim_at(stage, one),
        [] if !all.is_empty() => {
            Err(UsdError::new(format!("{} holds no mesh but products of usd-tailor", file.display()))
                .hint("name the garment's own file, or give one of them by --prim, or as \"prim\" in a .tailor file"))
        }
        [] => {
            let faults: Vec<_> = stage.composition_errors().iter().map(|e| format!("\n  {e}")).take(LISTED).collect();
            let because =
                if faults.is_empty() { String::new() } else { format!("; its composition fails:{}", faults.concat()) };
            Err(UsdError::new(format!("{} holds no mesh{because}", file.display()))
                .hint("a garment is an active prim of type Mesh"))
        }
        several => Err(UsdError::new(format!("{} holds {} meshes", file.display(), several.len()))
            .hint(format!("choose one by --prim, or as \"prim\" in a .tailor file: {}", list(several)))),
    }
}

/// The paths of all active, defined meshes, inside instances too.
fn all_meshes(stage: &Stage, file: &Path) -> Result<Vec<sdf::Path>, UsdError> {
    let fault = |e: openusd::Error| UsdError::new(format!("{} cannot be composed: {e}", file.display()));
    let mut paths = Vec::new();
    stage.traverse(PrimPredicate::DEFAULT_PROXIES, |path| paths.push(path.clone())).map_err(fault)?;
    let mut meshes = Vec::new();
    for path in paths {
        let type_name = prim_at(stage, &path)?.type_name().map_err(fault)?;
        if type_name.is_some_and(|t| t.as_str() == names::MESH) {
            meshes.push(path);
        }
    }
    Ok(meshes)
}

fn list(paths: &[sdf::Path]) -> String {
    if paths.is_empty() {
        return "it holds no mesh".into();
    }
    let shown: Vec<_> = paths.iter().take(LISTED).map(sdf::Path::as_str).collect();
    let more = if paths.len() > LISTED { format!(" and {} more", paths.len() - LISTED) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

/// The role that a prim has as a product of this program.
pub fn product_role(prim: &Prim) -> Option<String> {
    let Ok(Some(Value::Dictionary(data))) = prim.custom_data() else { return None };
    match data.get(names::PRODUCT_SPACE) {
        Some(Value::Dictionary(ours)) => ours.get(names::PRODUCT).and_then(text).map(str::to_owned),
        _ => None,
    }
}

/// The prim at `path`.
pub fn prim_at(stage: &Stage, path: &sdf::Path) -> Result<Prim, UsdError> {
    stage.prim(path).map_err(|e| UsdError::new(e.to_string()))
}

/// A prim that cannot be read.
pub fn unreadable(prim: &Prim, e: &dyn std::fmt::Display) -> UsdError {
    UsdError::new(format!("{} cannot be read: {e}", prim.path()))
}
