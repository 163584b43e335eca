//! Faults of composition in words, and options in the wrong place.

mod payloads;

pub use payloads::{TailorPayloads, tailor_payloads};

use super::origin::without_arguments;
use openusd::pcp::CompositionDiagnostic;
use std::path::Path;

/// Arcs in one chain that the USD library follows.
const MOST_ARCS: usize = 100;

/// A fault of composition. The USD library calls a chain of arcs that is too long a cycle, and knows no `.tailor` file.
pub fn in_words(fault: &CompositionDiagnostic) -> String {
    if let Some((prim, recipe)) = recipe_of(fault) {
        return format!("{prim} has its garment from {recipe}, which only OpenUSD with the plugin composes");
    }
    let CompositionDiagnostic::ArcCycle(chain) = fault else { return fault.to_string() };
    let Some((last, before)) = chain.hops.split_last() else { return fault.to_string() };
    let root = (chain.root_layer == last.layer).then_some(&chain.composing);
    let same_layer = before.iter().filter(|hop| hop.layer == last.layer).map(|hop| &hop.path);
    let is_cycle = same_layer.chain(root).any(|path| path.has_prefix(&last.path) || last.path.has_prefix(path));
    if is_cycle {
        return fault.to_string();
    }
    format!(
        "references are nested too deeply at {}: the {}th in a chain, to {} of {}, is left out; at most {MOST_ARCS} are followed, \
         and fewer where they lead below a root prim",
        chain.composing,
        chain.hops.len(),
        last.path,
        last.layer
    )
}

/// The remedy of a fault of composition.
pub fn remedy(fault: &CompositionDiagnostic) -> String {
    match recipe_of(fault) {
        Some((_, recipe)) => format!("Name {recipe} itself as the input"),
        None => "Mend the reference, or remove it".to_owned(),
    }
}

/// The prim and the `.tailor` file of an arc to one; none of other faults.
pub fn recipe_of(fault: &CompositionDiagnostic) -> Option<(String, &str)> {
    let (CompositionDiagnostic::UnresolvedLayer { asset_path, site_path, .. }
    | CompositionDiagnostic::MalformedLayer { asset_path, site_path, .. }) = fault
    else {
        return None;
    };
    let file = without_arguments(asset_path);
    let is_recipe = Path::new(file).extension().is_some_and(|e| e.eq_ignore_ascii_case("tailor"));
    is_recipe.then(|| (site_path.to_string(), file))
}
