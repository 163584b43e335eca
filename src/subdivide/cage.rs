//! A garment on its way through refinements and operators.

use super::carry::{Carry, Lineage, carried_points, carry, is_channel, mixed_channel, to_unit_length};
use super::stencil::Stencils;
use super::{Channel, ChannelChild, INFINITE_SHARPNESS, Level, Numbering, refined_sharpness};
use crate::garment::joints::{self, Influences};
use crate::garment::{Corner, Crease, Garment, Primvar, Scheme};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::{Arc, OnceLock};

/// A refinement as a lineage.
pub struct Refinement<'a> {
    level: &'a Level,
    faces: Faces,
    /// The channel of each primvar that has one.
    channels: Vec<Option<RefinedChannel<'a>>>,
}

/// A channel's refinement, and the rows of the parent's values where they are in another order.
struct RefinedChannel<'a> {
    child: ChannelChild<'a>,
    rows: Option<&'a [u32]>,
}

impl<'a> Refinement<'a> {
    fn new(level: &'a Level, faces: Faces, channels: &'a [Option<PrimvarChannel>]) -> Self {
        let refined = |c: &'a PrimvarChannel| RefinedChannel {
            child: ChannelChild::new(level, &c.channel),
            rows: c.rows.as_deref(),
        };
        Self { level, faces, channels: channels.par_iter().map(|c| c.as_ref().map(refined)).collect() }
    }

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
        let primvar = &garment.primvars[place];
        match &self.channels[place] {
            Some(channel) => mixed_channel(&channel.child, channel.child.indices(), channel.rows, primvar),
            None => primvar.clone(),
        }
    }
}

/// The channel of a face-varying primvar.
#[derive(Clone)]
struct PrimvarChannel {
    channel: Channel,
    /// The row of each value, where they are not the primvar's rows in their order.
    rows: Option<Vec<u32>>,
}

impl PrimvarChannel {
    fn new(garment: &Garment, level: &Level, primvar: &Primvar) -> Self {
        let rows = primvar.corner_rows(&garment.faces, garment.points.len());
        let rules = garment.rules;
        let (channel, rows) = Channel::base(level, |c| rows[c] as usize, rules.face_varying, rules.boundary);
        Self { channel, rows: Some(rows) }
    }
}

/// A garment on its way through derivations. Its joint influences are kept whole until the end, so that they are pruned
/// to `elementSize` only once.
#[derive(Clone)]
pub struct Cage {
    garment: Garment,
    level: Arc<Level>,
    influences: Option<Vec<Influences>>,
    /// The channel of each primvar that has one, once they are needed.
    channels: OnceLock<Vec<Option<PrimvarChannel>>>,
}

impl Cage {
    /// The cage of a garment.
    pub fn new(garment: Garment) -> Self {
        let influences = joints::pair(&garment).map(|(indices, weights)| joints::influences(indices, weights));
        Self { level: Arc::new(Level::base(&garment)), garment, influences, channels: OnceLock::new() }
    }

    fn channels(&self) -> &[Option<PrimvarChannel>] {
        let channel = |p: &Primvar| is_channel(p).then(|| PrimvarChannel::new(&self.garment, &self.level, p));
        self.channels.get_or_init(|| self.garment.primvars.iter().map(channel).collect())
    }

    /// The garment as it is so far: its skinning and its directions are not yet what [`Cage::into_garment`] gives.
    pub fn garment(&self) -> &Garment {
        &self.garment
    }

    /// The cage's connectivity and rules.
    pub fn level(&self) -> &Level {
        &self.level
    }

    /// The cage refined once, with every attribute, where its level refined is `level`. Its points are not: they are zero.
    pub fn refined(&self, level: Arc<Level>) -> Self {
        let refinement = Refinement::new(&self.level, level.topology.faces.clone(), self.channels());
        let (mut garment, influences) = carry(&self.garment, self.influences.as_deref(), &refinement);
        garment.points = IdVec::filled(Vec3::ZERO, level.topology.vertex_count());
        // Values of a refined channel are in the order of the primvar's rows.
        let channel = |c: RefinedChannel| PrimvarChannel { channel: c.child.into_channel(&level), rows: None };
        let channels: Vec<_> = refinement.channels.into_par_iter().map(|c| c.map(channel)).collect();
        Self { garment, level, influences, channels: channels.into() }
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
        Self { level, garment, influences, channels: OnceLock::new() }
    }

    /// The garment of the cage refined once, without points, where the faces of its refined level are `faces`. It is the
    /// last step, which needs no more connectivity of what it makes.
    pub fn refined_garment(&self, faces: Faces) -> Garment {
        let refinement = Refinement::new(&self.level, faces, self.channels());
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
