//! Points, faces and holes.

use super::mesh::{Count, Entry, Indices, MeshCheck, corner_sum};
use super::problem::Problems;
use crate::codes;
use crate::connectivity::{FaceId, Faces, VertexId};
use crate::garment::{Garment, Scheme};
use glam::Vec3;
use std::collections::HashSet;

/// Checks that there are points and that all are finite.
pub(super) fn check_points(points: &[Vec3], problems: &mut Problems) {
    if points.is_empty() {
        let fault = format_args!("the mesh has no points");
        problems.add(
            codes::EMPTY_MESH,
            "points",
            fault,
            format_args!("author the points, or name another mesh with --prim"),
        );
    }
    for (i, p) in points.iter().enumerate().filter(|(_, p)| !p.is_finite()) {
        let fault = format_args!("point {i} is ({}, {}, {}), which is not finite", p.x, p.y, p.z);
        problems.add(codes::NOT_FINITE, "points", fault, format_args!("give the point a finite position"));
    }
}

/// The faces, if they have no fault.
pub(super) fn faces(input: &Garment, problems: &mut Problems) -> Option<Faces> {
    let before = problems.count();
    let mesh = MeshCheck::new(input, None);
    check_counts(input, problems);
    let counts_hold = problems.count() == before;
    let indices = Indices { attribute: "faceVertexIndices", kind: "point", count: mesh.points };
    let corners = indices.handles(&input.face_vertex_indices, |c| mesh.corner(c), problems);
    let corners: Vec<VertexId> = corners.into_iter().collect::<Option<_>>()?;
    if !counts_hold || corners.is_empty() {
        return None;
    }
    check_repeats(&input.face_vertex_counts, &corners, input.points.len(), problems);
    if problems.count() > before {
        return None;
    }
    Some(Faces::mixed(input.face_vertex_counts.iter().map(|&n| n as usize), corners))
}

/// Checks that there are faces, that each has three corners or more, and that their corners are all indices.
fn check_counts(input: &Garment, problems: &mut Problems) {
    const ATTRIBUTE: &str = "faceVertexCounts";
    let counts = &input.face_vertex_counts;
    if counts.is_empty() {
        let remedy = format_args!("author the faces, or name another mesh with --prim");
        return problems.add(codes::EMPTY_MESH, ATTRIBUTE, format_args!("the mesh has no faces"), remedy);
    }
    for (face, &n) in counts.iter().enumerate().filter(|&(_, &n)| n < 3) {
        let corners = format_args!("face {face} has a count of {n}, but a face has three corners or more");
        problems.add(
            codes::FACE_CORNERS,
            ATTRIBUTE,
            corners,
            format_args!("remove the face, or give it its missing corners"),
        );
    }
    let found = input.face_vertex_indices.len();
    let Some(sum) = corner_sum(counts).filter(|&sum| sum != found) else { return };
    let fault = format_args!("holds {}, but faceVertexCounts adds up to {sum}", Count(found, "index"));
    let (verb, excess) = if found < sum { ("add the", sum - found) } else { ("remove the", found - sum) };
    let which = if found < sum { "missing" } else { "surplus" };
    let remedy = format_args!("{verb} {which} {}, or correct faceVertexCounts", Count(excess, "index"));
    problems.add(codes::FACE_CORNERS, "faceVertexIndices", fault, remedy);
}

/// Checks that a Loop cage has triangles only.
pub(super) fn check_scheme(input: &Garment, problems: &mut Problems) {
    if input.rules.scheme != Scheme::Loop {
        return;
    }
    let mut others = input.face_vertex_counts.iter().enumerate().filter(|&(_, &n)| n > 3);
    let Some((face, n)) = others.next() else { return };
    let all = 1 + others.count();
    let fault =
        format_args!("loop takes triangles only, but face {face} has {n} corners ({} in all)", Count(all, "face"));
    let remedy = format_args!("triangulate the mesh, or set subdivisionScheme to catmullClark");
    problems.add(codes::LOOP_FACES, "subdivisionScheme", fault, remedy);
}

/// Checks that no face has a vertex twice.
fn check_repeats(counts: &[i32], corners: &[VertexId], points: usize, problems: &mut Problems) {
    // The last corner at each vertex, plus one. It is in the same face if that is past the face's start.
    let mut last = vec![0usize; points];
    let mut start = 0;
    for (face, &count) in counts.iter().enumerate() {
        let end = start + count as usize;
        for (corner, vertex) in (start..).zip(&corners[start..end]) {
            let seen = std::mem::replace(&mut last[vertex.index()], corner + 1);
            if seen > start {
                let (point, first, second) = (vertex.index(), seen - 1 - start, corner - start);
                let fault = format_args!("face {face} has point {point} twice, at corners {first} and {second}");
                let remedy = format_args!("remove one of the two corners, or split the face");
                problems.add(codes::FACE_CORNERS, "faceVertexIndices", fault, remedy);
            }
        }
        start = end;
    }
}

/// The faces that are holes, each once, in authored order.
pub(super) fn holes(indices: &[i32], mesh: &MeshCheck<'_>, problems: &mut Problems) -> Vec<FaceId> {
    let kind = Indices { attribute: "holeIndices", kind: "face", count: mesh.faces };
    let faces: Vec<Option<FaceId>> = kind.handles(indices, |i| Entry("entry", i), problems);
    let mut seen = HashSet::new();
    faces.into_iter().flatten().filter(|&face| seen.insert(face)).collect()
}
