//! Blocks: the grids of lines at junctions, where the lines of two marked edges cross.

use super::cuts::Cut;
use super::faces::LineBuilder;
use super::points::grid_point;
use super::{Crossing, LineVertex};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, VertexId};

impl LineBuilder<'_, '_> {
    /// Adds the vertices of a block. Those on its diagonal are the column of the mitre.
    pub(super) fn add_grid(&mut self, corner: CornerId, number: usize) {
        let t = self.request.topology;
        let Some([after, before]) = self.cuts.block(corner) else { return };
        let height = self.widths.heights[self.ribs.all[number].vertex];
        let (along, across) = (t.corner_edge[corner], t.corner_edge[t.faces.prev(corner)]);
        let mut grid = Vec::with_capacity(after.len() * before.len());
        for (i, &x) in after.iter().enumerate() {
            for (j, &y) in before.iter().enumerate() {
                let vertex = self.builder.vertex(&grid_point(t, corner, x, y));
                let crossing = Some(Crossing { line: i, mark: across });
                self.vertices.push(LineVertex { vertex, line: Some(j), mark: along, height, crossing });
                grid.push(vertex);
            }
        }
        let n = self.line_count();
        self.columns.push((0..n).map(|i| grid[i * n + i]).collect());
        self.grids.insert(corner, grid);
    }

    /// The corner of the block on a half-edge that has a cut, with the line of the cut.
    pub(super) fn grid_of(&self, half: CornerId, cut: &Cut) -> Option<(CornerId, usize)> {
        let t = self.request.topology;
        let block = cut.block?;
        let corner = if t.faces.vertex(half) == block.vertex { half } else { t.faces.next(half) };
        self.grids.contains_key(&corner).then_some((corner, block.line))
    }

    /// Adds the faces of the block at a corner of two marked edges of a junction.
    pub(super) fn add_grid_faces(&mut self, face: FaceId, corner: CornerId) {
        let (t, n) = (self.request.topology, self.line_count());
        let Some(grid) = self.grids.get(&corner).cloned() else { return };
        let prev = t.faces.prev(corner);
        let on = |half: CornerId| self.junction_cuts(t.corner_edge[half], t.faces.vertex(corner));
        let (after, before) = (on(corner), on(prev));
        let at = |i: usize, j: usize| match (i, j) {
            (0, 0) => t.faces.vertex(corner),
            (_, 0) => after[i - 1],
            (0, _) => before[j - 1],
            _ => grid[(i - 1) * n + j - 1],
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let mark = t.corner_edge[if j <= i { corner } else { prev }];
            self.strip_face(face, &[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], i.min(j), mark);
        }
    }

    /// The vertices of a block's lines on a marked edge, from the junction on.
    fn junction_cuts(&self, edge: EdgeId, vertex: VertexId) -> Vec<VertexId> {
        let mut cuts: Vec<(usize, VertexId)> = Vec::new();
        for (cut, &on_edge) in self.cuts.of(edge).iter().zip(&self.cut_vertices[&edge]) {
            cuts.extend(cut.block.filter(|block| block.vertex == vertex).map(|block| (block.line, on_edge)));
        }
        cuts.sort_unstable();
        cuts.into_iter().map(|(_, vertex)| vertex).collect()
    }
}
