//! Parts of a stage that a fit does not move with the garment.

use super::trims::FittedTrims;
use crate::names;
use crate::read::{OrUnreadable, PlacedMesh, Source, all_meshes, is_a, is_other, prim_at, transforms, value, vectors};
use glam::Vec3;
use openusd::sdf::{Path, Value};
use openusd::usd::{Prim, Stage, TimeCode};
use tailor_costume::binding::Triangles;
use tailor_mesh::error::{Error, Warning, Warnings};

/// How far from a garment a mesh that lies on it may be. \[sizes of the garment\]
const NEAR: f32 = 0.02;

/// Warns of meshes that lie on garments and are neither fitted nor trims of theirs.
pub fn left_beside<'a>(stage: &Stage, garments: &[&'a Source], trims: &FittedTrims) -> Result<Warnings, Error> {
    let fitted: Vec<&Path> =
        garments.iter().flat_map(|source| &source.model.panels).chain(trims.keys().copied()).collect();
    let cloth = |source: &&'a Source| {
        let (garment, of_fit) = (source.garment.as_ref().ok()?, source.fitted.as_deref()?);
        let placed = PlacedMesh::new(garment, source.model.transforms.to_world);
        Some((*source, of_fit, Triangles::new(placed.triangles()), NEAR * placed.size()))
    };
    let cloths: Vec<_> = garments.iter().filter_map(cloth).collect();
    let Some((first, of_fit, ..)) = cloths.first() else { return Ok(Warnings::default()) };
    let time = of_fit.time.map(TimeCode::new);
    let elsewhere = |path: &Path| cloths.iter().flat_map(|of| &of.1.elsewhere).any(|(root, _)| path.has_prefix(root));
    let mut warnings = Warnings::default();
    for path in all_meshes(stage, &first.model.origin.file)? {
        if fitted.iter().any(|known| path.has_prefix(known)) || elsewhere(&path) || is_other(stage, &path)? {
            continue;
        }
        let prim = prim_at(stage, &path)?;
        let (to_world, points) =
            (transforms(&prim, time)?.to_world, vectors(&prim, names::POINTS, time).ok().flatten());
        let placed: Vec<Vec3> =
            points.iter().flatten().map(|p| to_world.transform_point3(p.as_dvec3()).as_vec3()).collect();
        let is_on = |near: f32, cloth: &Triangles| placed.iter().all(|&p| p.is_finite() && cloth.distance(p) <= near);
        let below = cloths.iter().find(|(.., cloth, near)| !placed.is_empty() && is_on(*near, cloth));
        let why = |source: &Source| format!("it lies on {}, and stays where it is", source.whole());
        let warning = below.map(|(source, ..)| Warning::not_carried(&path, why(source)));
        warnings.extend(warning.map(|w| w.remedy("Fit it too by --all, or make it a trim of the garment")));
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
        warnings.push(Warning::not_carried(place, why).remedy("Bake it into the points before the fit"));
    }
    Ok(warnings)
}
