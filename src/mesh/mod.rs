//! Mesh connectivity and its handles. Nothing here knows positions.

mod faces;
mod ids;
mod topology;

pub use faces::Faces;
pub use ids::{ChainId, CornerId, EdgeId, FaceId, Id, IdVec, ValueId, VertexId};
pub use topology::{Csr, Topology};
