//! Several meshes of a stage as garments: panels that are sewn together, and meshes of their own.

mod choose;
mod exclude;
mod laid;
mod model;
mod product_names;
mod recipe;

pub use choose::is_other;
pub use product_names::{LodSchema, ProductNames, level_name, product_names};

use super::origin::StageOrigin;
use super::query::prim_at;
use super::source::{ReadOptions, Source};
use super::surroundings::KnownSurroundings;
use super::trims;
use crate::codes;
use crate::on_large_stack;
use glam::DMat4;
use openusd::usd::{Stage, TimeCode};
use std::path::Path;
use std::sync::Arc;
use tailor_mesh::connectivity::{Elements, VertexId};
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::sew::{Seams, Unsewn, find_seams};
use tailor_mesh::garment::{Garment, check_garment};
use tailor_mesh::meter;

impl Source {
    /// Opens all garments of a stage: those below `options.prim` if that has several meshes below it, all if `options.all`, or else
    /// the one mesh that [`Source::open`] reads. Meshes whose borders coincide are sewn into one garment. Small ones that lie on a
    /// garment become a part of it. Garments are in the order of their first meshes; there is at least one.
    ///
    /// # Errors
    /// As [`Source::open`], for any of the meshes; panels that cannot be one mesh.
    pub fn open_all(path: &Path, options: &ReadOptions) -> Result<Vec<Self>, Error> {
        Self::all_of(&StageOrigin::new(path, None, &options.variants), options)
    }

    fn all_of(origin: &StageOrigin, options: &ReadOptions) -> Result<Vec<Self>, Error> {
        let may_be_several = options.all || options.prim.is_some() || !options.exclude.is_empty();
        if !may_be_several || options.time.is_some_and(|t| !t.is_finite()) {
            return Ok(vec![Self::of(origin, options)?]);
        }
        let read = |stage: &Stage| read(stage, origin, options);
        on_large_stack(|| origin.with_stage(read, |all| all.iter().find_map(|source| source.garment.as_ref().err())))
    }

    /// As [`Source::open_all`] for one garment, from `content`: a layer in memory (crate or text) to which another program
    /// flattened `file`. Relative paths in it are not resolved.
    ///
    /// # Errors
    /// As [`Source::open_all`]; several garments.
    pub fn from_layer(content: Arc<[u8]>, file: &Path, options: &ReadOptions) -> Result<Self, Error> {
        Self::only(Self::all_of(&StageOrigin::new(file, Some(content), &options.variants), options)?)
    }

    /// The one of several garments that there is.
    ///
    /// # Errors
    /// Several of them.
    pub fn only(mut garments: Vec<Self>) -> Result<Self, Error> {
        match garments.pop() {
            Some(one) if garments.is_empty() => Ok(one),
            last => {
                let names: Vec<&str> = garments.iter().chain(&last).map(Self::whole).collect();
                let file = garments.first().map(|garment| garment.file().display().to_string()).unwrap_or_default();
                Err(Error::usd(format!("{file} has {} garments, and one is wanted", names.len()))
                    .code(codes::SEVERAL_MESHES)
                    .remedy(format!("name one by --prim, or leave others out by --exclude: {}", names.join(", "))))
            }
        }
    }
}

fn read(stage: &Stage, origin: &StageOrigin, options: &ReadOptions) -> Result<Vec<Source>, Error> {
    let tolerance = options.tolerance()?;
    let Some((paths, left_out)) = choose::meshes(stage, &origin.file, options)? else {
        return Ok(vec![Source::of_stage(stage, origin.clone(), options)?]);
    };
    let time = options.time.map(TimeCode::new);
    let (mut sources, mut known) = (Vec::with_capacity(paths.len()), KnownSurroundings::default());
    for path in &paths {
        meter::check();
        sources.push(Source::of_mesh(stage, &prim_at(stage, path)?, origin.clone(), options, &mut known)?);
    }
    if sources.len() > 1 {
        check_panels(&mut sources)?;
        trims::take(stage, &mut sources)?;
    }
    sources[0].warnings.extend(left_out);
    // Nothing lies on a lone mesh, whose faults are those of its check.
    if sources.len() == 1 {
        return Ok(sources);
    }
    let seams = seams(&sources, tolerance)?;
    for unsewn in &seams.unsewn {
        let warning = unsewn_borders(unsewn, &sources, tolerance);
        sources[unsewn.panels[0]].warnings.push(warning);
    }
    laid::garments(stage, &mut sources, &seams, time)
}

/// Checks meshes before they are trims or parts of others, as faults name the elements of the mesh itself.
fn check_panels(sources: &mut [Source]) -> Result<(), Error> {
    for source in sources {
        let mesh = source.garment.as_mut().map_err(|fault| fault.clone())?;
        let (checked, _) = check_garment(mesh.clone())?;
        mesh.leave_out(&checked);
    }
    Ok(())
}

/// The seams between the meshes, in the space of the stage.
fn seams(sources: &[Source], tolerance: f64) -> Result<Seams, Error> {
    let mut meshes: Vec<(&Garment, DMat4)> = Vec::with_capacity(sources.len());
    for source in sources {
        let mesh = source.garment.as_ref().map_err(Clone::clone)?;
        meshes.push((mesh, source.model.transforms.to_world));
    }
    find_seams(&meshes, tolerance)
}

fn unsewn_borders(unsewn: &Unsewn, sources: &[Source], tolerance: f64) -> Warning {
    let [a, b] = unsewn.panels.map(|panel| sources[panel].prim());
    let [x, y, z] = unsewn.place;
    let problem = format!(
        "their borders run side by side near ({x:.3}, {y:.3}, {z:.3}) and are not sewn there: {} edges of the first and {} of \
         the second do not match within {tolerance} of the mean edge length",
        unsewn.edges[0].len(),
        unsewn.edges[1].len()
    );
    let edges = unsewn.edges[0].iter().map(|edge| edge.map(VertexId::new)).collect();
    Warning::new(tailor_mesh::codes::UNSEWN_BORDERS, format!("{a}, {b}"), problem)
        .at(Elements::Edges(edges))
        .remedy("Give both borders the same points, or raise --sew-tolerance")
}
