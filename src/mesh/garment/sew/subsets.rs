//! The subsets and families of several panels.

use super::merge::{Panel, Points, differ};
use crate::error::Error;
use crate::garment::{Family, FamilyType, SubsetInput};
use std::collections::HashSet;

/// The subsets of all panels. Those of one name are one.
///
/// # Errors
/// Two of one name whose elements or families differ.
pub fn merge_subsets(panels: &[Panel], points: &Points) -> Result<Vec<SubsetInput>, Error> {
    let mut merged: Vec<(usize, SubsetInput)> = Vec::new();
    let mut first_face = 0;
    for (i, panel) in panels.iter().enumerate() {
        for subset in &panel.mesh.subsets {
            let indices = restated(subset, first_face, &points.of_panel[i]);
            match merged.iter_mut().find(|(_, known)| known.name == subset.name) {
                None => {
                    // Points of one panel that were two are one.
                    let mut first = SubsetInput { indices: Vec::new(), ..subset.clone() };
                    add(&mut first, &indices);
                    merged.push((i, first));
                }
                Some((with, known)) => {
                    check_same(known, subset, [&panels[*with], panel])?;
                    add(known, &indices);
                }
            }
        }
        first_face += panel.mesh.face_vertex_counts.len() as i32;
    }
    Ok(merged.into_iter().map(|(_, subset)| subset).collect())
}

/// The indices of a panel's subset, of elements of the garment.
fn restated(subset: &SubsetInput, first_face: i32, of_panel: &[usize]) -> Vec<i32> {
    match subset.element_type.as_str() {
        "face" => subset.indices.iter().map(|face| first_face + face).collect(),
        _ => subset.indices.iter().map(|&point| of_panel[point as usize] as i32).collect(),
    }
}

fn check_same(known: &SubsetInput, subset: &SubsetInput, panels: [&Panel; 2]) -> Result<(), Error> {
    let name = &subset.name;
    let fault = |what: &str, [a, b]: [&str; 2]| {
        let text = format!("the {what} of their subset {name} differs: {a:?} and {b:?}");
        Err(differ(panels, text).remedy("rename one of the two, or make them alike"))
    };
    if known.element_type != subset.element_type {
        return fault("elementType", [&known.element_type, &subset.element_type]);
    }
    if known.family != subset.family {
        return fault("familyName", [&known.family, &subset.family]);
    }
    Ok(())
}

/// Adds elements to a subset of the garment, except for those on a seam that it has already.
fn add(known: &mut SubsetInput, indices: &[i32]) {
    let size = if known.element_type == "edge" { 2 } else { 1 };
    let key = |element: &[i32]| {
        let mut key = element.to_vec();
        key.sort_unstable();
        key
    };
    let mut has: HashSet<Vec<i32>> = known.indices.chunks(size).map(key).collect();
    known.indices.extend(indices.chunks(size).filter(|element| has.insert(key(element))).flatten());
}

/// The families of all panels. The rule of a family is the weakest of any panel; a partition needs all panels.
pub fn merge_families(panels: &[Panel]) -> Vec<Family> {
    let mut merged: Vec<Family> = Vec::new();
    for family in panels.iter().flat_map(|panel| &panel.mesh.families) {
        if merged.iter().any(|known| known.name == family.name) {
            continue;
        }
        let of_panel = |panel: &Panel| panel.mesh.families.iter().find(|f| f.name == family.name).map(|f| f.kind);
        let kinds: Vec<Option<FamilyType>> = panels.iter().map(of_panel).collect();
        let kind = if kinds.iter().flatten().any(|kind| *kind == FamilyType::Unrestricted) {
            FamilyType::Unrestricted
        } else if kinds.iter().all(|kind| *kind == Some(FamilyType::Partition)) {
            FamilyType::Partition
        } else {
            FamilyType::NonOverlapping
        };
        merged.push(Family { name: family.name.clone(), kind });
    }
    merged
}
