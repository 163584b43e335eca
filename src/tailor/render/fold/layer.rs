//! The faces of the second layer and of the hem that joins it to the first.

use super::ends::Ends;
use crate::render::lines::Lines;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{CornerId, Csr, EdgeId, FaceId, IdVec, Topology, VertexId};

/// The second layer.
pub struct Layer {
    /// The copy of each vertex, if any; the vertex itself where both layers share it.
    pub copy: Vec<Option<VertexId>>,
    /// Further copies on the surface, at the foot of walls, with their originals.
    pub feet: Vec<[VertexId; 2]>,
    /// The upper edges of walls, and their edges at square ends of folds.
    pub wall_edges: Vec<[VertexId; 2]>,
    /// The faces of the hem.
    pub hem: Vec<FaceId>,
    /// The faces of the layer.
    pub inner: Vec<FaceId>,
}

impl Layer {
    /// Copies the faces with reversed winding; the first corner stays first.
    pub fn new(t: &Topology, chosen: &IdVec<FaceId, bool>, ends: &Ends, lines: &mut Lines) -> Self {
        let mut layer = Self {
            copy: vec![None; lines.builder.vertex_count()],
            feet: Vec::new(),
            wall_edges: Vec::new(),
            hem: Vec::new(),
            inner: Vec::new(),
        };
        ends.joined.ids().filter(|&v| ends.joined[v]).for_each(|v| layer.copy[v.index()] = Some(v));
        for face in t.faces.ids().filter(|&f| chosen[f]) {
            for child in lines.first_child[face.index()]..lines.first_child[face.index() + 1] {
                let corners = lines.builder.corners_of(child);
                let mut copied: Vec<VertexId> = Vec::with_capacity(corners.len());
                for &corner in &corners {
                    copied.push(copy_of(&mut layer.copy, corner, lines));
                }
                copied[1..].reverse();
                layer.inner.push(lines.builder.face(face, &copied));
            }
        }
        layer
    }

    /// Adds the faces between the border and its copy. At the end of a fold they are triangles.
    pub fn add_hem(&mut self, t: &Topology, border: &[CornerId], lines: &mut Lines) {
        let children: Csr<EdgeId, [VertexId; 2]> = lines.builder.edges();
        for &half in border {
            let edge = t.corner_edge[half];
            let is_forward = t.faces.vertex(half) == t.edges[edge][0];
            for &[first, second] in children.row(edge) {
                let [a, b] = if is_forward { [first, second] } else { [second, first] };
                let [copy_a, copy_b] = [a, b].map(|v| copy_of(&mut self.copy, v, lines));
                let mut corners = vec![b, a, copy_a, copy_b];
                corners.dedup();
                corners.truncate(if copy_b == b { corners.len() - 1 } else { corners.len() });
                if corners.len() >= 3 {
                    self.hem.push(lines.builder.face(t.faces.face_of(half), &corners));
                }
            }
        }
    }

    /// Adds the walls of square ends, from the layer down to the surface. They share the vertex in which the fold ends with
    /// the surface, and have vertices of their own beyond.
    pub fn add_walls(&mut self, t: &Topology, chosen: &IdVec<FaceId, bool>, ends: &Ends, lines: &mut Lines) {
        let children: Csr<EdgeId, [VertexId; 2]> = lines.builder.edges();
        let mut feet: BTreeMap<VertexId, VertexId> = BTreeMap::new();
        for (end, _) in ends.square.enumerated().filter(|(_, is_square)| **is_square) {
            feet.insert(end, end);
            self.wall_edges.extend(self.copy[end.index()].map(|copy| [end, copy]));
        }
        for &edge in &ends.walls {
            let Some(&half) = t.edge_corners.row(edge).iter().find(|&&c| chosen[t.faces.face_of(c)]) else { continue };
            let is_forward = t.faces.vertex(half) == t.edges[edge][0];
            for &[first, second] in children.row(edge) {
                let [a, b] = if is_forward { [first, second] } else { [second, first] };
                let [Some(copy_a), Some(copy_b)] = [a, b].map(|v| self.copy[v.index()]) else { continue };
                let [foot_a, foot_b] = [a, b].map(|v| {
                    *feet.entry(v).or_insert_with(|| {
                        let sources = lines.builder.sources(v);
                        let foot = lines.builder.vertex(&sources);
                        self.feet.push([v, foot]);
                        foot
                    })
                });
                self.wall_edges.push([copy_a, copy_b]);
                self.hem.push(lines.builder.face(t.faces.face_of(half), &[foot_b, foot_a, copy_a, copy_b]));
            }
        }
    }

    /// Continues parent edges around the fold and back along the second layer, so that edge sets follow.
    pub fn add_edges(
        &self,
        t: &Topology,
        chosen: &IdVec<FaceId, bool>,
        folds: &IdVec<VertexId, bool>,
        lines: &mut Lines,
    ) {
        let children: Csr<EdgeId, [VertexId; 2]> = lines.builder.edges();
        let copy = |v: VertexId| self.copy[v.index()].unwrap_or(v);
        for edge in t.edges.ids() {
            let mut faces = t.edge_corners.row(edge).iter().map(|&c| t.faces.face_of(c));
            if !faces.any(|f| chosen[f]) {
                continue;
            }
            let ([a, b], is_interior) = (t.edges[edge], !t.is_border(edge));
            if is_interior && folds[b] && copy(b) != b {
                lines.builder.edge(edge, [b, copy(b)]);
            }
            for &[from, to] in children.row(edge).iter().rev() {
                lines.builder.edge(edge, [copy(to), copy(from)]);
            }
            if is_interior && folds[a] && copy(a) != a {
                lines.builder.edge(edge, [copy(a), a]);
            }
        }
    }
}

/// The copy of a vertex, added on first use.
fn copy_of(copies: &mut [Option<VertexId>], vertex: VertexId, lines: &mut Lines) -> VertexId {
    *copies[vertex.index()].get_or_insert_with(|| {
        let sources = lines.builder.sources(vertex);
        lines.builder.vertex(&sources)
    })
}
