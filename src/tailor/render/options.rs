//! Options of the render mesh, and what the options of an operator give.

use super::operator::Operator;
use std::sync::Arc;
use tailor_mesh::options::{Domain, OptionGroup, options};

options! {
    /// Options of the render mesh of this garment, an all-quad Catmull-Clark cage.
    "render" => RenderOptions {
        /// Subdivision level of the render mesh, each with four times the faces of the last; 0 is the cage itself
        "level" level: u32 = 2, Domain::Whole { most: 6, usual: 3 }, "levels";

        /// Refinements before the first seam, at most the level; 0 is as many as leave its lines room, and at least one
        /// after it
        "seamLevel" seam_level: u32 = 0, Domain::Whole { most: 6, usual: 3 }, "levels";

        /// Operators in the order they run, such as seam.placket; empty is all folds by name, then all seams by name
        "operators" operators: Vec<String> = Vec::new(), Domain::Operators, "names of operators";

        /// Add face sets of the faces that each operator creates, with its name followed by _seam, _rows, _hem
        /// or _inner
        "faceSets" face_sets: bool = false, Domain::Flag, "true or false";
    }
}

/// The options of one operator of a recipe.
pub trait OperatorOptions: OptionGroup {
    /// False if the operator is left out. Its values are then not checked.
    fn is_enabled(&self) -> bool;

    /// The operator of these options, under a name.
    fn operator(&self, name: &str) -> Arc<dyn Operator>;

    /// A single operator that replaces `before`, the operator just before, and this one. By default they stay apart.
    fn joined(&self, _name: &str, _before: &dyn Operator) -> Option<Arc<dyn Operator>> {
        None
    }
}

impl dyn OperatorOptions + '_ {
    /// The kind and name of an operator, such as `seam.placket`.
    pub fn full_name(&self, name: &str) -> String {
        format!("{}.{name}", self.group().name)
    }
}
