//! The summary of a build and its warnings as text.

use super::build::Built;
use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tailor::Products;
use tailor::error::{Error, Warning};

/// Writes warnings to standard error, prefixed with `input` if given.
pub fn print_warnings<'a>(warnings: impl IntoIterator<Item = &'a Warning>, quiet: bool, input: Option<&PathBuf>) {
    if quiet {
        return;
    }
    let label = input.map(|i| format!("{}: ", i.display())).unwrap_or_default();
    for warning in warnings {
        // A closed standard error is no failure.
        let _ = writeln!(std::io::stderr(), "warning: {label}{warning}");
    }
}

/// Writes the error of one of several inputs to standard error, naming the input once.
pub fn print_error(error: &Error, input: &Path) {
    let (text, input) = (error.to_string(), input.display().to_string());
    let label = if text.contains(&input) { String::new() } else { format!("{input}: ") };
    let _ = writeln!(std::io::stderr(), "error: {label}{text}");
}

/// A warning as JSON: its code, data and text.
pub fn warning_json(warning: &Warning) -> Value {
    let mut json = serde_json::to_value(warning).unwrap_or_default();
    json["message"] = Value::String(warning.to_string());
    json
}

/// The summary of a build, at most one screen.
pub fn summary(built: &Built, verbose: bool) -> String {
    let Built { products, figures, .. } = built;
    let (s, r, recipe) = (&figures.sim, &figures.render, &products.recipe);
    let percent = |share: f32| f64::from(share) * 100.0;
    let mut t = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(t, "{} -> {}", built.input.display(), built.output.display());
    let _ = writeln!(t, "  sim     {} vertices, {} triangles", s.vertices, s.faces);
    let _ = writeln!(
        t,
        "          target length {:.4} to {:.4} stage units, off by {:.1} % (RMS), {:.1} % of edges within 4/5 to 4/3",
        recipe.sim.min_edge_length,
        recipe.sim.max_edge_length,
        percent(s.length_error_rms),
        percent(s.lengths_in_band)
    );
    let _ = writeln!(
        t,
        "          angles: smallest {:.1}, 5th percentile {:.1} degrees; {:.2} % of triangles under 30",
        s.min_angle,
        s.min_angle_p5,
        percent(s.share_under30)
    );
    let _ = writeln!(
        t,
        "          valence 6 at {:.1} % of inner vertices; {:.2} % of edges not Delaunay; {} UV flips",
        percent(s.valence6),
        percent(s.non_delaunay),
        s.uv_flips
    );
    let _ = writeln!(
        t,
        "          distance to the surface at most {:.2}, on average {:.3} of the target length",
        s.distance_max, s.distance_mean
    );
    let _ = writeln!(
        t,
        "  render  {} vertices, {} faces, {:.1} % quads, level {}",
        r.vertices,
        r.faces,
        percent(r.quads),
        recipe.render.level
    );
    let operators = &products.operators;
    if !operators.is_empty() {
        let _ = writeln!(t, "          {} operators: {}", operators.len(), operators.join(", "));
    }
    let _ = write!(t, "  time   ");
    for stage in &built.timings {
        let _ = write!(t, " {} {:.0} ms", stage.name, stage.seconds * 1e3);
    }
    let _ = writeln!(t);
    if verbose {
        let m = products.remesh();
        let _ = writeln!(
            t,
            "  rounds  {} with {} splits, {} collapses, {} flips",
            m.rounds, m.splits, m.collapses, m.flips
        );
        for (name, faces) in operator_sets(products) {
            let _ = writeln!(t, "  new set {name}: {faces} faces");
        }
        for area in &s.subset_areas {
            let _ = writeln!(t, "  set     {}: area {:.3} of {:.3}", area.name, area.area, area.source_area);
        }
        let _ = writeln!(t, "  recipe  {}", serde_json::to_string(recipe).unwrap_or_default());
    }
    t
}

/// The face sets that operators add, with their sizes; empty without `render.faceSets`.
pub fn operator_sets(products: &Products) -> Vec<(String, usize)> {
    let size = |name: &String| Some((name.clone(), products.render.subset(name)?.elements.len()));
    products.operator_sets.iter().filter_map(size).collect()
}
