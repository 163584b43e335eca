//! The coarser levels of detail in the summary and the report of a build.

use super::{Built, unused};
use serde_json::{Value, json};
use tailor_costume::Products;
use tailor_mesh::error::{Warnings, names};
use tailor_usd::{ProductNames, warning_json};

/// The seams that are narrower than the faces of a level: those that are creases there, and those that it lacks.
struct Thin<'a> {
    creases: Vec<&'a String>,
    left_out: Vec<&'a String>,
}

impl<'a> Thin<'a> {
    fn of(first: &'a Products, level: &Products) -> Self {
        let seams = first.recipe.seam.iter().filter(|(_, seam)| seam.enabled && !seam.crease);
        let thin = seams.filter(|(name, _)| level.recipe.seam[*name].crease);
        let (creases, left_out): (Vec<_>, Vec<_>) = thin.partition(|(name, _)| level.recipe.seam[*name].enabled);
        let of = |seams: Vec<(&'a String, _)>| seams.into_iter().map(|(name, _)| name).collect();
        Self { creases: of(creases), left_out: of(left_out) }
    }
}

/// The warnings of products, with those of each coarser level.
pub fn warnings(products: &Products) -> Warnings {
    let mut all = unused::together(products);
    for (number, level) in (1..).zip(&products.levels) {
        for mut warning in unused::together(level).iter().cloned() {
            warning.problem += &format!(" at level of detail {number}");
            all.push(warning);
        }
    }
    all
}

/// A line about each coarser level.
pub fn lines(built: &Built) -> String {
    let first = &built.products;
    let line = |(level, to): (&Products, &ProductNames)| {
        let (triangles, faces) = (level.sim.faces.len(), level.render.faces.len());
        let Thin { creases, left_out } = Thin::of(first, level);
        let mut parts = vec![format!(
            "{triangles} triangles to {}, {faces} faces to {}, level {}",
            to.sim,
            to.render.join(" and "),
            level.recipe.render.level
        )];
        for (what, seams) in [("as creases", creases), ("left out", left_out)] {
            if !seams.is_empty() {
                parts.push(format!("{what}: {}", names(&seams)));
            }
        }
        format!("  level   {}\n", parts.join("; "))
    };
    first.levels.iter().zip(&built.names.levels).map(line).collect()
}

/// The coarser levels as JSON.
pub fn report(built: &Built) -> Value {
    let first = &built.products;
    let one = |(level, to): (&Products, &ProductNames)| {
        let Thin { creases, left_out } = Thin::of(first, level);
        json!({
            "names": to.all().collect::<Vec<_>>(),
            "recipe": level.recipe,
            "sim": level.sim_figures(),
            "render": level.render_figures(),
            "creases": creases,
            "leftOut": left_out,
            "warnings": level.warnings.iter().map(warning_json).collect::<Vec<_>>(),
        })
    };
    first.levels.iter().zip(&built.names.levels).map(one).collect()
}
