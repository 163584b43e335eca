//! The codes of warnings, and how bad each is. `docs/diagnostics.md` has a section for each.

use serde::Serialize;
use std::fmt;

/// How bad a warning is, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "camelCase")]
#[cfg_attr(test, derive(ts_rs::TS))]
#[non_exhaustive]
pub enum Severity {
    /// The garment or its recipe has a fault, or a product lacks what it should have.
    Fault,
    /// A product is less good at some places than was asked.
    Quality,
    /// The products are as they should be; it is good to know how.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// The kind of a warning, for programs that read reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(test, derive(ts_rs::TS, serde::Deserialize), ts(rename = "WarningCode"))]
#[non_exhaustive]
pub enum Code {
    /// Edges have more than two faces.
    NonManifoldEdges,
    /// Several fans of faces meet at one vertex.
    BowTieVertices,
    /// Neighbouring faces disagree in winding.
    WindingDisagreements,
    /// No face uses a point.
    UnusedPoints,
    /// Faces have no area.
    DegenerateFaces,
    /// Faces name a point more than once.
    RepeatedPoints,
    /// Faces have the points of an earlier face.
    DuplicateFaces,
    /// A product lacks an attribute of the model.
    NotCarried,
    /// The garment is so far from the origin that points of the products are rounded.
    FarFromOrigin,
    /// The mesh has no subdivision surface.
    PolygonalCage,
    /// The simulation mesh has reached the limit of its size.
    FaceLimit,
    /// UVs are flipped or degenerate, and the simulation mesh ignores them there.
    FlippedUvs,
    /// Edges of the simulation mesh leave a border, seam or constraint.
    CurvesCut,
    /// A face subset has another area on the simulation mesh.
    AreaChanged,
    /// Face subsets are too small for the triangles of the simulation mesh.
    SetsBlurred,
    /// Products keep what the selected variant has.
    FrozenVariant,
    /// A trim lies away from the cloth that it rides on.
    TrimOffCloth,
    /// A seam is narrower than its width, or lacks a row.
    NarrowSeam,
    /// A seam is pushed less than its offset.
    ShallowSeam,
    /// The heights of an operator are less than it asks.
    ReducedHeight,
    /// Two seams have the same edges.
    SharedSeamEdges,
    /// A second layer is nearer than its thickness.
    ThinLayer,
    /// Faces have no second layer.
    BareFaces,
    /// A face set of an operator has another name than asked.
    SetRenamed,
    /// Subsets break the rule of their family, and products have a weaker one.
    FamilyRule,
    /// Faces intersect others or are flipped.
    Intersections,
    /// Repair has ended before all faces were tested.
    RepairCutShort,
    /// `render.operators` leaves operators out.
    OperatorsLeftOut,
    /// A reference to the asset cannot reach the products.
    RootMesh,
    /// An expression of a recipe gives a set without elements.
    EmptySet,
    /// No vertex of the simulation mesh is in a set that is held.
    NothingPinned,
    /// The mesh has no UV set with seams, or several without a known name.
    NoUvSet,
    /// UV shells are too small for the triangles of the simulation mesh.
    SmallShells,
    /// Nearly every edge is a UV seam.
    UvConfetti,
    /// Triangles of the simulation mesh are flipped in the UVs.
    UvFlips,
    /// UV shells are not patterns of the mesh.
    NoPattern,
    /// There are no panels to write.
    NoPanels,
    /// A dialect of physics takes one value where the cloth has several.
    MeanFabric,
    /// The stage does not compose fully.
    Composition,
    /// An option of a payload cannot be one, and is left out.
    IgnoredOption,
    /// An option is where nothing reads it.
    MisplacedOption,
    /// A schema is applied, and the sets that it needs are not named.
    SchemaWithoutSets,
    /// A mesh lies on another and is not attached to it.
    Unattached,
    /// Borders of two meshes lie along each other and are not sewn.
    UnsewnBorders,
    /// A garment is not on the body that it was made for.
    OffBody,
    /// A fitted garment did not follow its body.
    FitLeftBehind,
    /// Faces of a fitted garment cross the body or each other, and did not before.
    FitCrosses,
    /// Fewer threads are started than asked for.
    ThreadsCapped,
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Code {
    /// How bad warnings of this code are.
    pub fn severity(self) -> Severity {
        match self {
            Self::WindingDisagreements
            | Self::DegenerateFaces
            | Self::DuplicateFaces
            | Self::NotCarried
            | Self::FlippedUvs
            | Self::Intersections
            | Self::FitCrosses
            | Self::FitLeftBehind
            | Self::OffBody
            | Self::RootMesh
            | Self::EmptySet
            | Self::NothingPinned
            | Self::NoPanels
            | Self::Composition
            | Self::IgnoredOption
            | Self::MisplacedOption
            | Self::SchemaWithoutSets => Severity::Fault,
            Self::FarFromOrigin
            | Self::UnsewnBorders
            | Self::MeanFabric
            | Self::FaceLimit
            | Self::CurvesCut
            | Self::AreaChanged
            | Self::SetsBlurred
            | Self::NarrowSeam
            | Self::ShallowSeam
            | Self::ReducedHeight
            | Self::SharedSeamEdges
            | Self::ThinLayer
            | Self::BareFaces
            | Self::RepairCutShort
            | Self::NoUvSet
            | Self::SmallShells
            | Self::UvConfetti
            | Self::UvFlips
            | Self::TrimOffCloth => Severity::Quality,
            Self::NonManifoldEdges
            | Self::BowTieVertices
            | Self::UnusedPoints
            | Self::RepeatedPoints
            | Self::FamilyRule
            | Self::PolygonalCage
            | Self::SetRenamed
            | Self::OperatorsLeftOut
            | Self::ThreadsCapped
            | Self::NoPattern
            | Self::Unattached
            | Self::FrozenVariant => Severity::Note,
        }
    }
}
