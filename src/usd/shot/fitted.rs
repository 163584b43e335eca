//! A garment on another body takes its trims along: they are bound to its faces, and driven by where these went.

use super::bound::{Bind, BoundPrim};
use super::stream::type_of;
use crate::on_large_stack;
use crate::read::{FittedPoints, FittedTrim, Model, Source, TrimPrim, is_on, prim_at, trim_path, trims};
use crate::write::off_cloth;
use glam::{Quat, Vec3};
use openusd::sdf::{Path, Value};
use openusd::usd::{Stage, TimeCode};
use std::collections::BTreeMap;
use std::sync::Arc;
use tailor_costume::binding::BindSurface;
use tailor_costume::drive::BindFrames;
use tailor_costume::trim::{TrimMode, TrimOptions};
use tailor_mesh::connectivity::{Faces, IdVec, VertexId};
use tailor_mesh::error::{Error, Warning, Warnings};
use tailor_mesh::garment::Mesh;

impl Source {
    /// Gives the garment other points, in the order of those that `mesh` has at `time`. They are written over its own, and its trims go
    /// with it. Warns of trims that stay.
    ///
    /// # Errors
    /// Other numbers of points; a trim that is not there, or that has no points.
    pub fn set_fitted(
        &mut self,
        mesh: &Mesh,
        points: Vec<Vec3>,
        time: Option<f64>,
        options: &BTreeMap<String, TrimOptions>,
    ) -> Result<Warnings, Error> {
        if points.len() != mesh.points.len() {
            let text = format!("{} new points for a garment of {}", points.len(), mesh.points.len());
            return Err(Error::usd(text)
                .code(tailor_mesh::codes::VALUE_COUNT)
                .remedy("give one for each of its points"));
        }
        let mut fitted = FittedPoints { points, time, ..FittedPoints::default() };
        let mut warnings = Warnings::default();
        if !options.is_empty() {
            (fitted.trims, fitted.elsewhere) =
                warnings.absorb(on_large_stack(|| taken_along(&self.model, mesh, &fitted, options))?);
        }
        self.fitted = Some(Arc::new(fitted));
        Ok(warnings)
    }
}

/// Trims that go along, and paths of those that ride on another mesh, with its path.
type Along = (Vec<FittedTrim>, Vec<(Path, String)>);

/// The trims that options name, each once, with a garment that was as `mesh` is.
fn taken_along(
    model: &Model,
    mesh: &Mesh,
    fitted: &FittedPoints,
    options: &BTreeMap<String, TrimOptions>,
) -> Result<(Along, Warnings), Error> {
    let (stage, cage) = (model.origin.open()?, triangulated(mesh));
    let way = Way::new(model, &cage, fitted)?;
    let (mut moved, mut staying, mut elsewhere) = (BTreeMap::new(), Vec::new(), Vec::new());
    let mut warnings = Warnings::default();
    for (name, TrimOptions { prims, mode, on }) in options {
        for named in prims {
            let key = format!("trim.{name}.prims");
            let root = trim_path(model, &key, named)?;
            if !is_on(model, on) {
                elsewhere.push((root, on.clone()));
                continue;
            }
            if *mode == TrimMode::None {
                staying.push(root);
                continue;
            }
            for trim in warnings.absorb(trims(&stage, &model.origin.file, &key, &root, way.time)?) {
                if moved.contains_key(&trim.path) {
                    continue;
                }
                match way.moved(&stage, name, &trim, *mode) {
                    Ok(trim) => _ = moved.insert(trim.path.clone(), trim),
                    Err(error) => warnings.push(Warning::unread(&trim.path, &error)),
                }
            }
        }
    }
    for root in staying.iter().filter(|root| !moved.keys().any(|path| path.has_prefix(root))) {
        let stays = Warning::not_carried(root, "its mode is none, so that it stays where it is");
        warnings.push(stays.remedy("Move it by hand, or give it another mode"));
    }
    Ok(((moved.into_values().collect(), elsewhere), warnings))
}

/// The faces of a garment as triangles.
fn triangulated(mesh: &Mesh) -> Mesh {
    let corners: IdVec<_, VertexId> = mesh.faces.fans().flatten().collect();
    Mesh { points: mesh.points.clone(), faces: Faces::triangles(corners), ..Mesh::default() }
}

/// A garment of triangles, and where it went.
struct Way<'a> {
    model: &'a Model,
    surface: BindSurface<'a>,
    size: f32,
    points: &'a [Vec3],
    triangles: Vec<[u32; 3]>,
    frames: Arc<BindFrames>,
    to: &'a [Vec3],
    rotations: Vec<Quat>,
    time: Option<TimeCode>,
}

impl<'a> Way<'a> {
    fn new(model: &'a Model, cage: &'a Mesh, fitted: &'a FittedPoints) -> Result<Self, Error> {
        let triangle = |face| [0, 1, 2].map(|k| cage.faces.vertices_of(face)[k].index() as u32);
        let triangles: Vec<[u32; 3]> = cage.faces.ids().map(triangle).collect();
        let points = cage.points.as_slice();
        let frames = Arc::new(BindFrames::new(points, &triangles)?);
        let (to, time) = (fitted.points.as_slice(), fitted.time.map(TimeCode::new));
        let rotations = frames.rotations(to);
        let (surface, size) = (BindSurface::new(cage), cage.size());
        Ok(Self { model, surface, size, points, triangles, frames, to, rotations, time })
    }

    /// A trim where the garment takes it.
    fn moved(&self, stage: &Stage, name: &str, trim: &TrimPrim, mode: TrimMode) -> Result<FittedTrim, Error> {
        let shape = trim.beside(self.model);
        let (places, ride) = shape.bound(mode, &self.surface, self.size);
        let (to_world, time) = (self.model.transforms.to_world, self.time);
        let bind = Bind { to_world, time, points: self.points, triangles: &self.triangles, frames: &self.frames };
        let bound = BoundPrim::read(&prim_at(stage, &trim.path)?, &trim.shape.points, &places, &bind)?;
        let driven = bound.driven(self.to, &self.rotations, None, bound.space.as_ref());
        if !driven.points.iter().all(|point| point.is_finite()) {
            return Err(Error::usd("it is too far from the cloth to be bound"));
        }
        let changed = driven.all_values().map(|(name, value)| (name.to_owned(), type_of(name), value));
        let blocked = bound.stale.iter().map(|(name, kind)| (name.clone(), kind.clone(), Value::ValueBlock));
        Ok(FittedTrim {
            path: trim.path.clone(),
            name: name.to_owned(),
            distance: shape.distance(&self.surface),
            off_cloth: off_cloth(&trim.path, &ride, &self.model.path, self.size),
            ride,
            values: changed.chain(blocked).collect(),
            points: driven.points,
            to_world: trim.to_world,
        })
    }
}
