//! The space of a driven mesh in that of the simulation mesh.

use crate::read::transforms;
use glam::{DMat3, DMat4, DQuat, DVec3, Quat, Vec3};
use openusd::usd::{Prim, TimeCode};
use tailor_mesh::error::Error;

/// The transform from a mesh to the simulation mesh.
#[derive(Clone, Copy, Debug)]
pub struct Space {
    to_sim: DMat4,
    from_sim: DMat4,
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
        let to_sim = of_sim.inverse() * own;
        let from_sim = to_sim.inverse();
        if !to_sim.is_finite() || !from_sim.is_finite() {
            let text = format!("{} has a transform to the simulation mesh that flattens it", mesh.path());
            return Err(Error::usd(text)
                .code(tailor_costume::codes::STALE_BINDING)
                .remedy("give it scales that are not 0"));
        }
        Ok(Some(Self { to_sim, from_sim }))
    }

    /// Points of the mesh in the space of the simulation mesh.
    pub fn points_to_sim(&self, points: &[Vec3]) -> Vec<Vec3> {
        points.iter().map(|p| self.to_sim.transform_point3(p.as_dvec3()).as_vec3()).collect()
    }

    /// Takes points back to the space of the mesh.
    pub fn points_from_sim(&self, points: &mut [Vec3]) {
        points.iter_mut().for_each(|p| *p = self.from_sim.transform_point3(p.as_dvec3()).as_vec3());
    }

    /// Takes velocities back to the space of the mesh.
    pub fn velocities_from_sim(&self, velocities: &mut [Vec3]) {
        velocities.iter_mut().for_each(|v| *v = self.from_sim.transform_vector3(v.as_dvec3()).as_vec3());
    }

    /// A rotation of the simulation mesh's space as one of the mesh's own.
    pub fn rotation_from_sim(&self, rotation: Quat) -> Quat {
        let [to_sim, from_sim] = [self.to_sim, self.from_sim].map(DMat3::from_mat4);
        let turned = from_sim * DMat3::from_quat(rotation.as_dquat()) * to_sim;
        // A scale that is not uniform leaves no rotation; the nearest in the order of the axes stands for it.
        let x = turned.x_axis.normalize_or(DVec3::X);
        let y = turned.y_axis.reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
        DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).as_quat()
    }

    /// Takes normals of the mesh to the space of the simulation mesh.
    pub fn normals_to_sim(&self, normals: &mut [Vec3]) {
        turn(normals, &self.from_sim);
    }

    /// Takes normals back to the space of the mesh.
    pub fn normals_from_sim(&self, normals: &mut [Vec3]) {
        turn(normals, &self.to_sim);
    }
}

/// Takes normals to the space from which `back` leads.
fn turn(normals: &mut [Vec3], back: &DMat4) {
    let transposed = DMat3::from_mat4(*back).transpose();
    normals.iter_mut().for_each(|n| *n = (transposed * n.as_dvec3()).normalize_or_zero().as_vec3());
}
