//! Sets of elements while an expression is evaluated.

use super::SetFault;
use super::expression::Operation;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::{EdgeId, Elements, FaceId, Topology, VertexId};

/// A set of elements of one kind.
#[derive(Clone, Debug, PartialEq)]
pub enum ElementSet {
    /// Faces.
    Faces(BTreeSet<FaceId>),
    /// Edges, each in the direction that gives a seam its left.
    Edges(BTreeMap<EdgeId, [VertexId; 2]>),
    /// Points.
    Points(BTreeSet<VertexId>),
}

impl ElementSet {
    /// The elements of a set of the garment.
    pub fn of(t: &Topology, elements: &Elements) -> Self {
        match elements {
            Elements::Faces(faces) => Self::Faces(faces.iter().copied().collect()),
            Elements::Points(points) => Self::Points(points.iter().copied().collect()),
            Elements::Edges(edges) => {
                Self::Edges(edges.iter().filter_map(|&[a, b]| Some((t.find_edge(a, b)?, [a, b]))).collect())
            }
        }
    }

    /// The elements in the order of the mesh.
    pub fn into_elements(self) -> Elements {
        match self {
            Self::Faces(faces) => Elements::Faces(faces.into_iter().collect()),
            Self::Edges(edges) => Elements::Edges(edges.into_values().collect()),
            Self::Points(points) => Elements::Points(points.into_iter().collect()),
        }
    }

    /// The plural of their kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Faces(_) => "faces",
            Self::Edges(_) => "edges",
            Self::Points(_) => "points",
        }
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Self::Faces(faces) => faces.len(),
            Self::Edges(edges) => edges.len(),
            Self::Points(points) => points.len(),
        }
    }

    /// True if there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True if all elements of another set are in this one, whatever the directions of edges.
    pub fn contains(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Faces(a), Self::Faces(b)) => b.is_subset(a),
            (Self::Edges(a), Self::Edges(b)) => b.keys().all(|edge| a.contains_key(edge)),
            (Self::Points(a), Self::Points(b)) => b.is_subset(a),
            _ => false,
        }
    }

    /// True for an edge of the set.
    pub fn contains_edge(&self, edge: EdgeId) -> bool {
        matches!(self, Self::Edges(edges) if edges.contains_key(&edge))
    }

    /// The points of its elements.
    pub fn points(&self, t: &Topology) -> BTreeSet<VertexId> {
        match self {
            Self::Faces(faces) => faces.iter().flat_map(|&face| t.faces.vertices_of(face)).copied().collect(),
            Self::Edges(edges) => edges.values().flatten().copied().collect(),
            Self::Points(points) => points.clone(),
        }
    }

    /// Combines two sets of one kind. Edges keep the direction that they have first.
    pub fn combine(self, operation: Operation, other: Self) -> Result<Self, SetFault> {
        Ok(match (self, other) {
            (Self::Faces(a), Self::Faces(b)) => Self::Faces(combine(a, operation, &b)),
            (Self::Points(a), Self::Points(b)) => Self::Points(combine(a, operation, &b)),
            (Self::Edges(mut a), Self::Edges(b)) => {
                match operation {
                    Operation::Union => {
                        for (edge, ends) in b {
                            a.entry(edge).or_insert(ends);
                        }
                    }
                    Operation::Difference => a.retain(|edge, _| !b.contains_key(edge)),
                    Operation::Intersection => a.retain(|edge, _| b.contains_key(edge)),
                }
                Self::Edges(a)
            }
            (a, b) => {
                let text = format!("{} and {} cannot be combined", a.kind(), b.kind());
                return Err(SetFault::new(text, "convert one of them by faces(...), edges(...) or points(...)"));
            }
        })
    }
}

fn combine<T: Copy + Ord>(mut a: BTreeSet<T>, operation: Operation, b: &BTreeSet<T>) -> BTreeSet<T> {
    match operation {
        Operation::Union => a.extend(b),
        Operation::Difference => a.retain(|element| !b.contains(element)),
        Operation::Intersection => a.retain(|element| b.contains(element)),
    }
    a
}
