//! Meshes that are too small or too thick to be cloth, and become trims.

use crate::error::Error;
use crate::trim::{PointCloud, Stiffness, TrimShape};
use crate::usd::names;
use crate::usd::read::query::{prim_at, property_names};
use crate::usd::read::source::Source;
use glam::Vec3;
use openusd::sdf::Path;
use openusd::usd::Stage;
use serde_json::{Map, Value as Json, json};

/// Largest distance of a trim from a garment. \[sizes of the garment\]
const NEAR: f32 = 0.02;

/// A mesh that may be a trim.
struct Candidate {
    /// Its points in the space of the stage.
    shape: TrimShape,
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
    let cloth: Vec<Vec3> = cloth.flat_map(|(candidate, _)| candidate.shape.points.iter().copied()).collect();
    let cloth = PointCloud::new(cloth);
    let is_near = |c: &Candidate| c.shape.is_near(&cloth, NEAR * largest);
    let mut taken: Vec<bool> = is_trim.iter().zip(&candidates).map(|(is_trim, c)| *is_trim && is_near(c)).collect();
    let trims: Vec<Path> =
        sources.iter().zip(&taken).filter(|(_, taken)| **taken).map(|(source, _)| source.model.path.clone()).collect();
    sources.retain(|_| !taken.remove(0));
    for source in sources.iter_mut() {
        if let Ok(options) = &mut source.recipe {
            trims.iter().for_each(|trim| add(options, trim));
        }
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
        let Ok(garment) = &source.garment else {
            return Ok(Self { shape: TrimShape::default(), size: 0.0, is_garment });
        };
        let to_world = source.model.transforms.to_world;
        let points: Vec<Vec3> =
            garment.points.iter().map(|p| to_world.transform_point3(p.as_dvec3()).as_vec3()).collect();
        let is_whole = |n: &i32| usize::try_from(*n).is_ok_and(|n| n < points.len());
        let is_good = points.iter().all(|p| p.is_finite()) && garment.face_vertex_indices.iter().all(is_whole);
        let counts: Vec<usize> = garment.face_vertex_counts.iter().map(|&n| usize::try_from(n).unwrap_or(0)).collect();
        let corners: Vec<u32> = garment.face_vertex_indices.iter().map(|&v| v as u32).collect();
        let shape = if is_good { TrimShape::of_mesh(points, &counts, &corners) } else { TrimShape::default() };
        Ok(Self { size: shape.size(), shape, is_garment })
    }
}

/// Adds a trim to the options of a garment, unless they have it.
fn add(options: &mut Map<String, Json>, trim: &Path) {
    let name = trim.as_str().trim_start_matches('/').replace('/', "_");
    let trims = options.entry("trim").or_insert_with(|| Json::Object(Map::new()));
    if let Json::Object(trims) = trims {
        trims.entry(name).or_insert_with(|| json!({ "prims": [trim.as_str()] }));
    }
}
