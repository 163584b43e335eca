//! One refinement step of a level with its face-varying channels, as a [`Derivation`].

use super::carry::{Derivation, blended_channel, is_channel};
use super::fvar::ChildValues;
use super::stencil::Stencils;
use super::{Channel, ChannelChild, Level, Numbering, refined_sharpness};
use crate::connectivity::{CornerId, EdgeId, FaceId, Faces, Topology, VertexId};
use crate::garment::{Mesh, Primvar, Scheme};
use crate::meter;
use rayon::prelude::*;
use std::sync::Arc;

/// Memory of a refinement for each of its faces and channels, with a level of two. \[bytes\]
const FACE: usize = 80;

/// The refinement of a level with its face-varying channels.
///
/// It depends only on connectivity and on the corners that share a value. Garments that differ in points or values
/// share it (see [`share_values_alike`]).
pub struct Refinement {
    level: Arc<Level>,
    faces: Faces,
    numbering: Numbering,
    channels: Vec<ChannelRefinement>,
}

/// The refinement of one face-varying channel.
struct ChannelRefinement {
    channel: Channel,
    /// The primvar's row of each value; `None` if values and rows have the same order.
    rows: Option<Vec<u32>>,
    children: Arc<ChildValues>,
    /// The value of each child corner.
    indices: Arc<Vec<u32>>,
}

impl Refinement {
    /// The refinement of a garment's cage, whose level is `level`.
    pub fn of_cage(level: Arc<Level>, garment: &Mesh) -> Self {
        let channel = |primvar: &Primvar| {
            let rows = primvar.corner_rows(&garment.faces, garment.points.len());
            let rules = garment.rules;
            let (channel, rows) = Channel::base(&level, |c| rows[c] as usize, rules.face_varying, rules.boundary);
            ChannelRefinement::new(&level, channel, Some(rows))
        };
        let channels = garment.primvars.par_iter().filter(|primvar| is_channel(primvar)).map(channel).collect();
        Self::new(level, channels)
    }

    fn new(level: Arc<Level>, channels: Vec<ChannelRefinement>) -> Self {
        Self { faces: level.refined_faces(), numbering: Numbering::new(&level), level, channels }
    }

    /// The refinement of the next finer level.
    #[must_use]
    pub fn next(&self) -> Self {
        meter::check_for(FACE * self.faces.len() * (2 + self.channels.len()));
        let refined = Arc::new(self.level.refined());
        // Values of a refined channel are in the order of the primvar's rows.
        let next =
            |c: &ChannelRefinement| ChannelRefinement::new(&refined, c.child(&self.level).into_channel(&refined), None);
        let channels = self.channels.par_iter().map(next).collect();
        Self::new(refined, channels)
    }

    /// The level that is refined.
    pub fn level(&self) -> &Level {
        &self.level
    }

    /// Estimated memory without the level. \[bytes\]
    pub fn bytes(&self) -> usize {
        4 * self.faces.corners().len() + self.channels.iter().map(ChannelRefinement::bytes).sum::<usize>()
    }
}

impl ChannelRefinement {
    fn new(level: &Level, channel: Channel, rows: Option<Vec<u32>>) -> Self {
        let children = Arc::new(ChildValues::new(&channel, level));
        let indices = ChannelChild::of(level, &channel, Arc::clone(&children)).indices();
        Self { channel, rows, children, indices: Arc::new(indices) }
    }

    fn child<'a>(&'a self, level: &'a Level) -> ChannelChild<'a> {
        ChannelChild::of(level, &self.channel, Arc::clone(&self.children))
    }

    fn bytes(&self) -> usize {
        let rows = self.rows.as_ref().map_or(0, |rows| size_of_val(rows.as_slice()));
        self.channel.bytes() + self.children.bytes() + rows + size_of_val(self.indices.as_slice())
    }
}

/// `true` if one refinement fits both garments: in each face-varying primvar, the same corners share a value.
pub fn share_values_alike(a: &Mesh, b: &Mesh) -> bool {
    let alike = |p: &Primvar, q: &Primvar| match (&p.indices, &q.indices) {
        _ if !is_channel(p) || !is_channel(q) => is_channel(p) == is_channel(q),
        (Some(p), Some(q)) => p == q,
        _ => p.corner_rows(&a.faces, a.points.len()) == q.corner_rows(&b.faces, b.points.len()),
    };
    a.rules.face_varying == b.rules.face_varying
        && a.primvars.len() == b.primvars.len()
        && a.primvars.iter().zip(b.primvars.iter()).all(|(p, q)| alike(p, q))
}

impl Derivation for Refinement {
    const EDGES_ARE_OWN: bool = true;

    fn parent(&self) -> &Topology {
        &self.level.topology
    }

    fn faces(&self) -> &Faces {
        &self.faces
    }

    #[inline]
    fn parent_face(&self, child: FaceId) -> FaceId {
        self.numbering.parent_face(&self.level.topology.faces, child)
    }

    #[inline]
    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId> {
        self.numbering.of_face_within(&self.level.topology.faces, parent)
    }

    #[inline]
    fn parent_corner(&self, corner: CornerId) -> CornerId {
        let child = self.faces.face_of(corner);
        if self.level.scheme != Scheme::Loop {
            // A child quad belongs to one corner of its parent.
            return CornerId::new(child.index());
        }
        let (parent, step) = (self.level.topology.faces.range(self.parent_face(child)).start, child.index() % 4);
        CornerId::new(parent + if step < 3 { step } else { corner.index() % 3 })
    }

    fn child_vertex(&self, vertex: VertexId) -> VertexId {
        self.numbering.of_vertex(vertex)
    }

    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>) {
        let ([a, b], middle) = (self.level.topology.edges[edge], self.numbering.of_edge(edge));
        children.extend([[self.numbering.of_vertex(a), middle], [middle, self.numbering.of_vertex(b)]]);
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

    fn face_varying(&self, garment: &Mesh, index: usize) -> Primvar {
        let number = garment.primvars[..index].iter().filter(|primvar| is_channel(primvar)).count();
        let c = &self.channels[number];
        blended_channel(&c.child(&self.level), Arc::clone(&c.indices), c.rows.as_deref(), &garment.primvars[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connectivity::IdVec;
    use crate::garment::{FaceVaryingInterpolation, Values};
    use crate::subdivide::Carrier;
    use glam::Vec3;

    /// Two quads side by side, with a value for each corner.
    fn garment(indices: Option<Vec<u32>>, values: Vec<f32>) -> Mesh {
        Mesh {
            points: IdVec::filled(Vec3::ZERO, 6),
            faces: Faces::quads([0, 1, 4, 3, 1, 2, 5, 4].map(VertexId::new).to_vec()),
            primvars: vec![Primvar::of_corners(values, indices)].into(),
            ..Mesh::default()
        }
    }

    #[test]
    fn cages_whose_corners_share_values_alike_are_known() {
        let joined = || Some(vec![0, 1, 2, 3, 1, 4, 5, 2]);
        let first = garment(joined(), vec![0.0; 6]);
        assert!(share_values_alike(&first, &garment(joined(), (0..6).map(|i| i as f32).collect())), "other values");
        let mut linear = garment(joined(), vec![0.0; 6]);
        linear.rules.face_varying = FaceVaryingInterpolation::All;
        let mut without = garment(joined(), vec![0.0; 6]);
        without.primvars = Vec::new().into();
        let apart = garment(Some((0..8).collect()), vec![0.0; 8]);
        for other in [&linear, &without, &apart] {
            assert!(!share_values_alike(&first, other));
        }
        let flat = garment(None, (0..8).map(|i| i as f32).collect());
        assert!(share_values_alike(&apart, &flat), "no corners share a value");
        let joined_flat = garment(None, vec![0.0, 1.0, 2.0, 3.0, 1.0, 4.0, 5.0, 2.0]);
        assert!(!share_values_alike(&flat, &joined_flat));
    }

    #[test]
    fn cages_with_other_values_share_a_refinement() {
        let indices = || Some(vec![0, 1, 2, 3, 6, 4, 5, 7]);
        let cages = [1.0, 2.0].map(|scale| garment(indices(), (0..8).map(|i| scale * i as f32).collect()));
        let refinement = |cage: &Mesh| Refinement::of_cage(Arc::new(Level::base(cage)), cage);
        let shared = refinement(&cages[0]);
        let refined = |cage: &Mesh, by: &Refinement| Carrier::new(cage, by).primvars()[0].clone();
        let [own, other] = cages.each_ref().map(|cage| refined(cage, &shared));
        assert!(Arc::ptr_eq(own.indices.as_ref().expect("indices"), other.indices.as_ref().expect("indices")));
        let doubled = match &own.values {
            Values::F32(values) => values.iter().map(|value| 2.0 * value).collect::<Vec<_>>(),
            _ => Vec::new(),
        };
        assert_eq!(Values::F32(doubled), other.values);
        assert_eq!(refined(&cages[1], &refinement(&cages[1])), other);
    }
}
