//! Areas that faces of the simulation mesh and of the garment have in common, by samples of the baseline. One pass
//! serves all sets and primvars. It keeps areas alone, so that memory is independent of the number of samples.

mod locator;
mod regions;
mod samples;

use super::topology::SimTopology;
use crate::sim::{SimOptions, SimProduct, closest_weights};
use glam::Vec3;
use rayon::prelude::*;
use samples::{AreaTally, SamplePlan};
use tailor_mesh::connectivity::{Csr, FaceId, IdVec};

pub(super) use locator::Locator;
pub(super) use regions::Regions;

/// Finds the triangle of a simulation mesh over a point of its baseline, on the same panel, layer and side.
pub struct TriangleLocator<'a> {
    product: &'a SimProduct,
    mesh: SimTopology,
    regions: Regions,
}

impl<'a> TriangleLocator<'a> {
    /// Places on `product`, whose garment has `source_faces` faces.
    pub fn new(product: &'a SimProduct, source_faces: usize) -> Self {
        let (mesh, regions) =
            rayon::join(|| SimTopology::new(product, source_faces), || Regions::new(&product.baseline));
        Self { product, mesh, regions }
    }

    /// Finds a place for each point: the triangle and the weights of its corners. A point is given with faces of the garment
    /// on or beside which it lies. `None` where the simulation mesh has no triangle in that region.
    pub fn find<'f>(
        &self,
        count: usize,
        point: impl Fn(usize) -> (Vec3, &'f [FaceId]) + Sync,
    ) -> Vec<Option<(FaceId, Vec3)>> {
        let locator = Locator::new(self.product, &self.mesh, &self.regions);
        let place = |i: usize| {
            let (point, faces) = point(i);
            let (face, weights) = self.closest(point, faces)?;
            locator.place(face, weights)
        };
        (0..count).into_par_iter().map(place).collect()
    }

    /// The closest point of the baseline within some faces of the garment.
    fn closest(&self, point: Vec3, faces: &[FaceId]) -> Option<(FaceId, Vec3)> {
        let triangles = faces.iter().flat_map(|&face| self.mesh.source_triangles.row(face));
        let near = triangles.map(|&triangle| {
            let [a, b, c] = self.product.baseline.triangle(triangle);
            let weights = closest_weights(a, b, c, point);
            let distance = (a * weights.x + b * weights.y + c * weights.z).distance_squared(point);
            (distance, triangle, weights)
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        Some((nearest.1, nearest.2))
    }
}

/// Area that one face covers of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredArea {
    /// The other face: the garment's for a face of the simulation mesh, and the reverse.
    pub face: FaceId,
    /// Area on the baseline, by the samples in it. \[square mesh units\]
    pub area: f32,
}

/// The areas that faces of the simulation mesh and faces of the garment have in common.
pub struct Coverage {
    /// For each face of the simulation mesh those of the garment, ascending.
    pub sources: Csr<FaceId, CoveredArea>,
    /// For each face of the garment those of the simulation mesh, ascending.
    pub faces: Csr<FaceId, CoveredArea>,
    /// Area on the baseline of each face of the garment. \[square mesh units\]
    pub source_area: IdVec<FaceId, f64>,
    /// Number of samples.
    pub samples: u64,
}

impl Coverage {
    /// Samples the baseline: `transferSamples` for each equilateral triangle of the target length. The garment has
    /// `source_faces` faces.
    pub fn new(product: &SimProduct, source_faces: usize, options: &SimOptions) -> Self {
        let mesh = SimTopology::new(product, source_faces);
        let regions = Regions::new(&product.baseline);
        Self::with_locator(product, &mesh, &Locator::new(product, &mesh, &regions), options)
    }

    /// [`Coverage::new`] with what locates points on the simulation mesh.
    pub(super) fn with_locator(
        product: &SimProduct,
        mesh: &SimTopology,
        locator: &Locator<'_>,
        options: &SimOptions,
    ) -> Self {
        let base = &product.baseline;
        let plan = SamplePlan::new(product, &mesh.source_triangles, options);
        let source_faces = mesh.source_triangles.rows();
        let buffers = || (Vec::new(), AreaTally::new(product.triangles.len()));
        let row = |(points, tally): &mut (Vec<_>, AreaTally), source| {
            let own = mesh.source_triangles.row(FaceId::new(source));
            own.iter().for_each(|&face| plan.sample(locator, face, points, tally));
            tally.take()
        };
        let rows: Vec<Vec<CoveredArea>> = (0..source_faces).into_par_iter().map_init(buffers, row).collect();
        let mut source_area = IdVec::filled(0.0, source_faces);
        for (&source, &area) in base.source_face.iter().zip(plan.area.iter()) {
            source_area[source] += f64::from(area);
        }
        let filler = CoveredArea { face: FaceId::new(0), area: 0.0 };
        let items = || rows.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |&c| (FaceId::new(i), c)));
        let faces = Csr::group(source_faces, items(), filler);
        let transposed = items().map(|(source, c)| (c.face, CoveredArea { face: source, ..c }));
        let sources = Csr::group(product.triangles.len(), transposed, filler);
        Self { sources, faces, source_area, samples: plan.count() }
    }

    /// Area inside both a set of the garment's faces and a set of faces of the simulation mesh, area of the first, and
    /// area of the second. \[square mesh units\]
    fn common(&self, source: &[FaceId], set: &[FaceId]) -> [f64; 3] {
        let mut is_in = IdVec::<FaceId, bool>::filled(false, self.faces.rows());
        source.iter().for_each(|&f| is_in[f] = true);
        let first = source.iter().flat_map(|&f| self.faces.row(f)).map(|s| f64::from(s.area)).sum();
        let covered = || set.iter().flat_map(|&f| self.sources.row(f));
        let both = covered().filter(|s| is_in[s.face]).map(|s| f64::from(s.area)).sum();
        [both, first, covered().map(|s| f64::from(s.area)).sum()]
    }

    /// Common area of a set of the garment's faces and a set of faces of the simulation mesh, as a share of their mean
    /// area (Dice 1945); 1 where both are empty.
    pub fn agreement(&self, source: &[FaceId], set: &[FaceId]) -> f64 {
        let [both, first, second] = self.common(source, set);
        if first + second > 0.0 { 2.0 * both / (first + second) } else { 1.0 }
    }

    /// Common area of such sets as a share of their union (Jaccard 1901); 1 where both are empty.
    pub fn overlap(&self, source: &[FaceId], set: &[FaceId]) -> f64 {
        let [both, first, second] = self.common(source, set);
        let all = first + second - both;
        if all > 0.0 { both / all } else { 1.0 }
    }
}
