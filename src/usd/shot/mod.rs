//! Shots: a cache of the simulation mesh moves the render mesh, frame by frame.
//!
//! `bound` reads both meshes at bind from a built garment, `cache` the moved points from USD or NumPy files, and `stream` writes
//! the frames. `playback` plays a cache on meshes in memory. A few frames are in memory at a time, however long the cache is.
//! `fitted` moves trims with a garment that fits another body, as one frame of a shot.

mod bound;
mod cache;
mod chosen;
mod clips;
mod conversion;
mod crate_samples;
mod fitted;
mod numpy;
mod playback;
mod size;
mod space;
mod stream;

use crate::codes;
use crate::{names, on_large_stack};
use bound::{Bound, BoundPrim, MeshAtBind};
use cache::{Cache, Frame};
use conversion::Conversion;
use glam::{Quat, Vec3};
use openusd::gf::{Quath, Vec3f, f16};
use openusd::sdf::Value;
use rayon::prelude::*;
use size::check_size;
use space::{Clock, Space};
use std::iter;
use std::path::{Path, PathBuf};
use stream::ShotWriter;
use tailor_costume::drive::Driver;
use tailor_mesh::error::{Error, ErrorKind, Warnings};

pub use cache::{CacheFile, CacheSpace};
pub use conversion::StageMetrics;
pub use playback::Playback;

/// Frames that are in memory at a time, for each thread.
const FRAMES_PER_THREAD: usize = 2;
/// Ratio of the median edge length of the first frame to that at bind beyond which the points are of another mesh.
const MOST_STRETCH: f64 = 2.0;

/// A garment, the cache that drives it, and the shot.
#[derive(Clone, Debug, Default)]
pub struct DriveOptions {
    /// A garment that this program built.
    pub render: PathBuf,
    /// The cache.
    pub cache: CacheFile,
    /// The shot.
    pub output: PathBuf,
    /// Path of the mesh to drive, or of a simulation mesh for all that are bound to it; by default the only simulation mesh.
    pub prim: Option<String>,
    /// Drive the garment's own mesh too, or the panels of which it is sewn.
    pub model: bool,
    /// Write a file for each frame, and a layer that has them as value clips.
    pub clips: bool,
    /// Accept a cache with gaps between its frames.
    pub gaps: bool,
    /// Overwrite files that are there already.
    pub force: bool,
    /// Largest shot; by default 1,000 times the cache on the disk, and at least 1 GiB. A stage of several layers has no default.
    /// \[bytes\]
    pub max_size: Option<u64>,
}

/// The sizes of a shot.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// Frames.
    pub frames: usize,
    /// Points of all driven meshes.
    pub points: usize,
    /// How the points of the cache were taken from the up axis and unit of its stage to those of the garment's, in words.
    pub conversions: Vec<String>,
    /// First and last time. \[time codes\]
    pub times: [f64; 2],
    /// Doubts about the space of the cache.
    pub warnings: Warnings,
}

/// Drives the meshes of a built garment by a cache and writes the shot. `progress` hears the number of frames that are done, and of
/// all.
///
/// # Errors
/// Files that cannot be read or written; a mesh that is not bound; a cache of another mesh, with gaps or points that are not
/// finite. Nothing is written then.
pub fn drive(options: &DriveOptions, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Driven, Error> {
    on_large_stack(|| {
        let (bound, motions) = Bound::read(options)?;
        let file = &options.cache.file;
        let mut cache = Cache::open(&options.cache, &bound.sim)?;
        cache.check_times(options.gaps)?;
        check_size(options, &bound, &cache)?;
        let clock = Clock::new(cache.rate, &bound.metadata);
        let conversion = Conversion::new(&cache, options.cache.space, &bound.sim, motions.sim.clone(), clock);
        let mut writer = ShotWriter::new(options, &bound, &cache)?;
        let frames = cache.times().len();
        let chunk = FRAMES_PER_THREAD * rayon::current_num_threads();
        let (mut done, mut warnings) = (0, Warnings::default());
        warnings.extend(bound.notes.iter().chain(&cache.notes).cloned());
        while done < frames {
            let mut read: Vec<Frame> =
                (done..frames.min(done + chunk)).map(|i| cache.read(i)).collect::<Result<_, Error>>()?;
            if done == 0 {
                warnings.extend(conversion.doubt(file, &read[0], &bound.sim)?);
            }
            read.iter_mut().try_for_each(|frame| conversion.apply(frame))?;
            if done == 0 {
                check_first(&bound.sim, &read[0], file)?;
            }
            let spaces = read.iter().map(|frame| motions.spaces(&bound.meshes, frame.time, clock));
            let spaces = spaces.collect::<Result<Vec<_>, Error>>()?;
            let moved: Vec<Vec<DrivenPrim>> =
                read.par_iter().zip(&spaces).map(|(frame, spaces)| bound.moved(frame, spaces)).collect();
            for (frame, meshes) in read.iter().zip(&moved) {
                check_finite(frame.time, meshes, file)?;
                writer.write(frame.time, meshes)?;
                done += 1;
                progress(done, frames);
            }
        }
        writer.finish()?;
        let points = bound.meshes.iter().map(|mesh| mesh.points).sum();
        let times = [cache.times()[0], cache.times()[frames - 1]];
        Ok(Driven { frames, points, conversions: conversion.in_words(times[0])?, times, warnings })
    })
}

/// A driven prim at one time.
struct DrivenPrim {
    points: Vec<Vec3>,
    normals: Option<Vec<Vec3>>,
    velocities: Option<Vec<Vec3>>,
    /// Of Hermite curves.
    tangents: Option<Vec<Vec3>>,
    /// Rotations of instances, as they are and not from those at bind.
    orientations: Option<Vec<Quat>>,
    /// The name of the attribute of its points.
    points_name: &'static str,
    /// How far it reaches beyond its points; none if nobody says so.
    reach: Option<f32>,
}

impl DrivenPrim {
    /// The long arrays, with the names of their attributes.
    fn arrays(&self) -> impl Iterator<Item = (&'static str, &[Vec3])> {
        let others =
            [(names::NORMALS, &self.normals), (names::VELOCITIES, &self.velocities), (names::TANGENTS, &self.tangents)];
        let others = others.into_iter().filter_map(|(name, values)| Some((name, values.as_deref()?)));
        iter::once((self.points_name, self.points.as_slice())).chain(others)
    }

    /// The other values, with the names of their attributes.
    fn values(&self) -> impl Iterator<Item = (&'static str, Value)> {
        let half = |q: &Quat| Quath {
            w: f16::from_f32(q.w),
            x: f16::from_f32(q.x),
            y: f16::from_f32(q.y),
            z: f16::from_f32(q.z),
        };
        let orientations = self.orientations.as_ref().map(|all| Value::QuathVec(all.iter().map(half).collect()));
        let extent = self.reach.map(|reach| extent(&self.points, reach));
        extent
            .map(|value| (names::EXTENT, value))
            .into_iter()
            .chain(orientations.map(|value| (names::ORIENTATIONS, value)))
    }

    /// Both as values.
    fn all_values(&self) -> impl Iterator<Item = (&'static str, Value)> {
        let array = |values| Value::Vec3fVec(bytemuck::cast_slice::<Vec3, Vec3f>(values).to_vec());
        self.arrays().map(move |(name, values)| (name, array(values))).chain(self.values())
    }

    /// Takes the prim from the space of the simulation mesh to its own.
    fn take_from_sim(&mut self, space: &Space) {
        space.from_sim.points(&mut self.points, self.velocities.as_mut());
        self.normals.iter_mut().for_each(|normals| space.from_sim.normals(normals));
        self.tangents.iter_mut().for_each(|tangents| space.from_sim.tangents(tangents));
    }
}

/// The bounding box of points, and of what reaches beyond them.
fn extent(points: &[Vec3], reach: f32) -> Value {
    let mut corners = crate::write::extent(points);
    if let [low, high] = &mut corners[..] {
        let grown = |corner: &Vec3f, by: f32| Vec3f::from((Vec3::from(<[f32; 3]>::from(*corner)) + by).to_array());
        (*low, *high) = (grown(low, -reach), grown(high, reach));
    }
    Value::Vec3fVec(corners)
}

impl Bound {
    /// The meshes at a frame.
    fn moved(&self, frame: &Frame, spaces: &[Option<Space>]) -> Vec<DrivenPrim> {
        let rotations = self.frames.rotations(&frame.points);
        // The points are a smooth function of those of the cache; its derivative is a difference of near ones.
        let step = frame.velocities.as_deref().map(|velocities| (self.velocity_step(velocities), velocities));
        let near = step.map(|(step, velocities)| {
            let shifted = [-step, step].map(|by| {
                let sim: Vec<Vec3> = frame.points.iter().zip(velocities).map(|(p, v)| *p + by * *v).collect();
                let rotations = self.frames.rotations(&sim);
                (sim, rotations)
            });
            (step, shifted)
        });
        let velocities = |driver: &Driver| {
            let (step, shifted) = near.as_ref()?;
            let [before, after] = shifted.each_ref().map(|(sim, rotations)| driver.points_by(sim, rotations));
            Some(after.iter().zip(&before).map(|(a, b)| (*a - *b) / (2.0 * step)).collect())
        };
        let moved = |(mesh, space): (&BoundPrim, &Option<Space>)| {
            mesh.driven(&frame.points, &rotations, velocities(&mesh.driver), space.as_ref())
        };
        self.meshes.iter().zip(spaces).map(moved).collect()
    }

    /// A time in which no point moves by more than a small share of the mesh. \[seconds\]
    fn velocity_step(&self, velocities: &[Vec3]) -> f32 {
        let fastest = velocities.iter().map(|v| v.length()).fold(0.0, f32::max);
        if fastest > 0.0 { 0.01 * self.sim.edge_length as f32 / fastest } else { 1.0 }
    }
}

impl BoundPrim {
    /// The prim in `space`, with the simulation mesh at `sim`, whose vertices have turned by `rotations` from bind.
    fn driven(
        &self,
        sim: &[Vec3],
        rotations: &[Quat],
        velocities: Option<Vec<Vec3>>,
        space: Option<&Space>,
    ) -> DrivenPrim {
        let normals = self.normals.as_ref().map(|n| self.driver.directions_by(rotations, &n.values, &n.points));
        let orientations = self.orientations.as_ref().map(|at_bind| {
            let turns = self.driver.rotations_by(rotations);
            let own = turns.into_iter().map(|turn| space.map_or(turn, |space| space.rotation_from_sim(turn)));
            own.zip(at_bind).map(|(turn, at_bind)| (turn * *at_bind).normalize()).collect()
        });
        let turned = |tangents: &Vec<Vec3>| {
            self.driver
                .rotations_by(rotations)
                .into_iter()
                .zip(tangents)
                .map(|(turn, tangent)| turn * *tangent)
                .collect()
        };
        let tangents = self.tangents.as_ref().map(turned);
        let (points_name, reach) = (self.points_name, self.reach);
        let points = self.driver.points_by(sim, rotations);
        let mut driven = DrivenPrim { points, normals, velocities, tangents, orientations, points_name, reach };
        if let Some(space) = space {
            driven.take_from_sim(space);
        }
        driven
    }
}

/// Refuses a frame whose points are so far apart that those of the mesh, or their velocities, are beyond the numbers of a file.
fn check_finite(time: f64, meshes: &[DrivenPrim], file: &Path) -> Result<(), Error> {
    let mut arrays = meshes.iter().flat_map(DrivenPrim::arrays);
    if time.is_finite() && arrays.all(|(_, values)| values.iter().all(|value| value.is_finite())) {
        return Ok(());
    }
    let text = format!("frame {time} moves points to places or with velocities that are not finite");
    Err(Error::new(ErrorKind::Usd, file.display(), text).code(codes::CACHE_FRAMES).remedy("cache this frame again"))
}

/// Refuses a first frame whose edges have other lengths than at bind: its points are in another order.
fn check_first(mesh: &MeshAtBind, frame: &Frame, file: &Path) -> Result<(), Error> {
    let length = mesh.median_edge(&frame.points);
    let ratio = length / mesh.edge_length;
    if ratio.is_finite() && (1.0 / MOST_STRETCH..=MOST_STRETCH).contains(&ratio) {
        return Ok(());
    }
    let text = format!(
        "the median edge of {} is {length:.3} in the first frame and {:.3} at bind: its points are in another order or unit",
        mesh.path, mesh.edge_length
    );
    Err(Error::new(ErrorKind::Usd, file.display(), text)
        .code(codes::CACHE_MISMATCH)
        .remedy("cache the points of the simulation mesh as it was written"))
}
