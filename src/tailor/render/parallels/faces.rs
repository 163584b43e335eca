//! The parts of the faces that lines lead through.

use super::chords::{Chord, Point, ring};
use super::crossings::Crossings;
use super::{LinePlace, ParallelRequest, Parallels, Passage};
use crate::render::child::ChildBuilder;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{EdgeId, FaceId, IdVec, VertexId};

/// A corner of a part of a face.
#[derive(Clone, Copy)]
struct PartCorner {
    vertex: VertexId,
    is_bend: bool,
}

struct Builder<'a, 'r> {
    crossings: &'r Crossings,
    builder: ChildBuilder<'a>,
    /// The vertex of each crossing that a line uses.
    used: BTreeMap<(EdgeId, usize), VertexId>,
    vertices: Vec<(VertexId, LinePlace)>,
}

/// Builds the child of a request.
pub fn build<'a>(
    request: &ParallelRequest<'a>,
    crossings: &Crossings,
    chords: &BTreeMap<FaceId, Vec<Chord>>,
    passages: Vec<Passage>,
) -> Parallels<'a> {
    let t = request.topology();
    let used = chords.values().flatten().flat_map(|chord| chord.ends);
    let used: BTreeSet<Point> = used.collect();
    let mut made = Builder { crossings, builder: ChildBuilder::new(t), used: BTreeMap::new(), vertices: Vec::new() };
    used.into_iter().for_each(|point| made.add_crossing(request, point));
    let mut near = IdVec::filled(false, t.vertex_count());
    let mut faces = Vec::new();
    for face in t.faces.ids() {
        let around: Vec<VertexId> = ring(t, crossings, face).into_iter().filter_map(|p| made.vertex(p)).collect();
        let Some(chords) = chords.get(&face) else {
            made.builder.face(face, &around);
            if around.len() > t.faces.valence(face) {
                t.faces.vertices_of(face).iter().for_each(|&v| near[v] = true);
            }
            continue;
        };
        t.faces.vertices_of(face).iter().for_each(|&v| near[v] = true);
        for part in made.parts(request, face, &around, chords) {
            let corners: Vec<VertexId> = part.iter().map(|corner| corner.vertex).collect();
            faces.push(made.builder.face(face, &corners));
        }
    }
    t.edges.ids().for_each(|edge| made.add_edge(request, edge));
    made.add_between(request, &near);
    let Builder { builder, vertices, .. } = made;
    Parallels { builder, vertices, faces, passages, near }
}

impl Builder<'_, '_> {
    fn add_crossing(&mut self, request: &ParallelRequest, point: Point) {
        let Point::Crossing(edge, number) = point else { return };
        let crossing = &self.crossings.of_edges[&edge][number];
        let [a, b] = request.topology().edges[edge];
        let vertex = self.builder.vertex(&[(a, 1.0 - crossing.at), (b, crossing.at)]);
        self.used.insert((edge, number), vertex);
        self.vertices.push((vertex, crossing.place()));
    }

    /// The vertex of a point around a face; none for a crossing that no line uses.
    fn vertex(&self, point: Point) -> Option<VertexId> {
        match point {
            Point::Vertex(vertex) => Some(vertex),
            Point::Crossing(edge, number) => self.used.get(&(edge, number)).copied(),
        }
    }

    /// The parts of a face between lines.
    fn parts(
        &mut self,
        request: &ParallelRequest,
        face: FaceId,
        around: &[VertexId],
        chords: &[Chord],
    ) -> Vec<Vec<PartCorner>> {
        let mut parts = vec![around.iter().map(|&vertex| PartCorner { vertex, is_bend: false }).collect::<Vec<_>>()];
        for chord in chords {
            let [Some(a), Some(b)] = chord.ends.map(|end| self.vertex(end)) else { continue };
            let place = |part: &[PartCorner], v: VertexId| part.iter().position(|corner| corner.vertex == v);
            let found = parts.iter().enumerate().find_map(|(number, part)| {
                let (i, j) = (place(part, a)?, place(part, b)?);
                let (low, high) = (i.min(j), i.max(j));
                // A chord beside an edge of the part would leave nothing between them.
                (high - low > 1 && low + part.len() - high > 1).then_some((number, low, high))
            });
            let Some((number, low, high)) = found else { continue };
            let bend =
                chord.bend.map(|at| PartCorner { vertex: self.add_bend(request, face, chord, at), is_bend: true });
            let part = std::mem::take(&mut parts[number]);
            let inner = part[low..=high].iter().copied().chain(bend).collect();
            let outer = part[high..].iter().chain(&part[..=low]).copied().chain(bend).collect();
            parts[number] = inner;
            parts.push(outer);
        }
        parts.into_iter().flat_map(split_at_bends).collect()
    }

    fn add_bend(&mut self, request: &ParallelRequest, face: FaceId, chord: &Chord, at: glam::Vec2) -> VertexId {
        let corners = request.topology().faces.vertices_of(face);
        let weights = [(1.0 - at.x) * (1.0 - at.y), at.x * (1.0 - at.y), at.x * at.y, (1.0 - at.x) * at.y];
        let sources: Vec<(VertexId, f32)> = corners.iter().copied().zip(weights).collect();
        let vertex = self.builder.vertex(&sources);
        let (line, side) = (chord.passage.line, chord.passage.side);
        let distance = request.distances[side][line];
        self.vertices.push((vertex, LinePlace { line: Some(line), side, distance, share: chord.share }));
        vertex
    }

    /// Adds the children of an edge.
    fn add_edge(&mut self, request: &ParallelRequest, edge: EdgeId) {
        let [a, b] = request.topology().edges[edge];
        let crossings = self.crossings.of_edges.get(&edge).map_or(0, Vec::len);
        let mut path = vec![a];
        path.extend((0..crossings).filter_map(|number| self.used.get(&(edge, number))));
        path.push(b);
        path.windows(2).for_each(|step| self.builder.edge(edge, [step[0], step[1]]));
    }

    /// Adds the parent's vertices among the lines.
    fn add_between(&mut self, request: &ParallelRequest, near: &IdVec<VertexId, bool>) {
        for vertex in near.ids().filter(|&v| near[v]) {
            let Some(foot) = request.field.off_chains(vertex) else { continue };
            let (line, share) = match self.crossings.through.get(&vertex) {
                Some(&(line, _, share)) => (Some(line), share),
                None => (None, request.share(&foot, |block| block.field.around_vertex(vertex))),
            };
            let distance = line.map_or(foot.distance, |line| request.distances[foot.side][line]);
            self.vertices.push((vertex, LinePlace { line, side: foot.side, distance, share }));
        }
    }
}

/// Splits a part between the bends of its two lines, or from its only bend to the opposite corner: its corner there is concave
/// on one side of the line.
fn split_at_bends(part: Vec<PartCorner>) -> Vec<Vec<PartCorner>> {
    let bends: Vec<usize> = (0..part.len()).filter(|&i| part[i].is_bend).collect();
    let (low, high) = match *bends.as_slice() {
        [a, b] => (a, b),
        [a] if part.len() >= 5 => {
            let opposite = (a + part.len() / 2) % part.len();
            (a.min(opposite), a.max(opposite))
        }
        _ => return vec![part],
    };
    if high - low < 2 || low + part.len() - high < 2 {
        return vec![part];
    }
    let outer = part[high..].iter().chain(&part[..=low]).copied().collect();
    vec![part[low..=high].to_vec(), outer]
}
