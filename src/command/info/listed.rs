//! The sets that a garment offers, as text.

use std::fmt::Write as _;
use tailor::sets::ListedSet;
use tailor_costume::recipe::Recipe;
use tailor_mesh::Mesh;
use tailor_mesh::units::in_words as length;

/// Pieces of one set that are listed as text.
const MOST: usize = 12;

/// The sets in the words that a recipe takes, one a line.
pub fn in_words(sets: &[ListedSet]) -> String {
    let mut text = String::new();
    for of_one in sets.chunk_by(|a, b| a.stem() == b.stem()) {
        // The largest pieces, in their order.
        let mut sizes: Vec<f64> = of_one.iter().map(|set| set.size.unwrap_or_default()).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        let least = sizes.get(MOST - 1).copied().unwrap_or_default();
        let shown = of_one.iter().filter(|set| set.size.unwrap_or_default() >= least).take(MOST);
        shown.for_each(|set| line(&mut text, set));
        if of_one.len() > MOST {
            let _ = writeln!(text, "  set      and {} smaller pieces of {}", of_one.len() - MOST, of_one[0].stem());
        }
    }
    text
}

fn line(text: &mut String, set: &ListedSet) {
    let ListedSet { expression, kind, count, size, is_closed, place, low, high, .. } = set;
    let _ = write!(text, "  set      {expression}: {count} {kind}");
    match size {
        Some(meters) if *kind == "edges" => drop(write!(text, ", {}", length(*meters))),
        Some(square) => drop(write!(text, ", {:.0} cm2", 1e4 * square)),
        None => {}
    }
    let closed = if *is_closed { ", closed" } else { "" };
    let place = if place.is_empty() { String::new() } else { format!(", {place}") };
    let coordinates = |p: &[f32; 3]| p.map(|x| format!("{x:.1}")).join(" ");
    let _ = writeln!(text, "{closed}{place} ({} to {})", coordinates(low), coordinates(high));
}

/// A first recipe for a garment without sets and operators.
pub fn hint(garment: &Mesh, recipe: &Recipe, sets: impl FnOnce() -> Vec<ListedSet>) -> Option<String> {
    let has_sets = garment.subsets.iter().any(|set| set.family != "materialBind");
    if has_sets || !recipe.operators().is_empty() {
        return None;
    }
    let count = sets().iter().filter(|set| set.stem() == "uvSeams").count();
    let advice =
        format!("--set seam.all.edges=uvSeams sews its {count} UV seams, and `usdtailor sets` lists its other sets");
    (count > 0).then(|| format!("  hint: it has no sets of its own; {advice}\n"))
}
