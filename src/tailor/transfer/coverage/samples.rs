//! Samples of the baseline in one low-discrepancy sequence, and the areas that they stand for.

use super::CoveredArea;
use super::locator::Locator;
use crate::sim::{SimOptions, SimProduct};
use glam::{Vec3, Vec3A};
use rayon::prelude::*;
use tailor_mesh::connectivity::{Csr, FaceId, IdVec};

/// Areas that one face of the garment has in common with faces of the simulation mesh.
pub(super) struct AreaTally {
    covered: Vec<CoveredArea>,
    /// Index of each face of the simulation mesh in `covered`; arbitrary for those that are not in it.
    index: IdVec<FaceId, u32>,
}

impl AreaTally {
    /// Over a simulation mesh of `faces` faces.
    pub fn new(faces: usize) -> Self {
        Self { covered: Vec::new(), index: IdVec::filled(0, faces) }
    }

    fn add(&mut self, face: FaceId, area: f32) {
        match self.covered.get_mut(self.index[face] as usize) {
            Some(own) if own.face == face => own.area += area,
            _ => {
                self.index[face] = self.covered.len() as u32;
                self.covered.push(CoveredArea { face, area });
            }
        }
    }

    /// Removes the areas and returns them, ascending by face.
    pub fn take(&mut self) -> Vec<CoveredArea> {
        self.covered.sort_unstable_by_key(|c| c.face);
        let areas = self.covered.clone();
        self.covered.clear();
        areas
    }
}

/// The samples of each triangle of the baseline, by their numbers in one low-discrepancy sequence. Their count is in
/// proportion to the triangle's area in squares of the target length.
pub(super) struct SamplePlan {
    /// The number of the first sample of each triangle, and one past its last.
    numbers: IdVec<FaceId, [u64; 2]>,
    /// The area of each triangle. \[square mesh units\]
    pub area: IdVec<FaceId, f32>,
    /// The area that one sample of each triangle stands for. \[square mesh units\]
    sample_area: IdVec<FaceId, f32>,
    /// Start of the sequence.
    shift: [u64; 2],
}

impl SamplePlan {
    pub fn new(product: &SimProduct, source_triangles: &Csr<FaceId, FaceId>, options: &SimOptions) -> Self {
        let base = &product.baseline;
        let samples = f64::from(options.transfer_samples.max(1));
        let areas = |i: usize| {
            let face = FaceId::new(i);
            let target: f32 = base.topology.faces.vertices_of(face).iter().map(|&v| base.target[v]).sum();
            let target = f64::from(target) / 3.0;
            (0.5 * base.normal(face).length(), (0.25 * 3f64.sqrt() * target * target / samples) as f32)
        };
        let (area, sample_area): (Vec<f32>, Vec<f32>) =
            (0..base.topology.faces.len()).into_par_iter().map(areas).unzip();
        let mut seed = u64::from(options.seed);
        let start = (random(&mut seed) >> 11) as f64 / (1u64 << 53) as f64;
        let shift = [0; 2].map(|_| random(&mut seed));
        let mut numbers = IdVec::filled([0, 0], area.len());
        let mut sum = start;
        for &face in source_triangles.items() {
            let first = sum as u64;
            let own = f64::from(area[face.index()]) / f64::from(sample_area[face.index()]);
            sum += if own.is_finite() { own } else { 0.0 };
            numbers[face] = [first, sum as u64];
        }
        Self { numbers, area: area.into(), sample_area: sample_area.into(), shift }
    }

    /// Number of all samples.
    pub fn count(&self) -> u64 {
        self.numbers.iter().map(|[first, end]| end - first).sum()
    }

    /// Locates the samples of a triangle of the baseline and adds their areas. `points` is a buffer.
    pub fn sample(&self, locator: &Locator<'_>, face: FaceId, points: &mut Vec<Vec3A>, tally: &mut AreaTally) {
        let [first, end] = self.numbers[face];
        if first == end {
            return;
        }
        let Some(mut triangle) = locator.triangle(face) else { return };
        let (area, [a, b, c]) = (self.sample_area[face], triangle.corners);
        points.extend((first..end).map(|number| {
            let weights = self.weights(number);
            a * weights.x + b * weights.y + c * weights.z
        }));
        locator.count(&mut triangle, points, |face, count| tally.add(face, count as f32 * area));
    }

    /// Barycentric coordinates of a sample: the R2 sequence (Roberts 2018) in wrapping integers, its square folded to
    /// the triangle.
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

/// The next random number (splitmix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
