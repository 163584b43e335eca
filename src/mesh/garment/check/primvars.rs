//! Primvars: their lengths, their indices and their numbers.

use super::mesh::{Count, Indices, MeshCheck};
use super::problem::Problems;
use crate::codes;
use crate::connectivity::ValueId;
use crate::garment::joints::{JOINT_INDICES, JOINT_WEIGHTS};
use crate::garment::{Interpolation, LeftOut, Meaning, Primvar, PrimvarInput, PrimvarRole, Values};
use std::collections::HashSet;
use std::sync::Arc;

/// The primvars, in the order in which they were authored, and those with faults that no step needs.
pub(super) fn primvars(
    inputs: Vec<PrimvarInput>,
    mesh: &MeshCheck<'_>,
    prim: &str,
    problems: &mut Problems,
) -> (Vec<Primvar>, Vec<LeftOut>) {
    check_names(&inputs, problems);
    let (mut found, mut left_out) = (Vec::new(), Vec::new());
    for input in inputs {
        if is_needed(&input) {
            found.extend(primvar(input, mesh, problems));
            continue;
        }
        let (name, mut own) = (input.name.clone(), Problems::default());
        let checked = primvar(input, mesh, &mut own);
        if own.is_empty() {
            found.extend(checked);
        } else {
            let fault = own.into_error(prim).faults.swap_remove(0);
            left_out.push(LeftOut { name, fault });
        }
    }
    (found, left_out)
}

/// Whether a mesh with faults in the primvar is refused: seams come from UVs, and motion from joints and blend shapes.
fn is_needed(input: &PrimvarInput) -> bool {
    let is_skinning = [JOINT_INDICES, JOINT_WEIGHTS].contains(&input.name.as_str());
    let is_pair = input.components == 2 && matches!(input.values, Values::F32(_));
    is_skinning
        || matches!(input.role, PrimvarRole::BlendShape { .. })
        || input.meaning == Meaning::TextureCoordinate
        || (is_pair && input.interpolation == Interpolation::FaceVarying)
}

/// Checks that names are unique.
fn check_names(inputs: &[PrimvarInput], problems: &mut Problems) {
    let mut seen = HashSet::new();
    for input in inputs.iter().filter(|input| !seen.insert(input.name.as_str())) {
        let remedy = format_args!("rename or remove one of the two");
        problems.add(
            codes::DUPLICATE_PRIMVAR,
            &attribute(input),
            format_args!("there are two primvars of this name"),
            remedy,
        );
    }
}

/// One primvar; none where its rows are unknown.
fn primvar(input: PrimvarInput, mesh: &MeshCheck<'_>, problems: &mut Problems) -> Option<Primvar> {
    let element_size = element_size(&input, problems)?;
    let width = input.components * element_size;
    let rows = rows(&input, element_size, problems)?;
    check_finite(&input, width, mesh, problems);
    let indices = match &input.indices {
        Some(indices) => Some(row_indices(&input, indices, rows, mesh, problems)),
        None => {
            check_rows(&input, rows, element_size, mesh, problems);
            None
        }
    };
    Some(Primvar {
        name: input.name,
        role: input.role,
        meaning: input.meaning,
        half: input.half,
        interpolation: input.interpolation,
        components: input.components,
        element_size,
        values: input.values,
        indices: indices.map(Arc::new),
    })
}

/// The attribute that holds the values, as problems name it.
fn attribute(input: &PrimvarInput) -> String {
    match input.role {
        PrimvarRole::Primvar => format!("primvars:{}", input.name),
        PrimvarRole::Normals | PrimvarRole::BlendShape { .. } => input.name.clone(),
    }
}

/// The kind of element that carries the values.
fn carrier(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Constant => "mesh",
        Interpolation::Uniform => "face",
        Interpolation::Varying | Interpolation::Vertex => "point",
        Interpolation::FaceVarying => "corner",
    }
}

/// `elementSize`, if it is positive.
fn element_size(input: &PrimvarInput, problems: &mut Problems) -> Option<usize> {
    let size = usize::try_from(input.element_size).ok().filter(|&n| n > 0);
    if size.is_none() {
        let fault = format_args!("elementSize is {}, but an element has one value or more", input.element_size);
        problems.add(
            codes::VALUE_COUNT,
            &attribute(input),
            fault,
            format_args!("set elementSize to the number of values in an element"),
        );
    }
    size
}

/// The number of rows, if the values fill them.
fn rows(input: &PrimvarInput, element_size: usize, problems: &mut Problems) -> Option<usize> {
    let (numbers, components) = (input.values.len(), input.components);
    if components == 0 || !numbers.is_multiple_of(components) {
        let fault = format_args!("{numbers} numbers do not make whole values of {components}");
        problems.add(
            codes::VALUE_COUNT,
            &attribute(input),
            fault,
            format_args!("author the values again with their full type"),
        );
        return None;
    }
    let values = numbers / components;
    if !values.is_multiple_of(element_size) {
        let fault = format_args!("holds {}, no multiple of elementSize {element_size}", Count(values, "value"));
        let remedy = format_args!("give {element_size} values for each element, or correct elementSize");
        problems.add(codes::VALUE_COUNT, &attribute(input), fault, remedy);
        return None;
    }
    Some(values / element_size)
}

/// Checks that real numbers are finite, as interpolation would spread others.
fn check_finite(input: &PrimvarInput, width: usize, mesh: &MeshCheck<'_>, problems: &mut Problems) {
    match &input.values {
        Values::F32(v) => check_each_finite(input, v, width, mesh, problems),
        Values::F64(v) => check_each_finite(input, v, width, mesh, problems),
        _ => {}
    }
}

/// Checks that every number in `values` is finite; lists one for each row.
fn check_each_finite<T>(input: &PrimvarInput, values: &[T], width: usize, mesh: &MeshCheck<'_>, problems: &mut Problems)
where
    T: Copy + Into<f64>,
{
    for (row, numbers) in values.chunks_exact(width).enumerate() {
        let Some(number) = numbers.iter().map(|&n| n.into()).find(|n: &f64| !n.is_finite()) else { continue };
        let interpolation = if input.indices.is_some() { Interpolation::Constant } else { input.interpolation };
        let place = mesh.element(interpolation, row);
        let fault = format_args!("{place} holds {number}, which is not finite");
        problems.add(codes::NOT_FINITE, &attribute(input), fault, format_args!("replace it by a finite number"));
    }
}

/// Checks that there is one row for each element.
fn check_rows(input: &PrimvarInput, rows: usize, element_size: usize, mesh: &MeshCheck<'_>, problems: &mut Problems) {
    let Some(elements) = mesh.elements(input.interpolation).filter(|&n| n != rows) else { return };
    let (token, carrier) = (input.interpolation.word(), carrier(input.interpolation));
    let (found, needed) = (Count(rows * element_size, "value"), elements * element_size);
    let fault = format_args!(
        "holds {found}, but {token} interpolation needs {needed}: {element_size} for each of {}",
        Count(elements, carrier)
    );
    let attribute = attribute(input);
    let size = rows / elements.max(1);
    let other = match fitting(rows, mesh) {
        Some(other) => format!("set interpolation to {other}"),
        None if size > 1 && rows == size * elements => {
            format!("set elementSize to {}, as {rows} are {size} x {elements}", size * element_size)
        }
        None => "correct the interpolation".to_owned(),
    };
    problems.add(codes::VALUE_COUNT, &attribute, fault, format_args!("give {needed} values, or {other}"));
}

/// The interpolation that `rows` rows fit.
fn fitting(rows: usize, mesh: &MeshCheck<'_>) -> Option<&'static str> {
    let all = [Interpolation::Vertex, Interpolation::FaceVarying, Interpolation::Uniform];
    all.into_iter().find(|&i| mesh.elements(i) == Some(rows)).map(Interpolation::word)
}

/// The row of each element.
fn row_indices(
    input: &PrimvarInput,
    indices: &[i32],
    rows: usize,
    mesh: &MeshCheck<'_>,
    problems: &mut Problems,
) -> Vec<u32> {
    let attribute = format!("{}:indices", attribute(input));
    let interpolation = input.interpolation;
    if let Some(elements) = mesh.elements(interpolation).filter(|&n| n != indices.len()) {
        let (token, carrier) = (interpolation.word(), carrier(interpolation));
        let found = Count(indices.len(), "index");
        let fault = format_args!("holds {found}, but {token} interpolation needs {elements}, one for each {carrier}");
        let other = fitting(indices.len(), mesh).map(|other| format!("set interpolation to {other}"));
        let other = other.unwrap_or_else(|| "correct the interpolation".to_owned());
        problems.add(codes::VALUE_COUNT, &attribute, fault, format_args!("give {elements} indices, or {other}"));
    }
    let values = Indices { attribute: &attribute, kind: "value", count: Some(rows) };
    let handles: Vec<Option<ValueId>> = values.handles(indices, |e| mesh.element(interpolation, e), problems);
    handles.into_iter().flatten().map(|row| row.index() as u32).collect()
}
