//! A face-varying primvar, refined to the baseline.

use crate::sim::{Baseline, BaselinePoint};
use crate::transfer::interpolate::{interpolate, weighted};
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec};
use tailor_mesh::garment::{Mesh, Mixing, Primvar};
use tailor_mesh::subdivide::{Channel, ChannelChild, Real, blend_into, blend_rows};

/// Largest difference of equal values, as a share of the largest value: rounding differs by the way to one place.
const SAME_VALUE: f64 = 4e-6;

/// A face-varying primvar on the baseline.
pub(super) struct FaceVaryingField<'a, T> {
    baseline: &'a Baseline,
    primvar: &'a Primvar,
    /// The primvar's topology on the finest level.
    channel: Channel,
    /// Its values there.
    values: Vec<T>,
    /// Largest difference of equal values.
    tolerance: f64,
}

impl<'a, T: Real> FaceVaryingField<'a, T> {
    /// `source` holds the primvar's values.
    pub fn new(garment: &Mesh, primvar: &'a Primvar, baseline: &'a Baseline, source: &[T]) -> Self {
        let own = primvar.joined_rows(&garment.faces, garment.points.len());
        let row = |c: CornerId| own[baseline.manifold.corner_source[c]] as usize;
        let rules = garment.rules;
        let cage = &baseline.manifold.level;
        let (mut channel, rows) = Channel::base(cage, row, rules.face_varying, rules.boundary);
        let width = primvar.width();
        let mut values: Vec<T> =
            rows.iter().flat_map(|&r| source[r as usize * width..][..width].iter().copied()).collect();
        // The levels of the baseline are reused: only the channel is refined.
        for (parent, child) in baseline.parents().zip(&baseline.levels) {
            let refined = ChannelChild::new(parent, &channel);
            values = blend_rows(&refined, &values, primvar);
            let next = refined.into_channel(child);
            channel = next;
        }
        let largest = values.iter().map(|v| v.to_f64().abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
        Self { baseline, primvar, channel, values, tolerance: SAME_VALUE * largest }
    }

    /// Half-edges of the baseline on cuts of the channel or barriers of the baseline; none if the channel has no cut of
    /// its own.
    pub fn barrier(&self) -> Option<IdVec<CornerId, bool>> {
        let baseline = self.baseline;
        let value = |c: CornerId| self.channel.corner_value[baseline.level_corner[c]];
        let faces = &baseline.topology.faces;
        let is_cut = |i: usize| {
            let corner = CornerId::new(i);
            let Some(twin) = baseline.open_twin(corner) else { return false };
            let source = |c| baseline.source_face[faces.face_of(c)];
            // Cuts run between faces of the garment.
            source(corner) != source(twin)
                && (value(corner) != value(faces.next(twin)) || value(faces.next(corner)) != value(twin))
        };
        let is_cut: Vec<bool> = (0..faces.corners().len()).into_par_iter().map(is_cut).collect();
        let barrier = || is_cut.iter().zip(baseline.barrier.iter()).map(|(&cut, &barrier)| cut || barrier).collect();
        is_cut.contains(&true).then(barrier)
    }

    /// Whether values are points of a plane, in which triangles can be flipped.
    pub fn is_layout(&self) -> bool {
        self.primvar.width() == 2 && self.primvar.mixing() == Mixing::Linear
    }

    /// Numbers in one value.
    pub fn width(&self) -> usize {
        self.primvar.width()
    }

    /// The value of corner `k` of a triangle of the baseline.
    fn corner(&self, face: FaceId, k: usize) -> &[T] {
        let corner = self.baseline.level_corner[CornerId::new(3 * face.index() + k)];
        &self.values[self.channel.corner_value[corner].index() * self.width()..][..self.width()]
    }

    /// The values of `count` corners, each at a location.
    pub fn at_locations(&self, count: usize, location: impl Fn(CornerId) -> BaselinePoint + Sync) -> Vec<T> {
        interpolate(count, self.primvar, |i| {
            let at = location(CornerId::new(i));
            weighted(&at, |k| self.corner(at.face, k))
        })
    }

    /// Writes the value at a location.
    pub fn value_at(&self, at: &BaselinePoint, value: &mut [T]) {
        blend_into(&weighted(at, |k| self.corner(at.face, k)).iter().copied(), self.primvar, value);
    }

    /// Whether two corners have equal `values`.
    pub fn same(&self, values: &[T], a: CornerId, b: CornerId) -> bool {
        let row = |c: CornerId| &values[c.index() * self.width()..][..self.width()];
        self.same_value(row(a), row(b))
    }

    /// Whether two values are equal up to the tolerance.
    pub fn same_value(&self, a: &[T], b: &[T]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a.to_f64() - b.to_f64()).abs() <= self.tolerance)
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
