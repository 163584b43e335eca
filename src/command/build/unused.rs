//! Warnings of sets that nothing uses, together as one.

use std::collections::BTreeSet;
use tailor_costume::Products;
use tailor_mesh::error::{Warning, Warnings, names};

/// Begin of the place of a warning of one set of the garment.
const SET: &str = "subset ";

/// The warnings of products, with those of sets that are not carried as one, if neither the recipe nor a material names the sets.
/// Exporters write sets by the dozen that nobody uses.
pub fn together(products: &Products) -> Warnings {
    let recipe = serde_json::to_string(&products.recipe).unwrap_or_default();
    let words: BTreeSet<&str> = recipe.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let unused = |warning: &Warning| {
        let set = warning.place.strip_prefix(SET).filter(|_| warning.code == tailor_mesh::codes::NOT_CARRIED)?;
        let is_used = words.contains(set) || products.sim.materials.contains_key(set);
        (!is_used).then(|| set.to_owned())
    };
    let sets: BTreeSet<String> = products.warnings.iter().filter_map(unused).collect();
    if sets.len() < 2 {
        return products.warnings.clone();
    }
    let (apart, mut all): (Vec<Warning>, Vec<Warning>) =
        products.warnings.iter().cloned().partition(|warning| unused(warning).is_some());
    let sets: Vec<String> = sets.into_iter().collect();
    let why = "elements are lost on the simulation mesh, and neither the recipe nor a material names the sets";
    let mut warning = Warning::not_carried(format!("subsets {}", names(&sets)), why);
    warning.names = sets;
    warning.elements = apart[0].elements.clone();
    apart.iter().for_each(|other| warning.elements.merge(&other.elements));
    all.push(warning.remedy("Name those that you need in sim.constraints, or leave the others out of the export"));
    all.into_iter().collect()
}
