//! Questions to a composed stage. Errors name the prim or attribute.

use crate::codes;
use crate::names::{self, UsdToken};
use crate::values::text;
use glam::Vec3;
use openusd::sdf::{self, Value};
use openusd::usd::{Prim, Stage, TimeCode};
use std::fmt::Display;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Interpolation;

/// Turns a failure of the USD library into an error that names a path.
pub trait OrUnreadable<T> {
    /// The value, or the error that `path` cannot be read.
    fn or_unreadable(self, path: &sdf::Path) -> Result<T, Error>;
}

impl<T, E: Display> OrUnreadable<T> for Result<T, E> {
    fn or_unreadable(self, path: &sdf::Path) -> Result<T, Error> {
        self.map_err(|e| {
            let words = e.to_string();
            let fault = Error::usd(format!("{path} cannot be read: {words}"));
            if !words.contains(UNDECODED) {
                return fault;
            }
            fault.code(codes::NOT_SUPPORTED).remedy(
                "the crate may be of an old version: write it again, for example by `usdcat OLD -o NEW`; it is damaged if \
                 that fails too",
            )
        })
    }
}

/// The library's words of a value that a crate has and that it cannot decode: such as time samples of version 0.4.0.
const UNDECODED: &str = "failed to decode field";

/// The prim at `path`.
pub fn prim_at(stage: &Stage, path: &sdf::Path) -> Result<Prim, Error> {
    stage.prim(path).or_unreadable(path)
}

/// A path and those above it, up to the root prim.
pub fn with_ancestors(path: &sdf::Path) -> impl Iterator<Item = sdf::Path> {
    std::iter::once(path.clone()).chain(path.strict_ancestors_below_root())
}

/// Name of a prim.
pub fn prim_name(prim: &Prim) -> String {
    prim.path().name().expect("every prim but the pseudo-root has a name").to_owned()
}

/// Whether a prim is of the type `name`.
pub fn is_a(prim: &Prim, name: &str) -> Result<bool, Error> {
    Ok(prim.type_name().or_unreadable(prim.path())?.is_some_and(|t| t.as_str() == name))
}

/// Whether this program wrote the prim.
pub fn is_product(prim: &Prim) -> Result<bool, Error> {
    Ok(product_of(prim)?.is_some())
}

/// Whether this program wrote the prim at `path`, or one above it.
pub fn is_below_product(stage: &Stage, path: &sdf::Path) -> Result<bool, Error> {
    for path in with_ancestors(path) {
        if is_product(&prim_at(stage, &path)?)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The name of the model from which this program made the prim, empty where it is not recorded; none for other prims.
pub fn product_of(prim: &Prim) -> Result<Option<String>, Error> {
    let Some(Value::Dictionary(data)) = prim.custom_data().or_unreadable(prim.path())? else { return Ok(None) };
    let Some(Value::Dictionary(ours)) = data.get(names::PRODUCT_SPACE) else { return Ok(None) };
    if ours.get(names::PRODUCT).is_none_or(|role| text(role).is_none()) {
        return Ok(None);
    }
    Ok(Some(ours.get(names::PRODUCT_OF).and_then(text).unwrap_or_default().to_owned()))
}

/// The paths of the meshes from which this program made the prim; empty for other prims.
pub fn made_from(prim: &Prim) -> Result<Vec<sdf::Path>, Error> {
    let Some(model) = product_of(prim)? else { return Ok(Vec::new()) };
    let data = prim.custom_data().or_unreadable(prim.path())?;
    if let Some(Value::Dictionary(data)) = data
        && let Some(Value::Dictionary(ours)) = data.get(names::PRODUCT_SPACE)
        && let Some(Value::StringVec(panels)) = ours.get(names::PRODUCT_PANELS)
    {
        return Ok(panels.iter().filter_map(|path| sdf::Path::new(path.as_str()).ok()).collect());
    }
    let beside = prim.path().parent().and_then(|parent| parent.append_path(model.as_str()).ok());
    Ok(beside.into_iter().collect())
}

/// Names of the properties that layers author.
pub fn property_names(prim: &Prim) -> Result<Vec<String>, Error> {
    let names = prim.authored_property_names().or_unreadable(prim.path())?;
    Ok(names.iter().map(ToString::to_string).collect())
}

/// Names of the primvars of a prim, without `primvars:`.
pub fn primvar_names(prim: &Prim) -> Result<Vec<String>, Error> {
    let properties = property_names(prim)?;
    let primvars = properties.iter().filter_map(|p| p.strip_prefix(names::PRIMVARS));
    Ok(primvars.filter(|p| !p.is_empty() && !p.ends_with(names::INDICES_SUFFIX)).map(str::to_owned).collect())
}

/// The interpolation of the attribute `property`, with that of primvars as fallback.
///
/// # Errors
/// A token that USD does not know.
pub fn interpolation(prim: &Prim, property: &str) -> Result<Interpolation, Error> {
    let attribute = prim.attribute(property);
    let field = attribute.get_metadata::<Value>(names::INTERPOLATION).or_unreadable(attribute.path())?;
    field.map_or(Ok(Interpolation::Constant), |field| known(&field, &format!("interpolation of {}", attribute.path())))
}

/// The value of a token; `place` names it.
///
/// # Errors
/// A token that USD does not know.
pub fn known<T: UsdToken>(token: &Value, place: &str) -> Result<T, Error> {
    let shown = text(token).unwrap_or("not a token");
    T::from_token(shown).ok_or_else(|| {
        Error::usd(format!("{place} is {shown:?}, which USD does not know"))
            .code(codes::UNKNOWN_TOKEN)
            .remedy(format!("use one of: {}", T::allowed()))
    })
}

/// The value of an attribute at `time`, or its default; none where nothing is authored or the value is blocked.
///
/// # Errors
/// A value that cannot be read, and, without a time, an attribute that has several time samples and no default.
pub fn value(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Value>, Error> {
    let attribute = prim.attribute(name);
    match attribute.get_at::<Value>(time).or_unreadable(attribute.path())? {
        Some(value) if !value.is_value_block() => return Ok(Some(value)),
        _ if time.is_some() => return Ok(None),
        _ => {}
    }
    match attribute.time_sample_times().or_unreadable(attribute.path())?.as_slice() {
        [] => Ok(None),
        // It holds at all times.
        [only] => {
            let value = attribute.get_at::<Value>(Some(TimeCode::new(*only))).or_unreadable(attribute.path())?;
            Ok(value.filter(|value| !value.is_value_block()))
        }
        times @ [first, ..] => {
            Err(Error::usd(format!("{} has values at {} times and no default", attribute.path(), times.len()))
                .code(codes::NO_DEFAULT_VALUE)
                .remedy(format!(
                    "choose a time, for example --time {first}, or the argument time={first} of a .tailor file"
                )))
        }
    }
}

/// The vectors of an attribute at `time`, or its default; none where it has none.
///
/// # Errors
/// As [`value`].
pub fn vectors(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<Vec<Vec3>>, Error> {
    Ok(match value(prim, name, time)? {
        Some(Value::Vec3fVec(all)) => Some(bytemuck::cast_slice(&all).to_vec()),
        Some(Value::Vec3dVec(all)) => Some(all.iter().map(|v| Vec3::new(v.x as f32, v.y as f32, v.z as f32)).collect()),
        _ => None,
    })
}

/// The text of a token or string attribute.
///
/// # Errors
/// As [`value`], and a value of another type.
pub fn text_value(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<String>, Error> {
    let Some(value) = value(prim, name, time)? else { return Ok(None) };
    let text = text(&value).ok_or_else(|| {
        Error::usd(format!("{}.{name} is not a token", prim.path()))
            .code(codes::ATTRIBUTE_TYPE)
            .remedy(format!("declare it as uniform token {name}"))
    })?;
    Ok(Some(text.to_owned()))
}

/// The active, defined subsets directly below a mesh.
pub fn subset_prims(mesh: &Prim) -> Result<Vec<Prim>, Error> {
    let mut found = Vec::new();
    for child in mesh.children().or_unreadable(mesh.path())? {
        let path = mesh.path();
        if is_a(&child, names::GEOM_SUBSET)?
            && child.is_active().or_unreadable(path)?
            && child.is_defined().or_unreadable(path)?
        {
            found.push(child);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_an_old_crate_is_not_called_damaged() {
        let path = sdf::Path::new("/Top/mesh_0").expect("a path");
        let of = |words: &str| Err::<(), _>(words).or_unreadable(&path).expect_err("a failure").faults.remove(0);
        let old = of("failed to decode field \"timeSamples\" at /Top/mesh_0.points");
        assert_eq!(old.code, codes::NOT_SUPPORTED);
        assert!(old.remedy.contains("usdcat"), "{}", old.remedy);
        assert_eq!(of("the end of the file came too early").code, tailor_mesh::codes::DAMAGED_FILE);
    }
}
