//! Loops and shortest paths.

use super::edges::{borders, creases_from, uv_seams_of};
use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};
use crate::sets::expression::Operation;
use crate::sets::pieces::{edges_at, oriented, other_end, pieces};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Id, IdVec, Topology, VertexId};
use tailor_mesh::subdivide;

/// The cosine of the largest turn at which a line goes straight on.
const STRAIGHT: f64 = 0.5;
/// The length that an edge which is on no line counts for a path. \[own lengths\]
const OFF_LINE: f64 = 2.0;
/// The length that a turn by a right angle adds to a path. \[lengths of the edge after it\]
const TURN: f64 = 0.5;

type Found = Result<ElementSet, SetFault>;

/// Edges in their directions.
type Directed = BTreeMap<EdgeId, [VertexId; 2]>;

pub fn loops(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    loops_of(of, arguments, arguments.edges(of, 0)?)
}

/// The lines that the garment has, the first before the others.
fn lines_of(of: &Evaluation<'_>, arguments: &Arguments<'_>, uv_set: usize) -> Result<[ElementSet; 3], SetFault> {
    Ok([borders(of, arguments)?, uv_seams_of(of, arguments, uv_set)?, creases_from(of, f64::MIN_POSITIVE)])
}

fn loops_of(of: &Evaluation<'_>, arguments: &Arguments<'_>, mut wanted: Directed) -> Found {
    let t = &of.sets.topology;
    let mut found = BTreeMap::new();
    // Lines that the garment has come before rows of its quads.
    for lines in lines_of(of, arguments, 1)? {
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

pub fn onward(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let set = arguments.edges(of, 0)?;
    let at = |v: VertexId| of.sets.garment.points[v].as_dvec3();
    let lines = lines_of(of, arguments, 1)?;
    let is_line = |edge: &EdgeId| lines.iter().any(|lines| lines.contains_edge(*edge));
    let mut ahead = Directed::new();
    for (&end, edges) in edges_at(t, set.keys()).iter().filter(|(_, edges)| edges.len() == 1) {
        let way = (at(end) - at(other_end(t, edges[0], end))).normalize_or_zero();
        let straight = |edge: EdgeId| way.dot((at(other_end(t, edge, end)) - at(end)).normalize_or_zero());
        let around: BTreeSet<EdgeId> = subdivide::edges_at(t, end).collect();
        let fits = |edge: &EdgeId| !set.contains_key(edge) && straight(*edge) > STRAIGHT;
        // A line that the garment has comes before the edges of its faces.
        let next = around
            .iter()
            .copied()
            .filter(fits)
            .max_by(|a, b| is_line(a).cmp(&is_line(b)).then(straight(*a).total_cmp(&straight(*b))));
        ahead.extend(next.map(|edge| (edge, [end, other_end(t, edge, end)])));
    }
    let found = loops_of(of, arguments, ahead)?;
    ElementSet::Edges(set).combine(Operation::Union, found)
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
            let way = along_lines(of, arguments, &from, &to)?;
            Ok(oriented(t, &way.into_iter().chain(from.into_keys()).chain(to.into_keys()).collect()))
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

/// The way from one set of edges to another, edge by edge, that keeps to lines of the garment and goes straight on.
fn along_lines(
    of: &Evaluation<'_>,
    arguments: &Arguments<'_>,
    from: &Directed,
    to: &Directed,
) -> Result<Vec<EdgeId>, SetFault> {
    let t = &of.sets.topology;
    let at = |v: VertexId| of.sets.garment.points[v].as_dvec3();
    let lines = lines_of(of, arguments, 2)?;
    let vector = |[a, b]: [VertexId; 2]| at(b) - at(a);
    let cost = |edge: EdgeId| {
        let is_line = lines.iter().any(|lines| lines.contains_edge(edge));
        vector(t.edges[edge]).length() * if is_line { 1.0 } else { OFF_LINE }
    };
    let shared = |a: EdgeId, b: EdgeId| t.edges[a].into_iter().find(|v| t.edges[b].contains(v));
    let steps = |edge: EdgeId| t.edges[edge].into_iter().flat_map(|v| subdivide::edges_at(t, v)).collect();
    let distance = |a: EdgeId, b: EdgeId| {
        let turn = shared(a, b).map_or(0.0, |v| {
            let [before, after] = [[other_end(t, a, v), v], [v, other_end(t, b, v)]].map(vector);
            1.0 - before.normalize_or_zero().dot(after.normalize_or_zero())
        });
        0.5 * (cost(a) + cost(b)) + TURN * turn * vector(t.edges[b]).length()
    };
    let [from, to] = [from, to].map(|set| set.keys().copied().collect());
    Ok(shortest(t.edges.len(), &from, &to, steps, distance))
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
