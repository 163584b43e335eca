//! Reading blend shapes (`UsdSkelBlendShape`) below the model or bound to it.

use super::query::{OrUnreadable, is_a, prim_at, prim_name, property_names, value};
use crate::codes;
use crate::names;
use crate::record::{Depth, Record};
use openusd::gf::Vec3f;
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, TimeCode};
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{Interpolation, Meaning, PrimvarInput, PrimvarRole, Values};

/// A blend shape without its offsets, which are carried as vertex primvars.
#[derive(Clone, Debug)]
pub struct BlendShape {
    /// Name of its prim.
    pub name: String,
    /// Its name in `skel:blendShapes`, if it is bound.
    pub binding: Option<String>,
    /// Declarations of the properties that hold offsets.
    pub properties: Vec<Record>,
}

/// Blend shapes and their offsets.
type Shapes = (Vec<BlendShape>, Vec<PrimvarInput>);

/// Reads the blend shapes of a model of `points` points, and their offsets. Those that cannot be read become warnings.
///
/// # Errors
/// A stage that cannot be queried.
pub fn read_shapes(prim: &Prim, time: Option<TimeCode>, points: usize) -> Result<(Shapes, Warnings), Error> {
    let (mut found, mut primvars, mut warnings) = (Vec::new(), Vec::new(), Warnings::default());
    for (path, binding) in warnings.absorb(targets(prim, time)?) {
        match read_shape(prim, &path, binding, found.len(), points) {
            Ok((shape, offsets)) => {
                found.push(shape);
                primvars.extend(offsets);
            }
            Err(e) => warnings.push(Warning::unread(format!("blend shape {path}"), &e)),
        }
    }
    Ok(((found, primvars), warnings))
}

/// A blend shape with its name in the binding.
type Target = (Path, Option<String>);

/// The blend shapes that the model is bound to, in that order, then those below it. Warns of a binding that does not name each.
fn targets(prim: &Prim, time: Option<TimeCode>) -> Result<(Vec<Target>, Warnings), Error> {
    let bound = match value(prim, names::SKEL_BLEND_SHAPES, time) {
        Ok(Some(Value::TokenVec(tokens))) => tokens,
        _ => Vec::new(),
    };
    let paths = prim.relationship(names::SKEL_BLEND_SHAPE_TARGETS).targets().or_unreadable(prim.path())?;
    let is_paired = bound.len() == paths.len();
    let unpaired = (!is_paired).then(|| {
        let place = format!("the binding of {}.{}", prim.path(), names::SKEL_BLEND_SHAPES);
        let why = format!("it names {} shapes, but there are {} targets", bound.len(), paths.len());
        Warning::not_carried(place, why)
    });
    let name = |i: usize| is_paired.then(|| bound[i].as_str().to_owned());
    let mut all: Vec<Target> = paths.into_iter().enumerate().map(|(i, p)| (p, name(i))).collect();
    for child in prim.children().or_unreadable(prim.path())? {
        let is_shape = is_a(&child, names::BLEND_SHAPE)? && child.is_active().or_unreadable(child.path())?;
        if is_shape && all.iter().all(|(path, _)| path != child.path()) {
            all.push((child.path().clone(), None));
        }
    }
    Ok((all, Warnings::from_iter(unpaired)))
}

/// Reads one shape; the error is the reason why it cannot be carried.
fn read_shape(
    model: &Prim,
    path: &Path,
    binding: Option<String>,
    number: usize,
    points: usize,
) -> Result<(BlendShape, Vec<PrimvarInput>), Error> {
    let prim = prim_at(model.stage(), path)?;
    if !is_a(&prim, names::BLEND_SHAPE)? {
        return Err(Error::usd("there is no BlendShape prim").code(codes::ATTRIBUTE_TYPE));
    }
    let indices = match value(&prim, names::POINT_INDICES, None)? {
        Some(Value::IntVec(indices)) => Some(indices),
        None => None,
        Some(_) => return Err(Error::usd("its pointIndices are not of type int[]").code(codes::ATTRIBUTE_TYPE)),
    };
    let mut shape = BlendShape { name: prim_name(&prim), binding, properties: Vec::new() };
    let mut primvars = Vec::new();
    for name in property_names(&prim)? {
        if !(name == names::OFFSETS || name == names::NORMAL_OFFSETS || name.starts_with(names::INBETWEENS)) {
            continue;
        }
        let offsets = match value(&prim, &name, None)? {
            Some(Value::Vec3fVec(offsets)) => offsets,
            None => continue,
            Some(_) => {
                return Err(Error::usd(format!("its {name} are not three floats each")).code(codes::ATTRIBUTE_TYPE));
            }
        };
        let values = dense(&offsets, indices.as_deref(), points);
        let values = values.map_err(|why| Error::usd(format!("its {name} {why}")).code(codes::ATTRIBUTE_TYPE))?;
        shape.properties.extend(Record::take(&prim, &name, Depth::Declaration).or_unreadable(path)?);
        primvars.push(PrimvarInput {
            name: format!("{path}.{name}"),
            role: PrimvarRole::BlendShape { shape: number, property: name },
            meaning: Meaning::Vector,
            half: false,
            interpolation: Interpolation::Vertex,
            components: 3,
            element_size: 1,
            values: Values::F32(values),
            indices: None,
        });
    }
    Ok((shape, primvars))
}

/// An offset for every point; zero for those without one.
fn dense(offsets: &[Vec3f], indices: Option<&[i32]>, points: usize) -> Result<Vec<f32>, String> {
    let flat: &[f32] = bytemuck::cast_slice(offsets);
    // An empty array means no offsets.
    let count = if flat.is_empty() { 0 } else { indices.map_or(points, <[i32]>::len) };
    if offsets.len() != count {
        return Err(format!("are {} for {count} points", offsets.len()));
    }
    let mut values = vec![0.0; 3 * points];
    for (i, offset) in flat.chunks_exact(3).enumerate() {
        let named = indices.map_or(i as i32, |all| all[i]);
        let point = usize::try_from(named).ok().filter(|&p| p < points);
        let Some(point) = point else { return Err(format!("name point {named}, of {points}")) };
        values[3 * point..3 * point + 3].copy_from_slice(offset);
    }
    Ok(values)
}
