//! Messages between the server and the page, as `page/src/server/protocol.ts` declares them.

use super::document::Before;
use crate::error::{Fault, Warning};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The three meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Role {
    /// The garment's input cage.
    Model,
    /// The render mesh.
    Render,
    /// The simulation mesh.
    Sim,
}

/// The meshes and attributes that a page draws.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct View {
    /// The meshes.
    pub roles: Vec<Role>,
    /// Refinements for display. \[levels\]
    pub smooth: u32,
    /// True if UVs are drawn.
    pub uv: bool,
    /// The primvar or quality figure that is drawn.
    pub values: Option<String>,
}

/// A message of the page.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase", tag = "type")]
pub enum Request {
    Edit { serial: u64, gesture: String, edits: Map<String, Value> },
    Undo,
    Redo,
    Compare { with: Option<Before> },
    Variant { prim: String, set: String, choice: String },
    View(View),
    Reload,
    Plan { path: String },
    Save { path: String, overwrite: bool },
}

/// Where faults come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Origin {
    /// The stage on disk.
    File,
    /// The recipe.
    Recipe,
    /// The build of the simulation mesh.
    Sim,
    /// The build of the render mesh.
    Render,
}

/// The answer to `plan` and `save`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SaveAnswer {
    pub path: String,
    /// `planned`, `saved` or `refused`.
    pub status: &'static str,
    pub exists: bool,
    pub text: String,
    pub note: String,
    pub fault: Option<Fault>,
}

/// A text message to the page.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase", tag = "type")]
pub enum Message<'a> {
    #[serde(rename_all = "camelCase")]
    State {
        revision: u64,
        serial: u64,
        upstream: &'a Map<String, Value>,
        edits: &'a Map<String, Value>,
        can_undo: bool,
        can_redo: bool,
        unsaved: bool,
        comparing: Option<Before>,
    },
    Faults {
        origin: Origin,
        faults: &'a [Fault],
    },
    Product {
        role: Role,
        revision: u64,
        figures: Value,
        warnings: &'a [Warning],
        operators: &'a [String],
        lengths: Map<String, Value>,
    },
    Progress {
        role: Role,
        step: Option<&'a str>,
    },
    Save(SaveAnswer),
}

impl Message<'_> {
    /// The message as JSON.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}
