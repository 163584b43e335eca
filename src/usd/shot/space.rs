//! The spaces of a cache, of the simulation mesh and of the meshes that it drives, which may move over time.

use super::bound::BoundPrim;
use super::cache::rates;
use crate::read::{is_moving, transforms};
use glam::{DMat3, DMat4, DQuat, DVec3, Quat, Vec3};
use openusd::sdf::Value;
use openusd::usd::{Prim, TimeCode};
use std::fmt::Display;
use tailor_mesh::error::{Error, ErrorKind};

/// Time codes of a second where a stage does not say, as in USD.
pub const TIME_CODES: f64 = 24.0;
/// Half of the time in which a moving transform is measured. \[time codes\]
const STEP: f64 = 0.01;

/// From the space of a prim to that of its stage, over time.
#[derive(Clone, Default)]
pub struct Motion {
    pub at_bind: DMat4,
    /// The prim, where its transform moves.
    pub moving: Option<Prim>,
}

impl Motion {
    /// The transforms of a prim. `time` is that of the bind pose.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn of(prim: &Prim, time: Option<TimeCode>) -> Result<Self, Error> {
        let moving = is_moving(prim)?.then(|| prim.clone());
        Ok(Self { at_bind: transforms(prim, time)?.to_world, moving })
    }

    /// The transform at a time.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn at(&self, time: f64) -> Result<DMat4, Error> {
        match &self.moving {
            Some(prim) => Ok(transforms(prim, Some(TimeCode::new(time)))?.to_world),
            None => Ok(self.at_bind),
        }
    }
}

/// The times of a shot in seconds and in the garment's stage, which the shot has as a sublayer.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Time codes of a second of the shot.
    per_second: f64,
    /// Time codes of the garment's stage for one of the shot.
    pub garment: f64,
}

impl Clock {
    /// The clock of a shot over a stage with some metadata. `cache` has the values of [`RATE`] that the cache states.
    pub fn new(cache: [Option<f64>; 2], metadata: &[(String, Value)]) -> Self {
        let stated = rates(metadata);
        let rate =
            |[frames, codes]: [Option<f64>; 2]| codes.or(frames).filter(|rate| *rate > 0.0).unwrap_or(TIME_CODES);
        let per_second = rate([0, 1].map(|i| cache[i].or(stated[i])));
        Self { per_second, garment: rate(stated) / per_second }
    }
}

/// What takes points from one space to another at one time.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    by: DMat4,
    /// The change of `by`, if it changes. \[1/second\]
    change: Option<DMat4>,
}

impl Passage {
    /// The passage by a matrix to the space of `place`.
    ///
    /// # Errors
    /// A matrix that flattens.
    fn new(by: DMat4, place: impl Display) -> Result<Self, Error> {
        if by.is_finite() && by.inverse().is_finite() {
            return Ok(Self { by, change: None });
        }
        let fault = Error::new(ErrorKind::Usd, place, "a transform flattens it or the simulation mesh");
        Err(fault.code(tailor_costume::codes::STALE_BINDING).remedy("give it scales that are not 0"))
    }

    /// The passage by `matrix` at a time, at which `motions` may move.
    ///
    /// # Errors
    /// As [`Passage::new`].
    pub fn at<'a>(
        time: f64,
        clock: Clock,
        motions: impl IntoIterator<Item = &'a Motion>,
        place: impl Display,
        matrix: impl Fn(f64) -> Result<DMat4, Error>,
    ) -> Result<Self, Error> {
        let passage = Self::new(matrix(time)?, place)?;
        if motions.into_iter().all(|motion| motion.moving.is_none()) {
            return Ok(passage);
        }
        let [behind, ahead] = [passage.by - matrix(time - STEP)?, matrix(time + STEP)? - passage.by];
        // Before its first sample and after its last, a transform stays: what it does on the other side counts.
        let mean = match [behind, ahead].map(|side| side == DMat4::ZERO) {
            [true, _] => ahead,
            [_, true] => behind,
            _ => (behind + ahead) * 0.5,
        };
        Ok(Self { change: Some(mean * (clock.per_second / STEP)), ..passage })
    }

    /// Takes points to the other space, and their velocities.
    pub fn points(&self, points: &mut [Vec3], velocities: Option<&mut Vec<Vec3>>) {
        if self.by == DMat4::IDENTITY && self.change.is_none() {
            return;
        }
        for (velocity, point) in velocities.into_iter().flatten().zip(&*points) {
            let carried = self.change.map_or(DVec3::ZERO, |change| (change * point.as_dvec3().extend(1.0)).truncate());
            *velocity = (self.by.transform_vector3(velocity.as_dvec3()) + carried).as_vec3();
        }
        points.iter_mut().for_each(|p| *p = self.by.transform_point3(p.as_dvec3()).as_vec3());
    }

    /// Takes tangents to the other space.
    pub fn tangents(&self, tangents: &mut [Vec3]) {
        tangents.iter_mut().for_each(|t| *t = self.by.transform_vector3(t.as_dvec3()).as_vec3());
    }

    /// Takes normals to the other space.
    pub fn normals(&self, normals: &mut [Vec3]) {
        let turn = DMat3::from_mat4(self.by.inverse()).transpose();
        normals.iter_mut().for_each(|n| *n = (turn * n.as_dvec3()).normalize_or_zero().as_vec3());
    }
}

/// The space of a driven mesh beside that of the simulation mesh.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    /// At bind.
    pub to_sim: Passage,
    /// At the time of the frame.
    pub from_sim: Passage,
}

impl Space {
    /// The space of `mesh` at a time; none if it is that of the simulation mesh, which `of_sim` takes to that of the stage.
    ///
    /// # Errors
    /// A transform that flattens one of them.
    pub fn between(mesh: &Prim, of_sim: DMat4, time: Option<TimeCode>) -> Result<Option<Self>, Error> {
        let own = transforms(mesh, time)?.to_world;
        if own == of_sim {
            return Ok(None);
        }
        let to_sim = Passage::new(of_sim.inverse() * own, mesh.path())?;
        Ok(Some(Self { to_sim, from_sim: Passage { by: to_sim.by.inverse(), change: None } }))
    }

    /// A rotation of the simulation mesh's space as one of the mesh's own.
    pub fn rotation_from_sim(&self, rotation: Quat) -> Quat {
        let [to_sim, from_sim] = [self.to_sim, self.from_sim].map(|passage| DMat3::from_mat4(passage.by));
        let turned = from_sim * DMat3::from_quat(rotation.as_dquat()) * to_sim;
        // A scale that is not uniform leaves no rotation; the nearest in the order of the axes stands for it.
        let x = turned.x_axis.normalize_or(DVec3::X);
        let y = turned.y_axis.reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
        DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).as_quat()
    }
}

/// The motions of a simulation mesh and of the meshes that it drives.
pub struct Motions {
    pub sim: Motion,
    pub meshes: Vec<Motion>,
}

impl Motions {
    /// The spaces of driven meshes at a time of the shot.
    ///
    /// # Errors
    /// A transform that flattens one of them.
    pub fn spaces(&self, meshes: &[BoundPrim], time: f64, clock: Clock) -> Result<Vec<Option<Space>>, Error> {
        let space = |(mesh, motion): (&BoundPrim, &Motion)| {
            let is_still = motion.moving.is_none() && self.sim.moving.is_none();
            let [own, sim] = [motion, &self.sim].map(|motion| motion.at(time * clock.garment));
            if is_still || (mesh.space.is_none() && own? == sim?) {
                return Ok(mesh.space);
            }
            let matrix = |time| Ok(motion.at(time * clock.garment)?.inverse() * self.sim.at(time * clock.garment)?);
            let from_sim = Passage::at(time, clock, [motion, &self.sim], &mesh.path, matrix)?;
            let own = Passage { by: DMat4::IDENTITY, change: None };
            Ok(Some(Space { to_sim: mesh.space.map_or(own, |space| space.to_sim), from_sim }))
        };
        meshes.iter().zip(&self.meshes).map(space).collect()
    }
}
