//! The codes of errors. `docs/diagnostics.md` has a section for each.

use super::ErrorKind;
use serde::Serialize;
use std::fmt;

/// The kind of a fault, which stays when its words change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(test, derive(ts_rs::TS))]
#[non_exhaustive]
pub enum ErrorCode {
    /// An argument of the command is wrong.
    CommandLine,
    /// No garment is named.
    NoInput,
    /// The page of the preview cannot be served.
    PreviewServer,
    /// A file cannot be opened.
    UnreadableFile,
    /// The content of a file cannot be read.
    DamagedFile,
    /// The content of a file is valid USD that this version cannot read.
    NotSupported,
    /// The layers of a stage do not compose.
    CompositionFailed,
    /// The output exists already.
    OutputExists,
    /// The output is a file that the input uses.
    OutputIsInput,
    /// The output cannot be a file of this name.
    OutputPath,
    /// A file cannot be written.
    WriteFailed,
    /// A layer cannot be written back unchanged.
    NotWrittenBack,
    /// The output is not what a build would make of the files as they are now.
    StaleOutput,
    /// A warning, where none is wanted.
    StrictWarning,
    /// The name of a product is taken, or is not valid.
    NameTaken,
    /// The stage holds no mesh to build from.
    NoMesh,
    /// The stage holds several meshes.
    SeveralMeshes,
    /// The prim that is named is not a mesh to build from.
    WrongPrim,
    /// Panels that are sewn together contradict each other.
    PanelsDiffer,
    /// The mesh is inside an instance.
    InsideInstance,
    /// An attribute has values at times only.
    NoDefaultValue,
    /// An attribute is missing or of another type.
    AttributeType,
    /// A token has a value that USD does not know.
    UnknownToken,
    /// The mesh has nothing to build from.
    EmptyMesh,
    /// The mesh is too small or too large for single precision.
    MeshSize,
    /// Counts and corners of faces disagree.
    FaceCorners,
    /// A Loop mesh has faces that are not triangles.
    LoopFaces,
    /// An index names an element that is not there.
    IndexOutOfRange,
    /// A value is not a finite number.
    NotFinite,
    /// A primvar has too many or too few values.
    ValueCount,
    /// Two primvars have one name.
    DuplicatePrimvar,
    /// Creases or corners disagree with the mesh.
    CreaseData,
    /// A list of elements names one twice, or edges that the mesh lacks.
    ElementList,
    /// Subsets of one family have elements of several types.
    SubsetFamily,
    /// A recipe cannot be read.
    RecipeFile,
    /// An attribute of the recipe cannot be an option.
    RecipeAttribute,
    /// There is no such option.
    UnknownOption,
    /// An option has a value that it cannot have.
    OptionValue,
    /// An option names a subset that the mesh lacks.
    UnknownSubset,
    /// An expression does not describe a set.
    SetExpression,
    /// An option names a primvar that the mesh lacks.
    UnknownPrimvar,
    /// `render.operators` names no operator, or one twice.
    UnknownOperator,
    /// Operators need a mesh that is not of Loop's scheme.
    LoopOperators,
    /// A fold is not at a border.
    NoBorder,
    /// The products would be too large.
    TooLarge,
    /// UV shells are not patterns, and the cloth is to rest on them.
    UnusablePanels,
    /// Two bodies of a fit do not correspond.
    BodiesDiffer,
    /// The target of the pins cannot hold them.
    PinTarget,
    /// No mesh is bound to a simulation mesh.
    NotBound,
    /// A product of an earlier build is incomplete or was edited.
    StaleBinding,
    /// A cache cannot be read.
    CacheFile,
    /// A cache is of another mesh.
    CacheMismatch,
    /// A cache lacks frames.
    CacheFrames,
    /// The system starts no more threads.
    NoThread,
    /// The build was cancelled.
    Cancelled,
    /// This program is at fault.
    Internal,
}

impl ErrorCode {
    /// The code of faults that have none of their own.
    pub(super) fn of_kind(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::Usd => Self::DamagedFile,
            ErrorKind::Mesh => Self::EmptyMesh,
            ErrorKind::Recipe => Self::OptionValue,
            ErrorKind::Usage => Self::CommandLine,
            ErrorKind::Cancelled => Self::Cancelled,
            ErrorKind::Internal => Self::Internal,
        }
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}
