//! A built garment at bind: the simulation mesh, and the meshes that are bound to it.

use super::DriveOptions;
use super::chosen::{BoundMesh, Chosen};
use super::conversion::StageMetrics;
use super::space::{Motion, Motions, Space};
use crate::codes;
use crate::names;
use crate::read::{
    OrUnreadable, composition, dependent_attributes, is_a, layer_files, points_name, prim_at, stage_metadata,
    transforms, value, vectors,
};
use crate::write::{extent, pose_points};
use glam::{DMat4, Quat, Vec3};
use openusd::gf::{Quath, f16};
use openusd::sdf::{Path, Value, ValueTypeName};
use openusd::tf::Token;
use openusd::usd::{Prim, Stage, TimeCode};
use std::path::PathBuf;
use std::sync::Arc;
use tailor_costume::binding::Binding;
use tailor_costume::drive::{BindFrames, BindPose, Driver};
use tailor_mesh::error::{Error, Warning};

/// A mesh at bind, which a cache moves.
pub struct MeshAtBind {
    pub path: Path,
    pub points: Vec<Vec3>,
    /// The vertices of its faces, one face after another.
    pub corners: Vec<u32>,
    /// The edges of each face.
    edges: Vec<[u32; 2]>,
    /// Median length of its edges.
    pub edge_length: f64,
    /// The up axis and unit of its stage.
    pub metrics: StageMetrics,
}

impl MeshAtBind {
    /// A mesh whose faces have `counts` of `corners`, each a vertex among `points`.
    pub fn new(
        path: Path,
        points: Vec<Vec3>,
        counts: impl Iterator<Item = usize>,
        corners: Vec<u32>,
        metrics: StageMetrics,
    ) -> Self {
        let mut edges = Vec::with_capacity(corners.len());
        let mut start = 0;
        for count in counts {
            let face = &corners[start..start + count];
            edges.extend((0..count).map(|k| [face[k], face[(k + 1) % count]]));
            start += count;
        }
        let mut mesh = Self { path, points, corners, edges, edge_length: 0.0, metrics };
        mesh.edge_length = mesh.median_edge(&mesh.points);
        mesh
    }

    /// The median edge length with some points.
    pub fn median_edge(&self, points: &[Vec3]) -> f64 {
        let length = |[a, b]: &[u32; 2]| points[*a as usize].distance(points[*b as usize]);
        let mut lengths: Vec<f32> = self.edges.iter().map(length).collect();
        let middle = lengths.len() / 2;
        if lengths.is_empty() {
            return 0.0;
        }
        f64::from(*lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
    }
}

/// A simulation mesh and what is bound to it.
pub struct Bound {
    /// The simulation mesh.
    pub sim: MeshAtBind,
    /// Its vertices at bind, from which they turn.
    pub frames: Arc<BindFrames>,
    /// The prims that are bound to it.
    pub meshes: Vec<BoundPrim>,
    /// The stage's metadata.
    pub metadata: Vec<(String, Value)>,
    /// The files of its layers.
    pub layers: Vec<PathBuf>,
    /// Warnings of its composition, and notes about layers that were converted.
    pub notes: Vec<Warning>,
}

/// A mesh that is bound, or a trim.
pub struct BoundPrim {
    pub path: Path,
    /// The name of the attribute of its points.
    pub points_name: &'static str,
    /// Whether a skeleton would move it again.
    pub is_skinned: bool,
    /// Number of its points.
    pub points: usize,
    pub normals: Option<BoundNormals>,
    /// Of Hermite curves, in the space of the simulation mesh.
    pub tangents: Option<Vec<Vec3>>,
    /// Rotations of instances at bind.
    pub orientations: Option<Vec<Quat>>,
    /// How far it reaches beyond its points, such as instances do; none if nobody says so.
    pub reach: Option<f32>,
    /// Attributes that are of its points at bind, with their types. They are blocked where they are not driven.
    pub stale: Vec<(String, ValueTypeName)>,
    /// Its space, if it is not that of the simulation mesh.
    pub space: Option<Space>,
    pub driver: Driver,
}

/// Authored normals, in the space of the simulation mesh.
pub struct BoundNormals {
    pub values: Vec<Vec3>,
    /// The point of each normal.
    pub points: Vec<u32>,
}

impl Bound {
    /// Reads the garment that is to be driven.
    ///
    /// # Errors
    /// A stage that cannot be read; no bound mesh, or several.
    pub fn read(options: &DriveOptions) -> Result<(Self, Motions), Error> {
        let (stage, chosen) = Chosen::open(options)?;
        let sim = prim_at(&stage, &chosen.sim)?;
        let sim_points = points_at_bind(&sim)?;
        let triangles = triangles(&sim)?;
        let frames = Arc::new(BindFrames::new(&sim_points, &triangles)?);
        let to_world = transforms(&sim, None)?.to_world;
        let bind = Bind { to_world, time: None, points: &sim_points, triangles: &triangles, frames: &frames };
        let mut found = Vec::with_capacity(chosen.meshes.len());
        for mesh in &chosen.meshes {
            found.push(bind.mesh(&prim_at(&stage, &mesh.path)?, mesh)?);
        }
        for (stage, of_level) in chosen.other_levels(&stage, options)? {
            let to_world = transforms(&prim_at(&stage, &chosen.sim)?, None)?.to_world;
            let bind = Bind { to_world, ..bind };
            for mesh in &of_level {
                found.push(bind.mesh(&prim_at(&stage, &mesh.path)?, mesh)?);
            }
        }
        if options.model {
            found.extend(models(&stage, options, &sim, &bind)?);
        }
        let (motions, meshes) = found.into_iter().unzip();
        let motions = Motions { sim: Motion::of(&sim, None)?, meshes: motions };
        let metadata = stage_metadata(&stage)?;
        let metrics = StageMetrics::of(&metadata);
        let counts = std::iter::repeat_n(3, triangles.len());
        let sim = MeshAtBind::new(sim.path().clone(), sim_points, counts, triangles.into_flattened(), metrics);
        let (layers, mut notes) = (layer_files(&stage, &chosen.origin.read), chosen.origin.read.notes());
        notes.extend(composition(&stage, &options.render).iter().cloned());
        Ok((Self { sim, frames, meshes, metadata, layers, notes }, motions))
    }
}

/// The garment's own meshes: one, or the panels that are sewn together, whose places are one after another.
fn models(
    stage: &Stage,
    options: &DriveOptions,
    holder: &Prim,
    bind: &Bind,
) -> Result<Vec<(Motion, BoundPrim)>, Error> {
    let [faces, coords, source] = names::MODEL_BINDING;
    let (sim, file) = (holder.path(), options.render.display());
    let paths = holder.relationship(source).targets().or_unreadable(sim)?;
    if paths.is_empty() {
        let text = format!("{sim} of {file} has no {source}");
        return Err(unbound(text).remedy("leave out --model, or build the garment again"));
    }
    let mut panels = Vec::with_capacity(paths.len());
    for path in &paths {
        let prim = prim_at(stage, path)?;
        let points = points_at_bind(&prim)?;
        panels.push((prim, points));
    }
    let mut places = read_places(holder, [faces, coords])?;
    let count: usize = panels.iter().map(|(_, points)| points.len()).sum();
    if count != places.faces.len() || count != places.coords.len() {
        let text = format!("{sim} of {file} has places for {} points of its model, not {count}", places.faces.len());
        return Err(unbound(text));
    }
    let mut meshes = Vec::with_capacity(panels.len());
    for (prim, points) in panels {
        let own = ..points.len();
        let own = Binding { faces: places.faces.drain(own).collect(), coords: places.coords.drain(own).collect() };
        meshes.push((Motion::of(&prim, None)?, BoundPrim::read(&prim, &points, &own, bind)?));
    }
    Ok(meshes)
}

/// The mesh of triangles at bind that moves what is bound to it.
#[derive(Clone, Copy)]
pub struct Bind<'a> {
    /// From its space to the stage's.
    pub to_world: DMat4,
    /// The time of what is bound.
    pub time: Option<TimeCode>,
    pub points: &'a [Vec3],
    pub triangles: &'a [[u32; 3]],
    pub frames: &'a Arc<BindFrames>,
}

impl Bind<'_> {
    /// Reads a mesh that is bound, and how its transform moves.
    fn mesh(&self, prim: &Prim, mesh: &BoundMesh) -> Result<(Motion, BoundPrim), Error> {
        let [faces, coords, _] = names::binding(mesh.level);
        let places = read_places(prim, [&faces, &coords])?;
        Ok((Motion::of(prim, None)?, BoundPrim::read(prim, &points_at_bind(prim)?, &places, self)?))
    }
}

/// Reads the places of points on the simulation mesh from `holder`, by the names of faces and coordinates.
fn read_places(holder: &Prim, [faces, coords]: [&str; 2]) -> Result<Binding, Error> {
    let faces = ints(holder, faces)?.iter().map(|face| *face as u32).collect();
    let coords = vectors(holder, coords, None)?.ok_or_else(|| missing(holder, coords))?;
    Ok(Binding { faces, coords })
}

/// The error of a garment that is not as it was built.
fn unbound(text: String) -> Error {
    Error::usd(text).code(tailor_costume::codes::STALE_BINDING).remedy("build the garment again")
}

fn missing(prim: &Prim, name: &str) -> Error {
    unbound(format!("{} has no {name}", prim.path()))
}

/// The points of a mesh at bind: its bind pose, else its points without a time.
fn points_at_bind(prim: &Prim) -> Result<Vec<Vec3>, Error> {
    let pose = pose_points().find_map(|name| vectors(prim, &name, None).ok().flatten());
    let own = vectors(prim, points_name(prim)?, None)?;
    // A viewer draws the mesh at its own points before the first frame.
    if let Some(at) = [&pose, &own].into_iter().flatten().find_map(|all| all.iter().position(|p| !p.is_finite())) {
        return Err(unbound(format!("point {at} of {} is not finite", prim.path())));
    }
    pose.or(own).ok_or_else(|| missing(prim, "points without a time"))
}

fn ints(prim: &Prim, name: &str) -> Result<Vec<i32>, Error> {
    match value(prim, name, None)? {
        Some(Value::IntVec(values)) => Ok(values),
        _ => Err(missing(prim, name)),
    }
}

fn triangles(sim: &Prim) -> Result<Vec<[u32; 3]>, Error> {
    let counts = ints(sim, names::FACE_VERTEX_COUNTS)?;
    let corners = ints(sim, names::FACE_VERTEX_INDICES)?;
    if counts.iter().any(|n| *n != 3) || corners.len() != 3 * counts.len() || corners.iter().any(|v| *v < 0) {
        return Err(unbound(format!("{} is not a triangle mesh", sim.path())));
    }
    Ok(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v as u32)).collect())
}

impl BoundPrim {
    /// Reads a prim with these points at bind and places on what moves it.
    pub fn read(prim: &Prim, points: &[Vec3], places: &Binding, bind: &Bind) -> Result<Self, Error> {
        let space = Space::between(prim, bind.to_world, bind.time)?;
        let mut in_sim = points.to_vec();
        space.iter().for_each(|space| space.to_sim.points(&mut in_sim, None));
        let pose = BindPose {
            sim_points: bind.points,
            triangles: bind.triangles,
            points: &in_sim,
            faces: &places.faces,
            coords: &places.coords,
        };
        let driver = Driver::sharing(bind.frames, &pose)?;
        let schemas = prim.authored_api_schemas().or_unreadable(prim.path())?;
        let is_skinned = schemas.iter().any(|schema| schema.as_str() == names::SKEL_BINDING_API);
        let mut normals = normals(prim, points.len(), bind.time)?;
        let mut tangents = vectors(prim, names::TANGENTS, bind.time)?.filter(|all| all.len() == points.len());
        if let Some(space) = &space {
            normals.iter_mut().for_each(|normals| space.to_sim.normals(&mut normals.values));
            tangents.iter_mut().for_each(|tangents| space.to_sim.tangents(tangents));
        }
        let mut stale = dependent_attributes(prim)?;
        // A normal of all points does not turn, and those of a subdivision surface count for nothing.
        stale.retain(|(name, _)| name != names::NORMALS && (name != names::TANGENTS || tangents.is_none()));
        Ok(Self {
            path: prim.path().clone(),
            points_name: points_name(prim)?,
            is_skinned,
            points: points.len(),
            normals,
            tangents,
            orientations: orientations(prim, points.len(), bind.time)?,
            reach: reach(prim, points, bind.time)?,
            stale,
            space,
            driver,
        })
    }
}

/// The rotations of instances; none of other prims.
fn orientations(prim: &Prim, count: usize, time: Option<TimeCode>) -> Result<Option<Vec<Quat>>, Error> {
    if !is_a(prim, names::POINT_INSTANCER)? {
        return Ok(None);
    }
    let mut all = match (value(prim, names::ORIENTATIONS_F, time)?, value(prim, names::ORIENTATIONS, time)?) {
        (Some(Value::QuatfVec(all)), _) if !all.is_empty() => {
            all.iter().map(|q| Quat::from_xyzw(q.x, q.y, q.z, q.w)).collect()
        }
        (_, Some(Value::QuathVec(all))) => {
            let full = |q: &Quath| [q.x, q.y, q.z, q.w].map(f16::to_f32);
            all.iter().map(|q| Quat::from_array(full(q))).collect()
        }
        _ => Vec::new(),
    };
    all.resize(count, Quat::IDENTITY);
    // To USD, a quaternion of zeros turns nothing.
    let is_turn = |q: &Quat| q.length_squared() > 0.0 && q.is_finite();
    Ok(Some(all.into_iter().map(|q| if is_turn(&q) { q } else { Quat::IDENTITY }).collect()))
}

/// How far a prim reaches beyond its points at bind: not at all for a mesh, otherwise as its authored extent does.
fn reach(prim: &Prim, points: &[Vec3], time: Option<TimeCode>) -> Result<Option<f32>, Error> {
    if is_a(prim, names::MESH)? {
        return Ok(Some(0.0));
    }
    let (authored, own) = (vectors(prim, names::EXTENT, time)?.unwrap_or_default(), extent(points));
    let (&[low, high], &[own_low, own_high]) = (&authored[..], bytemuck::cast_slice::<_, Vec3>(&own)) else {
        return Ok(None);
    };
    Ok(Some((own_low - low).max(high - own_high).max_element().max(0.0)))
}

/// The authored normals of curves, or of a mesh that is not a subdivision surface; none where one normal is for all points.
fn normals(prim: &Prim, points: usize, time: Option<TimeCode>) -> Result<Option<BoundNormals>, Error> {
    let scheme = value(prim, names::SUBDIVISION_SCHEME, None)?;
    let Some(values) = vectors(prim, names::NORMALS, time)? else { return Ok(None) };
    let is_polygonal = matches!(scheme, Some(Value::Token(scheme)) if scheme.as_str() == "none");
    if !is_polygonal && is_a(prim, names::MESH)? {
        return Ok(None);
    }
    let attribute = prim.attribute(names::NORMALS);
    let interpolation = attribute.get_metadata::<Token>(names::INTERPOLATION).or_unreadable(prim.path())?;
    let all = || (0..points as i32).collect::<Vec<_>>();
    let is_mesh = is_a(prim, names::MESH)?;
    let corners = || if is_mesh { ints(prim, names::FACE_VERTEX_INDICES) } else { Ok(all()) };
    let of = match interpolation.as_ref().map(Token::as_str) {
        Some("constant") => return Ok(None),
        Some("faceVarying") => corners()?,
        Some("uniform") => {
            let counts = if is_mesh { names::FACE_VERTEX_COUNTS } else { names::CURVE_VERTEX_COUNTS };
            first_corners(&corners()?, &ints(prim, counts)?)
        }
        _ => all(),
    };
    if of.len() != values.len() || !of.iter().all(|v| (0..points as i32).contains(v)) {
        let text = format!("{} normals of {} do not fit its {points} points and its faces", values.len(), prim.path());
        return Err(Error::usd(text)
            .code(codes::ATTRIBUTE_TYPE)
            .remedy("mend its normals or their interpolation, or block them"));
    }
    Ok(Some(BoundNormals { values, points: of.iter().map(|v| *v as u32).collect() }))
}

/// The first vertex of each face or curve.
fn first_corners(corners: &[i32], counts: &[i32]) -> Vec<i32> {
    let starts = counts.iter().scan(0, |next, n| {
        let start = *next;
        *next += usize::try_from(*n).unwrap_or(0);
        Some(start)
    });
    starts.filter_map(|start| corners.get(start)).copied().collect()
}
