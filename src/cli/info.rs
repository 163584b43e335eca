//! `usdtailor info` and `usdtailor check`.

use super::{Inputs, Output, text};
use std::fmt::Write as _;
use std::io::Write as _;
use tailor::error::Error;
use tailor::garment::Garment;
use tailor::pipeline::{Plan, mean_edge_length};
use tailor::usd::Facts;

/// Prints what each input holds and what `build` would make of it.
pub fn info(inputs: &Inputs) -> Result<Output, Error> {
    let mut out = String::new();
    for file in inputs.files()? {
        let mut opened = inputs.open(&file)?;
        let prepared = opened.prepare()?;
        text::print_warnings(&opened.warnings, inputs.quiet);
        describe(&mut out, opened.source.facts(), &prepared.garment, &prepared.plan()?, inputs.verbose);
    }
    Ok(Output { text: out, code: 0 })
}

/// Checks each input; all are checked, and one fault is enough for exit code 1.
pub fn check(inputs: &Inputs) -> Result<Output, Error> {
    let mut out = String::new();
    let mut code = 0;
    for file in inputs.files()? {
        let checked = inputs.open(&file).and_then(|mut opened| opened.prepare().map(|_| opened.warnings));
        match checked {
            Ok(warnings) => {
                text::print_warnings(&warnings, inputs.quiet);
                if !inputs.quiet {
                    let _ = writeln!(out, "{}: good", file.display());
                }
            }
            Err(error) => {
                let _ = writeln!(std::io::stderr(), "error: {error}");
                code = code.max(error.exit_code());
            }
        }
    }
    Ok(Output { text: out, code })
}

fn describe(out: &mut String, facts: &Facts, garment: &Garment, plan: &Plan, verbose: bool) {
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{} {}", facts.file, facts.prim);
    let _ = writeln!(out, "  stage    {} up, {} metres a unit", facts.up_axis, facts.meters_per_unit);
    let _ = writeln!(
        out,
        "  mesh     {} points, {} faces, mean edge {:.4}; {:?}, {:?}",
        garment.points.len(),
        garment.faces.len(),
        mean_edge_length(garment),
        garment.rules.scheme,
        garment.orientation
    );
    let _ = writeln!(
        out,
        "  sharp    {} creases, {} corners, {} holes",
        garment.creases.len(),
        garment.corners.len(),
        garment.holes.len()
    );
    let _ = writeln!(out, "  drawn    purpose {}, visibility {}", facts.purpose, facts.visibility);
    for op in &facts.transform {
        let _ = writeln!(out, "  xform    {} {}", op.name, op.value);
    }
    for p in &garment.primvars {
        let indexed = if p.indices.is_some() { ", indexed" } else { "" };
        let size =
            if p.element_size > 1 { format!(", {} a {:?}", p.element_size, p.interpolation) } else { String::new() };
        let _ = writeln!(out, "  primvar  {} {} {:?}{indexed}{size}", p.name, p.type_name, p.interpolation);
    }
    for name in &facts.constant_primvars {
        let _ = writeln!(out, "  primvar  {name} Constant");
    }
    for p in &facts.inherited_primvars {
        let _ = writeln!(out, "  primvar  {} {} from {}", p.name, p.type_name, p.from);
    }
    for s in &garment.subsets {
        let family = if s.family.is_empty() { String::new() } else { format!(", family {}", s.family) };
        let _ = writeln!(out, "  subset   {} of {} {}s{family}", s.name, s.elements.len(), s.elements.kind());
    }
    for b in &facts.bindings {
        let _ = writeln!(out, "  material {} on {}: {}", b.relationship, b.prim, b.targets.join(", "));
    }
    for schema in facts.api_schemas.iter().filter(|_| verbose) {
        let _ = writeln!(out, "  schema   {schema}");
    }
    for property in facts.staying.iter().filter(|_| verbose) {
        let _ = writeln!(out, "  stays    {property}");
    }
    let sim = &plan.recipe.sim;
    let _ = writeln!(
        out,
        "  sim      about {} triangles at lengths {} to {}, {} constraint chains",
        plan.expected_faces, sim.min_edge_length, sim.max_edge_length, plan.chains
    );
    let _ = writeln!(out, "  render   {} faces at level {}", plan.render_faces, plan.recipe.render.level);
    if verbose {
        let _ = writeln!(out, "  recipe   {}", serde_json::to_string(&plan.recipe).unwrap_or_default());
    }
}
