//! Moves the render mesh with a simulated cache.
//!
//! Each vertex of the simulation mesh turns and moves rigidly from its bind pose. A bound point takes the blend of the three
//! corners of its triangle. Along the surface the blend is Phong tessellation (Boubekeur and Alexa 2008), so that a bent
//! mesh does not show its triangles; off the surface it is one rotation, so that hems keep their thickness.
//!
//! ```
//! use tailor_costume::drive::{BindPose, Driver};
//! use tailor::glam::{Vec3, vec3};
//!
//! # fn main() -> Result<(), tailor::Error> {
//! let sim = [Vec3::ZERO, Vec3::X, Vec3::Y];
//! let driver = Driver::new(&BindPose {
//!     sim_points: &sim,
//!     triangles: &[[0, 1, 2]],
//!     points: &[vec3(0.25, 0.25, 0.1)],
//!     faces: &[0],
//!     coords: &[vec3(0.5, 0.25, 0.1)],
//! })?;
//! // A quarter turn about the x axis.
//! let frame = driver.points(&[Vec3::ZERO, Vec3::X, Vec3::Z]);
//! assert!(frame[0].distance(vec3(0.25, -0.1, 0.25)) < 1e-6);
//! # Ok(())
//! # }
//! ```

mod frames;

use crate::codes;
pub use frames::BindFrames;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use std::sync::Arc;
use tailor_mesh::error::{Error, ErrorKind};

/// Share of the corners' tangent planes in the surface. A half gives the height of a surface of constant curvature; less lets the
/// layers of crumpled hems cross, more stretches their edges.
const PHONG_SHARE: f32 = 0.6;

/// Length of a blend of rotations below which they oppose each other.
const LEAST_BLEND: f32 = 1e-6;

/// Two meshes at bind, and the places of the points of the second on the first.
#[derive(Clone, Copy, Debug)]
pub struct BindPose<'a> {
    /// Points of the simulation mesh.
    pub sim_points: &'a [Vec3],
    /// Its triangles.
    pub triangles: &'a [[u32; 3]],
    /// Points of the bound mesh.
    pub points: &'a [Vec3],
    /// The triangle of each bound point.
    pub faces: &'a [u32],
    /// The weights of the triangle's first and second corner at each bound point. The third number, the height, is not used:
    /// the bind pose has the whole offset.
    pub coords: &'a [Vec3],
}

/// A bound point.
struct Bound {
    corners: [u32; 3],
    weights: [f32; 3],
    /// The point of the triangle less each corner, at bind.
    around: [Vec3; 3],
    /// The point less that of the triangle, at bind.
    offset: Vec3,
}

/// Moves bound points.
pub struct Driver {
    frames: Arc<BindFrames>,
    bound: Vec<Bound>,
}

impl Driver {
    /// A driver of a bind pose.
    ///
    /// # Errors
    /// Numbers of points, triangles and places that do not fit.
    pub fn new(pose: &BindPose<'_>) -> Result<Self, Error> {
        Self::sharing(&Arc::new(BindFrames::new(pose.sim_points, pose.triangles)?), pose)
    }

    /// As [`Driver::new`], with the frames of the same simulation mesh at bind, which other drivers share.
    pub fn sharing(frames: &Arc<BindFrames>, pose: &BindPose<'_>) -> Result<Self, Error> {
        let count = pose.points.len();
        if pose.faces.len() != count || pose.coords.len() != count {
            let (faces, coords) = (pose.faces.len(), pose.coords.len());
            return Err(fault(format!("{count} points have {faces} faces and {coords} coordinates")));
        }
        if let Some(face) = pose.faces.iter().find(|&&face| face as usize >= pose.triangles.len()) {
            return Err(fault(format!("face {face} is beyond the {} triangles", pose.triangles.len())));
        }
        let bound = |i: usize| {
            let corners = pose.triangles[pose.faces[i] as usize];
            let weights = [pose.coords[i].x, pose.coords[i].y, 1.0 - pose.coords[i].x - pose.coords[i].y];
            let at = corners.map(|v| pose.sim_points[v as usize]);
            let place: Vec3 = at.iter().zip(weights).map(|(&p, w)| w * p).sum();
            Bound { corners, weights, around: at.map(|p| place - p), offset: pose.points[i] - place }
        };
        Ok(Self { frames: Arc::clone(frames), bound: (0..count).into_par_iter().map(bound).collect() })
    }

    /// Number of points of the simulation mesh.
    pub fn sim_points(&self) -> usize {
        self.frames.vertices()
    }

    /// The bound points, with the simulation mesh at `sim`, which has as many points as at bind.
    pub fn points(&self, sim: &[Vec3]) -> Vec<Vec3> {
        self.points_by(sim, &self.frames.rotations(sim))
    }

    /// As [`Driver::points`], by the rotations of the simulation mesh's vertices from bind.
    pub fn points_by(&self, sim: &[Vec3], rotations: &[Quat]) -> Vec<Vec3> {
        self.bound.par_iter().map(|bound| bound.at(sim, rotations)).collect()
    }

    /// The rotation of each bound point from bind, by those of the simulation mesh's vertices.
    pub fn rotations_by(&self, rotations: &[Quat]) -> Vec<Quat> {
        self.bound.par_iter().map(|bound| bound.turn(rotations)).collect()
    }

    /// Directions that turn with bound points, by the rotations of the simulation mesh's vertices from bind: `directions` at bind, each
    /// with the number of its point in `of`.
    pub fn directions_by(&self, rotations: &[Quat], directions: &[Vec3], of: &[u32]) -> Vec<Vec3> {
        let turned = |(direction, &point): (&Vec3, &u32)| self.bound[point as usize].turn(rotations) * *direction;
        directions.par_iter().zip(of).map(turned).collect()
    }
}

impl Bound {
    fn at(&self, sim: &[Vec3], rotations: &[Quat]) -> Vec3 {
        let (mut place, mut raised) = (Vec3::ZERO, Vec3::ZERO);
        for k in 0..3 {
            let corner = self.corners[k] as usize;
            place += self.weights[k] * sim[corner];
            raised += self.weights[k] * (rotations[corner] * self.around[k]);
        }
        place + PHONG_SHARE * raised + self.turn(rotations) * self.offset
    }

    /// The blend of the rotations of the corners. A rotation and its negative are the same.
    fn turn(&self, rotations: &[Quat]) -> Quat {
        let turns = self.corners.map(|v| rotations[v as usize]);
        let signed = |k: usize| if turns[k].dot(turns[0]) < 0.0 { -self.weights[k] } else { self.weights[k] };
        let sum = turns[0] * signed(0) + turns[1] * signed(1) + turns[2] * signed(2);
        let length = sum.length();
        if length > LEAST_BLEND { sum * (1.0 / length) } else { turns[0] }
    }
}

/// The error of a bind pose whose parts do not fit.
fn fault(text: String) -> Error {
    Error::new(ErrorKind::Mesh, "binding", text).code(codes::STALE_BINDING).remedy("build the garment again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    /// A bent strip of triangles.
    fn strip() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let points = (0..12).map(|i| vec3((i / 2) as f32, (i % 2) as f32, ((i / 2) as f32 * 0.7).sin())).collect();
        let triangles = (0..10).map(|i| if i % 2 == 0 { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] }).collect();
        (points, triangles)
    }

    fn driver(sim: &[Vec3], triangles: &[[u32; 3]], points: &[Vec3]) -> Driver {
        let faces: Vec<u32> = (0..points.len() as u32).map(|i| i % triangles.len() as u32).collect();
        let coords = vec![vec3(0.3, 0.5, 0.0); points.len()];
        let pose = BindPose { sim_points: sim, triangles, points, faces: &faces, coords: &coords };
        Driver::new(&pose).expect("a good pose")
    }

    #[test]
    fn bound_points_stay_at_bind_and_follow_rigid_motion() {
        let (sim, triangles) = strip();
        let points: Vec<Vec3> = (0..20).map(|i| vec3(i as f32 * 0.3, 0.4, 0.2 * (i % 3) as f32)).collect();
        let driver = driver(&sim, &triangles, &points);
        let close = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).all(|(a, b)| a.distance(*b) < 5e-6);
        assert!(close(&driver.points(&sim), &points));
        let turn = Quat::from_axis_angle(vec3(1.0, 2.0, -0.5).normalize(), 2.5);
        let moved = |points: &[Vec3]| points.iter().map(|&p| turn * p + vec3(3.0, -1.0, 2.0)).collect::<Vec<_>>();
        assert!(close(&driver.points(&moved(&sim)), &moved(&points)));
    }

    #[test]
    fn layers_at_one_place_keep_their_distance() {
        let (sim, triangles) = strip();
        let at = sim[triangles[4][0] as usize];
        let pose = BindPose {
            sim_points: &sim,
            triangles: &triangles,
            points: &[at, at + vec3(0.0, 0.0, 0.25)],
            faces: &[4, 4],
            coords: &[vec3(0.2, 0.3, 0.0); 2],
        };
        let driver = Driver::new(&pose).expect("a good pose");
        let bent: Vec<Vec3> = sim.iter().map(|p| vec3(p.x.sin() * 2.0, p.y * 1.2, p.x.cos() * 2.0 + p.z)).collect();
        let moved = driver.points(&bent);
        assert!((moved[0].distance(moved[1]) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn points_at_one_place_move_as_one() {
        let (sim, triangles) = strip();
        let points: Vec<Vec3> = (0..8).map(|i| vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let (faces, coords) = ([3; 8], [vec3(0.2, 0.3, 0.0); 8]);
        let pose =
            BindPose { sim_points: &sim, triangles: &triangles, points: &points, faces: &faces, coords: &coords };
        let driver = Driver::new(&pose).expect("a good pose");
        let bent: Vec<Vec3> = sim.iter().map(|p| vec3(p.x.sin() * 2.0, p.y * 1.2, p.x.cos() * 2.0 + p.z)).collect();
        let (moved, turns) = (driver.points(&bent), driver.rotations_by(&driver.frames.rotations(&bent)));
        for (a, b) in (0..8).flat_map(|a| (0..8).map(move |b| (a, b))) {
            assert!((moved[a] - moved[b]).distance(turns[0] * (points[a] - points[b])) < 1e-5);
        }
    }

    #[test]
    fn places_that_do_not_fit_are_refused() {
        let pose =
            BindPose { sim_points: &[Vec3::ZERO; 3], triangles: &[[0, 1, 3]], points: &[], faces: &[], coords: &[] };
        assert!(Driver::new(&pose).is_err());
        let pose =
            BindPose { triangles: &[[0, 1, 2]], points: &[Vec3::ZERO], faces: &[1], coords: &[Vec3::ZERO], ..pose };
        assert!(Driver::new(&pose).is_err());
    }
}
