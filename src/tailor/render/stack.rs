//! The stack of operators that a recipe asks for.

mod stage;
mod steps;

pub use stage::Origins;
pub use steps::{RenderResult, RenderSteps};

use super::operator::Operator;
use super::{OperatorOptions, RenderOptions};
use crate::codes;
use std::sync::Arc;
use tailor_mesh::connectivity::Topology;
use tailor_mesh::error::{Error, Warning, Warnings, names};
use tailor_mesh::garment::Mesh;
use tailor_mesh::options::did_you_mean;

/// Operators in their order, and the refinements after them.
#[derive(Clone)]
struct Stage {
    operators: Vec<Arc<dyn Operator>>,
    /// \[levels\]
    level: u32,
    names_sets: bool,
}

/// The operators of a render mesh in their order, and its subdivision level.
#[derive(Clone)]
pub struct Stack {
    /// The operators.
    pub operators: Vec<Arc<dyn Operator>>,
    /// Kinds and names of the recipe's operators, such as `seam.placket`.
    pub names: Vec<String>,
    /// Refinements of the cage. \[levels\]
    pub level: u32,
    /// Refinements before the first seam; 0: as many as leave its lines room. \[levels\]
    pub seam_level: u32,
    /// True if operators add face subsets of their new faces.
    pub names_sets: bool,
    /// Warnings of operators that `render.operators` omits.
    pub warnings: Warnings,
}

impl Stack {
    /// Whether the garment is the render mesh as it is.
    pub fn is_empty(&self) -> bool {
        self.level == 0 && self.operators.is_empty()
    }

    /// The stack of a recipe with the operators `all`, by name.
    ///
    /// # Errors
    /// A name in `render.operators` that is unknown, ambiguous or repeated.
    pub fn new(options: &RenderOptions, all: &[(&str, &dyn OperatorOptions)]) -> Result<Self, Error> {
        let (order, warnings) = order(all, &options.operators)?;
        let mut stack = Self {
            operators: Vec::new(),
            names: Vec::new(),
            level: options.level,
            seam_level: options.seam_level,
            names_sets: options.face_sets,
            warnings,
        };
        for at in order {
            let (name, options) = all[at];
            if !options.is_enabled() {
                continue;
            }
            match stack.operators.last().and_then(|last| options.joined(name, last.as_ref())) {
                Some(joined) => *stack.operators.last_mut().expect("an operator was joined") = joined,
                None => stack.operators.push(options.operator(name)),
            }
            stack.names.push(options.full_name(name));
        }
        let parts = |operator: Arc<dyn Operator>| {
            let parts = operator.parts();
            if parts.is_empty() { vec![operator] } else { parts }
        };
        stack.operators = stack.operators.into_iter().flat_map(parts).collect();
        Ok(stack)
    }

    /// The stages for a garment with its connectivity: the operators of the coarse cage with the refinements before the first
    /// seam, and all others; a single stage where no refinement comes before.
    fn stages(&self, garment: &Mesh, t: &Topology) -> Vec<Stage> {
        let rooms: Vec<Option<u32>> = self.operators.iter().map(|o| o.levels_with_room(garment, t)).collect();
        let stage = |operators: &[Arc<dyn Operator>], level: u32| Stage {
            operators: operators.to_vec(),
            level,
            names_sets: self.names_sets,
        };
        let automatic = rooms.iter().flatten().min().map_or(0, |&room| room.min(self.level.saturating_sub(1)));
        let before = if self.seam_level > 0 { self.seam_level.min(self.level) } else { automatic };
        let first = rooms.iter().position(Option::is_some).filter(|_| before > 0);
        let Some(first) = first else { return vec![stage(&self.operators, self.level)] };
        let (folds, seams) = self.operators.split_at(first);
        vec![stage(folds, before), stage(seams, self.level - before)]
    }
}

impl Stage {
    /// The largest height of the operators, rounded up to a quarter power of two so that most edits keep it.
    /// \[mesh units\]
    fn reach(&self, garment: &Mesh) -> f32 {
        let furthest = self.operators.iter().map(|o| o.reach(garment)).fold(0.0, f32::max);
        if furthest > 0.0 { (0.25 * (4.0 * furthest.log2()).ceil()).exp2() } else { 0.0 }
    }
}

/// Indices of the operators in the order of `wanted`, all of them if it is empty; the warning of those that it omits.
fn order(all: &[(&str, &dyn OperatorOptions)], wanted: &[String]) -> Result<(Vec<usize>, Warnings), Error> {
    let mut warnings = Warnings::default();
    if wanted.is_empty() {
        return Ok(((0..all.len()).collect(), warnings));
    }
    let full_name = |i: usize| all[i].1.full_name(all[i].0);
    let fault = |name: &str, fault: &str| {
        let known: Vec<String> = (0..all.len()).map(full_name).collect();
        let likely = did_you_mean(name, &known);
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        let error =
            Error::recipe("render.operators", format!("it names \"{name}\", {fault}")).code(codes::UNKNOWN_OPERATOR);
        Err(error.remedy(format!("{likely}the operators of the recipe are: {known}")))
    };
    let mut order: Vec<usize> = Vec::new();
    for name in wanted {
        let found: Vec<usize> = (0..all.len()).filter(|&i| is_name_of(all[i], name)).collect();
        match found.as_slice() {
            [] => return fault(name, "which is not an operator of the recipe"),
            [one] if order.contains(one) => return fault(name, "which it names twice"),
            [one] => order.push(*one),
            _ => return fault(name, "which several operators have; add its kind"),
        }
    }
    let omitted: Vec<String> =
        (0..all.len()).filter(|i| all[*i].1.is_enabled() && !order.contains(i)).map(full_name).collect();
    if !omitted.is_empty() {
        let problem = format!("it leaves out operators, which do not run: {}", names(&omitted));
        let warning = Warning::new(codes::OPERATORS_LEFT_OUT, "render.operators", problem);
        warnings.push(warning.remedy("Add them to it, or delete them from the recipe"));
    }
    Ok((order, warnings))
}

/// True if `text` is the name of an operator, with or without its kind.
fn is_name_of((name, options): (&str, &dyn OperatorOptions), text: &str) -> bool {
    text == name || text.split_once(['.', ':']).is_some_and(|(kind, rest)| kind == options.group().name && rest == name)
}
