//! Catmull-Clark, Loop and bilinear subdivision as `UsdGeomMesh` defines them.
//!
//! A [`Level`] is a mesh with its sharpness and rules. A [`Refinement`] of it is a [`Derivation`]: the child's
//! topology, the parent of each element, and stencils for each kind of value. The [`Carrier`] applies these to all
//! attributes of a garment.
//!
//! Weights and numbering are those of OpenSubdiv, so meshes can be compared element by element. Points agree with it to
//! 1e-6 of the bounding box (`tests/golden`).

mod carry;
mod connectivity;
mod fvar;
mod level;
mod limit;
mod masks;
mod refinement;
mod regular;
mod split;
mod stencil;
#[cfg(test)]
mod tests;

pub use carry::{
    Carrier, Derivation, blend_into, blend_rows, blended_channel, carried_points, gathered, scale_to_unit_length,
    to_unit_length,
};
pub use connectivity::{Connectivity, VertexRows};
pub use fvar::{Channel, ChannelChild};
pub use level::{INFINITE_SHARPNESS, Level, Rule, Spoke, edges_at, refined_sharpness, same_level};
pub use refinement::{Refinement, share_values_alike};
pub use split::{Numbering, child_corner, child_values};
pub use stencil::{Real, Stencils, Table};

use crate::connectivity::{CornerId, EdgeId, FaceId, VertexId};
use crate::garment::{Mesh, Scheme};
use regular::Quads;

/// Largest refined mesh. Corners have 32-bit indices, and a face takes about 200 bytes. \[faces\]
pub const MAX_REFINED_FACES: usize = 100_000_000;

/// Number of faces of a garment after `level` refinements.
pub fn refined_faces(garment: &Mesh, level: u32) -> usize {
    let faces = &garment.faces;
    match level {
        0 => faces.len(),
        _ if garment.rules.scheme == Scheme::Loop => faces.len().saturating_mul(4usize.saturating_pow(level)),
        _ => faces.corners().len().saturating_mul(4usize.saturating_pow(level - 1)),
    }
}

impl Level {
    /// The corner of the next level that a corner becomes, at the child of its vertex.
    pub fn child_of(&self, corner: CornerId) -> CornerId {
        match self.scheme {
            // Child j of a triangle has corner j at position j.
            Scheme::Loop => CornerId::new(4 * corner.index()),
            _ => child_corner(&self.topology.faces, corner, 0),
        }
    }

    /// The corner of the next level at the centre of a corner's face; `None` under Loop, which has no vertex there.
    pub fn centre_of(&self, corner: CornerId) -> Option<CornerId> {
        (self.scheme != Scheme::Loop).then(|| child_corner(&self.topology.faces, corner, 2))
    }

    /// The corner that a face of the next level lies at. Under Loop, the middle triangle belongs to the first corner.
    pub fn corner_of_child(&self, child: FaceId) -> CornerId {
        match self.scheme {
            Scheme::Loop if child.index() % 4 == 3 => CornerId::new(child.index() / 4 * 3),
            Scheme::Loop => CornerId::new(child.index() / 4 * 3 + child.index() % 4),
            _ => CornerId::new(child.index()),
        }
    }

    /// Stencils of the child vertices, by the subdivision rules.
    pub fn vertex_stencils(&self) -> VertexStencils<'_> {
        VertexStencils::new(self, false)
    }

    /// Stencils of the child vertices, by linear interpolation.
    pub fn varying_stencils(&self) -> VertexStencils<'_> {
        VertexStencils::new(self, true)
    }
}

/// The vertex masks of a level, or their linear counterparts.
pub struct VertexStencils<'a> {
    level: &'a Level,
    is_linear: bool,
    quads: Option<Quads<'a, VertexId>>,
    own: usize,
    faces: usize,
}

impl<'a> VertexStencils<'a> {
    fn new(level: &'a Level, is_linear: bool) -> Self {
        let faces = if level.scheme == Scheme::Loop { 0 } else { level.topology.faces.len() };
        let quads = if is_linear { None } else { Quads::new(level, level.topology.faces.corners()) };
        Self { level, is_linear, quads, own: level.topology.vertex_count(), faces }
    }
}

impl VertexStencils<'_> {
    /// Emits the row of an all-quad level; `false` without output if the row needs a sharp mask.
    #[inline(always)]
    fn regular_row(&self, quads: &Quads<VertexId>, row: usize, sink: &mut impl FnMut(VertexId, f32)) -> bool {
        if row >= self.own + self.faces {
            return quads.edge(EdgeId::new(row - self.own - self.faces), sink);
        }
        if row >= self.own {
            quads.face(FaceId::new(row - self.own), sink);
            return true;
        }
        quads.vertex(VertexId::new(row), sink)
    }
}

impl Stencils for VertexStencils<'_> {
    type Source = VertexId;

    fn rows(&self) -> usize {
        self.own + self.faces + self.level.topology.edges.len()
    }

    #[inline(always)]
    fn row(&self, row: usize, sink: &mut impl FnMut(VertexId, f32)) {
        if self.quads.is_some_and(|quads| self.regular_row(&quads, row, sink)) {
            return;
        }
        let faces = &self.level.topology.faces;
        let mut by_corner = |corner: CornerId, weight: f32| sink(faces.vertex(corner), weight);
        if row >= self.own + self.faces {
            let edge = EdgeId::new(row - self.own - self.faces);
            match self.is_linear {
                true => masks::middle(self.level, edge, 1.0, &mut by_corner),
                false => masks::edge(self.level, edge, &mut by_corner),
            }
        } else if row >= self.own {
            masks::face(self.level, FaceId::new(row - self.own), 1.0, &mut by_corner);
        } else {
            let vertex = VertexId::new(row);
            if self.is_linear || self.level.topology.vertex_corners.row(vertex).is_empty() {
                sink(vertex, 1.0);
            } else {
                masks::vertex(self.level, vertex, &mut by_corner);
            }
        }
    }
}
