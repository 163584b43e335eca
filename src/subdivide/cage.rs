//! A garment on its way through refinements and operators.

use super::carry::{Carry, Lineage, carried_points, carry, to_unit_length};
use super::channels::Channels;
use super::stencil::Stencils;
use super::{INFINITE_SHARPNESS, Level, Numbering, refined_sharpness};
use crate::garment::joints::{self, Influences};
use crate::garment::{Corner, Crease, Garment, Primvar, Scheme};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use glam::Vec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A refinement as a lineage.
pub struct Refinement<'a> {
    level: &'a Level,
    faces: Faces,
    channels: &'a Channels,
}

impl Refinement<'_> {
    fn is_loop(&self) -> bool {
        self.level.scheme == Scheme::Loop
    }
}

impl Lineage for Refinement<'_> {
    const EDGES_ARE_OWN: bool = true;

    fn parent(&self) -> &Topology {
        &self.level.topology
    }

    fn faces(&self) -> &Faces {
        &self.faces
    }

    #[inline]
    fn parent_face(&self, child: FaceId) -> FaceId {
        Numbering::new(self.level).parent_face(&self.level.topology.faces, child)
    }

    #[inline]
    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId> {
        Numbering::new(self.level).of_face_within(&self.level.topology.faces, parent)
    }

    #[inline]
    fn parent_corner(&self, corner: CornerId) -> CornerId {
        let child = self.faces.face_of(corner);
        if !self.is_loop() {
            // A child quad belongs to one corner of its parent.
            return CornerId::new(child.index());
        }
        let (parent, step) = (self.level.topology.faces.range(self.parent_face(child)).start, child.index() % 4);
        CornerId::new(parent + if step < 3 { step } else { corner.index() % 3 })
    }

    fn child_vertex(&self, vertex: VertexId) -> VertexId {
        Numbering::new(self.level).of_vertex(vertex)
    }

    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>) {
        let numbering = Numbering::new(self.level);
        let ([a, b], middle) = (self.level.topology.edges[edge], numbering.of_edge(edge));
        children.extend([[numbering.of_vertex(a), middle], [middle, numbering.of_vertex(b)]]);
    }

    fn remaining(&self, sharpness: f32) -> f32 {
        refined_sharpness(sharpness)
    }

    fn vertex(&self) -> impl Stencils<Source = VertexId> {
        self.level.vertex_stencils()
    }

    fn varying(&self) -> impl Stencils<Source = VertexId> {
        self.level.varying_stencils()
    }

    fn face_varying(&self, garment: &Garment, place: usize) -> Primvar {
        self.channels.refined_primvar(self.level, place, &garment.primvars[place])
    }
}

/// A garment on its way through derivations. Its joint influences are kept whole until the end, so that they are pruned
/// to `elementSize` only once.
#[derive(Clone)]
pub struct Cage {
    garment: Garment,
    level: Arc<Level>,
    influences: Option<Vec<Influences>>,
}

impl Cage {
    /// The cage of a garment.
    pub fn new(garment: Garment) -> Self {
        let influences = joints::pair(&garment).map(|(indices, weights)| joints::influences(indices, weights));
        Self { level: Arc::new(Level::base(&garment)), garment, influences }
    }

    /// The garment as it is so far: its skinning and its directions are not yet what [`Cage::into_garment`] gives.
    pub fn garment(&self) -> &Garment {
        &self.garment
    }

    /// The cage's connectivity and rules.
    pub fn level(&self) -> &Level {
        &self.level
    }

    /// The cage refined once, with every attribute, where its level refined is `level` and its channels are `channels`. Its
    /// points are not: they are zero.
    pub fn refined(&self, level: Arc<Level>, channels: &Channels) -> Self {
        let refinement = Refinement { level: &self.level, faces: level.topology.faces.clone(), channels };
        let (mut garment, influences) = carry(&self.garment, self.influences.as_deref(), &refinement);
        garment.points = IdVec::filled(Vec3::ZERO, level.topology.vertex_count());
        Self { garment, level, influences }
    }

    /// The same, to be kept.
    pub fn shared_level(&self) -> Arc<Level> {
        Arc::clone(&self.level)
    }

    /// The garment of the cage that an operator makes of it, without primvars.
    ///
    /// `corners` and `creases` of the child become infinitely sharp.
    pub fn frame(&self, lineage: &impl Lineage, corners: &[VertexId], creases: &[[VertexId; 2]]) -> Garment {
        let points = carried_points(&lineage.vertex(), &self.garment.points);
        let mut garment = Carry::new(&self.garment, lineage).frame(points);
        let mut sharp: BTreeSet<VertexId> = garment.corners.iter().map(|c| c.vertex).collect();
        let new = corners.iter().filter(|&&v| sharp.insert(v));
        garment.corners.extend(new.map(|&vertex| Corner { vertex, sharpness: INFINITE_SHARPNESS }));
        let crease = |ends: &[VertexId; 2]| Crease { vertices: ends.to_vec(), sharpnesses: vec![INFINITE_SHARPNESS] };
        garment.creases.extend(creases.iter().map(crease));
        garment
    }

    /// The cage that an operator makes of it, with every attribute: what is in `frame`, whose level is `level`, and the
    /// primvars.
    pub fn derived(&self, lineage: &impl Lineage, frame: Garment, level: Arc<Level>) -> Self {
        let (primvars, influences) = Carry::new(&self.garment, lineage).attributes(self.influences.as_deref());
        let garment = Garment { primvars: primvars.into(), ..frame };
        Self { level, garment, influences }
    }

    /// The garment of the cage refined once, without points, where the faces of its refined level are `faces` and its
    /// channels are `channels`. It is the last step, which needs no more connectivity of what it makes.
    pub fn refined_garment(&self, faces: Faces, channels: &Channels) -> Garment {
        let refinement = Refinement { level: &self.level, faces, channels };
        let (garment, influences) = carry(&self.garment, self.influences.as_deref(), &refinement);
        Self::completed(garment, influences.as_deref())
    }

    /// The garment, with its influences pruned and its directions of unit length.
    pub fn into_garment(self) -> Garment {
        Self::completed(self.garment, self.influences.as_deref())
    }

    fn completed(mut garment: Garment, influences: Option<&[Influences]>) -> Garment {
        garment.primvars.iter_mut().for_each(to_unit_length);
        let carried = match (joints::pair(&garment), influences) {
            (Some((indices, weights)), Some(influences)) => joints::to_primvars(influences, indices, weights),
            _ => return garment,
        };
        for primvar in carried {
            if let Some(slot) = garment.primvars.iter_mut().find(|p| p.name == primvar.name) {
                *slot = primvar;
            }
        }
        garment
    }
}
