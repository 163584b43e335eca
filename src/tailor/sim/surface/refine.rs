//! Refinement of the manifold cage.

use super::manifold::Manifold;
use glam::Vec3;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::garment::{Interpolation, Mesh, Primvar};
use tailor_mesh::subdivide::{Channel, ChannelChild, Level, Numbering, Real, Stencils, blend_rows};

/// The refined levels of a cage, and positions on the last.
pub struct RefinedLevels {
    /// The levels after the cage.
    pub levels: Vec<Level>,
    /// Positions on the last level. \[mesh units\]
    pub points: IdVec<VertexId, Vec3>,
    /// The channel of the constraint UVs on the last level.
    pub uv_channel: Option<Channel>,
    /// The values of that channel.
    pub uvs: Vec<[f32; 2]>,
    /// The cage's face behind each face, on every level from the cage on.
    pub cage_faces: Vec<IdVec<FaceId, FaceId>>,
}

impl Manifold {
    /// Adds the constraint UVs as a face-varying channel of the cage; returns the channel's values.
    pub fn add_uv_channel(&mut self, garment: &Mesh, uv: &Primvar) -> Vec<[f32; 2]> {
        let rows = uv.shell_rows(&garment.faces, garment.points.len());
        let (rules, row) = (garment.rules, |c| rows[self.corner_source[c]] as usize);
        let (channel, rows) = Channel::base(&self.level, row, rules.face_varying, rules.boundary);
        self.uv_channel = Some(channel);
        rows.iter().map(|&row| uv.uv(row).as_vec2().to_array()).collect()
    }

    /// Refines the cage `count` times; `uvs` are the values of its channel, if it has one.
    pub fn refine(&self, garment: &Mesh, mut uvs: Vec<[f32; 2]>, count: u32) -> RefinedLevels {
        let mut points: Vec<[f32; 3]> = self.vertex_source.iter().map(|&v| garment.points[v].to_array()).collect();
        let mut levels: Vec<Level> = Vec::new();
        let mut uv_channel = self.uv_channel.clone();
        let mut cage_faces: Vec<IdVec<FaceId, FaceId>> = vec![self.level.topology.faces.ids().collect()];
        for depth in 0..count as usize {
            let parent = levels.last().unwrap_or(&self.level);
            let child = parent.refined();
            points = parent.vertex_stencils().apply(&points);
            if let Some(channel) = &mut uv_channel {
                let refined = ChannelChild::new(parent, channel);
                uvs = refined.apply(&uvs);
                *channel = refined.into_channel(&child);
            }
            let (numbering, parent_faces) = (Numbering::new(parent), &parent.topology.faces);
            let cage_face = |f| cage_faces[depth][numbering.parent_face(parent_faces, f)];
            cage_faces.push(child.topology.faces.ids().map(cage_face).collect());
            levels.push(child);
        }
        RefinedLevels { levels, points: points.into_iter().map(Vec3::from).collect(), uv_channel, uvs, cage_faces }
    }

    /// The cage and all of `levels` but the last: those that are refined.
    pub fn parents<'a>(&'a self, levels: &'a [Level]) -> impl Iterator<Item = &'a Level> {
        std::iter::once(&self.level).chain(levels).take(levels.len())
    }

    /// The rows of a vertex or varying primvar at the vertices of the last of `levels`. `values` are the primvar's.
    pub fn refine_rows<T: Real>(&self, levels: &[Level], primvar: &Primvar, values: &[T]) -> Vec<T> {
        let width = primvar.width();
        let row = |v: &VertexId| values[primvar.row(v.index()) * width..][..width].iter().copied();
        let cage = self.vertex_source.iter().flat_map(row).collect();
        self.parents(levels).fold(cage, |rows: Vec<T>, parent| {
            let stencils = match primvar.interpolation {
                Interpolation::Varying => parent.varying_stencils(),
                _ => parent.vertex_stencils(),
            };
            blend_rows(&stencils, &rows, primvar)
        })
    }
}

/// The faces of a garment that are holes.
pub fn holes(garment: &Mesh, level: &Level) -> IdVec<FaceId, bool> {
    let mut is_hole = IdVec::filled(false, garment.faces.len());
    garment.holes.iter().copied().chain(level.border_holes(garment)).for_each(|f| is_hole[f] = true);
    is_hole
}
