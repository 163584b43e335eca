//! One coarse garment mesh in, a simulation mesh and a render mesh out: the method of Waggoner and de Goes, *Revamping the Cloth
//! Tailoring Pipeline at Pixar* (SIGGRAPH Talks 2022), without USD.
//!
//! [`build()`] makes both meshes from plain data. A [`MeshBuilder`] does so again and again, and repeats only what an edit changes.
//! [`operator`] has the types for operators of your own. `tailor-costume` adds what a garment needs beyond the two meshes, and
//! `tailor-usd` reads and writes stages.
//!
//! ```
//! use tailor::glam::Vec3;
//! use tailor::{Garment, MeshRecipe, PrimvarInput};
//!
//! # fn main() -> Result<(), tailor::Error> {
//! // A strip of two quads.
//! let mut mesh = Garment::default();
//! mesh.points = (0..6).map(|i| Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0)).collect();
//! mesh.face_vertex_counts = vec![4, 4];
//! mesh.face_vertex_indices = vec![0, 1, 4, 3, 1, 2, 5, 4];
//! let uvs: Vec<[f32; 2]> = mesh.points.iter().map(|p| [p.x / 2.0, p.y]).collect();
//! mesh.primvars = vec![
//!     PrimvarInput::uvs("st", &uvs, mesh.face_vertex_indices.clone()),
//!     PrimvarInput::weights("stiff", vec![0.0, 0.5, 1.0, 0.0, 0.5, 1.0]),
//! ];
//! let mut recipe = MeshRecipe::default();
//! recipe.sim.max_edge_length = 0.4;
//! recipe.render.level = 2;
//!
//! let products = tailor::build(&mesh, &recipe)?;
//! assert!(products.sim.faces.ids().all(|face| products.sim.faces.valence(face) == 3));
//! assert_eq!(products.render.faces.len(), 2 * 16);
//! assert!(products.sim.primvars.iter().any(|primvar| primvar.name == "stiff"));
//! for warning in products.warnings.iter() {
//!     println!("{warning}");
//! }
//! # Ok(())
//! # }
//! ```
//!
//! `examples/two_meshes.rs` makes both meshes of a sheet with a seam.
//!
//! # The paper, and where it is
//!
//! Paths are below `src/tailor`.
//!
//! | step of the paper | file | where we differ |
//! |---|---|---|
//! | Refine the input to a baseline, with attributes by stencils | `sim/surface/refine.rs`, `sim/baseline/mod.rs` | |
//! | Constraints: borders, UV seams and chosen edges, as chains between anchors | `sim/constraints/cage_edges.rs`, `sim/constraints/chain.rs` | Folds that the lengths cannot follow are chains too (`sim/constraints/feature_lines.rs`) |
//! | Target lengths from painted weights | `sim/surface/lengths.rs` | |
//! | Start | `sim/baseline/start.rs` | From the refinement whose edges are nearest to their targets |
//! | The loop: split, collapse, flip, relax, project | `sim/passes/remesh.rs` | Queues are sorted sweeps; the first round works in patches, in parallel; it ends at `sim.iterations` rounds, or when nothing changes |
//! | Split long edges, the longest first | `sim/passes/split.rs` | At 5/4 of the target, 1.4 in the first round |
//! | Collapse short edges, the shortest first | `sim/passes/collapse.rs` | At 4/5 of the target, 0.7 in the first round |
//! | Flip | `sim/passes/flip.rs` | Valence and Delaunay, weighted; pairs of irregular vertices drift together (`sim/passes/drift.rs`) |
//! | Relax in the UVs | `sim/passes/relax_uv.rs` | An option: the default relaxes on the surface (`sim/passes/relax.rs`), which does not take over the distortion of UVs |
//! | Vertices of chains slide along their curves | `sim/passes/even.rs` | |
//! | Lift the result to the baseline | `sim/baseline/project.rs` | |
//! | After the rounds | `sim/passes/finish/mod.rs` | Thin triangles are made better, turned ones are turned back, chords follow their curves |
//! | Carry values by their places on the baseline | `transfer/vertices.rs`, `transfer/corners/mod.rs` | Joint influences are merged, not averaged |
//! | Carry face sets by stochastic samples | `transfer/coverage/mod.rs`, `transfer/faces/sets.rs` | Samples are sequences with a seed: the same mesh each time |
//! | Carry edge sets | `transfer/edges/mod.rs` | Sets on chains exactly, borders of face sets edge for edge, others as paths along their curves |
//! | Render mesh: fold-over thickness, refinement, seams | `render/stack.rs` | Seams run at the finest level that has room for them |
//! | Thickness | `render/fold.rs` | Painted; heights keep clear of other cloth (`render/points.rs`) |
//! | Seams | `render/seam.rs`, `render/lines/mod.rs` | Rows of stitches beside a seam (`render/parallels/mod.rs`) |
//! | Not in the paper: place and repair | `render/placement.rs`, `render/repair/mod.rs` | New points are fitted so that the limit surface stays, and lowered where faces would cross |
//!
//! [The method](https://doi.org/10.1145/3532836.3536252) stands on Botsch and Kobbelt, *A Remeshing Approach to Multiresolution
//! Modeling* (SGP 2004). Files name the sources of what is in them, and `docs/method.md` of the repository says why, with figures.
//!
//! # Modules
//!
//! In data-flow order: [`contact`] (distances and intersections), [`sets`] (expressions of sets), [`sim`], [`render`] with [`operator`],
//! [`transfer`], [`report`] (figures), [`recipe`] (the options of both meshes), [`pipeline`] (the steps and their last results). [`codes`] has
//! the codes of their errors and warnings. `tailor-mesh`, below, has the garment with its attributes, and subdivision.

pub mod codes;
pub mod contact;
pub mod pipeline;
pub mod recipe;
pub mod render;
pub mod report;
pub mod sets;
pub mod sim;
pub mod transfer;

pub use pipeline::{
    DEFAULT_MAX_FACES, MemoryEstimate, MeshBuilder, MeshPlan, Meshes, Progress, RenderUpdate, SimUpdate, Timing, build,
};
pub use recipe::MeshRecipe;
pub use render::{FoldOptions, RenderOptions, RowSide, SeamEnd, SeamOptions, Side};
pub use sim::{Relaxation, SimOptions};
pub use tailor_mesh::error::{self, Error, ErrorKind, Warning};
pub use tailor_mesh::{
    BoundaryInterpolation, Corner, CornerId, Crease, EdgeId, Elements, FaceId, FaceVaryingInterpolation, Faces, Family,
    FamilyType, Garment, Interpolation, Meaning, Mesh, Orientation, Primvar, PrimvarInput, Scheme, SubdivisionRules,
    Subset, SubsetInput, TriangleRule, Units, Values, VertexId, glam,
};

/// Operators of your own for the render mesh.
///
/// ```
/// use std::sync::Arc;
/// use tailor::operator::{ChildBuilder, Control, Operator, OperatorInput, OperatorOutput, ControlRole};
/// use tailor::{Error, Garment, Mesh, MeshBuilder, MeshRecipe, VertexId};
///
/// /// Raises the middle of every face.
/// struct Quilt {
///     height: f32,
/// }
///
/// impl Operator for Quilt {
///     fn label(&self) -> String {
///         "quilt".into()
///     }
///
///     fn reach(&self, _: &Mesh) -> f32 {
///         self.height.abs()
///     }
///
///     fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
///         let t = cage.topology();
///         let mut child = ChildBuilder::new(t);
///         let mut controls = Vec::new();
///         for face in t.faces.ids() {
///             let corners = t.faces.vertices_of(face);
///             let share = 0.5 / corners.len() as f32;
///             // Halfway from each corner to the centre of the face.
///             let weight = |corner: VertexId, v: VertexId| if v == corner { 0.5 + share } else { share };
///             let mut inner: Vec<VertexId> = Vec::new();
///             for &corner in corners {
///                 let sources: Vec<_> = corners.iter().map(|&v| (v, weight(corner, v))).collect();
///                 inner.push(child.vertex(&sources));
///             }
///             for i in 0..corners.len() {
///                 let next = (i + 1) % corners.len();
///                 child.face(face, &[corners[i], corners[next], inner[next], inner[i]]);
///             }
///             child.face(face, &inner);
///             controls.extend(inner.into_iter().map(|vertex| Control { vertex, role: ControlRole::Raised }));
///         }
///         for (edge, &ends) in t.edges.enumerated() {
///             child.edge(edge, ends);
///         }
///         Ok(OperatorOutput { controls, ..OperatorOutput::new(child.finish(), cage) })
///     }
///
///     fn heights(&self, output: &OperatorOutput) -> Vec<f32> {
///         output.controls.iter().map(|_| self.height).collect()
///     }
/// }
///
/// # fn main() -> Result<(), Error> {
/// let mut mesh = Garment::default();
/// mesh.points = (0..9).map(|i| glam::Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0)).collect();
/// mesh.face_vertex_counts = vec![4; 4];
/// mesh.face_vertex_indices = vec![0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7];
/// let mut builder = MeshBuilder::new(mesh)?;
/// builder.set_operators(vec![Arc::new(Quilt { height: 0.1 })]);
/// let mut recipe = MeshRecipe::default();
/// recipe.render.level = 3;
/// let products = builder.update(&recipe)?;
/// // The limit surface is as high as asked above the inner vertices, and a little higher between them.
/// let highest = products.render.points.iter().map(|p| p.z).fold(0.0, f32::max);
/// assert!((0.1..0.13).contains(&highest), "{highest}");
///
/// // An edit of the operator.
/// builder.set_operators(vec![Arc::new(Quilt { height: 0.05 })]);
/// let lower = builder.update(&recipe)?;
/// assert!(lower.render.points.iter().all(|p| p.z < highest));
/// # Ok(())
/// # }
/// ```
pub mod operator {
    pub use crate::render::child::{ChildBuilder, OperatorDerivation, Table};
    pub use crate::render::operator::{Control, ControlRole, LayerEnd, Operator, OperatorInput, OperatorOutput};
}
