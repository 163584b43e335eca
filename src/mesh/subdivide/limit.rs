//! Limit positions of a cage's vertices under Catmull-Clark, as weighted sums of its vertices.
//!
//! Smooth vertices use the limit mask of Halstead, Kass and DeRose 1993. It holds where all faces at the vertex are
//! quads; at other vertices it is applied to the first refinement. Semi-sharp vertices have the limits of the refinement at
//! which they are sharp no more. Under the bilinear, polygonal and Loop schemes each vertex is its own limit.

use super::{INFINITE_SHARPNESS, Level, Numbering, Rule, Spoke, Stencils, Table, VertexStencils};
use crate::connectivity::{FaceId, VertexId};
use crate::garment::{Scheme, TriangleRule};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

impl Level {
    /// Limit position of each vertex, as a weighted sum of the level's vertices.
    pub fn limit_rows(&self) -> Table<VertexId> {
        let (refined, count) = (self.vertex_stencils(), self.topology.vertex_count());
        let known = semi_sharp_rows(self, &semi_sharp(self));
        let vertices = (0..count).into_par_iter().map(VertexId::new);
        let last = || vec![0; count];
        Table::of(vertices, last, |table, last, v| match known.get(&v) {
            Some(row) => table.push(row.iter().copied()),
            None => limit_row(self, &refined, v, &mut Rows { table, last }),
        })
    }
}

/// Positions as weighted sums of vertices.
type KnownRows = BTreeMap<VertexId, Vec<(VertexId, f32)>>;

/// The vertices whose rule is another one after some refinements.
fn semi_sharp(level: &Level) -> BTreeSet<VertexId> {
    if matches!(level.scheme, Scheme::Bilinear | Scheme::None | Scheme::Loop) {
        return BTreeSet::new();
    }
    let is_finite = |sharpness: f32| sharpness > 0.0 && sharpness < INFINITE_SHARPNESS;
    let edges = level.edge_sharpness.enumerated().filter(|(_, s)| is_finite(**s));
    let vertices = level.vertex_sharpness.enumerated().filter(|(_, s)| is_finite(**s)).map(|(v, _)| v);
    edges.flat_map(|(edge, _)| level.topology.edges[edge]).chain(vertices).collect()
}

/// The limits of some vertices by those of their children alone, which are less sharp.
fn semi_sharp_rows(level: &Level, vertices: &BTreeSet<VertexId>) -> KnownRows {
    if vertices.is_empty() {
        return KnownRows::new();
    }
    let faces: BTreeSet<FaceId> = vertices.iter().flat_map(|&v| level.topology.faces_at(v)).collect();
    let (part, whole) = level.part(&faces.into_iter().collect::<Vec<_>>());
    let (child, stencils) = (part.refined(), part.vertex_stencils());
    // A child has its parent's number.
    let children: Vec<VertexId> =
        whole.enumerated().filter(|(_, v)| vertices.contains(v)).map(|(own, _)| own).collect();
    let still_sharp = semi_sharp(&child);
    let known = semi_sharp_rows(&child, &children.iter().copied().filter(|v| still_sharp.contains(v)).collect());
    let (refined, mut last) = (child.vertex_stencils(), vec![0; child.topology.vertex_count()]);
    let row = |own: VertexId| {
        let mut table = Table::default();
        match known.get(&own) {
            Some(row) => table.push(row.iter().copied()),
            None => limit_row(&child, &refined, own, &mut Rows { table: &mut table, last: &mut last }),
        }
        let mut sum: BTreeMap<VertexId, f32> = BTreeMap::new();
        for &(source, weight) in table.at(0) {
            stencils.row(source.index(), &mut |v, share| *sum.entry(whole[v]).or_default() += weight * share);
        }
        (whole[own], sum.into_iter().collect())
    };
    children.into_iter().map(row).collect()
}

/// Builds rows in which each source appears once.
struct Rows<'a> {
    table: &'a mut Table<VertexId>,
    /// For each vertex, the table entry that was last added for it. It may belong to an earlier row or table.
    last: &'a mut [u32],
}

impl Rows<'_> {
    fn add(&mut self, vertex: VertexId, weight: f32) {
        let last = &mut self.last[vertex.index()];
        *last = self.table.add(vertex, weight, *last);
    }
}

fn limit_row(level: &Level, refined: &VertexStencils, vertex: VertexId, rows: &mut Rows) {
    let linear = matches!(level.scheme, Scheme::Bilinear | Scheme::None | Scheme::Loop);
    if linear || level.topology.vertex_corners.row(vertex).is_empty() {
        return rows.table.push([(vertex, 1.0)]);
    }
    rows.table.push([]);
    let mut sink = |v: VertexId, weight: f32| rows.add(v, weight);
    if level.rules[vertex] == Rule::Smooth {
        return smooth_row(level, refined, vertex, 1.0, &mut sink);
    }
    let mut spokes: Vec<Spoke> = Vec::new();
    level.spokes(vertex, &mut spokes);
    let sharp: Vec<&Spoke> = spokes.iter().filter(|s| level.edge_sharpness[s.edge] > 0.0).collect();
    match *sharp {
        _ if level.vertex_sharpness[vertex] > 0.0 => sink(vertex, 1.0),
        [] | [_] => smooth_row(level, refined, vertex, 1.0, &mut sink),
        [a, b] => {
            sink(vertex, 2.0 / 3.0);
            [a, b].into_iter().for_each(|s| sink(level.topology.faces.vertex(s.far), 1.0 / 6.0));
        }
        _ => sink(vertex, 1.0),
    }
}

/// Emits the smooth limit mask of a vertex, times `scale`. Away from all-quad and smooth Catmull-Clark neighbourhoods
/// it goes through the stencils of the first refinement.
fn smooth_row(
    level: &Level,
    refined: &VertexStencils,
    vertex: VertexId,
    scale: f32,
    sink: &mut impl FnMut(VertexId, f32),
) {
    let t = &level.topology;
    let corners = t.vertex_corners.row(vertex);
    let n = corners.len() as f32;
    let unit = scale / (n * (n + 5.0));
    if corners.iter().all(|&c| t.faces.valence(t.faces.face_of(c)) == 4) {
        sink(vertex, n * n * unit);
        for &corner in corners {
            sink(t.faces.vertex(t.faces.ahead(corner, 1)), 4.0 * unit);
            sink(t.faces.vertex(t.faces.ahead(corner, 2)), unit);
        }
        return;
    }
    if level.rules[vertex] == Rule::Smooth && level.triangles == TriangleRule::CatmullClark {
        // The limit mask applied to the masks of the first refinement: the vertex, its edges' ends and its faces'
        // centres.
        sink(vertex, n * (n - 1.0) * unit);
        for &corner in corners {
            sink(t.faces.vertex(t.faces.next(corner)), 2.0 * unit);
            let around = t.faces.vertices_of(t.faces.face_of(corner));
            let share = 4.0 / around.len() as f32 * unit;
            around.iter().for_each(|&v| sink(v, share));
        }
        return;
    }
    let numbering = Numbering::new(level);
    let mut through = |child: VertexId, weight: f32| {
        refined.row(child.index(), &mut |source, share| sink(source, weight * share));
    };
    through(vertex, n * n * unit);
    for &corner in corners {
        through(numbering.of_edge(t.corner_edge[corner]), 4.0 * unit);
        through(numbering.of_face(t.faces.face_of(corner)), unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connectivity::{FaceId, Faces, IdVec};
    use crate::garment::Mesh;
    use crate::subdivide::carried_points;
    use glam::Vec3;

    /// A triangle, two quads and a pentagon around vertex 0, with quads and a triangle around them.
    fn fan() -> Mesh {
        let faces: [&[usize]; 9] = [
            &[0, 1, 2],
            &[0, 2, 3, 4],
            &[0, 4, 5, 6],
            &[0, 6, 7, 8, 1],
            &[1, 8, 9],
            &[1, 9, 10, 2],
            &[2, 10, 11, 3],
            &[4, 3, 11, 12, 5],
            &[6, 5, 12, 7],
        ];
        let at = |i: usize| {
            let angle = if i < 9 { i as f32 * 0.785 } else { i as f32 * 1.57 };
            let radius = [0.0, 1.0, 2.2][usize::from(i > 0) + usize::from(i >= 9)];
            Vec3::new(radius * angle.cos(), radius * angle.sin(), (i as f32 * 1.3).sin())
        };
        let corners: Vec<VertexId> = faces.concat().into_iter().map(VertexId::new).collect();
        let faces = Faces::mixed(faces.map(<[usize]>::len), corners);
        Mesh { faces, points: (0..13).map(at).collect(), ..Mesh::default() }
    }

    #[test]
    fn limits_are_where_those_of_the_refinement_are() {
        let garment = fan();
        let level = Level::base(&garment);
        let limits = |level: &Level, points: &IdVec<VertexId, Vec3>| carried_points(&&level.limit_rows(), points);
        let coarse = limits(&level, &garment.points);
        let fine = limits(&level.refined(), &carried_points(&level.vertex_stencils(), &garment.points));
        for (vertex, limit) in coarse.enumerated() {
            let off = limit.distance(fine[vertex]);
            assert!(off < 1e-5, "vertex {vertex:?} is {off} off");
        }
        let is_mixed = |f: FaceId| garment.faces.valence(f) != 4;
        assert!(level.rules[VertexId::new(0)] == Rule::Smooth && garment.faces.ids().any(is_mixed));
    }
}
