//! The up axis and the unit of a cache whose stage has others than the garment's.

use super::bound::MeshAtBind;
use super::cache::Frame;
use crate::names;
use crate::values::text;
use glam::Vec3;
use openusd::sdf::Value;
use tailor_mesh::garment::Units;

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
        Self::new(field(names::UP_AXIS), field(names::METERS_PER_UNIT))
    }

    /// Those of a stage that has an axis called `Y` or `Z`.
    pub fn stated(up_axis: &str, meters_per_unit: f64) -> Self {
        let up_axis = Some(if up_axis == "Z" { UpAxis::Z } else { UpAxis::Y });
        Self { up_axis, meters_per_unit: Some(meters_per_unit) }
    }

    /// The up axis and the unit of the values of their fields.
    pub fn new(up_axis: Option<&Value>, meters_per_unit: Option<&Value>) -> Self {
        let up_axis = up_axis.and_then(|axis| match text(axis)? {
            "Y" => Some(UpAxis::Y),
            "Z" => Some(UpAxis::Z),
            _ => None,
        });
        let meters_per_unit = match meters_per_unit {
            Some(Value::Double(meters)) if *meters > 0.0 && meters.is_finite() => Some(*meters),
            _ => None,
        };
        Self { up_axis, meters_per_unit }
    }
}

/// What takes points of a cache to the space of the garment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Conversion {
    /// The up axis of the garment's stage, where the cache's has the other one.
    up_axis: Option<UpAxis>,
    /// Units of the garment's stage for one of the cache's.
    scale: Option<f32>,
}

impl Conversion {
    /// The conversion between two stages, as far as it brings `first` nearer to the garment at bind. Some programs scale and turn
    /// the mesh by its transform, and leave its points as they are.
    pub fn new(cache: StageMetrics, mesh: &MeshAtBind, first: &Frame) -> Self {
        let own = mesh.metrics;
        let up = own.up_axis.unwrap_or(UpAxis::Y);
        let meters = own.meters_per_unit.unwrap_or(Units::default().meters_per_unit);
        let scale = cache.meters_per_unit.map(|of_cache| (of_cache / meters) as f32).filter(|&scale| {
            let ratio = mesh.median_edge(&first.points) / mesh.edge_length;
            let [before, after] = [ratio, ratio * f64::from(scale)].map(|ratio| ratio.ln().abs());
            scale != 1.0 && after < before
        });
        let scaled = Self { up_axis: None, scale };
        let turned = Self { up_axis: Some(up), scale };
        let is_other = cache.up_axis.is_some_and(|axis| axis != up);
        let is_nearer = || turned.distance(&first.points, mesh) < scaled.distance(&first.points, mesh);
        if is_other && is_nearer() { turned } else { scaled }
    }

    fn place(self, v: Vec3) -> Vec3 {
        let v = match self.up_axis {
            Some(UpAxis::Y) => Vec3::new(v.x, v.z, -v.y),
            Some(UpAxis::Z) => Vec3::new(v.x, -v.z, v.y),
            None => v,
        };
        self.scale.map_or(v, |scale| v * scale)
    }

    /// The sum of squared distances to the points at bind.
    fn distance(self, points: &[Vec3], mesh: &MeshAtBind) -> f64 {
        points.iter().zip(&mesh.points).map(|(p, b)| f64::from(self.place(*p).distance_squared(*b))).sum()
    }

    /// Takes a frame to the space of the garment.
    pub fn apply(self, frame: &mut Frame) {
        if self != Self::default() {
            let vectors = frame.points.iter_mut().chain(frame.velocities.iter_mut().flatten());
            vectors.for_each(|v| *v = self.place(*v));
        }
    }

    /// What it does, in words; nothing where points stay.
    pub fn in_words(self) -> Vec<String> {
        let turned =
            self.up_axis.map(|_| "turned from the up axis of the cache's stage to that of the garment's".to_owned());
        let scaled = self
            .scale
            .map(|scale| format!("scaled by {scale} from the unit of the cache's stage to that of the garment's"));
        turned.into_iter().chain(scaled).collect()
    }
}
