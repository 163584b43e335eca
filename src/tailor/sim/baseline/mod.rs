//! The surface that the simulation mesh lies on: the garment refined, in triangles, with its chains.

mod build;
pub mod facets;
mod level;
mod mirror;
pub mod project;
mod start;

pub use level::baseline_level;
pub use project::Projection;

use crate::sim::constraints::cage_edges::StartSpan;
use crate::sim::constraints::chain::Chain;
use crate::sim::constraints::feature_lines::{BluntRidge, NarrowStrip};
use crate::sim::surface::manifold::Manifold;
use crate::sim::surface::small_shells::SmallShells;
use facets::Facet;
use glam::{Vec2, Vec3};
use mirror::Mirror;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{ChainId, CornerId, FaceId, IdVec, Topology, VertexId};
use tailor_mesh::garment::Primvar;
use tailor_mesh::subdivide::{Level, Real, child_values};

/// A point of the baseline, in barycentric coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselinePoint {
    /// The triangle.
    pub face: FaceId,
    /// Weights of its corners; they sum to 1.
    pub weights: Vec3,
}

/// The triangulated baseline.
pub struct Baseline {
    /// The manifold cage and the garment's elements behind it.
    pub manifold: Manifold,
    /// The refined levels after the cage. The last one, or the cage if there is none, is triangulated.
    pub levels: Vec<Level>,
    /// The vertex of the finest level behind each vertex. They differ where holes leave fans that only touch.
    pub level_vertex: IdVec<VertexId, VertexId>,
    /// Positions. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The triangles and their adjacency.
    pub topology: Topology,
    /// The constraint UVs of each corner; zero without a UV set.
    pub uvs: IdVec<CornerId, Vec2>,
    /// Whether there is a UV set. It is one to one over each piece between chains, so that remeshing can keep triangles from
    /// flipping there.
    pub has_uvs: bool,
    /// The face of the finest level behind each triangle.
    pub level_face: IdVec<FaceId, FaceId>,
    /// The corner of the finest level behind each corner of a triangle.
    pub level_corner: IdVec<CornerId, CornerId>,
    /// The garment's face behind each triangle.
    pub source_face: IdVec<FaceId, FaceId>,
    /// Half-edges that no projection crosses: those on chains and at borders.
    pub barrier: IdVec<CornerId, bool>,
    /// The triangles as projections read them.
    pub facets: IdVec<FaceId, Facet>,
    /// Number of closed details in `sim.smooth`, which are left as they are.
    pub closed_details: usize,
    /// UV shells whose borders constrain nothing.
    pub small_shells: SmallShells,
    /// The triangles whose UVs are flipped or degenerate.
    pub flipped: Vec<FaceId>,
    /// Target edge length at each vertex. \[mesh units\]
    pub target: IdVec<VertexId, f32>,
    /// Number of vertices whose target grading shortened.
    pub graded: usize,
    /// Folds that are too near to a chain to be one.
    pub narrow: Vec<NarrowStrip>,
    /// Lines that are not quite sharp enough for a chain.
    pub blunt: Vec<BluntRidge>,
    /// Target edge length at each vertex, shortened near chains that bend. \[mesh units\]
    pub sizing: IdVec<VertexId, f32>,
    /// The constraint chains.
    pub chains: IdVec<ChainId, Chain>,
    /// The index of the level whose edges the chains follow: the cage, or its first refinement.
    pub traced: usize,
    /// The triangles that remeshing starts from, by corners of the baseline.
    pub start: Vec<[CornerId; 3]>,
    /// Parts of chains that the start's constrained edges cover, by their vertices.
    pub start_spans: BTreeMap<[VertexId; 2], StartSpan>,
    /// The sides of a garment whose triangles are to be symmetric.
    pub mirror: Mirror,
}

impl Baseline {
    /// The levels that are refined on the way to the triangles, from the cage on.
    pub fn parents(&self) -> impl Iterator<Item = &Level> {
        self.manifold.parents(&self.levels)
    }

    /// The triangles that the lengths near chains ask for, all of them equilateral.
    pub fn expected_faces(&self) -> f64 {
        let wanted = self.topology.faces.ids().map(|f| {
            let sum: f64 = self.topology.faces.vertices_of(f).iter().map(|&v| f64::from(self.sizing[v])).sum();
            let target = sum / 3.0;
            0.5 * self.normal(f).as_dvec3().length() / (0.25 * 3f64.sqrt() * target * target)
        });
        wanted.sum()
    }

    /// The edges that the chains ask for, each between two of its corners or ends at least one.
    pub fn chain_edges(&self) -> f64 {
        self.chains.iter().map(|c| f64::from(c.spaced[c.spaced.len() - 1]) + (c.pins.len() + 1) as f64).sum()
    }

    /// The garment's corner whose part of its face a triangle lies in.
    pub fn source_corner(&self, face: FaceId) -> CornerId {
        let mut level_face = self.level_face[face];
        let mut corner = self.level_corner[CornerId::new(face.index() * 3)];
        for parent in self.parents().collect::<Vec<_>>().into_iter().rev() {
            corner = parent.corner_of_child(level_face);
            level_face = parent.topology.faces.face_of(corner);
        }
        self.manifold.corner_source[corner]
    }

    /// The vertices of the finest level on the curves and areas that points of the garment span: the edges with both ends in the set,
    /// and the faces with all corners.
    pub fn spanned(&self, points: &[VertexId]) -> IdVec<VertexId, bool> {
        let sources = &self.manifold.vertex_source;
        let wanted: BTreeSet<VertexId> = points.iter().copied().collect();
        let mut marked: IdVec<VertexId, bool> = sources.iter().map(|source| wanted.contains(source)).collect();
        for parent in self.parents() {
            let t = &parent.topology;
            let all = |vertices: &[VertexId]| vertices.iter().all(|&v| marked[v]);
            marked = child_values(parent, &marked, |f| all(t.faces.vertices_of(f)), |e| all(&t.edges[e]));
        }
        marked
    }

    /// The rows of a vertex or varying primvar at the vertices of the finest level. `values` are the primvar's.
    pub fn refine_rows<T: Real>(&self, primvar: &Primvar, values: &[T]) -> Vec<T> {
        self.manifold.refine_rows(&self.levels, primvar, values)
    }
}
