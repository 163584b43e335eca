//! Mesh connectivity and its handles. Nothing here knows positions.

pub mod edit;
mod faces;
mod ids;
mod topology;

pub use faces::Faces;
pub use ids::{ChainId, CornerId, EdgeId, FaceId, Id, IdVec, SiteId, SpanId, ValueId, VertexId};
pub use topology::{Csr, Topology};
