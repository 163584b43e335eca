//! Figures and warnings as text.

use serde_json::Value;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tailor::error::{Error, Warning, Warnings};
use tailor::pipeline::Products;

/// Writes warnings to standard error, with the name of the input where there are several.
pub fn print_warnings(warnings: &Warnings, quiet: bool, input: Option<&PathBuf>) {
    if quiet {
        return;
    }
    let label = input.map(|i| format!("{}: ", i.display())).unwrap_or_default();
    for warning in warnings.iter() {
        // Nobody to tell if standard error is closed.
        let _ = writeln!(std::io::stderr(), "warning: {label}{warning}");
    }
}

/// Writes the error of one of several inputs to standard error, with the input's name.
pub fn print_error(error: &Error, input: &Path) {
    let (text, input) = (error.to_string(), input.display().to_string());
    let label = if text.contains(&input) { String::new() } else { format!("{input}: ") };
    let _ = writeln!(std::io::stderr(), "error: {label}{text}");
}

/// A warning with its code, its data and its text.
pub fn warning_json(warning: &Warning) -> Value {
    let mut json = serde_json::to_value(warning).unwrap_or_default();
    json["message"] = Value::String(warning.to_string());
    json
}

/// The summary of a build; one screen.
pub fn summary(input: &Path, output: &Path, products: &Products, verbose: bool) -> String {
    let (s, r, recipe) = (&products.sim_figures, &products.render_figures, &products.recipe);
    let percent = |share: f32| f64::from(share) * 100.0;
    let mut t = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(t, "{} -> {}", input.display(), output.display());
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
    for stage in &products.stages {
        let _ = write!(t, " {} {:.0} ms", stage.name, stage.seconds * 1e3);
    }
    let _ = writeln!(t);
    if verbose {
        let m = &products.remesh;
        let _ = writeln!(
            t,
            "  rounds  {} with {} splits, {} collapses, {} flips",
            m.rounds, m.splits, m.collapses, m.flips
        );
        for (name, faces) in made(products) {
            let _ = writeln!(t, "  made    {name}: {faces} faces");
        }
        for area in &s.subset_areas {
            let _ = writeln!(t, "  set     {}: area {:.3} of {:.3}", area.name, area.area, area.source_area);
        }
        let _ = writeln!(t, "  recipe  {}", serde_json::to_string(recipe).unwrap_or_default());
    }
    t
}

/// The face sets of what operators made, with their sizes; none unless `render.faceSets` asks for them.
pub fn made(products: &Products) -> Vec<(String, usize)> {
    let size = |name: &String| Some((name.clone(), products.render.subset(name)?.elements.len()));
    products.operator_sets.iter().filter_map(size).collect()
}
