//! The message that describes a product.

use super::Role;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use tailor::report::{RenderFigures, SimFigures};
use tailor_costume::cloth::ClothFigures;
use tailor_costume::recipe::Recipe;
use tailor_mesh::error::Warning;

/// Figures and warnings of a product; follows its mesh.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ProductMessage<'a> {
    /// The product.
    pub role: Role,
    /// The revision that it was made from.
    pub revision: u64,
    /// Its figures.
    pub figures: Figures,
    /// Refinements that are written; null for the simulation mesh. \[levels\]
    pub level: Option<u32>,
    /// Its warnings.
    pub warnings: Vec<&'a Warning>,
    /// Operators in the order in which they ran, as `seam.placket`. Of the render mesh only.
    pub operators: &'a [String],
    /// Lengths and levels that replace 0, by key: of the simulation mesh, or of the render mesh.
    pub lengths: BTreeMap<String, f64>,
}

/// The cloth of the simulation mesh; follows its mesh.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ClothMessage<'a> {
    /// Its figures, as in the JSON report of `build`; null without physics.
    pub figures: Option<&'a ClothFigures>,
    /// Its warnings.
    pub warnings: Vec<&'a Warning>,
}

/// Figures of a product that the page shows, as in the JSON report of `build`.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Figures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Smallest angle of any triangle; null for the render mesh. \[degrees\]
    pub min_angle: Option<f32>,
    /// Share of triangles with an angle below 30 degrees; null for the render mesh.
    pub share_under30: Option<f32>,
    /// Root mean square of length / target - 1 over the edges; null for the render mesh.
    pub length_error_rms: Option<f32>,
    /// Share of faces with four corners; null for the simulation mesh.
    pub quads: Option<f32>,
}

impl From<&SimFigures> for Figures {
    fn from(figures: &SimFigures) -> Self {
        Self {
            vertices: figures.vertices,
            faces: figures.faces,
            min_angle: Some(figures.min_angle),
            share_under30: Some(figures.share_under30),
            length_error_rms: Some(figures.length_error_rms),
            ..Self::default()
        }
    }
}

impl From<&RenderFigures> for Figures {
    fn from(figures: &RenderFigures) -> Self {
        Self { vertices: figures.vertices, faces: figures.faces, quads: Some(figures.quads), ..Self::default() }
    }
}

/// The lengths and levels that replace 0, by key.
pub fn lengths(asked: &Recipe, used: &Recipe) -> BTreeMap<String, f64> {
    let [asked, used] = [asked, used].map(|recipe| flat("", &serde_json::to_value(recipe).unwrap_or_default()));
    let replaced = used.into_iter().filter(|(key, value)| asked.get(key) != Some(value));
    replaced.filter_map(|(key, value)| Some((key, value.as_f64()?))).collect()
}

fn flat(prefix: &str, value: &Value) -> Map<String, Value> {
    let Value::Object(fields) = value else { return Map::new() };
    let mut out = Map::new();
    for (key, value) in fields {
        let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Object(_) => out.extend(flat(&key, value)),
            value => drop(out.insert(key, value.clone())),
        }
    }
    out
}
