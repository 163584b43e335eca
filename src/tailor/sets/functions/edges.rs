//! The functions that give edges.

use crate::sets::SetFault;
use crate::sets::elements::ElementSet;
use crate::sets::evaluate::{Arguments, Evaluation};
use crate::sets::pieces::{beside, marked, oriented};
use std::collections::BTreeSet;
use tailor_mesh::connectivity::{CornerId, EdgeId, FaceId, IdVec, VertexId};
use tailor_mesh::garment::Interpolation;

type Found = Result<ElementSet, SetFault>;

/// The turn of a feature line, if none is given. \[degrees\]
const FEATURE: f64 = 45.0;

pub fn borders(of: &Evaluation<'_>, _: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let alone = |edge| if let [corner] = t.edge_corners.row(edge) { Some(beside(of.sets, *corner)) } else { None };
    Ok(ElementSet::Edges(t.edges.ids().filter_map(alone).collect()))
}

pub fn uv_seams(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    uv_seams_of(of, arguments, 0)
}

/// The seams of the UV set that an argument names, or else of that of the recipe.
pub fn uv_seams_of(of: &Evaluation<'_>, arguments: &Arguments<'_>, number: usize) -> Found {
    let t = &of.sets.topology;
    let seams = of.uv_seams(arguments, number)?;
    let cut = seams.map_or_else(BTreeSet::new, |seams| t.edges.ids().filter(|&edge| seams.is_cut(t, edge)).collect());
    Ok(oriented(t, &cut))
}

pub fn creases(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let found = creases_from(of, arguments.number(0, f64::MIN_POSITIVE)?);
    if found.is_empty() {
        let all = of.sets.garment.creases.iter().flat_map(|crease| &crease.sharpnesses);
        of.note(format!("the largest sharpness of a crease is {}", all.copied().fold(0.0, f32::max)));
    }
    Ok(found)
}

/// Creases from a sharpness on.
pub fn creases_from(of: &Evaluation<'_>, least: f64) -> ElementSet {
    let (garment, t) = (of.sets.garment, &of.sets.topology);
    let steps = garment.creases.iter().flat_map(|crease| crease.vertices.windows(2).zip(&crease.sharpnesses));
    let sharp = steps.filter(|(_, sharpness)| f64::from(**sharpness) >= least);
    oriented(t, &sharp.filter_map(|(ends, _)| t.find_edge(ends[0], ends[1])).collect())
}

pub fn feature_lines(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let (garment, t) = (of.sets.garment, &of.sets.topology);
    let least = arguments.number(0, FEATURE)?.to_radians();
    let normals: IdVec<FaceId, _> = t.faces.ids().map(|face| garment.doubled_normal(face)).collect();
    let turn = |edge: EdgeId| {
        let [a, b] = *t.edge_corners.row(edge) else { return 0.0 };
        let [n, m] = [a, b].map(|corner| normals[t.faces.face_of(corner)]);
        // Faces that disagree in winding look to two sides.
        let m = if t.faces.vertex(a) == t.faces.vertex(b) { -m } else { m };
        n.cross(m).length().atan2(n.dot(m))
    };
    let found: BTreeSet<EdgeId> = t.edges.ids().filter(|&edge| turn(edge) > least).collect();
    if found.is_empty() {
        let most = t.edges.ids().map(turn).fold(0.0, f64::max).to_degrees();
        of.note(format!("the largest turn between two faces is {most:.0} degrees"));
    }
    Ok(oriented(t, &found))
}

pub fn border(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let faces = marked(&arguments.faces(of, 0)?, t.faces.len());
    let is_in = |corner: &&CornerId| faces[t.faces.face_of(**corner)];
    let ends = |edge| {
        let around = t.edge_corners.row(edge);
        let inside = around.iter().filter(is_in).count();
        let is_border = inside == 1 || inside > 0 && inside < around.len();
        is_border.then(|| around.iter().find(is_in).map(|corner| beside(of.sets, *corner)))?
    };
    Ok(ElementSet::Edges(t.edges.ids().filter_map(ends).collect()))
}

pub fn between(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let [first, second] = [0, 1].map(|number| Ok(marked(&arguments.faces(of, number)?, t.faces.len())));
    let (first, second): (IdVec<FaceId, bool>, IdVec<FaceId, bool>) = (first?, second?);
    let ends = |edge| {
        let around = t.edge_corners.row(edge);
        let at = around.iter().find(|corner| {
            let other = |other: &CornerId| other != *corner && second[t.faces.face_of(*other)];
            first[t.faces.face_of(**corner)] && around.iter().any(other)
        })?;
        Some(beside(of.sets, *at))
    };
    Ok(ElementSet::Edges(t.edges.ids().filter_map(ends).collect()))
}

pub fn regions(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    let found = of.primvar(arguments, "the uniform primvars", |p| p.interpolation == Interpolation::Uniform)?;
    let Some(primvar) = found else { return Ok(ElementSet::Edges(Default::default())) };
    let row = |corner: &CornerId| primvar.row(t.faces.face_of(*corner).index());
    let differ = |edge: &EdgeId| match t.edge_corners.row(*edge) {
        [first, rest @ ..] => {
            rest.iter().any(|corner| !primvar.values.same_rows(primvar.width(), row(first), row(corner)))
        }
        [] => false,
    };
    Ok(oriented(t, &t.edges.ids().filter(differ).collect()))
}

pub fn edges(of: &Evaluation<'_>, arguments: &Arguments<'_>) -> Found {
    let t = &of.sets.topology;
    if !arguments.has(0) {
        return Ok(oriented(t, &t.edges.ids().collect()));
    }
    let found: BTreeSet<EdgeId> = match arguments.set(of, 0)? {
        ElementSet::Faces(faces) => {
            faces.iter().flat_map(|&face| t.faces.corners_of(face)).map(|corner| t.corner_edge[corner]).collect()
        }
        ElementSet::Points(points) => {
            let is_in = marked::<VertexId>(&points, t.vertex_count());
            t.edges.enumerated().filter(|(_, ends)| ends.iter().all(|&v| is_in[v])).map(|(edge, _)| edge).collect()
        }
        edges @ ElementSet::Edges(_) => return Ok(edges),
    };
    Ok(oriented(t, &found))
}
