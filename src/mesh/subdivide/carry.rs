//! Carries all attributes of a garment to a mesh derived from it.
//!
//! A [`Derivation`] describes the child mesh: its faces, the parent of each element, and stencils for each kind of
//! value. The [`Carrier`] needs nothing else, so refinements and render operators share it.

use super::stencil::Stencils;
use crate::connectivity::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, ValueId, VertexId};
use crate::garment::joints::{self, Influences};
use crate::garment::{
    Corner, Crease, Elements, Family, FamilyType, Interpolation, Mesh, Mixing, Primvar, Subset, Values,
};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// The origin of each element of a child mesh, as refinements and operators report it.
pub trait Derivation: Sync {
    /// `true` if each child edge comes from at most one parent edge.
    const EDGES_ARE_OWN: bool;

    /// The parent's connectivity.
    fn parent(&self) -> &Topology;
    /// The child's faces.
    fn faces(&self) -> &Faces;
    /// The parent of a child face.
    fn parent_face(&self, child: FaceId) -> FaceId;
    /// The children of a face.
    fn child_faces(&self, parent: FaceId) -> impl Iterator<Item = FaceId>;
    /// The corner that a child corner takes discrete values from.
    fn parent_corner(&self, child: CornerId) -> CornerId;
    /// The child at a vertex.
    fn child_vertex(&self, vertex: VertexId) -> VertexId;
    /// Appends the children of an edge as vertex pairs, in the direction of the parent's edge.
    fn child_edges(&self, edge: EdgeId, children: &mut Vec<[VertexId; 2]>);
    /// The sharpness of a child edge or vertex, from that of its parent.
    fn remaining(&self, sharpness: f32) -> f32;
    /// Stencils of `vertex` primvars.
    fn vertex(&self) -> impl Stencils<Source = VertexId>;
    /// Stencils of `varying` primvars, which are linear.
    fn varying(&self) -> impl Stencils<Source = VertexId>;
    /// The child of the face-varying primvar `garment.primvars[index]`, each region blended by itself.
    fn face_varying(&self, garment: &Mesh, index: usize) -> Primvar;
}

/// The child of a face-varying primvar.
///
/// `indices` holds the value of each child corner. `rows` holds the primvar's row for each parent value; without it,
/// the two have the same order.
pub fn blended_channel<S: Stencils<Source = ValueId>>(
    stencils: &S,
    indices: Arc<Vec<u32>>,
    rows: Option<&[u32]>,
    primvar: &Primvar,
) -> Primvar {
    let reordered = rows.map(|rows| primvar.values.gather(primvar.width(), rows.iter().map(|&r| r as usize)));
    let source = reordered.as_ref().unwrap_or(&primvar.values);
    Primvar { values: blend_values(stencils, source, primvar), indices: Some(indices), ..primvar.headed() }
}

/// The child points. \[mesh units\]
pub fn carried_points<S: Stencils<Source = VertexId>>(
    stencils: &S,
    points: &IdVec<VertexId, Vec3>,
) -> IdVec<VertexId, Vec3> {
    let rows: &[[f32; 3]] = bytemuck::cast_slice(points.as_slice());
    stencils.apply(rows).into_iter().map(Vec3::from).collect()
}

/// `true` if a primvar is carried as a face-varying channel.
pub(super) fn is_channel(primvar: &Primvar) -> bool {
    primvar.interpolation == Interpolation::FaceVarying && primvar.is_mixed()
}

/// A family after refinement. New edges and vertices inside faces belong to no subset, so a partition of edges or
/// points becomes a non-overlapping family.
fn carried_family(garment: &Mesh, family: &Family) -> Family {
    let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
    let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
    let kind = match family.kind {
        FamilyType::Partition if !of_faces => FamilyType::NonOverlapping,
        kind => kind,
    };
    Family { name: family.name.clone(), kind }
}

/// Carries the attributes of a garment through a derivation.
pub struct Carrier<'a, D> {
    garment: &'a Mesh,
    derivation: &'a D,
}

impl<'a, D: Derivation> Carrier<'a, D> {
    /// A carrier for `garment`, the parent of `derivation`.
    pub fn new(garment: &'a Mesh, derivation: &'a D) -> Self {
        Self { garment, derivation }
    }

    /// The child's subsets.
    pub fn subsets(&self) -> Arc<Vec<Subset>> {
        Arc::new(self.garment.subsets.iter().map(|s| self.subset(s)).collect())
    }

    /// The child with `subsets`; points, primvars and influences are still empty.
    pub fn frame(&self, subsets: Arc<Vec<Subset>>) -> Mesh {
        let garment = self.garment;
        Mesh {
            prim: garment.prim.clone(),
            points: IdVec::new(),
            units: garment.units,
            uv_scales: garment.uv_scales.clone(),
            space: garment.space,
            materials: garment.materials.clone(),
            orientation: garment.orientation,
            rules: garment.rules,
            holes: self.faces(&garment.holes),
            creases: garment.creases.iter().flat_map(|c| self.crease(c)).collect(),
            corners: garment.corners.iter().filter_map(|c| self.corner(c)).collect(),
            subsets,
            families: garment.families.iter().map(|f| carried_family(garment, f)).collect(),
            primvars: Vec::new().into(),
            influences: None,
            left_out: garment.left_out.clone(),
            faces: self.derivation.faces().clone(),
        }
    }

    /// The child's primvars. Primvars of joint influences are copied; [`Carrier::influences`] carries their content.
    pub fn primvars(&self) -> Arc<Vec<Primvar>> {
        let carried = |(index, primvar): (usize, &Primvar)| match primvar {
            p if is_channel(p) => self.derivation.face_varying(self.garment, index),
            p if joints::is_influence(self.garment, p) => p.clone(),
            p => self.primvar(p),
        };
        self.garment.primvars.par_iter().enumerate().map(carried).collect::<Vec<_>>().into()
    }

    /// The joint influences of the child's vertices, summed for each joint.
    pub fn influences(&self) -> Option<Arc<Vec<Influences>>> {
        let all = self.garment.influences.as_ref()?;
        let stencils = self.derivation.vertex();
        let row = |r: usize| joints::blend(stencils.merged(r).iter().map(|&(v, w)| (&all[v.index()], w)));
        Some(Arc::new((0..stencils.rows()).into_par_iter().map(row).collect()))
    }

    fn faces(&self, parents: &[FaceId]) -> Vec<FaceId> {
        let mut children = Vec::with_capacity(4 * parents.len());
        parents.iter().for_each(|&f| children.extend(self.derivation.child_faces(f)));
        children
    }

    /// The children of the edge from `a` to `b`, in that direction; empty without such an edge.
    fn edges(&self, [a, b]: [VertexId; 2]) -> Vec<[VertexId; 2]> {
        let (mut children, topology) = (Vec::new(), self.derivation.parent());
        if let Some(edge) = topology.find_edge(a, b) {
            self.derivation.child_edges(edge, &mut children);
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
                if !D::EDGES_ARE_OWN {
                    let mut known = BTreeSet::new();
                    children.retain(|&[a, b]| known.insert([a.min(b), a.max(b)]));
                }
                Elements::Edges(children)
            }
            Elements::Points(points) => {
                Elements::Points(points.iter().map(|&v| self.derivation.child_vertex(v)).collect())
            }
        };
        Subset { elements, ..subset.clone() }
    }

    /// The children of a crease, split where consecutive edges are apart or have lost their sharpness.
    fn crease(&self, crease: &Crease) -> Vec<Crease> {
        let mut parts: Vec<Crease> = Vec::new();
        for (pair, &sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            let left = self.derivation.remaining(sharpness);
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
        let sharpness = self.derivation.remaining(corner.sharpness);
        (sharpness > 0.0).then(|| Corner { vertex: self.derivation.child_vertex(corner.vertex), sharpness })
    }

    fn primvar(&self, primvar: &Primvar) -> Primvar {
        let corners = || self.derivation.faces().corners().ids().map(|c| self.derivation.parent_corner(c).index());
        match primvar.interpolation {
            Interpolation::Constant => primvar.clone(),
            Interpolation::Uniform => {
                let faces = 0..self.derivation.faces().len();
                gathered(primvar, faces.map(|f| self.derivation.parent_face(FaceId::new(f)).index()))
            }
            Interpolation::FaceVarying => gathered(primvar, corners()),
            Interpolation::Vertex => self.by_vertex(primvar, &self.derivation.vertex()),
            Interpolation::Varying => self.by_vertex(primvar, &self.derivation.varying()),
        }
    }

    fn by_vertex<S: Stencils<Source = VertexId>>(&self, primvar: &Primvar, stencils: &S) -> Primvar {
        if !primvar.is_mixed() {
            let sources = (0..stencils.rows()).into_par_iter();
            let sources: Vec<usize> = sources.map(|r| stencils.heaviest(r).map_or(0, |v| v.index())).collect();
            return gathered(primvar, sources.into_iter());
        }
        let rows = (0..self.derivation.parent().vertex_count()).map(|v| primvar.row(v));
        let source = primvar.values.gather(primvar.width(), rows);
        Primvar { values: blend_values(stencils, &source, primvar), indices: None, ..primvar.headed() }
    }
}

/// A primvar with a copy of the value of each of `elements`, in their order. Indexed primvars stay indexed.
pub fn gathered(primvar: &Primvar, elements: impl Iterator<Item = usize> + Clone) -> Primvar {
    match &primvar.indices {
        Some(indices) => Primvar {
            indices: Some(Arc::new(elements.map(|e| indices[e]).collect())),
            values: primvar.values.clone(),
            ..primvar.headed()
        },
        None => Primvar { values: primvar.values.gather(primvar.width(), elements), ..primvar.headed() },
    }
}

/// [`blend_rows`] for either precision. Callers pass floating-point primvars only.
fn blend_values<S: Stencils>(stencils: &S, source: &Values, primvar: &Primvar) -> Values {
    match source {
        Values::F32(v) => Values::F32(blend_rows(stencils, v, primvar)),
        Values::F64(v) => Values::F64(blend_rows(stencils, v, primvar)),
        discrete => discrete.clone(),
    }
}

/// Child rows of a primvar from the parent rows `source`, row by row of `primvar.width()` numbers.
///
/// Rotations are summed in one hemisphere (see [`blend_into`]); all else is a plain weighted sum.
pub fn blend_rows<S: Stencils, T: super::Real>(stencils: &S, source: &[T], primvar: &Primvar) -> Vec<T> {
    let width = primvar.width();
    if primvar.mixing() != Mixing::Rotation {
        return stencils.apply_rows(source, width);
    }
    let mut children = vec![T::from_f64(0.0); stencils.rows() * width];
    children.par_chunks_mut(width.max(1)).enumerate().for_each(|(r, child)| {
        let parts = stencils.merged(r);
        let row = |&(s, w): &(S::Source, f32)| (&source[crate::connectivity::Id::index(s) * width..][..width], w);
        blend_into(&parts.iter().map(row), primvar, child);
    });
    children
}

/// Writes the weighted sum of rows of a primvar to `mean`.
///
/// A quaternion and its negative are the same rotation. Each one is therefore negated where it opposes that of the
/// heaviest row. Directions and rotations still need [`to_unit_length`].
pub fn blend_into<'a, T: super::Real + 'a>(
    rows: &(impl Iterator<Item = (&'a [T], f32)> + Clone),
    primvar: &Primvar,
    mean: &mut [T],
) {
    let heavier = |best: (&'a [T], f32), row: (&'a [T], f32)| if best.1 >= row.1 { best } else { row };
    let is_rotation = primvar.mixing() == Mixing::Rotation;
    let heaviest = rows.clone().filter(|_| is_rotation).reduce(heavier);
    for (k, value) in mean.iter_mut().enumerate() {
        let own = k - k % primvar.components..;
        let is_opposite = |row: &[T], heaviest: &[T]| {
            let parts = row[own.clone()].iter().zip(&heaviest[own.clone()]).take(primvar.components);
            parts.map(|(a, b)| a.to_f64() * b.to_f64()).sum::<f64>() < 0.0
        };
        let part = |(row, weight): (&[T], f32)| f64::from(weight) * row[k].to_f64();
        let aligned = |row: (&[T], f32), heaviest| if is_opposite(row.0, heaviest) { -part(row) } else { part(row) };
        *value = T::from_f64(match heaviest {
            None => rows.clone().fold(0.0, |sum, row| sum + part(row)),
            Some((heaviest, _)) => rows.clone().fold(0.0, |sum, row| sum + aligned(row, heaviest)),
        });
    }
}

/// Scales directions and rotations to unit length, after the last blend. Constant and uniform primvars keep their
/// authored lengths, as refinement only copies them.
pub fn to_unit_length(primvar: &mut Primvar) {
    if matches!(primvar.interpolation, Interpolation::Constant | Interpolation::Uniform) {
        return;
    }
    let (components, mixing) = (primvar.components, primvar.mixing());
    match &mut primvar.values {
        Values::F32(v) => scale_to_unit_length(v, components, mixing),
        Values::F64(v) => scale_to_unit_length(v, components, mixing),
        _ => {}
    }
}

/// [`to_unit_length`] for a slice of values of `components` numbers each.
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
