//! Searches in space.

use crate::mesh::{IdVec, VertexId};
use glam::{IVec3, Vec3};
use std::collections::HashMap;

/// Points in the cells of a regular grid.
pub struct PointGrid {
    low: Vec3,
    cell: f32,
    cells: HashMap<IVec3, Vec<VertexId>>,
    /// Cells along the longest side.
    extent: i32,
}

impl PointGrid {
    /// A grid of about one point a cell, for points that lie on a surface.
    pub fn new(points: &IdVec<VertexId, Vec3>) -> Self {
        let (low, high) = points.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
        let size = (high - low).max_element().max(f32::MIN_POSITIVE);
        let extent = (points.len() as f32).sqrt().ceil().max(1.0);
        let cell = size / extent;
        let mut cells: HashMap<IVec3, Vec<VertexId>> = HashMap::with_capacity(points.len());
        for (id, &p) in points.enumerated() {
            cells.entry(((p - low) / cell).floor().as_ivec3()).or_default().push(id);
        }
        Self { low, cell, cells, extent: extent as i32 }
    }

    /// The point nearest to `position`, the lowest of equals; none if there are no points.
    pub fn nearest(&self, points: &IdVec<VertexId, Vec3>, position: Vec3) -> Option<VertexId> {
        let centre = ((position - self.low) / self.cell).floor().as_ivec3();
        let mut best: Option<(f32, VertexId)> = None;
        // A search from outside the grid begins at the ring that first touches it.
        let outside = (centre - centre.clamp(IVec3::ZERO, IVec3::splat(self.extent))).abs().max_element();
        for ring in outside..=outside + self.extent + 1 {
            self.visit_ring(centre, ring, |id| {
                let candidate = (points[id].distance_squared(position), id);
                if best.is_none_or(|b| candidate.0 < b.0 || candidate.0 == b.0 && candidate.1.index() < b.1.index()) {
                    best = Some(candidate);
                }
            });
            // Cells of the next ring are at least this far.
            let reach = ring as f32 * self.cell;
            if best.is_some_and(|b| b.0 <= reach * reach) {
                break;
            }
        }
        best.map(|b| b.1)
    }

    fn visit_ring(&self, centre: IVec3, ring: i32, mut visit: impl FnMut(VertexId)) {
        for z in -ring..=ring {
            for y in -ring..=ring {
                let inner = z.abs() < ring && y.abs() < ring;
                let step = if inner { (2 * ring).max(1) } else { 1 };
                for x in (-ring..=ring).step_by(step as usize) {
                    if let Some(ids) = self.cells.get(&(centre + IVec3::new(x, y, z))) {
                        ids.iter().copied().for_each(&mut visit);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_agrees_with_a_search_through_all() {
        let at = |i: usize| Vec3::new((i * 37 % 101) as f32, (i * 53 % 89) as f32, (i * 71 % 97) as f32);
        let points: IdVec<VertexId, Vec3> = (0..500).map(at).collect();
        let grid = PointGrid::new(&points);
        for i in 0..300 {
            let p = at(i * 7 + 3) * 1.3 - 20.0;
            let best = points.ids().min_by(|a, b| {
                points[*a].distance_squared(p).total_cmp(&points[*b].distance_squared(p)).then(a.cmp(b))
            });
            assert_eq!(grid.nearest(&points, p), best);
        }
    }
}
