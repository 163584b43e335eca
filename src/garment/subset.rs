//! Named sets of elements (`UsdGeomSubset`) and their families.

use crate::mesh::{FaceId, VertexId};

/// The elements of a subset.
#[derive(Clone, Debug, PartialEq)]
pub enum Elements {
    /// Faces.
    Faces(Vec<FaceId>),
    /// Edges, each by its two vertices, in the order in which they were authored.
    Edges(Vec<[VertexId; 2]>),
    /// Vertices.
    Points(Vec<VertexId>),
}

impl Elements {
    /// The value of `elementType`.
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

    /// Whether the set has no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A named set of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// Name of the subset's prim.
    pub name: String,
    /// Its family; empty for none.
    pub family: String,
    /// Its elements.
    pub elements: Elements,
    /// The sharpness of its edges or points as creases or corners, if the set was built from those.
    pub sharpness: Option<f32>,
}

/// The rule by which the subsets of a family share elements, as `subsetFamily:<name>:familyType`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FamilyType {
    /// Every element is in exactly one subset.
    Partition,
    /// No element is in two subsets.
    NonOverlapping,
    /// No rule.
    #[default]
    Unrestricted,
}

/// A family of subsets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    /// Its name.
    pub name: String,
    /// Its rule.
    pub kind: FamilyType,
}
