//! Values of corners: the constraint UVs as they were made, others at the corners' places on the baseline.

use super::rows::{at_places, parts};
use super::shell::Cuts;
use super::sides::Sides;
use super::{Sites, Target};
use crate::error::Warning;
use crate::garment::{Garment, Interpolation, Mixing, Primvar, Values};
use crate::mesh::{CornerId, FaceId, IdVec, Topology, VertexId};
use crate::sim::{Location, SimProduct};
use crate::subdivide::{Channel, ChannelChild, Real, mix_into, mix_rows, taken};
use rayon::prelude::*;
use std::sync::Arc;

/// Values that differ by no more than this share of the largest are the same: they came to one place on two ways.
const SAME: f64 = 4e-6;

/// A face-varying primvar on the simulation mesh: on its vertices where no value changes by that.
///
/// The constraint UVs stay on the corners, as a layout has to be there to be one of another run.
pub(super) fn carry(
    garment: &Garment,
    primvar: &Primvar,
    target: &Target<'_>,
    uv_set: Option<&Primvar>,
    warnings: &mut Vec<Warning>,
) -> Primvar {
    let Target { product, sites, .. } = *target;
    if uv_set.is_some_and(|uv| uv.name == primvar.name) {
        let values: Vec<f32> = product.places.iter().flat_map(|p| p.uv.to_array()).collect();
        let same = |a: CornerId, b: CornerId| values[2 * a.index()..][..2] == values[2 * b.index()..][..2];
        let rows = indexed(sites, true, same);
        return rows.primvar(primvar, &Values::F32(values));
    }
    let (carried, apart) = match &primvar.values {
        Values::F32(v) if primvar.is_mixed() => Field::new(garment, primvar, product, v).carry(target, Values::F32),
        Values::F64(v) if primvar.is_mixed() => Field::new(garment, primvar, product, v).carry(target, Values::F64),
        _ => {
            let source = |i| product.baseline.source_corner(sites.centre(FaceId::new(i))).index();
            let sources: Vec<usize> = (0..product.triangles.len()).into_par_iter().map(source).collect();
            (taken(primvar, sources.iter().flat_map(|&c| [c; 3])), 0)
        }
    };
    if apart > 0 {
        warnings.push(Warning::NotCarried {
            what: format!("the shells of {apart} triangles in primvars:{} on the simulation mesh", primvar.name),
            why: "next to others of their side they would lie the wrong way round, so that they are cut off; make the cuts \
                  of the layout edges of the mesh, or lower sim.maxEdgeLength"
                .into(),
        });
    }
    as_vertex(carried, &sites.net.topology)
}

/// The primvar on vertices, where all corners of each vertex have one value bit for bit; else as it is.
fn as_vertex(primvar: Primvar, t: &Topology) -> Primvar {
    let corners_of = |v: VertexId| t.vertex_corners.row(v);
    let row = |c: CornerId| primvar.row(c.index());
    let same = |a: usize, b: usize| a == b || primvar.values.same_rows(primvar.width(), a, b);
    let is_one = |v| corners_of(v).first().is_some_and(|&own| corners_of(v).iter().all(|&c| same(row(c), row(own))));
    let vertices = (0..t.vertex_count()).map(VertexId::new);
    if !vertices.clone().all(is_one) {
        return primvar;
    }
    let rows = vertices.map(|v| row(corners_of(v)[0]));
    let (values, indices) = match &primvar.indices {
        Some(_) if !primvar.is_mixed() => (primvar.values.clone(), Some(Arc::new(rows.map(|r| r as u32).collect()))),
        _ => (primvar.values.gather(primvar.width(), rows), None),
    };
    Primvar { interpolation: Interpolation::Vertex, values, indices, ..primvar }
}

/// A face-varying primvar refined to the baseline.
pub(super) struct Field<'a, T> {
    product: &'a SimProduct,
    primvar: &'a Primvar,
    /// The primvar's topology on the finest level.
    channel: Channel,
    /// Its values there.
    values: Vec<T>,
    /// Values that differ by no more are the same.
    slack: f64,
}

impl<'a, T: Real> Field<'a, T> {
    fn new(garment: &Garment, primvar: &'a Primvar, product: &'a SimProduct, source: &[T]) -> Self {
        let baseline = &product.baseline;
        let own = primvar.corner_rows(&garment.faces, garment.points.len());
        let row = |c: CornerId| own[baseline.manifold.corner_source[c]] as usize;
        let rules = garment.rules;
        let cage = &baseline.manifold.refiner.level;
        let (mut channel, rows) = Channel::base(cage, row, rules.face_varying, rules.boundary);
        let width = primvar.width();
        let mut values: Vec<T> =
            rows.iter().flat_map(|&r| source[r as usize * width..][..width].iter().copied()).collect();
        // Along the levels that the baseline has, so that only the channel itself is refined.
        for (parent, child) in baseline.parents().zip(&baseline.levels) {
            let refined = ChannelChild::new(&parent.level, &channel);
            values = mix_rows(&refined, &values, primvar);
            let next = refined.into_channel(&child.level);
            channel = next;
        }
        let largest = values.iter().map(|v| v.to_f64().abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
        Self { product, primvar, channel, values, slack: SAME * largest }
    }

    /// The cuts of this channel with the barriers of the baseline; none where it has no other cuts than those.
    fn barrier(&self) -> Option<IdVec<CornerId, bool>> {
        let baseline = &self.product.baseline;
        let value = |c: CornerId| self.channel.corner_value[baseline.level_corner[c]];
        let t = &baseline.topology;
        let is_own = |i: usize| {
            let corner = CornerId::new(i);
            let Some(twin) = baseline.open_twin(corner) else { return false };
            let source = |c| baseline.source_face[t.faces.face_of(c)];
            // No cut runs through a face of the garment.
            source(corner) != source(twin)
                && (value(corner) != value(t.faces.next(twin)) || value(t.faces.next(corner)) != value(twin))
        };
        let is_own: Vec<bool> = (0..t.faces.corners().len()).into_par_iter().map(is_own).collect();
        let has_own = is_own.contains(&true);
        has_own.then(|| is_own.iter().zip(baseline.barrier.iter()).map(|(&own, &barrier)| own || barrier).collect())
    }

    /// The primvar, and how many of its triangles had to be cut off.
    fn carry(&self, target: &Target<'_>, wrap: impl Fn(Vec<T>) -> Values) -> (Primvar, usize) {
        let sites = target.sites;
        let (values, apart) = match self.barrier() {
            Some(barrier) => {
                let cuts = Cuts::new(self.product, sites, target.coverage, barrier);
                Sides::new(self, &cuts, sites).settle(self.is_layout())
            }
            None => (self.at_locations(|c| self.product.places[c].location), 0),
        };
        let rows = indexed(sites, false, |a, b| self.same(&values, a, b));
        (rows.primvar(self.primvar, &wrap(values)), apart)
    }

    /// Whether the values lie in a plane, in which triangles can turn over.
    fn is_layout(&self) -> bool {
        self.primvar.width() == 2 && self.primvar.mixing == Mixing::Linear
    }

    /// Numbers of one value.
    pub fn width(&self) -> usize {
        self.primvar.width()
    }

    /// The value of corner `k` of a triangle of the baseline.
    pub fn corner(&self, face: FaceId, k: usize) -> &[T] {
        let corner = self.product.baseline.level_corner[CornerId::new(3 * face.index() + k)];
        let width = self.primvar.width();
        &self.values[self.channel.corner_value[corner].index() * width..][..width]
    }

    /// The values of all corners of the simulation mesh, each at a location.
    pub fn at_locations(&self, location: impl Fn(CornerId) -> Location + Sync) -> Vec<T> {
        at_places(self.product.places.len(), self.primvar, |i| {
            let at = location(CornerId::new(i));
            parts(&at, |k| self.corner(at.face, k))
        })
    }

    /// The value at a location.
    pub fn value_at(&self, at: &Location, value: &mut [T]) {
        mix_into(&parts(at, |k| self.corner(at.face, k)).iter().copied(), self.primvar, value);
    }

    /// Whether two corners have the same of `values`.
    pub fn same(&self, values: &[T], a: CornerId, b: CornerId) -> bool {
        let width = self.primvar.width();
        let row = |c: CornerId| &values[c.index() * width..][..width];
        self.same_values(row(a), row(b))
    }

    /// Whether two values are the same.
    pub fn same_values(&self, a: &[T], b: &[T]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a.to_f64() - b.to_f64()).abs() <= self.slack)
    }

    /// Twice the signed area of a triangle of the baseline in a layout.
    pub fn doubled_area(&self, face: FaceId) -> f64 {
        doubled_area([0, 1, 2].map(|k| self.corner(face, k)))
    }
}

/// Twice the signed area of a triangle in a layout.
pub(super) fn doubled_area<T: Real>([a, b, c]: [&[T]; 3]) -> f64 {
    let side = |p: &[T]| [0, 1].map(|k| p[k].to_f64() - a[k].to_f64());
    let (u, v) = (side(b), side(c));
    u[0] * v[1] - u[1] * v[0]
}

/// The corners that have a value each, and for every corner the one whose value it shares.
struct Rows {
    rows: Vec<usize>,
    indices: Vec<u32>,
}

impl Rows {
    fn primvar(self, primvar: &Primvar, values: &Values) -> Primvar {
        let values = values.gather(primvar.width(), self.rows.into_iter());
        Primvar { values, indices: Some(Arc::new(self.indices)), ..primvar.clone() }
    }
}

/// Corners of a vertex share a value where neither a difference nor, for the constraint UVs, a seam is between them.
fn indexed(sites: &Sites<'_>, keep_seams: bool, same: impl Fn(CornerId, CornerId) -> bool) -> Rows {
    let (net, faces) = (&sites.net, &sites.net.topology.faces);
    let mut row: IdVec<CornerId, Option<u32>> = IdVec::filled(None, faces.corners().len());
    let (mut rows, mut reached) = (Vec::with_capacity(sites.vertices.len()), Vec::new());
    for seed in faces.corners().ids() {
        if row[seed].is_some() {
            continue;
        }
        let own = rows.len() as u32;
        rows.push(seed.index());
        row[seed] = Some(own);
        reached.push(seed);
        while let Some(corner) = reached.pop() {
            // The neighbours around the vertex: across the edge that leaves and across the one that arrives.
            let arriving = faces.prev(corner);
            let before = net.twin[corner].map(|twin| (corner, faces.next(twin)));
            let after = net.twin[arriving].map(|twin| (arriving, twin));
            for (half, other) in before.into_iter().chain(after) {
                let is_cut = || keep_seams && net.is_seam[net.topology.corner_edge[half]];
                // By the value that is kept, so that small differences do not add up around a vertex.
                if row[other].is_none() && !is_cut() && same(seed, other) {
                    row[other] = Some(own);
                    reached.push(other);
                }
            }
        }
    }
    Rows { rows, indices: row.iter().map(|r| r.unwrap_or(0)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    /// Two triangles over four vertices.
    fn two() -> Topology {
        Topology::new(Faces::triangles([0, 1, 2, 2, 1, 3].map(VertexId::new).to_vec()), 4)
    }

    fn bits(primvar: &Primvar, row: usize) -> u32 {
        match &primvar.values {
            Values::F32(v) => v[primvar.row(row)].to_bits(),
            _ => panic!("floats stay floats"),
        }
    }

    #[test]
    fn values_on_vertices_are_those_of_all_corners_bit_for_bit() {
        let (t, of_vertex) = (two(), [0.1f32, -0.0, f32::MIN_POSITIVE, f32::NAN]);
        let corners: Vec<f32> = t.faces.corners().iter().map(|v| of_vertex[v.index()]).collect();
        for given in
            [Primvar::of_corners(corners, None), Primvar::of_corners(of_vertex.to_vec(), Some(vec![0, 1, 2, 2, 1, 3]))]
        {
            let moved = as_vertex(given.clone(), &t);
            assert_eq!((moved.interpolation, moved.elements()), (Interpolation::Vertex, 4));
            for (corner, vertex) in t.faces.corners().enumerated() {
                assert_eq!(bits(&moved, vertex.index()), bits(&given, corner.index()));
            }
        }
    }

    #[test]
    fn a_corner_that_differs_by_one_bit_keeps_all_on_corners() {
        let t = two();
        for (corner, other) in [(3, 2.0f32.next_up()), (4, -0.0)] {
            let mut values = vec![1.0, 0.0, 2.0, 2.0, 0.0, 3.0];
            values[corner] = other;
            let given = Primvar::of_corners(values, None);
            assert_eq!(as_vertex(given.clone(), &t), given);
        }
    }
}
