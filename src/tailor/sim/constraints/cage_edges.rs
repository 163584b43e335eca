//! The constrained edges of the cage, and the paths and loops that they form.

use super::chain::{Chain, ChainKind};
use crate::sim::options::SimOptions;
use crate::sim::surface::manifold::Manifold;
use crate::sim::surface::small_shells::SmallShells;
use crate::sim::surface::triangulation::RefinedSurface;
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{ChainId, CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Elements, Mesh};
use tailor_mesh::subdivide::{INFINITE_SHARPNESS, Level, Numbering};

/// The part of a chain that an edge of the start mesh covers.
#[derive(Clone, Copy, Debug)]
pub struct StartSpan {
    /// The chain.
    pub chain: ChainId,
    /// The vertex at `from`.
    pub first: VertexId,
    /// Arc length at the first vertex. \[mesh units\]
    pub from: f32,
    /// Arc length at the other. \[mesh units\]
    pub to: f32,
}

/// A chain on the cage: its vertices in order; a loop repeats its first at the end.
pub struct CagePath {
    /// The features that its edges belong to.
    pub kind: ChainKind,
    /// Whether it closes without an anchor.
    pub is_loop: bool,
    /// Vertices of the level that it was traced on.
    pub vertices: Vec<VertexId>,
}

/// The constrained edges of the manifold cage, with the features that they belong to.
pub fn constrained_edges(
    garment: &Mesh,
    manifold: &Manifold,
    options: &SimOptions,
    is_seam: impl Fn(EdgeId) -> bool,
    small_shells: &SmallShells,
    is_hole: &IdVec<FaceId, bool>,
) -> BTreeMap<EdgeId, ChainKind> {
    let t = &manifold.level.topology;
    let in_subsets = edge_subsets(garment, options);
    let kind_of = |(edge, &ends): (EdgeId, &[VertexId; 2])| {
        let solid = t.edge_corners.row(edge).iter().filter(|&&c| !is_hole[t.faces.face_of(c)]).count();
        let [a, b] = ends.map(|v| manifold.vertex_source[v]);
        let (subsets, is_chosen) = in_subsets.get(&[a.min(b), a.max(b)]).cloned().unwrap_or_default();
        let kind = ChainKind {
            border: solid == 1,
            seam: solid > 1 && is_seam(edge),
            sharp: solid > 1 && manifold.level.edge_sharpness[edge] >= INFINITE_SHARPNESS,
            feature: false,
            subsets,
            twin: None,
        };
        let holds_seam = kind.seam && !small_shells.is_released(edge);
        let is_constrained = kind.border || kind.sharp || is_chosen || holds_seam;
        (solid > 0 && is_constrained).then_some((edge, kind))
    };
    t.edges.enumerated().filter_map(kind_of).collect()
}

/// For each edge in a subset: the subsets that hold it, and whether the options make one of them a constraint.
fn edge_subsets(garment: &Mesh, options: &SimOptions) -> BTreeMap<[VertexId; 2], (Vec<usize>, bool)> {
    let mut found: BTreeMap<[VertexId; 2], (Vec<usize>, bool)> = BTreeMap::new();
    for (i, subset) in garment.subsets.iter().enumerate() {
        let Elements::Edges(edges) = &subset.elements else { continue };
        let is_chosen = options.constraints.contains(&subset.name);
        for &[a, b] in edges {
            let entry = found.entry([a.min(b), a.max(b)]).or_default();
            entry.0.push(i);
            entry.1 |= is_chosen;
        }
    }
    found
}

/// Joins constrained edges into paths between anchors, and loops.
///
/// A vertex is an anchor if one, or more than two, constrained edges meet there (Waggoner and de Goes 2022), if its two
/// edges belong to different features, or if the surface has a corner there or at its `twin`.
pub fn trace_paths(
    level: &Level,
    kinds: &BTreeMap<EdgeId, ChainKind>,
    twin: impl Fn(VertexId) -> Option<VertexId>,
) -> Vec<CagePath> {
    let t = &level.topology;
    let mut at: BTreeMap<VertexId, Vec<EdgeId>> = BTreeMap::new();
    for &edge in kinds.keys() {
        t.edges[edge].iter().for_each(|&v| at.entry(v).or_default().push(edge));
    }
    let is_corner = |v: VertexId| level.vertex_sharpness[v] >= INFINITE_SHARPNESS;
    let is_anchor = |v: VertexId| match at[&v].as_slice() {
        &[a, b] => kinds[&a] != kinds[&b] || is_corner(v) || twin(v).is_some_and(is_corner),
        _ => true,
    };
    let mut is_used = IdVec::<EdgeId, bool>::filled(false, t.edges.len());
    let mut walk = |start: VertexId, first: EdgeId| {
        if is_used[first] {
            return None;
        }
        let mut vertices = vec![start];
        let (mut vertex, mut next) = (start, Some(first));
        while let Some(edge) = next {
            is_used[edge] = true;
            let [a, b] = t.edges[edge];
            vertex = if a == vertex { b } else { a };
            vertices.push(vertex);
            let ends = vertex == start || is_anchor(vertex);
            next = at[&vertex].iter().copied().find(|&e| !ends && !is_used[e]);
        }
        Some(CagePath { kind: kinds[&first].clone(), is_loop: vertex == start && !is_anchor(start), vertices })
    };
    let mut paths = Vec::new();
    for anchors in [true, false] {
        for (&vertex, edges) in at.iter().filter(|&(&v, _)| is_anchor(v) == anchors) {
            paths.extend(edges.iter().filter_map(|&e| walk(vertex, e)));
        }
    }
    paths
}

/// Vertices of each path on every level from the first of `levels` on: element `k` holds those of `levels[k]`.
pub fn refine_paths(mut paths: Vec<Vec<VertexId>>, levels: &[&Level]) -> Vec<Vec<Vec<VertexId>>> {
    let mut all = vec![paths.clone()];
    for parent in &levels[..levels.len() - 1] {
        let numbering = Numbering::new(parent);
        let middle = |pair: &[VertexId]| {
            let edge = parent.topology.find_edge(pair[0], pair[1]);
            numbering.of_edge(edge.unwrap_or_else(|| unreachable!("a path runs along edges of its level")))
        };
        for path in &mut paths {
            let refined = path.windows(2).flat_map(|pair| [pair[0], middle(pair)]);
            *path = refined.chain(path.last().copied()).collect();
        }
        all.push(paths.clone());
    }
    all
}

impl CagePath {
    /// The chain of this path on the surface, where its vertices are `curve`; `source` has the garment's vertex of each of its
    /// own. Corners and lengths are not set yet.
    pub fn on_surface(
        &self,
        curve: &[VertexId],
        source: &IdVec<VertexId, VertexId>,
        surface: &RefinedSurface<'_>,
    ) -> Chain {
        let half_edges = |from: usize| -> Vec<Option<CornerId>> {
            curve.windows(2).map(|p| half_edge(surface.topology, p[from], p[1 - from])).collect()
        };
        let mut length = 0.0f64;
        let advance = |pair: &[VertexId]| {
            length += f64::from(surface.points[pair[0]].distance(surface.points[pair[1]]));
            length as f32
        };
        let mut chain = Chain {
            kind: self.kind.clone(),
            is_loop: self.is_loop,
            cage: self.vertices.iter().map(|&v| source[v]).collect(),
            vertices: curve.to_vec(),
            along: std::iter::once(0.0).chain(curve.windows(2).map(advance)).collect(),
            left: half_edges(0),
            right: half_edges(1),
            normals: Vec::new(),
            pins: Vec::new(),
            lengths: Vec::new(),
            spaced: Vec::new(),
        };
        surface.set_normals(&mut chain);
        chain
    }
}

/// The half-edge from one vertex to another.
pub fn half_edge(t: &Topology, from: VertexId, to: VertexId) -> Option<CornerId> {
    // Search around the vertex with fewer faces.
    let (own, others) = (t.vertex_corners.row(from), t.vertex_corners.row(to));
    if own.len() <= others.len() {
        return own.iter().copied().find(|&c| t.faces.vertex(t.faces.next(c)) == to);
    }
    others.iter().map(|&c| t.faces.prev(c)).find(|&c| t.faces.vertex(c) == from)
}

/// The spans of a level's edges on each chain, by their vertices. `curves` are the chains' vertices on that level.
pub fn start_spans(chains: &IdVec<ChainId, Chain>, curves: &[Vec<VertexId>]) -> BTreeMap<[VertexId; 2], StartSpan> {
    let spans = chains.enumerated().zip(curves).flat_map(|((id, chain), curve)| {
        let step = (chain.vertices.len() - 1) / (curve.len() - 1);
        curve.windows(2).enumerate().map(move |(i, pair)| {
            let (from, to) = (chain.along[i * step], chain.along[(i + 1) * step]);
            ([pair[0].min(pair[1]), pair[0].max(pair[1])], StartSpan { chain: id, first: pair[0], from, to })
        })
    });
    spans.collect()
}
