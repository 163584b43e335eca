//! The simulation mesh that a cache moves, and the meshes that are bound to it at all levels of detail.

use super::DriveOptions;
use crate::codes;
use crate::names;
use crate::read::{
    OrUnreadable, Selection, StageOrigin, all_prims, choices_of, composition, has_points, prim_at, property_names,
};
use openusd::sdf::Path;
use openusd::usd::{PrimPredicate, Stage};
use std::path::Path as FilePath;
use tailor_mesh::error::Error;

/// A mesh that is bound to a simulation mesh.
#[derive(Clone)]
pub struct BoundMesh {
    pub path: Path,
    pub sim: Path,
    /// The level of detail of that simulation mesh, by which the binding is named.
    pub level: u32,
}

/// The simulation mesh and the bound meshes that are driven.
pub struct Chosen {
    /// The simulation mesh.
    pub sim: Path,
    /// The meshes that are bound to it, at least one.
    pub meshes: Vec<BoundMesh>,
    /// Whether the options name one of them.
    is_one: bool,
    /// The stage that has them.
    pub origin: StageOrigin,
}

impl Chosen {
    /// The stage with the meshes that the options choose. A mesh of a level of detail that is not selected is chosen by its path.
    ///
    /// # Errors
    /// As [`Chosen::new`].
    pub fn open(options: &DriveOptions) -> Result<(Stage, Self), Error> {
        let origin = StageOrigin::new(&options.render, None, &[]);
        let choose = |stage: &Stage| Ok((stage.clone(), Self::new(stage, options, &origin)));
        let (stage, chosen) = origin.with_stage(choose, |(_, chosen)| chosen.as_ref().err())?;
        let error = match chosen {
            Ok(chosen) => return Ok((stage, chosen)),
            Err(error) => error,
        };
        let wanted = options.prim.as_ref().and_then(|wanted| Path::new(wanted).ok());
        let choices = wanted.and_then(|wanted| levels_above(&stage, &wanted).ok()).unwrap_or_default();
        for choice in choices {
            let stage = StageOrigin { variants: vec![choice], ..origin.clone() }.open()?;
            if let Ok(chosen) = Self::new(&stage, options, &origin) {
                return Ok((stage, chosen));
            }
        }
        Err(error)
    }

    /// The meshes of a stage that the options choose.
    ///
    /// # Errors
    /// None, or several simulation meshes.
    pub fn new(stage: &Stage, options: &DriveOptions, origin: &StageOrigin) -> Result<Self, Error> {
        let all = bound_meshes(stage, &options.render, false)?;
        let file = options.render.display();
        let listed = |paths: &[&Path]| paths.iter().map(|path| path.as_str()).collect::<Vec<_>>().join(", ");
        let of_sim = |sim: &Path| Self {
            sim: sim.clone(),
            meshes: all.iter().filter(|mesh| mesh.sim == *sim).cloned().collect(),
            is_one: false,
            origin: origin.clone(),
        };
        if let Some(wanted) = &options.prim {
            if let Some(mesh) = all.iter().find(|mesh| mesh.sim.as_str() == wanted) {
                return Ok(of_sim(&mesh.sim));
            }
            let found = all.iter().find(|mesh| mesh.path.as_str() == wanted);
            let one = |mesh: &BoundMesh| Self {
                sim: mesh.sim.clone(),
                meshes: vec![mesh.clone()],
                is_one: true,
                origin: origin.clone(),
            };
            if let Some(error) = in_instance(stage, &options.render)?.filter(|_| found.is_none()) {
                return Err(error);
            }
            return found.map(one).ok_or_else(|| {
                let mut bound: Vec<&Path> = all.iter().map(|mesh| &mesh.path).collect();
                bound.dedup();
                Error::usd(format!("{wanted} of {file} is not bound to a simulation mesh"))
                    .code(codes::NOT_BOUND)
                    .remedy(format!("the bound meshes are: {}", listed(&bound)))
            });
        }
        // The simulation mesh of the first level of detail stands for those of all.
        let mut sims: Vec<&Path> = Vec::new();
        for mesh in all.iter().filter(|mesh| mesh.level == 0) {
            if !sims.contains(&&mesh.sim) {
                sims.push(&mesh.sim);
            }
        }
        match sims.as_slice() {
            [one] => Ok(of_sim(one)),
            [] => Err(in_instance(stage, &options.render)?.unwrap_or_else(|| {
                let faults = composition(stage, &options.render);
                let why = faults.iter().next().map(|fault| format!("; {}", fault.problem)).unwrap_or_default();
                Error::usd(format!("{file} has no mesh that is bound to a simulation mesh{why}"))
                    .code(codes::NOT_BOUND)
                    .remedy("build both meshes with `usdtailor build` of this version")
            })),
            _ => Err(Error::usd(format!("{file} has {} simulation meshes, each with bound meshes", sims.len()))
                .code(codes::SEVERAL_MESHES)
                .remedy(format!("choose one by --prim: {}", listed(&sims)))),
        }
    }

    /// The meshes that are bound to the same simulation mesh in variants of levels of detail that are not selected, each with a
    /// stage that selects it.
    ///
    /// # Errors
    /// A stage that cannot be read.
    pub fn other_levels(&self, stage: &Stage, options: &DriveOptions) -> Result<Vec<(Stage, Vec<BoundMesh>)>, Error> {
        let choices = if self.is_one { Vec::new() } else { levels_above(stage, &self.sim)? };
        let mut found = Vec::new();
        let mut known: Vec<Path> = self.meshes.iter().map(|mesh| mesh.path.clone()).collect();
        for choice in choices {
            let stage = StageOrigin { variants: vec![choice], ..self.origin.clone() }.open()?;
            let mut meshes = bound_meshes(&stage, &options.render, false)?;
            meshes.retain(|mesh| mesh.sim == self.sim && !known.contains(&mesh.path));
            known.extend(meshes.iter().map(|mesh| mesh.path.clone()));
            if !meshes.is_empty() {
                found.push((stage, meshes));
            }
        }
        Ok(found)
    }
}

/// The levels of detail of the prim above a mesh.
fn levels_above(stage: &Stage, mesh: &Path) -> Result<Vec<Selection>, Error> {
    match mesh.parent().filter(|parent| *parent != Path::abs_root()) {
        Some(parent) => choices_of(&prim_at(stage, &parent)?, names::LOD),
        None => Ok(Vec::new()),
    }
}

/// The error of a stage whose bound meshes are inside instances; none of others.
fn in_instance(stage: &Stage, file: &FilePath) -> Result<Option<Error>, Error> {
    let Some(mesh) = bound_meshes(stage, file, true)?
        .into_iter()
        .map(|mesh| mesh.path)
        .find(|path| prim_at(stage, path).is_ok_and(|prim| prim.is_instance_proxy().is_ok_and(|is_proxy| is_proxy)))
    else {
        return Ok(None);
    };
    let mut above = mesh.ancestors_below_root().skip(1);
    let is_instance = |path: &Path| prim_at(stage, path).is_ok_and(|prim| prim.is_instance().is_ok_and(|is| is));
    let instance = above.find(is_instance).unwrap_or_else(|| mesh.clone());
    let text = format!("{mesh} is inside the instance {instance}, whose points no layer can move");
    Ok(Some(Error::usd(text).code(codes::INSIDE_INSTANCE).remedy(format!(
        "set instanceable = false on {instance} in the shot, or drive the garment's own file and refer to the result"
    ))))
}

/// The bound meshes of a stage, once for each simulation mesh.
fn bound_meshes(stage: &Stage, file: &FilePath, in_instances: bool) -> Result<Vec<BoundMesh>, Error> {
    let mut found = Vec::new();
    for path in all_prims(stage, file, PrimPredicate::DEFAULT, in_instances)? {
        let prim = prim_at(stage, &path)?;
        if !has_points(&prim)? {
            continue;
        }
        let properties = property_names(&prim)?;
        for level in 0.. {
            let [.., target] = names::binding(level);
            if !properties.contains(&target) {
                break;
            }
            let targets = prim.relationship(target.as_str()).targets().or_unreadable(&path)?;
            found.extend(targets.into_iter().next().map(|sim| BoundMesh { path: path.clone(), sim, level }));
        }
    }
    Ok(found)
}
