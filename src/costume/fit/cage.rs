//! The edges, triangles and faces of a garment's cage.

use super::bodies::fans;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::iter::repeat_n;
use tailor_mesh::connectivity::{Elements, FaceId, Groups, Topology};
use tailor_mesh::garment::Mesh;

/// A cage as lists of vertices.
pub struct Cage {
    pub edges: Vec<[usize; 2]>,
    pub triangles: Vec<[usize; 3]>,
    /// The face of each triangle.
    pub face: Vec<usize>,
    /// The faces at each vertex.
    faces_at: Vec<Vec<usize>>,
}

impl Cage {
    pub fn new(mesh: &Mesh) -> Self {
        let topology = Topology::new(mesh.faces.clone(), mesh.points.len());
        let mut faces_at = vec![Vec::new(); mesh.points.len()];
        for face in mesh.faces.ids() {
            mesh.faces.vertices_of(face).iter().for_each(|v| faces_at[v.index()].push(face.index()));
        }
        let of_face = |face: FaceId| repeat_n(face.index(), mesh.faces.valence(face) - 2);
        Self {
            edges: topology.edges.iter().map(|ends| ends.map(|v| v.index())).collect(),
            triangles: fans(mesh),
            face: mesh.faces.ids().flat_map(of_face).collect(),
            faces_at,
        }
    }

    pub fn vertex_count(&self) -> usize {
        self.faces_at.len()
    }

    /// The faces that have all of some vertices.
    pub fn faces_of<'a>(&'a self, vertices: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
        let (first, others) =
            vertices.split_first().map_or((&[][..], vertices), |(v, rest)| (&self.faces_at[*v][..], rest));
        let has_all = move |face: &&usize| others.iter().all(|&v| self.faces_at[v].contains(face));
        first.iter().filter(has_all).copied()
    }

    /// The faces of two triangles, the lower one first.
    pub fn pair_of(&self, [a, b]: [usize; 2]) -> [usize; 2] {
        let [f, g] = [self.face[a], self.face[b]];
        [f.min(g), f.max(g)]
    }

    /// The mean length of the edges at each vertex.
    pub fn mean_edges(&self, points: &[DVec3]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0); points.len()];
        for &[a, b] in &self.edges {
            let length = points[a].distance(points[b]);
            [a, b].into_iter().for_each(|v| sums[v] = (sums[v].0 + length, sums[v].1 + 1));
        }
        sums.into_iter().map(|(sum, count)| sum / f64::from(count.max(1))).collect()
    }

    /// Whether each edge is in a set: one of its edges, a side of one of its faces, or between two of its points.
    pub fn edges_in(&self, set: &Elements) -> Vec<bool> {
        match set {
            Elements::Edges(all) => {
                let both = all.iter().map(|edge| edge.map(|v| v.index())).flat_map(|[a, b]| [[a, b], [b, a]]);
                let all: BTreeSet<[usize; 2]> = both.collect();
                self.edges.iter().map(|edge| all.contains(edge)).collect()
            }
            Elements::Faces(all) => {
                let all: BTreeSet<usize> = all.iter().map(|f| f.index()).collect();
                self.edges.iter().map(|edge| self.faces_of(edge).any(|f| all.contains(&f))).collect()
            }
            Elements::Points(all) => {
                let all: BTreeSet<usize> = all.iter().map(|v| v.index()).collect();
                self.edges.iter().map(|edge| edge.iter().all(|v| all.contains(v))).collect()
            }
        }
    }

    /// The parts that some of the edges connect, as their vertices.
    pub fn parts_of(&self, is_in: &[bool]) -> Vec<Vec<usize>> {
        let mut groups = Groups::<usize>::new(self.vertex_count());
        let joined: Vec<[usize; 2]> =
            self.edges.iter().zip(is_in).filter(|(_, is_in)| **is_in).map(|(edge, _)| *edge).collect();
        for &[a, b] in &joined {
            groups.join(a, b);
        }
        let mut parts = BTreeMap::<usize, BTreeSet<usize>>::new();
        for v in joined.into_iter().flatten() {
            parts.entry(groups.first(v)).or_default().insert(v);
        }
        parts.into_values().map(|part| part.into_iter().collect()).collect()
    }
}
