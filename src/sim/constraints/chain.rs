//! Constrained edges, joined into chains between anchors; each chain keeps its curve on the baseline.

use crate::garment::{Elements, Garment};
use crate::mesh::{ChainId, CornerId, EdgeId, IdVec, Topology, VertexId};
use crate::sim::options::SimOptions;
use crate::sim::surface::manifold::Manifold;
use crate::subdivide::{INFINITE_SHARPNESS, Refiner};
use glam::Vec3;
use std::collections::BTreeMap;

/// What an edge of the cage is part of.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChainKind {
    /// A border of the mesh, or of its holes.
    pub border: bool,
    /// A border of a UV shell.
    pub seam: bool,
    /// An infinitely sharp edge inside the mesh: the surface has a fold there at every level.
    pub sharp: bool,
    /// A fold that is sharper than the target length can follow.
    pub ridge: bool,
    /// The edge subsets that hold it, by their place in the garment's list.
    pub subsets: Vec<usize>,
}

/// A path or loop of constrained edges, with its curve on the baseline.
#[derive(Clone, Debug)]
pub struct Chain {
    /// What its edges are part of; the same for all.
    pub kind: ChainKind,
    /// Whether it closes without an anchor.
    pub is_loop: bool,
    /// The garment's vertices along the cage; a loop repeats its first at the end.
    pub cage: Vec<VertexId>,
    /// Vertices of the baseline along the curve; a loop repeats its first at the end.
    pub vertices: Vec<VertexId>,
    /// Length of the curve up to each vertex. \[stage units\]
    pub along: Vec<f32>,
    /// The baseline's half-edge on the left of each segment; none where there is no face.
    pub left: Vec<Option<CornerId>>,
    /// The same on the right, in the other direction.
    pub right: Vec<Option<CornerId>>,
    /// Unit normals of the surface to the left and to the right of each segment: how triangles should lie there. Those of
    /// a ridge are taken half a target length away, as the fold itself is rounded.
    pub normals: Vec<[Vec3; 2]>,
    /// Vertices of the curve, by their place in `vertices`, that stay where they are although no chain ends there:
    /// corners.
    pub pins: Vec<usize>,
    /// The length that edges should have at each vertex: the target, or less where the curve bends. \[stage units\]
    pub lengths: Vec<f32>,
    /// Number of edges that the curve asks for up to each vertex, as a real number.
    pub spaced: Vec<f32>,
}

/// A place on a chain's curve.
#[derive(Clone, Copy, Debug)]
pub struct CurvePoint {
    /// The segment.
    pub segment: usize,
    /// How far along it, 0 to 1.
    pub t: f32,
}

impl Chain {
    /// Length of the curve. \[stage units\]
    pub fn length(&self) -> f32 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// Segments of the curve for each edge of the cage.
    pub fn step(&self) -> usize {
        (self.vertices.len() - 1) / (self.cage.len() - 1).max(1)
    }

    /// The place at arc length `s`; loops go round, paths end.
    pub fn at(&self, s: f32) -> CurvePoint {
        self.wound(s).1
    }

    /// The same, searched from the segment `near` on, which becomes that of the place: for places one after the other.
    pub(crate) fn at_after(&self, s: f32, near: &mut usize) -> CurvePoint {
        let (_, s) = self.unwound(s);
        if self.along[*near] > s {
            *near = self.segment_at(s);
        }
        while *near + 2 < self.along.len() && self.along[*near + 1] <= s {
            *near += 1;
        }
        self.in_segment(s, *near)
    }

    /// The surface's unit normal beside the curve, on the side of a half-edge that runs `forward`.
    pub(crate) fn normal_at(&self, at: CurvePoint, forward: bool) -> Vec3 {
        self.normals[at.segment][usize::from(!forward)]
    }

    /// How many times a loop was gone round up to arc length `s`, and the place there.
    pub(crate) fn wound(&self, s: f32) -> (f32, CurvePoint) {
        let (turn, s) = self.unwound(s);
        (turn, self.in_segment(s, self.segment_at(s)))
    }

    /// How many times a loop was gone round up to arc length `s`, and the rest.
    fn unwound(&self, s: f32) -> (f32, f32) {
        let length = self.length();
        let turn = if self.is_loop && length > 0.0 { (s / length).floor() } else { 0.0 };
        (turn, (s - turn * length).clamp(0.0, length))
    }

    /// The segment of an arc length on the curve.
    fn segment_at(&self, s: f32) -> usize {
        let last = self.along.len().saturating_sub(2);
        self.along.partition_point(|&a| a <= s).saturating_sub(1).min(last)
    }

    fn in_segment(&self, s: f32, segment: usize) -> CurvePoint {
        let span = self.along[segment + 1] - self.along[segment];
        let t = if span > 0.0 { ((s - self.along[segment]) / span).clamp(0.0, 1.0) } else { 0.0 };
        CurvePoint { segment, t }
    }
}

/// The span of an edge of a start mesh on its chain.
#[derive(Clone, Copy, Debug)]
pub struct StartSpan {
    /// The chain.
    pub chain: ChainId,
    /// The vertex at `from`.
    pub first: VertexId,
    /// Arc length at the first vertex. \[stage units\]
    pub from: f32,
    /// Arc length at the other. \[stage units\]
    pub to: f32,
}

/// The chains of a garment on its cage.
pub struct CageChains {
    /// Marks, whether it is a loop, and the cage's vertices in order.
    pub paths: Vec<(ChainKind, bool, Vec<VertexId>)>,
}

/// What each constrained edge of the manifold cage is part of.
pub fn constrained_edges(
    garment: &Garment,
    manifold: &Manifold,
    options: &SimOptions,
    is_seam: impl Fn(EdgeId) -> bool,
    is_hole: impl Fn(crate::mesh::FaceId) -> bool,
) -> BTreeMap<EdgeId, ChainKind> {
    let t = &manifold.refiner.level.topology;
    let mut in_subsets: BTreeMap<[VertexId; 2], (Vec<usize>, bool)> = BTreeMap::new();
    for (i, subset) in garment.subsets.iter().enumerate() {
        let Elements::Edges(edges) = &subset.elements else { continue };
        let chosen = options.constraints.contains(&subset.name);
        for &[a, b] in edges {
            let entry = in_subsets.entry([a.min(b), a.max(b)]).or_default();
            entry.0.push(i);
            entry.1 |= chosen;
        }
    }
    let mut marked = BTreeMap::new();
    for (edge, &[a, b]) in t.edges.enumerated() {
        let halves = t.edge_corners.row(edge);
        let solid = halves.iter().filter(|&&c| !is_hole(t.faces.face_of(c))).count();
        if solid == 0 {
            continue;
        }
        let (a, b) = (manifold.vertex_source[a], manifold.vertex_source[b]);
        let (subsets, chosen) = in_subsets.get(&[a.min(b), a.max(b)]).cloned().unwrap_or_default();
        let kind = ChainKind {
            border: solid == 1,
            seam: solid > 1 && is_seam(edge),
            sharp: solid > 1 && manifold.refiner.level.edge_sharpness[edge] >= INFINITE_SHARPNESS,
            ridge: false,
            subsets,
        };
        if kind.border || kind.sharp || chosen || kind.seam && options.constrain_uv_seams {
            marked.insert(edge, kind);
        }
    }
    marked
}

/// Joins constrained edges into paths between anchors, and loops.
///
/// A vertex is an anchor if one, or more than two, constrained edges meet there (Waggoner and de Goes 2022), if what
/// its two edges are part of differs, or if the surface has a corner there.
pub fn join(manifold: &Manifold, marked: &BTreeMap<EdgeId, ChainKind>) -> CageChains {
    let level = &manifold.refiner.level;
    let t = &level.topology;
    let mut at: BTreeMap<VertexId, Vec<EdgeId>> = BTreeMap::new();
    for &edge in marked.keys() {
        t.edges[edge].iter().for_each(|&v| at.entry(v).or_default().push(edge));
    }
    let is_anchor = |v: VertexId| match at[&v].as_slice() {
        &[a, b] => marked[&a] != marked[&b] || level.vertex_sharpness[v] >= INFINITE_SHARPNESS,
        _ => true,
    };
    let mut used = IdVec::<EdgeId, bool>::filled(false, t.edges.len());
    let mut walk = |start: VertexId, first: EdgeId| -> Option<(ChainKind, bool, Vec<VertexId>)> {
        if used[first] {
            return None;
        }
        let mut path = vec![start];
        let (mut vertex, mut edge) = (start, first);
        loop {
            used[edge] = true;
            let [a, b] = t.edges[edge];
            vertex = if a == vertex { b } else { a };
            path.push(vertex);
            if vertex == start || is_anchor(vertex) {
                break;
            }
            match at[&vertex].iter().find(|&&e| !used[e]) {
                Some(&next) => edge = next,
                None => break,
            }
        }
        let is_loop = vertex == start && !is_anchor(start);
        Some((marked[&first].clone(), is_loop, path))
    };
    let mut paths = Vec::new();
    for anchors in [true, false] {
        for (&vertex, edges) in &at {
            if is_anchor(vertex) == anchors {
                paths.extend(edges.iter().filter_map(|&e| walk(vertex, e)));
            }
        }
    }
    CageChains { paths }
}

impl CageChains {
    /// The vertices of each chain on every level from the cage on: `levels[k]` is refined `k` times.
    pub fn refine(&self, levels: &[&Refiner]) -> Vec<Vec<Vec<VertexId>>> {
        let mut paths: Vec<Vec<VertexId>> = self.paths.iter().map(|p| p.2.clone()).collect();
        let mut all = vec![paths.clone()];
        for parent in &levels[..levels.len() - 1] {
            let t = &parent.level.topology;
            let numbering = crate::subdivide::Numbering::new(&parent.level);
            for path in &mut paths {
                let mut fine = Vec::with_capacity(2 * path.len());
                for pair in path.windows(2) {
                    fine.push(pair[0]);
                    fine.extend(t.find_edge(pair[0], pair[1]).map(|e| numbering.of_edge(e)));
                }
                fine.extend(path.last());
                *path = fine;
            }
            all.push(paths.clone());
        }
        all
    }

    /// The chains with their curves on the triangulated baseline.
    pub fn on_baseline(
        &self,
        curves: &[Vec<VertexId>],
        manifold: &Manifold,
        t: &Topology,
        points: &IdVec<VertexId, Vec3>,
    ) -> IdVec<ChainId, Chain> {
        let half = |a: VertexId, b: VertexId| {
            t.vertex_corners.row(a).iter().copied().find(|&c| t.faces.vertex(t.faces.next(c)) == b)
        };
        self.paths
            .iter()
            .zip(curves)
            .map(|((kind, is_loop, cage), curve)| {
                let mut along = vec![0.0f32];
                let mut length = 0.0f64;
                for pair in curve.windows(2) {
                    length += f64::from(points[pair[0]].distance(points[pair[1]]));
                    along.push(length as f32);
                }
                Chain {
                    kind: kind.clone(),
                    is_loop: *is_loop,
                    cage: cage.iter().map(|&v| manifold.vertex_source[v]).collect(),
                    left: curve.windows(2).map(|p| half(p[0], p[1])).collect(),
                    right: curve.windows(2).map(|p| half(p[1], p[0])).collect(),
                    vertices: curve.clone(),
                    normals: Vec::new(),
                    pins: Vec::new(),
                    lengths: Vec::new(),
                    spaced: Vec::new(),
                    along,
                }
            })
            .collect()
    }
}

/// Spans of the edges that a level has on each chain, by their vertices. `level` holds the chains' vertices there.
pub fn start_spans(chains: &IdVec<ChainId, Chain>, level: &[Vec<VertexId>]) -> BTreeMap<[VertexId; 2], StartSpan> {
    let mut spans = BTreeMap::new();
    for ((id, chain), path) in chains.enumerated().zip(level) {
        let step = (chain.vertices.len() - 1) / (path.len() - 1).max(1);
        for (i, pair) in path.windows(2).enumerate() {
            let span =
                StartSpan { chain: id, first: pair[0], from: chain.along[i * step], to: chain.along[(i + 1) * step] };
            spans.insert([pair[0].min(pair[1]), pair[0].max(pair[1])], span);
        }
    }
    spans
}
