//! Transforms of prims, from their ops.

use crate::codes;
use crate::read::origin::StageOrigin;
use crate::read::query::{OrUnreadable, prim_at, property_names, value, with_ancestors};
use crate::{names, on_large_stack};
use glam::{DMat4, DQuat, DVec3};
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, TimeCode};
use tailor_mesh::error::Error;

/// Resets the transform of ancestors, as an entry of `xformOpOrder`.
const RESET: &str = "!resetXformStack!";
/// Prefix of inverted entries of `xformOpOrder`.
const INVERT: &str = "!invert!";

/// The transforms of a prim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transforms {
    /// From its own space to that of its parent.
    pub to_parent: DMat4,
    /// From its own space to the stage's.
    pub to_world: DMat4,
}

/// The transforms of `prim` at `time`. Animated ops without a default count as the identity when no time is given.
///
/// # Errors
/// A stage that cannot be queried.
pub fn transforms(prim: &Prim, time: Option<TimeCode>) -> Result<Transforms, Error> {
    let ancestors: Vec<Path> = prim.path().strict_ancestors_below_root().collect();
    let mut parent = DMat4::IDENTITY;
    for path in ancestors.iter().rev() {
        let (own, is_reset) = local(&prim_at(prim.stage(), path)?, time);
        parent = if is_reset { own } else { parent * own };
    }
    let (own, is_reset) = local(prim, time);
    Ok(match is_reset {
        true => Transforms { to_parent: parent.inverse() * own, to_world: own },
        false => Transforms { to_parent: own, to_world: parent * own },
    })
}

/// Whether transforms of `prim` or of those above it change over time.
///
/// # Errors
/// A stage that cannot be queried.
pub fn is_moving(prim: &Prim) -> Result<bool, Error> {
    for path in with_ancestors(prim.path()) {
        let prim = prim_at(prim.stage(), &path)?;
        for name in property_names(&prim)?.iter().filter(|name| name.starts_with(names::XFORM_OP)) {
            if prim.attribute(name.as_str()).num_time_samples().or_unreadable(&path)? > 0 {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// The path of the prim at `target` in a stage, and its transform to the stage's space.
///
/// # Errors
/// A prim that the stage lacks.
pub fn world_of(origin: &StageOrigin, target: &str) -> Result<(Path, DMat4), Error> {
    let fault = |text: &str| Error::recipe("cloth.pinTarget", format!("{target} {text}")).code(codes::PIN_TARGET);
    let path = Path::new(target).map_err(|_| fault("is not a prim path").remedy("write it as /Body/hips"))?;
    on_large_stack(|| {
        let stage = origin.open()?;
        let prim = prim_at(&stage, &path)?;
        if !prim.is_valid().or_unreadable(&path)? {
            return Err(
                fault("is not a prim of the stage").remedy("name a prim that the garment's file or its layers have")
            );
        }
        Ok((path.clone(), transforms(&prim, None)?.to_world))
    })
}

/// The transform of a prim's own ops, and whether it resets that of its ancestors.
fn local(prim: &Prim, time: Option<TimeCode>) -> (DMat4, bool) {
    let type_name = prim.type_name().ok().flatten();
    if type_name.is_none_or(|name| name.is_empty() || name.as_str() == "Scope") {
        // USD takes no ops of prims without a place in space.
        return (DMat4::IDENTITY, false);
    }
    let Ok(Some(Value::TokenVec(order))) = value(prim, names::XFORM_OP_ORDER, time) else {
        return (DMat4::IDENTITY, false);
    };
    let (mut matrix, mut is_reset) = (DMat4::IDENTITY, false);
    for op in &order {
        if op.as_str() == RESET {
            (matrix, is_reset) = (DMat4::IDENTITY, true);
            continue;
        }
        let (name, inverted) = op.as_str().strip_prefix(INVERT).map_or((op.as_str(), false), |name| (name, true));
        let by = value(prim, name, time).ok().flatten().and_then(|value| op_matrix(name, &value));
        let by = by.unwrap_or(DMat4::IDENTITY);
        matrix *= if inverted { by.inverse() } else { by };
    }
    (matrix, is_reset)
}

/// The matrix of an op such as `xformOp:rotateXYZ:pivot`; `None` for a type that its values cannot have.
fn op_matrix(name: &str, value: &Value) -> Option<DMat4> {
    let kind = name.strip_prefix(names::XFORM_OP)?.split(':').next()?;
    let (kind, axes) = kind.split_at(kind.find(['X', 'Y', 'Z']).unwrap_or(kind.len()));
    let number = || value.clone().cast::<f64>().ok();
    let vector = || value.clone().cast::<[f64; 3]>().ok().map(DVec3::from);
    let axis = || DVec3::AXES.get("XYZ".find(axes)?).copied();
    Some(match (kind, axes.len(), value) {
        ("translate", 0, _) => DMat4::from_translation(vector()?),
        ("translate", 1, _) => DMat4::from_translation(number()? * axis()?),
        ("scale", 0, _) => DMat4::from_scale(vector()?),
        ("scale", 1, _) => DMat4::from_scale(DVec3::ONE + (number()? - 1.0) * axis()?),
        ("rotate", 1, _) => DMat4::from_axis_angle(axis()?, number()?.to_radians()),
        ("rotate", 3, _) => {
            let angles = vector()?;
            // The first axis of the name is applied first.
            axes.chars().try_fold(DMat4::IDENTITY, |matrix, letter| {
                let k = "XYZ".find(letter)?;
                Some(DMat4::from_axis_angle(DVec3::AXES[k], angles[k].to_radians()) * matrix)
            })?
        }
        ("orient", 0, _) => {
            let [w, x, y, z] = value.clone().cast::<[f64; 4]>().ok()?;
            DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize())
        }
        // USD multiplies rows, so that its rows are columns here.
        ("transform", 0, Value::Matrix4d(m)) => DMat4::from_cols_array(&m.0),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ops_move_points_as_usd_does() {
        let angles = Value::Vec3d([90.0, 0.0, 90.0].into());
        let turned = op_matrix("xformOp:rotateXYZ:pivot", &angles).expect("a rotation");
        // About x first: y goes to z, which the turn about z leaves.
        assert!(turned.transform_point3(DVec3::Y).distance(DVec3::Z) < 1e-12);
        assert!(turned.transform_point3(DVec3::X).distance(DVec3::Y) < 1e-12);
        assert_eq!(op_matrix("xformOp:translate", &Value::Double(1.0)), None);
        let of_one =
            |name: &str, by: f64| op_matrix(name, &Value::Double(by)).expect(name).transform_point3(DVec3::ONE);
        assert_eq!(of_one("xformOp:translateY", 2.0), DVec3::new(1.0, 3.0, 1.0));
        assert_eq!(of_one("xformOp:scaleZ:stretch", 2.0), DVec3::new(1.0, 1.0, 2.0));
    }
}
