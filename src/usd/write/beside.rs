//! What a fit leaves where it was.

use super::trims::FittedTrims;
use crate::names;
use crate::read::{OrUnreadable, PlacedMesh, Source, all_meshes, is_a, is_other, prim_at, transforms, value, vectors};
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage, TimeCode};
use tailor_costume::binding::Triangles;
use tailor_mesh::error::{Error, Warning, Warnings};

/// How far from a garment a mesh that lies on it may be. \[sizes of the garment\]
const NEAR: f32 = 0.02;

/// Warns of meshes that lie on garments and are neither fitted nor trims of theirs.
pub fn left_beside(stage: &Stage, garments: &[&Source], trims: &FittedTrims) -> Result<Warnings, Error> {
    let fitted: Vec<&Path> =
        garments.iter().flat_map(|source| &source.model.panels).chain(trims.keys().copied()).collect();
    let mut warnings = Warnings::default();
    for source in garments {
        let (Ok(garment), Some(of_fit)) = (&source.garment, source.fitted.as_deref()) else { continue };
        let placed = PlacedMesh::new(garment, source.model.transforms.to_world);
        let elsewhere = |path: &Path| of_fit.elsewhere.iter().any(|(root, _)| path.has_prefix(root));
        let (cloth, size) = (Triangles::new(placed.triangles()), placed.size());
        for path in all_meshes(stage, &source.model.origin.file)? {
            if fitted.iter().any(|known| path.has_prefix(known)) || elsewhere(&path) || is_other(stage, &path)? {
                continue;
            }
            let (prim, time) = (prim_at(stage, &path)?, of_fit.time.map(TimeCode::new));
            let to_world = transforms(&prim, time)?.to_world;
            let points = vectors(&prim, names::POINTS, time).ok().flatten().unwrap_or_default();
            let is_near = |p: &glam::Vec3| {
                let at = to_world.transform_point3(p.as_dvec3()).as_vec3();
                at.is_finite() && cloth.distance(at) <= NEAR * size
            };
            if !points.is_empty() && points.iter().all(is_near) {
                let why = format!("it lies on {}, and stays where it is", source.whole());
                let warning = Warning::not_carried(&path, why);
                warnings.push(warning.remedy("Fit it too by --all, or make it a trim of the garment"));
            }
        }
    }
    Ok(warnings)
}

/// Warns of blend shapes of a fitted mesh, and of a transform that is its own in the bind pose.
pub fn stale_skin(prim: &Prim, time: Option<TimeCode>) -> Result<Warnings, Error> {
    let mut shapes = prim.relationship(names::SKEL_BLEND_SHAPE_TARGETS).targets().or_unreadable(prim.path())?;
    for child in prim.children().or_unreadable(prim.path())? {
        if is_a(&child, names::BLEND_SHAPE)? && !shapes.contains(child.path()) {
            shapes.push(child.path().clone());
        }
    }
    let of_shape = |path: &Path| {
        let warning = Warning::not_carried(path, "its offsets are those of the garment before the fit");
        warning.remedy("Make the shape on the fitted garment, or fit the garment to the body of the shape")
    };
    let mut warnings: Warnings = shapes.iter().map(of_shape).collect();
    if let Ok(Some(Value::Matrix4d(bind))) = value(prim, names::GEOM_BIND_TRANSFORM, time)
        && bind.0 != glam::DMat4::IDENTITY.to_cols_array()
    {
        let place = format!("{}.{}", prim.path(), names::GEOM_BIND_TRANSFORM);
        let why = "the garment is fitted where its own transform has it, and a skeleton moves it elsewhere";
        warnings
            .push(Warning::not_carried(place, why).remedy("Apply it to the points, and take it out, before the fit"));
    }
    Ok(warnings)
}
