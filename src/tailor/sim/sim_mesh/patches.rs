//! Patches of a mesh that are remeshed in parallel: each fits the cache, and none sees another.
//!
//! Vertices on the borders of patches are fixed, so the parts fit together again, and the result is the same for any number
//! of threads. A later pass over the whole mesh edits what is left along the borders.

use super::{SimMesh, VertexConstraint};
use crate::sim::baseline::Baseline;
use rayon::prelude::*;
use std::collections::VecDeque;
use tailor_mesh::connectivity::edit::{EditMesh, corners, face, prev};
use tailor_mesh::connectivity::{CornerId, FaceId, IdVec, JoinedMesh, VertexId, WedgeId, join_meshes};

/// Triangles of a patch. Larger patches have fewer border edges; smaller ones fit a core's cache better and balance the
/// load better.
pub const PATCH_SIZE: usize = 4096;

/// The role of a vertex in its patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PatchVertex {
    /// In this patch alone.
    #[default]
    Interior,
    /// On the border, shared with other patches.
    Border,
    /// On the border more than once.
    Pinched,
}

/// The triangles of each patch, and for each triangle its patch and its index there.
struct Patches {
    faces: Vec<Vec<FaceId>>,
    index: IdVec<FaceId, Option<(u32, u32)>>,
}

/// Runs `work` on patches of about `size` triangles. Returns its results; none, with the mesh unchanged, if the patches
/// cannot be joined again or have more than `max_faces` triangles together.
pub fn in_patches<'a, T: Send>(
    mesh: &mut SimMesh<'a>,
    size: usize,
    max_faces: usize,
    work: impl Fn(&mut SimMesh<'a>) -> T + Sync,
) -> Option<Vec<T>> {
    let patches = Patches::new(&mesh.topology, size);
    let whole = &*mesh;
    let done = (0..patches.faces.len()).into_par_iter().map(|i| {
        let (mut patch, names) = whole.patch(&patches, i);
        let result = work(&mut patch);
        let old = patch.reorder();
        (patch, old.iter().map(|v| names.get(v.index()).copied().flatten()).collect(), result)
    });
    let done: Vec<(SimMesh<'a>, Names, T)> = done.collect();
    if done.iter().map(|(patch, ..)| patch.topology.face_count()).sum::<usize>() > max_faces {
        return None;
    }
    let parts: Vec<(&EditMesh, &Names)> = done.iter().map(|(patch, names, _)| (&patch.topology, names)).collect();
    let joined = join_meshes(&parts, mesh.topology.vertex_slots())?;
    let patches: Vec<&SimMesh<'a>> = done.iter().map(|(patch, ..)| patch).collect();
    let constraint = |i: usize, v: VertexId| done[i].1[v].map_or(patches[i].constraint[v], |v| mesh.constraint[v]);
    *mesh = SimMesh::joined(joined, &patches, constraint, mesh.baseline);
    Some(done.into_iter().map(|(_, _, result)| result).collect())
}

/// The vertices of the whole mesh behind those that a patch shares.
type Names = IdVec<VertexId, Option<VertexId>>;

impl Patches {
    /// Grows patches over edges, each from the first triangle that is in none.
    fn new(topology: &EditMesh, size: usize) -> Self {
        let mut index: IdVec<FaceId, Option<(u32, u32)>> = IdVec::filled(None, topology.face_slots());
        let mut faces = Vec::new();
        for seed in topology.faces() {
            if index[seed].is_some() {
                continue;
            }
            let number = faces.len() as u32;
            let (mut own, mut queue) = (Vec::new(), VecDeque::from([seed]));
            while let Some(f) = queue.pop_front().filter(|_| own.len() < size) {
                if index[f].is_some() {
                    continue;
                }
                index[f] = Some((number, own.len() as u32));
                own.push(f);
                queue.extend(corners(f).filter_map(|c| topology.twin(c)).map(face));
            }
            faces.push(own);
        }
        Self { faces, index }
    }
}

impl<'a> SimMesh<'a> {
    /// A patch with its border fixed, and the vertices of the whole mesh there.
    fn patch(&self, patches: &Patches, number: usize) -> (Self, Names) {
        let index = |f: FaceId| patches.index[f].filter(|p| p.0 as usize == number).map(|p| p.1 as usize);
        let part = self.topology.submesh(&patches.faces[number], index);
        let (topology, old_vertex) = (&part.mesh, &part.old_vertex);
        let mut names = IdVec::filled(None, old_vertex.len());
        for c in topology.corners().filter(|&c| topology.twin(c).is_none()) {
            if self.topology.twin(part.old_corner[c]).is_some() {
                [topology.vertex(c), topology.target(c)].into_iter().for_each(|v| names[v] = Some(old_vertex[v]));
            }
        }
        let mut shared: Vec<(VertexId, VertexId)> = names.enumerated().filter_map(|(v, n)| Some(((*n)?, v))).collect();
        shared.sort_unstable();
        let mut patch = self.submesh(part);
        patch.patch_vertices = IdVec::filled(PatchVertex::Interior, patch.points.len());
        for same in shared.chunk_by(|a, b| a.0 == b.0) {
            for &(_, v) in same {
                patch.patch_vertices[v] = if same.len() > 1 { PatchVertex::Pinched } else { PatchVertex::Border };
                patch.constraint[v] = VertexConstraint::Fixed;
            }
        }
        (patch, names)
    }

    /// Joins patches; `constraint` is that of a patch's vertex in the whole mesh.
    fn joined(
        joined: JoinedMesh,
        patches: &[&Self],
        constraint: impl Fn(usize, VertexId) -> VertexConstraint,
        baseline: &'a Baseline,
    ) -> Self {
        let JoinedMesh { mesh: topology, old_vertex, seams, shared } = joined;
        let mut mesh = Self {
            points: old_vertex.iter().map(|&(i, v)| patches[i].points[v]).collect(),
            target: old_vertex.iter().map(|&(i, v)| patches[i].target[v]).collect(),
            constraint: old_vertex.iter().map(|&(i, v)| constraint(i, v)).collect(),
            corner_span: IdVec::with_capacity(topology.corner_slots()),
            corner_wedge: IdVec::with_capacity(topology.corner_slots()),
            wedges: IdVec::with_capacity(patches.iter().map(|p| p.wedges.len()).sum()),
            ..Self::empty(baseline, topology)
        };
        for patch in patches {
            let (spans, wedges) = (mesh.spans.len(), mesh.wedges.len());
            mesh.corner_span.extend(patch.corner_span.iter().map(|s| s.map(|s| s.shifted(spans))));
            mesh.corner_wedge.extend(patch.corner_wedge.iter().map(|s| WedgeId::new(wedges + s.index())));
            mesh.spans.extend_from_slice(&patch.spans);
            mesh.wedges.extend_from_slice(&patch.wedges);
        }
        // Both sides of a seam have copies of the same span and wedges; one of them stays.
        for [half, _] in seams {
            if let Some(span) = mesh.corner_span[half] {
                mesh.set_span(half, span);
            }
        }
        let mut sector = Vec::new();
        for vertex in shared {
            for corner in mesh.topology.fan(vertex).collect::<Vec<_>>() {
                mesh.sector(corner, &mut sector);
                let first = sector.iter().map(|&c| mesh.corner_wedge[c]).min();
                first.into_iter().for_each(|wedge| mesh.corner_wedge[corner] = wedge);
            }
        }
        mesh
    }

    fn patch_vertex(&self, vertex: VertexId) -> PatchVertex {
        self.patch_vertices.get(vertex.index()).copied().unwrap_or_default()
    }

    /// Whether an edge is on the border of a patch, shared with other patches.
    pub fn is_patch_border(&self, half: CornerId) -> bool {
        self.topology.twin(half).is_none()
            && self.topology.ends(half).iter().all(|&v| self.patch_vertex(v) != PatchVertex::Interior)
    }

    /// Whether a new edge between two vertices cannot also arise in another patch.
    pub fn may_connect(&self, a: VertexId, b: VertexId) -> bool {
        match (self.patch_vertex(a), self.patch_vertex(b)) {
            (PatchVertex::Pinched, _) | (_, PatchVertex::Pinched) => false,
            (a, b) => a == PatchVertex::Interior || b == PatchVertex::Interior,
        }
    }

    /// Whether collapsing an end of an edge into the other makes only such edges.
    pub fn may_merge(&self, half: CornerId, removed: VertexId) -> bool {
        if self.patch_vertices.is_empty() {
            return true;
        }
        let kept = self.topology.other_end(half, removed);
        let apexes = [Some(half), self.topology.twin(half)].map(|h| h.map(|h| self.topology.vertex(prev(h))));
        self.topology.ring(removed).all(|v| v == kept || apexes.contains(&Some(v)) || self.may_connect(kept, v))
    }
}
