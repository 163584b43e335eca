//! Feature lines: edges of the surface that are sharper than the target length can follow. Edges across such a one cut it off and
//! leave it jagged, so the edges of the cage along it become chains.
//!
//! A rim has two sharp edges, or many, with a strip between them that may be thinner than triangles. Lines of sharp edges are therefore
//! chosen as wholes, the sharpest first, and none beside another chain: what lies between is drawn to that chain along its
//! whole length. Between two such sharp edges the surface is highest in the middle of the strip, so the feature line is there.

use super::cage_edges::refine_paths;
use super::chain::ChainKind;
use super::sharp_lines::{SharpEdges, lines};
use crate::sim::geometry::angle;
use crate::sim::surface::triangulation::RefinedSurface;
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Scheme;
use tailor_mesh::subdivide::{Level, Numbering};

/// The ends of a feature line turn by at least this share of the angle that makes one. Smaller values make longer feature lines.
const ENDS: f32 = 0.75;
/// The inside of a feature line turns by at least this share.
const INSIDE: f32 = 0.5;
/// A line that turns by at least this share is nearly a feature line.
const NEARLY: f32 = 2.0 / 3.0;
/// Least total length of a feature line's sharp edges, as a multiple of the target length.
const LEAST_LENGTH: f32 = 2.0;
/// Two parallel chains are at least this multiple of the target length apart: triangles between nearer ones are thin.
const APART: f32 = 0.5;
/// A feature line is at least this multiple of the target length from any other chain. What is nearer to a border or a seam is drawn
/// to it, and facets of the turn stay.
const APART_FROM_CHAINS: f32 = 0.15;
/// Sharpness from which on an edge is a line that its author drew.
const CREASE: f32 = 1.0;
/// Its least turn within one target length. \[radians\]
const CREASE_TURN: f32 = 30.0 * std::f32::consts::PI / 180.0;
/// Least dihedral of a sharp edge: it is sharper on the cage than on the refined surface. \[radians\]
const LEAST_DIHEDRAL: f32 = 0.3;
/// Most faces of a walk across parallel edges.
const MAX_STEPS: usize = 64;

/// How the surface bends across an edge of the cage.
pub(super) struct SharpEdge {
    /// The turn of the normal within one target length, as a share of the turn that makes a feature line there.
    pub bend: f32,
    /// In target lengths.
    pub length: f32,
}

/// A chain beside a sharp edge that is too near to it to be a chain itself.
#[derive(Clone, Copy)]
struct Neighbour {
    edge: EdgeId,
    /// \[target lengths\]
    distance: f32,
}

/// A sharp edge that is too near to a chain to be one itself.
#[derive(Clone, Debug)]
pub struct NarrowStrip {
    /// A vertex of the manifold cage on it.
    pub vertex: VertexId,
    /// The number of its edges of the cage.
    pub edges: usize,
    /// The largest distance to the chain, which bounds how far the surface moves. \[target lengths\]
    pub width: f32,
}

/// A line of edges that are nearly sharp enough for a feature line, so that triangles may cut it off.
#[derive(Clone, Debug)]
pub struct BluntRidge {
    /// A vertex of the manifold cage on it.
    pub vertex: VertexId,
    /// The number of its edges of the cage.
    pub edges: usize,
    /// \[target lengths\]
    pub length: f32,
}

/// A quad of the cage whose middle line is on a feature line.
#[derive(Clone, Copy)]
struct Crest {
    face: FaceId,
    /// The two edges that the line crosses.
    rungs: [EdgeId; 2],
}

/// A part of a feature line.
enum Part<'a> {
    Edges(&'a [EdgeId]),
    Crest(Vec<Crest>),
}

/// The parts of feature lines that are not edges of the cage, and the sharp edges that are not feature lines.
#[derive(Default)]
pub struct Rims {
    crests: Vec<Crest>,
    /// The sharp edges that are too near to chains to be some.
    pub narrow: Vec<NarrowStrip>,
    /// The lines that are not quite sharp enough to be some.
    pub blunt: Vec<BluntRidge>,
    /// The vertices of the cage that are drawn to a chain beside them. No chain has a corner there.
    pub drawn: BTreeSet<VertexId>,
}

impl Rims {
    /// Whether feature lines run along edges of the first refinement that the cage lacks.
    pub fn has_crests(&self) -> bool {
        !self.crests.is_empty()
    }

    /// The kinds of constrained edges on the first refinement, from those of the cage.
    pub fn refined_kinds(
        &self,
        kinds: &BTreeMap<EdgeId, ChainKind>,
        [cage, child]: [&Level; 2],
    ) -> BTreeMap<EdgeId, ChainKind> {
        let numbering = Numbering::new(cage);
        let find = |a, b| child.topology.find_edge(a, b);
        let halves = |edge: EdgeId| cage.topology.edges[edge].map(|v| find(v, numbering.of_edge(edge)));
        let mut refined: BTreeMap<EdgeId, ChainKind> = BTreeMap::new();
        for (&edge, kind) in kinds {
            refined.extend(halves(edge).into_iter().flatten().map(|half| (half, kind.clone())));
        }
        for crest in &self.crests {
            let halves = crest.rungs.map(|rung| find(numbering.of_edge(rung), numbering.of_face(crest.face)));
            refined.extend(halves.into_iter().flatten().map(|half| (half, ChainKind::FEATURE)));
        }
        let ends = self.ends_on_features(&cage.topology, kinds);
        for half in ends.filter_map(|(rung, v)| find(v, numbering.of_edge(rung))) {
            refined.entry(half).or_insert(ChainKind::FEATURE).feature = true;
        }
        refined
    }

    /// The rungs at the ends of crests, with those of their own ends at which a feature line goes on.
    fn ends_on_features<'a>(
        &'a self,
        t: &'a Topology,
        kinds: &BTreeMap<EdgeId, ChainKind>,
    ) -> impl Iterator<Item = (EdgeId, VertexId)> + 'a {
        let lines = kinds.iter().filter(|(_, kind)| kind.feature);
        let on_feature: BTreeSet<VertexId> = lines.flat_map(|(&edge, _)| t.edges[edge]).collect();
        let mut crests_at = BTreeMap::<EdgeId, usize>::new();
        self.crests.iter().flat_map(|crest| crest.rungs).for_each(|rung| *crests_at.entry(rung).or_default() += 1);
        let last = crests_at.into_iter().filter(|&(_, count)| count == 1).map(|(rung, _)| rung);
        last.flat_map(move |rung| t.edges[rung].map(|v| (rung, v))).filter(move |(_, v)| on_feature.contains(v))
    }
}

/// The cage, its refinements and its surface. The last of `levels` is the surface's.
#[derive(Clone, Copy)]
pub struct FeatureSurface<'a> {
    pub levels: &'a [&'a Level],
    pub surface: RefinedSurface<'a>,
    /// The turn within one target length that makes a feature line. \[radians\]
    pub sharp: f32,
}

impl<'a> FeatureSurface<'a> {
    fn cage(&self) -> &'a Topology {
        &self.levels[0].topology
    }

    /// Adds the feature lines among the unconstrained edges of the cage to `kinds`.
    pub fn add_features(&self, kinds: &mut BTreeMap<EdgeId, ChainKind>) -> Rims {
        let sharp_edges = self.sharp_edges(kinds);
        let mut narrow = BTreeMap::new();
        kinds.keys().for_each(|&edge| self.leave_narrow(edge, APART_FROM_CHAINS, &sharp_edges, &mut narrow));
        let mut found = lines(self.cage(), self.surface.points, &sharp_edges);
        found.sort_by(|a, b| b.strength.total_cmp(&a.strength).then_with(|| a.edges.cmp(&b.edges)));
        let mut rims = Rims::default();
        for line in &found {
            let runs: Vec<&[EdgeId]> = line.runs(|edge| !narrow.contains_key(&edge)).collect();
            for line in runs.into_iter().filter_map(|run| self.feature_line(run, &sharp_edges)) {
                for part in self.parts(line, &sharp_edges, &narrow) {
                    match part {
                        Part::Edges(edges) => kinds.extend(edges.iter().map(|&edge| (edge, ChainKind::FEATURE))),
                        Part::Crest(faces) => rims.crests.extend(faces),
                    }
                }
                line.iter().for_each(|&edge| self.leave_narrow(edge, APART, &sharp_edges, &mut narrow));
            }
        }
        for line in &found {
            let lost =
                line.runs(|edge| narrow.contains_key(&edge)).filter_map(|run| self.feature_line(run, &sharp_edges));
            rims.narrow.extend(lost.map(|edges| self.narrow_strip(edges, &narrow, kinds)));
            let blunt = line.runs(|edge| !narrow.contains_key(&edge) && !kinds.contains_key(&edge));
            rims.blunt.extend(blunt.filter_map(|run| self.blunt_ridge(run, &sharp_edges)));
        }
        let t = self.cage();
        rims.drawn = narrow.keys().flat_map(|&edge| t.edges[edge]).collect();
        rims.drawn.extend(rims.crests.iter().flat_map(|crest| t.faces.vertices_of(crest.face)));
        rims
    }

    /// The strip between a sharp edge that is not a chain and the chains beside it, which become feature lines too.
    fn narrow_strip(
        &self,
        edges: &[EdgeId],
        narrow: &BTreeMap<EdgeId, Neighbour>,
        kinds: &mut BTreeMap<EdgeId, ChainKind>,
    ) -> NarrowStrip {
        let mut width = 0.0f32;
        for Neighbour { edge, distance } in edges.iter().map(|edge| narrow[edge]) {
            match kinds.get_mut(&edge) {
                Some(kind) => {
                    kind.feature = true;
                    width = width.max(distance);
                }
                // The feature line is in the middle of the strip.
                None => width = width.max(0.5 * distance),
            }
        }
        NarrowStrip { vertex: self.cage().edges[edges[0]][0], edges: edges.len(), width }
    }

    /// The part of a line that is nearly a feature line, if there is one.
    fn blunt_ridge(&self, run: &[EdgeId], sharp_edges: &SharpEdges) -> Option<BluntRidge> {
        let nearly = || run.iter().filter(|edge| sharp_edges[edge].bend > NEARLY);
        let length: f32 = nearly().map(|edge| sharp_edges[edge].length).sum();
        let vertex = self.cage().edges[*nearly().next()?][0];
        (length >= LEAST_LENGTH).then(|| BluntRidge { vertex, edges: nearly().count(), length })
    }

    /// The parts of a feature line that run along its edges, and those that run along the middle of a strip beside them.
    fn parts<'e>(
        &self,
        line: &'e [EdgeId],
        sharp_edges: &SharpEdges,
        narrow: &BTreeMap<EdgeId, Neighbour>,
    ) -> Vec<Part<'e>> {
        let strips: Vec<Option<Crest>> = line.iter().map(|&edge| self.crest(edge, sharp_edges, narrow)).collect();
        let are_joined = |a: &Option<Crest>, b: &Option<Crest>| match (a, b) {
            (Some(a), Some(b)) => a.rungs.iter().any(|rung| b.rungs.contains(rung)),
            (a, b) => a.is_none() && b.is_none(),
        };
        let mut first = 0;
        let parts = strips.chunk_by(are_joined).map(|strip| {
            let edges = &line[first..first + strip.len()];
            first += strip.len();
            let length: f32 = edges.iter().map(|edge| sharp_edges[edge].length).sum();
            match strip.iter().copied().collect::<Option<Vec<Crest>>>() {
                Some(faces) if length >= LEAST_LENGTH => Part::Crest(faces),
                _ => Part::Edges(edges),
            }
        });
        parts.collect()
    }

    /// The quad beside an edge of a feature line whose opposite edge is a sharp edge as well, too near to be a chain, if there is one side
    /// with such a quad.
    fn crest(&self, edge: EdgeId, sharp_edges: &SharpEdges, narrow: &BTreeMap<EdgeId, Neighbour>) -> Option<Crest> {
        let t = self.cage();
        if self.levels.len() == 1 || self.levels[0].scheme == Scheme::Loop {
            return None;
        }
        let is_strip = |&corner: &CornerId| {
            let other = self.opposite(corner).map(|c| t.corner_edge[c]);
            other.is_some_and(|other| {
                let is_sharp = sharp_edges.get(&other).is_some_and(|sharp_edge| sharp_edge.bend > ENDS);
                is_sharp && !narrow.contains_key(&other) && self.distance(edge, other) < APART
            })
        };
        let mut strips = t.edge_corners.row(edge).iter().copied().filter(is_strip);
        let corner = strips.next().filter(|_| strips.next().is_none())?;
        let rungs = [t.faces.next(corner), t.faces.prev(corner)].map(|c| t.corner_edge[c]);
        Some(Crest { face: t.faces.face_of(corner), rungs })
    }

    /// The opposite corner of a quad.
    fn opposite(&self, corner: CornerId) -> Option<CornerId> {
        let faces = &self.cage().faces;
        (faces.valence(faces.face_of(corner)) == 4).then(|| faces.next(faces.next(corner)))
    }

    /// The distance between the middles of two edges. \[target lengths\]
    fn distance(&self, a: EdgeId, b: EdgeId) -> f32 {
        self.middle(a).distance(self.middle(b)) / self.target(b)
    }

    /// The part of a line that is a feature line, without its blunt ends, if there is one.
    fn feature_line<'e>(&self, run: &'e [EdgeId], sharp_edges: &SharpEdges) -> Option<&'e [EdgeId]> {
        let is_end = |edge: &EdgeId| sharp_edges[edge].bend > ENDS;
        let (first, last) = (run.iter().position(is_end)?, run.iter().rposition(is_end)?);
        let sharp = run[first..=last].iter().map(|edge| &sharp_edges[edge]).filter(|sharp_edge| sharp_edge.bend > 1.0);
        (sharp.map(|sharp_edge| sharp_edge.length).sum::<f32>() >= LEAST_LENGTH).then(|| &run[first..=last])
    }

    /// The unconstrained edges of the cage across which the surface bends.
    fn sharp_edges(&self, kinds: &BTreeMap<EdgeId, ChainKind>) -> SharpEdges {
        let (t, at) = (self.cage(), |v: VertexId| self.surface.points[v]);
        let normal = |face: FaceId| {
            let vertices = t.faces.vertices_of(face);
            let origin = at(vertices[0]);
            let fan = vertices.windows(2).map(|p| (at(p[0]) - origin).cross(at(p[1]) - origin));
            fan.sum::<Vec3>().normalize_or_zero()
        };
        let normals: IdVec<FaceId, Vec3> = t.faces.ids().map(normal).collect();
        let is_bent = |&edge: &EdgeId| match *t.edge_corners.row(edge) {
            [a, b] => {
                let (m, n) = (normals[t.faces.face_of(a)], normals[t.faces.face_of(b)]);
                !kinds.contains_key(&edge) && angle(m, n) > LEAST_DIHEDRAL
            }
            _ => false,
        };
        let edges: Vec<EdgeId> = t.edges.ids().filter(is_bent).collect();
        let curves = refine_paths(edges.iter().map(|&e| t.edges[e].to_vec()).collect(), self.levels);
        let measured = edges.iter().zip(&curves[self.levels.len() - 1]).filter_map(|(&edge, curve)| {
            let steps = curve.windows(2);
            let turn = steps.clone().map(|p| self.surface.bend(p[0], p[1])).sum::<f32>() / steps.len() as f32;
            let bend = turn / self.sharp_turn(edge);
            let length = steps.map(|p| at(p[0]).distance(at(p[1]))).sum::<f32>() / self.target(edge);
            (bend > INSIDE).then_some((edge, SharpEdge { bend, length }))
        });
        measured.collect()
    }

    /// The turn within one target length that makes a feature line at an edge. \[radians\]
    fn sharp_turn(&self, edge: EdgeId) -> f32 {
        let is_crease = self.levels[0].edge_sharpness[edge] >= CREASE && self.sharp.is_finite();
        if is_crease { self.sharp.min(CREASE_TURN) } else { self.sharp }
    }

    fn target(&self, edge: EdgeId) -> f32 {
        self.cage().edges[edge].map(|v| self.surface.target[v]).into_iter().sum::<f32>() / 2.0
    }

    fn middle(&self, edge: EdgeId) -> Vec3 {
        let [a, b] = self.cage().edges[edge].map(|v| self.surface.points[v]);
        a.midpoint(b)
    }

    /// Marks the sharp edges that are parallel to an edge, over quads on both sides, and less than `apart` target lengths from it.
    fn leave_narrow(
        &self,
        edge: EdgeId,
        apart: f32,
        sharp_edges: &SharpEdges,
        narrow: &mut BTreeMap<EdgeId, Neighbour>,
    ) {
        let t = self.cage();
        for &corner in t.edge_corners.row(edge) {
            let (mut half, mut own, mut passed) = (Some(corner), edge, 0.0);
            for _ in 0..MAX_STEPS {
                let Some(opposite) = half.and_then(|half| self.opposite(half)) else { break };
                let other = t.corner_edge[opposite];
                passed += self.distance(own, other);
                if passed >= apart || other == edge {
                    break;
                }
                if sharp_edges.contains_key(&other) {
                    narrow.entry(other).or_insert(Neighbour { edge, distance: passed });
                }
                (half, own) = (t.twin(opposite), other);
            }
        }
    }
}
