//! The size of the unit of a mesh.

use super::xform::transforms;
use crate::names;
use crate::read::query::{OrUnreadable, primvar_names, value};
use glam::{DMat3, DMat4};
use openusd::sdf::{self, Value};
use openusd::usd::{Prim, Stage, TimeCode};
use std::collections::BTreeMap;
use tailor_mesh::error::Error;
use tailor_mesh::garment::{StageSpace, Units};

/// The units of the mesh `prim` at `time`.
///
/// # Errors
/// A transform that cannot be read.
pub fn units(prim: &Prim, time: Option<TimeCode>) -> Result<Units, Error> {
    let stage = prim.stage();
    let root = sdf::Path::abs_root();
    let meters: Option<Value> = stage.field(&root, names::METERS_PER_UNIT).or_unreadable(&root)?;
    let meters_per_unit = match meters {
        Some(Value::Double(meters)) if meters > 0.0 && meters.is_finite() => meters,
        _ => Units::default().meters_per_unit,
    };
    let scale = transforms(prim, time)?.to_world.determinant().abs().cbrt();
    let usable = scale.is_finite() && scale > 0.0;
    Ok(Units { meters_per_unit, scale: if usable { scale } else { 1.0 } })
}

/// How a mesh with a transform lies in its stage.
///
/// # Errors
/// A stage that cannot be read.
pub fn space(stage: &Stage, to_world: &DMat4) -> Result<StageSpace, Error> {
    let root = sdf::Path::abs_root();
    let axis: Option<Value> = stage.field(&root, names::UP_AXIS).or_unreadable(&root)?;
    let is_z_up = matches!(axis, Some(Value::Token(axis)) if axis.as_str() == "Z");
    Ok(StageSpace { to_stage: DMat3::from_mat4(*to_world).as_mat3(), is_z_up })
}

/// The constant primvars `<name>Scale` of a mesh, by `<name>`.
///
/// # Errors
/// A primvar that cannot be read.
pub fn uv_scales(prim: &Prim, time: Option<TimeCode>) -> Result<BTreeMap<String, f32>, Error> {
    let mut scales = BTreeMap::new();
    for primvar in primvar_names(prim)? {
        let Some(name) = primvar.strip_suffix("Scale") else { continue };
        match value(prim, &format!("{}{primvar}", names::PRIMVARS), time) {
            Ok(Some(Value::Float(scale))) => scales.insert(name.to_owned(), scale),
            Ok(Some(Value::Double(scale))) => scales.insert(name.to_owned(), scale as f32),
            _ => continue,
        };
    }
    Ok(scales)
}
