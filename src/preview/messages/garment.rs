//! The message that describes the garment.

use super::SetKind;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use tailor_costume::cloth::Fabric;
use tailor_costume::recipe::GroupTable;
use tailor_mesh::error::Warning;
use tailor_mesh::garment::{Interpolation, Primvar, Subset, Values};
use tailor_usd::{self, Look, type_word};

/// The garment as it was read. First message of a connection, and again each time the stage is read anew.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct GarmentMessage<'a> {
    /// Version of this program.
    pub version: &'a str,
    /// Its folder.
    pub folder: PathBuf,
    /// File name without its folder.
    pub file: String,
    /// Path of the mesh.
    pub prim: &'a str,
    /// The axis that points up.
    #[cfg_attr(feature = "typescript", ts(type = "UpAxis"))]
    pub up_axis: &'static str,
    /// Metres in one unit of the mesh.
    pub meters_per_unit: f64,
    /// Number of points.
    pub points: usize,
    /// Number of faces.
    pub faces: usize,
    /// Mean length of the edges. \[mesh units\]
    pub mean_edge: f64,
    /// Checksum of its faces, which picked elements carry.
    pub checksum: String,
    /// Its sets.
    pub sets: Vec<SetInfo<'a>>,
    /// The plane of symmetry, if it has one.
    pub mirror: Option<Box<MirrorInfo>>,
    /// Looks of its materials: of the mesh, and of sets that have their own.
    pub looks: Vec<LookInfo<'a>>,
    /// Its primvars.
    pub primvars: Vec<PrimvarInfo<'a>>,
    /// Variant sets of the mesh and of its ancestors.
    pub variants: Vec<VariantSet<'a>>,
    /// The table of options.
    pub groups: Vec<GroupTable>,
    /// Properties of the fabrics that every recipe has.
    pub fabrics: BTreeMap<&'static str, Fabric>,
    /// File and path of the body that is shown under it, if there is one.
    pub body: Option<String>,
    /// Files to save to.
    pub suggested: SaveTargets,
    /// Warnings of the stage and of its mesh; those of the products are in their own messages.
    pub warnings: Vec<&'a Warning>,
}

/// A plane of symmetry.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct MirrorInfo {
    /// The axis that it is across: x, y or z.
    pub axis: &'static str,
    /// Share of the faces that have a twin.
    pub share: f64,
    /// The set on the other side of each set, by name; a set that lies on both sides has its own name.
    pub twins: BTreeMap<String, String>,
    /// The point on the other side of each point; itself where it has none.
    pub points: Vec<usize>,
}

/// A set of elements of the garment.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SetInfo<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its elements.
    pub kind: SetKind,
    /// `familyName` of its subset.
    pub family: &'a str,
    /// Number of elements.
    pub count: usize,
}

impl<'a> From<&'a Subset> for SetInfo<'a> {
    fn from(set: &'a Subset) -> Self {
        let Subset { name, family, elements, .. } = set;
        Self { name, kind: elements.into(), family, count: elements.len() }
    }
}

/// The preview surface of a material: constants, and the image of its colour.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct LookInfo<'a> {
    /// The face set with the material; empty for the mesh.
    pub set: &'a str,
    /// `diffuseColor`. \[linear\]
    pub colour: Option<[f32; 3]>,
    /// The address of the image that `diffuseColor` is, below that of the page.
    pub texture: Option<String>,
    /// `roughness`, from 0 to 1.
    pub roughness: Option<f32>,
}

impl<'a> LookInfo<'a> {
    /// The message of a look; `address` is that of its image.
    pub fn new(set: &'a str, look: &Look, address: Option<String>) -> Self {
        Self { set, colour: look.colour, texture: address, roughness: look.roughness }
    }
}

/// A primvar of the garment.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct PrimvarInfo<'a> {
    /// Its name, without `primvars:`.
    pub name: &'a str,
    /// USD's name of its type, such as `texCoord2f[]`.
    #[serde(rename = "type")]
    pub type_name: &'static str,
    /// The elements that carry its values.
    pub interpolation: Interpolation,
    /// Numbers in one value: 1 can be shown as heat, 2 and `faceVarying` is a UV set.
    pub width: usize,
    /// True for 32-bit floats.
    pub is_float: bool,
}

impl<'a> From<&'a Primvar> for PrimvarInfo<'a> {
    fn from(primvar: &'a Primvar) -> Self {
        let Primvar { name, interpolation, values, .. } = primvar;
        let is_float = matches!(values, Values::F32(_));
        Self { name, type_name: type_word(primvar), interpolation: *interpolation, width: primvar.width(), is_float }
    }
}

/// A variant set and its selection.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct VariantSet<'a> {
    /// Path of its prim.
    pub prim: &'a str,
    /// Its name.
    pub set: &'a str,
    /// Its variants.
    pub choices: &'a [String],
    /// The selected variant; empty for none.
    pub selected: &'a str,
}

impl<'a> From<&'a tailor_usd::VariantSet> for VariantSet<'a> {
    fn from(variants: &'a tailor_usd::VariantSet) -> Self {
        let selected = &variants.selected;
        Self { prim: &selected.prim, set: &selected.set, choices: &variants.choices, selected: &selected.choice }
    }
}

/// Files to save to: those of the input where it has one, else new ones beside the garment.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SaveTargets {
    /// A USD layer. Panels that are sewn together have none: their options are of no prim.
    pub layer: Option<String>,
    /// A `.tailor` file.
    pub recipe: String,
}
