//! Which faces of the garment each face of the simulation mesh covers, counted by samples of the baseline. One pass
//! serves all sets and primvars, and keeps the counts alone, so that memory does not grow with the number of samples.

use super::Net;
use super::locate::Locator;
use super::region::Regions;
use crate::mesh::{Csr, FaceId, IdVec};
use crate::sim::{SimOptions, SimProduct};
use glam::{Vec3, Vec3A};
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

impl Coverage {
    /// Samples the baseline: `transferSamples` for each equilateral triangle of the target length.
    pub fn new(product: &SimProduct, source_faces: usize, options: &SimOptions) -> Self {
        Self::over(product, &Net::new(product, source_faces), options)
    }

    /// The same, with the edges of the simulation mesh at hand.
    pub(super) fn over(product: &SimProduct, net: &Net, options: &SimOptions) -> Self {
        let base = &product.baseline;
        let (regions, plan) = rayon::join(|| Regions::new(base), || Plan::new(product, &net.children, options));
        let locator = Locator::new(product, net, &regions);
        let source_faces = net.children.rows();
        let rows: Vec<Vec<Share>> = (0..source_faces)
            .into_par_iter()
            .map_init(
                || Tally::new(product.triangles.len()),
                |tally, source| {
                    let own = net.children.row(FaceId::new(source));
                    own.iter().for_each(|&face| plan.sample(&locator, face, tally));
                    tally.take()
                },
            )
            .collect();
        let mut source_area = IdVec::filled(0.0, source_faces);
        for (&source, &area) in base.source_face.iter().zip(plan.area.iter()) {
            source_area[source] += f64::from(area);
        }
        let faces = rows_of(&rows);
        let transposed = rows.iter().enumerate().flat_map(|(source, row)| {
            row.iter().map(move |s| (s.face, Share { face: FaceId::new(source), area: s.area }))
        });
        let filler = Share { face: FaceId::new(0), area: 0.0 };
        let sources = Csr::group(product.triangles.len(), transposed, filler);
        Self { sources, faces, source_area, samples: plan.samples() }
    }

    /// The area that a set of the garment's faces and a set of faces of the simulation mesh have in common: that inside
    /// both, that of the first, and that of the second. \[square stage units\]
    fn common(&self, source: &[FaceId], set: &[FaceId]) -> [f64; 3] {
        let mut is_in = IdVec::<FaceId, bool>::filled(false, self.faces.rows());
        source.iter().for_each(|&f| is_in[f] = true);
        let first = source.iter().flat_map(|&f| self.faces.row(f)).map(|s| f64::from(s.area)).sum();
        let shares = || set.iter().flat_map(|&f| self.sources.row(f));
        let both = shares().filter(|s| is_in[s.face]).map(|s| f64::from(s.area)).sum();
        [both, first, shares().map(|s| f64::from(s.area)).sum()]
    }

    /// What a set of the garment's faces and a set of faces of the simulation mesh have in common, as a share of their mean
    /// area (Dice 1945); 1 where both are empty.
    pub fn agreement(&self, source: &[FaceId], set: &[FaceId]) -> f64 {
        let [both, first, second] = self.common(source, set);
        if first + second > 0.0 { 2.0 * both / (first + second) } else { 1.0 }
    }

    /// The same as a share of their union (Jaccard 1901).
    pub fn overlap(&self, source: &[FaceId], set: &[FaceId]) -> f64 {
        let [both, first, second] = self.common(source, set);
        let all = first + second - both;
        if all > 0.0 { both / all } else { 1.0 }
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

/// The shares of one face of the garment while they are counted.
struct Tally {
    shares: Vec<Share>,
    /// The place of each face of the simulation mesh in the shares; of those that have none, anything.
    place: IdVec<FaceId, u32>,
    /// Samples that are being located.
    points: Vec<Vec3A>,
}

impl Tally {
    fn new(faces: usize) -> Self {
        Self { shares: Vec::new(), place: IdVec::filled(0, faces), points: Vec::new() }
    }

    fn add(&mut self, face: FaceId, area: f32) {
        match self.shares.get_mut(self.place[face] as usize) {
            Some(share) if share.face == face => share.area += area,
            _ => {
                self.place[face] = self.shares.len() as u32;
                self.shares.push(Share { face, area });
            }
        }
    }

    /// The shares, ascending; none are left.
    fn take(&mut self) -> Vec<Share> {
        self.shares.sort_unstable_by_key(|s| s.face);
        self.shares.drain(..).collect()
    }
}

/// The samples of each triangle of the baseline: numbered in one low-discrepancy sequence, the number of each triangle
/// in proportion to its area in terms of the target length.
struct Plan {
    /// The number of the first sample of each triangle, and one past its last.
    numbers: IdVec<FaceId, [u64; 2]>,
    /// The area of each triangle. \[square stage units\]
    area: IdVec<FaceId, f32>,
    /// The area that one sample of each triangle stands for. \[square stage units\]
    sample_area: IdVec<FaceId, f32>,
    /// Where the sequence begins.
    shift: [u64; 2],
}

impl Plan {
    fn new(product: &SimProduct, children: &Csr<FaceId, FaceId>, options: &SimOptions) -> Self {
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
        for &face in children.items() {
            let first = sum as u64;
            let own = f64::from(area[face.index()]) / f64::from(sample_area[face.index()]);
            sum += if own.is_finite() { own } else { 0.0 };
            numbers[face] = [first, sum as u64];
        }
        Self { numbers, area: area.into(), sample_area: sample_area.into(), shift }
    }

    fn samples(&self) -> u64 {
        self.numbers.iter().map(|[first, end]| end - first).sum()
    }

    /// Locates the samples of a triangle.
    fn sample(&self, locator: &Locator<'_>, face: FaceId, tally: &mut Tally) {
        let [first, end] = self.numbers[face];
        if first == end {
            return;
        }
        let Some(mut near) = locator.near(face) else { return };
        let (area, [a, b, c]) = (self.sample_area[face], near.corners);
        let mut points = std::mem::take(&mut tally.points);
        points.extend((first..end).map(|number| {
            let weights = self.weights(number);
            a * weights.x + b * weights.y + c * weights.z
        }));
        locator.count(&mut near, &mut points, |face, count| tally.add(face, count as f32 * area));
        tally.points = points;
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
