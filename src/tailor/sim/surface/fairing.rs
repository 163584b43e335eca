//! Fair surfaces in place of details: between vertices that stay, points minimize the squared Laplacian (Botsch and Sorkine 2008,
//! *On Linear Variational Surface Deformation Methods*).

use glam::{DVec3, Vec3};
use tailor_mesh::connectivity::{FaceId, Groups, IdVec, Topology, VertexId};

/// Rounds in which edges get their weights from the points of the last round: more makes faces more even.
const ROUNDS: usize = 3;
/// Most steps of conjugate gradients in a round. They reach across as many edges, and leave the shape of larger areas.
const MAX_STEPS: usize = 400;
/// The squared residual at which a round ends, as a share of the first.
const RESIDUAL: f64 = 1e-12;
/// The shortest edge that counts, as a share of the mean.
const SHORTEST: f64 = 0.05;

/// The vertices of a mesh that move.
pub struct Fairing<'a> {
    topology: &'a Topology,
    /// Which vertices bound pieces of the surface: fair surfaces end there, and others go on beyond the vertices that stay.
    is_edge: &'a IdVec<VertexId, bool>,
    /// The index of each vertex that moves.
    index: IdVec<VertexId, Option<u32>>,
    moving: Vec<VertexId>,
}

/// The Laplacian of a vertex.
struct Row {
    /// Vertices that move with their weights.
    terms: Vec<(u32, f64)>,
    /// The part of those that stay.
    fixed: DVec3,
}

impl<'a> Fairing<'a> {
    /// Moves the vertices inside the faces of `is_inside` that are not edges. Pieces of them that touch no other vertex stay,
    /// because nothing says where they would go; returns the number of these pieces too.
    pub fn new(
        topology: &'a Topology,
        is_edge: &'a IdVec<VertexId, bool>,
        is_inside: impl Fn(FaceId) -> bool,
    ) -> (Self, usize) {
        let vertices = || is_edge.ids().filter(|&v| !topology.vertex_corners.row(v).is_empty());
        let is_inner = |v: &VertexId| !is_edge[*v] && topology.faces_at(*v).all(&is_inside);
        let mut index: IdVec<VertexId, Option<u32>> = IdVec::filled(None, is_edge.len());
        vertices().filter(is_inner).for_each(|v| index[v] = Some(0));
        let mut fairing = Self { topology, is_edge, index, moving: Vec::new() };
        let mut pieces = Groups::<VertexId>::new(is_edge.len());
        let mut is_held = IdVec::<VertexId, bool>::filled(false, is_edge.len());
        let moving: Vec<VertexId> = vertices().filter(|&v| fairing.index[v].is_some()).collect();
        for &vertex in &moving {
            fairing.neighbours(vertex).filter(|&v| fairing.index[v].is_some()).for_each(|v| _ = pieces.join(vertex, v));
        }
        for &vertex in &moving {
            let first = pieces.first(vertex);
            is_held[first] |= fairing.neighbours(vertex).any(|v| fairing.index[v].is_none());
        }
        let loose = moving.iter().filter(|&&v| pieces.first(v) == v && !is_held[v]).count();
        for vertex in moving {
            let stays = !is_held[pieces.first(vertex)];
            fairing.index[vertex] = if stays { None } else { Some(fairing.moving.len() as u32) };
            fairing.moving.extend((!stays).then_some(vertex));
        }
        (fairing, loose)
    }

    /// The neighbours of a vertex by edges; those across an edge of two faces twice.
    fn neighbours(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> {
        let faces = &self.topology.faces;
        let corners = self.topology.vertex_corners.row(vertex).iter();
        corners.flat_map(|&c| [faces.next(c), faces.prev(c)]).map(|c| faces.vertex(c))
    }

    /// Moves the points.
    pub fn apply(&self, points: &mut IdVec<VertexId, Vec3>) {
        for _ in 0..ROUNDS {
            let rows = self.rows(points);
            let mut moved: Vec<DVec3> = self.moving.iter().map(|&v| points[v].as_dvec3()).collect();
            minimize(&rows, &mut moved);
            for (&vertex, point) in self.moving.iter().zip(&moved) {
                // A system without a solution leaves what it was given.
                if point.is_finite() {
                    points[vertex] = point.as_vec3();
                }
            }
        }
    }

    /// The Laplacians of vertices that move and of those next to them.
    fn rows(&self, points: &IdVec<VertexId, Vec3>) -> Vec<Row> {
        let mut around: Vec<VertexId> = self.moving.iter().flat_map(|&v| self.neighbours(v)).collect();
        around.extend(&self.moving);
        around.sort_unstable();
        around.dedup();
        around.retain(|&v| !self.is_edge[v]);
        let length = |a: VertexId, b: VertexId| f64::from(points[a].distance(points[b]));
        let lengths = || self.moving.iter().flat_map(|&v| self.neighbours(v).map(move |w| length(v, w)));
        let mean = lengths().sum::<f64>() / lengths().count().max(1) as f64;
        let row = |v: VertexId| {
            let weight = |w| 1.0 / length(v, w).max(SHORTEST * mean).max(f64::MIN_POSITIVE);
            let sum: f64 = self.neighbours(v).map(weight).sum();
            let mut row = Row { terms: Vec::with_capacity(9), fixed: DVec3::ZERO };
            let parts = self.neighbours(v).map(|w| (w, weight(w) / sum)).chain([(v, -1.0)]);
            for (vertex, part) in parts {
                match self.index[vertex] {
                    Some(index) => row.terms.push((index, part)),
                    None => row.fixed += part * points[vertex].as_dvec3(),
                }
            }
            row
        };
        around.into_iter().map(row).collect()
    }
}

/// Minimizes the sum of the squared rows, by conjugate gradients on their normal equations.
fn minimize(rows: &[Row], x: &mut [DVec3]) {
    let count = x.len();
    let transposed = |values: &[DVec3]| {
        let mut sums = vec![DVec3::ZERO; count];
        for (row, &value) in rows.iter().zip(values) {
            row.terms.iter().for_each(|&(index, part)| sums[index as usize] += part * value);
        }
        sums
    };
    let product = |values: &[DVec3]| -> Vec<DVec3> {
        rows.iter().map(|row| row.terms.iter().map(|&(index, part)| part * values[index as usize]).sum()).collect()
    };
    let squared = |values: &[DVec3]| values.iter().map(|v| v.length_squared()).sum::<f64>();
    let start: Vec<DVec3> = product(x).iter().zip(rows).map(|(own, row)| -(*own + row.fixed)).collect();
    let mut residual = transposed(&start);
    let mut way = residual.clone();
    let mut left = squared(&residual);
    let least = RESIDUAL * left;
    for _ in 0..MAX_STEPS {
        if left <= least {
            break;
        }
        let image = product(&way);
        let step = left / squared(&image).max(f64::MIN_POSITIVE);
        x.iter_mut().zip(&way).for_each(|(x, way)| *x += step * *way);
        residual.iter_mut().zip(transposed(&image)).for_each(|(r, image)| *r -= step * image);
        let before = std::mem::replace(&mut left, squared(&residual));
        way.iter_mut().zip(&residual).for_each(|(way, r)| *way = *r + left / before * *way);
    }
}
