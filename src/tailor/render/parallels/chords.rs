//! How lines go through faces: a chord from edge to edge, with a bend in the middle where the line turns.

use super::crossings::Crossings;
use super::waves::Foot;
use super::{ParallelRequest, Passage};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, Topology, VertexId};

/// Distance of a line from its chord, as a share of the distance to the next line, from which on it has a bend.
const BENT: f32 = 0.2;
/// Halvings of the search for a bend.
const HALVINGS: usize = 16;
/// The part of a face, from each of its sides, in which no bend is.
const RIM: f32 = 0.03;

/// A point around a face through which a line may lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Point {
    /// A vertex of the parent.
    Vertex(VertexId),
    /// A crossing of an edge, by its index there.
    Crossing(EdgeId, usize),
}

/// A line through a face.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// Its ends.
    pub ends: [Point; 2],
    /// Its bend: the coordinates in the face, from its first corner to the second one and to the last one.
    pub bend: Option<Vec2>,
    /// Its passage.
    pub passage: Passage,
    /// Share of the height in the middle.
    pub share: f32,
}

/// A point around a face.
#[derive(Clone, Copy)]
struct Around {
    point: Point,
    line: Option<usize>,
    foot: Option<Foot>,
    share: f32,
    /// Coordinates in the face; of quads only.
    place: Vec2,
}

/// Ends lines one face before the edges of blocks: an edge that lines split leaves no room for those beside it.
pub fn end_before_blocks(request: &ParallelRequest, crossings: &mut Crossings) {
    let t = request.topology();
    let is_on_block = |point: Point| {
        request.blocks.iter().any(|block| match point {
            Point::Crossing(edge, _) => block.field.is_chain(edge),
            Point::Vertex(vertex) => block.field.around_vertex(vertex).is_some_and(|foot| foot.distance == 0.0),
        })
    };
    let is_beside = |face: &FaceId| t.faces.vertices_of(*face).iter().any(|&v| is_on_block(Point::Vertex(v)));
    let mut last = Vec::new();
    for face in t.faces.ids().filter(is_beside) {
        let around = around(request, crossings, face);
        for [a, b] in (0..request.distances[0].len()).flat_map(|line| ends(request, &around, face, line)) {
            let [a, b] = [a, b].map(|end| around[end].point);
            last.extend(is_on_block(a).then_some(b).into_iter().chain(is_on_block(b).then_some(a)));
        }
    }
    last.into_iter().for_each(|point| crossings.end(point));
}

/// The chords of each face that lines lead through, and the pieces of lines.
pub fn all(request: &ParallelRequest, crossings: &Crossings) -> (BTreeMap<FaceId, Vec<Chord>>, Vec<Passage>) {
    let mut passages = Vec::new();
    let of = |face: FaceId| (face, chords(request, crossings, face, &mut passages));
    let all = touched(request.topology(), crossings).map(of).filter(|(_, chords)| !chords.is_empty()).collect();
    (all, passages)
}

/// The pieces of a line through all faces, each with the side of the chain and its ends in order.
pub fn pieces(request: &ParallelRequest, crossings: &Crossings, line: usize) -> Vec<(usize, [Point; 2])> {
    let mut pieces = Vec::new();
    for face in touched(request.topology(), crossings) {
        let around = around(request, crossings, face);
        for [a, b] in ends(request, &around, face, line).into_iter().map(|piece| piece.map(|end| around[end])) {
            let side = a.foot.map(|foot| foot.side).filter(|_| a.share.min(b.share) > 0.0);
            pieces.extend(side.map(|side| (side, [a.point.min(b.point), a.point.max(b.point)])));
        }
    }
    pieces
}

/// The faces that lines lead to.
fn touched<'a>(t: &'a Topology, crossings: &'a Crossings) -> impl Iterator<Item = FaceId> + 'a {
    t.faces.ids().filter(|&face| {
        let is_crossed = |c: CornerId| crossings.of_edges.contains_key(&t.corner_edge[c]);
        let is_through = |c: CornerId| crossings.through.contains_key(&t.faces.vertex(c));
        t.faces.corners_of(face).any(|c| is_crossed(c) || is_through(c))
    })
}

/// The corners of a face and the crossings of its edges, in its direction.
pub fn ring(t: &Topology, crossings: &Crossings, face: FaceId) -> Vec<Point> {
    let mut ring = Vec::with_capacity(2 * t.faces.valence(face));
    for corner in t.faces.corners_of(face) {
        let (vertex, edge) = (t.faces.vertex(corner), t.corner_edge[corner]);
        ring.push(Point::Vertex(vertex));
        let count = crossings.of_edges.get(&edge).map_or(0, Vec::len);
        let is_forward = t.edges[edge][0] == vertex;
        ring.extend((0..count).map(|i| Point::Crossing(edge, if is_forward { i } else { count - 1 - i })));
    }
    ring
}

/// The corners of the unit square in the order of a quad's corners.
const SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];

fn chords(request: &ParallelRequest, crossings: &Crossings, face: FaceId, passages: &mut Vec<Passage>) -> Vec<Chord> {
    let t = request.topology();
    let around = around(request, crossings, face);
    let mut chords: Vec<Chord> = Vec::new();
    for line in 0..request.distances[0].len() {
        for [a, b] in ends(request, &around, face, line) {
            let (from, to) = (around[a], around[b]);
            let (Some(foot), Some(other)) = (from.foot, to.foot) else { continue };
            if from.share.max(to.share) <= 0.0 {
                continue;
            }
            let along = if foot.chain == other.chain { [foot.along, other.along] } else { [foot.along; 2] };
            let passage = Passage { line, chain: foot.chain, side: foot.side, along };
            if from.share.min(to.share) > 0.0 {
                passages.push(passage);
            }
            let is_along_edge = b - a == 1 || a + around.len() - b == 1;
            if !is_along_edge {
                let share = 0.5 * (from.share + to.share);
                chords.push(Chord { ends: [from.point, to.point], bend: None, passage, share });
            }
        }
    }
    if t.faces.valence(face) == 4 && !chords.is_empty() {
        let place = |point: Point| around.iter().find(|a| a.point == point).map_or(Vec2::ZERO, |a| a.place);
        let bends: Vec<(Vec2, bool)> =
            chords.iter().map(|c| bend(request, face, c.passage, c.ends.map(place))).collect();
        // Lines that bend do so side by side, so that quads stay between them.
        if bends.iter().any(|(_, is_bent)| *is_bent) {
            chords.iter_mut().zip(bends).for_each(|(chord, (at, _))| chord.bend = Some(at));
        }
    }
    chords
}

fn around(request: &ParallelRequest, crossings: &Crossings, face: FaceId) -> Vec<Around> {
    let t = request.topology();
    let first = t.faces.corners_of(face).next();
    let corner_place = |i: usize| SQUARE[i % 4];
    let mut corner = 0;
    let of = |point: Point| match point {
        Point::Vertex(vertex) => {
            let through = crossings.through.get(&vertex);
            corner += 1;
            Around {
                point,
                line: through.map(|(line, ..)| *line),
                foot: through.map(|(_, foot, _)| *foot).or_else(|| request.field.around_vertex(vertex)),
                share: through.map_or(0.0, |(.., share)| *share),
                place: corner_place(corner - 1),
            }
        }
        Point::Crossing(edge, number) => {
            let crossing = &crossings.of_edges[&edge][number];
            let half = first.map(|c| t.faces.ahead(c, corner - 1));
            let is_forward = half.is_some_and(|c| t.faces.vertex(c) == t.edges[edge][0]);
            let part = if is_forward { crossing.at } else { 1.0 - crossing.at };
            let (from, to) = (corner_place(corner - 1), corner_place(corner));
            let (line, foot) = (Some(crossing.line), Some(crossing.foot));
            Around { point, line, foot, share: crossing.share, place: from + part * (to - from) }
        }
    };
    ring(t, crossings, face).into_iter().map(of).collect()
}

/// The ends of the pieces of a line through a face, as indices around it.
fn ends(request: &ParallelRequest, around: &[Around], face: FaceId, line: usize) -> Vec<[usize; 2]> {
    let mut on: Vec<usize> = (0..around.len()).filter(|&i| around[i].line == Some(line)).collect();
    if on.len() % 2 == 1 {
        // A line that touches a corner from outside does not lead through the face.
        on.retain(|&i| matches!(around[i].point, Point::Crossing(..)));
    }
    let &[first, second, ..] = on.as_slice() else { return Vec::new() };
    // The middle of the face is between the pieces, on its side of the line.
    let is_over = |foot: Option<Foot>| foot.is_none_or(|foot| request.over(line, &foot) > 0.0);
    let is_low = around[first + 1..second].iter().any(|p| p.line != Some(line) && !is_over(p.foot));
    if is_low != is_over(request.field.at_centre(face)) {
        on.rotate_left(1);
    }
    let piece = |pair: &[usize]| [pair[0].min(pair[1]), pair[0].max(pair[1])];
    if on.len().is_multiple_of(2) { on.chunks(2).map(piece).collect() } else { Vec::new() }
}

/// Where a line is beside the middle of its chord, and whether it is far enough from there for a bend.
fn bend(request: &ParallelRequest, face: FaceId, passage: Passage, [from, to]: [Vec2; 2]) -> (Vec2, bool) {
    let corners = request.topology().faces.vertices_of(face);
    let place = |p: Vec2| -> Vec3 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| request.points()[corners[i]]);
        (1.0 - p.y) * ((1.0 - p.x) * a + p.x * b) + p.y * ((1.0 - p.x) * d + p.x * c)
    };
    let middle = 0.5 * (from + to);
    let over = |p: Vec2| request.field.within(face, place(p)).map(|foot| request.over(passage.line, &foot));
    // The chord is straight in space, where the middle of its coordinates may be beside it.
    let straight = request.field.within(face, 0.5 * (place(from) + place(to)));
    let (Some(straight), Some(start)) = (straight, over(middle)) else { return (middle, false) };
    let lines = &request.distances[passage.side];
    let step = lines.windows(2).map(|pair| pair[1] - pair[0]).fold(f32::INFINITY, f32::min);
    let across = (to - from).perp().normalize_or_zero();
    let is_within = |p: Vec2| p.cmpge(Vec2::splat(RIM)).all() && p.cmple(Vec2::splat(1.0 - RIM)).all();
    let mut best: Option<Vec2> = None;
    for direction in [across, -across] {
        let Some(far) = [0.25, 0.5, 1.0].map(|r| middle + r * direction).into_iter().find(|&p| {
            over(p.clamp(Vec2::splat(RIM), Vec2::splat(1.0 - RIM))).is_some_and(|value| (value > 0.0) != (start > 0.0))
        }) else {
            continue;
        };
        let (mut near, mut far) = (middle, far.clamp(Vec2::splat(RIM), Vec2::splat(1.0 - RIM)));
        for _ in 0..HALVINGS {
            let half = 0.5 * (near + far);
            let is_near = over(half).is_none_or(|value| (value > 0.0) == (start > 0.0));
            (near, far) = if is_near { (half, far) } else { (near, half) };
        }
        let found = 0.5 * (near + far);
        if is_within(found) && best.is_none_or(|best| middle.distance(found) < middle.distance(best)) {
            best = Some(found);
        }
    }
    best.map_or((middle, false), |at| (at, request.over(passage.line, &straight).abs() > BENT * step))
}
