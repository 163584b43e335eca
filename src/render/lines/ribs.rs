//! Where the lines cross the mesh around the marked edges.

use super::{Narrowed, Request};
use crate::mesh::{CornerId, EdgeId, IdVec, Topology, VertexId};
use crate::render::REPORTED;
use glam::Vec3;

/// Part of an edge that lines from one end may take. Larger leaves less of the face beside a wide seam.
const ROOM: f32 = 0.8;
/// Part of an edge that lines from both its ends may take together.
const SHARED_ROOM: f32 = 0.9;
/// Part of the edges of a triangle that a mitre may take, so that three of them do not meet.
const TRIANGLE_ROOM: f32 = 0.28;
/// Part of the edges of a corner that a mitre may take together where lines taper at the ends of both, so that what is left
/// of the face is not concave.
const TAPERED_ROOM: f32 = 0.9;
/// Part of a rib that the line at the full distance may take, so that the one that holds has room outside.
const INNER_ROOM: f32 = 0.75;
/// Least sine of the angle between a rib and a marked edge. Smaller makes longer ribs where a chain turns sharply.
const LEAST_SINE: f32 = 0.34;
/// Least length of an edge as a share of the distance that lines are asked for along it, so that shares stay finite.
const SHORT: f32 = 1e-3;

/// Where a rib leads, with how far along each direction its end is.
#[derive(Clone, Copy, Debug)]
pub enum Path {
    /// Along an unmarked edge, to this part of it.
    Edge { to: VertexId, part: f32 },
    /// Into the face of a corner: parts of the edge after it and of the edge before.
    Face { corner: CornerId, after: f32, before: f32 },
    /// Straight into the face of a corner where its edges are in line: part of the way to the other corners' mean.
    Across { corner: CornerId, part: f32 },
}

/// The places of the lines at one vertex of marked edges.
#[derive(Clone, Debug)]
pub struct Rib {
    /// Where it begins.
    pub vertex: VertexId,
    /// Where it leads.
    pub path: Path,
    /// For each line how far along the path it is, as a share.
    pub steps: Vec<f32>,
    /// The marked edge that the lines belong to.
    pub mark: EdgeId,
}

/// All ribs of a request.
pub struct Ribs {
    /// The ribs.
    pub all: Vec<Rib>,
    /// The rib along an edge from its first and second vertex.
    along: IdVec<EdgeId, [Option<u32>; 2]>,
    /// The rib into the face of a corner.
    within: IdVec<CornerId, Option<u32>>,
    /// Corners that lines pass.
    pub active: IdVec<CornerId, bool>,
    /// Ribs that are shorter than asked.
    pub narrowed: Vec<Narrowed>,
}

/// The length of a spoke's rib and the marked edge it belongs to.
type Reach = (f32, EdgeId);

impl Ribs {
    /// The ribs of a request.
    pub fn new(request: &Request) -> Self {
        let t = request.topology;
        let mut ribs = Self {
            all: Vec::new(),
            along: IdVec::filled([None; 2], t.edges.len()),
            within: IdVec::filled(None, t.faces.corners().len()),
            active: active_corners(request),
            narrowed: Vec::new(),
        };
        ribs.add_spokes(request);
        ribs.add_mitres(request);
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

    /// Ribs along unmarked edges at active corners.
    fn add_spokes(&mut self, request: &Request) {
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
            let length = request.points[vertices[0]].distance(request.points[vertices[1]]);
            let reach = [0, 1].map(|i| ends[i].then(|| spoke_reach(request, edge, vertices[i])).flatten());
            let asked = reach.map(|r| r.map_or(0.0, |(reach, _)| share_of(outer * reach, length)));
            let room = if asked[0] > 0.0 && asked[1] > 0.0 { SHARED_ROOM } else { ROOM };
            let scale = (room / (asked[0] + asked[1])).min(1.0);
            for i in [0, 1] {
                let Some((_, mark)) = reach[i] else { continue };
                let path = Path::Edge { to: vertices[1 - i], part: asked[i] * scale };
                let steps = self.steps(request, vertices[i], mark, scale);
                self.along[edge][i] = self.push(Rib { vertex: vertices[i], path, steps, mark });
            }
        }
    }

    /// The places of the lines on a rib that was scaled to the room there is.
    fn steps(&mut self, request: &Request, vertex: VertexId, mark: EdgeId, scale: f32) -> Vec<f32> {
        let outer = request.shares.last().copied().unwrap_or(1.0);
        let width = request.shares[request.kept_line];
        let most = if outer > width { INNER_ROOM } else { 1.0 };
        let inner = (width / (outer * scale)).min(most);
        let kept = inner * outer * scale / width;
        if kept < REPORTED {
            self.narrowed.push(Narrowed { vertex, mark, share: kept });
        }
        request.shares.iter().map(|&s| if s > width { 1.0 } else { inner * s / width }).collect()
    }

    /// Ribs into faces with two marked edges at a corner.
    fn add_mitres(&mut self, request: &Request) {
        let t = request.topology;
        let marked = |c: CornerId| request.marked[t.corner_edge[c]];
        let is_mitre = |c: &CornerId| marked(*c) && marked(t.faces.prev(*c));
        let corners: Vec<CornerId> = self.active.ids().filter(|&c| self.active[c]).filter(is_mitre).collect();
        let paths: Vec<Path> = corners.iter().map(|&c| mitre(request, c)).collect();
        let parts = |c: CornerId| {
            corners.binary_search(&c).ok().map_or([0.0; 2], |at| match paths[at] {
                Path::Face { after, before, .. } => [after, before],
                _ => [0.0; 2],
            })
        };
        for (&corner, &path) in corners.iter().zip(&paths) {
            let mark = t.corner_edge[corner];
            let next_to = [parts(t.faces.next(corner))[1], parts(t.faces.prev(corner))[0]];
            let (scale, path) = within_room(request, path, next_to);
            let vertex = t.faces.vertex(corner);
            let steps = self.steps(request, vertex, mark, scale);
            self.within[corner] = self.push(Rib { vertex, path, steps, mark });
        }
    }

    /// Ribs between two spokes of one face. In a triangle they would make a face of no use.
    fn add_diagonals(&mut self, request: &Request) {
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

/// Corners in fans of faces that have a marked edge at their vertex, unless lines taper there.
fn active_corners(request: &Request) -> IdVec<CornerId, bool> {
    let t = request.topology;
    let mut active = IdVec::filled(false, t.faces.corners().len());
    let may = |c: CornerId| request.cuttable[t.faces.face_of(c)] && !request.tapers[t.faces.vertex(c)];
    for start in active.ids() {
        let prev = t.faces.prev(start);
        let marked = request.marked[t.corner_edge[start]] || request.marked[t.corner_edge[prev]];
        if !marked || !may(start) {
            continue;
        }
        active[start] = true;
        for turn in [Turn::Left, Turn::Right] {
            let mut corner = start;
            while let Some(next) = turn.across_unmarked(request, corner).filter(|&c| may(c) && !active[c]) {
                active[next] = true;
                corner = next;
            }
        }
    }
    active
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
    /// The edge of a corner on this side, and the half-edge of its face along it.
    fn side(self, t: &Topology, corner: CornerId) -> CornerId {
        match self {
            Self::Left => t.faces.prev(corner),
            Self::Right => corner,
        }
    }

    /// The next corner around the vertex, unless a marked edge is between.
    fn across_unmarked(self, request: &Request, corner: CornerId) -> Option<CornerId> {
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
        // Neighbours that disagree in winding have the vertex at the other end.
        (t.faces.vertex(next) == t.faces.vertex(corner)).then_some(next)
    }
}

/// How far a rib along `edge` from `vertex` leads until it is as far as asked from the marked edges next to it.
fn spoke_reach(request: &Request, edge: EdgeId, vertex: VertexId) -> Option<Reach> {
    let t = request.topology;
    let mut nearest: [Option<(usize, CornerId)>; 2] = [None; 2];
    for &corner in t.vertex_corners.row(vertex) {
        // The edge is the last of a corner on its left, and the first of one on its right.
        for (i, (turn, back)) in [(Turn::Left, Turn::Right), (Turn::Right, Turn::Left)].into_iter().enumerate() {
            if t.corner_edge[back.side(t, corner)] == edge {
                let found = steps_to_mark(request, corner, turn);
                nearest[i] = [nearest[i], found].into_iter().flatten().min();
            }
        }
    }
    let least = nearest.iter().flatten().map(|n| n.0).min()?;
    let chosen: Vec<CornerId> = nearest.iter().flatten().filter(|n| n.0 == least).map(|n| n.1).collect();
    let along = direction(request, edge, vertex);
    let reach = |half: CornerId| {
        let sine = along.cross(direction(request, t.corner_edge[half], vertex)).length();
        request.distance[half] / sine.max(LEAST_SINE)
    };
    let mean = chosen.iter().map(|&half| reach(half)).sum::<f32>() / chosen.len() as f32;
    Some((mean, t.corner_edge[chosen[0]]))
}

/// Faces to pass until a marked edge, and its half-edge there.
fn steps_to_mark(request: &Request, start: CornerId, turn: Turn) -> Option<(usize, CornerId)> {
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

/// A distance as a share of a length, which may be none.
fn share_of(distance: f32, length: f32) -> f32 {
    distance / length.max(SHORT * distance).max(f32::MIN_POSITIVE)
}

fn direction(request: &Request, edge: EdgeId, from: VertexId) -> Vec3 {
    let [a, b] = request.topology.edges[edge];
    let to = if a == from { b } else { a };
    (request.points[to] - request.points[from]).normalize_or_zero()
}

/// The path of a mitre as far as there is room beside those of the next corner and of the one before, and the share of it
/// that this is.
fn within_room(request: &Request, path: Path, [ahead, behind]: [f32; 2]) -> (f32, Path) {
    let t = request.topology;
    match path {
        Path::Face { corner, after, before } => {
            let is_triangle = t.faces.valence(t.faces.face_of(corner)) == 3;
            let tapers = |c: CornerId| request.tapers[t.faces.vertex(c)];
            let is_tapered = tapers(t.faces.next(corner)) && tapers(t.faces.prev(corner));
            let shared = if is_triangle { 2.0 * TRIANGLE_ROOM } else { SHARED_ROOM };
            let both = if is_tapered { TAPERED_ROOM } else { 2.0 * ROOM };
            let rooms = [shared / (after + ahead), shared / (before + behind), ROOM / after, ROOM / before];
            let scale = rooms.into_iter().fold(f32::min(1.0, both / (after + before)), f32::min);
            (scale, Path::Face { corner, after: after * scale, before: before * scale })
        }
        Path::Across { corner, part } => {
            let scale = (0.5 * ROOM / part).min(1.0);
            (scale, Path::Across { corner, part: part * scale })
        }
        edge @ Path::Edge { .. } => (1.0, edge),
    }
}

/// Where the outermost lines beside the two marked edges of a corner meet.
fn mitre(request: &Request, corner: CornerId) -> Path {
    let t = request.topology;
    let outer = request.shares.last().copied().unwrap_or(1.0);
    let prev = t.faces.prev(corner);
    let at = |c: CornerId| request.points[t.faces.vertex(c)];
    let (next, back) = (at(t.faces.next(corner)) - at(corner), at(prev) - at(corner));
    let (after, before) = (next.length(), back.length());
    let (d1, d2) = (next.normalize_or_zero(), back.normalize_or_zero());
    let [from_after, from_before] = [corner, prev].map(|half| outer * request.distance[half]);
    let sine = d1.cross(d2).length();
    if d1.dot(d2) < 0.0 && sine < LEAST_SINE {
        let others: Vec<Vec3> = t.faces.corners_of(t.faces.face_of(corner)).filter(|&c| c != corner).map(at).collect();
        let middle = others.iter().sum::<Vec3>() / others.len() as f32 - at(corner);
        let away = middle.reject_from_normalized((d1 - d2).normalize_or_zero()).length();
        return Path::Across { corner, part: share_of(0.5 * (from_after + from_before), away) };
    }
    let sine = sine.max(LEAST_SINE);
    Path::Face { corner, after: share_of(from_before / sine, after), before: share_of(from_after / sine, before) }
}
