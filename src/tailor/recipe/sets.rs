//! Sets that a recipe describes by expressions.

use super::UsedGroup;
use crate::codes;
use crate::sets::{SetEvaluator, is_subset_name, quoted};
use std::borrow::Cow;
use std::cell::LazyCell;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::{DERIVED, Mesh, Subset};
use tailor_mesh::options::{Domain, Given, Key, OptionGroup, float_primvar, subset_of};

/// The elements of the sets that weights take.
const ANY: &[&str] = &["face", "edge", "point"];

/// The groups whose sets are those of the render mesh.
const OF_RENDER: [&str; 3] = ["fold", "seam", "stitch"];

/// The derived sets of a recipe, for each product those that its options name. Their names are the texts of the recipe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecipeSets {
    /// The sets of the simulation mesh and its cloth.
    pub sim: Vec<Subset>,
    /// The sets of the operators of the render mesh, and of what lies on it.
    pub render: Vec<Subset>,
}

impl RecipeSets {
    /// Evaluates what groups of options name and the garment has no subset for; `uv_set` is the resolved one. Warns of sets without
    /// elements.
    ///
    /// # Errors
    /// A text that is not an expression, or that does not fit the garment.
    pub fn new(groups: &[UsedGroup<'_>], uv_set: &str, garment: &Mesh) -> Result<(Self, Warnings), Error> {
        let evaluator = LazyCell::new(|| SetEvaluator::new(garment, uv_set));
        let (mut found, mut warnings) = (Self::default(), Warnings::default());
        for (prefix, options) in groups {
            let is_of_render = OF_RENDER.contains(&options.group().name);
            let sets = if is_of_render { &mut found.render } else { &mut found.sim };
            for (key, of, names) in named_sets(*options) {
                let place = format!("{prefix}.{}", key.key);
                for name in names {
                    let Some(expression) = expression_of(name, key, of, &place, garment)? else { continue };
                    if !sets.iter().any(|set| set.name == *name) {
                        let derived = evaluator.evaluate(&expression).map_err(|fault| fault.at(&place))?;
                        if derived.elements.is_empty() {
                            warnings.push(empty(&place, name, &derived.notes));
                        }
                        let (name, family) = (name.to_owned(), DERIVED.to_owned());
                        sets.push(Subset { name, family, elements: derived.elements, sharpness: None });
                    }
                    let kind = sets.iter().find(|set| set.name == *name).map_or("", |set| set.elements.kind());
                    if !of.contains(&kind) {
                        return Err(other_kind(&place, name, kind, of));
                    }
                }
            }
        }
        Ok((found, warnings))
    }
}

/// The keys of a group that name sets, with the kinds of elements that they take, and the names or expressions. A name of weights
/// may be that of a primvar.
pub fn named_sets(
    options: &dyn OptionGroup,
) -> impl Iterator<Item = (&'static Key, &'static [&'static str], Vec<&str>)> {
    let sets = |(key, given): (&'static Key, _)| match (key.domain, given) {
        (Domain::Sets { of, .. }, Given::Names(names)) => Some((key, of, names.iter().map(String::as_str).collect())),
        (Domain::Weights, Given::Text(name)) if !name.is_empty() => Some((key, ANY, vec![name])),
        _ => None,
    };
    options.group().keys.iter().zip(options.given()).filter_map(sets)
}

/// The expression that a name of an option stands for; none for that of a subset or of painted weights. Where points are wanted, painted
/// weights are those above their middle.
fn expression_of<'a>(
    name: &'a str,
    key: &Key,
    of: &[&str],
    place: &str,
    garment: &Mesh,
) -> Result<Option<Cow<'a, str>>, Error> {
    let are_weights = matches!(key.domain, Domain::Weights);
    let is_set = garment.subset(name).is_some();
    let is_primvar = garment.primvar(name).is_some() || garment.left_out(name).is_some();
    let is_word = !is_set && is_subset_name(name);
    // Of a primvar and a set with one name, weights are the primvar. A word that is neither is a fault.
    if are_weights && (is_primvar || is_word) || is_primvar && !is_set && of.contains(&"point") {
        float_primvar(garment, place, name)?;
        return Ok((!are_weights).then(|| Cow::Owned(format!("weight({})", quoted(name)))));
    }
    if is_word {
        subset_of(garment, place, name, of)?;
    }
    Ok((!is_set).then_some(Cow::Borrowed(name)))
}

fn other_kind(place: &str, name: &str, kind: &str, of: &[&str]) -> Error {
    let fault = Error::recipe(place, format!("\"{name}\" gives {kind}s, and it takes {}s", of.join("s or ")));
    fault.code(tailor_mesh::codes::UNKNOWN_SUBSET).remedy(format!("write {}s({name}), or another set", of[0]))
}

fn empty(place: &str, name: &str, notes: &[String]) -> Warning {
    let there = if notes.is_empty() { String::new() } else { format!(": {}", notes.join("; ")) };
    let warning = Warning::new(codes::EMPTY_SET, place, format!("\"{name}\" has no elements{there}"));
    warning.remedy("Change the expression; `usdtailor info` lists the sets of the garment")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{FoldOptions, SeamOptions};
    use tailor_mesh::garment::check_garment;
    use tailor_testing::sheets::grid;

    #[test]
    fn each_option_checks_the_kind_of_a_set_that_another_names_too() {
        let garment = check_garment(grid(2, 2, |_, _| true)).expect("a good mesh").0;
        let mut recipe = MeshRecipe::default();
        let edges = vec!["borders".to_owned()];
        recipe.seam.insert("a".into(), SeamOptions { edges: edges.clone(), ..SeamOptions::default() });
        let (sets, warnings) = RecipeSets::new(&recipe.used(), &recipe.sim.uv_set, &garment).expect("edges for a seam");
        assert_eq!((sets.sim.len(), sets.render.len(), warnings.iter().count()), (0, 1, 0));
        recipe.fold.insert("b".into(), FoldOptions { faces: edges, ..FoldOptions::default() });
        let fault =
            RecipeSets::new(&recipe.used(), &recipe.sim.uv_set, &garment).expect_err("edges for a fold").to_string();
        assert!(fault.contains("gives edges, and it takes faces"), "{fault}");
    }
}
