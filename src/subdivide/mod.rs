//! Catmull-Clark, Loop and bilinear subdivision as `UsdGeomMesh` defines them, as derivations.
//!
//! A refinement does not move values itself: it yields a [`Derivation`] (the child's topology, stencils for every kind
//! of value, the parent of each element), and values of any kind are carried by that. Conventions and weights are
//! OpenSubdiv's; values agree with it to 1e-6 of the bounding box.

mod cage;
mod carry;
mod channels;
mod connectivity;
mod fvar;
mod level;
mod limit;
mod masks;
mod regular;
mod split;
mod stencil;

pub use cage::Cage;
pub use carry::{
    Lineage, carried_points, mix_into, mix_rows, mixed_channel, scale_to_unit_length, taken, to_unit_length,
};
pub use channels::Channels;
pub use connectivity::{Connectivity, Fingerprint, VertexRows};
pub use fvar::{Channel, ChannelChild};
pub use level::{INFINITE_SHARPNESS, Level, Rule, Spoke, refined_sharpness};
pub use split::{Numbering, child_corner};
pub use stencil::{Real, Stencils, Table};

use crate::garment::{Garment, Scheme};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, VertexId};
use regular::Quads;

/// Largest refined mesh: its corners are counted in 32 bits, and it takes some 200 bytes a face. \[faces\]
pub const MAX_REFINED_FACES: usize = 100_000_000;

/// Faces of a garment after `level` refinements.
pub fn refined_faces(garment: &Garment, level: u32) -> usize {
    let faces = &garment.faces;
    match level {
        0 => faces.len(),
        _ if garment.rules.scheme == Scheme::Loop => faces.len().saturating_mul(4usize.saturating_pow(level)),
        _ => faces.corners().len().saturating_mul(4usize.saturating_pow(level - 1)),
    }
}

/// A level with its face-varying channels, ready to be refined.
#[derive(Clone, Debug)]
pub struct Refiner {
    /// The level.
    pub level: Level,
    /// Its face-varying channels.
    pub channels: Vec<Channel>,
}

impl Refiner {
    /// The unrefined level of a garment, without channels.
    pub fn new(garment: &Garment) -> Self {
        Self { level: Level::base(garment), channels: Vec::new() }
    }

    /// Adds a channel whose corners take the rows `rows`; returns the row of each of its values.
    pub fn add_channel(&mut self, garment: &Garment, rows: impl Fn(CornerId) -> usize) -> Vec<u32> {
        let rules = garment.rules;
        let (channel, rows) = Channel::base(&self.level, rows, rules.face_varying, rules.boundary);
        self.channels.push(channel);
        rows
    }

    /// The child corner of a corner, at the child of its vertex.
    pub fn child_of(&self, corner: CornerId) -> CornerId {
        match self.level.scheme {
            // Child j of a triangle holds corner j at place j.
            Scheme::Loop => CornerId::new(4 * corner.index()),
            _ => child_corner(&self.level.topology.faces, corner, 0),
        }
    }

    /// The corner at the centre of a corner's face, in the child of that corner; none under Loop, which has no such
    /// vertex.
    pub fn centre_of(&self, corner: CornerId) -> Option<CornerId> {
        (self.level.scheme != Scheme::Loop).then(|| child_corner(&self.level.topology.faces, corner, 2))
    }

    /// The corner whose part of its face a child face is; the middle of a triangle under Loop counts to its first.
    pub fn corner_of_child(&self, child: FaceId) -> CornerId {
        match self.level.scheme {
            Scheme::Loop if child.index() % 4 == 3 => CornerId::new(child.index() / 4 * 3),
            Scheme::Loop => CornerId::new(child.index() / 4 * 3 + child.index() % 4),
            _ => CornerId::new(child.index()),
        }
    }

    /// The refinement of this level.
    pub fn derive(&self) -> Derivation<'_> {
        Derivation {
            level: &self.level,
            faces: split::child_faces(&self.level),
            channels: self.channels.iter().map(|c| ChannelChild::new(&self.level, c)).collect(),
        }
    }
}

impl Level {
    /// Child vertices from this level's, by the subdivision rules.
    pub fn vertex_stencils(&self) -> VertexStencils<'_> {
        VertexStencils::new(self, false)
    }

    /// Child vertices from this level's, linearly.
    pub fn varying_stencils(&self) -> VertexStencils<'_> {
        VertexStencils::new(self, true)
    }
}

/// One refinement: what the child's elements are made of.
pub struct Derivation<'a> {
    level: &'a Level,
    /// The child's faces.
    pub faces: Faces,
    /// Child values from parent values, for each face-varying channel.
    pub channels: Vec<ChannelChild<'a>>,
}

impl<'a> Derivation<'a> {
    /// The parent level.
    pub fn parent(&self) -> &'a Level {
        self.level
    }

    /// Where the children of the parent's elements are.
    pub fn numbering(&self) -> Numbering {
        Numbering::new(self.level)
    }

    /// Child vertices from parent vertices, by the subdivision rules.
    pub fn vertex(&self) -> VertexStencils<'a> {
        self.level.vertex_stencils()
    }

    /// Child vertices from parent vertices, linearly.
    pub fn varying(&self) -> VertexStencils<'a> {
        self.level.varying_stencils()
    }

    /// The refined level.
    pub fn into_child(self) -> Refiner {
        let level = split::child_level(self.level, self.faces);
        let channels = self.channels.into_iter().map(|c| c.into_channel(&level)).collect();
        Refiner { level, channels }
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
    /// The row of a mesh of quads; whether it is one of the smooth ones.
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
