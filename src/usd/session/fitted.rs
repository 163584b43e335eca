//! A garment that follows the body that its recipe names.

use crate::{ReadOptions, Source, body_of};
use glam::Vec3;
use std::path::Path;
use tailor_costume::fit::{Bodies, BodyOptions, FitOptions, FitStep, Fitted, fit};
use tailor_costume::pipeline::Builder;
use tailor_costume::recipe::Recipe;
use tailor_mesh::error::{Error, Warnings};
use tailor_mesh::garment::{Elements, FIT_FROM, Garment, Interpolation, Mesh, PrimvarInput, Values};

/// The way of a garment from one body to another.
#[derive(Clone, Debug)]
pub struct FitWay {
    steps: Vec<FitStep>,
    bodies: Bodies,
    /// The body that it fits.
    to: Mesh,
}

impl FitWay {
    /// The points of the garment and the body after a share of the way.
    pub fn at(&self, share: f64) -> (Vec<Vec3>, Mesh) {
        let body = self.bodies.shape_at(share).into_iter().collect();
        let next = self.steps.partition_point(|step| step.share < share).min(self.steps.len() - 1);
        let (before, after) = (&self.steps[next.saturating_sub(1)], &self.steps[next]);
        let along = ((share - before.share) / (after.share - before.share).max(f64::EPSILON)).clamp(0.0, 1.0) as f32;
        let points = before.points.iter().zip(&after.points).map(|(a, b)| a.lerp(*b, along)).collect();
        (points, Mesh { points: body, ..self.to.clone() })
    }
}

/// Moves a garment and its trims to the body that its recipe names, and notes their points in the source, for the layer of its
/// products. A recipe without a body moves nothing.
///
/// # Errors
/// A body that cannot be read or does not correspond to the other; sets that the garment lacks; trims that are not there.
pub fn follow_body(
    source: &mut Source,
    mesh: &mut Garment,
    recipe: &Recipe,
    time: Option<f64>,
) -> Result<(Option<FitWay>, Warnings), Error> {
    let BodyOptions { from, to, .. } = &recipe.fit;
    if to.is_empty() {
        return Ok((None, Warnings::default()));
    }
    // Trims are on it as it is on the stage.
    let authored = mesh.points.clone();
    // A garment that is fitted already is fitted again from the body that it was made for.
    if let Some(made) = made_points(mesh) {
        mesh.points = made;
    }
    let files = [body("fit.from", from, time)?, body("fit.to", to, time)?];
    let [from, to] = [("fit.from", &files[0]), ("fit.to", &files[1])]
        .map(|(key, body)| body_of(source, body).map_err(|error| of_option(key, &error)));
    let (from, to) = (from?, to?);
    let bodies = Bodies::new(&from, &to).map_err(|error| of_option("fit.to", &error))?;
    let builder = Builder::new(mesh.clone())?;
    let Fitted { points, steps, mut warnings, .. } = fitted(&builder, recipe, &bodies)?;
    if !mesh.primvars.iter().any(|primvar| primvar.name == FIT_FROM) {
        let made = mesh.points.iter().flat_map(|p| p.to_array()).collect();
        let made = PrimvarInput::new(FIT_FROM, Interpolation::Vertex, Values::F32(made));
        mesh.primvars.push(PrimvarInput { components: 3, ..made });
    }
    mesh.points.clone_from(&points);
    let on_stage = Mesh { points: authored.into(), ..Mesh::clone(builder.garment()) };
    warnings.extend(source.set_fitted(&on_stage, points, time, &recipe.trim)?);
    warnings.extend(files.iter().flat_map(Source::notes));
    source.add_bodies(&files);
    Ok((Some(FitWay { steps, bodies, to }), warnings))
}

/// The points with which a fitted garment was made.
fn made_points(mesh: &Garment) -> Option<Vec<Vec3>> {
    let is_made = |primvar: &&PrimvarInput| {
        primvar.name == FIT_FROM && primvar.interpolation == Interpolation::Vertex && primvar.indices.is_none()
    };
    match &mesh.primvars.iter().find(is_made)?.values {
        Values::F32(made) if made.len() == 3 * mesh.points.len() => {
            Some(made.chunks_exact(3).map(Vec3::from_slice).collect())
        }
        _ => None,
    }
}

/// The options of a fit, by the names or expressions of its sets and the options that give them; `recipe` is a resolved one.
///
/// # Errors
/// Sets that the garment lacks, or that have no elements.
pub fn fit_options(
    builder: &Builder,
    recipe: &Recipe,
    rigid: (&str, &[String]),
    keep_length: (&str, &[String]),
) -> Result<FitOptions, Error> {
    let set = |place: &str, expression: &String| {
        let elements = builder.derived_set(recipe, place, expression)?.elements;
        if !elements.is_empty() {
            return Ok(elements);
        }
        let fault = Error::recipe(place, format!("the set {expression} has no elements"));
        Err(fault.code(tailor::codes::SET_EXPRESSION).remedy("`usdtailor sets` lists the sets of the garment"))
    };
    let sets = |(place, names): (&str, &[String])| names.iter().map(|name| set(place, name)).collect();
    let (rigid, keep_length): (Result<Vec<Elements>, Error>, _) = (sets(rigid), sets(keep_length));
    Ok(FitOptions { rigid: rigid?, keep_length: keep_length?, ease: recipe.fit.ease })
}

fn fitted(builder: &Builder, recipe: &Recipe, bodies: &Bodies) -> Result<Fitted, Error> {
    let recipe = builder.resolve(recipe)?;
    let BodyOptions { rigid, keep_length, .. } = &recipe.fit;
    let options = fit_options(builder, &recipe, ("fit.rigid", rigid), ("fit.keepLength", keep_length))?;
    let fitted = fit(builder.garment(), bodies, &options)?;
    Ok(Fitted { warnings: builder.face_numbers().warnings_in_file(fitted.warnings), ..fitted })
}

/// A body, whose faults are those of the option that names it.
fn body(key: &str, file: &str, time: Option<f64>) -> Result<Source, Error> {
    if file.is_empty() {
        let fault = Error::recipe(key, "it names no body, and fit.to does").code(tailor_mesh::codes::OPTION_VALUE);
        return Err(fault.remedy("name the file of the body that the garment was made for, or take fit.to out"));
    }
    Source::open(Path::new(file), &ReadOptions { time, unsewn: true, ..ReadOptions::default() })
        .map_err(|error| of_option(key, &error))
}

/// A fault of a body as one of the option that names it.
fn of_option(key: &str, error: &Error) -> Error {
    let Some(first) = error.faults.first() else { return Error::recipe(key, error.to_string()) };
    let text = if first.place.is_empty() { first.text.clone() } else { format!("{}: {}", first.place, first.text) };
    let remedy = if first.remedy.contains("--prim") { "name a file with one mesh" } else { &first.remedy };
    Error::recipe(key, text).code(first.code).remedy(remedy)
}
