//! The garment mesh, without USD types.
//!
//! [`check_garment`] turns a [`Garment`], the mesh as authored, into a [`Mesh`], or lists its faults. Products are
//! [`Mesh`]s too, so that the output of an operator is the input of the next.

mod check;
mod face_numbers;
mod input;
pub mod joints;
pub mod parts;
mod primvar;
pub mod sew;
mod space;
mod subset;
pub mod units;
mod uv_seams;

pub use crate::connectivity::Elements;
pub use check::check_garment;
pub use check::split_repeats;
pub use face_numbers::FaceNumbers;
pub use input::{Garment, LeftOut, PrimvarInput, SubsetInput};
pub use primvar::{Interpolation, Meaning, Mixing, Primvar, PrimvarRole, Values};
pub use space::StageSpace;
pub use subset::{CONSTRAINTS, DERIVED, face_sets_warning, free_name};
pub use subset::{Family, FamilyType, Subset};
pub use units::Units;
pub use uv_seams::UvSeams;

use crate::connectivity::{FaceId, Faces, IdVec, VertexId};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The vertex primvar of a fitted garment's points on the body that it was made for.
pub const FIT_FROM: &str = "tailor:fitFrom";

/// The winding of faces seen from the front, as `UsdGeomGprim.orientation`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// Counter-clockwise.
    #[default]
    RightHanded,
    /// Clockwise.
    LeftHanded,
}

/// The limit surface of a cage, as `UsdGeomMesh.subdivisionScheme`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Scheme {
    /// Catmull-Clark, the default.
    #[default]
    CatmullClark,
    /// Loop; triangles only.
    Loop,
    /// The faces, split into quads.
    Bilinear,
    /// A polygonal mesh.
    None,
}

/// The rule at mesh borders, as `UsdGeomMesh.interpolateBoundary`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BoundaryInterpolation {
    /// Faces at borders are holes.
    None,
    /// Border edges are sharp.
    EdgeOnly,
    /// Border edges are sharp, and so are vertices of a single face.
    #[default]
    EdgeAndCorner,
}

/// Where face-varying values are interpolated linearly, as `UsdGeomMesh.faceVaryingLinearInterpolation`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FaceVaryingInterpolation {
    /// Smooth everywhere.
    None,
    /// Sharp at corners.
    CornersOnly,
    /// Sharp at corners and where more than two regions meet.
    #[default]
    CornersPlus1,
    /// As `CornersPlus1`, and at darts and concave corners.
    CornersPlus2,
    /// Sharp along region borders.
    Boundaries,
    /// Linear everywhere.
    All,
}

/// The weights for triangles under Catmull-Clark, as `UsdGeomMesh.triangleSubdivisionRule`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TriangleRule {
    /// The ordinary weights.
    #[default]
    CatmullClark,
    /// Weights that make triangles smoother.
    Smooth,
}

/// The subdivision options of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SubdivisionRules {
    /// The scheme.
    pub scheme: Scheme,
    /// The rule at mesh borders.
    pub boundary: BoundaryInterpolation,
    /// The rule at borders of face-varying regions.
    pub face_varying: FaceVaryingInterpolation,
    /// The rule for triangles.
    pub triangles: TriangleRule,
}

/// A crease: a path of vertices, each step an edge of the mesh with a sharpness.
#[derive(Clone, Debug, PartialEq)]
pub struct Crease {
    /// The vertices along the crease; at least two.
    pub vertices: Vec<VertexId>,
    /// One sharpness for each edge; ten or more is infinite.
    pub sharpnesses: Vec<f32>,
}

/// A sharp vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The vertex.
    pub vertex: VertexId,
    /// Its sharpness; ten or more is infinite.
    pub sharpness: f32,
}

/// A checked mesh with all its attributes.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name of the mesh in messages: its prim path.
    pub prim: String,
    /// Positions in local space. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The faces as authored.
    pub faces: Faces,
    /// The size of its unit of length.
    pub units: Units,
    /// The length of one unit of UV sets that say so, in units of the mesh.
    pub uv_scales: BTreeMap<String, f32>,
    /// How its space lies in the stage.
    pub space: StageSpace,
    /// The name of the material of each subset that has one; that of the whole mesh under an empty name.
    pub materials: BTreeMap<String, String>,
    /// The winding of the faces.
    pub orientation: Orientation,
    /// The subdivision rules.
    pub rules: SubdivisionRules,
    /// Faces that are not drawn.
    pub holes: Vec<FaceId>,
    /// Sharp edges.
    pub creases: Vec<Crease>,
    /// Sharp vertices.
    pub corners: Vec<Corner>,
    /// Primvars that vary over the mesh; constant ones are copied as they are by the writer.
    pub primvars: Arc<Vec<Primvar>>,
    /// Primvars of the model that have faults, and are not among `primvars`.
    pub left_out: Vec<LeftOut>,
    /// The joint influences of each vertex while operators and refinements work on them. They are pruned to
    /// `elementSize` once, at the end.
    pub influences: Option<Arc<Vec<joints::Influences>>>,
    /// Named sets of faces, edges and points.
    pub subsets: Arc<Vec<Subset>>,
    /// Families of subsets with their rules.
    pub families: Vec<Family>,
}

impl Mesh {
    /// The primvar called `name` (without `primvars:`).
    pub fn primvar(&self, name: &str) -> Option<&Primvar> {
        self.primvars.iter().find(|p| p.name == name)
    }

    /// The primvar called `name` (without `primvars:`) that was left out, if one was.
    pub fn left_out(&self, name: &str) -> Option<&LeftOut> {
        self.left_out.iter().find(|left_out| left_out.name == name)
    }

    /// The subset called `name`.
    pub fn subset(&self, name: &str) -> Option<&Subset> {
        self.subsets.iter().find(|s| s.name == name)
    }

    /// The normal of a face with twice its area as length. \[square mesh units\]
    pub fn doubled_normal(&self, face: FaceId) -> DVec3 {
        let vertices = self.faces.vertices_of(face);
        let at = |v: &VertexId| self.points[*v].as_dvec3();
        let origin = at(&vertices[0]);
        vertices.windows(2).map(|p| (at(&p[0]) - origin).cross(at(&p[1]) - origin)).sum()
    }

    /// The least and the largest coordinates of the points that faces use. \[mesh units\]
    pub fn bounds(&self) -> [Vec3; 2] {
        let points = self.faces.corners().iter().map(|&v| self.points[v]);
        let box_of = |[low, high]: [Vec3; 2], p: Vec3| [low.min(p), high.max(p)];
        points.map(|p| [p, p]).reduce(|all, [p, _]| box_of(all, p)).unwrap_or_default()
    }

    /// The diagonal of [`Self::bounds`]. \[mesh units\]
    pub fn size(&self) -> f32 {
        let [low, high] = self.bounds().map(|p| p.as_dvec3());
        low.distance(high) as f32
    }

    /// An estimate of its memory. \[bytes\]
    pub fn bytes(&self) -> usize {
        let subset = |s: &Subset| s.elements.len() * if matches!(s.elements, Elements::Edges(_)) { 8 } else { 4 };
        let attributes = self.primvars.iter().map(Primvar::bytes).chain(self.subsets.iter().map(subset));
        12 * self.points.len() + 4 * self.faces.corners().len() + attributes.sum::<usize>()
    }
}
