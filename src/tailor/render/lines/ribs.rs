//! The ribs of a request: paths away from the vertices of marked edges, and the steps of the lines along them.
//!
//! A rib along an edge is as long as the requested distance over the sine of its angle to the marked edge. A mitre ends
//! where the outermost lines of two marked edges intersect. Both shrink to the space in their faces, so that ribs from
//! opposite ends stay apart.

use super::LineRequest;
use crate::render::operator::REPORTED;
use glam::Vec3;
use tailor_mesh::connectivity::{CornerId, EdgeId, IdVec, Topology, VertexId};

/// Share of an edge that lines from one end may use. A larger share leaves less of the face beside a wide seam.
pub const MAX_EDGE_SHARE: f32 = 0.9;
/// Share of an edge that lines from both ends may use together.
pub const MAX_SHARED_SHARE: f32 = 0.9;
/// The most by which an edge may be longer on the surface than on the cage. Where it is longer still, the cage is folded, and
/// what its lines need is between the vertices of the cage.
const MOST_STRETCHED: f32 = 1.25;
/// Share of the edges of a triangle that a mitre may use, so that three mitres stay apart.
const MAX_TRIANGLE_SHARE: f32 = 0.28;
/// Largest step of the kept line in a narrow face, which leaves space for the support loop outside.
const MAX_KEPT_STEP: f32 = 0.85;
/// Smallest assumed sine of the angle between a rib and a marked edge. A smaller one gives longer ribs at sharp turns.
const MIN_SINE: f32 = 0.34;
/// Smallest sine of the corners at the end of a path, around which lines can lead.
const MIN_END_SINE: f32 = 0.34;
/// Smallest assumed length of an edge, as a share of the requested distance, so that shares stay finite.
const MIN_LENGTH: f32 = 1e-3;

/// The path of a rib and its length.
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// Along an unmarked edge, over a share of its length.
    Edge { to: VertexId, part: f32 },
    /// Into the face of a corner: shares of the edge after it and of the edge before it.
    Face { corner: CornerId, after: f32, before: f32 },
    /// Into the face of a corner with collinear edges: a share of the way to the mean of the other corners.
    Across { corner: CornerId, part: f32 },
}

/// A rib: the positions of the lines at one vertex of marked edges.
#[derive(Clone, Debug)]
pub struct Rib {
    /// The vertex where it begins.
    pub vertex: VertexId,
    /// The path to its end.
    pub path: Path,
    /// For each line, its share of the path.
    pub steps: Vec<f32>,
    /// The marked edge of the lines.
    pub mark: EdgeId,
}

impl Rib {
    /// The corner into whose face it leads.
    pub fn corner(&self) -> Option<CornerId> {
        match self.path {
            Path::Edge { .. } => None,
            Path::Face { corner, .. } | Path::Across { corner, .. } => Some(corner),
        }
    }
}

/// All ribs of a request.
pub struct Ribs {
    /// The ribs.
    pub all: Vec<Rib>,
    /// The ribs along each edge, from its first and second vertex.
    along: IdVec<EdgeId, [Option<u32>; 2]>,
    /// The rib into the face of each corner.
    within: IdVec<CornerId, Option<u32>>,
    /// True for corners that lines pass.
    pub active: IdVec<CornerId, bool>,
    /// For each vertex, the share of the distance of its lines that its faces leave room for.
    pub room: IdVec<VertexId, f32>,
}

impl Ribs {
    /// The ribs of a request. `shares` are those of the requested distance at each vertex.
    pub fn new(request: &LineRequest, shares: &IdVec<VertexId, f32>) -> Self {
        let t = request.topology;
        let mut ribs = Self {
            all: Vec::new(),
            along: IdVec::filled([None; 2], t.edges.len()),
            within: IdVec::filled(None, t.faces.corners().len()),
            active: active_corners(request),
            room: IdVec::filled(1.0, t.vertex_count()),
        };
        ribs.add_spokes(request, shares);
        ribs.add_mitres(request, shares);
        ribs.add_diagonals(request);
        ribs
    }

    /// The rib along `edge` from `vertex`.
    pub fn along(&self, t: &Topology, edge: EdgeId, vertex: VertexId) -> Option<usize> {
        self.along[edge][usize::from(t.edges[edge][0] != vertex)].map(|r| r as usize)
    }

    /// The rib into the face of a corner.
    pub fn within(&self, corner: CornerId) -> Option<usize> {
        self.within[corner].map(|r| r as usize)
    }

    fn push(&mut self, rib: Rib) -> Option<u32> {
        self.all.push(rib);
        Some(self.all.len() as u32 - 1)
    }

    /// Adds ribs along the unmarked edges of active corners.
    fn add_spokes(&mut self, request: &LineRequest, shares: &IdVec<VertexId, f32>) {
        let t = request.topology;
        let mut wanted = IdVec::filled([false; 2], t.edges.len());
        for corner in self.active.ids().filter(|&c| self.active[c]) {
            let vertex = t.faces.vertex(corner);
            for edge in [t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]] {
                wanted[edge][usize::from(t.edges[edge][0] != vertex)] |= !request.marked[edge];
            }
        }
        let outer = request.shares.last().copied().unwrap_or(1.0);
        for (edge, &ends) in wanted.enumerated().filter(|(_, w)| w[0] || w[1]) {
            let vertices = t.edges[edge];
            let lengths = [request.points, request.on_surface].map(|at| at[vertices[0]].distance(at[vertices[1]]));
            let length = lengths[1].min(MOST_STRETCHED * lengths[0]).max(lengths[0]);
            let reach = [0, 1].map(|i| ends[i].then(|| spoke_reach(request, edge, vertices[i])).flatten());
            let asked = [0, 1]
                .map(|i| reach[i].map_or(0.0, |(reach, _)| share_of(outer * shares[vertices[i]] * reach, length)));
            let most = if asked[0] > 0.0 && asked[1] > 0.0 { MAX_SHARED_SHARE } else { MAX_EDGE_SHARE };
            let scale = (most / (asked[0] + asked[1])).min(1.0);
            for i in [0, 1] {
                let Some((_, mark)) = reach[i] else { continue };
                let path = Path::Edge { to: vertices[1 - i], part: asked[i] * scale };
                let steps = self.steps(request, vertices[i], scale);
                self.along[edge][i] = self.push(Rib { vertex: vertices[i], path, steps, mark });
            }
        }
    }

    /// The steps of the lines on a rib that was scaled to the available space.
    fn steps(&mut self, request: &LineRequest, vertex: VertexId, scale: f32) -> Vec<f32> {
        let outer = request.shares.last().copied().unwrap_or(1.0);
        let width = request.shares[request.kept_line];
        let most = if outer > width { MAX_KEPT_STEP } else { 1.0 };
        let inner = (width / (outer * scale)).min(most);
        let kept = inner * outer * scale / width;
        if kept < REPORTED {
            self.room[vertex] = self.room[vertex].min(kept);
        }
        request.shares.iter().map(|&s| if s > width { 1.0 } else { inner * s / width }).collect()
    }

    /// Adds ribs into faces with two marked edges at a corner.
    fn add_mitres(&mut self, request: &LineRequest, shares: &IdVec<VertexId, f32>) {
        let t = request.topology;
        let marked = |c: CornerId| request.marked[t.corner_edge[c]];
        let is_mitre = |c: &CornerId| marked(*c) && marked(t.faces.prev(*c));
        let corners: Vec<CornerId> = self.active.ids().filter(|&c| self.active[c]).filter(is_mitre).collect();
        let paths: Vec<Path> = corners.iter().map(|&c| mitre(request, c, shares[t.faces.vertex(c)])).collect();
        let parts = |c: CornerId| {
            corners.binary_search(&c).ok().map_or([0.0; 2], |at| match paths[at] {
                Path::Face { after, before, .. } => [after, before],
                _ => [0.0; 2],
            })
        };
        for (&corner, &path) in corners.iter().zip(&paths) {
            let mark = t.corner_edge[corner];
            let neighbours = [parts(t.faces.next(corner))[1], parts(t.faces.prev(corner))[0]];
            let (scale, path) = clamped_mitre(request, path, neighbours);
            let vertex = t.faces.vertex(corner);
            let steps = self.steps(request, vertex, scale);
            self.within[corner] = self.push(Rib { vertex, path, steps, mark });
        }
    }

    /// Adds ribs between two spokes of one face, except in triangles, where the corner block is a single quad.
    fn add_diagonals(&mut self, request: &LineRequest) {
        let t = request.topology;
        for corner in self.active.ids() {
            let prev = t.faces.prev(corner);
            let edges = [t.corner_edge[corner], t.corner_edge[prev]];
            let marked = edges.iter().any(|&e| request.marked[e]);
            if !self.active[corner] || marked || t.faces.valence(t.faces.face_of(corner)) == 3 {
                continue;
            }
            let vertex = t.faces.vertex(corner);
            let [Some(after), Some(before)] = edges.map(|e| self.along(t, e, vertex)) else { continue };
            let part = |rib: &Rib| if let Path::Edge { part, .. } = rib.path { part } else { 0.0 };
            let (after, before) = (&self.all[after], &self.all[before]);
            let path = Path::Face { corner, after: part(after), before: part(before) };
            let steps = after.steps.iter().zip(&before.steps).map(|(a, b)| 0.5 * (a + b)).collect();
            let rib = Rib { vertex, path, steps, mark: after.mark };
            self.within[corner] = self.push(rib);
        }
    }
}

/// True for corners of cuttable fans of faces that begin at a marked edge of their vertex. At the end of a path they lead
/// around it, unless a corner there is too sharp: lines then meet in the end.
fn active_corners(request: &LineRequest) -> IdVec<CornerId, bool> {
    let t = request.topology;
    let mut active = IdVec::filled(false, t.faces.corners().len());
    let is_sharp = |v: VertexId| t.vertex_corners.row(v).iter().any(|&c| sine(request, c) < MIN_END_SINE);
    let closed: IdVec<VertexId, bool> = request.tapers.enumerated().map(|(v, ends)| *ends && is_sharp(v)).collect();
    let is_open = |c: CornerId| request.cuttable[t.faces.face_of(c)] && !closed[t.faces.vertex(c)];
    for start in active.ids() {
        let prev = t.faces.prev(start);
        let marked = request.marked[t.corner_edge[start]] || request.marked[t.corner_edge[prev]];
        if !marked || !is_open(start) {
            continue;
        }
        active[start] = true;
        for turn in [Turn::Left, Turn::Right] {
            let mut corner = start;
            while let Some(next) = turn.across_unmarked(request, corner).filter(|&c| is_open(c) && !active[c]) {
                active[next] = true;
                corner = next;
            }
        }
    }
    active
}

/// The sine of the angle between the edges at a corner.
pub fn sine(request: &LineRequest, corner: CornerId) -> f32 {
    let faces = &request.topology.faces;
    let at = |c: CornerId| request.points[faces.vertex(c)] - request.points[faces.vertex(corner)];
    at(faces.next(corner)).normalize_or_zero().cross(at(faces.prev(corner)).normalize_or_zero()).length()
}

/// A direction around a vertex.
#[derive(Clone, Copy)]
enum Turn {
    /// Over the edge before the corner.
    Left,
    /// Over the edge after it.
    Right,
}

impl Turn {
    /// The half-edge of a corner's face on this side.
    fn side(self, t: &Topology, corner: CornerId) -> CornerId {
        match self {
            Self::Left => t.faces.prev(corner),
            Self::Right => corner,
        }
    }

    /// The next corner around the vertex, unless a marked edge or border is between.
    fn across_unmarked(self, request: &LineRequest, corner: CornerId) -> Option<CornerId> {
        let t = request.topology;
        let half = self.side(t, corner);
        if request.marked[t.corner_edge[half]] {
            return None;
        }
        let twin = t.twin(half)?;
        let next = match self {
            Self::Left => twin,
            Self::Right => t.faces.next(twin),
        };
        // A neighbour of opposite winding has the vertex at the other end.
        (t.faces.vertex(next) == t.faces.vertex(corner)).then_some(next)
    }
}

/// The length of the rib along `edge` from `vertex` that reaches the requested distance from the nearest marked edges,
/// and one of these. Two equally near marked edges give the mean length. At the end of a path, the distance is that from
/// the end.
fn spoke_reach(request: &LineRequest, edge: EdgeId, vertex: VertexId) -> Option<(f32, EdgeId)> {
    let t = request.topology;
    let mut nearest: [Option<(usize, CornerId)>; 2] = [None; 2];
    for &corner in t.vertex_corners.row(vertex) {
        for (i, (turn, back)) in [(Turn::Left, Turn::Right), (Turn::Right, Turn::Left)].into_iter().enumerate() {
            if t.corner_edge[back.side(t, corner)] == edge {
                let found = nearest_marked(request, corner, turn);
                nearest[i] = [nearest[i], found].into_iter().flatten().min();
            }
        }
    }
    let least = nearest.iter().flatten().map(|n| n.0).min()?;
    let chosen: Vec<CornerId> = nearest.iter().flatten().filter(|n| n.0 == least).map(|n| n.1).collect();
    let along = direction(request, edge, vertex);
    let reach = |half: CornerId| {
        let mark = direction(request, t.corner_edge[half], vertex);
        let sine = if request.tapers[vertex] { 1.0 } else { along.cross(mark).length() };
        request.distance[half] / sine.max(MIN_SINE)
    };
    let mean = chosen.iter().map(|&half| reach(half)).sum::<f32>() / chosen.len() as f32;
    Some((mean, t.corner_edge[chosen[0]]))
}

/// The number of faces from a corner to the next marked edge around the vertex, and the half-edge there.
fn nearest_marked(request: &LineRequest, start: CornerId, turn: Turn) -> Option<(usize, CornerId)> {
    let t = request.topology;
    let most = t.vertex_corners.row(t.faces.vertex(start)).len();
    let mut corner = start;
    for steps in 1..=most {
        if !request.cuttable[t.faces.face_of(corner)] {
            return None;
        }
        let half = turn.side(t, corner);
        if request.marked[t.corner_edge[half]] {
            return Some((steps, half));
        }
        corner = turn.across_unmarked(request, corner)?;
    }
    None
}

/// A distance as a share of a length, which may be zero.
fn share_of(distance: f32, length: f32) -> f32 {
    distance / length.max(MIN_LENGTH * distance).max(f32::MIN_POSITIVE)
}

fn direction(request: &LineRequest, edge: EdgeId, from: VertexId) -> Vec3 {
    let [a, b] = request.topology.edges[edge];
    let to = if a == from { b } else { a };
    (request.points[to] - request.points[from]).normalize_or_zero()
}

/// The scale of a mitre that fits beside the mitres of the next corner and the previous one, and the scaled path.
fn clamped_mitre(request: &LineRequest, path: Path, [ahead, behind]: [f32; 2]) -> (f32, Path) {
    let t = request.topology;
    match path {
        Path::Face { corner, after, before } => {
            let is_triangle = t.faces.valence(t.faces.face_of(corner)) == 3;
            let shared = if is_triangle { 2.0 * MAX_TRIANGLE_SHARE } else { MAX_SHARED_SHARE };
            let scales =
                [shared / (after + ahead), shared / (before + behind), MAX_EDGE_SHARE / after, MAX_EDGE_SHARE / before];
            let scale = scales.into_iter().fold(1.0, f32::min);
            (scale, Path::Face { corner, after: after * scale, before: before * scale })
        }
        Path::Across { corner, part } => {
            let scale = (0.5 * MAX_EDGE_SHARE / part).min(1.0);
            (scale, Path::Across { corner, part: part * scale })
        }
        edge @ Path::Edge { .. } => (1.0, edge),
    }
}

/// The path to the intersection of the outermost lines beside the two marked edges of a corner, at a share of their
/// distance.
fn mitre(request: &LineRequest, corner: CornerId, share: f32) -> Path {
    let t = request.topology;
    let outer = share * request.shares.last().copied().unwrap_or(1.0);
    let prev = t.faces.prev(corner);
    let at = |c: CornerId| request.points[t.faces.vertex(c)];
    let (next, back) = (at(t.faces.next(corner)) - at(corner), at(prev) - at(corner));
    let (after, before) = (next.length(), back.length());
    let (d1, d2) = (next.normalize_or_zero(), back.normalize_or_zero());
    let [from_after, from_before] = [corner, prev].map(|half| outer * request.distance[half]);
    let sine = d1.cross(d2).length();
    if d1.dot(d2) < 0.0 && sine < MIN_SINE {
        let others: Vec<Vec3> = t.faces.corners_of(t.faces.face_of(corner)).filter(|&c| c != corner).map(at).collect();
        let middle = others.iter().sum::<Vec3>() / others.len() as f32 - at(corner);
        let away = middle.reject_from_normalized((d1 - d2).normalize_or_zero()).length();
        return Path::Across { corner, part: share_of(0.5 * (from_after + from_before), away) };
    }
    let sine = sine.max(MIN_SINE);
    Path::Face { corner, after: share_of(from_before / sine, after), before: share_of(from_after / sine, before) }
}
