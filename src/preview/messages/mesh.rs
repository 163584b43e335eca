//! The header of a binary frame, which brings a mesh.

use super::{Role, SetKind};
use serde::Serialize;

/// The header of a binary frame.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MeshHeader<'a> {
    /// The mesh.
    pub role: Role,
    /// The revision that it was made from.
    pub revision: u64,
    /// True if faces are new: then all blocks are there that the view needs.
    pub replaces: bool,
    /// True if the corners of faces are clockwise, seen from outside.
    pub left_handed: bool,
    /// Sets of the mesh as it is drawn; absent if they are as before. The edge set `UV seams` of the model and the render
    /// mesh is none of the garment's sets: it shows where the UV set is cut.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "typescript", ts(optional))]
    pub sets: Option<Vec<DrawnSet<'a>>>,
    /// The values of the block `values`; absent if they are as before, null if the mesh has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "typescript", ts(optional))]
    pub values: Option<Option<DrawnValues<'a>>>,
    /// Times of the server.
    pub times: Times,
    /// Places of the blocks that are there.
    pub blocks: Blocks,
}

/// A set of a mesh as it is drawn.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DrawnSet<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its elements.
    pub kind: SetKind,
    /// `familyName` of its subset.
    pub family: &'a str,
    /// Its first number in the block `elements`.
    pub offset: usize,
    /// Its numbers there; edges are pairs.
    pub length: usize,
}

/// Values of a primvar, or a quality figure, as they are drawn.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DrawnValues<'a> {
    /// The primvar or quality figure.
    pub name: &'a str,
    /// The elements that have a value each.
    pub of: ValuesOf,
    /// The smallest value.
    pub least: f32,
    /// The largest value.
    pub most: f32,
}

/// The elements that have a value each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum ValuesOf {
    /// Points.
    Point,
    /// Corners of faces.
    Corner,
    /// Faces.
    Face,
}

/// Times of the server for one frame.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Times {
    /// Time to build the mesh. \[ms\]
    pub build: f64,
    /// Time to make the frame. \[ms\]
    pub encode: f64,
    /// When it was sent. \[ms since 1970\]
    pub sent: f64,
}

/// The blocks of a frame; null if they are as in the last frame of the role.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Blocks {
    /// x, y, z of each point.
    pub points: Option<Block>,
    /// Corners of each face.
    pub face_counts: Option<Block>,
    /// The point of each corner.
    pub face_points: Option<Block>,
    /// For each corner 1 if the edge from it to the next corner is an edge of the mesh, 0 if refinement for display made
    /// it. Null if all are edges.
    pub edges: Option<Block>,
    /// The mesh's face of each drawn face. Null if they are the same.
    pub face_of: Option<Block>,
    /// For each face of a product, before refinement for display, the face of the model that it is part of. Length 0 for the
    /// model.
    pub sources: Option<Block>,
    /// Faces that are not drawn.
    pub holes: Option<Block>,
    /// u, v of each corner. Length 0 if the mesh has no UV set.
    pub uvs: Option<Block>,
    /// One value of each element.
    pub values: Option<Block>,
    /// Faces, points, or pairs of points of all sets.
    pub elements: Option<Block>,
}

/// A block of numbers behind the header.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Block {
    /// The type of its numbers, which are little-endian.
    #[serde(rename = "type")]
    pub number: NumberType,
    /// Its first byte, counted from the end of the header.
    pub offset: usize,
    /// Its numbers.
    pub length: usize,
}

/// The type of the numbers in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum NumberType {
    /// 32-bit floats.
    F32,
    /// 32-bit unsigned integers.
    U32,
    /// Bytes.
    U8,
}
