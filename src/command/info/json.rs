//! The findings of `info` and `check` as JSON.

use super::super::report;
use super::token;
use serde_json::{Value, json};
use std::path::Path;
use tailor::sets::ListedSet;
use tailor_costume::{Builder, Plan};
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::{Mesh, PrimvarRole};
use tailor_usd::{Facts, Selection, type_word};

/// The entry of an input: what was `found`, its warnings, and its error if it has one.
pub fn entry(file: &Path, found: Value, warnings: &Warnings, error: Option<&Error>) -> Value {
    let mut entry = json!({
        "input": file.display().to_string(),
        "warnings": warnings.iter().map(tailor_usd::warning_json).collect::<Vec<_>>(),
    });
    if let Some(error) = error {
        entry["error"] = report::error_json(error);
    }
    if let (Value::Object(entry), Value::Object(found)) = (&mut entry, found) {
        entry.extend(found);
    }
    entry
}

/// A garment and the meshes that a build would write for it.
pub fn garment(
    facts: &Facts,
    variant: Option<&Selection>,
    builder: &Builder,
    plan: &Plan,
    sets: &[ListedSet],
) -> Value {
    let garment = builder.garment();
    let mut described = json!({
        "facts": facts,
        "mesh": {
            "points": garment.points.len(),
            "faces": garment.faces.len(),
            "meanEdge": builder.mean_edge_length(),
            "metersPerUnit": garment.units.meters(),
            "scheme": token(&garment.rules.scheme),
            "orientation": token(&garment.orientation),
            "normals": super::facing::facing(garment),
            "mirror": super::mirror(garment).map(|found| json!({ "axis": found.axis_name(), "at": found.at, "share": found.share })),
            "creases": garment.creases.len(),
            "corners": garment.corners.len(),
            "holes": garment.holes.len(),
        },
        "primvars": primvars(garment),
        "subsets": subsets(garment),
        "sets": sets,
        "sim": { "triangles": plan.meshes.expected_faces, "chains": plan.meshes.chains },
        "render": { "faces": plan.meshes.render_faces, "seamLevel": plan.meshes.seam_level },
        "recipe": plan.recipe,
    });
    if !plan.levels.is_empty() {
        let level =
            |level: &Plan| json!({ "triangles": level.meshes.expected_faces, "faces": level.meshes.render_faces });
        described["levels"] = plan.levels.iter().map(level).collect();
    }
    if let Some(variant) = variant {
        described["variant"] = json!(variant);
    }
    described
}

fn primvars(garment: &Mesh) -> Vec<Value> {
    let all = garment.primvars.iter().filter(|p| p.role == PrimvarRole::Primvar);
    all.map(|p| {
        json!({
            "name": p.name,
            "type": type_word(p),
            "interpolation": token(&p.interpolation),
            "elementSize": p.element_size,
            "indexed": p.indices.is_some(),
        })
    })
    .collect()
}

fn subsets(garment: &Mesh) -> Vec<Value> {
    let all = garment.subsets.iter();
    all.map(|s| json!({ "name": s.name, "elements": s.elements.kind(), "size": s.elements.len(), "family": s.family }))
        .collect()
}
