//! Ribs across seams at their ends and corners.
//!
//! ```text
//!   ---+-+--+----     At an end or a corner the lines of a seam are near to each other, and the next vertex along them would be
//!   ===o=+==+====     a whole edge away: the limit there would be pulled along the seam, and the surface with it. Ribs from there
//!   --/+-+--+----     on have gaps that grow by a factor, so that no vertex has a far and a near neighbour.
//! ```

use crate::render::child::{ChildBuilder, OperatorDerivation};
use glam::Vec3;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};

/// Difference below which places on an edge are one.
const SAME: f32 = 1e-4;

/// An edge that needs ribs from one of its ends on.
pub struct Ribbed {
    /// The end.
    pub vertex: VertexId,
    /// The edge.
    pub edge: EdgeId,
    /// Places of the ribs, as shares of the edge from the end.
    pub places: Vec<f32>,
    /// How far they reach on each side. \[mesh units\]
    pub reach: f32,
}

/// Inserts ribs over the quads on both sides of some edges.
pub fn insert(topology: &Topology, points: &IdVec<VertexId, Vec3>, edges: &[Ribbed]) -> OperatorDerivation {
    let mut ribs = Ribs { topology, places: BTreeMap::new(), faces: BTreeMap::new() };
    edges.iter().for_each(|edge| ribs.add(points, edge));
    ribs.build()
}

/// Ribs across faces.
struct Ribs<'a> {
    topology: &'a Topology,
    /// The places of ribs on each edge, as ascending shares from its first vertex.
    places: BTreeMap<EdgeId, Vec<f32>>,
    /// The half-edges from which ribs lead through a face, with their places along them.
    faces: BTreeMap<FaceId, BTreeMap<CornerId, Vec<f32>>>,
}

impl Ribs<'_> {
    fn add(&mut self, points: &IdVec<VertexId, Vec3>, ribbed: &Ribbed) {
        let t = self.topology;
        self.mark(ribbed.vertex, ribbed.edge, &ribbed.places);
        for &first in t.edge_corners.row(ribbed.edge) {
            let (mut half, mut near, mut left) = (first, ribbed.vertex, ribbed.reach);
            while left > 0.0 {
                let face = t.faces.face_of(half);
                if t.faces.valence(face) != 4 {
                    break;
                }
                let [opposite, behind] = [2, 3].map(|n| t.faces.ahead(half, n));
                let is_start = t.faces.vertex(half) == near;
                self.lead_through(face, half, ribbed.places.iter().map(|&p| if is_start { p } else { 1.0 - p }));
                let next = t.faces.vertex(if is_start { behind } else { opposite });
                left -= points[near].distance(points[next]);
                near = next;
                self.mark(near, t.corner_edge[opposite], &ribbed.places);
                let Some(twin) = t.twin(opposite).filter(|&twin| twin != first) else { break };
                half = twin;
            }
        }
    }

    /// Adds ribs of a face from places on a half-edge, or on the opposite one if that has ribs.
    fn lead_through(&mut self, face: FaceId, half: CornerId, places: impl Iterator<Item = f32>) {
        let opposite = self.topology.faces.ahead(half, 2);
        let sides = self.faces.entry(face).or_default();
        if sides.contains_key(&opposite) {
            add(sides.entry(opposite).or_default(), places.map(|place| 1.0 - place));
        } else {
            add(sides.entry(half).or_default(), places);
        }
    }

    fn mark(&mut self, from: VertexId, edge: EdgeId, places: &[f32]) {
        let is_forward = self.topology.edges[edge][0] == from;
        let places = places.iter().map(|&place| if is_forward { place } else { 1.0 - place });
        add(self.places.entry(edge).or_default(), places);
    }

    fn build(self) -> OperatorDerivation {
        let t = self.topology;
        let mut builder = ChildBuilder::new(t);
        let mut made = Made { topology: t, on_edges: BTreeMap::new() };
        for (&edge, places) in &self.places {
            let [a, b] = t.edges[edge];
            let of = |&place: &f32| (place, builder.vertex(&[(a, 1.0 - place), (b, place)]));
            made.on_edges.insert(edge, places.iter().map(of).collect());
        }
        let none = BTreeMap::new();
        for face in t.faces.ids() {
            let ribs = self.faces.get(&face).unwrap_or(&none);
            made.add_face(&mut builder, face, ribs);
        }
        for (edge, &[a, b]) in t.edges.enumerated() {
            let between = made.on_edges.get(&edge).into_iter().flatten().map(|&(_, vertex)| vertex);
            let path: Vec<VertexId> = [a].into_iter().chain(between).chain([b]).collect();
            path.windows(2).for_each(|step| builder.edge(edge, [step[0], step[1]]));
        }
        builder.finish()
    }
}

/// The vertices of ribs on edges.
struct Made<'a> {
    topology: &'a Topology,
    on_edges: BTreeMap<EdgeId, Vec<(f32, VertexId)>>,
}

impl Made<'_> {
    /// The vertices of a half-edge with its ends, in its direction or against it, each with its share along that.
    fn side(&self, half: CornerId, is_forward: bool) -> Vec<(f32, VertexId)> {
        let t = self.topology;
        let edge = t.corner_edge[half];
        let ends = t.edges[edge];
        let between = self.on_edges.get(&edge).into_iter().flatten().copied();
        let mut side: Vec<(f32, VertexId)> =
            [(0.0, ends[0])].into_iter().chain(between).chain([(1.0, ends[1])]).collect();
        if (ends[0] == t.faces.vertex(half)) != is_forward {
            side.reverse();
            side.iter_mut().for_each(|(place, _)| *place = 1.0 - *place);
        }
        side
    }

    fn add_face(&self, builder: &mut ChildBuilder, face: FaceId, ribs: &BTreeMap<CornerId, Vec<f32>>) {
        let t = self.topology;
        let Some((&first, _)) = ribs.first_key_value() else {
            let around = t.faces.corners_of(face).flat_map(|c| {
                let mut side = self.side(c, true);
                side.pop();
                side
            });
            builder.face(face, &around.map(|(_, vertex)| vertex).collect::<Vec<_>>());
            return;
        };
        // The sides around the face from the first ribs on, all from the left or from below.
        let halves = [0, 1, 2, 3].map(|n| t.faces.ahead(first, n));
        let [low, right] = [0, 1].map(|n| self.side(halves[n], true));
        let [high, left] = [2, 3].map(|n| self.side(halves[n], false));
        let columns = grid(ribs.get(&halves[0]).into_iter().flatten().copied());
        let upward = ribs.get(&halves[1]).into_iter().flatten().copied();
        let rows = grid(upward.chain(ribs.get(&halves[3]).into_iter().flatten().map(|place| 1.0 - place)));
        let corners = halves.map(|half| t.faces.vertex(half));
        let mut inner: BTreeMap<(usize, usize), VertexId> = BTreeMap::new();
        for (i, j) in (1..columns.len() - 1).flat_map(|i| (1..rows.len() - 1).map(move |j| (i, j))) {
            let (x, y) = (columns[i], rows[j]);
            let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
            let sources: Vec<(VertexId, f32)> = corners.into_iter().zip(weights).collect();
            inner.insert((i, j), builder.vertex(&sources));
        }
        // The vertices of a side between two places, with both.
        let part = |side: &[(f32, VertexId)], [from, to]: [f32; 2]| -> Vec<VertexId> {
            let within = side.iter().filter(|(place, _)| (from - SAME..=to + SAME).contains(place));
            within.map(|&(_, vertex)| vertex).collect()
        };
        let (last_column, last_row) = (columns.len() - 2, rows.len() - 2);
        for (i, j) in (0..=last_column).flat_map(|i| (0..=last_row).map(move |j| (i, j))) {
            let (x, y) = ([columns[i], columns[i + 1]], [rows[j], rows[j + 1]]);
            let at = |i: usize, j: usize| inner.get(&(i, j)).copied();
            let mut cell = Vec::new();
            cell.extend(if j == 0 { part(&low, x) } else { [at(i, j), at(i + 1, j)].into_iter().flatten().collect() });
            cell.extend(if i == last_column {
                part(&right, y)
            } else {
                [at(i + 1, j), at(i + 1, j + 1)].into_iter().flatten().collect()
            });
            let mut back = if j == last_row {
                part(&high, x)
            } else {
                [at(i, j + 1), at(i + 1, j + 1)].into_iter().flatten().collect()
            };
            back.reverse();
            cell.extend(back);
            let mut down =
                if i == 0 { part(&left, y) } else { [at(i, j), at(i, j + 1)].into_iter().flatten().collect() };
            down.reverse();
            cell.extend(down);
            cell.dedup();
            if cell.first() == cell.last() {
                cell.pop();
            }
            builder.face(face, &cell);
        }
    }
}

/// Adds places to ascending ones, each once.
fn add(known: &mut Vec<f32>, places: impl Iterator<Item = f32>) {
    known.extend(places);
    known.sort_by(f32::total_cmp);
    known.dedup_by(|a, b| (*a - *b).abs() < SAME);
}

/// The places of a side from one end to the other.
fn grid(places: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut all = vec![0.0, 1.0];
    add(&mut all, places);
    all
}
