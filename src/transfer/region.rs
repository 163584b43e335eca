//! Regions of the baseline: what is connected without crossing a chain or a border. A triangle of the simulation mesh
//! lies in one of them, so that what is counted within regions never leaks across a seam or to another layer.

use crate::mesh::{CornerId, FaceId, IdVec};
use crate::sim::{Baseline, SimProduct};

/// The regions of a baseline.
pub(super) struct Regions {
    /// The region of each triangle of the baseline.
    pub of: IdVec<FaceId, u32>,
    /// For each region whether it lies in UV space in one piece and does not fold, so that places in it are found there.
    pub is_flat: Vec<bool>,
}

impl Regions {
    pub fn new(baseline: &Baseline) -> Self {
        let t = &baseline.topology;
        let mut of = IdVec::<FaceId, Option<u32>>::filled(None, t.faces.len());
        let mut is_flat = Vec::new();
        for seed in t.faces.ids() {
            if of[seed].is_some() {
                continue;
            }
            let own = is_flat.len() as u32;
            of[seed] = Some(own);
            let mut region = vec![seed];
            let (mut at, mut is_whole, mut upright, mut turned) = (0, baseline.has_uvs, false, false);
            while let Some(&face) = region.get(at) {
                at += 1;
                let area = baseline.uv_area(face);
                turned |= area < 0.0;
                upright |= area > 0.0;
                for corner in t.faces.corners_of(face) {
                    let Some(twin) = baseline.open_twin(corner) else { continue };
                    is_whole &= same_uvs(baseline, corner, twin);
                    let other = t.faces.face_of(twin);
                    if of[other].is_none() {
                        of[other] = Some(own);
                        region.push(other);
                    }
                }
            }
            is_flat.push(is_whole && upright != turned);
        }
        Self { of: of.iter().map(|r| r.unwrap_or(0)).collect(), is_flat }
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

/// Whether two faces have the same UVs along the edge between them.
fn same_uvs(baseline: &Baseline, half: CornerId, twin: CornerId) -> bool {
    let next = |c| baseline.topology.faces.next(c);
    baseline.uvs[half] == baseline.uvs[next(twin)] && baseline.uvs[next(half)] == baseline.uvs[twin]
}
