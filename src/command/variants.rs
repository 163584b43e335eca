//! `--variants`: a garment for each variant of a set, in one output.

use super::{Build, usage};
use std::path::Path;
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::options::did_you_mean;
use tailor_usd::session::{Input, OpenGarment};
use tailor_usd::{Selection, Source};

/// The garments of an input, and the variant that they were read with.
pub struct Opening {
    pub variant: Option<Selection>,
    pub garments: Vec<OpenGarment>,
}

/// Opens the garments of an input: as they are selected, or once for each variant of the set that `--variants` names.
pub fn open(build: &Build, file: &Path) -> Result<Vec<Opening>, Error> {
    let input = build.inputs.input(file);
    let Some(set) = &build.variants else {
        return Ok(vec![Opening { variant: None, garments: input.open_all()? }]);
    };
    if build.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("usdz")) {
        return Err(usage(
            format!("-o {}", build.output.display()),
            "a package is flattened, and has no variants then",
        )
        .code(tailor_usd::codes::OUTPUT_PATH)
        .remedy("write .usda or .usdc with --variants"));
    }
    let openings = each(set, &input)?;
    for Opening { variant, garments } in &openings {
        if let Some(variant) = variant {
            let flag = format!("--variants {}", variant.set);
            garments.iter().try_for_each(|garment| refuse_products(&garment.source, &flag, &variant.choice))?;
        }
    }
    Ok(openings)
}

/// Opens the garments of an input once for each variant of a set.
pub fn each(set: &str, input: &Input) -> Result<Vec<Opening>, Error> {
    let open_one = |variant: Selection| -> Result<Opening, Error> {
        let mut input = input.clone();
        input.read.variants.push(variant.clone());
        Ok(Opening { garments: input.open_all()?, variant: Some(variant) })
    };
    let selected = match input.open_all() {
        // The stage may select a variant without the mesh.
        Err(error) if is_without_mesh(&error) => {
            let all = input.variants(set)?;
            all.into_iter().find_map(|variant| open_one(variant).ok()).ok_or(error)?.garments
        }
        selected => selected?,
    };
    let mut openings: Vec<Opening> = Vec::new();
    let mut without = Warnings::default();
    for variant in choices(set, &selected)? {
        let Selection { prim, set, choice } = variant.clone();
        match open_one(variant) {
            Ok(opening) => openings.push(opening),
            Err(error) if is_without_mesh(&error) => {
                without
                    .push(Warning::not_carried(format!("{prim}{{{set}={choice}}}"), "it has no mesh, so no products"));
            }
            Err(error) => return Err(error),
        }
    }
    if let Some(garment) = openings.first_mut().and_then(|opening| opening.garments.first_mut()) {
        garment.warnings.extend(without);
    }
    Ok(openings)
}

/// Whether a variant has no mesh, or not the one that is named.
fn is_without_mesh(error: &Error) -> bool {
    error.faults.iter().all(|fault| [tailor_usd::codes::NO_MESH, tailor_mesh::codes::WRONG_PRIM].contains(&fault.code))
}

/// Each variant of a set on a prim that has all garments below it.
fn choices(set: &str, garments: &[OpenGarment]) -> Result<Vec<Selection>, Error> {
    let sets = garments.first().map_or(&[][..], |garment| &garment.source.facts().variants);
    let prim = garments.first().map(|garment| garment.source.prim()).unwrap_or_default();
    let known: Vec<&str> = sets.iter().map(|set| set.selected.set.as_str()).collect();
    let fault = |text: String| usage(format!("--variants {set}"), text).code(tailor_mesh::codes::COMMAND_LINE);
    let Some(found) = sets.iter().find(|known| known.selected.set == set) else {
        let remedy = match known[..] {
            [] => "build without --variants".to_owned(),
            _ => format!("{}the variant sets are: {}", did_you_mean(set, &known), known.join(", ")),
        };
        return Err(fault(format!("{prim} and the prims above it have no variant set of this name")).remedy(remedy));
    };
    let owner = &found.selected.prim;
    let is_above = |garment: &OpenGarment| garment.source.prim().starts_with(&format!("{owner}/"));
    if !garments.iter().all(is_above) {
        return Err(fault(format!("the variant set is on {owner}, and the meshes are written beside it"))
            .remedy("move the variant set to the prim above, such as the asset's root"));
    }
    let choice = |choice: &String| Selection { choice: choice.clone(), ..found.selected.clone() };
    Ok(found.choices.iter().map(choice).collect())
}

/// Products that the input has outside of variants would hide those inside them.
///
/// # Errors
/// Such products.
pub fn refuse_products(source: &Source, flag: impl std::fmt::Display, variants: &str) -> Result<(), Error> {
    if !source.has_products() {
        return Ok(());
    }
    let text = format!("{} has products already, which would hide those of {variants}", source.prim());
    Err(usage(flag, text)
        .code(tailor_costume::codes::NAME_TAKEN)
        .remedy("name the garment that they were made from as the input"))
}
