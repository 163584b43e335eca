//! The connectivity of a cage and the masks that depend on it alone.
//!
//! Garments that differ only in points or primvar values share one [`Connectivity`].

use super::stencil::{Stencils, Table};
use super::{Level, VertexStencils};
use crate::connectivity::VertexId;
use rayon::prelude::*;
use std::sync::Arc;

/// A cage's connectivity with its masks.
pub struct Connectivity {
    level: Arc<Level>,
    /// Stored masks of the refinement. `None` for meshes of one valence, whose masks cost less to compute than to read.
    refined: Option<KeptRows>,
    limits: Table<VertexId>,
}

impl Connectivity {
    /// Computes the masks of a level.
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

    /// Stencils of the refined vertices over the level's vertices.
    pub fn vertex_rows(&self) -> VertexRows<'_> {
        self.refined.as_ref().map_or_else(|| self.level.vertex_rows(), VertexRows::Kept)
    }

    /// Limit position of each vertex, as a weighted sum of the level's vertices.
    pub fn limits(&self) -> &Table<VertexId> {
        &self.limits
    }
}

impl Level {
    /// Stencils of the refined vertices over the level's vertices.
    pub fn vertex_rows(&self) -> VertexRows<'_> {
        VertexRows::Masks(self.vertex_stencils())
    }
}

/// Stencils of child vertices, computed or stored.
pub enum VertexRows<'a> {
    /// Computes each row on demand.
    Masks(VertexStencils<'a>),
    /// Reads stored rows.
    Kept(&'a KeptRows),
}

/// Stored stencil rows, in blocks that are built in parallel.
pub struct KeptRows {
    tables: Vec<Table<VertexId>>,
    rows: usize,
}

/// Rows of one table.
const BLOCK: usize = 4096;
/// Expected sources of a row, to reserve memory.
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
    use crate::connectivity::{Faces, IdVec};
    use crate::garment::{Corner, Crease, Mesh};
    use crate::subdivide::carried_points;
    use glam::Vec3;

    fn ids(all: &[usize]) -> Vec<VertexId> {
        all.iter().copied().map(VertexId::new).collect()
    }

    /// A quad and a triangle.
    fn garment() -> Mesh {
        Mesh {
            points: IdVec::filled(Vec3::ZERO, 5),
            faces: Faces::mixed([4, 3], ids(&[0, 1, 2, 3, 1, 4, 2])),
            creases: vec![Crease { vertices: ids(&[1, 2]), sharpnesses: vec![2.0] }],
            corners: vec![Corner { vertex: VertexId::new(0), sharpness: 1.0 }],
            ..Mesh::default()
        }
    }

    #[test]
    fn kept_masks_are_those_of_the_level() {
        let garment = garment();
        let level = Arc::new(Level::base(&garment));
        let points = (0..5).map(|i| Vec3::new(i as f32, (i * i) as f32, 1.0)).collect();
        let connectivity = Connectivity::new(Arc::clone(&level));
        assert!(matches!(connectivity.vertex_rows(), VertexRows::Kept(_)), "faces differ");
        assert_eq!(carried_points(&connectivity.vertex_rows(), &points), carried_points(&level.vertex_rows(), &points));
        let quad = Mesh { faces: Faces::quads(ids(&[0, 1, 2, 3])), ..Mesh::default() };
        let quad = Mesh { points: IdVec::filled(Vec3::ZERO, 4), ..quad };
        assert!(matches!(Connectivity::new(Arc::new(Level::base(&quad))).vertex_rows(), VertexRows::Masks(_)));
    }
}
