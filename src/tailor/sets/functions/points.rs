//! The functions that give points.

use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};
use tailor_mesh::connectivity::{FaceId, VertexId};
use tailor_mesh::garment::{Interpolation, Primvar, Values};

type Found = Result<ElementSet, SetFault>;

/// The number that a weight has to exceed, if none is given.
const HALF: f64 = 0.5;

pub fn points(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    if !arguments.has(0) {
        return Ok(ElementSet::Points((0..t.vertex_count()).map(VertexId::new).collect()));
    }
    Ok(ElementSet::Points(arguments.set(of, 0)?.points(t)))
}

pub fn weight(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let least = arguments.number(1, HALF)?;
    let Some(primvar) = of.primvar(arguments, "the painted weights", is_weight)? else {
        return Ok(ElementSet::Points(Default::default()));
    };
    let number = |element: usize| match &primvar.values {
        Values::F32(values) => f64::from(values[primvar.row(element)]),
        Values::F64(values) => values[primvar.row(element)],
        _ => f64::NAN,
    };
    let found = elements(primvar, |element| number(element) > least);
    if found.is_empty() {
        let most = (0..primvar.elements()).map(number).fold(f64::NEG_INFINITY, f64::max);
        of.note(format!("its largest value is {most}"));
    }
    Ok(found)
}

/// True for a primvar of one real number a point or face.
pub fn is_weight(primvar: &Primvar) -> bool {
    primvar.width() == 1 && matches!(primvar.values, Values::F32(_) | Values::F64(_)) && is_of_elements(primvar)
}

/// True for a primvar with a value for each face or point.
pub fn is_of_elements(primvar: &Primvar) -> bool {
    matches!(primvar.interpolation, Interpolation::Uniform | Interpolation::Vertex | Interpolation::Varying)
}

/// The faces or points of a primvar that are `in` a set.
pub fn elements(primvar: &Primvar, is_in: impl Fn(usize) -> bool) -> ElementSet {
    let all = (0..primvar.elements()).filter(|&element| is_in(element));
    match primvar.interpolation {
        Interpolation::Uniform => ElementSet::Faces(all.map(FaceId::new).collect()),
        _ => ElementSet::Points(all.map(VertexId::new).collect()),
    }
}
