//! Blend shapes (`UsdSkelBlendShape`) under the model or bound to it.

use super::UsdError;
use super::choose::prim_at;
use super::geometry::value;
use super::names;
use super::product::Author;
use super::record::{Depth, Record};
use crate::error::Warning;
use crate::garment::{Garment, Interpolation, Mixing, PrimvarInput, PrimvarRole, Values};
use openusd::gf::Vec3f;
use openusd::sdf::{self, AbstractData, FieldKey, Path, PrimSpec, Specifier, Value};
use openusd::tf::Token;
use openusd::usd::{Prim, TimeCode};
use std::collections::BTreeSet;

/// A blend shape without its offsets, which are carried as vertex primvars.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Name of its prim.
    pub name: String,
    /// Its name in `skel:blendShapes`, if it is bound.
    pub binding: Option<String>,
    /// Declarations of the properties that hold offsets.
    channels: Vec<Record>,
}

/// The blend shapes of the model and their offsets; what cannot be read becomes a warning.
///
/// # Errors
/// A stage that cannot be queried.
pub fn read_shapes(
    prim: &Prim,
    time: Option<TimeCode>,
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<Shape>, Vec<PrimvarInput>), UsdError> {
    let points = match value(prim, names::POINTS, time)? {
        Some(Value::Vec3fVec(points)) => points.len(),
        _ => 0,
    };
    let (mut found, mut primvars) = (Vec::new(), Vec::new());
    for (path, binding) in targets(prim, time, warnings)? {
        match read_shape(prim, &path, binding, found.len(), points) {
            Ok((shape, channels)) => {
                found.push(shape);
                primvars.extend(channels);
            }
            Err(why) => warnings.push(Warning::NotCarried { what: format!("blend shape {path}"), why }),
        }
    }
    Ok((found, primvars))
}

/// The blend shapes that the model is bound to, in that order, then those below it.
fn targets(
    prim: &Prim,
    time: Option<TimeCode>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(Path, Option<String>)>, UsdError> {
    let fault = |e: openusd::Error| UsdError::new(format!("{} cannot be read: {e}", prim.path()));
    let mut bound: Vec<String> = match value(prim, names::SKEL_BLEND_SHAPES, time) {
        Ok(Some(Value::TokenVec(tokens))) => tokens.iter().map(|t| t.as_str().to_owned()).collect(),
        _ => Vec::new(),
    };
    let paths = prim.relationship(names::SKEL_BLEND_SHAPE_TARGETS).targets().map_err(fault)?;
    if bound.len() != paths.len() {
        warnings.push(Warning::NotCarried {
            what: format!("the binding of {}.{}", prim.path(), names::SKEL_BLEND_SHAPES),
            why: format!("it names {} shapes, but there are {} targets", bound.len(), paths.len()),
        });
        bound.clear();
    }
    let mut names = bound.into_iter();
    let mut all: Vec<(Path, Option<String>)> = paths.into_iter().map(|p| (p, names.next())).collect();
    for child in prim.children().map_err(fault)? {
        let is_shape = child.type_name().map_err(fault)?.is_some_and(|t| t.as_str() == names::BLEND_SHAPE);
        if is_shape && child.is_active().map_err(fault)? && all.iter().all(|(path, _)| path != child.path()) {
            all.push((child.path().clone(), None));
        }
    }
    Ok(all)
}

/// One shape, and the reason where it cannot be carried.
fn read_shape(
    model: &Prim,
    path: &Path,
    binding: Option<String>,
    number: usize,
    points: usize,
) -> Result<(Shape, Vec<PrimvarInput>), String> {
    let prim = prim_at(model.stage(), path).map_err(|e| e.message)?;
    let is_shape = prim.type_name().map_err(|e| e.to_string())?.is_some_and(|t| t.as_str() == names::BLEND_SHAPE);
    if !is_shape {
        return Err("there is no BlendShape prim".into());
    }
    let of = |name: &str| value(&prim, name, None).map_err(|e| e.message);
    let indices = match of(names::POINT_INDICES)? {
        Some(Value::IntVec(indices)) => Some(indices),
        None => None,
        Some(_) => return Err("its pointIndices are not of type int[]".into()),
    };
    let mut shape = Shape { name: path.name().unwrap_or_default().to_owned(), binding, channels: Vec::new() };
    let mut channels = Vec::new();
    for name in prim.authored_property_names().map_err(|e| e.to_string())? {
        if !(name == names::OFFSETS || name == names::NORMAL_OFFSETS || name.starts_with(names::INBETWEENS)) {
            continue;
        }
        let Some(offsets) = of(&name)? else { continue };
        let Value::Vec3fVec(offsets) = offsets else { return Err(format!("its {name} are not three floats each")) };
        let values = dense(&offsets, indices.as_deref(), points).map_err(|why| format!("its {name} {why}"))?;
        channels.push(PrimvarInput {
            name: format!("{path}.{name}"),
            role: PrimvarRole::BlendShape { shape: number, property: name.to_string() },
            type_name: "vector3f[]".into(),
            interpolation: Interpolation::Vertex,
            components: 3,
            element_size: 1,
            mixing: Mixing::Linear,
            values: Values::F32(values),
            indices: None,
        });
        shape.channels.extend(Record::take(&prim, &name, Depth::Declaration).map_err(|e| e.to_string())?);
    }
    Ok((shape, channels))
}

/// An offset for every point.
fn dense(offsets: &[Vec3f], indices: Option<&[i32]>, points: usize) -> Result<Vec<f32>, String> {
    let flat: &[f32] = bytemuck::cast_slice(offsets);
    // An empty array stands for no offsets at all.
    let count = if flat.is_empty() { 0 } else { indices.map_or(points, <[i32]>::len) };
    if offsets.len() != count {
        return Err(format!("are {} for {count} points", offsets.len()));
    }
    let mut values = vec![0.0; 3 * points];
    for (i, offset) in flat.chunks_exact(3).enumerate() {
        let point = indices.map_or(Some(i), |all| usize::try_from(all[i]).ok()).filter(|&p| p < points);
        let Some(point) = point else { return Err(format!("name point {}, of {points}", indices.map_or(0, |a| a[i]))) };
        values[3 * point..3 * point + 3].copy_from_slice(offset);
    }
    Ok(values)
}

impl Author<'_> {
    /// States the blend shapes below a product, and binds it to them.
    ///
    /// # Errors
    /// A name or type that the layer does not admit.
    pub fn shapes(&mut self, prim: &Path, mesh: &Garment) -> openusd::Result<()> {
        let mut taken: BTreeSet<String> = mesh.subsets.iter().map(|s| s.name.clone()).collect();
        let (mut tokens, mut targets) = (Vec::new(), Vec::new());
        let model = self.model;
        for (number, shape) in model.shapes.iter().enumerate() {
            let mut numbered = (1..).map(|n| if n == 1 { shape.name.clone() } else { format!("{}_{n}", shape.name) });
            let Some(name) = numbered.find(|n| !taken.contains(n)) else { continue };
            let path = prim.append_path(name.as_str())?;
            taken.insert(name);
            self.shape(&path, number, shape, mesh)?;
            if let Some(binding) = &shape.binding {
                tokens.push(Token::from(binding.as_str()));
                targets.push(path);
            }
        }
        if !targets.is_empty() {
            let (name, value) = (names::SKEL_BLEND_SHAPES, Value::TokenVec(tokens));
            let (type_name, uniform) = (sdf::ValueTypeName::TOKEN_ARRAY, sdf::Variability::Uniform);
            self.attribute(prim, name, type_name, uniform, value)?;
            let path = prim.append_property(names::SKEL_BLEND_SHAPE_TARGETS)?;
            sdf::RelationshipSpec::new(self.data, &path, uniform, false)?;
            let targets = sdf::PathListOp::explicit(targets);
            AbstractData::set_field(self.data, &path, FieldKey::TargetPaths.as_str(), targets.into());
        }
        Ok(())
    }

    /// One blend shape: the points that it moves, and how.
    fn shape(&mut self, path: &Path, number: usize, shape: &Shape, mesh: &Garment) -> openusd::Result<()> {
        PrimSpec::new(self.data, path, Specifier::Def, names::BLEND_SHAPE)?;
        let channels: Vec<(&Record, &[f32])> = shape
            .channels
            .iter()
            .filter_map(|record| {
                let role = PrimvarRole::BlendShape { shape: number, property: record.name.clone() };
                match &mesh.primvars.iter().find(|p| p.role == role)?.values {
                    Values::F32(values) => Some((record, values.as_slice())),
                    _ => None,
                }
            })
            .collect();
        let moves = |point: &usize| channels.iter().any(|(_, v)| v[3 * point..3 * point + 3].iter().any(|x| *x != 0.0));
        let moved: Vec<usize> = (0..mesh.points.len()).filter(moves).collect();
        self.ints(path, names::POINT_INDICES, moved.iter().map(|&p| p as i32).collect())?;
        for (record, values) in channels {
            let offset = |&p: &usize| Vec3f::from([values[3 * p], values[3 * p + 1], values[3 * p + 2]]);
            let offsets = moved.iter().map(offset).collect();
            let property = record.declare(self.data, path)?;
            AbstractData::set_field(self.data, &property, FieldKey::Default.as_str(), Value::Vec3fVec(offsets));
        }
        Ok(())
    }
}
