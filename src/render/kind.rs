//! What the recipe needs to know of the options of an operator.

use super::shape::Operator;
use crate::error::Error;
use crate::garment::Garment;
use serde::Serialize;
use serde_json::Value;

/// An option of every instance of a kind of operator.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub field: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// What operators are made with.
#[derive(Clone, Copy, Debug)]
pub struct Context {
    /// Points of the garment.
    pub points: usize,
    /// Whether operators leave face sets of what they made.
    pub names_sets: bool,
}

/// The options of one instance of an operator.
pub trait Instance {
    /// The kind: the first part of its keys.
    fn kind(&self) -> &'static str;

    /// Whether the values make sense, before any garment is looked at; `key` gives the key of an option.
    ///
    /// # Errors
    /// One that makes none.
    fn check(&self, key: &dyn Fn(&str) -> String) -> Result<(), Error>;

    /// Whether what they name is on a garment.
    ///
    /// # Errors
    /// A name of nothing there, or of something of another kind.
    fn bind(&self, key: &dyn Fn(&str) -> String, garment: &Garment) -> Result<(), Error>;

    /// Gives automatic lengths their value, by the mean edge length of the garment.
    fn settle(&mut self, mean_edge: f32);

    /// Puts the operator of an instance on a stack, or makes it part of the last one there.
    fn stack(&self, name: &str, context: Context, operators: &mut Vec<Box<dyn Operator>>);
}

impl dyn Instance + '_ {
    /// What gives the keys of the options of an instance.
    pub fn key_of(&self, name: &str) -> impl Fn(&str) -> String {
        let start = self.full_name(name);
        move |field| format!("{start}.{field}")
    }

    /// The name of an instance with its kind.
    pub fn full_name(&self, name: &str) -> String {
        format!("{}.{name}", self.kind())
    }
}

/// The options of a kind of operator, as a type.
pub trait Options: Instance + Default + Serialize {
    /// The kind: the first part of its keys.
    const KIND: &'static str;
    /// The options in the order of the schema.
    const KEYS: &'static [Key];
}

/// A kind of operator.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name: the first part of its keys.
    pub name: &'static str,
    /// Its options.
    pub keys: &'static [Key],
    /// Their defaults, as an object.
    pub defaults: fn() -> Value,
}

impl Kind {
    /// The kind that has these options.
    pub const fn of<O: Options>() -> Self {
        let defaults = || serde_json::to_value(O::default()).unwrap_or_default();
        Self { name: O::KIND, keys: O::KEYS, defaults }
    }
}
