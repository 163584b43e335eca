//! Areas that faces of the simulation mesh and of the garment have in common, by samples of the baseline. One pass
//! serves all sets and primvars. It keeps areas alone, so that memory is independent of the number of samples.

mod locator;
mod regions;
mod samples;

use crate::sim::SimOptions;
use rayon::prelude::*;
use samples::{AreaTally, SamplePlan};
use tailor_mesh::connectivity::{Csr, FaceId, IdVec};

pub use locator::{Locator, LocatorTables};

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
    /// Samples the baseline of a simulation mesh: `transferSamples` for each equilateral triangle of the target length.
    pub fn new(locator: &Locator<'_>, options: &SimOptions) -> Self {
        let Locator { product, tables } = locator;
        let (base, mesh) = (&product.baseline, &tables.mesh);
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
