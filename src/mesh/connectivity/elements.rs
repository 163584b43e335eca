//! A set of faces, edges or points.

use super::{FaceId, Id, VertexId};
use serde::{Serialize, Serializer};

/// A set of mesh elements of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Elements {
    /// Faces.
    #[serde(serialize_with = "indices")]
    Faces(#[cfg_attr(feature = "typescript", ts(as = "Vec<u32>"))] Vec<FaceId>),
    /// Edges as vertex pairs, in authored order and direction.
    #[serde(serialize_with = "pairs")]
    Edges(#[cfg_attr(feature = "typescript", ts(as = "Vec<[u32; 2]>"))] Vec<[VertexId; 2]>),
    /// Vertices.
    #[serde(serialize_with = "indices")]
    Points(#[cfg_attr(feature = "typescript", ts(as = "Vec<u32>"))] Vec<VertexId>),
}

impl Elements {
    /// The `elementType` of a `GeomSubset`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Faces(_) => "face",
            Self::Edges(_) => "edge",
            Self::Points(_) => "point",
        }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Self::Faces(f) => f.len(),
            Self::Edges(e) => e.len(),
            Self::Points(p) => p.len(),
        }
    }

    /// The `indices` of a `GeomSubset`: edges are pairs, one after the other.
    pub fn indices(&self) -> Vec<i32> {
        match self {
            Self::Faces(faces) => faces.iter().map(|face| face.index() as i32).collect(),
            Self::Edges(edges) => edges.iter().flatten().map(|end| end.index() as i32).collect(),
            Self::Points(points) => points.iter().map(|point| point.index() as i32).collect(),
        }
    }

    /// `true` if there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds the elements of another set of the same kind that are not there yet, and sorts all.
    pub fn merge(&mut self, other: &Self) {
        match (self, other) {
            (Self::Faces(own), Self::Faces(other)) => merge(own, other),
            (Self::Edges(own), Self::Edges(other)) => merge(own, other),
            (Self::Points(own), Self::Points(other)) => merge(own, other),
            _ => {}
        }
    }

    /// The first `most` elements as text, such as `edges 3-7, 7-9, …`.
    pub fn in_words(&self, most: usize) -> String {
        let mut words: Vec<String> = match self {
            Self::Faces(faces) => faces.iter().take(most).map(|f| f.index().to_string()).collect(),
            Self::Points(points) => points.iter().take(most).map(|p| p.index().to_string()).collect(),
            Self::Edges(edges) => {
                edges.iter().take(most).map(|[a, b]| format!("{}-{}", a.index(), b.index())).collect()
            }
        };
        if self.len() > most {
            words.push("…".to_owned());
        }
        let plural = if self.len() == 1 { "" } else { "s" };
        format!("{}{plural} {}", self.kind(), words.join(", "))
    }
}

fn merge<T: Copy + Ord>(own: &mut Vec<T>, other: &[T]) {
    own.extend(other);
    own.sort_unstable();
    own.dedup();
}

fn indices<I: Id, S: Serializer>(ids: &[I], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(ids.iter().map(|id| id.index()))
}

fn pairs<S: Serializer>(edges: &[[VertexId; 2]], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(edges.iter().map(|edge| edge.map(VertexId::index)))
}
