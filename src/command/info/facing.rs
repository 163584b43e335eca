//! Which way the normals of a garment point.

use glam::DVec3;
use tailor_mesh::{Mesh, Orientation};

/// Share of the volume between the faces and the middle of the garment that has to be on one side. A garment that wraps a body has
/// nearly all of it on one, apart from facings and folds.
const LEAST_SHARE: f64 = 0.25;
/// Volume below which a surface is flat. \[cubes of the diagonal of its box\]
const FLAT: f64 = 1e-3;

/// `outward`, `inward`, or `neither` for a sheet that is nearly flat or bends both ways.
pub fn facing(garment: &Mesh) -> &'static str {
    let (mut signed, mut all) = (0.0, 0.0);
    let [low, high] = garment.bounds().map(|p| p.as_dvec3());
    let corners = garment.faces.corners();
    let at = |v| garment.points[v].as_dvec3();
    let middle = corners.iter().map(|&v| at(v)).sum::<DVec3>() / corners.len().max(1) as f64;
    for face in garment.faces.ids().map(|face| garment.faces.vertices_of(face)) {
        for pair in face[1..].windows(2) {
            let [a, b, c] = [face[0], pair[0], pair[1]].map(|v| at(v) - middle);
            let volume = a.dot(b.cross(c)) / 6.0;
            signed += volume;
            all += volume.abs();
        }
    }
    if garment.orientation == Orientation::LeftHanded {
        signed = -signed;
    }
    let is_flat = all < FLAT * low.distance(high).powi(3);
    match signed / all {
        share if share > LEAST_SHARE && !is_flat => "outward",
        share if share < -LEAST_SHARE && !is_flat => "inward",
        _ => "neither",
    }
}

/// The facing of a garment as a sentence about its normals.
pub fn in_words(garment: &Mesh) -> &'static str {
    match facing(garment) {
        "neither" => "point neither outward nor inward: the surface is nearly flat, or bends both ways",
        "inward" => "point inward: a positive normalOffset or side \"outer\" goes inside",
        _ => "point outward",
    }
}
