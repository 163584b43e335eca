//! A garment as authored, before it is checked.

use super::{
    FaceNumbers, Family, Interpolation, Meaning, Orientation, PrimvarRole, StageSpace, SubdivisionRules, Units, Values,
};
use crate::error::{Fault, Warning};
use glam::Vec3;
use std::collections::BTreeMap;

/// A mesh as authored. Index arrays keep the file's signed integers, which messages show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Garment {
    /// Path of the prim.
    pub prim: String,
    /// The size of its unit of length.
    pub units: Units,
    /// The constant primvar `<name>Scale` of each UV set: the length of one UV unit, in units of the mesh.
    pub uv_scales: BTreeMap<String, f32>,
    /// How its space lies in the stage.
    pub space: StageSpace,
    /// The name of the material of each subset that has one; that of the whole mesh under an empty name.
    pub materials: BTreeMap<String, String>,
    /// `points`
    pub points: Vec<Vec3>,
    /// `faceVertexCounts`
    pub face_vertex_counts: Vec<i32>,
    /// `faceVertexIndices`
    pub face_vertex_indices: Vec<i32>,
    /// The faces of the file behind these.
    pub face_numbers: FaceNumbers,
    /// `orientation`
    pub orientation: Orientation,
    /// `subdivisionScheme`, `interpolateBoundary`, `faceVaryingLinearInterpolation`, `triangleSubdivisionRule`
    pub rules: SubdivisionRules,
    /// `holeIndices`
    pub hole_indices: Vec<i32>,
    /// `creaseIndices`
    pub crease_indices: Vec<i32>,
    /// `creaseLengths`
    pub crease_lengths: Vec<i32>,
    /// `creaseSharpnesses`: one for each crease, or one for each edge
    pub crease_sharpnesses: Vec<f32>,
    /// `cornerIndices`
    pub corner_indices: Vec<i32>,
    /// `cornerSharpnesses`
    pub corner_sharpnesses: Vec<f32>,
    /// Primvars of the prim itself that are not constant.
    pub primvars: Vec<PrimvarInput>,
    /// Primvars with faults, which are not among `primvars`. The check adds those that it finds.
    pub left_out: Vec<LeftOut>,
    /// GeomSubsets, in namespace order.
    pub subsets: Vec<SubsetInput>,
    /// `subsetFamily:<name>:familyType`
    pub families: Vec<Family>,
}

/// A primvar that no product has, because it has faults.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// See [`Primvar::name`](super::Primvar::name).
    pub name: String,
    /// The first fault.
    pub fault: Fault,
}

impl LeftOut {
    /// The warning of the products.
    pub fn warning(&self) -> Warning {
        let mut remedy = self.fault.remedy.clone();
        if let Some(first) = remedy.get_mut(..1) {
            first.make_ascii_uppercase();
        }
        Warning::not_carried(&self.fault.place, &self.fault.text).remedy(remedy)
    }
}

/// A primvar as authored.
#[derive(Clone, Debug, PartialEq)]
pub struct PrimvarInput {
    /// See [`Primvar::name`](super::Primvar::name).
    pub name: String,
    /// The property that holds the values.
    pub role: PrimvarRole,
    /// The meaning of the values.
    pub meaning: Meaning,
    /// Whether a file stores the numbers in half precision.
    pub half: bool,
    /// `interpolation`
    pub interpolation: Interpolation,
    /// Numbers in one value of the type.
    pub components: usize,
    /// `elementSize`
    pub element_size: i32,
    /// The values, flat.
    pub values: Values,
    /// `primvars:<name>:indices`
    pub indices: Option<Vec<i32>>,
}

impl Garment {
    /// Takes out the primvars that its check left out.
    pub fn leave_out(&mut self, checked: &super::Mesh) {
        let is_kept = |p: &PrimvarInput| checked.primvars.iter().any(|kept| kept.name == p.name && kept.role == p.role);
        self.primvars.retain(is_kept);
        self.left_out.clone_from(&checked.left_out);
    }
}

impl PrimvarInput {
    /// Plain values, one for each element. Fields of the result can be replaced.
    pub fn new(name: &str, interpolation: Interpolation, values: Values) -> Self {
        Self {
            name: name.into(),
            role: PrimvarRole::Primvar,
            meaning: Meaning::Plain,
            half: false,
            interpolation,
            components: 1,
            element_size: 1,
            values,
            indices: None,
        }
    }

    /// A UV set: `indices` name the row of `uvs` at each corner of the faces.
    pub fn uvs(name: &str, uvs: &[[f32; 2]], indices: Vec<i32>) -> Self {
        let values = Values::F32(uvs.as_flattened().to_vec());
        let uvs = Self::new(name, Interpolation::FaceVarying, values);
        Self { meaning: Meaning::TextureCoordinate, components: 2, indices: Some(indices), ..uvs }
    }

    /// Painted weights, one for each point.
    pub fn weights(name: &str, weights: Vec<f32>) -> Self {
        Self::new(name, Interpolation::Vertex, Values::F32(weights))
    }
}

/// A GeomSubset as authored.
#[derive(Clone, Debug, PartialEq)]
pub struct SubsetInput {
    /// Name of the subset's prim.
    pub name: String,
    /// `elementType`: `face`, `edge` or `point`.
    pub element_type: String,
    /// `familyName`; empty for none.
    pub family: String,
    /// `indices`: of faces or points, or pairs of the points of edges.
    pub indices: Vec<i32>,
}
