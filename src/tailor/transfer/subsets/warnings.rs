//! Warnings of subsets that the simulation mesh cannot hold.

use crate::codes;
use crate::transfer::coverage::Coverage;
use crate::transfer::edges::CarriedEdges;
use tailor_mesh::connectivity::FaceId;
use tailor_mesh::error::{Warning, counted};
use tailor_mesh::garment::{Elements, Mesh, Subset, face_sets_warning};

/// Least agreement of a face set with its source that needs no warning.
const AGREEMENT: f64 = 0.97;

/// A warning of face sets that are too small for the triangles to follow.
pub(super) fn of_small_sets<'a>(garment: &'a Mesh, sets: &[Vec<FaceId>], coverage: &Coverage) -> Option<Warning> {
    let agreement = |(subset, set): (&'a Subset, &Vec<FaceId>)| match &subset.elements {
        // Empty sets have a warning of their own.
        Elements::Faces(source) if !set.is_empty() => Some((subset, coverage.agreement(source, set))),
        _ => None,
    };
    let found = garment.subsets.iter().zip(sets).filter_map(agreement);
    let (sets, agreements): (Vec<&Subset>, Vec<f64>) = found.filter(|(_, own)| *own < AGREEMENT).unzip();
    let least = agreements.iter().copied().reduce(f64::min)?;
    let problem = format!("they are about one triangle wide: only {:.0} % of their area is kept", 100.0 * least);
    let warning = face_sets_warning(codes::SETS_BLURRED, &sets, problem);
    Some(warning.amount(least as f32).remedy("Add their borders to sim.constraints, or lower sim.maxEdgeLength"))
}

/// A warning of a face set that is empty on the simulation mesh.
pub(super) fn of_lost_set(source: &Subset) -> Warning {
    let problem = "it is empty on the simulation mesh, as it is smaller than each triangle that it touches";
    let warning = of_subset(source, problem.into()).at(source.elements.clone());
    warning.remedy("Lower sim.maxEdgeLength, or name its border in sim.constraints")
}

/// Warnings of lost edges and merged chains of an edge set.
pub(super) fn of_edges(source: &Subset, carried: &CarriedEdges) -> Vec<Warning> {
    let CarriedEdges { lost, merged, .. } = carried;
    let remedy = "Name the set in sim.constraints, or lower sim.maxEdgeLength";
    let lost_text = format!(
        "{} of {} edges are lost: they lie between holes, or no edges of the simulation mesh are near",
        lost.len(),
        source.elements.len()
    );
    let merged_text = format!(
        "{} meet others of the set: the simulation mesh has too few vertices to keep them apart",
        counted(merged.len(), "chain", "chains")
    );
    let told = [(lost_text, lost.clone()), (merged_text, merged.concat())];
    let warnings = told.into_iter().filter(|(_, edges)| !edges.is_empty());
    warnings.map(|(text, edges)| of_subset(source, text).at(Elements::Edges(edges)).remedy(remedy)).collect()
}

fn of_subset(source: &Subset, problem: String) -> Warning {
    Warning::new(tailor_mesh::codes::NOT_CARRIED, format!("subset {}", source.name), problem)
}
