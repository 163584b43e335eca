//! `usdtailor info` and `usdtailor check`.

mod facing;
mod json;
pub mod listed;
mod recorded;

use super::build::all_warnings;
use super::process::memory;
use super::text::Wording;
use super::variants::Opening;
use super::{DEFAULT_MAX_FACES, ExamineArgs, Output, report, text, variants};
use crate::codes;
use recorded::RecordedBuild;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use tailor::recipe::named_sets;
use tailor::sets::{ListedSet, SetEvaluator, Symmetry};
use tailor_costume::trim::Ride;
use tailor_costume::{Builder, Plan, Recipe};
use tailor_mesh::error::{Error, ErrorKind, Fault, Warnings};
use tailor_mesh::units::in_words;
use tailor_mesh::{Mesh, PrimvarRole};
use tailor_usd::session::OpenGarment;
use tailor_usd::{
    BuildRecord, Facts, ProductRole, Selection, Source, Stale, TailorPayloads, check_product_names, product_names,
    tailor_payloads, type_word,
};

/// Describes each input and the meshes that `build` would write for it.
pub fn info(args: &ExamineArgs) -> Result<Output, Error> {
    let limit = memory::hold(args.limits.max_memory);
    each(args, |file, found| {
        let mut garments = Vec::new();
        let made = RecordedBuild::of(&args.inputs, file);
        let (openings, payloads) = opened(args, file, made.as_ref(), found)?;
        for Opening { variant, garments: opened } in openings {
            for garment in opened {
                let of = Origin { file, variant: variant.as_ref(), made: made.as_ref(), payload: None };
                garments.push(describe(args, found, garment, &of, limit)?);
            }
        }
        for (prim, recipe) in &payloads {
            for garment in args.inputs.open(recipe)? {
                let of = Origin { file, variant: None, made: None, payload: Some(prim) };
                garments.push(describe(args, found, garment, &of, limit)?);
            }
        }
        found.json = if garments.len() == 1 { garments.remove(0) } else { json!({ "garments": garments }) };
        if let Some(made) = &made {
            found.json["made"] = made.json();
        }
        args.strictness.check(&found.warnings)
    })
}

/// Where a garment of an input comes from.
struct Origin<'a> {
    file: &'a Path,
    variant: Option<&'a Selection>,
    /// The build that made the input.
    made: Option<&'a RecordedBuild>,
    /// The prim whose payload it is.
    payload: Option<&'a str>,
}

/// Describes a garment in the text, and returns the same as JSON.
fn describe(
    args: &ExamineArgs,
    found: &mut Found,
    garment: OpenGarment,
    of: &Origin<'_>,
    limit: usize,
) -> Result<Value, Error> {
    let (source, builder, recipe) = garment.check()?;
    let mut builder = limited(builder, of.made, limit);
    found.warnings.extend(builder.warnings().iter().cloned());
    let plan = builder.plan(&recipe)?;
    title(&mut found.text, source.facts(), of.variant);
    if let Some(made) = of.made {
        let _ = writeln!(found.text, "  made     {}", made.in_words(of.file)?);
    }
    if let Some(prim) = of.payload {
        let _ = writeln!(found.text, "  payload  of {prim}, whose own options are not read here");
    }
    let sets = builder.listed_sets(&plan.recipe);
    describe_mesh(&mut found.text, source.facts(), &builder, &plan, &sets, args.inputs.verbose);
    panels(&mut found.text, &source);
    let trims = source.trims(&recipe.trim, builder.garment().size())?;
    for (prim, ride) in &trims {
        let _ = writeln!(found.text, "  trim     {prim}: {}", ride.in_words());
    }
    let mut described = json::garment(source.facts(), of.variant, &builder, &plan, &sets);
    let trim = |(prim, ride): &(String, Ride)| json!({ "prim": prim, "pieces": ride.pieces(), "rigid": ride.rigid() });
    described["trims"] = trims.iter().map(trim).collect();
    if let Some(prim) = of.payload {
        described["payload"] = json!(prim);
    }
    Ok(described)
}

/// The prim that has a payload, and the `.tailor` file.
type Payload = (String, PathBuf);

/// The garments of a file itself, and the prims and files of the payloads that bring others.
fn opened(
    args: &ExamineArgs,
    file: &Path,
    made: Option<&RecordedBuild>,
    found: &mut Found,
) -> Result<(Vec<Opening>, Vec<Payload>), Error> {
    let payloads = std::mem::take(&mut found.payloads.recipes);
    // A prim that is named is looked at alone.
    let payloads = if args.inputs.prim.is_some() { Vec::new() } else { payloads };
    match open(args, file, made) {
        // Its garments are those of the payloads.
        Err(error) if is_no_mesh(&error) && !payloads.is_empty() && !found.payloads.has_other_faults => {
            Ok((Vec::new(), payloads))
        }
        openings => Ok((openings?, payloads)),
    }
}

/// Opens the garments of a file; those of an output as they were built.
fn open(args: &ExamineArgs, file: &Path, made: Option<&RecordedBuild>) -> Result<Vec<Opening>, Error> {
    match made.map(|made| (made, made.variants())) {
        None => Ok(vec![Opening { variant: None, garments: args.inputs.open(file)? }]),
        Some((made, Some(set))) => variants::each(set, &made.input),
        Some((made, None)) => Ok(vec![Opening { variant: None, garments: made.input.open_all()? }]),
    }
}

/// A builder with the limits of the command and of the build that made the file.
fn limited(builder: Builder, made: Option<&RecordedBuild>, memory: usize) -> Builder {
    builder.with_max_memory(memory).with_max_faces(made.map_or(DEFAULT_MAX_FACES, RecordedBuild::max_faces))
}

/// Checks all inputs by what a build does, so that it finds what a build would. The exit code is that of the worst error.
pub fn check(args: &ExamineArgs) -> Result<Output, Error> {
    let limit = memory::hold(args.limits.max_memory);
    each(args, |file, found| {
        let (mut is_fresh, mut hint) = (true, None);
        let made = RecordedBuild::of(&args.inputs, file);
        let (openings, recipes) = opened(args, file, made.as_ref(), found)?;
        let has_own = !openings.is_empty();
        if made.is_none() {
            openings.iter().try_for_each(|opening| free_names(&opening.garments))?;
        }
        for garment in openings.into_iter().flat_map(|opening| opening.garments) {
            let (source, builder, recipe) = garment.check()?;
            let mut builder = limited(builder, made.as_ref(), limit);
            let products = builder.update(&recipe)?;
            found.warnings.extend(all_warnings(&products));
            source.trims(&products.recipe.trim, builder.garment().size())?;
            is_fresh &= fresh(&source)?;
            let sets = || builder.listed_sets(&products.recipe);
            hint = hint.or(listed::hint(builder.garment(), &products.recipe, sets));
        }
        for (_, recipe) in &recipes {
            for garment in args.inputs.open(recipe)? {
                let (_, builder, recipe) = garment.check()?;
                let products = builder.with_max_memory(limit).update(&recipe)?;
                found.warnings.extend(all_warnings(&products));
            }
        }
        is_fresh &= has_own;
        args.strictness.check(&found.warnings)?;
        if !args.inputs.quiet {
            let _ = writeln!(found.text, "{}: good{}", file.display(), if is_fresh { ", and fresh" } else { "" });
            for (prim, recipe) in &recipes {
                let recipe = recipe.display();
                let _ = writeln!(found.text, "  {prim} from {recipe}: good; options of the payload are not checked");
            }
        }
        if let Some(hint) = hint.filter(|_| !args.inputs.quiet) {
            found.text += &hint;
        }
        found.json = json!({ "fresh": is_fresh });
        Ok(())
    })
}

fn is_no_mesh(error: &Error) -> bool {
    error.faults.iter().any(|fault| fault.code == tailor_usd::codes::NO_MESH)
}

/// Refuses garments beside which other prims have the names that a build without options gives.
fn free_names(garments: &[OpenGarment]) -> Result<(), Error> {
    let sources = || garments.iter().map(|garment| &garment.source);
    let names = product_names(sources(), [ProductRole::Sim.name(), ProductRole::Render.name()]);
    sources().zip(&names).try_for_each(|(source, names)| check_product_names(source, names))
}

/// Whether the stage has products of this program, which are what a build would make again.
fn fresh(source: &Source) -> Result<bool, Error> {
    let Some(stale) = BuildRecord::stale_in_use(source)? else { return Ok(false) };
    let Some(Stale { output, changes }) = stale else { return Ok(true) };
    let fault = Error::new(ErrorKind::Usd, output.display(), format!("stale: {}", changes.join("; ")));
    Err(fault.code(codes::STALE_OUTPUT).remedy("build it again, with --force"))
}

/// The findings about an input.
#[derive(Default)]
struct Found {
    warnings: Warnings,
    /// The payloads that garments come by.
    payloads: TailorPayloads,
    text: String,
    json: Value,
}

/// Runs `work` on each input. With several inputs, a failed one is reported and the others still run.
fn each(args: &ExamineArgs, mut work: impl FnMut(&Path, &mut Found) -> Result<(), Error>) -> Result<Output, Error> {
    let inputs = &args.inputs;
    let files = inputs.files()?;
    let several = files.len() > 1;
    let (mut text, mut entries, mut code) = (String::new(), Vec::new(), 0);
    for file in files {
        // A file that cannot be searched is reported by the work.
        let payloads = tailor_payloads(&file).unwrap_or_default();
        let mut found = Found { payloads, ..Found::default() };
        found.warnings.extend(found.payloads.misplaced.iter().cloned());
        let result = work(&file, &mut found);
        // The error has those that are refused.
        let is_strict_fault = |fault: &Fault| fault.code == tailor_mesh::codes::STRICT_WARNING;
        let is_strict = result.as_ref().is_err_and(|error| error.faults.iter().any(is_strict_fault));
        let warnings = found.warnings.worst_first().into_iter();
        let warnings = warnings.filter(|warning| !is_strict || !args.strictness.refuses(warning));
        let wording = if args.json { Wording::Silent } else { inputs.wording() };
        text::print_warnings(warnings, wording, several.then_some(&file));
        if let Err(error) = &result {
            code = code.max(super::program::exit_code(error));
        }
        entries.push(json::entry(&file, found.json, &found.warnings, result.as_ref().err()));
        match result {
            Err(error) if several || args.json => text::print_error(&error, several.then_some(&file)),
            result => result?,
        }
        text += &found.text;
    }
    if args.json {
        text = report::pretty(&json!({ "inputs": entries }))?;
    }
    Ok(Output { text, code })
}

/// The line that names a garment. Writing to a string cannot fail.
fn title(out: &mut String, facts: &Facts, variant: Option<&Selection>) {
    let variant = variant.map(|variant| format!(" {}={}", variant.set, variant.choice)).unwrap_or_default();
    let _ = writeln!(out, "{} {}{variant}", facts.file, facts.prim);
}

fn describe_mesh(out: &mut String, facts: &Facts, builder: &Builder, plan: &Plan, sets: &[ListedSet], verbose: bool) {
    let garment = builder.garment();
    let _ = writeln!(out, "  stage    {} up, {} metres a unit", facts.up_axis, facts.meters_per_unit);
    let _ = writeln!(
        out,
        "  mesh     {} points, {} faces, mean edge {:.4} ({}); {}, {}",
        garment.points.len(),
        garment.faces.len(),
        builder.mean_edge_length(),
        in_words(f64::from(builder.mean_edge_length()) * garment.units.meters()),
        token(&garment.rules.scheme),
        token(&garment.orientation)
    );
    let _ = writeln!(out, "  normals  {}", facing::in_words(garment));
    let _ = writeln!(
        out,
        "  sharp    {} creases, {} corners, {} holes",
        garment.creases.len(),
        garment.corners.len(),
        garment.holes.len()
    );
    let mirror = mirror(garment).map_or_else(
        || "no plane of symmetry".to_owned(),
        |found| {
            let share = (100.0 * found.share).floor();
            format!("plane {} = {:.4}, {share} % of the faces have a twin", found.axis_name(), found.at)
        },
    );
    let _ = writeln!(out, "  mirror   {mirror}");
    let _ = writeln!(out, "  drawn    purpose {}, visibility {}", facts.purpose, facts.visibility);
    for op in &facts.transform {
        let _ = writeln!(out, "  xform    {} {}", op.name, op.value);
    }
    for p in garment.primvars.iter().filter(|p| p.role == PrimvarRole::Primvar) {
        let indexed = if p.indices.is_some() { ", indexed" } else { "" };
        let size = if p.element_size > 1 { format!(", elementSize {}", p.element_size) } else { String::new() };
        let _ = writeln!(out, "  primvar  {} {} {}{indexed}{size}", p.name, type_word(p), token(&p.interpolation));
    }
    for name in &facts.constant_primvars {
        let _ = writeln!(out, "  primvar  {name} constant");
    }
    for p in &facts.inherited_primvars {
        let _ = writeln!(out, "  primvar  {} {} from {}", p.name, p.type_name, p.from);
    }
    for s in garment.subsets.iter() {
        let family = if s.family.is_empty() { String::new() } else { format!(", family {}", s.family) };
        let _ = writeln!(out, "  subset   {} of {} {}s{family}", s.name, s.elements.len(), s.elements.kind());
    }
    out.push_str(&listed::in_words(sets));
    for b in &facts.bindings {
        let _ = writeln!(out, "  material {} on {}: {}", b.relationship, b.prim, b.targets.join(", "));
    }
    for schema in facts.api_schemas.iter().filter(|_| verbose) {
        let _ = writeln!(out, "  schema   {schema}");
    }
    for property in facts.staying.iter().filter(|_| verbose) {
        let _ = writeln!(out, "  stays    {property}");
    }
    let _ = writeln!(
        out,
        "  sim      about {} triangles at length {}, {} constraint chains",
        plan.meshes.expected_faces,
        text::target_length(&plan.recipe, garment.units),
        plan.meshes.chains
    );
    let seams = if plan.meshes.seam_level > 0 {
        format!(", seams after level {}", plan.meshes.seam_level)
    } else {
        String::new()
    };
    let _ = writeln!(out, "  render   {} faces at level {}{seams}", plan.meshes.render_faces, plan.recipe.render.level);
    for (number, level) in plan.levels.iter().enumerate() {
        let (triangles, faces, refined) =
            (level.meshes.expected_faces, level.meshes.render_faces, level.recipe.render.level);
        let _ = writeln!(out, "  LOD{}     about {triangles} triangles, {faces} faces at level {refined}", number + 1);
    }
    operators(out, garment, &plan.recipe);
    if verbose {
        let _ = writeln!(out, "  recipe   {}", serde_json::to_string(&plan.recipe).unwrap_or_default());
    }
}

/// The plane of symmetry of a garment, in the stage's directions and units.
fn mirror(garment: &Mesh) -> Option<Symmetry> {
    SetEvaluator::new(garment, "").symmetry().cloned()
}

/// The panels of a garment, and what is sewn.
fn panels(out: &mut String, source: &Source) {
    for panel in source.panels().filter(|_| source.is_sewn()) {
        let _ = writeln!(out, "  panel    {panel}");
    }
    for seam in source.seams() {
        let [a, b] = &seam.panels;
        let what = if a == b { "its own borders".to_owned() } else { format!("{a} to {b}") };
        let _ =
            writeln!(out, "  sewn     {what}: {} border edges, at most {:.2e} stage units apart", seam.edges, seam.gap);
    }
}

/// The operators of a recipe, with the sets that they work on.
fn operators(out: &mut String, garment: &Mesh, recipe: &Recipe) {
    for (name, options) in recipe.operators() {
        let sized = named_sets(options)
            .flat_map(|(_, _, sets)| sets)
            .filter_map(|set| garment.subset(set))
            .map(|set| format!("{} ({} {}s)", set.name, set.elements.len(), set.elements.kind()));
        let left_out = if options.is_enabled() { "" } else { ", left out" };
        let _ =
            writeln!(out, "  {:<8} {name}: {}{left_out}", options.group().name, sized.collect::<Vec<_>>().join(", "));
    }
}

/// The USD token of an enum variant, such as `catmullClark`.
fn token(variant: &impl std::fmt::Debug) -> String {
    let name = format!("{variant:?}");
    let mut letters = name.chars();
    letters.next().map(|first| first.to_ascii_lowercase()).into_iter().chain(letters).collect()
}
