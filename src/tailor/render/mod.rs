//! The render mesh: the cage through a stack of operators and refinements.
//!
//! An operator gives a new connectivity with the parents of every element ([`child`]), and heights over the limit surface
//! of its parent. `placement` finds the points: they are moved until their limit is on the limit surface of the parent, and
//! raised. `points` holds heights within the clearance to other layers, and `repair` lowers heights where faces would
//! intersect or flip against the `reference` normals of the first cage. Attributes follow the derivation by the code that
//! refinement uses. Seams and hems share the insertion of `lines` beside marked edges. `parallels` cuts rows of stitches
//! at a distance from such edges. `stack` runs all of it: folds on the cage, then seams on the refined cage.
//!
//! # A new operator
//!
//! 1. A file here with its options (the macro `options!`, and the trait [`OperatorOptions`]) and the operator (the trait
//!    [`operator::Operator`]). [`apply`](operator::Operator::apply) builds the connectivity with a [`child::ChildBuilder`]
//!    and lists the vertices whose limit position is controlled; [`heights`](operator::Operator::heights) raises each of
//!    them.
//! 2. A row in `recipe/groups.rs`, and an export of the options here and in `lib.rs`. `CONTRIBUTING.md` of the repository lists the
//!    other places: the whole recipe, documents, the page of the preview, the extension for Blender.

pub mod child;
mod fold;
mod limit;
mod lines;
pub mod operator;
mod options;
mod parallels;
mod placement;
mod points;
mod reference;
mod repair;
mod seam;
mod stack;

pub use fold::{FoldOptions, Side};
pub use limit::LimitSurface;
pub use options::{OperatorOptions, RenderOptions};
pub use parallels::SurfaceLine;
pub use seam::{RowSide, SeamEnd, SeamOptions};
pub use stack::{Origins, RenderResult, RenderSteps, Stack};

use crate::codes;
use operator::OperatorInput;
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{BoundaryInterpolation, Elements, Mesh, Scheme, Subset, free_name};
use tailor_mesh::subdivide::{Level, MAX_REFINED_FACES, refined_faces};

/// Whether a cage, whose faces operators have multiplied, can be refined.
fn check_size(cage: &Mesh, level: u32) -> Result<(), Error> {
    let faces = refined_faces(cage, level);
    if faces <= MAX_REFINED_FACES || level == 0 {
        return Ok(());
    }
    let fault = format!("level {level} makes {faces} faces with the operators, more than {MAX_REFINED_FACES}");
    Err(Error::recipe("render.level", fault).code(codes::TOO_LARGE).remedy("lower the level"))
}

/// Notes the faces that `interpolateBoundary = "none"` removes, which are fewer with each refinement.
fn add_border_holes(cage: &mut Mesh, level: &Level) {
    if cage.rules.boundary == BoundaryInterpolation::None {
        let holes = level.border_holes(cage);
        cage.holes.extend(holes);
        cage.holes.sort_unstable();
        cage.holes.dedup();
    }
}

/// Subsets of new faces, under names that prims may have and no other subset has: the name that is wanted, or followed by `_faces`
/// where a subset has it. Warns of other names.
fn new_sets(garment: &Mesh, wanted: Vec<(String, Vec<FaceId>)>) -> (Vec<Subset>, Warnings) {
    let mut warnings = Warnings::default();
    let mut sets: Vec<Subset> = Vec::with_capacity(wanted.len());
    for (wanted, faces) in wanted {
        let valid: String = wanted.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let valid = if valid.starts_with(|c: char| c.is_ascii_digit()) { format!("_{valid}") } else { valid };
        let is_taken = |name: &str| garment.subset(name).is_some() || sets.iter().any(|set| set.name == name);
        // A seam `waist` of the edge set `waist_seam` is a natural pair.
        let asked = if is_taken(&valid) { format!("{valid}_faces") } else { valid.clone() };
        let name = free_name(&asked, is_taken);
        if valid != wanted || name != asked {
            let problem = format!("operator face set `{wanted}` was renamed `{name}`: its name is taken or not valid");
            warnings.push(Warning::new(codes::SET_RENAMED, &name, problem).remedy("Rename the operator"));
        }
        sets.push(Subset { name, family: String::new(), elements: Elements::Faces(faces), sharpness: None });
    }
    (sets, warnings)
}

/// Loop surfaces have no quads to work with.
fn refuse_loop(cage: &OperatorInput, operator: &str) -> Result<(), Error> {
    if cage.garment.rules.scheme != Scheme::Loop {
        return Ok(());
    }
    let prim = &cage.garment.prim;
    let fault = format!("it makes quads, which {prim} with subdivisionScheme \"loop\" cannot have");
    Err(Error::recipe(operator, fault)
        .code(codes::LOOP_OPERATORS)
        .remedy("set the scheme to catmullClark, or remove the operator"))
}
