//! A mesh of a garment with its attributes.
//!
//! | module | has |
//! |---|---|
//! | [`connectivity`] | faces, edges and vertices by number, without positions |
//! | [`garment`] | the mesh as it was authored ([`Garment`]), its checks, and the mesh that geometry code trusts ([`Mesh`]) |
//! | [`subdivide`] | Catmull-Clark, Loop and bilinear refinement: stencils, limit points, attributes of every kind |
//! | [`options`] | the declaration of options, their checks, and their table |
//! | [`error`], [`codes`] | faults and warnings: problem, place, remedy |
//! | [`files`], [`meter`] | reading and writing files; memory that is counted |
//! | [`step`] | results that are kept beside their inputs |

pub mod codes;
pub mod connectivity;
pub mod error;
pub mod files;
pub mod garment;
pub mod meter;
pub mod options;
pub mod step;
pub mod subdivide;

pub use connectivity::{CornerId, Csr, EdgeId, Elements, FaceId, Faces, IdVec, Topology, VertexId};
pub use error::{Error, ErrorKind, Warning};
pub use garment::units;
pub use garment::{
    BoundaryInterpolation, Corner, Crease, FaceNumbers, FaceVaryingInterpolation, Family, FamilyType, Garment,
    Interpolation, LeftOut, Meaning, Mesh, Mixing, Orientation, Primvar, PrimvarInput, PrimvarRole, Scheme, StageSpace,
    SubdivisionRules, Subset, SubsetInput, TriangleRule, Units, Values,
};
pub use glam;
