//! The up axis of a cache whose stage has another one than the garment's.

use super::cache::Frame;
use crate::usd::values::text;
use glam::Vec3;
use openusd::sdf::Value;

/// The name of the metadata.
pub const UP_AXIS: &str = "upAxis";

/// The up axis of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    Y,
    Z,
}

impl UpAxis {
    /// The axis that metadata states.
    pub fn of(metadata: &[(String, Value)]) -> Option<Self> {
        metadata.iter().find(|(key, _)| key == UP_AXIS).and_then(|(_, value)| Self::named(value))
    }

    /// The axis of a value.
    pub fn named(value: &Value) -> Option<Self> {
        match text(value)? {
            "Y" => Some(Self::Y),
            "Z" => Some(Self::Z),
            _ => None,
        }
    }

    /// A vector of a stage with the other axis in a stage with this one.
    fn turned(self, v: Vec3) -> Vec3 {
        match self {
            Self::Y => Vec3::new(v.x, v.z, -v.y),
            Self::Z => Vec3::new(v.x, -v.z, v.y),
        }
    }

    /// Turns a frame to a stage with this axis.
    pub fn turn(self, frame: &mut Frame) {
        let vectors = frame.points.iter_mut().chain(frame.velocities.iter_mut().flatten());
        vectors.for_each(|v| *v = self.turned(*v));
    }

    /// Whether points of a stage with the other axis are nearer to those at bind if they are turned. Some programs turn the
    /// mesh by its transform, and leave its points as they are.
    pub fn fits(self, points: &[Vec3], bind: &[Vec3]) -> bool {
        let distance = |place: &dyn Fn(Vec3) -> Vec3| -> f64 {
            points.iter().zip(bind).map(|(p, b)| f64::from(place(*p).distance_squared(*b))).sum()
        };
        distance(&|p| self.turned(p)) < distance(&|p| p)
    }
}
