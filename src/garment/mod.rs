//! The input model, without any USD type: what a garment mesh is before and after it is checked.
//!
//! [`GarmentInput`] holds what a file said, [`check_garment`] turns it into a [`Garment`] or says what is wrong.
//! Every product is a [`Garment`] again, so that one operator's output is the next one's input.

mod check;
mod input;
pub mod joints;
mod primvar;
mod shared;
mod subset;

pub use check::{GarmentError, Problem, check_garment};
pub use input::{GarmentInput, PrimvarInput, SubsetInput};
pub use primvar::{Interpolation, Mixing, Primvar, PrimvarRole, Values};
pub use shared::Shared;
pub use subset::{Elements, Family, FamilyType, Subset};

use crate::mesh::{FaceId, Faces, IdVec, VertexId};
use glam::Vec3;

/// Which side of a face is its front, as `UsdGeomGprim.orientation`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// Counter-clockwise faces are seen from the front.
    #[default]
    RightHanded,
    /// Clockwise faces are seen from the front.
    LeftHanded,
}

/// The surface that a cage stands for, as `UsdGeomMesh.subdivisionScheme`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Scheme {
    /// Catmull-Clark, the default.
    #[default]
    CatmullClark,
    /// Loop; triangles only.
    Loop,
    /// The faces themselves, split in quads.
    Bilinear,
    /// A polygonal mesh.
    None,
}

/// What happens at mesh borders, as `UsdGeomMesh.interpolateBoundary`.
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

/// Where face-varying values are kept linear, as `UsdGeomMesh.faceVaryingLinearInterpolation`.
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
pub struct Garment {
    /// Name of the mesh in messages: its prim path.
    pub prim: String,
    /// Positions, local space. [stage units]
    pub points: IdVec<VertexId, Vec3>,
    /// The faces as they were authored.
    pub faces: Faces,
    /// Which side is the front.
    pub orientation: Orientation,
    /// How the surface follows from the cage.
    pub rules: SubdivisionRules,
    /// Faces that are not drawn.
    pub holes: Vec<FaceId>,
    /// Sharp edges.
    pub creases: Vec<Crease>,
    /// Sharp vertices.
    pub corners: Vec<Corner>,
    /// Primvars that vary over the mesh; constant ones are copied as they are by the writer.
    pub primvars: Shared<Vec<Primvar>>,
    /// Named sets of faces, edges and points.
    pub subsets: Shared<Vec<Subset>>,
    /// Families of subsets with their rules.
    pub families: Vec<Family>,
}

impl Garment {
    /// The primvar called `name` (without `primvars:`).
    pub fn primvar(&self, name: &str) -> Option<&Primvar> {
        self.primvars.iter().find(|p| p.name == name)
    }

    /// The subset called `name`.
    pub fn subset(&self, name: &str) -> Option<&Subset> {
        self.subsets.iter().find(|s| s.name == name)
    }
}
