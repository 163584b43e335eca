//! Loops and shortest paths.

use super::edges::{borders, creases_from, uv_seams_of};
use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};
use crate::sets::expression::Operation;
use crate::sets::pieces::{oriented, other_end, pieces};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Id, IdVec, Topology, VertexId};

type Found = Result<ElementSet, SetFault>;

pub fn loops(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let mut wanted = arguments.edges(of, 0)?;
    let mut found = BTreeMap::new();
    // Lines that the garment has come before rows of its quads.
    let lines = [borders(of, arguments)?, uv_seams_of(of, arguments, 1)?, creases_from(of, f64::MIN_POSITIVE)];
    for lines in lines {
        for piece in pieces(t, &lines) {
            let ElementSet::Edges(piece) = piece else { continue };
            if piece.keys().any(|edge| wanted.contains_key(edge)) {
                wanted.retain(|edge, _| !piece.contains_key(edge));
                found.extend(piece);
            }
        }
    }
    let mut rows = BTreeSet::new();
    for edge in wanted.into_keys() {
        if !rows.contains(&edge) {
            rows.extend(edge_loop(t, edge));
        }
    }
    ElementSet::Edges(found).combine(Operation::Union, oriented(t, &rows))
}

/// The edges that follow one another across inner vertices of four quads.
fn edge_loop(t: &Topology, first: EdgeId) -> BTreeSet<EdgeId> {
    let mut found = BTreeSet::from([first]);
    for end in t.edges[first] {
        let (mut edge, mut vertex) = (first, end);
        while let Some(next) = opposite(t, edge, vertex).filter(|&next| found.insert(next)) {
            (edge, vertex) = (next, other_end(t, next, vertex));
        }
    }
    found
}

/// The edge on the other side of an inner vertex of four quads.
fn opposite(t: &Topology, edge: EdgeId, vertex: VertexId) -> Option<EdgeId> {
    let corners = t.vertex_corners.row(vertex);
    let is_regular = corners.len() == 4 && corners.iter().all(|&corner| t.faces.valence(t.faces.face_of(corner)) == 4);
    let ends_of = |corner: CornerId| [t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]];
    let around: BTreeSet<EdgeId> = corners.iter().flat_map(|&corner| ends_of(corner)).collect();
    let is_closed = around.len() == 4 && around.iter().all(|&edge| t.edge_corners.row(edge).len() == 2);
    let beside: BTreeSet<EdgeId> =
        corners.iter().map(|&corner| ends_of(corner)).filter(|ends| ends.contains(&edge)).flatten().collect();
    around.into_iter().find(|other| is_regular && is_closed && !beside.contains(other))
}

pub fn path(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let (garment, t) = (of.sets.garment, &of.sets.topology);
    let at = |v: VertexId| garment.points[v].as_dvec3();
    match (arguments.set(of, 0)?, arguments.set(of, 1)?) {
        (ElementSet::Edges(from), ElementSet::Edges(to)) => {
            let steps = |v: VertexId| {
                let corners = t.vertex_corners.row(v).iter();
                corners.flat_map(|&c| [t.faces.next(c), t.faces.prev(c)].map(|end| t.faces.vertex(end))).collect()
            };
            let ends = |set: &BTreeMap<EdgeId, [VertexId; 2]>| set.values().flatten().copied().collect();
            let way = shortest(t.vertex_count(), &ends(&from), &ends(&to), steps, |a, b| at(a).distance(at(b)));
            let edges = way.windows(2).filter_map(|ends| t.find_edge(ends[0], ends[1]));
            Ok(oriented(t, &edges.chain(from.into_keys()).chain(to.into_keys()).collect()))
        }
        (ElementSet::Faces(from), ElementSet::Faces(to)) => {
            let centre = |face: FaceId| {
                let vertices = t.faces.vertices_of(face);
                vertices.iter().map(|&v| at(v)).sum::<DVec3>() / vertices.len() as f64
            };
            let steps = |face: FaceId| {
                let edges = t.faces.corners_of(face).map(|corner| t.corner_edge[corner]);
                edges.flat_map(|edge| t.edge_corners.row(edge)).map(|&corner| t.faces.face_of(corner)).collect()
            };
            let way = shortest(t.faces.len(), &from, &to, steps, |a, b| centre(a).distance(centre(b)));
            Ok(ElementSet::Faces(way.into_iter().chain(from).chain(to).collect()))
        }
        (a, b) => {
            let text = format!("path is given {} and {}", a.kind(), b.kind());
            Err(SetFault::new(text, "give two sets of edges, or two sets of faces"))
        }
    }
}

/// The shortest way from one of `from` to one of `to`; empty if there is none (Dijkstra).
fn shortest<I: Id + Ord>(
    count: usize,
    from: &BTreeSet<I>,
    to: &BTreeSet<I>,
    steps: impl Fn(I) -> Vec<I>,
    distance: impl Fn(I, I) -> f64,
) -> Vec<I> {
    let mut best: IdVec<I, f64> = IdVec::filled(f64::INFINITY, count);
    let mut before: IdVec<I, Option<I>> = IdVec::filled(None, count);
    // Distances are not negative, so their bits have their order.
    let mut open: BinaryHeap<Reverse<(u64, I)>> = from.iter().map(|&start| Reverse((0, start))).collect();
    from.iter().for_each(|&start| best[start] = 0.0);
    while let Some(Reverse((bits, at))) = open.pop() {
        if to.contains(&at) {
            let mut way = vec![at];
            while let Some(last) = before[way[way.len() - 1]] {
                way.push(last);
            }
            return way;
        }
        if bits > best[at].to_bits() {
            continue;
        }
        for next in steps(at) {
            let length = best[at] + distance(at, next);
            if length < best[next] {
                (best[next], before[next]) = (length, Some(at));
                open.push(Reverse((length.to_bits(), next)));
            }
        }
    }
    Vec::new()
}
