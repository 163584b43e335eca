//! The surface that the simulation mesh lies on: the garment refined, in triangles, with its chains.

pub mod facets;
pub mod project;

use crate::garment::{Garment, Interpolation, Primvar, Values};
use crate::mesh::{ChainId, CornerId, FaceId, Faces, IdVec, Topology, VertexId};
use crate::sim::baseline::facets::{Facet, facets};
use crate::sim::constraints::chain::{self as chains, Chain, StartSpan};
use crate::sim::constraints::ridges;
use crate::sim::options::SimOptions;
use crate::sim::surface::lengths::grade;
use crate::sim::surface::manifold::Manifold;
use crate::sim::surface::triangulation::{StartMesh, Triangulation};
use crate::subdivide::{Level, Numbering, Real, Refiner, Stencils, mix_rows};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// A point of the baseline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Location {
    /// The triangle.
    pub face: FaceId,
    /// Weights of its corners; they sum to 1.
    pub weights: Vec3,
}

/// The triangulated baseline.
pub struct Baseline {
    /// The pieces of the cage and what they come from.
    pub manifold: Manifold,
    /// The refined levels after the cage; the last, or the cage where there is none, is the one in triangles.
    pub levels: Vec<Refiner>,
    /// The vertex of the finest level behind each vertex; they differ where holes leave fans that only touch.
    pub level_vertex: IdVec<VertexId, VertexId>,
    /// Positions. \[stage units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The triangles and their adjacency.
    pub topology: Topology,
    /// The constraint UVs of each corner; zero without a UV set.
    pub uvs: IdVec<CornerId, Vec2>,
    /// Whether there is a UV set.
    pub has_uvs: bool,
    /// The face of the finest level behind each triangle.
    pub level_face: IdVec<FaceId, FaceId>,
    /// The corner of the finest level behind each corner of a triangle.
    pub level_corner: IdVec<CornerId, CornerId>,
    /// The garment's face behind each triangle.
    pub source_face: IdVec<FaceId, FaceId>,
    /// Half-edges that no projection crosses: those on chains and at borders.
    pub barrier: IdVec<CornerId, bool>,
    /// What projections ask of each triangle.
    pub facets: IdVec<FaceId, Facet>,
    /// Whether UVs are one to one over each piece between chains, so that a mesh can be held to them.
    pub holds_uvs: bool,
    /// Target edge length at each vertex. \[stage units\]
    pub target: IdVec<VertexId, f32>,
    /// Number of vertices whose target grading shortened.
    pub graded: usize,
    /// The length that remeshing works with at each vertex: the target, or less near a chain that bends.
    /// \[stage units\]
    pub sizing: IdVec<VertexId, f32>,
    /// The constraint chains.
    pub chains: IdVec<ChainId, Chain>,
    /// The triangles that remeshing starts from, by corners of the baseline.
    pub start: Vec<[CornerId; 3]>,
    /// Spans of the start's constrained edges.
    pub start_spans: BTreeMap<[VertexId; 2], StartSpan>,
}

/// Target edge lengths over the garment.
#[derive(Clone, Copy, Debug)]
pub struct Lengths<'a> {
    /// Where the density is 1. \[stage units\]
    pub min: f32,
    /// Where the density is 0. \[stage units\]
    pub max: f32,
    /// The density, on the garment's vertices.
    pub density: Option<&'a Primvar>,
}

impl Lengths<'_> {
    /// The target length for a weight.
    fn of(&self, weight: f32) -> f32 {
        self.max + (self.min - self.max) * weight.clamp(0.0, 1.0)
    }

    /// The target length at a vertex of the garment. \[stage units\]
    pub fn at(&self, vertex: VertexId) -> f32 {
        match self.density.map(|d| (d, &d.values)) {
            Some((density, Values::F32(values))) => self.of(values[density.row(vertex.index())]),
            _ => self.max,
        }
    }
}

impl Baseline {
    /// Refines and triangulates a garment and finds its chains.
    ///
    /// `uv_set` is the primvar whose shells are constraints, if there is one.
    pub fn new(garment: &Garment, options: &SimOptions, lengths: Lengths<'_>, uv_set: Option<&Primvar>) -> Self {
        let base = Level::base(garment);
        let manifold = Manifold::new(garment, &base);
        let mut cage = manifold.refiner.clone();
        let uv_rows = uv_set.map(|uv| add_uv_channel(&mut cage, garment, &manifold, uv));
        let mut points: Vec<[f32; 3]> = manifold.vertex_source.iter().map(|&v| garment.points[v].to_array()).collect();
        let mut uvs = uv_rows.unwrap_or_default();
        let mut levels: Vec<Refiner> = Vec::new();
        let mut faces: IdVec<FaceId, FaceId> = cage.level.topology.faces.ids().collect();
        for _ in 0..options.baseline_level {
            let parent = levels.last().unwrap_or(&cage);
            let derivation = parent.derive();
            points = derivation.vertex().apply(&points);
            if let Some(channel) = derivation.channels.first() {
                uvs = channel.apply(&uvs);
            }
            let numbering = derivation.numbering();
            let parent_faces = &parent.level.topology.faces;
            faces = derivation.faces.ids().map(|f| faces[numbering.parent_face(parent_faces, f)]).collect();
            let child = derivation.into_child();
            levels.push(child);
        }
        let points: IdVec<VertexId, Vec3> = points.into_iter().map(Vec3::from).collect();
        let is_hole = holes(garment, &base);
        let finest = levels.last().unwrap_or(&cage);
        let solid = |f: FaceId| !is_hole[faces[f]];
        let quads = Triangulation::new(&finest.level.topology, &points, solid);
        let topology = Topology::new(Faces::triangles(quads.vertices(&finest.level.topology.faces)), points.len());
        let corner_uvs = quads.corners.iter().map(|&c| match finest.channels.first() {
            Some(channel) => Vec2::from(uvs[channel.corner_value[c].index()]),
            None => Vec2::ZERO,
        });
        let corner_uvs: IdVec<CornerId, Vec2> = corner_uvs.collect();

        let is_seam = |e| cage.channels.first().is_some_and(|c| c.is_cut(e));
        let mut marked = chains::constrained_edges(garment, &manifold, options, is_seam, |f| is_hole[f]);
        let mut target = targets(garment, lengths, &manifold, &levels, points.len());
        let graded = match options.grading > 0.0 {
            true => {
                let all: Vec<(VertexId, f32)> = target.enumerated().map(|(v, &length)| (v, length)).collect();
                grade(&mut target, all.into_iter(), options.grading - 1.0, &topology, &points)
            }
            false => 0,
        };
        let all_levels: Vec<&Refiner> = std::iter::once(&cage).chain(&levels).collect();
        let surface = ridges::RefinedSurface { topology: &topology, points: &points, target: &target };
        ridges::mark(&manifold, &all_levels, &surface, &mut marked);
        let cage_chains = chains::join(&manifold, &marked);
        let curves = cage_chains.refine(&all_levels);
        let mut chains = cage_chains.on_baseline(&curves[levels.len()], &manifold, &topology, &points);
        chains.iter_mut().for_each(|c| surface.set_normals(c));

        let start_level = nearest_level(&all_levels, &points, lengths);
        let start =
            StartMesh { levels: &all_levels, level: start_level, points: &points, uvs: &corner_uvs, target: &target };
        let start = start.triangles(&quads, |f| !is_hole[root_face(&all_levels[..=start_level], f)]);
        let start_spans = chains::start_spans(&chains, &curves[start_level]);
        // Chains and the start know the vertices of the level; from here on, fans that only touch are apart.
        let (topology, level_vertex) = apart(topology, is_hole.contains(&true));
        let points: IdVec<VertexId, Vec3> = level_vertex.iter().map(|&v| points[v]).collect();
        let mut barrier: IdVec<CornerId, bool> = topology.corner_edge.iter().map(|&e| topology.is_border(e)).collect();
        for half in chains.iter().flat_map(|c| c.left.iter().chain(&c.right)).flatten() {
            barrier[*half] = true;
        }
        let facets = facets(&topology, &points, &barrier, uv_set.map(|_| &corner_uvs));
        let mut baseline = Self {
            facets,
            holds_uvs: uv_set.is_some() && options.constrain_uv_seams,
            source_face: quads.faces.iter().map(|&f| faces[f]).collect(),
            level_face: quads.faces,
            level_corner: quads.corners,
            target: level_vertex.iter().map(|&v| target[v]).collect(),
            sizing: IdVec::new(),
            graded,
            has_uvs: uv_set.is_some(),
            uvs: corner_uvs,
            manifold,
            levels,
            level_vertex,
            points,
            topology,
            barrier,
            chains,
            start,
            start_spans,
        };
        let (points, target) = (&baseline.points, &baseline.target);
        let (step, corner) = (1 << options.baseline_level, options.corner());
        baseline.chains.iter_mut().for_each(|c| c.space(points, target, step, corner));
        baseline.spread_lengths();
        baseline
    }

    /// The levels that are refined on the way to the triangles, from the cage on.
    pub fn parents(&self) -> impl Iterator<Item = &Refiner> {
        std::iter::once(&self.manifold.refiner).chain(&self.levels).take(self.levels.len())
    }

    /// The garment's corner whose part of its face a triangle lies in.
    pub fn source_corner(&self, face: FaceId) -> CornerId {
        let mut level_face = self.level_face[face];
        let mut corner = self.level_corner[CornerId::new(face.index() * 3)];
        for parent in self.parents().collect::<Vec<_>>().into_iter().rev() {
            corner = parent.corner_of_child(level_face);
            level_face = parent.level.topology.faces.face_of(corner);
        }
        self.manifold.corner_source[corner]
    }

    /// The rows of a vertex or varying primvar at the vertices of the finest level. `values` are the primvar's.
    pub fn refine_rows<T: Real>(&self, primvar: &Primvar, values: &[T]) -> Vec<T> {
        refine_rows(&self.manifold, &self.levels, primvar, values)
    }
}

/// The rows of a vertex or varying primvar at the vertices of the last of `levels`.
fn refine_rows<T: Real>(manifold: &Manifold, levels: &[Refiner], primvar: &Primvar, values: &[T]) -> Vec<T> {
    let width = primvar.width();
    let row = |v: &VertexId| values[primvar.row(v.index()) * width..][..width].iter().copied();
    let mut rows: Vec<T> = manifold.vertex_source.iter().flat_map(row).collect();
    for parent in std::iter::once(&manifold.refiner).chain(levels).take(levels.len()) {
        let stencils = match primvar.interpolation {
            Interpolation::Varying => parent.level.varying_stencils(),
            _ => parent.level.vertex_stencils(),
        };
        rows = mix_rows(&stencils, &rows, primvar);
    }
    rows
}

/// Target edge length at each vertex of the finest level.
fn targets(
    garment: &Garment,
    lengths: Lengths<'_>,
    manifold: &Manifold,
    levels: &[Refiner],
    vertices: usize,
) -> IdVec<VertexId, f32> {
    let Some((density, Values::F32(values))) = lengths.density.map(|d| (d, &d.values)) else {
        return IdVec::filled(lengths.max, vertices);
    };
    debug_assert_eq!(density.elements(), garment.points.len());
    refine_rows(manifold, levels, density, values).into_iter().map(|w| lengths.of(w)).collect()
}

/// Adds the constraint UVs as a channel of the cage; returns the channel's values.
fn add_uv_channel(cage: &mut Refiner, garment: &Garment, manifold: &Manifold, uv: &Primvar) -> Vec<[f32; 2]> {
    let Values::F32(values) = &uv.values else { return Vec::new() };
    let rows = uv.corner_rows(&garment.faces, garment.points.len());
    let rows = cage.add_channel(garment, |c| rows[manifold.corner_source[c]] as usize);
    rows.iter().map(|&r| [values[2 * r as usize], values[2 * r as usize + 1]]).collect()
}

/// Which faces of a garment are not there.
pub fn holes(garment: &Garment, level: &Level) -> IdVec<FaceId, bool> {
    let mut is_hole = IdVec::filled(false, garment.faces.len());
    garment.holes.iter().copied().chain(level.border_holes(garment)).for_each(|f| is_hole[f] = true);
    is_hole
}

/// Gives each fan of faces at a vertex a vertex of its own; the first keeps the vertex. Returns the vertex behind each.
fn apart(t: Topology, has_holes: bool) -> (Topology, IdVec<VertexId, VertexId>) {
    let mut source: IdVec<VertexId, VertexId> = (0..t.vertex_count()).map(VertexId::new).collect();
    if !has_holes {
        return (t, source);
    }
    let mut corners = t.faces.corners().clone();
    for vertex in (0..t.vertex_count()).map(VertexId::new) {
        let mut left: Vec<CornerId> = t.vertex_corners.row(vertex).to_vec();
        let mut is_first = true;
        while let Some(&seed) = left.first() {
            let fan = fan_of(&t, seed);
            left.retain(|c| !fan.contains(c));
            if !std::mem::replace(&mut is_first, false) {
                let own = source.push(vertex);
                fan.iter().for_each(|&c| corners[c] = own);
            }
        }
    }
    let count = source.len();
    (Topology::new(Faces::triangles(corners), count), source)
}

/// The corners at the vertex of `seed` that are joined to it across edges.
fn fan_of(t: &Topology, seed: CornerId) -> Vec<CornerId> {
    let mut fan = vec![seed];
    let mut at = seed;
    while let Some(c) = t.twin(t.faces.prev(at)).filter(|&c| c != seed) {
        fan.push(c);
        at = c;
    }
    at = seed;
    while let Some(c) = t.twin(at).map(|twin| t.faces.next(twin)).filter(|c| !fan.contains(c)) {
        fan.push(c);
        at = c;
    }
    fan
}

/// The face of the cage behind a face of the last of `levels`.
fn root_face(levels: &[&Refiner], face: FaceId) -> FaceId {
    levels
        .windows(2)
        .rev()
        .fold(face, |f, pair| Numbering::new(&pair[0].level).parent_face(&pair[0].level.topology.faces, f))
}

/// The level whose mean edge is nearest to the mean target, as a ratio: the fewest edits lead from there to it.
fn nearest_level(levels: &[&Refiner], points: &IdVec<VertexId, Vec3>, lengths: Lengths<'_>) -> usize {
    let target = f64::from((lengths.min * lengths.max).sqrt());
    let off = |level: &Refiner| {
        let edges = &level.level.topology.edges;
        let sum: f64 = edges.iter().map(|&[a, b]| f64::from(points[a].distance(points[b]))).sum();
        (sum / edges.len().max(1) as f64 / target).ln().abs()
    };
    let mut best = 0;
    for level in 1..levels.len() {
        if off(levels[level]) < off(levels[best]) {
            best = level;
        }
    }
    best
}
