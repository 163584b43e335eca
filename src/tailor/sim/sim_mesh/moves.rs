//! Moves of vertices over the surface and along chains.

use super::{SimMesh, Wedge};
use glam::{Vec2, Vec3};
use tailor_mesh::connectivity::edit::next;
use tailor_mesh::connectivity::{CornerId, VertexId, WedgeId};

/// The place that a vertex should move to.
#[derive(Clone, Copy)]
pub enum Destination {
    /// The point of the surface near a position. \[mesh units\]
    Near(Vec3),
    /// The point of its UV shell at these coordinates.
    AtUv(Vec2),
    /// The point of its chain at a signed arc length from it. \[mesh units\]
    Along(f32),
}

/// A vertex with all that a move changes. Swapped with the mesh, it is the move back.
pub struct VertexMove {
    pub vertex: VertexId,
    position: Vec3,
    target: f32,
    id: WedgeId,
    wedge: Wedge,
    /// Set for a chain's vertex.
    slide: Option<Box<Slide>>,
}

/// The changes to a chain when one of its vertices moves.
struct Slide {
    /// The constrained half-edges along the chain and against it.
    ahead: CornerId,
    back: CornerId,
    /// The signed arc length. \[mesh units\]
    by: f32,
    /// The number of edges that the chain asks for over that length.
    by_count: f32,
    /// The wedge on the other side of the chain.
    other: Option<(WedgeId, Wedge)>,
}

impl VertexMove {
    /// Position and wedge of a corner of the vertex, as the move has them; `there` is the corner's wedge in the mesh.
    pub fn corner<'a>(&'a self, id: WedgeId, there: &'a Wedge) -> (Vec3, &'a Wedge) {
        let other = self.slide.as_ref().and_then(|slide| slide.other.as_ref());
        let wedge = match other {
            _ if id == self.id => &self.wedge,
            Some((other, wedge)) if *other == id => wedge,
            _ => there,
        };
        (self.position, wedge)
    }
}

impl SimMesh<'_> {
    /// The move of a vertex by a share `step` of the way to its destination.
    pub fn find_move(&self, vertex: VertexId, destination: Destination, step: f32) -> Option<VertexMove> {
        let id = self.corner_wedge[self.topology.fan(vertex).next()?];
        let from = self.wedges[id].place;
        let (to, position) = match destination {
            Destination::Near(goal) => {
                let there = self.baseline.closest(from.location.face, self.points[vertex].lerp(goal, step));
                (there.location, there.position)
            }
            Destination::AtUv(goal) => {
                let to = self.baseline.locate_uv(from.location.face, from.uv.lerp(goal, step))?;
                (to, self.baseline.position(to))
            }
            Destination::Along(by) => return self.find_slide(vertex, step * by),
        };
        let target = self.baseline.sizing_at(to);
        Some(VertexMove { vertex, position, target, id, wedge: self.wedge_at(to), slide: None })
    }

    /// The move of a chain's vertex by a signed arc length.
    fn find_slide(&self, vertex: VertexId, by: f32) -> Option<VertexMove> {
        let near = self.curve_neighbours(vertex)?;
        let (ahead, back, chain) = (near.ahead, near.back, self.chain(near.after.chain));
        let (turns, at) = chain.at_with_turns(near.arc_length() + by);
        let by_count = chain.count_at(turns, at) - near.before.counts[1];
        // The corner of a half-edge lies on its left: of one that leaves forward, on the chain's left.
        let leaves = |half: CornerId| self.topology.vertex(half) == vertex;
        let on_left = if leaves(ahead) { Some(ahead) } else { Some(next(back)).filter(|_| !leaves(back)) };
        let on_right = if leaves(back) { Some(back) } else { Some(next(ahead)).filter(|_| !leaves(ahead)) };
        let wedge = |corner: Option<CornerId>, forward: bool| {
            Some((self.corner_wedge[corner?], self.wedge_on_curve(chain, at, forward)?))
        };
        let ((id, wedge), other) = match (wedge(on_left, true), wedge(on_right, false)) {
            (Some(left), right) => (left, right),
            (None, right) => (right?, None),
        };
        let (position, target) = (self.position_on(chain, at), chain.length_at(at));
        let slide = Some(Box::new(Slide { ahead, back, by, by_count, other }));
        Some(VertexMove { vertex, position, target, id, wedge, slide })
    }

    /// Makes a move, which becomes the move back.
    pub fn swap(&mut self, wanted: &mut VertexMove) {
        std::mem::swap(&mut self.points[wanted.vertex], &mut wanted.position);
        std::mem::swap(&mut self.target[wanted.vertex], &mut wanted.target);
        std::mem::swap(&mut self.wedges[wanted.id], &mut wanted.wedge);
        let Some(slide) = &mut wanted.slide else { return };
        for (half, is_start) in [(slide.ahead, true), (slide.back, false)] {
            let Some(own) = self.corner_span[half] else { unreachable!("a slide lies between constrained edges") };
            let span = &mut self.spans[own.span()];
            *(if is_start { &mut span.from } else { &mut span.to }) += slide.by;
            span.counts[usize::from(!is_start)] += slide.by_count;
        }
        (slide.by, slide.by_count) = (-slide.by, -slide.by_count);
        if let Some((id, wedge)) = &mut slide.other {
            std::mem::swap(&mut self.wedges[*id], wedge);
        }
    }
}
