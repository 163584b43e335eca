//! Meshes that are too small or too thick to be cloth, and become trims.

use crate::names;
use crate::read::query::{prim_at, property_names};
use crate::read::source::Source;
use glam::{DMat4, Vec3};
use openusd::sdf::Path;
use openusd::usd::Stage;
use serde_json::{Map, Value as Json, json};
use std::iter;
use tailor_costume::binding::Triangles;
use tailor_costume::trim::{Stiffness, TrimShape, faces};
use tailor_mesh::error::Error;
use tailor_mesh::garment::Garment;

/// The name of the options of the trims that are found.
const FOUND: &str = "found";
/// Largest distance of a trim from a garment. \[sizes of the garment\]
const NEAR: f32 = 0.02;

/// A mesh that may be a trim.
struct Candidate {
    /// Its points in the space of the stage.
    shape: TrimShape,
    triangles: Vec<[Vec3; 3]>,
    size: f32,
    /// Whether it has options of its own, which make it a garment.
    is_garment: bool,
}

/// Takes out the meshes that are not cloth and lie on another: all their pieces are small or thick beside the largest mesh. They become
/// trims of the others.
///
/// # Errors
/// A stage that cannot be queried.
pub fn take(stage: &Stage, sources: &mut Vec<Source>) -> Result<(), Error> {
    let candidates = sources.iter().map(|source| Candidate::new(stage, source)).collect::<Result<Vec<_>, Error>>()?;
    let largest = candidates.iter().map(|candidate| candidate.size).fold(0.0, f32::max);
    let is_stiff = |c: &Candidate| c.shape.pieces.iter().all(|piece| piece.stiffness(largest) != Stiffness::Supple);
    let is_trim: Vec<bool> =
        candidates.iter().map(|c| !c.is_garment && !c.shape.pieces.is_empty() && is_stiff(c)).collect();
    let cloth = candidates.iter().zip(&is_trim).filter(|(_, is_trim)| !**is_trim);
    let cloth = Triangles::new(cloth.flat_map(|(candidate, _)| candidate.triangles.iter().copied()).collect());
    let is_near = |c: &Candidate| c.shape.is_near(&cloth, NEAR * largest);
    let taken = is_trim.iter().zip(&candidates).map(|(is_trim, c)| *is_trim && is_near(c));
    let (taken, cloth): (Vec<_>, Vec<_>) = sources.drain(..).zip(taken).partition(|(_, taken)| *taken);
    sources.extend(cloth.into_iter().map(|(source, _)| source));
    let trims: Vec<Path> = taken.into_iter().map(|(source, _)| source.model.path).collect();
    if !trims.is_empty() {
        sources.iter_mut().filter_map(|source| source.recipe.as_mut().ok()).for_each(|options| add(options, &trims));
    }
    Ok(())
}

impl Candidate {
    fn new(stage: &Stage, source: &Source) -> Result<Self, Error> {
        let prim = prim_at(stage, &source.model.path)?;
        let has_options = |name: &String| name.starts_with(names::RECIPE) && !names::is_produced(name);
        let schemas = &source.facts.api_schemas;
        let is_ours = |schema: &String| schema.starts_with("Tailor");
        let is_garment = property_names(&prim)?.iter().any(has_options) || schemas.iter().any(is_ours);
        let none = Self { shape: TrimShape::default(), triangles: Vec::new(), size: 0.0, is_garment };
        let Ok(garment) = &source.garment else { return Ok(none) };
        let placed = PlacedMesh::new(garment, source.model.transforms.to_world);
        let triangles = placed.triangles();
        let shape = TrimShape::of_mesh(placed.points, &placed.counts, &placed.corners);
        let size = shape.size();
        Ok(if size.is_finite() { Self { triangles, shape, size, is_garment } } else { none })
    }
}

/// A mesh in the space of the stage.
pub struct PlacedMesh {
    /// Its points.
    pub points: Vec<Vec3>,
    counts: Vec<usize>,
    corners: Vec<u32>,
}

impl PlacedMesh {
    pub fn new(mesh: &Garment, to_world: DMat4) -> Self {
        Self {
            points: mesh.points.iter().map(|p| to_world.transform_point3(p.as_dvec3()).as_vec3()).collect(),
            counts: mesh.face_vertex_counts.iter().map(|&n| usize::try_from(n).unwrap_or(0)).collect(),
            corners: mesh.face_vertex_indices.iter().map(|&v| v as u32).collect(),
        }
    }

    /// The diagonal of the box of its points.
    pub fn size(&self) -> f32 {
        let [low, high] = [Vec3::min, Vec3::max].map(|f| self.points.iter().copied().reduce(f).unwrap_or_default());
        high.distance(low)
    }

    /// The triangles of its faces, all of whose corners have to be points.
    pub fn triangles(&self) -> Vec<[Vec3; 3]> {
        let fan = |face: &[u32]| -> Vec<[Vec3; 3]> {
            let at = |v: u32| self.points[v as usize];
            face.windows(2).skip(1).map(|pair| [at(face[0]), at(pair[0]), at(pair[1])]).collect()
        };
        faces(&self.counts, &self.corners).flat_map(fan).collect()
    }
}

/// Adds trims to the options of a garment, under the name [`FOUND`], or one with a number where that is taken.
fn add(options: &mut Map<String, Json>, trims: &[Path]) {
    let named = options.entry("trim").or_insert_with(|| Json::Object(Map::new()));
    let Json::Object(named) = named else { return };
    let numbered = (2..).map(|number| format!("{FOUND}_{number}"));
    let name = iter::once(FOUND.to_owned()).chain(numbered).find(|name| !named.contains_key(name));
    let prims: Vec<&str> = trims.iter().map(Path::as_str).collect();
    named.extend(name.map(|name| (name, json!({ "prims": prims }))));
}
