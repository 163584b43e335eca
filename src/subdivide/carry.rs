//! A garment with all its attributes through one derivation.

use super::stencil::Stencils;
use crate::garment::joints::{self, Influences};
use crate::garment::{
    Corner, Crease, Elements, Family, FamilyType, Garment, Interpolation, Mixing, Primvar, Subset, Values,
};
use crate::mesh::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, ValueId, VertexId};
use crate::parallel::when_idle;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Vertices whose influences are found in one go.
const BLOCK: usize = 512;

/// Where each element of a child mesh comes from. All that is attached to a mesh is carried by this alone, whether the
/// child is a refinement or what an operator made.
pub trait Lineage: Sync {
    /// Whether no child edge comes from two parent edges.
    const EDGES_ARE_OWN: bool;

    /// The parent's connectivity.
    fn parent(&self) -> &Topology;
    /// The child's faces.
    fn faces(&self) -> &Faces;
    /// The face that a child face is part of.
    fn parent_face(&self, child: FaceId) -> FaceId;
    /// The parts of a face.
    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId>;
    /// The corner that a child corner takes discrete values from.
    fn parent_corner(&self, child: CornerId) -> CornerId;
    /// The child that takes the place of a vertex.
    fn child_vertex(&self, vertex: VertexId) -> VertexId;
    /// Adds the children of an edge, each step a pair, in the direction in which the parent's topology has it.
    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>);
    /// What is left of a sharpness.
    fn remaining(&self, sharpness: f32) -> f32;
    /// Child vertices from parent vertices.
    fn vertex(&self) -> impl Stencils<Source = VertexId>;
    /// Child vertices from parent vertices, linearly.
    fn varying(&self) -> impl Stencils<Source = VertexId>;
    /// A face-varying primvar whose values are mixed, by its place among the garment's. Values of different regions do
    /// not mix.
    fn face_varying(&self, garment: &Garment, place: usize) -> Primvar;
}

/// A face-varying primvar from the rows of its parent's values, if they have an order of their own, and the value of
/// each child corner, by its number.
pub fn mixed_channel<S: Stencils<Source = ValueId>>(
    stencils: &S,
    indices: Arc<Vec<u32>>,
    rows: Option<&[u32]>,
    primvar: &Primvar,
) -> Primvar {
    let gathered = rows.map(|rows| primvar.values.gather(primvar.width(), rows.iter().map(|&r| r as usize)));
    let source = gathered.as_ref().unwrap_or(&primvar.values);
    Primvar { values: mixed(stencils, source, primvar), indices: Some(indices), ..primvar.headed() }
}

/// Points through stencils.
pub fn carried_points<S: Stencils<Source = VertexId>>(
    stencils: &S,
    points: &IdVec<VertexId, Vec3>,
) -> IdVec<VertexId, Vec3> {
    let rows: &[[f32; 3]] = bytemuck::cast_slice(points.as_slice());
    stencils.apply(rows).into_iter().map(Vec3::from).collect()
}

/// A garment through a lineage, without points, with the subsets that it has then.
pub(super) fn carry<L: Lineage>(
    garment: &Garment,
    influences: Option<&[Influences]>,
    lineage: &L,
    subsets: Arc<Vec<Subset>>,
) -> (Garment, Option<Vec<Influences>>) {
    let carry = Carry::new(garment, lineage);
    let (primvars, influences) = carry.attributes(influences);
    (Garment { primvars: primvars.into(), ..carry.frame(IdVec::default(), subsets) }, influences)
}

/// Whether a primvar is carried as a face-varying channel.
pub(super) fn is_channel(primvar: &Primvar) -> bool {
    primvar.interpolation == Interpolation::FaceVarying && primvar.is_mixed()
}

/// New edges and vertices inside faces belong to no subset, so a partition of edges or points is none any more.
fn carried_family(garment: &Garment, family: &Family) -> Family {
    let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
    let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
    let kind = match family.kind {
        FamilyType::Partition if !of_faces => FamilyType::NonOverlapping,
        kind => kind,
    };
    Family { name: family.name.clone(), kind }
}

pub(super) struct Carry<'a, L> {
    garment: &'a Garment,
    lineage: &'a L,
}

impl<'a, L: Lineage> Carry<'a, L> {
    pub(super) fn new(garment: &'a Garment, lineage: &'a L) -> Self {
        Self { garment, lineage }
    }

    /// The child's subsets.
    pub(super) fn subsets(&self) -> Arc<Vec<Subset>> {
        self.garment.subsets.iter().map(|s| self.subset(s)).collect::<Vec<_>>().into()
    }

    /// The child without its primvars.
    pub(super) fn frame(&self, points: IdVec<VertexId, Vec3>, subsets: Arc<Vec<Subset>>) -> Garment {
        let garment = self.garment;
        Garment {
            prim: garment.prim.clone(),
            points,
            orientation: garment.orientation,
            rules: garment.rules,
            holes: self.faces(&garment.holes),
            creases: garment.creases.iter().flat_map(|c| self.crease(c)).collect(),
            corners: garment.corners.iter().filter_map(|c| self.corner(c)).collect(),
            subsets,
            families: garment.families.iter().map(|f| carried_family(garment, f)).collect(),
            primvars: Vec::new().into(),
            faces: self.lineage.faces().clone(),
        }
    }

    /// The child's primvars, and joint influences.
    pub(super) fn attributes(&self, influences: Option<&[Influences]>) -> (Vec<Primvar>, Option<Vec<Influences>>) {
        let primvars = &self.garment.primvars;
        let carried = |place: usize| match &primvars[place] {
            p if is_channel(p) => self.lineage.face_varying(self.garment, place),
            p if joints::is_influence(self.garment, p) => p.clone(),
            p => self.primvar(p),
        };
        let mut all: Vec<Primvar> = primvars.iter().map(Primvar::headed).collect();
        // All threads share in each that is mixed.
        let places = all.iter_mut().enumerate();
        let (mixed, others): (Vec<_>, Vec<_>) = places.partition(|(place, _)| primvars[*place].is_mixed());
        when_idle(others.into_iter(), |(place, child)| *child = carried(place));
        mixed.into_iter().for_each(|(place, child)| *child = carried(place));
        (all, influences.map(|all| self.influences(all)))
    }

    fn faces(&self, parents: &[FaceId]) -> Vec<FaceId> {
        let mut children = Vec::with_capacity(4 * parents.len());
        parents.iter().for_each(|&f| children.extend(self.lineage.child_faces(f)));
        children
    }

    /// The children of an edge, in its direction.
    fn edges(&self, [a, b]: [VertexId; 2]) -> Vec<[VertexId; 2]> {
        let (mut children, topology) = (Vec::new(), self.lineage.parent());
        if let Some(edge) = topology.find_edge(a, b) {
            self.lineage.child_edges(edge, &mut children);
            if topology.edges[edge][0] != a {
                children.reverse();
                children.iter_mut().for_each(|pair| pair.reverse());
            }
        }
        children
    }

    fn subset(&self, subset: &Subset) -> Subset {
        let elements = match &subset.elements {
            Elements::Faces(faces) => Elements::Faces(self.faces(faces)),
            Elements::Edges(edges) => {
                let mut children: Vec<_> = edges.iter().flat_map(|&e| self.edges(e)).collect();
                if !L::EDGES_ARE_OWN {
                    let mut known = BTreeSet::new();
                    children.retain(|&[a, b]| known.insert([a.min(b), a.max(b)]));
                }
                Elements::Edges(children)
            }
            Elements::Points(points) => {
                Elements::Points(points.iter().map(|&v| self.lineage.child_vertex(v)).collect())
            }
        };
        Subset { elements, ..subset.clone() }
    }

    /// The children of a crease: one, or parts where they are apart or the sharpness ends within.
    fn crease(&self, crease: &Crease) -> Vec<Crease> {
        let mut parts: Vec<Crease> = Vec::new();
        for (pair, &sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            let left = self.lineage.remaining(sharpness);
            let children = if left > 0.0 { self.edges([pair[0], pair[1]]) } else { Vec::new() };
            for [a, b] in children {
                match parts.last_mut() {
                    Some(part) if part.vertices.last() == Some(&a) => part.vertices.push(b),
                    _ => parts.push(Crease { vertices: vec![a, b], sharpnesses: Vec::new() }),
                }
                if let Some(part) = parts.last_mut() {
                    part.sharpnesses.push(left);
                }
            }
        }
        parts
    }

    fn corner(&self, corner: &Corner) -> Option<Corner> {
        let sharpness = self.lineage.remaining(corner.sharpness);
        (sharpness > 0.0).then(|| Corner { vertex: self.lineage.child_vertex(corner.vertex), sharpness })
    }

    fn primvar(&self, primvar: &Primvar) -> Primvar {
        let corners = || self.lineage.faces().corners().ids().map(|c| self.lineage.parent_corner(c).index());
        match primvar.interpolation {
            Interpolation::Constant => primvar.clone(),
            Interpolation::Uniform => {
                let faces = 0..self.lineage.faces().len();
                taken(primvar, faces.map(|f| self.lineage.parent_face(FaceId::new(f)).index()))
            }
            Interpolation::FaceVarying => taken(primvar, corners()),
            Interpolation::Vertex => self.by_vertex(primvar, &self.lineage.vertex()),
            Interpolation::Varying => self.by_vertex(primvar, &self.lineage.varying()),
        }
    }

    fn by_vertex<S: Stencils<Source = VertexId>>(&self, primvar: &Primvar, stencils: &S) -> Primvar {
        if !primvar.is_mixed() {
            let sources = (0..stencils.rows()).into_par_iter();
            let sources: Vec<usize> = sources.map(|r| stencils.heaviest(r).map_or(0, |v| v.index())).collect();
            return taken(primvar, sources.into_iter());
        }
        let rows = (0..self.garment.points.len()).map(|v| primvar.row(v));
        let source = primvar.values.gather(primvar.width(), rows);
        Primvar { values: mixed(stencils, &source, primvar), indices: None, ..primvar.headed() }
    }

    /// The influences of the child's vertices, merged by joint.
    fn influences(&self, all: &[Influences]) -> Vec<Influences> {
        let stencils = self.lineage.vertex();
        let row = |r: usize| joints::blend(stencils.merged(r).iter().map(|&(v, w)| (&all[v.index()], w)));
        let mut children = vec![Influences::new(); stencils.rows()];
        when_idle(children.chunks_mut(BLOCK).enumerate(), |(block, children)| {
            children.iter_mut().zip(BLOCK * block..).for_each(|(child, r)| *child = row(r));
        });
        children
    }
}

/// The values of the given elements, as they are; indexed primvars stay indexed.
pub fn taken(primvar: &Primvar, elements: impl Iterator<Item = usize> + Clone) -> Primvar {
    match &primvar.indices {
        Some(indices) => Primvar {
            indices: Some(Arc::new(elements.map(|e| indices[e]).collect())),
            values: primvar.values.clone(),
            ..primvar.headed()
        },
        None => Primvar { values: primvar.values.gather(primvar.width(), elements), ..primvar.headed() },
    }
}

/// Real values through stencils, by the primvar's way of mixing.
fn mixed<S: Stencils>(stencils: &S, source: &Values, primvar: &Primvar) -> Values {
    match source {
        Values::F32(v) => Values::F32(mix_rows(stencils, v, primvar)),
        Values::F64(v) => Values::F64(mix_rows(stencils, v, primvar)),
        // Only real values are mixed.
        discrete => discrete.clone(),
    }
}

/// Child rows of a primvar from parent rows, by its way of mixing.
pub fn mix_rows<S: Stencils, T: super::Real>(stencils: &S, source: &[T], primvar: &Primvar) -> Vec<T> {
    let width = primvar.width();
    if primvar.mixing != Mixing::Rotation {
        return stencils.apply_rows(source, width);
    }
    let mut children = vec![T::from_f64(0.0); stencils.rows() * width];
    children.par_chunks_mut(width.max(1)).enumerate().for_each(|(r, child)| {
        let parts = stencils.merged(r);
        let row = |&(s, w): &(S::Source, f32)| (&source[crate::mesh::Id::index(s) * width..][..width], w);
        mix_into(&parts.iter().map(row), primvar, child);
    });
    children
}

/// The mean of rows of a primvar with their weights, by its way of mixing; directions are not yet of unit length.
pub fn mix_into<'a, T: super::Real + 'a>(
    rows: &(impl Iterator<Item = (&'a [T], f32)> + Clone),
    primvar: &Primvar,
    mean: &mut [T],
) {
    // The heaviest row decides the hemisphere of quaternions, which stand for the same rotation with either sign.
    let heavier = |best: (&'a [T], f32), row: (&'a [T], f32)| if best.1 >= row.1 { best } else { row };
    let heaviest = rows.clone().filter(|_| primvar.mixing == Mixing::Rotation).reduce(heavier);
    for (k, value) in mean.iter_mut().enumerate() {
        let own = k - k % primvar.components..;
        let is_opposite = |row: &[T], heaviest: &[T]| {
            let parts = row[own.clone()].iter().zip(&heaviest[own.clone()]).take(primvar.components);
            parts.map(|(a, b)| a.to_f64() * b.to_f64()).sum::<f64>() < 0.0
        };
        let part = |(row, weight): (&[T], f32)| f64::from(weight) * row[k].to_f64();
        let turned = |row: (&[T], f32), heaviest| if is_opposite(row.0, heaviest) { -part(row) } else { part(row) };
        *value = T::from_f64(match heaviest {
            None => rows.clone().fold(0.0, |sum, row| sum + part(row)),
            Some((heaviest, _)) => rows.clone().fold(0.0, |sum, row| sum + turned(row, heaviest)),
        });
    }
}

/// Scales the values of a primvar of directions or rotations to unit length, once all mixing is done. Uniform ones are
/// taken as they are.
pub fn to_unit_length(primvar: &mut Primvar) {
    if matches!(primvar.interpolation, Interpolation::Constant | Interpolation::Uniform) {
        return;
    }
    let (components, mixing) = (primvar.components, primvar.mixing);
    match &mut primvar.values {
        Values::F32(v) => scale_to_unit_length(v, components, mixing),
        Values::F64(v) => scale_to_unit_length(v, components, mixing),
        _ => {}
    }
}

/// The same for values of `components` numbers that were mixed by `mixing`.
pub fn scale_to_unit_length<T: super::Real>(values: &mut [T], components: usize, mixing: Mixing) {
    if !matches!(mixing, Mixing::Direction | Mixing::Rotation) {
        return;
    }
    for value in values.chunks_mut(components) {
        let length = value.iter().map(|x| x.to_f64() * x.to_f64()).sum::<f64>().sqrt();
        if length > 0.0 {
            value.iter_mut().for_each(|x| *x = T::from_f64(x.to_f64() / length));
        }
    }
}
