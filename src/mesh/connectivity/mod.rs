//! Mesh connectivity and its handles. Nothing here knows positions.

mod check;
mod compact;
pub mod edit;
mod elements;
mod faces;
mod groups;
mod ids;

mod submesh;
mod topology;

pub use compact::Compact;
pub use elements::Elements;
pub use faces::Faces;
pub use groups::Groups;
pub use ids::{ChainId, CornerId, EdgeId, FaceId, Id, IdVec, SpanId, ValueId, VertexId, WedgeId};
pub use submesh::{JoinedMesh, Submesh, join_meshes};
pub use topology::{Csr, Topology};
