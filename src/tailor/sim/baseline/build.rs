//! The steps from a garment to its baseline.

use super::Baseline;
use super::facets::{Layout, facets, free_flipped};
use super::mirror::Mirror;
use super::start::{StartMesh, nearest_level};
use crate::sets::weights_named;
use crate::sim::constraints::cage_edges::{constrained_edges, refine_paths, start_spans, trace_paths};
use crate::sim::constraints::chain::{Chain, ChainKind};
use crate::sim::constraints::feature_lines::{BluntRidge, FeatureSurface, NarrowStrip};
use crate::sim::options::SimOptions;
use crate::sim::surface::fairing::Fairing;
use crate::sim::surface::lengths::{Lengths, grade, painted};
use crate::sim::surface::manifold::Manifold;
use crate::sim::surface::refine::{RefinedLevels, holes};
use crate::sim::surface::small_shells::SmallShells;
use crate::sim::surface::triangulation::{RefinedSurface, Triangulation};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{ChainId, CornerId, EdgeId, FaceId, Faces, Groups, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Elements, Mesh, Primvar};
use tailor_mesh::subdivide::Level;

/// Largest growth of lengths per length away from a chain that bends. Larger values spend fewer triangles near bends,
/// smaller ones make them more even.
const GROWTH: f32 = 0.3;

impl Baseline {
    /// Refines a garment `level` times, triangulates it, and finds its chains.
    ///
    /// `uv_set` is the primvar whose shells are constraints, if there is one.
    pub fn new(
        garment: &Mesh,
        options: &SimOptions,
        lengths: Lengths<'_>,
        uv_set: Option<&Primvar>,
        level: u32,
    ) -> Self {
        let base = Level::base(garment);
        let is_hole = holes(garment, &base);
        let mut manifold = Manifold::new(garment, &base);
        let uvs = uv_set.map(|uv| manifold.add_uv_channel(garment, uv)).unwrap_or_default();
        let RefinedLevels { levels, mut points, uv_channel, uvs, cage_faces } = manifold.refine(garment, uvs, level);
        let all_levels: Vec<&Level> = std::iter::once(&manifold.level).chain(&levels).collect();
        let finest = all_levels[levels.len()];
        let source_face = &cage_faces[levels.len()];
        let small_shells = small_shells(garment, options, lengths, &manifold);
        let is_seam = |e| manifold.uv_channel.as_ref().is_some_and(|c| c.is_cut(e));
        let mut kinds = constrained_edges(garment, &manifold, options, is_seam, &small_shells, &is_hole);
        let mut mirror = match options.symmetry {
            true => Mirror::new(garment, &manifold, &all_levels, &cage_faces, &is_hole, (&points, lengths.max)),
            false => Mirror::default(),
        };
        if !mirror.is_empty() {
            mirror.constrain(0, &manifold.level.topology, &mut kinds);
        }
        let weights = weights_named(garment, &options.smooth_weights).and_then(|p| painted(&manifold, &levels, &p));
        let details = Details { garment, options, levels: &all_levels, source_face, weights };
        let closed_details = details.smooth(&kinds, &mut points);
        let apex = |f| mirror.apex(&finest.topology, &points, f);
        let quads = Triangulation::from_apexes(&finest.topology, |f| !is_hole[source_face[f]], apex);
        let topology = Topology::new(Faces::triangles(quads.vertices(&finest.topology.faces)), points.len());
        let uvs = quads.uvs(uv_channel.as_ref(), &uvs);
        let mut target = lengths.refined(&manifold, &levels, points.len());
        if !mirror.is_empty() {
            mirror.shorten(&mut target);
            mirror.pair(&topology, &quads.faces, source_face);
        }
        let graded = grade_targets(&mut target, options, &topology, &points);

        let surface = RefinedSurface { topology: &topology, points: &points, target: &target, uvs: &uvs };
        let FoundChains { chains, traced, curves, drawn, narrow, blunt } =
            find_chains(options, &manifold, kinds, &mirror, &all_levels, &surface);
        let level = nearest_level(&all_levels, &points, lengths).max(traced);
        let start = StartMesh { levels: &all_levels, level, surface };
        let start = start.triangles(&quads, |f| !is_hole[cage_faces[level][f]] && !mirror.is_copied(level, f));
        let start_spans = start_spans(&chains, &curves[level - traced]);

        // Chains and the start refer to the vertices of the level; from here on, fans that only touch are separate.
        let (topology, level_vertex) = separate_fans(topology, is_hole.contains(&true));
        let points: IdVec<VertexId, Vec3> = level_vertex.iter().map(|&v| points[v]).collect();
        let barrier = barrier(&topology, &chains);
        let layout = uv_channel.as_ref().map(|channel| Layout { uvs: &uvs, values: quads.values(channel) });
        let mut facets = facets(&topology, &points, &barrier, layout);
        let has_uvs = uv_set.is_some();
        let flipped = if has_uvs { free_flipped(&topology, &uvs, &mut facets) } else { Vec::new() };
        let mut baseline = Self {
            facets,
            closed_details,
            small_shells,
            flipped,
            source_face: quads.faces.iter().map(|&f| source_face[f]).collect(),
            level_face: quads.faces,
            level_corner: quads.corners,
            target: level_vertex.iter().map(|&v| target[v]).collect(),
            sizing: IdVec::new(),
            graded,
            narrow,
            blunt,
            traced,
            has_uvs,
            uvs,
            manifold,
            levels,
            level_vertex,
            points,
            topology,
            barrier,
            chains,
            start,
            start_spans,
            mirror,
        };
        baseline.release_small_shells();
        baseline.space_chains(options, &drawn);
        baseline
    }

    /// Lets triangles flip in UV where they reach a small shell.
    fn release_small_shells(&mut self) {
        for (facet, &source) in self.facets.iter_mut().zip(self.source_face.iter()) {
            if self.small_shells.holds(source) {
                facet.sense = 0.0;
            }
        }
    }

    /// Spaces vertices along the chains, and shortens the lengths of vertices near those that bend.
    fn space_chains(&mut self, options: &SimOptions, drawn: &BTreeSet<VertexId>) {
        let cage = self.manifold.level.topology.vertex_count();
        // A refinement has new corners nowhere.
        let may_be_corner = |v: VertexId| v.index() < cage && !drawn.contains(&v);
        for chain in self.chains.iter_mut() {
            chain.space(&self.points, &self.target, may_be_corner, options.corner());
        }
        self.sizing = self.target.clone();
        let on_chains = self.chains.iter().flat_map(|c| c.vertices.iter().copied().zip(c.lengths.iter().copied()));
        let shorter = on_chains.filter(|&(v, length)| length < self.target[v]);
        grade(&mut self.sizing, shorter, GROWTH, &self.topology, &self.points);
    }
}

/// The details that the options name.
struct Details<'a> {
    garment: &'a Mesh,
    options: &'a SimOptions,
    levels: &'a [&'a Level],
    /// The face of the garment behind each face of the finest level.
    source_face: &'a IdVec<FaceId, FaceId>,
    /// The painted weight at each vertex of the finest level.
    weights: Option<IdVec<VertexId, f32>>,
}

impl Details<'_> {
    /// Blends the surface to a fair one. The constrained edges of the cage stay. Returns the number of closed details, which
    /// stay too.
    fn smooth(&self, kinds: &BTreeMap<EdgeId, ChainKind>, points: &mut IdVec<VertexId, Vec3>) -> usize {
        if self.options.smooth.is_empty() && self.weights.is_none() {
            return 0;
        }
        let levels = self.levels;
        let finest = &levels[levels.len() - 1].topology;
        let in_sets = self.in_sets();
        let is_in_sets = |face: FaceId| in_sets[self.source_face[face]];
        let weight = |v: VertexId| match &self.weights {
            _ if finest.faces_at(v).all(is_in_sets) => 1.0,
            Some(weights) => weights[v].clamp(0.0, 1.0),
            None => 0.0,
        };
        let weights: IdVec<VertexId, f32> = points.ids().map(weight).collect();
        let is_inside = |face| is_in_sets(face) || finest.faces.vertices_of(face).iter().any(|&v| weights[v] > 0.0);
        let constrained = kinds.keys().map(|&edge| levels[0].topology.edges[edge].to_vec()).collect();
        let mut is_edge = IdVec::<VertexId, bool>::filled(false, points.len());
        refine_paths(constrained, levels).pop().iter().flatten().flatten().for_each(|&v| is_edge[v] = true);
        let (fairing, closed) = Fairing::new(finest, &is_edge, is_inside);
        let modelled = points.clone();
        fairing.apply(points);
        for (v, point) in weights.ids().zip(points.iter_mut()).filter(|(v, point)| **point != modelled[*v]) {
            *point = modelled[v].lerp(*point, weights[v]);
        }
        closed
    }

    /// Whether each face of the garment is in a set.
    fn in_sets(&self) -> IdVec<FaceId, bool> {
        let mut is_in = IdVec::<FaceId, bool>::filled(false, self.garment.faces.len());
        for subset in self.options.smooth.iter().filter_map(|name| self.garment.subset(name)) {
            if let Elements::Faces(faces) = &subset.elements {
                faces.iter().for_each(|&face| is_in[face] = true);
            }
        }
        is_in
    }
}

/// The UV shells whose borders constrain nothing.
fn small_shells(garment: &Mesh, options: &SimOptions, lengths: Lengths<'_>, manifold: &Manifold) -> SmallShells {
    match &manifold.uv_channel {
        Some(channel) if options.smallest_shell > 0.0 => {
            SmallShells::new(garment, manifold, channel, lengths, options.smallest_shell)
        }
        _ => SmallShells::default(),
    }
}

/// Grades the targets of all vertices, if the options ask for it. Returns the number of shortened ones.
fn grade_targets(
    target: &mut IdVec<VertexId, f32>,
    options: &SimOptions,
    topology: &Topology,
    points: &IdVec<VertexId, Vec3>,
) -> usize {
    if options.grading <= 0.0 {
        return 0;
    }
    let all = target.clone();
    let all = all.enumerated().map(|(v, &length)| (v, length));
    grade(target, all, options.grading - 1.0, topology, points)
}

/// The chains on the surface.
struct FoundChains {
    chains: IdVec<ChainId, Chain>,
    /// The index of the level whose edges they follow: the cage, or its first refinement.
    traced: usize,
    /// Their vertices on that level and all finer ones.
    curves: Vec<Vec<Vec<VertexId>>>,
    /// Vertices of the cage beside feature lines, at which no chain has a corner.
    drawn: BTreeSet<VertexId>,
    narrow: Vec<NarrowStrip>,
    blunt: Vec<BluntRidge>,
}

fn find_chains(
    options: &SimOptions,
    manifold: &Manifold,
    mut kinds: BTreeMap<EdgeId, ChainKind>,
    mirror: &Mirror,
    levels: &[&Level],
    surface: &RefinedSurface<'_>,
) -> FoundChains {
    let rims = FeatureSurface { levels, surface: *surface, sharp: options.feature_turn() }.add_features(&mut kinds);
    let (mut traced, mut source) = (0, manifold.vertex_source.clone());
    if rims.has_crests() || levels.len() > 1 && !mirror.is_empty() {
        kinds = rims.refined_kinds(&kinds, [levels[0], levels[1]]);
        (traced, source) = (1, manifold.child_source());
    }
    if !mirror.is_empty() {
        mirror.constrain(traced, &levels[traced].topology, &mut kinds);
    }
    let paths = trace_paths(levels[traced], &kinds, |v| mirror.vertex(v));
    let curves = refine_paths(paths.iter().map(|p| p.vertices.clone()).collect(), &levels[traced..]);
    let on_surface = paths.iter().zip(&curves[levels.len() - 1 - traced]);
    let chains = on_surface.map(|(path, curve)| path.on_surface(curve, &source, surface)).collect();
    FoundChains { chains, traced, curves, drawn: rims.drawn, narrow: rims.narrow, blunt: rims.blunt }
}

/// Half-edges on chains and at borders.
fn barrier(t: &Topology, chains: &IdVec<ChainId, Chain>) -> IdVec<CornerId, bool> {
    let mut barrier: IdVec<CornerId, bool> = t.corner_edge.iter().map(|&e| t.is_border(e)).collect();
    for &half in chains.iter().flat_map(|c| c.left.iter().chain(&c.right)).flatten() {
        barrier[half] = true;
    }
    barrier
}

/// Gives each fan of faces at a vertex a vertex of its own; the first fan keeps the vertex. Returns the vertex behind each.
fn separate_fans(t: Topology, has_holes: bool) -> (Topology, IdVec<VertexId, VertexId>) {
    let mut source: IdVec<VertexId, VertexId> = (0..t.vertex_count()).map(VertexId::new).collect();
    if !has_holes {
        return (t, source);
    }
    let mut corners = t.faces.corners().clone();
    let mut fans = Groups::<CornerId>::new(corners.len());
    for corner in corners.ids() {
        if let Some(twin) = t.twin(corner) {
            fans.join(corner, t.faces.next(twin));
        }
    }
    for vertex in (0..t.vertex_count()).map(VertexId::new) {
        for &corner in t.vertex_corners.row(vertex).iter().skip(1) {
            let first = fans.first(corner);
            corners[corner] = if first == corner { source.push(vertex) } else { corners[first] };
        }
    }
    let count = source.len();
    (Topology::new(Faces::triangles(corners), count), source)
}
