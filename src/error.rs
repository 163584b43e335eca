//! The root error, its exit class, and the warnings that are collected on the way.

use crate::garment::GarmentError;
use crate::usd::UsdError;
use serde::Serialize;
use std::fmt;
use std::io;

/// Elements that a warning names: enough to find the place, few enough to read.
pub const EXAMPLES: usize = 5;

/// What went wrong, for the person at the terminal.
#[derive(Debug)]
pub enum Error {
    /// A USD file could not be opened, understood or written.
    Usd(UsdError),
    /// The mesh is not a garment that can be worked on.
    Garment(GarmentError),
    /// The recipe (file, flag or attribute) is wrong.
    Recipe(String),
    /// The command line is wrong.
    Usage(String),
    /// A fault of this program.
    Internal(String),
}

impl Error {
    /// Exit code of the command: 1 for the user's input, 2 for our own faults.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Internal(_) => 2,
            _ => 1,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usd(e) => e.fmt(f),
            Self::Garment(e) => e.fmt(f),
            Self::Recipe(e) | Self::Usage(e) => e.fmt(f),
            Self::Internal(e) => write!(f, "internal error: {e}; please report it"),
        }
    }
}

impl std::error::Error for Error {}

impl From<UsdError> for Error {
    fn from(e: UsdError) -> Self {
        Self::Usd(e)
    }
}

impl From<GarmentError> for Error {
    fn from(e: GarmentError) -> Self {
        Self::Garment(e)
    }
}

/// The system's words for a failure, without its number.
pub fn plain(e: &io::Error) -> String {
    match e.kind() {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::FileTooLarge => "the file is larger than is allowed here".into(),
        io::ErrorKind::IsADirectory => "it is a folder".into(),
        _ => e.to_string(),
    }
}

/// Why faces have no second layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bare {
    /// Their neighbours look the other way.
    Turned,
    /// Another part of the garment lies on them.
    NoRoom,
    /// Others without a second layer are between them and the border.
    CutOff,
}

/// Something the user should know that does not stop the work.
///
/// `examples` name the first few elements in the user's own numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "code", rename_all = "kebab-case", rename_all_fields = "camelCase")]
pub enum Warning {
    /// Edges with more than two faces; cut apart on the simulation mesh, kept on the render mesh.
    NonManifoldEdges {
        /// How many.
        count: usize,
        /// Point indices.
        examples: Vec<[usize; 2]>,
    },
    /// Vertices where several fans of faces touch, a fan being faces connected through edges of two faces; cut apart
    /// on the simulation mesh, kept on the render mesh. The ends of a non-manifold edge are among them.
    BowTieVertices {
        /// How many.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
    },
    /// Neighbouring faces that disagree in winding; oriented on the simulation mesh, kept on the render mesh.
    WindingDisagreements {
        /// How many edges.
        count: usize,
        /// Point indices.
        examples: Vec<[usize; 2]>,
    },
    /// Points that no face uses; dropped on the simulation mesh, kept on the render mesh.
    UnusedPoints {
        /// How many.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
    },
    /// Faces without area; both meshes keep them, and the simulation mesh may have such triangles there.
    DegenerateFaces {
        /// How many.
        count: usize,
        /// Face indices.
        examples: Vec<usize>,
    },
    /// Faces on the same points as an earlier face; both are kept.
    DuplicateFaces {
        /// How many, the earlier ones not counted.
        count: usize,
        /// Face indices: the earlier face and its duplicate.
        examples: Vec<[usize; 2]>,
    },
    /// An attribute of the model that a product does not carry.
    NotCarried {
        /// What: a property or a subset by name.
        what: String,
        /// Why, and where it still can be found.
        why: String,
    },
    /// The cage has no subdivision surface.
    PolygonalCage,
    /// The simulation mesh was stopped before its edges were as short as asked.
    FaceLimit {
        /// Triangles that it has.
        faces: usize,
    },
    /// Borders, seams and edge subsets that bend too much for the edges of the simulation mesh to follow.
    CurvesCut {
        /// How many chains.
        count: usize,
        /// The largest distance of a curve from its edges, in target lengths.
        farthest: f32,
        /// The points of the garment nearest to the farthest places, the farthest first.
        examples: Vec<usize>,
    },
    /// Face subsets whose area on the simulation mesh is not that on the garment's surface: folds finer than the target
    /// length are cut short.
    AreaChanged {
        /// Names of the subsets.
        sets: Vec<String>,
        /// The largest change, as a share of the subset's area.
        largest: f32,
    },
    /// Seams that are narrower in places than asked, for want of room, and as much lower.
    NarrowSeam {
        /// Name of the seam.
        seam: String,
        /// At how many points.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
        /// What is left of the width at the narrowest place, as a share.
        least: f32,
    },
    /// Seams that are pushed less than asked, as they would cross the other layer of a fold or another part.
    ShallowSeam {
        /// Name of the seam.
        seam: String,
        /// At how many points.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
        /// What is left of the offset at the shallowest place, as a share.
        least: f32,
    },
    /// Edges of a seam that an earlier seam has already.
    SharedSeamEdges {
        /// Name of the later seam.
        seam: String,
        /// How many.
        count: usize,
        /// Point indices.
        examples: Vec<[usize; 2]>,
    },
    /// Single edges of a seam with both ends inside the surface, where it cannot narrow to nothing on both sides.
    NoRoomToTaper {
        /// Name of the seam.
        seam: String,
        /// How many.
        count: usize,
        /// Point indices.
        examples: Vec<[usize; 2]>,
    },
    /// A second layer that is nearer in places than asked, where it would cross itself or another part.
    ThinLayer {
        /// Name of the thickness.
        thickness: String,
        /// At how many points.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
        /// What is left of the distance at the thinnest place, as a share.
        least: f32,
    },
    /// A face set of an operator whose name another subset has.
    SetRenamed {
        /// The name that it would have.
        wanted: String,
        /// The name that it has.
        name: String,
    },
    /// Faces that cross others or are turned over, whatever their heights.
    Unsound {
        /// The operators, by kind and name.
        operator: String,
        /// How many faces of the cage.
        count: usize,
        /// Points of the input beside them.
        examples: Vec<usize>,
    },
    /// Faces that have no second layer.
    BareFaces {
        /// Name of the thickness.
        thickness: String,
        /// How many faces.
        count: usize,
        /// Point indices.
        examples: Vec<usize>,
        /// Why.
        why: Bare,
    },
    /// Operators that `render.operators` does not name.
    OperatorsLeftOut {
        /// Their names.
        names: Vec<String>,
    },
    /// Face subsets that are too small for the triangles of the simulation mesh to follow their borders.
    SetsBlurred {
        /// Names of the subsets.
        sets: Vec<String>,
        /// The least agreement with the source: what both have in common, as a share of their mean area.
        least: f32,
    },
    /// The products have no ancestor that a reference to the asset could name.
    RootMesh {
        /// Path of the model.
        prim: String,
    },
    /// A reference, payload or other arc that could not be followed; the rest of the stage is as it should be.
    Composition {
        /// What failed, in the words of composition.
        fault: String,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonManifoldEdges { count, examples } => {
                let some = some(*count, "points", examples, |[a, b]| format!("{a}-{b}"));
                write!(f, "edges with more than two faces: {count} ({some}); the simulation mesh is cut apart there")
            }
            Self::BowTieVertices { count, examples } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "points where fans of faces touch: {count} ({some}); the simulation mesh is cut apart there")
            }
            Self::WindingDisagreements { count, examples } => {
                let some = some(*count, "points", examples, |[a, b]| format!("{a}-{b}"));
                write!(f, "edges between faces of opposite winding: {count} ({some}); ")?;
                write!(f, "the simulation mesh is oriented alike, the render mesh keeps them")
            }
            Self::UnusedPoints { count, examples } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "points without a face: {count} ({some}); ")?;
                write!(f, "the simulation mesh drops them, the render mesh keeps them")
            }
            Self::DegenerateFaces { count, examples } => {
                let some = some(*count, "faces", examples, usize::to_string);
                write!(f, "faces without area: {count} ({some}); ")?;
                write!(f, "both meshes keep them; delete them, or give them an area")
            }
            Self::DuplicateFaces { count, examples } => {
                let some = some(*count, "faces", examples, |[first, face]| format!("{face} on {first}"));
                write!(f, "faces on the same points as another: {count} ({some}); ")?;
                write!(f, "delete one of each two unless two layers are meant")
            }
            Self::PolygonalCage => {
                write!(f, "subdivisionScheme is none: the faces are taken as they are, flat, and split in quads")
            }
            Self::FaceLimit { faces } => {
                write!(f, "the simulation mesh was stopped at {faces} triangles, before its edges were short enough")
            }
            Self::CurvesCut { count, farthest, examples } => {
                let some = some(*count, "at points", examples, usize::to_string);
                write!(f, "borders, seams or constraints up to {farthest:.2} edge lengths from their edges: {count} ")?;
                write!(f, "({some}); they bend within an edge: lower sim.maxEdgeLength, or sim.cornerAngle")
            }
            Self::AreaChanged { sets, largest } => {
                write!(
                    f,
                    "the simulation mesh has up to {:.0} % more or less area than the surface in ",
                    largest * 100.0
                )?;
                write!(f, "{}; lower sim.maxEdgeLength, or name edge sets along folds in ", few(sets))?;
                write!(f, "sim.constraints")
            }
            Self::NarrowSeam { seam, count, examples, least } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "seam.{seam} is narrower than asked at {count} places ({some}), down to ")?;
                write!(
                    f,
                    "{:.0} % of its width and height; lower its width, or give it longer edges there",
                    least * 100.0
                )
            }
            Self::ShallowSeam { seam, count, examples, least } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "seam.{seam} is pushed less than its normalOffset at {count} places ({some}), down to ")?;
                write!(f, "{:.0} % of it, where it would cross another layer or part; ", least * 100.0)?;
                write!(f, "lower it there, or run a thickness after the seam")
            }
            Self::SharedSeamEdges { seam, count, examples } => {
                let some = some(*count, "points", examples, |[a, b]| format!("{a}-{b}"));
                write!(f, "edges of seam.{seam} that another seam has already: {count} ({some}); ")?;
                write!(f, "they follow the other, take them out of one of the two edge sets")
            }
            Self::NoRoomToTaper { seam, count, examples } => {
                let some = some(*count, "points", examples, |[a, b]| format!("{a}-{b}"));
                write!(f, "edges of seam.{seam} that stand alone inside the surface: {count} ({some}); ")?;
                write!(f, "they are left as they are, as a seam narrows to nothing at its ends: add an edge to each")
            }
            Self::ThinLayer { thickness, count, examples, least } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "thickness.{thickness} is thinner than asked at {count} places ({some}), down to ")?;
                write!(f, "{:.0} % of its amount, where it would cross itself or another part", least * 100.0)
            }
            Self::SetRenamed { wanted, name } => {
                write!(
                    f,
                    "the face set {wanted} of an operator is {name}, as the mesh has a subset of its name or no "
                )?;
                write!(f, "prim can have it; rename the operator")
            }
            Self::Unsound { operator, count, examples } => {
                let points: Vec<String> = examples.iter().map(usize::to_string).collect();
                let at = if points.is_empty() { String::new() } else { format!(", near points {}", points.join(", ")) };
                write!(f, "{operator}: {count} faces of the cage cross others or are turned over{at}; the surface ")?;
                write!(f, "bends too tightly for it there: make it narrower or thinner, or take those places out")
            }
            Self::BareFaces { thickness, count, examples, why } => {
                let some = some(*count, "points", examples, usize::to_string);
                write!(f, "thickness.{thickness} leaves out {count} faces ({some}) ")?;
                match why {
                    Bare::Turned => {
                        write!(f, "whose neighbours look the other way, as a second layer would pass through the ")?;
                        write!(f, "surface there; give both the same winding")
                    }
                    Bare::NoRoom => {
                        write!(f, "on which another part of the garment lies, so that there is no room for a second ")?;
                        write!(
                            f,
                            "layer; move them apart, put the layer on the other side, or take them out of its faces"
                        )
                    }
                    Bare::CutOff => {
                        write!(f, "that others without a second layer cut off from the border, so that there is ")?;
                        write!(f, "nothing to fold over; mend those, or set thickness.{thickness}.closed")
                    }
                }
            }
            Self::OperatorsLeftOut { names } => {
                write!(f, "not in render.operators, and so not made: {}", names.join(", "))
            }
            Self::SetsBlurred { sets, least } => {
                write!(
                    f,
                    "whole triangles of the simulation mesh agree by no more than {:.0} % of area ",
                    least * 100.0
                )?;
                write!(
                    f,
                    "with face subsets that are hardly larger: {}; name edge sets along their borders ",
                    few(sets)
                )?;
                write!(f, "in sim.constraints, or lower sim.maxEdgeLength")
            }
            Self::RootMesh { prim } => {
                write!(
                    f,
                    "{prim} is a root prim, and so are the meshes beside it: a reference to the file's default "
                )?;
                write!(f, "prim does not bring them; put the model below an Xform")
            }
            Self::NotCarried { what, why } => write!(f, "not carried: {what} ({why})"),
            Self::Composition { fault } => write!(f, "the stage does not compose fully: {fault}"),
        }
    }
}

/// The first few names, and how many more there are.
fn few(names: &[String]) -> String {
    let (shown, more) = (names.iter().take(5).cloned().collect::<Vec<_>>().join(", "), names.len().saturating_sub(5));
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

/// The examples of `count` elements, with dots where there are more.
fn some<T>(count: usize, kind: &str, examples: &[T], name: impl Fn(&T) -> String) -> String {
    let names: Vec<String> = examples.iter().map(name).collect();
    if names.is_empty() {
        return "between the input's points".into();
    }
    let dots = if count > examples.len() { ", …" } else { "" };
    format!("{kind} {}{dots}", names.join(", "))
}

/// The warnings of one run, in the order in which they arose; the caller prints them once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// Adds a warning, unless it is there already.
    pub fn push(&mut self, warning: Warning) {
        if !self.0.contains(&warning) {
            self.0.push(warning);
        }
    }

    /// Adds all of `others`.
    pub fn extend(&mut self, others: &Self) {
        others.0.iter().for_each(|warning| self.push(warning.clone()));
    }

    /// The warnings so far.
    pub fn iter(&self) -> impl Iterator<Item = &Warning> {
        self.0.iter()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
