//! Options of operators, for recipes, the command-line help and the USD plugin.

use super::operator::Operator;
use crate::error::Error;
use crate::garment::Garment;
use serde_json::Value;
use std::sync::Arc;

/// The description of an option, for the help, the schemas and the preview.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// The key, such as `sim.maxEdgeLength`; for an operator the last part alone, such as `width`.
    pub key: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// The values that it takes.
    pub domain: Domain,
    /// Meaning, in a few words.
    pub meaning: &'static str,
}

/// The values of an option. Ranges are those of a slider; the recipe may hold values beyond them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// True or false.
    Flag,
    /// A number without a unit of length.
    Number {
        /// Start of the range.
        least: f32,
        /// End of the range.
        most: f32,
        /// A step that can be seen.
        step: f32,
    },
    /// A whole number from 0.
    Whole {
        /// End of the range.
        most: u32,
    },
    /// A length. \[mean edge lengths of the mesh\]
    Length {
        /// Start of the range.
        least: f32,
        /// End of the range.
        most: f32,
        /// The length that 0 stands for; 0 if it is no length.
        automatic: f32,
    },
    /// One of several words.
    Choice(&'static [&'static str]),
    /// Some of several words.
    Words(&'static [&'static str]),
    /// Free text.
    Text,
    /// A UV set, or empty.
    UvSet,
    /// A painted float primvar, or empty.
    Weights,
    /// Edge subsets.
    EdgeSets,
    /// Edge and point subsets.
    LineSets,
    /// Face subsets.
    FaceSets,
    /// Operators of the recipe.
    Operators,
}

/// The options of one operator of a recipe.
pub trait OperatorOptions {
    /// The kind of operator, such as `seam`: the first part of its keys.
    fn kind(&self) -> &'static str;

    /// The descriptions of the options, in the order of the schema.
    fn keys(&self) -> &'static [Key];

    /// False if the operator is left out. Its values are then not checked.
    fn is_enabled(&self) -> bool;

    /// Checks the values without a garment; `key` gives the key of a field for messages.
    ///
    /// # Errors
    /// A value out of its range.
    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), Error>;

    /// Checks the names against a garment.
    ///
    /// # Errors
    /// A subset or primvar that the garment lacks, or that has another type.
    fn bind(&self, key: &dyn Fn(&str) -> String, garment: &Garment) -> Result<(), Error>;

    /// Replaces automatic lengths by a share of `mean_edge`, the mean edge length of the garment. \[mesh units\]
    fn resolve_lengths(&mut self, mean_edge: f32);

    /// The operator of these options, under a name.
    fn operator(&self, name: &str) -> Arc<dyn Operator>;

    /// A single operator that replaces `before`, the operator just before, and this one. By default they stay apart.
    fn joined(&self, _name: &str, _before: &dyn Operator) -> Option<Arc<dyn Operator>> {
        None
    }
}

impl dyn OperatorOptions + '_ {
    /// A function from fields to their keys, such as `seam.placket.width`, for the operator `name`.
    pub fn key_of(&self, name: &str) -> impl Fn(&str) -> String {
        let full_name = self.full_name(name);
        move |field| format!("{full_name}.{field}")
    }

    /// The kind and name of an operator, such as `seam.placket`.
    pub fn full_name(&self, name: &str) -> String {
        format!("{}.{name}", self.kind())
    }
}

/// A kind of operator.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Name of the kind: the first part of its keys.
    pub name: &'static str,
    /// Descriptions of its options.
    pub keys: &'static [Key],
    /// Default values of the options, as a JSON object.
    pub defaults: fn() -> Value,
    /// True if its instances are operators of the render mesh.
    pub is_operator: bool,
}
