//! Named sets of elements (`UsdGeomSubset`) and their families.

use crate::connectivity::Elements;
use crate::error::{Warning, WarningCode};

/// Family of the borders and seams of a simulation mesh.
pub const CONSTRAINTS: &str = "tailorConstraints";
/// Family of the sets that a recipe derives from an expression. Their name is its text.
pub const DERIVED: &str = "tailorDerived";

/// A named set of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Subset {
    /// Name of the subset's prim.
    pub name: String,
    /// Its family; empty for none.
    pub family: String,
    /// Its elements.
    pub elements: Elements,
    /// The sharpness of its edges or points as creases or corners, if the set was built from those.
    pub sharpness: Option<f32>,
}

/// A warning of face sets, with the faces of all of them.
pub fn face_sets_warning(code: WarningCode, sets: &[&Subset], problem: String) -> Warning {
    let mut faces = Elements::Faces(Vec::new());
    sets.iter().for_each(|set| faces.merge(&set.elements));
    Warning::of_sets(code, sets.iter().map(|set| set.name.clone()).collect(), problem).at(faces)
}

/// The rule by which the subsets of a family share elements, as `subsetFamily:<name>:familyType`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FamilyType {
    /// Every element is in exactly one subset.
    Partition,
    /// No element is in two subsets.
    NonOverlapping,
    /// No rule.
    #[default]
    Unrestricted,
}

/// A family of subsets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    /// Its name.
    pub name: String,
    /// Its rule.
    pub kind: FamilyType,
}

/// `base`, or the first of `base_2`, `base_3` and so on that is free.
pub fn free_name(base: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let (mut name, mut number) = (base.to_owned(), 1);
    while is_taken(&name) {
        number += 1;
        name = format!("{base}_{number}");
    }
    name
}
