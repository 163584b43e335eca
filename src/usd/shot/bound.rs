//! A built garment at bind: the simulation mesh, and the meshes that are bound to it.

use super::DriveOptions;
use crate::drive::{BindPose, Driver};
use crate::error::{Error, ErrorCode};
use crate::usd::names;
use crate::usd::read::{
    OrUnreadable, StageOrigin, all_prims, is_a, layer_files, prim_at, property_names, stage_metadata, value,
};
use crate::usd::write::pose_points;
use glam::Vec3;
use openusd::sdf::{Path, Value};
use openusd::tf::Token;
use openusd::usd::{Prim, PrimPredicate, Stage};
use std::path::{Path as FilePath, PathBuf};

/// A simulation mesh and what is bound to it.
pub struct Bound {
    /// Path of the simulation mesh.
    pub sim_path: Path,
    /// Number of its points.
    pub sim_points: usize,
    /// Its triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Median length of its edges at bind.
    pub edge_length: f64,
    /// The meshes that are bound to it.
    pub meshes: Vec<BoundMesh>,
    /// The stage's metadata.
    pub metadata: Vec<(String, Value)>,
    /// The files of its layers.
    pub layers: Vec<PathBuf>,
}

/// A mesh that is bound.
pub struct BoundMesh {
    pub path: Path,
    /// Whether a skeleton would move it again.
    pub is_skinned: bool,
    /// Points at bind.
    pub points: Vec<Vec3>,
    pub normals: Option<BoundNormals>,
    pub driver: Driver,
}

/// Authored normals.
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
    pub fn read(options: &DriveOptions) -> Result<Self, Error> {
        let origin = StageOrigin::new(&options.render, None, &[]);
        let stage = origin.open()?;
        let all = bound_meshes(&stage, &options.render)?;
        let file = options.render.display();
        let listed = || all.iter().map(|(path, _)| path.as_str()).collect::<Vec<_>>().join(", ");
        let chosen = match &options.prim {
            Some(wanted) => all.iter().find(|(path, _)| path.as_str() == wanted).ok_or_else(|| {
                Error::usd(format!("{wanted} of {file} is not bound to a simulation mesh"))
                    .code(ErrorCode::NotBound)
                    .remedy(format!("the bound meshes are: {}", listed()))
            })?,
            None => match all.as_slice() {
                [one] => one,
                [] => {
                    return Err(Error::usd(format!("{file} has no mesh that is bound to a simulation mesh"))
                        .code(ErrorCode::NotBound)
                        .remedy("build it with `usdtailor build` of this version"));
                }
                _ => {
                    return Err(Error::usd(format!("{file} has {} bound meshes", all.len()))
                        .code(ErrorCode::SeveralMeshes)
                        .remedy(format!("choose one by --prim: {}", listed())));
                }
            },
        };
        let sim = prim_at(&stage, &chosen.1)?;
        let sim_points = points_at_bind(&sim)?;
        let triangles = triangles(&sim)?;
        let render = prim_at(&stage, &chosen.0)?;
        let mut meshes = vec![BoundMesh::read(&render, &render, names::BINDING, &sim_points, &triangles)?];
        if options.model {
            let [.., source] = names::MODEL_BINDING;
            let model = sim.relationship(source).targets().or_unreadable(&chosen.1)?;
            let Some(model) = model.first() else {
                return Err(Error::usd(format!("{} of {file} has no {source}", chosen.1))
                    .code(ErrorCode::StaleBinding)
                    .remedy("leave out --model, or build the garment again"));
            };
            let model = prim_at(&stage, model)?;
            meshes.push(BoundMesh::read(&model, &sim, names::MODEL_BINDING, &sim_points, &triangles)?);
        }
        let mut bound = Self {
            sim_path: chosen.1.clone(),
            sim_points: sim_points.len(),
            triangles,
            edge_length: 0.0,
            meshes,
            metadata: stage_metadata(&stage)?,
            layers: layer_files(&stage),
        };
        bound.edge_length = bound.median_edge(&sim_points);
        Ok(bound)
    }

    /// The median edge length of the triangles with some points.
    pub fn median_edge(&self, points: &[Vec3]) -> f64 {
        let length = |t: &[u32; 3], k: usize| points[t[k] as usize].distance(points[t[(k + 1) % 3] as usize]);
        let mut lengths: Vec<f32> = self.triangles.iter().flat_map(|t| [0, 1, 2].map(|k| length(t, k))).collect();
        let middle = lengths.len() / 2;
        if lengths.is_empty() {
            return 0.0;
        }
        f64::from(*lengths.select_nth_unstable_by(middle, f32::total_cmp).1)
    }
}

/// The bound meshes of a stage, each with the simulation mesh.
fn bound_meshes(stage: &Stage, file: &FilePath) -> Result<Vec<(Path, Path)>, Error> {
    let mut found = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, false)? {
        let prim = prim_at(stage, &path)?;
        if !is_a(&prim, names::MESH)? || !property_names(&prim)?.iter().any(|name| name == names::BINDING[2]) {
            continue;
        }
        let targets = prim.relationship(names::BINDING[2]).targets().or_unreadable(&path)?;
        found.extend(targets.into_iter().next().map(|target| (path, target)));
    }
    Ok(found)
}

/// The points of a mesh at bind: its bind pose, else its points without a time.
fn points_at_bind(prim: &Prim) -> Result<Vec<Vec3>, Error> {
    let pose = pose_points().find_map(|name| value(prim, &name, None).ok().flatten());
    let points = match pose {
        Some(pose) => Some(pose),
        None => value(prim, names::POINTS, None)?,
    };
    match points {
        Some(Value::Vec3fVec(points)) => Ok(bytemuck::cast_slice(&points).to_vec()),
        _ => Err(Error::usd(format!("{} has no points without a time", prim.path()))
            .code(ErrorCode::StaleBinding)
            .remedy("build the garment again")),
    }
}

fn ints(prim: &Prim, name: &str) -> Result<Vec<i32>, Error> {
    match value(prim, name, None)? {
        Some(Value::IntVec(values)) => Ok(values),
        _ => Err(Error::usd(format!("{}.{name} is missing", prim.path()))
            .code(ErrorCode::StaleBinding)
            .remedy("build the garment again")),
    }
}

fn triangles(sim: &Prim) -> Result<Vec<[u32; 3]>, Error> {
    let counts = ints(sim, names::FACE_VERTEX_COUNTS)?;
    let corners = ints(sim, names::FACE_VERTEX_INDICES)?;
    if counts.iter().any(|n| *n != 3) || corners.len() != 3 * counts.len() || corners.iter().any(|v| *v < 0) {
        return Err(Error::usd(format!("{} is no triangle mesh", sim.path()))
            .code(ErrorCode::StaleBinding)
            .remedy("build the garment again"));
    }
    Ok(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v as u32)).collect())
}

impl BoundMesh {
    /// Reads a mesh whose places `holder` has, by the first two of `names`.
    fn read(
        prim: &Prim,
        holder: &Prim,
        [faces, coords, _]: [&str; 3],
        sim_points: &[Vec3],
        triangles: &[[u32; 3]],
    ) -> Result<Self, Error> {
        let points = points_at_bind(prim)?;
        let faces: Vec<u32> = ints(holder, faces)?.iter().map(|face| *face as u32).collect();
        let coords: Vec<Vec3> = match value(holder, coords, None)? {
            Some(Value::Vec3fVec(coords)) => bytemuck::cast_slice(&coords).to_vec(),
            _ => {
                return Err(Error::usd(format!("{}.{coords} is missing", holder.path()))
                    .code(ErrorCode::StaleBinding)
                    .remedy("build the garment again"));
            }
        };
        let pose = BindPose { sim_points, triangles, points: &points, faces: &faces, coords: &coords };
        let driver = Driver::new(&pose)?;
        let schemas = prim.authored_api_schemas().or_unreadable(prim.path())?;
        let is_skinned = schemas.iter().any(|schema| schema.as_str() == names::SKEL_BINDING_API);
        Ok(Self { path: prim.path().clone(), is_skinned, normals: normals(prim, points.len())?, points, driver })
    }
}

/// The authored normals of a mesh that is no subdivision surface; none where one normal is for all points.
fn normals(prim: &Prim, points: usize) -> Result<Option<BoundNormals>, Error> {
    let scheme = value(prim, names::SUBDIVISION_SCHEME, None)?;
    let Some(Value::Vec3fVec(values)) = value(prim, names::NORMALS, None)? else { return Ok(None) };
    if !matches!(scheme, Some(Value::Token(scheme)) if scheme.as_str() == "none") {
        return Ok(None);
    }
    let attribute = prim.attribute(names::NORMALS);
    let interpolation = attribute.get_metadata::<Token>(names::INTERPOLATION).or_unreadable(prim.path())?;
    let corners = || ints(prim, names::FACE_VERTEX_INDICES);
    let of = match interpolation.as_ref().map(Token::as_str) {
        Some("constant") => return Ok(None),
        Some("faceVarying") => corners()?,
        Some("uniform") => first_corners(&corners()?, &ints(prim, names::FACE_VERTEX_COUNTS)?),
        _ => (0..points as i32).collect(),
    };
    if of.len() != values.len() || !of.iter().all(|v| (0..points as i32).contains(v)) {
        let text = format!("{} normals of {} do not fit its {points} points and its faces", values.len(), prim.path());
        return Err(Error::usd(text)
            .code(ErrorCode::AttributeType)
            .remedy("mend its normals or their interpolation, or block them"));
    }
    let values = bytemuck::cast_slice(&values).to_vec();
    Ok(Some(BoundNormals { values, points: of.iter().map(|v| *v as u32).collect() }))
}

/// The first vertex of each face.
fn first_corners(corners: &[i32], counts: &[i32]) -> Vec<i32> {
    let starts = counts.iter().scan(0, |next, n| {
        let start = *next;
        *next += usize::try_from(*n).unwrap_or(0);
        Some(start)
    });
    starts.filter_map(|start| corners.get(start)).copied().collect()
}
