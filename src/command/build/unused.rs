//! Warnings of sets that nothing uses, together as one.

use std::collections::{BTreeMap, BTreeSet};
use tailor::recipe::named_sets;
use tailor_costume::Products;
use tailor_mesh::error::{Warning, Warnings, names};

/// Begin of the place of a warning of one set of the garment.
const SET: &str = "subset ";

/// The warnings of products. Those of sets that lose elements are one for each kind of elements, if neither the recipe nor a
/// material names the sets: exporters write sets by the dozen that nobody uses.
pub fn together(products: &Products) -> Warnings {
    let groups = products.recipe.used();
    // An expression names sets among its words.
    let named = groups.iter().flat_map(|(_, options)| named_sets(*options)).flat_map(|(_, _, sets)| sets);
    let words: BTreeSet<&str> = named.flat_map(|set| set.split(|c: char| !c.is_alphanumeric() && c != '_')).collect();
    let unused = |warning: &Warning| {
        let set = warning.place.strip_prefix(SET).filter(|_| warning.code == tailor_mesh::codes::NOT_CARRIED)?;
        let is_used = words.contains(set) || products.sim.materials.contains_key(set);
        (!is_used).then(|| set.to_owned())
    };
    let mut of_kinds = BTreeMap::<&str, BTreeSet<String>>::new();
    for warning in products.warnings.iter() {
        of_kinds.entry(warning.elements.kind()).or_default().extend(unused(warning));
    }
    let is_alone = |warning: &&Warning| of_kinds[warning.elements.kind()].len() < 2 || unused(warning).is_none();
    let mut all: Warnings = products.warnings.iter().filter(is_alone).cloned().collect();
    for (kind, sets) in of_kinds.iter().filter(|(_, sets)| sets.len() > 1) {
        let sets: Vec<String> = sets.iter().cloned().collect();
        let why = "the simulation mesh lacks elements of them, and neither the recipe nor a material names them";
        let mut warning = Warning::not_carried(format!("{kind} sets {}", names(&sets)), why);
        for other in products.warnings.iter().filter(|w| w.elements.kind() == *kind && unused(w).is_some()) {
            if warning.elements.is_empty() {
                warning.elements = other.elements.clone();
            }
            warning.elements.merge(&other.elements);
        }
        warning.names = sets;
        all.push(warning.remedy("Name those that you need in sim.constraints, and leave the others out of the export"));
    }
    all
}
