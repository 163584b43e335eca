//! Creases and corners.

use super::mesh::{Count, Entry, Indices, MeshCheck, Repeat, repeats};
use super::problem::Problems;
use crate::codes;
use crate::connectivity::VertexId;
use crate::garment::{Corner, Crease, Garment};

/// Infinite sharpness, as in OpenSubdiv.
const INFINITE_SHARPNESS: f32 = 10.0;

/// The creases.
pub(super) fn creases(input: &Garment, mesh: &MeshCheck<'_>, problems: &mut Problems) -> Vec<Crease> {
    let sharpnesses = sharpnesses("creaseSharpnesses", &input.crease_sharpnesses, problems);
    let indices = Indices { attribute: "creaseIndices", kind: "point", count: mesh.points };
    let vertices = indices.handles(&input.crease_indices, |i| Entry("entry", i), problems);
    let Some(lengths) = lengths(input, problems) else { return Vec::new() };
    let Some(per_edge) = sharpness_per_edge(&lengths, sharpnesses.len(), problems) else { return Vec::new() };

    let (mut vertices, mut sharpnesses) = (vertices.as_slice(), sharpnesses.as_slice());
    let mut creases = Vec::with_capacity(lengths.len());
    for (crease, length) in lengths.into_iter().enumerate() {
        let path = vertices.split_off(..length).expect("lengths sum to the number of indices");
        let sharp = sharpnesses.split_off(..if per_edge { length - 1 } else { 1 }).expect("sharpnesses were counted");
        check_steps(crease, path, mesh, problems);
        let sharpnesses = if per_edge { sharp.to_vec() } else { vec![sharp[0]; length - 1] };
        creases.push(Crease { vertices: path.iter().copied().flatten().collect(), sharpnesses });
    }
    creases
}

/// The lengths of the creases, if they are valid and fit the indices.
fn lengths(input: &Garment, problems: &mut Problems) -> Option<Vec<usize>> {
    let before = problems.count();
    for (crease, &n) in input.crease_lengths.iter().enumerate().filter(|&(_, &n)| n < 2) {
        let fault = format_args!("crease {crease} has a length of {n}, but a crease has two points or more");
        problems.add(
            codes::CREASE_DATA,
            "creaseLengths",
            fault,
            format_args!("remove the crease, or add the other end of its edge"),
        );
    }
    if problems.count() > before {
        return None;
    }
    let lengths: Vec<usize> = input.crease_lengths.iter().map(|&n| n as usize).collect();
    let (sum, found) = (lengths.iter().sum::<usize>(), input.crease_indices.len());
    if sum != found {
        let fault = format_args!("holds {}, but creaseLengths adds up to {sum}", Count(found, "index"));
        let remedy = format_args!("list the points of every crease, or correct creaseLengths");
        problems.add(codes::CREASE_DATA, "creaseIndices", fault, remedy);
        return None;
    }
    Some(lengths)
}

/// Whether there is a sharpness for each edge, or one for each crease; none if neither fits.
fn sharpness_per_edge(lengths: &[usize], found: usize, problems: &mut Problems) -> Option<bool> {
    let creases = lengths.len();
    let edges = lengths.iter().map(|n| n - 1).sum::<usize>();
    if found == creases || found == edges {
        return Some(found != creases);
    }
    let fault = format_args!(
        "holds {}, but there are {} of {} in all",
        Count(found, "number"),
        Count(creases, "crease"),
        Count(edges, "edge")
    );
    let remedy = format_args!("give one sharpness for each crease ({creases}) or one for each edge ({edges})");
    problems.add(codes::CREASE_DATA, "creaseSharpnesses", fault, remedy);
    None
}

/// Checks that each step of a crease is an edge.
fn check_steps(crease: usize, path: &[Option<VertexId>], mesh: &MeshCheck<'_>, problems: &mut Problems) {
    for (step, ends) in path.windows(2).enumerate() {
        let &[Some(a), Some(b)] = ends else { continue };
        if mesh.edge([a, b]) == Some(None) {
            let (a, b) = (a.index(), b.index());
            let fault = format_args!("step {step} of crease {crease}, point {a} to {b}, is not an edge of the mesh");
            let remedy = format_args!("list the points that the crease passes in between, or end it at point {a}");
            problems.add(codes::CREASE_DATA, "creaseIndices", fault, remedy);
        }
    }
}

/// Sharpnesses, with infinity as [`INFINITE_SHARPNESS`].
fn sharpnesses(attribute: &str, values: &[f32], problems: &mut Problems) -> Vec<f32> {
    for (i, &s) in values.iter().enumerate().filter(|&(_, &s)| s.is_nan() || s < 0.0) {
        let fault = format_args!("entry {i} is {s}, but a sharpness is zero or more");
        problems.add(codes::CREASE_DATA, attribute, fault, format_args!("use 0 for smooth, 10 for infinitely sharp"));
    }
    values.iter().map(|&s| if s == f32::INFINITY { INFINITE_SHARPNESS } else { s }).collect()
}

/// The corners.
pub(super) fn corners(input: &Garment, mesh: &MeshCheck<'_>, problems: &mut Problems) -> Vec<Corner> {
    let sharpnesses = sharpnesses("cornerSharpnesses", &input.corner_sharpnesses, problems);
    let indices = Indices { attribute: "cornerIndices", kind: "point", count: mesh.points };
    let mut vertices: Vec<Option<VertexId>> = indices.handles(&input.corner_indices, |i| Entry("entry", i), problems);
    check_twice(&mut vertices, &sharpnesses, problems);
    let (found, needed) = (sharpnesses.len(), vertices.len());
    if found != needed {
        let fault = format_args!("holds {}, but cornerIndices holds {needed}", Count(found, "number"));
        let remedy = format_args!("give one sharpness for each corner ({needed})");
        problems.add(codes::CREASE_DATA, "cornerSharpnesses", fault, remedy);
    }
    let corners = vertices.into_iter().zip(sharpnesses);
    corners.filter_map(|(vertex, sharpness)| Some(Corner { vertex: vertex?, sharpness })).collect()
}

/// Checks that no point is a corner twice, and leaves out those that are with one sharpness.
fn check_twice(vertices: &mut [Option<VertexId>], sharpnesses: &[f32], problems: &mut Problems) {
    let keys = vertices.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?)));
    for Repeat { first, again } in repeats(keys) {
        let vertex = vertices[again].take().filter(|_| sharpnesses.get(first) != sharpnesses.get(again));
        let Some(vertex) = vertex else { continue };
        let fault = format_args!("entry {again} names point {} again, after entry {first}", vertex.index());
        let remedy = format_args!("keep one of the two, and its sharpness");
        problems.add(codes::CREASE_DATA, "cornerIndices", fault, remedy);
    }
}
