//! Checks of the attributes of products: subsets, families and primvars.

use std::collections::BTreeSet;
use tailor_mesh::connectivity::Topology;
use tailor_mesh::garment::{Elements, FamilyType, Interpolation, Mesh, Mixing, Subset, Values};

/// Joint weights sum to what they were except for this.
pub const WEIGHT_SUM: f64 = 1e-4;

/// Subsets whose elements are not there, or there twice.
pub fn subset_faults(mesh: &Mesh, t: &Topology) -> Vec<String> {
    let mut faults = Vec::new();
    for subset in mesh.subsets.iter() {
        let (sound, distinct) = match &subset.elements {
            Elements::Faces(f) => {
                (f.iter().all(|f| f.index() < mesh.faces.len()), f.iter().collect::<BTreeSet<_>>().len())
            }
            Elements::Points(p) => {
                (p.iter().all(|p| p.index() < mesh.points.len()), p.iter().collect::<BTreeSet<_>>().len())
            }
            Elements::Edges(e) => (
                e.iter().all(|&[a, b]| t.find_edge(a, b).is_some()),
                e.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect::<BTreeSet<_>>().len(),
            ),
        };
        if !sound {
            faults.push(format!("{} has an element that the mesh has not", subset.name));
        }
        if distinct != subset.elements.len() {
            faults.push(format!("{} has an element twice", subset.name));
        }
    }
    faults
}

/// Families of faces that break their rule.
pub fn family_faults(mesh: &Mesh) -> Vec<String> {
    let mut faults = Vec::new();
    for family in mesh.families.iter().filter(|f| f.kind != FamilyType::Unrestricted) {
        let of_faces = |s: &&Subset| s.family == family.name && s.elements.kind() == "face";
        let mut uses = vec![0usize; mesh.faces.len()];
        let mut members = 0;
        for subset in mesh.subsets.iter().filter(of_faces) {
            members += 1;
            if let Elements::Faces(faces) = &subset.elements {
                faces.iter().for_each(|f| uses[f.index()] += 1);
            }
        }
        if let Some(face) = uses.iter().position(|&n| n > 1) {
            faults.push(format!("face {face} is in {} subsets of {}", uses[face], family.name));
        }
        if family.kind == FamilyType::Partition
            && members > 0
            && let Some(face) = uses.iter().position(|&n| n == 0)
        {
            faults.push(format!("face {face} is in no subset of the partition {}", family.name));
        }
    }
    faults
}

fn numbers(values: &Values) -> Option<Vec<f64>> {
    match values {
        Values::F32(v) => Some(v.iter().map(|&x| x.into()).collect()),
        Values::F64(v) => Some(v.clone()),
        _ => None,
    }
}

/// Primvars that do not fit the mesh, leave the range of their source, or weights with another sum.
pub fn primvar_faults(mesh: &Mesh, source: &Mesh) -> Vec<String> {
    let mut faults = Vec::new();
    for p in mesh.primvars.iter() {
        let elements = match p.interpolation {
            Interpolation::Constant => p.elements(),
            Interpolation::Uniform => mesh.faces.len(),
            Interpolation::Vertex | Interpolation::Varying => mesh.points.len(),
            Interpolation::FaceVarying => mesh.faces.corners().len(),
        };
        if p.elements() != elements {
            faults.push(format!("{} has {} elements instead of {elements}", p.name, p.elements()));
        }
        if p.indices.as_ref().is_some_and(|i| i.iter().any(|&i| i as usize >= p.rows())) {
            faults.push(format!("{} has an index without a value", p.name));
        }
        let Some(from) = source.primvar(&p.name) else {
            faults.push(format!("{} came from nowhere", p.name));
            continue;
        };
        if (p.width(), p.interpolation) != (from.width(), from.interpolation) {
            faults.push(format!("{} has another shape than its source", p.name));
        }
        let (Some(own), Some(given)) = (numbers(&p.values), numbers(&from.values)) else { continue };
        if own.iter().any(|x| !x.is_finite()) {
            faults.push(format!("{} is not finite", p.name));
        }
        let width = p.width().max(1);
        let is_vertex = matches!(p.interpolation, Interpolation::Vertex | Interpolation::Varying);
        if is_vertex && p.mixing() == Mixing::Linear && !p.name.starts_with("skel:") {
            for k in 0..width {
                let of = |v: &[f64]| {
                    let each = v.iter().skip(k).step_by(width);
                    (each.clone().copied().fold(f64::MAX, f64::min), each.copied().fold(f64::MIN, f64::max))
                };
                let ((low, high), (least, most)) = (of(&own), of(&given));
                let slack = 1e-5 * (most - least).max(most.abs()).max(1e-6);
                if low < least - slack || high > most + slack {
                    faults.push(format!("{} is in {low}..{high}, its source in {least}..{most}", p.name));
                }
            }
        }
        if p.name == "skel:jointWeights" {
            let sums = |v: &[f64]| v.chunks(width).map(|w| w.iter().sum::<f64>()).collect::<Vec<_>>();
            let given = sums(&given);
            let (least, most) =
                (given.iter().copied().fold(f64::MAX, f64::min), given.iter().copied().fold(f64::MIN, f64::max));
            let fits = |s: &f64| (least - WEIGHT_SUM..=most + WEIGHT_SUM).contains(s);
            if let Some((i, sum)) = sums(&own).into_iter().enumerate().find(|(_, s)| !fits(s)) {
                faults.push(format!("the joint weights of point {i} sum to {sum}"));
            }
        }
    }
    faults
}
