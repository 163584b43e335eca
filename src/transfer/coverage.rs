//! Which faces of the garment each face of the simulation mesh covers, counted by samples of the baseline. One pass
//! serves all sets and primvars, and keeps the counts alone, so that memory does not grow with the number of samples.

use super::Net;
use super::locate::{Locator, Near};
use super::region::Regions;
use crate::mesh::{Csr, FaceId, IdVec};
use crate::sim::{SimOptions, SimProduct};
use glam::Vec3;
use rayon::prelude::*;

/// Area that one face covers of another. \[square stage units\]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The other face: of the garment for a face of the simulation mesh, and the other way round.
    pub face: FaceId,
    /// The area on the baseline, as the samples say.
    pub area: f32,
}

/// The areas that faces of the simulation mesh and faces of the garment have in common.
pub struct Coverage {
    /// For each face of the simulation mesh those of the garment, ascending.
    pub sources: Csr<FaceId, Share>,
    /// For each face of the garment those of the simulation mesh, ascending.
    pub faces: Csr<FaceId, Share>,
    /// Area on the baseline of each face of the garment. \[square stage units\]
    pub source_area: IdVec<FaceId, f64>,
    /// Samples that were taken.
    pub samples: u64,
}

/// Shares of one face that are merged when there are so many.
const MERGE_AT: usize = 512;

impl Coverage {
    /// Samples the baseline: `transferSamples` for each equilateral triangle of the target length.
    pub fn new(product: &SimProduct, source_faces: usize, options: &SimOptions) -> Self {
        Self::over(product, &Net::new(product), source_faces, options)
    }

    /// The same, with the edges of the simulation mesh at hand.
    pub(super) fn over(product: &SimProduct, net: &Net, source_faces: usize, options: &SimOptions) -> Self {
        let regions = Regions::new(&product.baseline);
        let locator = Locator::new(product, net, &regions);
        let base = &product.baseline;
        let pairs = base.source_face.enumerated().map(|(face, &source)| (source, face));
        let children: Csr<FaceId, FaceId> = Csr::group(source_faces, pairs, FaceId::new(0));
        let plan = Plan::new(product, &children, options);
        let rows: Vec<Vec<Share>> = (0..source_faces)
            .into_par_iter()
            .map_init(Near::new, |near, source| {
                let mut shares = Vec::new();
                for &face in children.row(FaceId::new(source)) {
                    plan.sample(&locator, face, near, &mut shares);
                }
                merge(&mut shares);
                // Thousands of rows wait until all are there.
                shares.shrink_to_fit();
                shares
            })
            .collect();
        let mut source_area = IdVec::filled(0.0, source_faces);
        for (face, &source) in base.source_face.enumerated() {
            source_area[source] += 0.5 * f64::from(base.normal(face).length());
        }
        let faces = rows_of(&rows);
        let transposed = rows.iter().enumerate().flat_map(|(source, row)| {
            row.iter().map(move |s| (s.face, Share { face: FaceId::new(source), area: s.area }))
        });
        let filler = Share { face: FaceId::new(0), area: 0.0 };
        let sources = Csr::group(product.triangles.len(), transposed, filler);
        Self { sources, faces, source_area, samples: plan.samples() }
    }

    /// The area that all samples of a face of the simulation mesh stand for; 0 where it has none.
    pub fn total(&self, face: FaceId) -> f32 {
        self.sources.row(face).iter().map(|s| s.area).sum()
    }
}

fn rows_of(rows: &[Vec<Share>]) -> Csr<FaceId, Share> {
    let mut offsets = Vec::with_capacity(rows.len() + 1);
    offsets.push(0);
    let mut items = Vec::with_capacity(rows.iter().map(Vec::len).sum());
    for row in rows {
        items.extend_from_slice(row);
        offsets.push(items.len() as u32);
    }
    Csr::from_parts(offsets, items)
}

/// Sums the shares of each face; ascending.
fn merge(shares: &mut Vec<Share>) {
    // Stable, so that sums do not depend on how the sort works.
    shares.sort_by_key(|s| s.face);
    shares.dedup_by(|next, kept| {
        let same = next.face == kept.face;
        if same {
            kept.area += next.area;
        }
        same
    });
}

/// The samples of each triangle of the baseline: numbered in one low-discrepancy sequence, the number of each triangle
/// in proportion to its area in terms of the target length.
struct Plan {
    /// The number of the first sample of each triangle, and one past its last.
    numbers: IdVec<FaceId, [u64; 2]>,
    /// The area that one sample of each triangle stands for.
    area: IdVec<FaceId, f32>,
    /// Where the sequence begins.
    shift: [u64; 2],
}

impl Plan {
    fn new(product: &SimProduct, children: &Csr<FaceId, FaceId>, options: &SimOptions) -> Self {
        let base = &product.baseline;
        let samples = f64::from(options.transfer_samples.max(1));
        let area: IdVec<FaceId, f32> = base
            .topology
            .faces
            .ids()
            .map(|face| {
                let target: f32 = base.topology.faces.vertices_of(face).iter().map(|&v| base.target[v]).sum();
                let target = f64::from(target) / 3.0;
                (0.25 * 3f64.sqrt() * target * target / samples) as f32
            })
            .collect();
        let mut seed = u64::from(options.seed);
        let start = (random(&mut seed) >> 11) as f64 / (1u64 << 53) as f64;
        let shift = [0; 2].map(|_| random(&mut seed));
        let mut numbers = IdVec::filled([0, 0], area.len());
        let mut sum = start;
        for &face in children.items() {
            let first = sum as u64;
            let own = 0.5 * f64::from(base.normal(face).length()) / f64::from(area[face]);
            sum += if own.is_finite() { own } else { 0.0 };
            numbers[face] = [first, sum as u64];
        }
        Self { numbers, area, shift }
    }

    fn samples(&self) -> u64 {
        self.numbers.iter().map(|[first, end]| end - first).sum()
    }

    /// Locates the samples of a triangle.
    fn sample(&self, locator: &Locator<'_>, face: FaceId, near: &mut Near, shares: &mut Vec<Share>) {
        let [first, end] = self.numbers[face];
        if first == end {
            return;
        }
        if !locator.turn_to(face, near) {
            return;
        }
        let area = self.area[face];
        let mut merge_at = MERGE_AT;
        let mut found = |face: FaceId, count: u32| {
            shares.push(Share { face, area: count as f32 * area });
            if shares.len() >= merge_at {
                merge(shares);
                merge_at = MERGE_AT.max(2 * shares.len());
            }
        };
        for number in first..end {
            locator.count(near, self.weights(number), &mut found);
        }
        Locator::finish(near, &mut found);
    }

    /// A place on a triangle: the plane's R2 sequence (Roberts 2018) in whole numbers that wrap around, whose square is
    /// folded to the triangle.
    fn weights(&self, number: u64) -> Vec3 {
        // 2^64 over the plastic number, and over its square.
        const STEP: [u64; 2] = [0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1d];
        const ONE: u32 = 1 << 24;
        let [u, v] = [0, 1].map(|k| (self.shift[k].wrapping_add(number.wrapping_mul(STEP[k])) >> 40) as u32);
        let (u, v) = if u + v > ONE { (ONE - u, ONE - v) } else { (u, v) };
        let [u, v] = [u, v].map(|x| x as f32 / ONE as f32);
        Vec3::new(1.0 - u - v, u, v)
    }
}

/// A number of any 64 bits, and the next state (splitmix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
