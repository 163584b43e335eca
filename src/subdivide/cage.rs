//! A garment on its way through refinements and operators.

use super::carry::{Carry, Lineage, carried_points, carry, to_unit_length};
use super::channels::Channels;
use super::connectivity::{Fingerprint, Hasher};
use super::stencil::Stencils;
use super::{INFINITE_SHARPNESS, Level, Numbering, refined_sharpness};
use crate::garment::joints::{self, Influences};
use crate::garment::{Corner, Crease, Elements, Garment, Primvar, Scheme, Subset};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use glam::Vec3;
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a cage is once it is refined. Its points are not made.
pub struct Refinement<'a> {
    cage: &'a Cage,
    faces: Faces,
    channels: &'a Channels,
}

impl Refinement<'_> {
    /// Its subsets. They are the same for each cage with the same connectivity and subsets.
    pub fn subsets(&self) -> Arc<Vec<Subset>> {
        Carry::new(&self.cage.garment, self).subsets()
    }

    /// It as a cage with these subsets, whose level is `level`. Its points are zero.
    pub fn cage(&self, level: Arc<Level>, subsets: Arc<Vec<Subset>>) -> Cage {
        let (mut garment, influences) = self.carried(subsets);
        garment.points = IdVec::filled(Vec3::ZERO, level.topology.vertex_count());
        Cage { garment, level, influences }
    }

    /// Its garment with these subsets, without points, as the last step: that needs no more connectivity.
    pub fn garment(&self, subsets: Arc<Vec<Subset>>) -> Garment {
        let (garment, influences) = self.carried(subsets);
        Cage::completed(garment, influences.as_deref())
    }

    fn carried(&self, subsets: Arc<Vec<Subset>>) -> (Garment, Option<Vec<Influences>>) {
        carry(&self.cage.garment, self.cage.influences.as_deref(), self, subsets)
    }

    fn numbering(&self) -> Numbering {
        Numbering::new(&self.cage.level)
    }

    fn is_loop(&self) -> bool {
        self.cage.level.scheme == Scheme::Loop
    }
}

impl Lineage for Refinement<'_> {
    const EDGES_ARE_OWN: bool = true;

    fn parent(&self) -> &Topology {
        &self.cage.level.topology
    }

    fn faces(&self) -> &Faces {
        &self.faces
    }

    #[inline]
    fn parent_face(&self, child: FaceId) -> FaceId {
        self.numbering().parent_face(&self.cage.level.topology.faces, child)
    }

    #[inline]
    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId> {
        self.numbering().of_face_within(&self.cage.level.topology.faces, parent)
    }

    #[inline]
    fn parent_corner(&self, corner: CornerId) -> CornerId {
        let child = self.faces.face_of(corner);
        if !self.is_loop() {
            // A child quad belongs to one corner of its parent.
            return CornerId::new(child.index());
        }
        let (parent, step) = (self.cage.level.topology.faces.range(self.parent_face(child)).start, child.index() % 4);
        CornerId::new(parent + if step < 3 { step } else { corner.index() % 3 })
    }

    fn child_vertex(&self, vertex: VertexId) -> VertexId {
        self.numbering().of_vertex(vertex)
    }

    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>) {
        let numbering = self.numbering();
        let ([a, b], middle) = (self.cage.level.topology.edges[edge], numbering.of_edge(edge));
        children.extend([[numbering.of_vertex(a), middle], [middle, numbering.of_vertex(b)]]);
    }

    fn remaining(&self, sharpness: f32) -> f32 {
        refined_sharpness(sharpness)
    }

    fn vertex(&self) -> impl Stencils<Source = VertexId> {
        self.cage.level.vertex_stencils()
    }

    fn varying(&self) -> impl Stencils<Source = VertexId> {
        self.cage.level.varying_stencils()
    }

    fn face_varying(&self, garment: &Garment, place: usize) -> Primvar {
        self.channels.refined_primvar(&self.cage.level, place, &garment.primvars[place])
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

    /// The same, to be kept.
    pub fn shared_level(&self) -> Arc<Level> {
        Arc::clone(&self.level)
    }

    /// The cage refined once, where the faces of its refined level are `faces` and its channels are `channels`.
    pub fn refinement<'a>(&'a self, faces: Faces, channels: &'a Channels) -> Refinement<'a> {
        Refinement { cage: self, faces, channels }
    }

    /// The fingerprint of its subsets.
    pub fn subsets_fingerprint(&self) -> Fingerprint {
        let mut hasher = Hasher::default();
        for Subset { name, family, elements, sharpness } in self.garment.subsets.iter() {
            hasher.add((name, family, elements.kind(), sharpness.map(f32::to_bits)));
            match elements {
                Elements::Faces(faces) => hasher.add_all(faces),
                Elements::Edges(edges) => hasher.add_all(edges.as_flattened()),
                Elements::Points(points) => hasher.add_all(points),
            }
        }
        hasher.finish()
    }

    /// The garment of the cage that an operator makes of it, without primvars.
    ///
    /// `corners` and `creases` of the child become infinitely sharp.
    pub fn frame(&self, lineage: &impl Lineage, corners: &[VertexId], creases: &[[VertexId; 2]]) -> Garment {
        let points = carried_points(&lineage.vertex(), &self.garment.points);
        let carry = Carry::new(&self.garment, lineage);
        let mut garment = carry.frame(points, carry.subsets());
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

    /// The garment, with its influences pruned and its directions of unit length.
    pub fn into_garment(self) -> Garment {
        Self::completed(self.garment, self.influences.as_deref())
    }

    fn completed(mut garment: Garment, influences: Option<&[Influences]>) -> Garment {
        Arc::make_mut(&mut garment.primvars).iter_mut().for_each(to_unit_length);
        let carried = match (joints::pair(&garment), influences) {
            (Some((indices, weights)), Some(influences)) => joints::to_primvars(influences, indices, weights),
            _ => return garment,
        };
        for primvar in carried {
            if let Some(slot) = Arc::make_mut(&mut garment.primvars).iter_mut().find(|p| p.name == primvar.name) {
                *slot = primvar;
            }
        }
        garment
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fingerprint_is_that_of_all_subsets() {
        let set = |elements: Elements| Subset {
            name: "front".to_owned(),
            family: "panels".to_owned(),
            elements,
            sharpness: None,
        };
        let first = set(Elements::Faces(vec![FaceId::new(1), FaceId::new(2)]));
        let points = set(Elements::Points(vec![VertexId::new(1), VertexId::new(2)]));
        let edge = set(Elements::Edges(vec![[1, 2].map(VertexId::new)]));
        let others = [
            vec![],
            vec![set(Elements::Faces(vec![FaceId::new(2), FaceId::new(1)]))],
            vec![edge.clone()],
            vec![Subset { sharpness: Some(2.0), ..edge }],
            vec![points],
            vec![Subset { name: "back".to_owned(), ..first.clone() }],
            vec![Subset { family: String::new(), ..first.clone() }],
            vec![first.clone(), first.clone()],
        ];
        let of = |subsets: Vec<Subset>, points: usize| {
            let points = IdVec::filled(Vec3::ZERO, points);
            Cage::new(Garment { subsets: subsets.into(), points, ..Garment::default() }).subsets_fingerprint()
        };
        let known = of(vec![first.clone()], 0);
        assert_eq!(of(vec![first], 3), known, "points do not matter");
        let mut all: Vec<Fingerprint> = others.map(|subsets| of(subsets, 0)).into_iter().chain([known]).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 9);
    }
}
