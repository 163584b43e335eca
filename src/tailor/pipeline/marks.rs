//! Sets of the places that warnings name, on the render mesh.

use std::collections::BTreeMap;
use std::sync::Arc;
use tailor_mesh::connectivity::Elements;
use tailor_mesh::error::Warnings;
use tailor_mesh::garment::{Mesh, Subset, free_name};

/// The garment with a set for each kind of elements of each code of warning: `mark_flipped_uvs`. None if no warning names
/// elements.
pub fn marked(garment: &Mesh, warnings: &Warnings) -> Option<Mesh> {
    let mut marks = BTreeMap::<(String, &str), Elements>::new();
    for warning in warnings.iter().filter(|warning| !warning.elements.is_empty()) {
        let name = format!("mark_{}", warning.code.to_string().replace('-', "_"));
        // A warning may name an element twice, and a set may not.
        let known = marks.entry((name, warning.elements.kind())).or_insert_with(|| warning.elements.clone());
        known.merge(&warning.elements);
    }
    if marks.is_empty() {
        return None;
    }
    let mut subsets = garment.subsets.to_vec();
    for ((name, _), elements) in marks {
        let name = free_name(&name, |name| subsets.iter().any(|set| set.name == name));
        subsets.push(Subset { name, family: String::new(), elements, sharpness: None });
    }
    Some(Mesh { subsets: Arc::new(subsets), ..garment.clone() })
}
