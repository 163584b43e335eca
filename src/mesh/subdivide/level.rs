//! One level of a subdivision hierarchy: topology, sharpness, and the rule of each vertex.
//!
//! Sharpness and rules follow OpenSubdiv (`vtr/level.cpp`, `sdc/crease.h`), including non-manifold edges and vertices.

use super::split;
use crate::connectivity::{CornerId, EdgeId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::garment::{BoundaryInterpolation, Mesh, Scheme, TriangleRule};
use std::collections::BTreeSet;

/// Edges and vertices of this sharpness or more stay sharp at every level (OpenSubdiv's `SHARPNESS_INFINITE`).
pub const INFINITE_SHARPNESS: f32 = 10.0;

/// The sharpness after one refinement: one less, unless infinite (DeRose, Kass and Truong 1998, uniform creases).
pub fn refined_sharpness(sharpness: f32) -> f32 {
    if sharpness >= INFINITE_SHARPNESS { INFINITE_SHARPNESS } else { (sharpness - 1.0).max(0.0) }
}

/// The mask of a vertex, selected by the number of sharp edges at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// No sharp edge.
    Smooth,
    /// One sharp edge; the mask is the smooth one.
    Dart,
    /// Two sharp edges.
    Crease,
    /// Three or more sharp edges, or a sharp vertex.
    Corner,
}

impl Rule {
    /// The rule of a vertex from its own sharpness and that of its edges.
    pub fn new(vertex: f32, edges: impl IntoIterator<Item = f32>) -> Self {
        Self::of_count(vertex, edges.into_iter().filter(|&s| s > 0.0).count())
    }

    /// The rule of a vertex from its own sharpness and its number of sharp edges.
    fn of_count(vertex: f32, sharp_edges: usize) -> Self {
        if vertex > 0.0 {
            return Self::Corner;
        }
        match sharp_edges {
            0 => Self::Smooth,
            1 => Self::Dart,
            2 => Self::Crease,
            _ => Self::Corner,
        }
    }

    /// `true` for rules with the smooth mask.
    pub fn is_smooth(self) -> bool {
        matches!(self, Self::Smooth | Self::Dart)
    }
}

/// An edge at a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Spoke {
    /// The edge.
    pub edge: EdgeId,
    /// A corner at its far end.
    pub far: CornerId,
}

/// A mesh and all other data that the masks depend on.
#[derive(Clone, Debug)]
pub struct Level {
    /// Connectivity.
    pub topology: Topology,
    /// The scheme; `None` refines as `Bilinear`.
    pub scheme: Scheme,
    /// The rule of smooth edges beside triangles.
    pub triangles: TriangleRule,
    /// `true` if border vertices of one face are sharp (`edgeAndCorner`).
    pub sharp_corners: bool,
    /// Sharpness of each edge; infinite on borders and non-manifold edges.
    pub edge_sharpness: IdVec<EdgeId, f32>,
    /// Sharpness of each vertex.
    pub vertex_sharpness: IdVec<VertexId, f32>,
    /// The rule of each vertex.
    pub rules: IdVec<VertexId, Rule>,
}

impl Level {
    /// The unrefined level of a garment. Borders and non-manifold elements are sharpened as in OpenSubdiv.
    ///
    /// Garments that [`same_level`] calls equal have equal levels.
    pub fn base(garment: &Mesh) -> Self {
        let topology = Topology::new(garment.faces.clone(), garment.points.len());
        let sharp_corners = garment.rules.boundary == BoundaryInterpolation::EdgeAndCorner;
        let mut edge_sharpness = IdVec::filled(0.0f32, topology.edges.len());
        for crease in &garment.creases {
            for (pair, &s) in crease.vertices.windows(2).zip(&crease.sharpnesses) {
                if let Some(edge) = topology.find_edge(pair[0], pair[1]) {
                    edge_sharpness[edge] = s.min(INFINITE_SHARPNESS);
                }
            }
        }
        for edge in topology.edges.ids() {
            if topology.is_border(edge) || is_non_manifold(&topology, edge) {
                edge_sharpness[edge] = INFINITE_SHARPNESS;
            }
        }
        let mut vertex_sharpness = IdVec::filled(0.0f32, topology.vertex_count());
        for corner in &garment.corners {
            vertex_sharpness[corner.vertex] = corner.sharpness.min(INFINITE_SHARPNESS);
        }
        let mut level = Self {
            rules: IdVec::filled(Rule::Smooth, topology.vertex_count()),
            scheme: garment.rules.scheme,
            triangles: garment.rules.triangles,
            topology,
            sharp_corners,
            edge_sharpness,
            vertex_sharpness,
        };
        level.sharpen_vertices();
        level.set_rules();
        level
    }

    /// Makes border corners (under `edgeAndCorner`) and non-manifold vertices infinitely sharp.
    fn sharpen_vertices(&mut self) {
        let mut spokes = Vec::new();
        let borders = borders_at(&self.topology);
        for vertex in self.vertex_sharpness.ids() {
            let corners = self.topology.vertex_corners.row(vertex).len();
            if corners == 0 {
                continue;
            }
            let is_non_manifold = borders[vertex] > 2 || fan_length(&self.topology, vertex) != corners;
            if corners > 1 && !is_non_manifold {
                continue;
            }
            self.spokes(vertex, &mut spokes);
            let is_corner = corners == 1 && spokes.len() == 2;
            if is_corner && self.sharp_corners
                || !is_corner && is_non_manifold && !is_non_manifold_crease(&self.topology, vertex, &spokes)
            {
                self.vertex_sharpness[vertex] = INFINITE_SHARPNESS;
            }
        }
    }

    fn set_rules(&mut self) {
        let mut sharp_edges = IdVec::<VertexId, usize>::filled(0, self.topology.vertex_count());
        for (edge, _) in self.edge_sharpness.enumerated().filter(|(_, s)| **s > 0.0) {
            self.topology.edges[edge].iter().for_each(|&end| sharp_edges[end] += 1);
        }
        for (vertex, rule) in self.rules.iter_mut().enumerate().map(|(i, r)| (VertexId::new(i), r)) {
            *rule = Rule::of_count(self.vertex_sharpness[vertex], sharp_edges[vertex]);
        }
    }

    /// The level of a subset of the faces, with the vertex of `self` for each of its vertices.
    ///
    /// A vertex with all of its faces in the subset keeps its rule; any other becomes a corner.
    pub fn part(&self, faces: &[FaceId]) -> (Self, IdVec<VertexId, VertexId>) {
        let t = &self.topology;
        let mut new: IdVec<VertexId, Option<VertexId>> = IdVec::filled(None, t.vertex_count());
        let mut old: IdVec<VertexId, VertexId> = IdVec::with_capacity(4 * faces.len());
        let corners = faces.iter().flat_map(|&f| t.faces.vertices_of(f));
        let corners: Vec<VertexId> = corners.map(|&v| *new[v].get_or_insert_with(|| old.push(v))).collect();
        let topology = Topology::new(Faces::mixed(faces.iter().map(|&f| t.faces.valence(f)), corners), old.len());
        let mut edge_sharpness = IdVec::filled(INFINITE_SHARPNESS, topology.edges.len());
        let all = faces.iter().flat_map(|&f| t.faces.corners_of(f));
        all.zip(topology.corner_edge.iter()).for_each(|(corner, &edge)| {
            edge_sharpness[edge] = self.edge_sharpness[t.corner_edge[corner]];
        });
        let is_whole = |v: VertexId| topology.vertex_corners.row(v).len() == t.vertex_corners.row(old[v]).len();
        let rule = |v: VertexId| if is_whole(v) { self.rules[old[v]] } else { Rule::Corner };
        let rules = old.ids().map(rule).collect();
        for (edge, ends) in topology.edges.enumerated() {
            if !ends.iter().any(|&v| is_whole(v)) {
                edge_sharpness[edge] = INFINITE_SHARPNESS;
            }
        }
        let sharpness = |v: VertexId| if is_whole(v) { self.vertex_sharpness[old[v]] } else { INFINITE_SHARPNESS };
        let vertex_sharpness = old.ids().map(sharpness).collect();
        let level = Self { topology, edge_sharpness, vertex_sharpness, rules, ..*self };
        (level, old)
    }

    /// The next finer level.
    #[must_use]
    pub fn refined(&self) -> Self {
        split::child_level(self, self.refined_faces())
    }

    /// The faces of the next finer level.
    pub fn refined_faces(&self) -> Faces {
        split::child_faces(self)
    }

    /// Writes each edge at a vertex to `out`, once.
    pub fn spokes(&self, vertex: VertexId, out: &mut Vec<Spoke>) {
        spokes(&self.topology, vertex, out);
    }

    /// The faces that `interpolateBoundary = "none"` removes: those with a vertex on an uncreased border.
    ///
    /// Empty under any other boundary rule and for bilinear or polygonal meshes.
    pub fn border_holes(&self, garment: &Mesh) -> Vec<FaceId> {
        if garment.rules.boundary != BoundaryInterpolation::None
            || matches!(garment.rules.scheme, Scheme::Bilinear | Scheme::None)
        {
            return Vec::new();
        }
        let steps = garment.creases.iter().flat_map(|c| c.vertices.windows(2).zip(&c.sharpnesses));
        let sharp = steps.filter(|(_, s)| **s >= INFINITE_SHARPNESS);
        let creased: BTreeSet<EdgeId> = sharp.filter_map(|(p, _)| self.topology.find_edge(p[0], p[1])).collect();
        let mut at_border = IdVec::<VertexId, bool>::filled(false, self.topology.vertex_count());
        for edge in self.topology.edges.ids().filter(|&e| self.topology.is_border(e) && !creased.contains(&e)) {
            self.topology.edges[edge].iter().for_each(|&v| at_border[v] = true);
        }
        let faces = &self.topology.faces;
        faces.ids().filter(|&f| faces.vertices_of(f).iter().any(|&v| at_border[v])).collect()
    }
}

/// `true` if both garments have the same unrefined level.
pub fn same_level(a: &Mesh, b: &Mesh) -> bool {
    let rules = |g: &Mesh| (g.rules.scheme, g.rules.boundary, g.rules.triangles, g.points.len());
    rules(a) == rules(b) && a.faces == b.faces && a.creases == b.creases && a.corners == b.corners
}

/// The edges at a vertex, each as often as it has faces.
#[inline]
pub fn edges_at(topology: &Topology, vertex: VertexId) -> impl Iterator<Item = EdgeId> {
    let corners = topology.vertex_corners.row(vertex).iter();
    corners.flat_map(|&c| [topology.corner_edge[c], topology.corner_edge[topology.faces.prev(c)]])
}

/// Writes each edge at a vertex to `out`, once, in the order of the corners.
pub fn spokes(topology: &Topology, vertex: VertexId, out: &mut Vec<Spoke>) {
    out.clear();
    for &corner in topology.vertex_corners.row(vertex) {
        let prev = topology.faces.prev(corner);
        for (edge, far) in
            [(topology.corner_edge[corner], topology.faces.next(corner)), (topology.corner_edge[prev], prev)]
        {
            if out.iter().all(|s| s.edge != edge) {
                out.push(Spoke { edge, far });
            }
        }
    }
}

/// `true` if the edge has more than two faces, or two that traverse it in the same direction.
#[inline]
pub fn is_non_manifold(topology: &Topology, edge: EdgeId) -> bool {
    match *topology.edge_corners.row(edge) {
        [] | [_] => false,
        [a, b] => topology.faces.vertex(a) == topology.faces.vertex(b),
        _ => true,
    }
}

/// `true` for a vertex of a non-manifold edge and for a vertex with more than one fan of faces.
pub fn is_non_manifold_vertex(topology: &Topology, vertex: VertexId) -> bool {
    if edges_at(topology, vertex).any(|e| is_non_manifold(topology, e)) {
        return true;
    }
    let borders = edges_at(topology, vertex).filter(|&e| topology.is_border(e)).count();
    borders > 2 || fan_length(topology, vertex) != topology.vertex_corners.row(vertex).len()
}

/// The number of border edges at each vertex; `u8::MAX` at vertices of non-manifold edges.
fn borders_at(topology: &Topology) -> IdVec<VertexId, u8> {
    let mut borders = IdVec::filled(0u8, topology.vertex_count());
    for (edge, ends) in topology.edges.enumerated() {
        let more = match topology.is_border(edge) {
            true => 1,
            false if is_non_manifold(topology, edge) => u8::MAX,
            false => continue,
        };
        ends.iter().for_each(|&v| borders[v] = borders[v].saturating_add(more));
    }
    borders
}

/// The number of corners in one fan of the vertex: that of a border edge if there is one, else any.
fn fan_length(topology: &Topology, vertex: VertexId) -> usize {
    let corners = topology.vertex_corners.row(vertex);
    let Some(&first) =
        corners.iter().find(|&&c| topology.is_border(topology.corner_edge[c])).or_else(|| corners.first())
    else {
        return 0;
    };
    let mut corner = first;
    for length in 1..=corners.len() {
        match topology.twin(topology.faces.prev(corner)) {
            Some(next) if next != first => corner = next,
            _ => return length,
        }
    }
    corners.len() + 1
}

/// `true` if exactly two non-manifold edges meet at the vertex and all of its faces lie in sheets between them
/// (OpenSubdiv's `testVertexNonManifoldCrease`).
fn is_non_manifold_crease(topology: &Topology, vertex: VertexId, spokes: &[Spoke]) -> bool {
    let corners = topology.vertex_corners.row(vertex);
    let fins: Vec<EdgeId> = spokes.iter().map(|s| s.edge).filter(|&e| is_non_manifold(topology, e)).collect();
    let &[first, second] = fins.as_slice() else { return false };
    let others_interior =
        spokes.iter().all(|s| is_non_manifold(topology, s.edge) || topology.edge_corners.row(s.edge).len() == 2);
    let sheets = topology.edge_corners.row(first).len();
    if !others_interior || corners.len() <= spokes.len() || sheets != topology.edge_corners.row(second).len() {
        return false;
    }
    let mut seen = 0;
    for (start, end) in [(first, second), (second, first)] {
        for &leaving in topology.edge_corners.row(start).iter().filter(|&&c| topology.faces.vertex(c) == vertex) {
            let mut corner = leaving;
            loop {
                seen += 1;
                if seen > corners.len() {
                    return false;
                }
                let prev = topology.faces.prev(corner);
                let edge = topology.corner_edge[prev];
                if edge == end {
                    break;
                }
                match topology.twin(prev) {
                    Some(next) if edge != start => corner = next,
                    _ => return false,
                }
            }
        }
    }
    seen == corners.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::connectivity::Faces;
    use crate::garment::SubdivisionRules;

    #[test]
    fn only_smooth_schemes_lose_faces_at_borders() {
        for (scheme, boundary, expected) in [
            (Scheme::CatmullClark, BoundaryInterpolation::None, 1),
            (Scheme::CatmullClark, BoundaryInterpolation::EdgeOnly, 0),
            (Scheme::Bilinear, BoundaryInterpolation::None, 0),
            (Scheme::None, BoundaryInterpolation::None, 0),
        ] {
            let garment = Mesh {
                points: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
                    .map(Into::into)
                    .to_vec()
                    .into(),
                faces: Faces::quads((0..4).map(VertexId::new).collect::<Vec<_>>()),
                rules: SubdivisionRules { scheme, boundary, ..SubdivisionRules::default() },
                ..Mesh::default()
            };
            assert_eq!(Level::base(&garment).border_holes(&garment).len(), expected, "{scheme:?}, {boundary:?}");
        }
    }
}
