//! The summary of a build and its warnings as text.

use super::build::{Built, Figures, Outcome, Task, level_lines};
use clap::builder::styling::AnsiColor;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tailor::SimOptions;
use tailor::report::{RenderFigures, SimFigures};
use tailor_costume::{ClothFigures, Products, Recipe, Timing};
use tailor_mesh::Units;
use tailor_mesh::error::{Error, ErrorCode, ErrorKind, Warning};
use tailor_mesh::units::in_words;

/// Longest line of a summary. \[characters\]
const WIDTH: usize = 100;

/// Sets whether messages are coloured: by default where standard error is a terminal and `NO_COLOR` is not set.
pub fn set_colors(choice: clap::ColorChoice) {
    let choice = match choice {
        clap::ColorChoice::Auto => anstream::ColorChoice::Auto,
        clap::ColorChoice::Always => anstream::ColorChoice::Always,
        clap::ColorChoice::Never => anstream::ColorChoice::Never,
    };
    choice.write_global();
}

/// A text in bold colour; the stream removes the codes where they are not wanted.
fn painted(color: AnsiColor, text: &str) -> String {
    let style = color.on_default().bold();
    format!("{style}{text}{style:#}")
}

/// How much of a warning is printed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Wording {
    /// Nothing.
    Silent,
    /// Place and problem on one line.
    Short,
    /// The remedy on a second line.
    Full,
}

/// Writes warnings to standard error, prefixed with `input` if it is one of several.
pub fn print_warnings<'a>(warnings: impl IntoIterator<Item = &'a Warning>, wording: Wording, input: Option<&PathBuf>) {
    let line = |warning: &'a Warning| {
        let headline = format!("{} ({})", warning.headline(), warning.severity);
        (warning.code.name(), headline, warning.remedy.as_str())
    };
    print_lines(warnings.into_iter().map(line), wording, input);
}

/// As [`print_warnings`], those that the record of an output has.
pub fn print_earlier<'a>(warnings: &'a [Value], wording: Wording, input: Option<&PathBuf>) {
    let line = |warning: &'a Value| {
        let [code, severity, message, remedy] =
            ["code", "severity", "message", "remedy"].map(|key| warning[key].as_str().unwrap_or_default());
        let headline = message.strip_suffix(remedy).map_or(message, |line| line.trim_end_matches(". "));
        (code, format!("{headline} ({severity})"), remedy)
    };
    print_lines(warnings.iter().map(line), wording, input);
}

/// Writes warnings to standard error: their code, headline and remedy.
fn print_lines<'a>(
    warnings: impl Iterator<Item = (&'a str, String, &'a str)>,
    wording: Wording,
    input: Option<&PathBuf>,
) {
    if wording == Wording::Silent {
        return;
    }
    let label = input.map(|i| format!("{}: ", i.display())).unwrap_or_default();
    let (mut out, mut is_cut) = (anstream::stderr(), false);
    for (code, headline, remedy) in warnings {
        let mark = painted(AnsiColor::Yellow, &format!("warning[{code}]"));
        // A closed standard error is not a failure.
        let _ = writeln!(out, "{mark}: {label}{headline}");
        if remedy.is_empty() {
            continue;
        }
        is_cut |= wording == Wording::Short;
        if wording == Wording::Full {
            let _ = writeln!(out, "  hint: {remedy}");
        }
    }
    if is_cut && input.is_none() {
        let _ = writeln!(out, "hint: -v says what to do about warnings");
    }
}

/// Writes each fault of an error to standard error, with its code. The error of one of several inputs names the input.
pub fn print_error(error: &Error, input: Option<&Path>) {
    let input = input.map(|input| input.display().to_string());
    let label = |text: &str| match &input {
        Some(input) if !text.contains(input) => format!("{input}: "),
        _ => String::new(),
    };
    let mut out = anstream::stderr();
    let mark = |code: ErrorCode| painted(AnsiColor::Red, &format!("error[{code}]"));
    if let (ErrorKind::Internal, Some(fault)) = (error.kind, error.faults.first()) {
        let _ = writeln!(out, "{}: {}{error}", mark(fault.code), label(&error.to_string()));
        return;
    }
    for fault in &error.faults {
        let _ = writeln!(out, "{}: {}{fault}", mark(fault.code), label(&fault.to_string()));
    }
    if error.more > 0 {
        let _ = writeln!(out, "and {} more", error.more);
    }
}

/// The results of the inputs: the summary of one, or a table of several.
pub fn outcomes(tasks: &[Task], outcomes: &[Outcome]) -> String {
    let summaries =
        outcomes.iter().filter_map(|o| if let Outcome::Built(s) = o { Some(s.text.as_str()) } else { None });
    match (tasks, outcomes) {
        _ if outcomes.iter().any(|outcome| planned(outcome).is_some()) => outcomes.iter().filter_map(planned).collect(),
        ([task], [Outcome::Fresh(_)]) => format!("{}: fresh\n", task.output.display()),
        ([_], _) => summaries.collect(),
        _ => summaries.collect::<String>() + &table(tasks, outcomes),
    }
}

fn planned(outcome: &Outcome) -> Option<&str> {
    if let Outcome::Planned { text, .. } = outcome { Some(text) } else { None }
}

/// A line for each input, and their numbers.
fn table(tasks: &[Task], outcomes: &[Outcome]) -> String {
    let names: Vec<String> = tasks.iter().map(|task| task.input.display().to_string()).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let mut t = format!(
        "{:width$}  result  {:>9}  {:>9}  {:>8}  faults  quality  notes\n",
        "input", "triangles", "faces", "seconds"
    );
    let mut counts = [0; 3];
    for (name, outcome) in names.iter().zip(outcomes) {
        let (at, row) = match outcome {
            Outcome::Built(s) => {
                let [sim, render] = s.faces;
                let warnings = in_columns(s.warnings.iter().map(|warning| warning.severity.to_string()));
                (0, format!("built   {sim:>9}  {render:>9}  {:>8.2}{warnings}", s.seconds))
            }
            Outcome::Fresh(warnings) => {
                let of = |warning: &Value| warning["severity"].as_str().unwrap_or_default().to_owned();
                (1, format!("fresh   {:30}{}", "", in_columns(warnings.iter().map(of))))
            }
            Outcome::Failed(_) => (2, "failed".to_owned()),
            Outcome::Planned { .. } => continue,
        };
        counts[at] += 1;
        // Writing to a string cannot fail.
        let _ = writeln!(t, "{name:width$}  {row}");
    }
    let [built, fresh, failed] = counts;
    let _ = writeln!(t, "{} inputs: {built} built, {fresh} fresh, {failed} failed", tasks.len());
    t
}

/// The numbers of warnings of each severity, as columns of the table.
fn in_columns(severities: impl Iterator<Item = String>) -> String {
    let mut counts = BTreeMap::new();
    severities.for_each(|severity| *counts.entry(severity).or_insert(0) += 1);
    let count = |severity| counts.get(severity).copied().unwrap_or(0);
    format!("  {:>6}  {:>7}  {:>5}", count("fault"), count("quality"), count("note"))
}

/// The summary of each garment of an input, at most one screen. Several are distinguished by their paths.
pub fn summaries(task: &Task, garments: &[Built], figures: &[Figures], verbose: bool) -> String {
    let input = task.input.display();
    let name = |built: &Built| match &built.variant {
        Some(variant) => format!("{input} {} {}={}", built.prim, variant.set, variant.choice),
        None if garments.len() > 1 => format!("{input} {}", built.prim),
        None => input.to_string(),
    };
    let output = task.output.display();
    let one = |(built, of): (&Built, &Figures)| format!("{} -> {output}\n{}", name(built), summary(built, of, verbose));
    garments.iter().zip(figures).map(one).collect()
}

fn summary(built: &Built, Figures { sim: s, render: r, cloth: of_cloth }: &Figures, verbose: bool) -> String {
    let (products, recipe) = (&built.products, &built.products.recipe);
    let percent = |share: f32| f64::from(share) * 100.0;
    let mut t = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(t, "  sim     {} vertices, {} triangles", s.vertices, s.faces);
    let _ = writeln!(
        t,
        "          target length {}, off by {:.1} % (RMS), {:.1} % of edges within 4/5 to 4/3",
        target_length(recipe, products.sim.units),
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
    if !recipe.sim.uv_set.is_empty() && recipe.sim.uv_set != SimOptions::default().uv_set {
        let _ = writeln!(t, "          seams of the UV set {}", recipe.sim.uv_set);
    }
    let _ = writeln!(
        t,
        "          distance to the surface at most {:.2}, on average {:.3} of the target length",
        s.distance_max, s.distance_mean
    );
    t += &features(s);
    t += &r.as_ref().map(|r| render(built, r)).unwrap_or_default();
    t += &level_lines(built);
    if let Some(figures) = of_cloth {
        t += &cloth(figures, s.short_edges.len());
    }
    for trim in &built.trims {
        let _ = writeln!(t, "  trim    {}: {}", trim.prim, trim.ride.in_words());
    }
    t += &times(&built.timings);
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
        for cost in &s.constraint_costs {
            let _ = writeln!(
                t,
                "  beside  {}: {} of {} triangles have an angle under 30 degrees",
                cost.constraint, cost.thin, cost.triangles
            );
        }
        for area in &s.subset_areas {
            let _ = writeln!(t, "  set     {}: area {:.3} of {:.3}", area.name, area.area, area.source_area);
        }
        for file in &built.packed {
            let _ = writeln!(t, "  packed  {}", file.display());
        }
        let _ = writeln!(t, "  recipe  {}", serde_json::to_string(recipe).unwrap_or_default());
    }
    t
}

/// The lines about a render mesh.
fn render(built: &Built, r: &RenderFigures) -> String {
    let (level, quads) = (built.products.recipe.render.level, 100.0 * f64::from(r.quads));
    let mut t = format!("  render  {} vertices, {} faces, {quads:.1} % quads, level {level}\n", r.vertices, r.faces);
    for (name, panel) in built.names.render.iter().zip(built.panels.iter().flatten()) {
        let (vertices, faces) = (panel.mesh.points.len(), panel.mesh.faces.len());
        let _ = writeln!(t, "          {name}: {vertices} vertices, {faces} faces");
    }
    let operators = &built.products.operators;
    if !operators.is_empty() {
        let s = if operators.len() == 1 { "" } else { "s" };
        let _ = writeln!(t, "          {} operator{s}: {}", operators.len(), operators.join(", "));
    }
    t
}

/// The line about edges without a feature line of their own and triangles that face away from the surface, if there are some.
fn features(s: &SimFigures) -> String {
    let mut parts = Vec::new();
    if !s.narrow_features.is_empty() {
        let width = s.narrow_features.iter().map(|feature| feature.width).fold(0.0, f32::max);
        let count = s.narrow_features.len();
        parts.push(format!(
            "narrow features drawn to edges beside them: {count}, over at most {width:.2} of the target length"
        ));
    }
    if !s.blunt_ridges.is_empty() {
        let length: f32 = s.blunt_ridges.iter().map(|ridge| ridge.length).sum();
        let count = s.blunt_ridges.len();
        parts.push(format!(
            "ridges nearly as sharp as sim.featureAngle, which triangles may cut off: {count}, of {length:.0} target lengths"
        ));
    }
    if s.facing_away > 0 {
        parts.push(format!("triangles that face away from the surface: {}", s.facing_away));
    }
    if parts.is_empty() { String::new() } else { format!("          {}\n", parts.join("; ")) }
}

/// The target lengths in mesh units and in the world.
pub fn target_length(recipe: &Recipe, units: Units) -> String {
    let (min, max) = (recipe.sim.min_edge_length, recipe.sim.max_edge_length);
    let in_world = |length: f32| in_words(f64::from(length) * units.meters());
    if min == max {
        return format!("{max:.4} mesh units ({})", in_world(max));
    }
    format!("{min:.4} to {max:.4} mesh units ({} to {})", in_world(min), in_world(max))
}

/// The line about times, broken where it is long.
fn times(stages: &[Timing]) -> String {
    let mut t = "  time   ".to_owned();
    let mut width = t.len();
    for stage in stages {
        let one = format!(" {} {:.0} ms", stage.name, stage.seconds * 1e3);
        if width + one.len() > WIDTH {
            t += "\n         ";
            width = 9;
        }
        width += one.len();
        t += &one;
    }
    t.push('\n');
    t
}

/// The lines about the cloth; `short` edges of it are short.
fn cloth(figures: &ClothFigures, short: usize) -> String {
    let mut t = String::new();
    let grams = 1e3 * figures.mass;
    let _ = write!(t, "  cloth   {}: {grams:.0} g, {:.3} m2", figures.fabrics.join(", "), figures.area);
    for (count, what) in [(figures.pinned, "pinned vertices"), (figures.attached, "attached pieces")] {
        if count > 0 {
            let _ = write!(t, ", {count} {what}");
        }
    }
    let (edge, step) = (1e3 * figures.shortest_edge, 1e6 * figures.critical_time_step);
    let _ = write!(t, "\n          shortest edge {edge:.2} mm");
    if short > 0 {
        let _ = write!(t, " ({short} are under a fifth of their target)");
    }
    let _ = writeln!(t, "; time step of an explicit solver under {step:.1} µs");
    match &figures.rest {
        None => t += "          rests as modelled\n",
        Some(rest) => {
            let percent = 100.0 * rest.stretch_rms;
            let _ = write!(t, "          rests as {} flat panels, stretched by {percent:.2} % (RMS)", rest.panels);
            let _ = match rest.modelled {
                0 => writeln!(t),
                shells => writeln!(t, "; {shells} shells as modelled"),
            };
        }
    }
    t
}

/// The face sets that operators add, with their sizes; empty without `render.faceSets`.
pub fn operator_sets(products: &Products) -> Vec<(String, usize)> {
    let size = |name: &String| Some((name.clone(), products.render.subset(name)?.elements.len()));
    products.operator_sets.iter().filter_map(size).collect()
}
