//! Messages between the server and the page. `page/src/server/protocol.ts` is generated from these types.
//!
//! Text frames of the socket are a [`ServerMessage`] or a [`PageMessage`] as JSON; binary frames are meshes, which begin
//! with a [`MeshHeader`].

mod build;
mod garment;
mod mesh;
mod presets;
mod product;
mod selection;
mod shot;

pub use build::{BuildMessage, BuildStatus};
pub use garment::{GarmentMessage, LookInfo, MirrorInfo, PrimvarInfo, SaveTargets, SetInfo, VariantSet};
pub use mesh::{Block, Blocks, DrawnSet, DrawnValues, MeshHeader, NumberType, Times, ValuesOf};
pub use presets::{PresetSavedMessage, PresetsMessage};
pub use product::{ClothMessage, Figures, ProductMessage, lengths};
pub use selection::SelectionMessage;
pub use shot::ShotMessage;

use super::document::{Before, Options};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use tailor::sets::Change;
use tailor_costume::recipe::ListedOperator;
use tailor_mesh::connectivity::Elements;
use tailor_mesh::error::{Fault, Warning};

/// The meshes: the garment's input cage, the two products, and the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Role {
    /// The garment's input cage.
    Model,
    /// The render mesh.
    Render,
    /// The simulation mesh.
    Sim,
    /// The body under the garment.
    Body,
}

/// The elements of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum SetKind {
    /// Faces.
    Face,
    /// Edges.
    Edge,
    /// Points.
    Point,
}

impl From<&Elements> for SetKind {
    fn from(elements: &Elements) -> Self {
        match elements {
            Elements::Faces(_) => Self::Face,
            Elements::Edges(_) => Self::Edge,
            Elements::Points(_) => Self::Point,
        }
    }
}

/// The meshes and attributes that a page draws. The server sends nothing else.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
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
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum PageMessage {
    /// Replaces the edits.
    Edit {
        /// Counts the edits of this page.
        serial: u64,
        /// Edits of one gesture, such as one drag, are one step of undo.
        gesture: String,
        /// The new edits.
        #[cfg_attr(feature = "typescript", ts(type = "Options"))]
        edits: Options,
    },
    /// Answers the offer of kept edits.
    Kept {
        /// Their time.
        time: u64,
        /// True if they replace those of the document; they are forgotten otherwise.
        restore: bool,
    },
    /// Goes back a step.
    Undo,
    /// Goes forward a step.
    Redo,
    /// Shows an earlier state.
    Compare {
        /// The state that is shown in place of the edits; null ends it.
        with: Option<Before>,
    },
    /// Selects a variant of the garment.
    Variant {
        /// Path of the prim with the variant set.
        prim: String,
        /// The variant set.
        set: String,
        /// The variant.
        choice: String,
    },
    /// Asks for a selection after a change. Selections are of one page.
    Select {
        /// The selection before, as an expression; empty for none.
        selection: String,
        /// How the set changes the selection.
        change: Change,
        /// The set, as an expression.
        set: String,
    },
    /// Changes what this page draws.
    View(View),
    /// Reads the files again. They are followed, but some network file systems do not tell of changes.
    Reload,
    /// Asks what a save would write.
    Plan {
        /// The file.
        path: String,
    },
    /// Shows a level of detail.
    Level {
        /// Its number; the last one if there are fewer.
        level: u32,
    },
    /// Shows all meshes on the way of the fit.
    Fit {
        /// The share of the way, from 0 to 1.
        share: f64,
    },
    /// Looks for bodies near the garment.
    Bodies,
    /// Shows a frame of the cache.
    Pose {
        /// Its number, from 0; null for the meshes at bind.
        frame: Option<usize>,
    },
    /// Builds what is saved.
    Build {
        /// The output.
        path: String,
        /// True if an existing file may be replaced.
        overwrite: bool,
    },
    /// Saves the edits.
    Save {
        /// The file.
        path: String,
        /// True if an existing file may be replaced.
        overwrite: bool,
    },
    /// Saves a preset beside the garment, or takes it out.
    Preset {
        /// The kind of operator that it is for.
        #[cfg_attr(feature = "typescript", ts(type = "KindName"))]
        kind: String,
        /// Its name. A preset of this name is replaced.
        name: String,
        /// Its values; null takes it out.
        #[cfg_attr(feature = "typescript", ts(type = "Fields | null"))]
        values: Option<Options>,
    },
}

/// A text message to the page.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase", tag = "type")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum ServerMessage<'a> {
    /// The garment.
    Garment(Box<GarmentMessage<'a>>),
    /// The document.
    State(StateMessage),
    /// Faults of one origin.
    Faults(FaultsMessage<'a>),
    /// Figures of a product.
    Product(ProductMessage<'a>),
    /// The cloth of the simulation mesh.
    Cloth(ClothMessage<'a>),
    /// A build that a page started.
    Build(&'a BuildMessage),
    /// The cache that is played.
    Shot(&'a ShotMessage),
    /// The place on the way of the fit.
    Fit(&'a FitMessage),
    /// The bodies near the garment.
    Bodies(BodiesMessage<'a>),
    /// A step of a build.
    Progress(ProgressMessage<'a>),
    /// The answer to `select`.
    Selection(SelectionMessage),
    /// The answer to `plan` and `save`.
    Save(SaveMessage),
    /// The presets.
    Presets(PresetsMessage<'a>),
    /// The answer to `preset`.
    PresetSaved(PresetSavedMessage),
}

impl ServerMessage<'_> {
    /// The message as JSON.
    pub fn to_text(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// The shared document of all pages. Sent after each change.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct StateMessage {
    /// Counts the changes; meshes carry the revision that they were made from.
    pub revision: u64,
    /// Serial of the last edit of this page that the document includes.
    pub serial: u64,
    /// Options of the garment and of `--recipe`, below the edits.
    #[cfg_attr(feature = "typescript", ts(type = "Options"))]
    pub upstream: Options,
    /// Options that were changed here.
    #[cfg_attr(feature = "typescript", ts(type = "Options"))]
    pub edits: Options,
    /// The options that hold: the edits over those of upstream.
    #[cfg_attr(feature = "typescript", ts(type = "Options"))]
    pub merged: Options,
    /// The operators in the order in which they run.
    pub stack: Vec<ListedOperator>,
    /// True if there is a step to go back.
    pub can_undo: bool,
    /// True if there is a step to go forward.
    pub can_redo: bool,
    /// True if the edits are not in a file.
    pub unsaved: bool,
    /// The earlier state that is shown in place of the edits.
    pub comparing: Option<Before>,
    /// The level of detail that is shown.
    pub level: u32,
    /// The input of a build of what is on screen; null if it is not saved.
    pub saved_as: Option<String>,
    /// Edits of an earlier preview that were not saved, which the user may have back.
    pub kept: Option<KeptEdits>,
}

/// Edits of an earlier preview that were not saved.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct KeptEdits {
    /// The last change. \[milliseconds since 1970\]
    pub time: u64,
    /// True if the options below them are the same as then.
    pub is_current: bool,
}

/// The place that faults come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum Origin {
    /// The stage on disk.
    File,
    /// The file of presets beside the garment.
    Presets,
    /// The recipe.
    Recipe,
    /// The build of the simulation mesh.
    Sim,
    /// The build of the render mesh.
    Render,
    /// The cloth of the simulation mesh.
    Cloth,
}

/// Faults of the current document or of the file on disk. The last good meshes stay.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FaultsMessage<'a> {
    /// `file`: the stage on disk cannot be read; `presets`: nor can the presets beside it; `recipe`: an option is wrong; others: the build of that part.
    pub origin: Origin,
    /// The faults; none if all is well.
    pub faults: &'a [Fault],
}

/// The place of the garment and the body on the way of the fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FitMessage {
    /// The share of the way, from 0 to 1.
    pub share: f64,
    /// The warning of the faces of the garment that cross the body there.
    pub warning: Option<Warning>,
    /// How many of them do not at the start.
    pub new: usize,
}

/// The answer to `bodies`: files with one mesh near the garment. Sent for each that is found.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct BodiesMessage<'a> {
    /// The files.
    pub files: &'a [PathBuf],
    /// False while it is looked for more.
    pub is_complete: bool,
}

/// Work that has begun or ended.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ProgressMessage<'a> {
    /// The product.
    pub role: Role,
    /// The step that has begun; null at the end.
    pub step: Option<&'a str>,
}

/// The outcome of `plan` or `save`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub enum SaveStatus {
    /// Nothing was asked to be written.
    Planned,
    /// The file is written.
    Saved,
    /// Nothing was or would be written.
    Refused,
}

/// The answer to `plan` and `save`.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SaveMessage {
    /// The file.
    pub path: String,
    /// `planned`: the text would be written. `saved`: it is written.
    pub status: SaveStatus,
    /// True if the file exists, so that saving needs `overwrite`.
    pub exists: bool,
    /// The opinions, as USD text or JSON.
    pub text: String,
    /// Words on what happens to the rest of an existing file; empty for a new one.
    pub note: String,
    /// The reason of a refusal.
    pub fault: Option<Fault>,
}
