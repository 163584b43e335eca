//! The connectivity of a cage with the masks that follow from it alone, so that cages with other points and other values
//! may have them in common.

use super::stencil::{Stencils, Table};
use super::{Level, VertexStencils};
use crate::garment::Garment;
use crate::mesh::VertexId;
use rayon::prelude::*;
use std::hash::Hash;
use std::sync::Arc;
use twox_hash::xxhash3_128;

/// What the connectivity of a garment depends on, as a number. Two that differ have the same by a chance of about 2^-128.
pub type Fingerprint = u128;

/// A cage's connectivity with its masks.
pub struct Connectivity {
    level: Arc<Level>,
    /// The masks of its refinement, where it costs more to compute them again.
    refined: Option<KeptRows>,
    limits: Table<VertexId>,
}

impl Connectivity {
    /// A level with its masks.
    pub fn new(level: Arc<Level>) -> Self {
        let is_regular = level.topology.faces.regular_valence().is_some();
        let kept = || (!is_regular).then(|| KeptRows::new(&level.vertex_stencils()));
        let (refined, limits) = rayon::join(kept, || level.limit_rows());
        Self { level, refined, limits }
    }

    /// The level.
    pub fn level(&self) -> &Level {
        &self.level
    }

    /// The vertices of the refinement from those of the level.
    pub fn vertex_rows(&self) -> VertexRows<'_> {
        self.refined.as_ref().map_or_else(|| self.level.vertex_rows(), VertexRows::Kept)
    }

    /// Limit positions of the vertices, as weighted sums of them.
    pub fn limits(&self) -> &Table<VertexId> {
        &self.limits
    }
}

impl Level {
    /// The vertices of the refinement from those of the level.
    pub fn vertex_rows(&self) -> VertexRows<'_> {
        VertexRows::Masks(self.vertex_stencils())
    }

    /// The fingerprint of the unrefined level of a garment.
    pub fn fingerprint(garment: &Garment) -> Fingerprint {
        // All that [`Level::base`] reads.
        let (faces, rules, mut hasher) = (&garment.faces, garment.rules, Hasher::default());
        hasher.add((rules.scheme, rules.boundary, rules.triangles, garment.points.len()));
        hasher.add(faces.regular_valence());
        if faces.regular_valence().is_none() {
            faces.ids().for_each(|face| hasher.add(faces.valence(face)));
        }
        hasher.add_all(faces.corners().as_slice());
        hasher.add(garment.creases.len());
        for crease in &garment.creases {
            hasher.add_all(&crease.vertices);
            hasher.add_all(&crease.sharpnesses);
        }
        garment.corners.iter().for_each(|corner| hasher.add((corner.vertex, corner.sharpness.to_bits())));
        hasher.finish()
    }
}

/// Makes fingerprints.
#[derive(Default)]
pub(super) struct Hasher(xxhash3_128::Hasher);

impl Hasher {
    pub(super) fn add(&mut self, value: impl Hash) {
        value.hash(self);
    }

    /// Adds numbers of which all bits count, all at once.
    pub(super) fn add_all<T: bytemuck::NoUninit>(&mut self, values: &[T]) {
        self.add(values.len());
        self.0.write(bytemuck::cast_slice(values));
    }

    pub(super) fn finish(&self) -> Fingerprint {
        self.0.finish_128()
    }
}

impl std::hash::Hasher for Hasher {
    fn finish(&self) -> u64 {
        self.0.finish_128() as u64
    }

    fn write(&mut self, bytes: &[u8]) {
        self.0.write(bytes);
    }
}

/// Child vertices from a cage's.
pub enum VertexRows<'a> {
    /// Computed when they are asked for.
    Masks(VertexStencils<'a>),
    /// Computed before.
    Kept(&'a KeptRows),
}

/// Rows that were computed before, so many to a table.
pub struct KeptRows {
    tables: Vec<Table<VertexId>>,
    rows: usize,
}

/// Rows of a table.
const BLOCK: usize = 4096;
/// Sources of a row for which there is room at first.
const SOURCES: usize = 12;

impl KeptRows {
    fn new(masks: &VertexStencils) -> Self {
        let rows = masks.rows();
        let table = |block: usize| {
            let mut table = Table::with_capacity(BLOCK, SOURCES * BLOCK);
            for row in block * BLOCK..rows.min((block + 1) * BLOCK) {
                masks.row(row, &mut |vertex, weight| table.extend_row(vertex, weight));
                table.push([]);
            }
            table
        };
        Self { tables: (0..rows.div_ceil(BLOCK)).into_par_iter().map(table).collect(), rows }
    }
}

impl Stencils for VertexRows<'_> {
    type Source = VertexId;

    fn rows(&self) -> usize {
        match self {
            Self::Masks(masks) => masks.rows(),
            Self::Kept(kept) => kept.rows,
        }
    }

    #[inline(always)]
    fn row(&self, row: usize, sink: &mut impl FnMut(VertexId, f32)) {
        match self {
            Self::Masks(masks) => masks.row(row, sink),
            Self::Kept(kept) => {
                let row = kept.tables[row / BLOCK].at(row % BLOCK);
                row.iter().for_each(|&(vertex, weight)| sink(vertex, weight));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::garment::{BoundaryInterpolation, Corner, Crease, Scheme, TriangleRule};
    use crate::mesh::{Faces, IdVec};
    use crate::subdivide::carried_points;
    use glam::Vec3;

    fn ids(all: &[usize]) -> Vec<VertexId> {
        all.iter().copied().map(VertexId::new).collect()
    }

    /// A quad and a triangle.
    fn garment() -> Garment {
        Garment {
            points: IdVec::filled(Vec3::ZERO, 5),
            faces: Faces::mixed([4, 3], ids(&[0, 1, 2, 3, 1, 4, 2])),
            creases: vec![Crease { vertices: ids(&[1, 2]), sharpnesses: vec![2.0] }],
            corners: vec![Corner { vertex: VertexId::new(0), sharpness: 1.0 }],
            ..Garment::default()
        }
    }

    #[test]
    fn a_fingerprint_is_that_of_all_that_a_level_depends_on() {
        let changes: [fn(&mut Garment); 11] = [
            |g| _ = g.points.push(Vec3::ZERO),
            |g| g.faces = Faces::mixed([4, 3], ids(&[0, 1, 2, 3, 4, 2, 1])),
            |g| g.faces = Faces::mixed([3, 4], ids(&[0, 1, 2, 3, 1, 4, 2])),
            |g| g.faces = Faces::quads(ids(&[0, 1, 2, 3])),
            |g| g.creases[0].vertices = ids(&[1, 0]),
            |g| g.creases[0].sharpnesses[0] = 2.5,
            |g| g.corners[0].vertex = VertexId::new(1),
            |g| g.corners[0].sharpness = 1.5,
            |g| g.rules.scheme = Scheme::Bilinear,
            |g| g.rules.boundary = BoundaryInterpolation::EdgeOnly,
            |g| g.rules.triangles = TriangleRule::Smooth,
        ];
        let first = Level::fingerprint(&garment());
        let mut known = vec![first];
        for change in changes {
            let mut changed = garment();
            change(&mut changed);
            known.push(Level::fingerprint(&changed));
        }
        known.sort_unstable();
        known.dedup();
        assert_eq!(known.len(), changes.len() + 1);
        let moved = Garment { points: IdVec::filled(Vec3::ONE, 5), ..garment() };
        assert_eq!(Level::fingerprint(&moved), first, "where the points are does not matter");
    }

    #[test]
    fn kept_masks_are_those_of_the_level() {
        let garment = garment();
        let level = Arc::new(Level::base(&garment));
        let points = (0..5).map(|i| Vec3::new(i as f32, (i * i) as f32, 1.0)).collect();
        let connectivity = Connectivity::new(Arc::clone(&level));
        assert!(matches!(connectivity.vertex_rows(), VertexRows::Kept(_)), "faces differ");
        assert_eq!(carried_points(&connectivity.vertex_rows(), &points), carried_points(&level.vertex_rows(), &points));
        let quad = Garment { faces: Faces::quads(ids(&[0, 1, 2, 3])), ..Garment::default() };
        let quad = Garment { points: IdVec::filled(Vec3::ZERO, 4), ..quad };
        assert!(matches!(Connectivity::new(Arc::new(Level::base(&quad))).vertex_rows(), VertexRows::Masks(_)));
    }
}
