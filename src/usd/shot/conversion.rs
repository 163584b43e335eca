//! From the points of a cache to those of the simulation mesh: up axes, units and transforms.

use super::bound::MeshAtBind;
use super::cache::{Cache, CacheSpace, Frame};
use super::space::{Clock, Motion, Passage};
use crate::codes;
use crate::names;
use crate::values::{number, text};
use glam::{DMat4, DVec3, DVec4};
use openusd::sdf::Value;
use std::path::Path;
use tailor_mesh::error::{Error, Warning};
use tailor_mesh::garment::Units;

/// How many times nearer to bind the first frame has to be in another space, to be doubted.
const DOUBTED: f64 = 2.0;

/// The up axis of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    Y,
    Z,
}

/// The up axis and the unit that a stage states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageMetrics {
    pub up_axis: Option<UpAxis>,
    pub meters_per_unit: Option<f64>,
}

impl StageMetrics {
    /// The up axis and the unit in the metadata of a stage.
    pub fn of(metadata: &[(String, Value)]) -> Self {
        let field = |name: &str| metadata.iter().find(|(key, _)| key == name).map(|(_, value)| value);
        let up_axis = field(names::UP_AXIS).and_then(|axis| match text(axis)? {
            "Y" => Some(UpAxis::Y),
            "Z" => Some(UpAxis::Z),
            _ => None,
        });
        let meters = field(names::METERS_PER_UNIT).and_then(number);
        let meters_per_unit = meters.filter(|meters| *meters > 0.0 && meters.is_finite());
        Self { up_axis, meters_per_unit }
    }

    /// These, or else what USD takes for what is not stated.
    fn or_usual(self) -> Self {
        Self {
            up_axis: self.up_axis.or(Some(UpAxis::Y)),
            meters_per_unit: self.meters_per_unit.or(Some(Units::default().meters_per_unit)),
        }
    }

    /// From this stage to another, as far as both state their up axes and units.
    pub fn to(self, other: Self) -> DMat4 {
        let scale = match (self.meters_per_unit, other.meters_per_unit) {
            (Some(from), Some(to)) => from / to,
            _ => 1.0,
        };
        let [y, z] = match (self.up_axis, other.up_axis) {
            (Some(UpAxis::Z), Some(UpAxis::Y)) => [DVec3::NEG_Z, DVec3::Y],
            (Some(UpAxis::Y), Some(UpAxis::Z)) => [DVec3::Z, DVec3::NEG_Y],
            _ => [DVec3::Y, DVec3::Z],
        };
        let [x, y, z] = [DVec3::X, y, z].map(|axis| (scale * axis).extend(0.0));
        DMat4::from_cols(x, y, z, DVec4::W)
    }
}

/// What takes points of a cache to the space of the simulation mesh.
#[derive(Clone)]
pub struct Conversion {
    /// From the stage of the cache to that of the garment.
    stages: DMat4,
    /// From the points of the cache to its stage; none where they are in the space of the simulation mesh.
    cache: Option<Motion>,
    /// From the simulation mesh to its stage.
    garment: Motion,
    /// Whether the user states the space.
    is_stated: bool,
    clock: Clock,
}

impl Conversion {
    /// The conversion of a cache to the space of `sim`, which `garment` moves. The space of its points is `stated`, or else what
    /// its file says, or else that of the simulation mesh.
    pub fn new(cache: &Cache, stated: Option<CacheSpace>, sim: &MeshAtBind, garment: Motion, clock: Clock) -> Self {
        let motion = match stated {
            Some(CacheSpace::World) => Some(Motion::default()),
            Some(CacheSpace::Local) => None,
            None => cache.motion.clone(),
        };
        let stages = cache.metrics.to(sim.metrics.or_usual());
        Self { stages, cache: motion, garment, is_stated: stated.is_some(), clock }
    }

    fn matrix(&self, time: f64) -> Result<DMat4, Error> {
        let Some(cache) = &self.cache else { return Ok(self.stages) };
        let [from, to] = [cache.at(time)?, self.garment.at(time * self.clock.garment)?];
        // Without the rounding of an inverse, points of one space stay as they are.
        let is_one = self.stages == DMat4::IDENTITY && from == to;
        Ok(if is_one { DMat4::IDENTITY } else { to.inverse() * self.stages * from })
    }

    /// Takes a frame to the space of the simulation mesh.
    ///
    /// # Errors
    /// A transform that flattens the garment.
    pub fn apply(&self, frame: &mut Frame) -> Result<(), Error> {
        let motions = self.cache.iter().flat_map(|cache| [cache, &self.garment]);
        let passage = Passage::at(frame.time, self.clock, motions, "the cache", |time| self.matrix(time))?;
        passage.points(&mut frame.points, frame.velocities.as_mut());
        Ok(())
    }

    /// The distance of the first frame from bind, as the root of the mean square.
    fn distance(&self, first: &Frame, sim: &MeshAtBind) -> Result<f64, Error> {
        let by = self.matrix(first.time)?;
        let apart = first.points.iter().zip(&sim.points);
        let sum: f64 = apart.map(|(p, b)| by.transform_point3(p.as_dvec3()).distance_squared(b.as_dvec3())).sum();
        Ok((sum / sim.points.len() as f64).sqrt())
    }

    /// The warning that the first frame is much nearer to bind without the turn of its up axis, or in the other space.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn doubt(&self, file: &Path, first: &Frame, sim: &MeshAtBind) -> Result<Option<Warning>, Error> {
        let own = self.distance(first, sim)?;
        let (mut nearest, mut cure) = (own / DOUBTED, String::new());
        let (other, flag) = match self.cache {
            Some(_) => (None, "give `--cache-space local`"),
            None => (Some(Motion::default()), "give `--cache-space world`"),
        };
        let axis = "correct `upAxis` of its stage";
        let unturned = DMat4::from_scale(DVec3::splat(self.stages.x_axis.x));
        for (stages, cache, words) in [
            (unturned, &self.cache, axis.to_owned()),
            (self.stages, &other, flag.to_owned()),
            (unturned, &other, format!("{axis} and {flag}")),
        ] {
            let apart = Self { stages, cache: cache.clone(), ..self.clone() }.distance(first, sim)?;
            if apart < nearest && !(self.is_stated && words.contains(flag)) {
                (nearest, cure) = (apart, words);
            }
        }
        if cure.is_empty() || own <= sim.edge_length {
            return Ok(None);
        }
        let problem = format!(
            "its first frame is {own:.3} mesh units from {} at bind, and would be {nearest:.3} in another space",
            sim.path
        );
        let warning = Warning::new(codes::CACHE_SPACE, file.display(), problem).amount(own as f32);
        Ok(Some(warning.remedy(format!("Where the garment should start at bind, {cure}"))))
    }

    /// What it does to the frame at `time`, in words; nothing where points stay.
    ///
    /// # Errors
    /// A stage that cannot be queried.
    pub fn in_words(&self, time: f64) -> Result<Vec<String>, Error> {
        let scale = self.stages.x_axis.x;
        let is_turned = self.stages != DMat4::from_scale(DVec3::splat(scale));
        let is_moved = self.matrix(time)? != self.stages;
        let words = [
            is_turned.then(|| "turned from the up axis of the cache's stage to that of the garment's".to_owned()),
            (scale != 1.0).then(|| format!("scaled by {scale} from the unit of the cache's stage to the garment's")),
            is_moved.then(|| "moved from the space of the cache to that of the simulation mesh".to_owned()),
        ];
        Ok(words.into_iter().flatten().collect())
    }
}
