//! One coarse garment mesh in, a simulation mesh and a render mesh out.
//!
//! [`build()`] makes both from plain data. A [`Builder`] does so again and again, and repeats only what an edit changes.
//! [`operator`] has the types for operators of your own. With the feature `usd` (on by default) [`usd`] reads the mesh from
//! a stage and writes the products beside it.
//!
//! ```
//! use tailor::glam::Vec3;
//! use tailor::{Garment, PrimvarInput, Recipe};
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
//! let mut recipe = Recipe::default();
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
//! Modules in data-flow order; each imports only those before it: `error` and `mesh` (connectivity without positions),
//! `garment` (the checked mesh with its attributes), `subdivide`, `contact` (distances and intersections), `sim`, `render`, `transfer`, `report` (figures), `recipe`
//! (all options), `cloth` (fabrics, pins, the shape at rest), `binding` and [`drive`] (the render mesh follows a simulation), `pipeline` (the steps and their results), then the doors `usd` and `session`. `docs/architecture.md` draws
//! them.

pub mod codes;
pub mod contact;
pub mod render;
pub mod report;
pub mod sets;
pub mod sim;
pub mod transfer;

pub use render::{FoldOptions, RenderOptions, RowSide, SeamOptions, Side};
pub use sim::{Relaxation, SimOptions};
pub use tailor_mesh::error::{self, Error, ErrorKind, Warning};
pub use tailor_mesh::{
    BoundaryInterpolation, Corner, Crease, FaceVaryingInterpolation, Family, FamilyType, Garment, Interpolation,
    Meaning, Mesh, Orientation, Primvar, PrimvarInput, Scheme, SubdivisionRules, Subset, SubsetInput, TriangleRule,
    Units, Values, glam,
};

/// Operators of your own for the render mesh.
///
/// ```
/// use std::sync::Arc;
/// use tailor::operator::{ChildBuilder, Control, Operator, OperatorInput, OperatorOutput, ControlRole};
/// use tailor::{Builder, Error, Mesh, Garment, Recipe, VertexId};
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
/// let mut builder = Builder::new(mesh)?;
/// builder.set_operators(vec![Arc::new(Quilt { height: 0.1 })]);
/// let mut recipe = Recipe::default();
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
