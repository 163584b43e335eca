//! Rings around the ends and corners of seams.
//!
//! ```text
//!   o-----------+-----     At an end or a corner the lines of a seam are near to each other, and the next vertex along them would
//!   |   .-------+          be a whole edge away: the limit there would be pulled along the seam, and the surface with it. Rings
//!   |   | .---. |          around the vertex have gaps that grow by a factor, so that no vertex has a far and a near neighbour.
//!   +---+-+=o=+=+====      They leave all other faces as they are.
//! ```

use super::profile::LINES;
use crate::render::child::{ChildBuilder, OperatorDerivation};
use glam::Vec3;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};

/// Factor by which radii grow.
const GROWTH: f32 = 2.0;
/// Factor by which the distances of ribs from the centre grow.
const RIBS: f32 = 2.5;
/// The middle of a quarter of a ring, as a share of its radius along both edges.
const ROUND: f32 = 1.0;
/// Share of an edge that rings may take from one end.
const MAX_SHARE: f32 = 0.45;

/// Inserts rings around vertices, each with the distance of the lines there. \[mesh units\]
pub fn insert(
    t: &Topology,
    points: &IdVec<VertexId, Vec3>,
    around: &BTreeMap<VertexId, f32>,
    is_chain: impl Fn(EdgeId) -> bool,
) -> OperatorDerivation {
    let mut rings =
        Rings { topology: t, builder: ChildBuilder::new(t), on_edges: BTreeMap::new(), ribs: BTreeMap::new() };
    for (&vertex, &step) in around {
        let corners = t.vertex_corners.row(vertex);
        let edges: Vec<EdgeId> = corners.iter().flat_map(|&c| [c, t.faces.prev(c)]).map(|c| t.corner_edge[c]).collect();
        let length = |&edge: &EdgeId| points[t.edges[edge][0]].distance(points[t.edges[edge][1]]);
        let most = MAX_SHARE * edges.iter().map(length).fold(f32::INFINITY, f32::min);
        let gaps = std::iter::successors(Some(step), |gap| Some(GROWTH * gap));
        let radii: Vec<f32> =
            gaps.map(|gap| LINES.len() as f32 * step + gap).take_while(|&r| r > 0.0 && r <= most).collect();
        for edge in edges {
            let shares: Vec<f32> = radii.iter().map(|radius| radius / length(&edge)).collect();
            rings.cut(vertex, edge, &shares);
            if is_chain(edge) && !radii.is_empty() {
                let ribs = std::iter::successors(Some(step), |r| Some(RIBS * r)).take_while(|&r| r < 0.7 * radii[0]);
                let ribs: Vec<f32> = ribs.map(|radius| radius / length(&edge)).collect();
                rings.rib(vertex, edge, &ribs);
            }
        }
    }
    rings.build()
}

/// A vertex of a ring on an edge, with its share of the edge from the centre of the ring.
type OnEdge = (f32, VertexId);

struct Rings<'a> {
    topology: &'a Topology,
    builder: ChildBuilder<'a>,
    /// The vertices of ribs within the first ring, likewise.
    ribs: BTreeMap<(EdgeId, VertexId), Vec<OnEdge>>,
    /// The vertices of the rings around an end of an edge, from there.
    on_edges: BTreeMap<(EdgeId, VertexId), Vec<OnEdge>>,
}

impl Rings<'_> {
    fn cut(&mut self, centre: VertexId, edge: EdgeId, shares: &[f32]) {
        if !self.on_edges.contains_key(&(edge, centre)) {
            let made = self.made(centre, edge, shares);
            self.on_edges.insert((edge, centre), made);
        }
    }

    fn rib(&mut self, centre: VertexId, edge: EdgeId, shares: &[f32]) {
        if !self.ribs.contains_key(&(edge, centre)) {
            let made = self.made(centre, edge, shares);
            self.ribs.insert((edge, centre), made);
        }
    }

    fn made(&mut self, centre: VertexId, edge: EdgeId, shares: &[f32]) -> Vec<OnEdge> {
        let [a, b] = self.topology.edges[edge];
        let far = if a == centre { b } else { a };
        shares.iter().map(|&share| (share, self.builder.vertex(&[(centre, 1.0 - share), (far, share)]))).collect()
    }

    /// The vertices of the rings around the start of a corner's edge or of the edge before it.
    fn on_edge(&self, edge: EdgeId, centre: VertexId) -> Vec<OnEdge> {
        self.on_edges.get(&(edge, centre)).cloned().unwrap_or_default()
    }

    fn build(mut self) -> OperatorDerivation {
        let t = self.topology;
        for face in t.faces.ids() {
            let rest: Vec<VertexId> = t.faces.corners_of(face).flat_map(|c| self.corner(face, c)).collect();
            self.builder.face(face, &rest);
        }
        for (edge, &[a, b]) in t.edges.enumerated() {
            let [from, to] = [a, b].map(|end| self.on_edge(edge, end));
            let [near, far] = [a, b].map(|end| self.ribs.get(&(edge, end)).cloned().unwrap_or_default());
            let between = near.iter().chain(&from).chain(to.iter().rev()).chain(far.iter().rev()).map(|place| place.1);
            let path: Vec<VertexId> = [a].into_iter().chain(between).chain([b]).collect();
            path.windows(2).for_each(|step| self.builder.edge(edge, [step[0], step[1]]));
        }
        self.builder.finish()
    }

    /// Adds the faces within the rings in a corner of a face. Returns what is left of the corner for the rest of the face.
    fn corner(&mut self, face: FaceId, corner: CornerId) -> Vec<VertexId> {
        let t = self.topology;
        let (before, centre) = (t.faces.prev(corner), t.faces.vertex(corner));
        let [ahead, back] = [corner, before].map(|c| self.on_edge(t.corner_edge[c], centre));
        // The sides of what is within the rings so far, from the edge ahead to the middle and on to the edge before.
        let mut within: Option<[Vec<VertexId>; 2]> = None;
        for (&(x, a), &(y, b)) in ahead.iter().zip(&back) {
            let sources = self.bilinear(face, corner, [ROUND * x, ROUND * y]);
            let middle = self.builder.vertex(&sources);
            within = Some(match within {
                None => self.first(face, corner, [(x, a), (y, b)], middle),
                Some([low, high]) => {
                    let first = [vec![low[0], a, middle], low[1..].iter().rev().copied().collect()].concat();
                    let second = [vec![middle, b], high.iter().rev().copied().collect()].concat();
                    self.builder.face(face, &first);
                    self.builder.face(face, &second);
                    [vec![a, middle], vec![middle, b]]
                }
            });
        }
        within.map_or_else(
            || vec![centre],
            |[low, high]| {
                let around: Vec<VertexId> = low.iter().chain(&high[1..]).rev().copied().collect();
                around
            },
        )
    }

    /// Adds the faces of a corner within its first ring, with ribs from edges of chains. Returns the sides of the ring there.
    fn first(&mut self, face: FaceId, corner: CornerId, ends: [OnEdge; 2], middle: VertexId) -> [Vec<VertexId>; 2] {
        let t = self.topology;
        let centre = t.faces.vertex(corner);
        let before = t.faces.prev(corner);
        let [(x, a), (y, b)] = ends;
        let [columns, rows] =
            [corner, before].map(|c| self.ribs.get(&(t.corner_edge[c], centre)).cloned().unwrap_or_default());
        let low: Vec<VertexId> = [centre].into_iter().chain(columns.iter().map(|rib| rib.1)).chain([a]).collect();
        let left: Vec<VertexId> = [centre].into_iter().chain(rows.iter().map(|rib| rib.1)).chain([b]).collect();
        let places = |ribs: &[OnEdge], end: f32| -> Vec<f32> {
            [0.0].into_iter().chain(ribs.iter().map(|rib| rib.0)).chain([end]).collect()
        };
        let (xs, ys) = (places(&columns, x), places(&rows, y));
        let mut grid: Vec<Vec<VertexId>> = vec![low];
        for j in 1..ys.len() {
            let row = (0..xs.len()).map(|i| match (i, j) {
                (0, _) => left[j],
                (i, j) if i + 1 == xs.len() && j + 1 == ys.len() => middle,
                _ => {
                    // Coordinates go from the edges to the middle of the ring.
                    let round = |u: f32, other: f32| u * (1.0 + (ROUND - 1.0) * other);
                    let place = [round(xs[i], ys[j] / y), round(ys[j], xs[i] / x)];
                    let sources = self.bilinear(face, corner, place);
                    self.builder.vertex(&sources)
                }
            });
            grid.push(row.collect::<Vec<_>>());
        }
        for pair in grid.windows(2) {
            for i in 0..xs.len() - 1 {
                self.builder.face(face, &[pair[0][i], pair[0][i + 1], pair[1][i + 1], pair[1][i]]);
            }
        }
        let last = grid.last().cloned().unwrap_or_default();
        [grid.iter().map(|row| row[xs.len() - 1]).collect(), last.into_iter().rev().collect()]
    }

    /// The weights at a place in a face, with shares of the edges after and before a corner. All vertices but those of these
    /// edges count as one.
    fn bilinear(&self, face: FaceId, corner: CornerId, [x, y]: [f32; 2]) -> Vec<(VertexId, f32)> {
        let faces = &self.topology.faces;
        let near = [corner, faces.next(corner), faces.prev(corner)];
        let others: Vec<CornerId> = faces.corners_of(face).filter(|c| !near.contains(c)).collect();
        let far = if others.is_empty() { 0.0 } else { x * y };
        let weights = [1.0 - x - y + far, x - far, y - far];
        let others = others.iter().map(|&c| (faces.vertex(c), far / others.len() as f32));
        near.into_iter().map(|c| faces.vertex(c)).zip(weights).chain(others).collect()
    }
}
