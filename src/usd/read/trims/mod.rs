//! Prims that ride on cloth: meshes, curves, points and PointInstancers.

mod found;

pub use found::{PlacedMesh, take};

use crate::codes;
use crate::read::choose::{check_instance, prims_below};
use crate::read::model::Model;
use crate::read::query::{OrUnreadable, is_below_product, prim_at, value, vectors};
use crate::read::source::Source;
use crate::read::space::transforms;
use crate::{names, on_large_stack};
use glam::{DMat4, Vec3};
use openusd::sdf::{Path, Value, ValueTypeName};
use openusd::usd::{Prim, PrimPredicate, Stage, TimeCode};
use std::collections::{BTreeMap, HashSet};
use std::path::Path as FilePath;
use tailor_costume::trim::{Ride, TrimOptions, TrimShape};
use tailor_mesh::error::{Error, Warning, Warnings};

/// Types of curves, which have the numbers of their points in `curveVertexCounts`.
const CURVES: [&str; 3] = ["BasisCurves", "NurbsCurves", "HermiteCurves"];
/// Other types with points.
const WITH_POINTS: [&str; 5] = [names::MESH, names::POINT_INSTANCER, "Points", "NurbsPatch", "TetMesh"];
/// Types of shapes that have no points.
const WITHOUT_POINTS: [&str; 8] = ["Sphere", "Cube", "Cylinder", "Capsule", "Cone", "Plane", "Cylinder_1", "Capsule_1"];

/// Attributes of the types of UsdGeom that follow from points, beside the extent and what instances have anew.
const DEPENDENT: [&str; 9] = [
    names::NORMALS,
    "primvars:normals",
    "primvars:normals:indices",
    names::TANGENTS,
    names::VELOCITIES,
    names::ACCELERATIONS,
    "angularVelocities",
    names::ORIENTATIONS_F,
    "extentsHint",
];

/// A prim that rides on cloth.
#[derive(Clone, Debug)]
pub struct TrimPrim {
    /// Its path.
    pub path: Path,
    /// Its points, in its own space.
    pub shape: TrimShape,
    /// From its own space to the stage's.
    pub to_world: DMat4,
}

/// A trim that a garment on another body takes along.
#[derive(Debug)]
pub struct FittedTrim {
    /// Path of its prim.
    pub path: Path,
    /// The name of its options in the recipe.
    pub name: String,
    /// Its distance from the garment, on average. \[mesh units\]
    pub distance: f32,
    /// How it rides.
    pub ride: Ride,
    /// The warning that it is away from the garment.
    pub off_cloth: Option<Warning>,
    /// Its points there, in its own space.
    pub points: Vec<Vec3>,
    /// From its own space to the stage's.
    pub to_world: DMat4,
    /// The attributes that change, by name and type. A block is for one that holds no more.
    pub values: Vec<(String, ValueTypeName, Value)>,
}

/// The name of the attribute with the points that cloth moves.
pub fn points_name(prim: &Prim) -> Result<&'static str, Error> {
    Ok(if type_of(prim)? == names::POINT_INSTANCER { names::POSITIONS } else { names::POINTS })
}

/// The authored attributes of a prim that are of its points at one time, besides its extent, with their types.
///
/// # Errors
/// A stage that cannot be queried.
pub fn dependent_attributes(prim: &Prim) -> Result<Vec<(String, ValueTypeName)>, Error> {
    let mut found = Vec::new();
    for name in DEPENDENT {
        let attribute = prim.attribute(name);
        if attribute.has_authored_value().or_unreadable(prim.path())? {
            let kind = attribute.type_name().or_unreadable(prim.path())?;
            found.extend(kind.map(|kind| (name.to_owned(), kind)));
        }
    }
    Ok(found)
}

/// Whether a prim has points that cloth can move.
pub fn has_points(prim: &Prim) -> Result<bool, Error> {
    let kind = type_of(prim)?;
    let kind = kind.as_str();
    Ok(WITH_POINTS.contains(&kind) || CURVES.contains(&kind))
}

/// The trims at and below a prim, with their values at a time.
///
/// # Errors
/// A prim that is not there, or that holds nothing with points. `key` is the option that names it.
pub fn trims(
    stage: &Stage,
    file: &FilePath,
    key: &str,
    root: &Path,
    time: Option<TimeCode>,
) -> Result<(Vec<TrimPrim>, Warnings), Error> {
    let fault = |text: String| Error::recipe(key, text).code(tailor_mesh::codes::WRONG_PRIM);
    if !prim_at(stage, root)?.is_valid().or_unreadable(root)? {
        let text = format!("{root} is not a prim of {}", file.display());
        return Err(fault(text).remedy("name a mesh, curves, points or a PointInstancer of the stage"));
    }
    let (mut found, mut warnings) = (Vec::new(), Warnings::default());
    let below = prims_below(stage, root, file, PrimPredicate::DEFAULT, false)?;
    let instances = Instances::of(stage, &below)?;
    for path in below.into_iter().filter(|path| !instances.move_along(path)) {
        let prim = prim_at(stage, &path)?;
        if prim.is_instance().or_unreadable(&path)? {
            let problem = "it is an instance, in which no layer moves points";
            warnings.push(Warning::not_carried(&path, problem).remedy("Set instanceable = false on it"));
        } else if WITHOUT_POINTS.contains(&type_of(&prim)?.as_str()) {
            let problem = format!("it is a {}, which has no points that cloth could move", type_of(&prim)?);
            warnings.push(Warning::not_carried(&path, problem).remedy("Make it a mesh"));
        } else if has_points(&prim)? && !is_below_product(stage, &path)? {
            match check_instance(&prim).and_then(|()| TrimPrim::read(&prim, time)) {
                Ok(trim) if trim.shape.points.is_empty() => {}
                Ok(trim) => found.push(trim),
                Err(error) => warnings.push(Warning::unread(&path, &error)),
            }
        }
    }
    if found.is_empty() && warnings.is_empty() {
        let text = format!("{root} has no points, and nothing below it has");
        return Err(fault(text).remedy("name a mesh, curves, points or a PointInstancer of the stage"));
    }
    Ok((found, warnings))
}

/// The PointInstancers among some prims, and their prototypes.
struct Instances {
    instancers: HashSet<Path>,
    prototypes: HashSet<Path>,
}

impl Instances {
    fn of(stage: &Stage, prims: &[Path]) -> Result<Self, Error> {
        let mut found = Self { instancers: HashSet::new(), prototypes: HashSet::new() };
        for path in prims {
            let prim = prim_at(stage, path)?;
            if type_of(&prim)? == names::POINT_INSTANCER {
                found.prototypes.extend(prim.relationship("prototypes").targets().or_unreadable(path)?);
                found.instancers.insert(path.clone());
            }
        }
        Ok(found)
    }

    /// Whether a prim moves with instances.
    fn move_along(&self, prim: &Path) -> bool {
        let moves = |above: Path| self.instancers.contains(&above) || self.prototypes.contains(&above);
        self.prototypes.contains(prim) || prim.strict_ancestors_below_root().any(moves)
    }
}

impl Source {
    /// The trims of some options with how they ride on this garment, of the size `size`. \[mesh units\]
    ///
    /// # Errors
    /// A prim that is not there, or that has no points.
    pub fn trims(&self, options: &BTreeMap<String, TrimOptions>, size: f32) -> Result<Vec<(String, Ride)>, Error> {
        let mut found = Vec::new();
        if options.is_empty() {
            return Ok(found);
        }
        on_large_stack(|| {
            let stage = self.model.origin.open()?;
            for (name, options) in options {
                for named in &options.prims {
                    let key = format!("trim.{name}.prims");
                    let root = trim_path(&self.model, &key, named)?;
                    let (all, _) = trims(&stage, &self.model.origin.file, &key, &root, None)?;
                    let ride = |trim: &TrimPrim| trim.beside(&self.model).ride(options.mode, size);
                    found.extend(all.iter().map(|trim| (trim.path.to_string(), ride(trim))));
                }
            }
            Ok(found)
        })
    }
}

/// The path of what an option names as trims: absolute, or beside the model.
///
/// # Errors
/// The garment itself. `key` is the option.
pub fn trim_path(model: &Model, key: &str, named: &str) -> Result<Path, Error> {
    let beside = model.path.parent().unwrap_or_else(|| model.parent.clone());
    let relative = || beside.append_path(named);
    let root = Path::new(named).ok().filter(Path::is_abs).or_else(|| relative().ok()).unwrap_or(beside.clone());
    match model.panels.iter().find(|panel| panel.has_prefix(&root)) {
        Some(panel) => Err(Error::recipe(key, format!("{root} has {panel}, the garment itself"))
            .code(tailor_mesh::codes::WRONG_PRIM)
            .remedy("name what rides on it")),
        None => Ok(root),
    }
}

/// Whether trims with this option `on` may ride on a model.
pub fn is_on(model: &Model, on: &str) -> bool {
    on.is_empty() || model.panels.iter().any(|panel| panel.as_str() == on)
}

fn type_of(prim: &Prim) -> Result<String, Error> {
    Ok(prim.type_name().or_unreadable(prim.path())?.map(|name| name.as_str().to_owned()).unwrap_or_default())
}

impl TrimPrim {
    /// Its shape in the space of a model and of its products.
    pub fn beside(&self, model: &Model) -> TrimShape {
        let to_model = model.transforms.to_world.inverse() * self.to_world;
        let points = self.shape.points.iter().map(|p| to_model.transform_point3(p.as_dvec3()).as_vec3()).collect();
        self.shape.with_points(points, to_model.determinant().abs().cbrt() as f32)
    }

    fn read(prim: &Prim, time: Option<TimeCode>) -> Result<Self, Error> {
        let to_world = transforms(prim, time)?.to_world;
        if !to_world.inverse().is_finite() {
            return Err(Error::usd(format!("{} has a transform that flattens it", prim.path()))
                .remedy("give it scales that are not 0"));
        }
        let points = vectors(prim, points_name(prim)?, time).map_err(|e| without_time(&e))?.unwrap_or_default();
        if let Some(at) = points.iter().position(|point| !point.is_finite()) {
            return Err(
                Error::usd(format!("{}: point {at} is not finite", prim.path())).code(tailor_mesh::codes::NOT_FINITE)
            );
        }
        let kind = type_of(prim)?;
        let shape = if kind == names::MESH {
            let (counts, corners) = (sizes(prim, names::FACE_VERTEX_COUNTS)?, sizes(prim, names::FACE_VERTEX_INDICES)?);
            if let Some(corner) = corners.iter().position(|&vertex| vertex >= points.len()) {
                let text = format!("{}: corner {corner} names a point beyond its {}", prim.path(), points.len());
                return Err(Error::usd(text).code(tailor_mesh::codes::INDEX_OUT_OF_RANGE));
            }
            let corners: Vec<u32> = corners.into_iter().map(|vertex| vertex as u32).collect();
            TrimShape::of_mesh(points, &counts, &corners)
        } else if CURVES.contains(&kind.as_str()) {
            TrimShape::of_parts(points, sizes(prim, names::CURVE_VERTEX_COUNTS)?)
        } else {
            let count = points.len();
            let is_whole = ["NurbsPatch", "TetMesh"].contains(&kind.as_str());
            TrimShape::of_parts(points, if is_whole { vec![count] } else { vec![1; count] })
        };
        Ok(Self { path: prim.path().clone(), shape, to_world })
    }
}

/// The error of points that cannot be read, where it is that they have no value without a time: the bind pose has none.
fn without_time(error: &Error) -> Error {
    if error.faults.iter().any(|fault| fault.code == codes::NO_DEFAULT_VALUE) {
        return Error::usd("its points have values at times alone, and none for the bind pose")
            .code(codes::NO_DEFAULT_VALUE)
            .remedy("author the points of the bind pose without a time");
    }
    error.clone()
}

/// Whole numbers from 0; a negative one is beyond all.
fn sizes(prim: &Prim, name: &str) -> Result<Vec<usize>, Error> {
    Ok(match value(prim, name, None)? {
        Some(Value::IntVec(values)) => values.iter().map(|&n| usize::try_from(n).unwrap_or(usize::MAX)).collect(),
        _ => Vec::new(),
    })
}
