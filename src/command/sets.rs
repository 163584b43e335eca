//! `usdtailor sets`.

use super::info::listed;
use super::{Inputs, Output, report, usage};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Subset;
use tailor_usd::write_sets;

/// The sets of a garment.
#[derive(Args)]
pub struct SetsCommand {
    #[command(flatten)]
    inputs: Inputs,
    /// A set of this name and expression, such as hem='rings(borders.lowest, 2)'; repeatable. Without one, all sets are listed
    #[arg(long = "bake", value_name = "NAME=EXPRESSION", help_heading = "Output")]
    bake: Vec<String>,
    /// Layer over the input to write the sets to, as subsets of the mesh (.usd, .usda or .usdc)
    #[arg(short, long, value_name = "OUT", help_heading = "Output", requires = "bake")]
    output: Option<PathBuf>,
    /// Overwrite an existing output; the input is never overwritten
    #[arg(long, help_heading = "Output")]
    force: bool,
    /// Print JSON instead of text, with the indices of the elements
    #[arg(long, help_heading = "Output")]
    json: bool,
}

impl SetsCommand {
    /// The number of threads.
    pub fn threads(&self) -> Option<usize> {
        self.inputs.threads
    }
}

/// Lists the sets of a garment, or evaluates and writes some of them.
pub fn run(command: &SetsCommand) -> Result<Output, Error> {
    let [file] = &command.inputs.files()?[..] else {
        let fault = usage("sets", "several inputs are given, and this command takes one garment")
            .code(tailor_mesh::codes::COMMAND_LINE);
        return Err(fault.remedy("name one input"));
    };
    let (source, builder, recipe) = command.inputs.input(file).open_one()?.check()?;
    let recipe = builder.resolve(&recipe)?;
    if command.bake.is_empty() {
        let sets = builder.listed_sets(&recipe);
        if !command.json {
            return Ok(Output { text: listed::in_words(&sets), code: 0 });
        }
        let mut all = Vec::with_capacity(sets.len());
        for set in sets {
            let mut entry = json!(set);
            entry["indices"] = json!(builder.face_numbers().in_file(set.elements).indices());
            all.push(entry);
        }
        return Ok(Output { text: report::pretty(&json!({ "prim": source.prim(), "sets": all }))?, code: 0 });
    }
    let mut sets: Vec<Subset> = Vec::with_capacity(command.bake.len());
    let (mut entries, mut text) = (Vec::new(), String::new());
    for assignment in &command.bake {
        let Some((name, expression)) = assignment.split_once('=') else {
            let fault =
                usage(format!("--bake {assignment}"), "it has no expression").code(tailor_mesh::codes::COMMAND_LINE);
            return Err(fault.remedy("write --bake hem='rings(borders.lowest, 2)'"));
        };
        let place = format!("--bake {name}");
        if sets.iter().any(|set| set.name == name) {
            return Err(usage(place, "the name is given twice")
                .code(tailor_costume::codes::NAME_TAKEN)
                .remedy("give each a name"));
        }
        let derived = builder.derived_set(&recipe, &place, expression)?;
        let elements = derived.elements;
        if elements.is_empty() {
            let fault =
                Error::recipe(place, format!("\"{expression}\" has no elements")).code(tailor::codes::SET_EXPRESSION);
            let notes = derived.notes.join("; ");
            let remedy = if notes.is_empty() { "`usdtailor sets` lists those that it has".to_owned() } else { notes };
            return Err(fault.remedy(format!("change the expression: {remedy}")));
        }
        text += &format!("{name}: {} {}s\n", elements.len(), elements.kind());
        entries.push(json!({ "name": name, "expression": expression, "elementType": elements.kind(), "indices": builder.face_numbers().in_file(elements.clone()).indices() }));
        sets.push(Subset { name: name.to_owned(), family: String::new(), elements, sharpness: None });
    }
    if let Some(output) = &command.output {
        write_sets(&source, sets, output, command.force)?;
    }
    if command.json {
        text = report::pretty(&json!({ "prim": source.prim(), "sets": entries }))?;
    }
    Ok(Output { text, code: 0 })
}
