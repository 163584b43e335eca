//! Regions of the baseline: what is connected without crossing a chain or a border. A triangle of the simulation mesh
//! lies in one of them, so that what is counted within regions never leaks across a seam or to another layer.

use crate::mesh::{CornerId, FaceId, Groups, IdVec};
use crate::sim::{Baseline, SimProduct};
use rayon::prelude::*;

/// The regions of a baseline.
pub(super) struct Regions {
    /// The region of each triangle of the baseline.
    pub of: IdVec<FaceId, u32>,
    /// For each region whether it lies in UV space in one piece and does not fold, so that places in it are found there.
    pub is_flat: Vec<bool>,
}

impl Regions {
    pub fn new(baseline: &Baseline) -> Self {
        let count = baseline.topology.faces.len();
        let places: Vec<InUv> = (0..count).into_par_iter().map(|i| InUv::new(baseline, FaceId::new(i))).collect();
        let mut regions = Groups::<FaceId>::new(count);
        for corner in baseline.topology.faces.corners().ids() {
            if let Some(twin) = baseline.open_twin(corner).filter(|&twin| corner < twin) {
                let [a, b] = [corner, twin].map(|c| FaceId::new(c.index() / 3));
                regions.join(a, b);
            }
        }
        let (mut of, mut whole) = (IdVec::<FaceId, u32>::with_capacity(count), Vec::<InUv>::new());
        for (i, place) in places.into_iter().enumerate() {
            // The first of a region comes before all others of it.
            let first = regions.first(FaceId::new(i));
            let own = of.as_slice().get(first.index()).copied().unwrap_or(whole.len() as u32);
            of.push(own);
            match whole.get_mut(own as usize) {
                Some(whole) => whole.join(&place),
                None => whole.push(place),
            }
        }
        Self { of, is_flat: whole.iter().map(|w| w.is_whole && w.is_upright != w.is_turned).collect() }
    }

    /// The region of each triangle of the simulation mesh: that of most of its corners.
    pub fn of_product(&self, product: &SimProduct) -> IdVec<FaceId, u32> {
        let region = |i: usize| {
            let [a, b, c] = [0, 1, 2].map(|k| self.of[product.places[CornerId::new(3 * i + k)].location.face]);
            if b == c { b } else { a }
        };
        (0..product.triangles.len()).map(region).collect()
    }
}

/// How triangles lie in UV space.
struct InUv {
    /// Whether they have the same UVs as their neighbours.
    is_whole: bool,
    is_upright: bool,
    is_turned: bool,
}

impl InUv {
    fn new(baseline: &Baseline, face: FaceId) -> Self {
        let area = baseline.uv_area(face);
        // From one of the two faces.
        let is_joined = |c| baseline.open_twin(c).is_none_or(|twin| twin < c || same_uvs(baseline, c, twin));
        let is_whole = baseline.has_uvs && baseline.topology.faces.corners_of(face).all(is_joined);
        Self { is_whole, is_upright: area > 0.0, is_turned: area < 0.0 }
    }

    fn join(&mut self, other: &Self) {
        self.is_whole &= other.is_whole;
        self.is_upright |= other.is_upright;
        self.is_turned |= other.is_turned;
    }
}

/// Whether two faces have the same UVs along the edge between them.
fn same_uvs(baseline: &Baseline, half: CornerId, twin: CornerId) -> bool {
    let next = |c| baseline.topology.faces.next(c);
    baseline.uvs[half] == baseline.uvs[next(twin)] && baseline.uvs[next(half)] == baseline.uvs[twin]
}
