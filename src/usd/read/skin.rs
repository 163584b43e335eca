//! The joints of a skinned mesh.

use super::query::with_ancestors;
use super::query::{OrUnreadable, prim_at, value};
use crate::names;
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::{
    PrimvarInput, Values,
    joints::{JOINT_INDICES, JOINT_WEIGHTS},
};

/// Refuses influences of joints that the skeleton does not have. OpenUSD skins no point of such a mesh. Where the skeleton is the one
/// joint that Blender makes for shape keys without their armature, the skin is left out, with a warning.
///
/// # Errors
/// The first such influence.
pub fn check_joints(
    prim: &Prim,
    primvars: &mut Vec<PrimvarInput>,
    time: Option<TimeCode>,
) -> Result<Option<Warning>, Error> {
    let Some(primvar) = primvars.iter().find(|primvar| primvar.name == JOINT_INDICES) else { return Ok(None) };
    let Values::I32(joints) = &primvar.values else { return Ok(None) };
    let count = joint_count(prim, time)?;
    let is_known = |joint: i32| joint >= 0 && count.is_none_or(|count| (joint as usize) < count);
    let Some(at) = joints.iter().position(|joint| !is_known(*joint)) else { return Ok(None) };
    let size = usize::try_from(primvar.element_size).unwrap_or(1).max(1);
    let (joint, row) = (joints[at], at / size);
    if count == Some(1) && joint > 0 {
        let why =
            format!("it names joint {joint}, and its skeleton has one joint, as of an export without the armature");
        primvars.retain(|primvar| ![JOINT_INDICES, JOINT_WEIGHTS].contains(&primvar.name.as_str()));
        let warning = Warning::not_carried(format!("the skin of {}", prim.path()), why);
        return Ok(Some(warning.remedy("Export the garment with its armature")));
    }
    let has =
        count.map_or_else(|| "joints are numbered from 0".to_owned(), |count| format!("there are {count} joints"));
    Err(Error::usd(format!("{}.primvars:{JOINT_INDICES}: value {row} names joint {joint}, and {has}", prim.path()))
        .code(tailor_mesh::codes::INDEX_OUT_OF_RANGE)
        .remedy("bind the mesh to its skeleton again; unused influences have joint 0 and weight 0"))
}

/// The number of joints: those that the mesh lists, or those of the skeleton to which it or a prim above it is bound.
fn joint_count(prim: &Prim, time: Option<TimeCode>) -> Result<Option<usize>, Error> {
    if let Some(count) = joints_of(prim, names::SKEL_JOINTS, time)? {
        return Ok(Some(count));
    }
    for path in with_ancestors(prim.path()) {
        let targets =
            prim_at(prim.stage(), &path)?.relationship(names::SKEL_SKELETON).targets().or_unreadable(&path)?;
        if let Some(target) = targets.first() {
            return joints_of(&prim_at(prim.stage(), target)?, "joints", time);
        }
    }
    Ok(None)
}

fn joints_of(prim: &Prim, name: &str, time: Option<TimeCode>) -> Result<Option<usize>, Error> {
    Ok(match value(prim, name, time)? {
        Some(Value::TokenVec(joints)) => Some(joints.len()),
        _ => None,
    })
}
