//! The names that dialects of USD physics give to the same things, in one table.
//!
//! - `aousd`: the deformable proposal of the Alliance for OpenUSD (OpenUSD-proposals, pull request 111), read by Newton 1.8.
//! - `omni`: `OmniPhysics` and `PhysxSchema` of Omniverse (PyPI: physx-usd-schemas).
//! - `chaos` has other concepts, which `chaos.rs` writes.

use openusd::sdf::ValueTypeName;

/// The names of a dialect with a deformable body, a simulation mesh and a material.
pub struct Dialect {
    /// Its name in `cloth.physics`.
    pub name: &'static str,
    /// Namespace of attributes and relationships.
    pub space: &'static str,
    /// Schemas of the prim above both meshes.
    pub body: &'static [&'static str],
    /// Schemas of the simulation mesh.
    pub sim: &'static [&'static str],
    /// The multiple-apply schema of poses, and the namespace of its instance.
    pub pose: (&'static str, &'static str),
    /// Purposes of the pose of the simulation mesh.
    pub sim_purposes: &'static [&'static str],
    /// Rest triangles.
    pub rest_triangles: &'static str,
    /// Whether the rest shape may have other points than the mesh.
    pub free_rest: bool,
    /// The token by which the rest shape gives rest angles.
    pub rest_angles: &'static str,
    /// Schemas of the material.
    pub material: &'static [&'static str],
    /// Whether thickness is on the material instead of the mesh.
    pub thickness_on_material: bool,
    /// The names of attachments.
    pub attachment: Attachments,
    /// The type of collision filters.
    pub filter: &'static str,
    /// Whether element indices are unsigned.
    pub unsigned: bool,
}

/// Names of attachments of vertices to transforms and to triangles.
pub struct Attachments {
    /// Types of the prims, to a transform and to triangles.
    pub types: [&'static str; 2],
    /// The kinds of both ends, where attributes state them.
    pub kinds: Option<[&'static str; 2]>,
    /// Indices of vertices.
    pub vertices: &'static str,
    /// Positions in the frame of a transform, and their type.
    pub positions: (&'static str, ValueTypeName),
    /// Indices of triangles.
    pub triangles: &'static str,
    /// Coordinates on triangles.
    pub coords: &'static str,
}

impl Dialect {
    /// The attribute of a mesh's points in the bind pose.
    pub fn pose_points(&self) -> String {
        format!("{}points", self.pose.1)
    }
}

/// The dialects.
pub static DIALECTS: [Dialect; 2] = [
    Dialect {
        name: "aousd",
        space: "physics:",
        body: &["PhysicsDeformableBodyAPI"],
        sim: &["PhysicsSurfaceDeformableSimAPI", "PhysicsCollisionAPI"],
        pose: ("PhysicsDeformablePoseAPI:default", "physics:deformablePose:default:"),
        sim_purposes: &["bindPose"],
        rest_triangles: "restTriVertexIndices",
        free_rest: true,
        rest_angles: "restShape",
        material: &["PhysicsMaterialAPI", "PhysicsSurfaceDeformableMaterialAPI"],
        thickness_on_material: false,
        attachment: Attachments {
            types: ["PhysicsAttachment", "PhysicsAttachment"],
            kinds: Some(["xform", "face"]),
            vertices: "indices0",
            positions: ("coords1", ValueTypeName::VECTOR3F_ARRAY),
            triangles: "indices1",
            coords: "coords1",
        },
        filter: "PhysicsElementCollisionFilter",
        unsigned: false,
    },
    Dialect {
        name: "omni",
        space: "omniphysics:",
        body: &["OmniPhysicsDeformableBodyAPI", "PhysxSurfaceDeformableBodyAPI"],
        sim: &["OmniPhysicsSurfaceDeformableSimAPI", "PhysicsCollisionAPI"],
        pose: ("OmniPhysicsDeformablePoseAPI:default", "deformablePose:default:omniphysics:"),
        sim_purposes: &["bindPose", "selfCollisionFilterPose"],
        rest_triangles: "restTriVtxIndices",
        free_rest: false,
        rest_angles: "restShapeDefault",
        material: &[
            "OmniPhysicsBaseMaterialAPI",
            "OmniPhysicsDeformableMaterialAPI",
            "OmniPhysicsSurfaceDeformableMaterialAPI",
        ],
        thickness_on_material: true,
        attachment: Attachments {
            types: ["OmniPhysicsVtxXformAttachment", "OmniPhysicsVtxTriAttachment"],
            kinds: None,
            vertices: "vtxIndicesSrc0",
            positions: ("localPositionsSrc1", ValueTypeName::POINT3F_ARRAY),
            triangles: "triIndicesSrc1",
            coords: "triCoordsSrc1",
        },
        filter: "OmniPhysicsElementCollisionFilter",
        unsigned: true,
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dialect_of_the_recipe_is_written() {
        let written: Vec<&str> = DIALECTS.iter().map(|dialect| dialect.name).chain(["chaos"]).collect();
        assert_eq!(written, tailor_costume::cloth::DIALECTS);
    }
}
