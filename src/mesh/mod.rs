//! Mesh connectivity and its handles. Nothing here knows positions.

mod check;
mod compact;
pub mod edit;
mod faces;
mod groups;
mod ids;
mod parts;
mod ring;
mod topology;

pub use compact::Compact;
pub use faces::Faces;
pub use groups::Groups;
pub use ids::{ChainId, CornerId, EdgeId, FaceId, Id, IdVec, SpanId, ValueId, VertexId, WedgeId};
pub use parts::{Joined, Part, join};
pub use topology::{Csr, Topology};
