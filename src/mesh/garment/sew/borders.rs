//! Border edges, and which of different meshes coincide.

use crate::garment::Garment;
use glam::{DMat4, DVec3};

/// Border edges near one edge that are looked at. A garment has a handful; copies of a mesh on each other have more.
const CROWD: usize = 4096;

/// An edge of one face.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Its points, the lower one first.
    pub points: [usize; 2],
    /// Whether its face runs from the first point to the second.
    pub forward: bool,
    /// Where they are in the common space.
    pub ends: [DVec3; 2],
}

impl Edge {
    pub fn middle(&self) -> DVec3 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    pub fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

/// The border of a mesh.
#[derive(Clone, Debug)]
pub struct Border {
    /// Its edges, sorted by their points.
    pub edges: Vec<Edge>,
    /// Mean length of all edges of the mesh. \[units of the common space\]
    pub mean_edge: f64,
}

/// Two edges that coincide.
#[derive(Clone, Copy, Debug)]
pub struct Match {
    /// The edges, as mesh and edge of its border.
    pub edges: [(usize, usize); 2],
    /// Whether the first point of one is at the second of the other.
    pub reversed: bool,
    /// The larger distance of their ends.
    pub gap: f64,
}

impl Match {
    /// The pairs of points that are one, each as mesh and point.
    pub fn welds(&self, borders: &[Border]) -> [[(usize, usize); 2]; 2] {
        let [a, b] = self.edges.map(|(panel, edge)| borders[panel].edges[edge].points.map(|point| (panel, point)));
        if self.reversed { [[a[0], b[1]], [a[1], b[0]]] } else { [[a[0], b[0]], [a[1], b[1]]] }
    }
}

impl Border {
    /// The border of `mesh`, which `to_common` takes to the common space.
    pub fn of(mesh: &Garment, to_common: &DMat4) -> Self {
        let points: Vec<DVec3> = mesh.points.iter().map(|p| to_common.transform_point3(p.as_dvec3())).collect();
        let all = half_edges(mesh);
        let (mut edges, mut length, mut count) = (Vec::new(), 0.0, 0);
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            let (of_edge, forward) = same[0];
            let edge = Edge { points: of_edge, forward, ends: of_edge.map(|p| points[p]) };
            (length, count) = (length + edge.length(), count + 1);
            if same.len() == 1 {
                edges.push(edge);
            }
        }
        Self { edges, mean_edge: length / f64::from(count.max(1)) }
    }

    /// The distance at which its points coincide with others.
    pub fn within(&self, tolerance: f64) -> f64 {
        tolerance * self.mean_edge
    }
}

/// The edges of each face of a mesh, sorted: their points, the lower one first, and whether the face runs along them so.
fn half_edges(mesh: &Garment) -> Vec<([usize; 2], bool)> {
    let mut all = Vec::with_capacity(mesh.face_vertex_indices.len());
    let mut corners = mesh.face_vertex_indices.as_slice();
    for &count in &mesh.face_vertex_counts {
        let Some((face, rest)) = corners.split_at_checked(count as usize) else { break };
        corners = rest;
        let ends = face.iter().zip(face.iter().cycle().skip(1));
        all.extend(ends.map(|(&a, &b)| ([a.min(b) as usize, a.max(b) as usize], a < b)));
    }
    all.sort_unstable();
    all
}

/// The points of the edges of a mesh, the lower one first, sorted.
pub fn edges(mesh: &Garment) -> Vec<[usize; 2]> {
    let mut edges: Vec<[usize; 2]> = half_edges(mesh).into_iter().map(|(points, _)| points).collect();
    edges.dedup();
    edges
}

/// The points of the border of a mesh, ascending.
pub fn border_points(mesh: &Garment) -> Vec<usize> {
    let all = half_edges(mesh);
    let borders = all.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    let mut points: Vec<usize> = borders.flat_map(|border| border[0].0).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// The pairs of border edges that are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pairs {
    /// Of different meshes.
    Between,
    /// Of one mesh.
    Within,
}

impl Pairs {
    /// Whether a pair is one of them, each pair in one order.
    fn has(self, [(panel, i), (with, j)]: [(usize, usize); 2]) -> bool {
        match self {
            Self::Between => with > panel,
            Self::Within => with == panel && j > i,
        }
    }
}

/// The pairs of border edges whose ends coincide, sorted. Edges too short for their ends to be distinguished
/// match none.
///
/// # Errors
/// The number of a mesh one edge of which has too many others beside it.
pub fn matches(borders: &[Border], tolerance: f64, pairs: Pairs) -> Result<Vec<Match>, usize> {
    let within: Vec<f64> = borders.iter().map(|border| border.within(tolerance)).collect();
    let largest_edge = borders.iter().map(|border| border.mean_edge).fold(0.0, f64::max);
    // Midpoints of edges that match are within the tolerance of each other, which no cell is smaller than.
    let cell = (2.0 * tolerance * largest_edge).max(1e-6 * largest_edge);
    if cell == 0.0 {
        return Ok(Vec::new());
    }
    let key = |p: DVec3| (p / cell).floor().to_array().map(|x| x as i64);
    let mut grid = Vec::new();
    for (panel, border) in borders.iter().enumerate() {
        let usable = border.edges.iter().enumerate().filter(|(_, edge)| edge.length() > 2.0 * within[panel]);
        grid.extend(usable.map(|(i, edge)| (key(edge.middle()), panel, i)));
    }
    grid.sort_unstable();
    let mut found = Vec::new();
    for &(at, panel, i) in &grid {
        let edge = &borders[panel].edges[i];
        let mut seen = 0;
        for &(_, with, j) in near(&grid, at).filter(|(_, with, j)| pairs.has([(panel, i), (*with, *j)])) {
            seen += 1;
            if seen > CROWD {
                return Err(panel);
            }
            let near = within[panel].min(within[with]);
            if let Some((reversed, gap)) = coincide(edge, &borders[with].edges[j], near) {
                found.push(Match { edges: [(panel, i), (with, j)], reversed, gap });
            }
        }
    }
    found.sort_unstable_by_key(|pair| pair.edges);
    Ok(found)
}

/// The entries of a sorted grid in a cell and those around it.
fn near(grid: &[([i64; 3], usize, usize)], [x, y, z]: [i64; 3]) -> impl Iterator<Item = &([i64; 3], usize, usize)> {
    let columns = (-1..=1).flat_map(move |i| (-1..=1).map(move |j| (x.saturating_add(i), y.saturating_add(j))));
    columns.flat_map(move |(x, y)| {
        let first = grid.partition_point(|(key, ..)| *key < [x, y, z.saturating_sub(1)]);
        grid[first..].iter().take_while(move |(key, ..)| *key <= [x, y, z.saturating_add(1)])
    })
}

/// Whether the ends of two edges coincide, in which order, and how far apart they are.
fn coincide(a: &Edge, b: &Edge, within: f64) -> Option<(bool, f64)> {
    let gap = |ends: [DVec3; 2]| a.ends[0].distance(ends[0]).max(a.ends[1].distance(ends[1]));
    let gaps = [gap(b.ends), gap([b.ends[1], b.ends[0]])];
    let (reversed, gap) = if gaps[1] < gaps[0] { (true, gaps[1]) } else { (false, gaps[0]) };
    (gap <= within).then_some((reversed, gap))
}
