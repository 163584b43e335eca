//! Regions of the baseline: triangles connected across half-edges on no chain and no border. A triangle of the
//! simulation mesh lies in one region, so that its samples stay on its layer and its side of each seam.

use crate::sim::{Baseline, SimProduct};
use rayon::prelude::*;
use tailor_mesh::connectivity::{CornerId, FaceId, Groups, IdVec};

/// The regions of a baseline.
pub(in crate::transfer) struct Regions {
    /// The region of each triangle of the baseline.
    pub of: IdVec<FaceId, u32>,
    /// For each region whether its UVs are connected and unfolded, so that points are located in UV space.
    pub is_flat: Vec<bool>,
}

impl Regions {
    pub fn new(baseline: &Baseline) -> Self {
        let count = baseline.topology.faces.len();
        let layouts: Vec<UvLayout> =
            (0..count).into_par_iter().map(|i| UvLayout::new(baseline, FaceId::new(i))).collect();
        let mut groups = Groups::<FaceId>::new(count);
        for corner in baseline.topology.faces.corners().ids() {
            if let Some(twin) = baseline.open_twin(corner).filter(|&twin| corner < twin) {
                groups.join(FaceId::new(corner.index() / 3), FaceId::new(twin.index() / 3));
            }
        }
        let (mut of, mut regions) = (IdVec::<FaceId, u32>::with_capacity(count), Vec::<UvLayout>::new());
        for (i, layout) in layouts.into_iter().enumerate() {
            let first = groups.first(FaceId::new(i));
            // The first triangle of a region has the lowest number.
            if first.index() == i {
                of.push(regions.len() as u32);
                regions.push(layout);
            } else {
                of.push(of[first]);
                regions[of[first] as usize].join(&layout);
            }
        }
        let is_flat = |r: &UvLayout| r.is_connected && r.has_upright != r.has_flipped;
        Self { is_flat: regions.iter().map(is_flat).collect(), of }
    }

    /// The region of each triangle of the simulation mesh: the mode of its corners.
    pub fn of_product(&self, product: &SimProduct) -> IdVec<FaceId, u32> {
        let region = |i: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| self.of[product.places[CornerId::new(3 * i + k)].location.face]);
            if b == c { b } else { a }
        };
        (0..product.triangles.len()).map(region).collect()
    }
}

/// UVs of some triangles.
struct UvLayout {
    /// Whether neighbours have the same UVs along their common edges.
    is_connected: bool,
    has_upright: bool,
    has_flipped: bool,
}

impl UvLayout {
    fn new(baseline: &Baseline, face: FaceId) -> Self {
        let area = baseline.uv_area(face);
        let next = |c| baseline.topology.faces.next(c);
        let same_uvs = |half, twin| {
            baseline.uvs[half] == baseline.uvs[next(twin)] && baseline.uvs[next(half)] == baseline.uvs[twin]
        };
        // Each edge is compared from one of its two faces.
        let is_joined = |c| baseline.open_twin(c).is_none_or(|twin| twin < c || same_uvs(c, twin));
        let is_connected = baseline.has_uvs && baseline.topology.faces.corners_of(face).all(is_joined);
        Self { is_connected, has_upright: area > 0.0, has_flipped: area < 0.0 }
    }

    fn join(&mut self, other: &Self) {
        self.is_connected &= other.is_connected;
        self.has_upright |= other.has_upright;
        self.has_flipped |= other.has_flipped;
    }
}
