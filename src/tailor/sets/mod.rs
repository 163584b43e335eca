//! Sets of elements that follow from a garment: borders, UV seams, creases, materials, painted weights and what is made of
//! them, so that a recipe needs no authored edge sets.
//!
//! An expression is text such as `uvSeams - border(collar)`. [`SetEvaluator`] finds its elements, and lists the sets that a
//! garment offers.

mod elements;
mod evaluate;
mod expression;
mod functions;
mod list;
mod pieces;
mod select;
mod symmetry;
#[cfg(test)]
mod tests;
mod weights;

pub use evaluate::Function;
pub use expression::{quoted, split_list};
pub use functions::FUNCTIONS;
pub use functions::{checksum, painted_expression, painted_weights};
pub use list::ListedSet;
pub use select::Change;
pub use symmetry::Symmetry;
pub use weights::{weights_named, weights_of};

use crate::codes;
use elements::ElementSet;
use evaluate::Evaluation;
use expression::{Expression, Extreme};
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use tailor_mesh::connectivity::{Elements, Topology};
use tailor_mesh::error::{Error, ErrorCode};
use tailor_mesh::garment::{Mesh, Subset};

/// A fault of an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct SetFault {
    pub(super) code: ErrorCode,
    /// The problem.
    pub text: String,
    /// The cure.
    pub remedy: String,
}

impl SetFault {
    fn new(text: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { code: codes::SET_EXPRESSION, text: text.into(), remedy: remedy.into() }
    }

    /// The error of an option or argument that holds the expression.
    pub fn at(self, place: &str) -> Error {
        Error::recipe(place, self.text).code(self.code).remedy(self.remedy)
    }
}

/// The elements of an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedSet {
    /// The elements.
    pub elements: Elements,
    /// Alternatives of the garment for what was not found; empty if all was found.
    pub notes: Vec<String>,
}

/// The functions as help text, one a line.
pub fn help() -> String {
    let line = |function: &Function| {
        let Function { usage, gives, meaning, .. } = function;
        format!("  {usage:<40} {gives:<8} {meaning}\n")
    };
    let words: Vec<&str> = Extreme::ALL.iter().map(|(word, _)| *word).collect();
    let functions: String = FUNCTIONS.iter().map(line).collect();
    let pieces = format!("A piece of a set is set.1, set.2 and so on, or one of: {}.", words.join(", "));
    format!("Sets that a recipe can name in place of subsets; +, - and & combine them:\n{functions}{pieces}\n")
}

/// True for a single name that is not that of a function, so that it can only be a subset of the garment.
pub fn is_subset_name(text: &str) -> bool {
    let is_function = |name: &str| FUNCTIONS.iter().any(|function| function.name == name);
    matches!(Expression::parse(text), Ok(Expression::Name(name)) if !is_function(&name))
}

/// Evaluates expressions on one garment.
pub struct SetEvaluator<'a> {
    garment: &'a Mesh,
    topology: Topology,
    /// The UV set of functions that name none.
    uv_set: &'a str,
    symmetry: OnceCell<Option<Symmetry>>,
}

impl<'a> SetEvaluator<'a> {
    /// An evaluator for a garment and the UV set of functions that name none.
    pub fn new(garment: &'a Mesh, uv_set: &'a str) -> Self {
        let topology = Topology::new(garment.faces.clone(), garment.points.len());
        Self { garment, topology, uv_set, symmetry: OnceCell::new() }
    }

    /// The plane of symmetry of the garment, if it has one.
    pub fn symmetry(&self) -> Option<&Symmetry> {
        self.symmetry.get_or_init(|| Symmetry::of(self.garment, &self.topology, |v| v)).as_ref()
    }

    /// The name of the twin of each set that has one on the other side; a set that lies on both sides has its own name.
    pub fn twins(&self, sets: &[Subset]) -> BTreeMap<String, String> {
        self.symmetry().map_or_else(BTreeMap::new, |symmetry| symmetry.twins(&self.topology, sets))
    }

    /// The elements of an expression.
    ///
    /// # Errors
    /// A text that is not an expression, a name that the garment lacks, and sets of another kind than a function takes.
    pub fn evaluate(&self, text: &str) -> Result<DerivedSet, SetFault> {
        let evaluation = self.evaluation();
        let elements = evaluation.evaluate(&Expression::parse(text)?)?.into_elements();
        Ok(DerivedSet { elements, notes: evaluation.notes.into_inner() })
    }

    fn elements(&self, expression: &Expression) -> Result<ElementSet, SetFault> {
        self.evaluation().evaluate(expression)
    }

    fn evaluation(&self) -> Evaluation<'_> {
        Evaluation { sets: self, functions: FUNCTIONS, notes: RefCell::default(), known: RefCell::default() }
    }
}
