//! A garment with all its attributes through one derivation.

use super::stencil::Stencils;
use super::{Derivation, Refiner, refined_sharpness};
use crate::garment::joints::{self, Influences};
use crate::garment::{
    Corner, Crease, Elements, Family, FamilyType, Garment, Interpolation, Mixing, Primvar, Scheme, Subset, Values,
};
use crate::mesh::{CornerId, Csr, FaceId, VertexId};
use rayon::prelude::*;

/// A garment on its way through derivations. Its joint influences are kept whole until the end, so that they are pruned
/// to `elementSize` only once.
pub struct Cage {
    garment: Garment,
    influences: Option<Vec<Influences>>,
}

impl Cage {
    /// The cage of a garment.
    pub fn new(garment: Garment) -> Self {
        let influences = joints::pair(&garment).map(|(indices, weights)| joints::influences(indices, weights));
        Self { garment, influences }
    }

    /// The cage refined once, with every attribute.
    pub fn refined(&self) -> Self {
        let (garment, influences) = refine(&self.garment, self.influences.as_deref());
        Self { garment, influences }
    }

    /// The garment, with its influences pruned and its directions of unit length.
    pub fn into_garment(self) -> Garment {
        let Self { mut garment, influences } = self;
        garment.primvars.iter_mut().for_each(to_unit_length);
        let carried = match (joints::pair(&garment), &influences) {
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

fn refine(garment: &Garment, influences: Option<&[Influences]>) -> (Garment, Option<Vec<Influences>>) {
    let mut refiner = Refiner::new(garment);
    let of_channels: Vec<usize> = (0..garment.primvars.len()).filter(|&i| is_channel(&garment.primvars[i])).collect();
    let rows = refiner.add_channels(garment, of_channels.par_iter().map(|&i| &garment.primvars[i]));
    let derivation = refiner.derive();
    let carry = Carry::new(garment, &derivation);
    let points: Vec<[f32; 3]> = garment.points.iter().map(|p| p.to_array()).collect();
    let carried =
        garment.primvars.par_iter().enumerate().map(|(i, primvar)| match of_channels.iter().position(|&at| at == i) {
            Some(channel) => carry.channel(primvar, channel, &rows[channel]),
            None if joints::is_influence(garment, primvar) => primvar.clone(),
            None => carry.primvar(primvar),
        });
    let (primvars, influences) = rayon::join(|| carried.collect(), || influences.map(|all| carry.influences(all)));
    let refined = Garment {
        prim: garment.prim.clone(),
        points: derivation.vertex().apply(&points).into_iter().map(Into::into).collect(),
        orientation: garment.orientation,
        rules: garment.rules,
        holes: carry.faces(&garment.holes),
        creases: garment.creases.iter().flat_map(|c| carry.crease(c)).collect(),
        corners: garment.corners.iter().filter_map(refined_corner).collect(),
        subsets: garment.subsets.iter().map(|s| carry.subset(s)).collect(),
        families: garment.families.iter().map(|f| refined_family(garment, f)).collect(),
        primvars,
        faces: derivation.faces,
    };
    (refined, influences)
}

/// Whether a primvar is refined as a face-varying channel.
fn is_channel(primvar: &Primvar) -> bool {
    primvar.interpolation == Interpolation::FaceVarying && primvar.is_mixed()
}

fn refined_corner(corner: &Corner) -> Option<Corner> {
    let sharpness = refined_sharpness(corner.sharpness);
    (sharpness > 0.0).then_some(Corner { sharpness, ..*corner })
}

/// New edges and vertices inside faces belong to no subset, so a partition of edges or points is none any more.
fn refined_family(garment: &Garment, family: &Family) -> Family {
    let mut members = garment.subsets.iter().filter(|s| s.family == family.name);
    let of_faces = members.all(|s| matches!(s.elements, Elements::Faces(_)));
    let kind = match family.kind {
        FamilyType::Partition if !of_faces => FamilyType::NonOverlapping,
        kind => kind,
    };
    Family { name: family.name.clone(), kind }
}

struct Carry<'a> {
    garment: &'a Garment,
    derivation: &'a Derivation<'a>,
    parent_face: Vec<FaceId>,
    children: Csr<FaceId, FaceId>,
}

impl<'a> Carry<'a> {
    fn new(garment: &'a Garment, derivation: &'a Derivation<'a>) -> Self {
        let numbering = derivation.numbering();
        let parents = &derivation.parent().topology.faces;
        let parent_face: Vec<FaceId> = derivation.faces.ids().map(|f| numbering.parent_face(parents, f)).collect();
        let pairs = parent_face.iter().enumerate().map(|(child, &parent)| (parent, FaceId::new(child)));
        let children = Csr::group(parents.len(), pairs, FaceId::new(0));
        Self { garment, derivation, parent_face, children }
    }

    fn faces(&self, parents: &[FaceId]) -> Vec<FaceId> {
        parents.iter().flat_map(|&f| self.children.row(f).iter().copied()).collect()
    }

    /// The two halves of an edge, in its direction.
    fn halves(&self, [a, b]: [VertexId; 2]) -> Option<[[VertexId; 2]; 2]> {
        let numbering = self.derivation.numbering();
        let edge = self.derivation.parent().topology.find_edge(a, b)?;
        let middle = numbering.of_edge(edge);
        Some([[numbering.of_vertex(a), middle], [middle, numbering.of_vertex(b)]])
    }

    fn subset(&self, subset: &Subset) -> Subset {
        let elements = match &subset.elements {
            Elements::Faces(faces) => Elements::Faces(self.faces(faces)),
            Elements::Edges(edges) => Elements::Edges(edges.iter().filter_map(|&e| self.halves(e)).flatten().collect()),
            Elements::Points(points) => {
                Elements::Points(points.iter().map(|&v| self.derivation.numbering().of_vertex(v)).collect())
            }
        };
        Subset { elements, ..subset.clone() }
    }

    /// The refined crease; where its sharpness ends within, the parts that remain.
    fn crease(&self, crease: &Crease) -> Vec<Crease> {
        let mut parts: Vec<Crease> = Vec::new();
        let mut open = false;
        for (pair, &sharpness) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
            let left = refined_sharpness(sharpness);
            let halves = self.halves([pair[0], pair[1]]).filter(|_| left > 0.0);
            let Some([[a, middle], [_, b]]) = halves else {
                open = false;
                continue;
            };
            if !std::mem::replace(&mut open, true) {
                parts.push(Crease { vertices: vec![a], sharpnesses: Vec::new() });
            }
            if let Some(part) = parts.last_mut() {
                part.vertices.extend([middle, b]);
                part.sharpnesses.extend([left, left]);
            }
        }
        parts
    }

    fn channel(&self, primvar: &Primvar, channel: usize, rows: &[u32]) -> Primvar {
        let stencils = &self.derivation.channels[channel];
        let source = primvar.values.gather(primvar.width(), rows.iter().map(|&r| r as usize));
        let values = mixed(stencils, &source, primvar);
        let indices = stencils.corner_values().iter().map(|v| v.index() as u32).collect();
        Primvar { values, indices: Some(indices), ..primvar.clone() }
    }

    fn primvar(&self, primvar: &Primvar) -> Primvar {
        match primvar.interpolation {
            Interpolation::Constant => primvar.clone(),
            Interpolation::Uniform => taken(primvar, self.parent_face.iter().map(|f| f.index())),
            Interpolation::FaceVarying => taken(primvar, self.parent_corners()),
            Interpolation::Vertex => self.by_vertex(primvar, &self.derivation.vertex()),
            Interpolation::Varying => self.by_vertex(primvar, &self.derivation.varying()),
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
        Primvar { values: mixed(stencils, &source, primvar), indices: None, ..primvar.clone() }
    }

    /// The parent corner that each child corner takes discrete values from.
    fn parent_corners(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        let faces = &self.derivation.parent().topology.faces;
        let is_loop = self.derivation.parent().scheme == Scheme::Loop;
        self.derivation.faces.corners().ids().map(move |c: CornerId| {
            let child = self.derivation.faces.face_of(c);
            if !is_loop {
                // A child quad belongs to one corner of its parent.
                return child.index();
            }
            let parent = faces.range(self.parent_face[child.index()]).start;
            let step = child.index() % 4;
            parent + if step < 3 { step } else { c.index() % 3 }
        })
    }

    /// The influences of the child's vertices, merged by joint.
    fn influences(&self, all: &[Influences]) -> Vec<Influences> {
        let stencils = self.derivation.vertex();
        let rows = (0..stencils.rows()).into_par_iter();
        rows.map(|r| joints::blend(stencils.merged(r).iter().map(|&(v, w)| (&all[v.index()], w)))).collect()
    }
}

/// The values of the given elements, as they are; indexed primvars stay indexed.
pub fn taken(primvar: &Primvar, elements: impl Iterator<Item = usize> + Clone) -> Primvar {
    match &primvar.indices {
        Some(indices) => Primvar { indices: Some(elements.map(|e| indices[e]).collect()), ..primvar.clone() },
        None => Primvar { values: primvar.values.gather(primvar.width(), elements), ..primvar.clone() },
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
