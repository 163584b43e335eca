//! Faults of composition in words.

use openusd::pcp::CompositionDiagnostic;

/// Arcs in one chain that the USD library follows.
const MOST_ARCS: usize = 100;

/// A fault of composition. The USD library calls a chain of arcs that is too long a cycle.
pub fn in_words(fault: &CompositionDiagnostic) -> String {
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
