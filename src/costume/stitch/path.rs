//! A line on a surface by its length, with the frame of the surface at each place.

use glam::Vec3;
use tailor::render::{LimitSurface, SurfaceLine};

/// The least turn that is a corner: a needle goes down in it. \[cosine of the angle\]
const CORNER: f32 = 0.766;
/// Share of a stitch on both sides of a place, between which the line has its direction there.
const REACH: f32 = 0.25;

/// A line on a surface.
pub struct SurfacePath {
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The length up to each point. \[mesh units\]
    along: Vec<f32>,
    /// True if its last point is its first one.
    pub is_closed: bool,
}

/// The surface at a place of a path.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The place.
    pub point: Vec3,
    /// The outer normal.
    pub normal: Vec3,
    /// The direction to the left of the line.
    pub left: Vec3,
}

impl SurfacePath {
    /// The path of a line.
    pub fn new(line: &SurfaceLine, surface: &LimitSurface) -> Self {
        let closing = line.points.first().filter(|_| line.is_closed);
        let (points, normals): (Vec<_>, Vec<_>) = line.points.iter().chain(closing).map(|&at| surface.at(at)).unzip();
        let mut along = Vec::with_capacity(points.len());
        let mut length = 0.0;
        for (number, &point) in points.iter().enumerate() {
            length += number.checked_sub(1).map_or(0.0, |before| point.distance(points[before]));
            along.push(length);
        }
        Self { points, normals, along, is_closed: line.is_closed }
    }

    /// Its length. \[mesh units\]
    pub fn length(&self) -> f32 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// The lengths up to its corners.
    pub fn corners(&self) -> Vec<f32> {
        let turns = |at: &usize| {
            let [before, after] = [*at - 1, *at].map(|i| (self.points[i + 1] - self.points[i]).normalize_or_zero());
            before.dot(after) < CORNER
        };
        (1..self.points.len().saturating_sub(1)).filter(turns).map(|at| self.along[at]).collect()
    }

    /// The frame at a length, with the direction of a piece as long as `stitch` there. \[mesh units\]
    pub fn frame(&self, length: f32, stitch: f32) -> Frame {
        let (point, normal) = self.at(length);
        let [before, after] = [-REACH, REACH].map(|share| self.at(length + share * stitch).0);
        let left = normal.cross(after - before).normalize_or_zero();
        Frame { point, normal, left }
    }

    fn at(&self, length: f32) -> (Vec3, Vec3) {
        let whole = self.length();
        let length = if self.is_closed && whole > 0.0 { length.rem_euclid(whole) } else { length.clamp(0.0, whole) };
        let next = self.along.partition_point(|&along| along <= length).clamp(1, self.points.len() - 1);
        let [from, to] = [self.along[next - 1], self.along[next]];
        let share = if to > from { (length - from) / (to - from) } else { 0.0 };
        let normal = self.normals[next - 1].lerp(self.normals[next], share).normalize_or_zero();
        (self.points[next - 1].lerp(self.points[next], share), normal)
    }
}
