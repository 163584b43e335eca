//! The render mesh: the cage through a stack of operators, then refined.
//!
//! An operator is a *derivation* (cage in, cage out, with the parents of every element: [`derivation`]) and a
//! *deformation* (where the limit surface of the new cage is to be: `surface`). Attributes of every kind go through the
//! derivation by the code that refinement uses. Seams and hems share the insertion of lines beside marked edges
//! (`lines`).
//!
//! Heights stay within the room that is left to other layers (`placed`, from gaps found once on the input; where there is
//! none, a thickness leaves faces as they are: `thickness::cover`), the cage settles to them without the waves of an exact
//! fit (`settle`), and `sound` lowers them where faces still would cross or turn over, as seen from the `front` of the input.
//!
//! # A new operator
//!
//! 1. A file here with two types. Its options (a serde struct with defaults) have the traits [`Options`] and [`Instance`]:
//!    their keys with units and meanings, what they may be, what they name on the garment, automatic lengths. The operator
//!    has the trait [`Operator`]: `shape` collects faces, vertices and edges in a [`derivation::Builder`], each with its
//!    parent, and lists the vertices that are held (`clearance` is the room there is for them); `heights` says how far from
//!    the old surface each of them is, `reach` the furthest of them, and `reduced` and `unsound` warn of what is not as
//!    asked. `structure` names the options that `shape` reads, so that a change of the others only moves points.
//! 2. A multiple-apply schema in `schemas/schema.usda`; a test holds its attributes to the options.
//! 3. Its options among those of [`Recipe`](crate::recipe::Recipe): a map of instances by name, and its line in `KINDS` and
//!    in the lists of instances beside it, where serde and `--set`, layers, the help and the plugin find all they need.

pub mod derivation;
mod front;
mod kind;
mod lines;
mod placed;
mod placing;
mod repair;
mod seam;
mod settle;
mod shape;
mod stages;
mod surface;
mod thickness;

pub use front::Front;
pub use kind::{Context, Instance, Key, Kind, Options};
pub use placed::{Placed, Room};
pub use placing::{Ground, Placing};
pub use seam::{SeamOptions, Seams};
pub use shape::{Formed, Held, Operator, Origin, Role, Shape, Shaped};
pub use stages::{Afresh, Rendered, Stages, render};
pub use surface::Surface;
pub use thickness::{Side, Thickness, ThicknessOptions};

use crate::error::{EXAMPLES, Error, Warning, Warnings};
use crate::garment::{BoundaryInterpolation, Elements, Garment, Subset};
use crate::mesh::{FaceId, VertexId};
use crate::subdivide::{Cage, Level, MAX_REFINED_FACES, refined_faces};
use serde::{Deserialize, Serialize};

/// A height or a distance that keeps less of what was asked than this is reported.
const REPORTED: f32 = 0.98;

/// Options of the render mesh: the attributes of `TailorRenderAPI`, with the same names and defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub struct RenderOptions {
    /// Refinements of the cage. \[levels\]
    pub level: u32,
    /// Names of the operators in the order in which they run; empty: seams, then thickness.
    pub operators: Vec<String>,
    /// Whether each operator leaves face subsets of what it made: `<name>_seam`, `<name>_hem`, `<name>_inner`.
    pub face_sets: bool,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { level: 1, operators: Vec::new(), face_sets: false }
    }
}

/// The operators of a render mesh in their order, and its level.
pub struct Stack {
    /// The operators.
    pub operators: Vec<Box<dyn Operator>>,
    /// Their names with their kinds, of each seam by itself.
    pub names: Vec<String>,
    /// Refinements after them. \[levels\]
    pub level: u32,
    /// What was met on the way.
    pub warnings: Warnings,
}

impl Stack {
    /// The stack of a garment of `points` points, from all instances by name.
    ///
    /// # Errors
    /// A name in `operators` that no instance has, or more than one.
    pub fn new(points: usize, options: &RenderOptions, instances: &[(&str, &dyn Instance)]) -> Result<Self, Error> {
        let mut warnings = Warnings::default();
        let context = Context { points, names_sets: options.face_sets };
        let mut operators: Vec<Box<dyn Operator>> = Vec::new();
        let mut names = Vec::new();
        for at in order(instances, &options.operators, &mut warnings)? {
            let (name, instance) = instances[at];
            instance.stack(name, context, &mut operators);
            names.push(instance.full_name(name));
        }
        Ok(Self { operators, names, level: options.level, warnings })
    }

    /// The furthest that an operator goes from the surface of a garment, rounded up, so that what depends on it need not
    /// change with each edit. \[stage units\]
    pub fn reach(&self, garment: &Garment) -> f32 {
        let furthest = self.operators.iter().map(|o| o.reach(garment)).fold(0.0, f32::max);
        if furthest > 0.0 { (0.25 * (4.0 * furthest.log2()).ceil()).exp2() } else { 0.0 }
    }
}

/// The places of the instances in the order of `names`; all of them where it is empty.
fn order(all: &[(&str, &dyn Instance)], names: &[String], warnings: &mut Warnings) -> Result<Vec<usize>, Error> {
    if names.is_empty() {
        return Ok((0..all.len()).collect());
    }
    let full_names = |of: &mut dyn Iterator<Item = usize>| of.map(|i| all[i].1.full_name(all[i].0)).collect::<Vec<_>>();
    let fault = |name: &str, fault: &str| {
        let known = full_names(&mut (0..all.len()));
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Err(Error::Recipe(format!(
            "render.operators names \"{name}\", {fault}\n  hint: the operators of the recipe are: {known}"
        )))
    };
    let mut order: Vec<usize> = Vec::new();
    for name in names {
        let called: Vec<usize> = (0..all.len()).filter(|&i| is_called(all[i], name)).collect();
        match called.as_slice() {
            [] => return fault(name, "which is no operator of the recipe"),
            [one] if order.contains(one) => return fault(name, "which it names before already"),
            [one] => order.push(*one),
            _ => return fault(name, "which is the name of several; give its kind too"),
        }
    }
    let left = full_names(&mut (0..all.len()).filter(|i| !order.contains(i)));
    if !left.is_empty() {
        warnings.push(Warning::OperatorsLeftOut { names: left });
    }
    Ok(order)
}

/// Whether `text` names an instance: by its name alone, or with its kind.
fn is_called((name, instance): (&str, &dyn Instance), text: &str) -> bool {
    text == name || text.split_once(['.', ':']).is_some_and(|(kind, rest)| kind == instance.kind() && rest == name)
}

/// Whether a cage, whose faces operators have multiplied, can be refined.
fn check_size(cage: &Garment, level: u32) -> Result<(), Error> {
    let faces = refined_faces(cage, level);
    if faces <= MAX_REFINED_FACES || level == 0 {
        return Ok(());
    }
    Err(Error::Recipe(format!(
        "{}: render.level {level} makes {faces} faces with its operators, more than {MAX_REFINED_FACES}\n  \
         hint: lower the level",
        cage.prim
    )))
}

/// The cage before any operator.
fn first_cage(garment: &Garment) -> Cage {
    let mut garment = garment.clone();
    add_border_holes(&mut garment);
    Cage::new(garment)
}

/// Notes the faces that `interpolateBoundary = "none"` removes, which are fewer with each refinement.
fn add_border_holes(cage: &mut Garment) {
    if cage.rules.boundary == BoundaryInterpolation::None {
        let holes = Level::base(cage).border_holes(cage);
        cage.holes.extend(holes);
        cage.holes.sort_unstable();
        cage.holes.dedup();
    }
}

/// Subsets of new faces, under names that prims may have and no other subset has.
fn new_sets(garment: &Garment, wanted: Vec<(String, Vec<FaceId>)>, warnings: &mut Warnings) -> Vec<Subset> {
    let mut sets: Vec<Subset> = Vec::with_capacity(wanted.len());
    for (wanted, faces) in wanted {
        let valid: String = wanted.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let valid = if valid.starts_with(|c: char| c.is_ascii_digit()) { format!("_{valid}") } else { valid };
        let mut numbered = (1..).map(|n| if n == 1 { valid.clone() } else { format!("{valid}_{n}") });
        let is_free = |name: &String| garment.subset(name).is_none() && sets.iter().all(|set| set.name != *name);
        let name = numbered.find(is_free).unwrap_or_default();
        if name != wanted {
            warnings.push(Warning::SetRenamed { wanted, name: name.clone() });
        }
        sets.push(Subset { name, family: String::new(), elements: Elements::Faces(faces), sharpness: None });
    }
    sets
}

/// The first points of the input among `vertices`, as many as a warning names.
fn examples(own_points: usize, vertices: impl IntoIterator<Item = VertexId>) -> Vec<usize> {
    vertices.into_iter().map(VertexId::index).filter(|&v| v < own_points).take(EXAMPLES).collect()
}

/// Loop surfaces have no quads to work with.
fn refuse_loop(cage: &Cage, operator: &str) -> Result<(), Error> {
    if seam::is_supported(cage.garment().rules.scheme) {
        return Ok(());
    }
    Err(Error::Recipe(format!(
        "{}: {operator} makes quads, which a mesh with subdivisionScheme \"loop\" cannot have\n  \
         hint: set the scheme to catmullClark, or remove the operator",
        cage.garment().prim
    )))
}
