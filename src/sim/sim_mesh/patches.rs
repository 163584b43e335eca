//! Patches of a mesh that are worked on apart, at the same time: each fits the cache, and none sees another.
//!
//! What patches share stays as it is: vertices on their borders are sealed. So the parts fit together again, and the
//! result is the same for any number of threads. What was left along the borders is for a pass over the whole.

use crate::mesh::edit::{EditMesh, corners, face, prev};
use crate::mesh::{CornerId, FaceId, IdVec, Joined, VertexId, WedgeId, join};
use crate::sim::baseline::Baseline;
use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Triangles of a patch. Larger ones have fewer edges along their borders, smaller ones fit a core's cache better and
/// are shared out more evenly.
pub(crate) const PATCH: usize = 4096;

/// Whether a vertex is on the border of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum PatchVertex {
    /// Not shared.
    #[default]
    Open,
    /// Other patches have it too.
    Shared,
    /// The patch itself has it more than once.
    Pinched,
}

/// The triangles of each patch, and for each triangle its patch and its place there.
struct Patches {
    faces: Vec<Vec<FaceId>>,
    place: IdVec<FaceId, (u32, u32)>,
}

/// Does `work` on patches of about `size` triangles. Returns what it returned for each; nothing, with the mesh as it was,
/// where parts cannot be told apart again.
pub(crate) fn in_patches<'a, T: Send>(
    mesh: &mut SimMesh<'a>,
    size: usize,
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
    let parts: Vec<(&EditMesh, &Names)> = done.iter().map(|(patch, names, _)| (&patch.topology, names)).collect();
    let joined = join(&parts, mesh.topology.vertex_slots())?;
    let patches: Vec<&SimMesh<'a>> = done.iter().map(|(patch, ..)| patch).collect();
    let constraint = |i: usize, v: VertexId| done[i].1[v].map_or(patches[i].constraint[v], |v| mesh.constraint[v]);
    *mesh = SimMesh::joined(joined, &patches, constraint, mesh.baseline);
    Some(done.into_iter().map(|(_, _, result)| result).collect())
}

/// The vertices that a patch shares, by their numbers in the whole.
type Names = IdVec<VertexId, Option<VertexId>>;

impl Patches {
    /// Grows patches over edges, each from the first triangle that is in none.
    fn new(topology: &EditMesh, size: usize) -> Self {
        let mut place: IdVec<FaceId, Option<(u32, u32)>> = IdVec::filled(None, topology.face_slots());
        let mut faces = Vec::new();
        for seed in topology.faces() {
            if place[seed].is_some() {
                continue;
            }
            let number = faces.len() as u32;
            let (mut own, mut queue) = (Vec::new(), VecDeque::from([seed]));
            while let Some(f) = queue.pop_front().filter(|_| own.len() < size) {
                if place[f].is_some() {
                    continue;
                }
                place[f] = Some((number, own.len() as u32));
                own.push(f);
                queue.extend(corners(f).filter_map(|c| topology.twin(c)).map(face));
            }
            faces.push(own);
        }
        Self { faces, place: place.iter().map(|p| p.unwrap_or_default()).collect() }
    }
}

impl<'a> SimMesh<'a> {
    /// A patch with its border sealed, and what the whole calls the vertices there.
    fn patch(&self, patches: &Patches, number: usize) -> (Self, Names) {
        let place = |f: FaceId| Some(patches.place[f]).filter(|p| p.0 as usize == number).map(|p| p.1 as usize);
        let part = self.topology.part(&patches.faces[number], place);
        let (topology, old_vertex) = (&part.mesh, &part.old_vertex);
        let mut names = IdVec::filled(None, old_vertex.len());
        for c in topology.corners().filter(|&c| topology.twin(c).is_none()) {
            if self.topology.twin(part.old_corner[c]).is_some() {
                [topology.vertex(c), topology.target(c)].into_iter().for_each(|v| names[v] = Some(old_vertex[v]));
            }
        }
        let mut shared: Vec<(VertexId, VertexId)> = names.enumerated().filter_map(|(v, n)| Some(((*n)?, v))).collect();
        shared.sort_unstable();
        let mut patch = self.gathered(part);
        patch.patch_vertices = IdVec::filled(PatchVertex::Open, patch.points.len());
        for same in shared.chunk_by(|a, b| a.0 == b.0) {
            for &(_, v) in same {
                patch.patch_vertices[v] = if same.len() > 1 { PatchVertex::Pinched } else { PatchVertex::Shared };
                patch.constraint[v] = VertexConstraint::Fixed;
            }
        }
        (patch, names)
    }

    /// Patches joined; `grade` tells what a patch's vertex may do.
    fn joined(
        joined: Joined,
        patches: &[&Self],
        constraint: impl Fn(usize, VertexId) -> VertexConstraint,
        baseline: &'a Baseline,
    ) -> Self {
        let Joined { mesh: topology, old_vertex, seams, shared } = joined;
        let slots = topology.corner_slots();
        let mut mesh = Self {
            baseline,
            points: old_vertex.iter().map(|&(i, v)| patches[i].points[v]).collect(),
            target: old_vertex.iter().map(|&(i, v)| patches[i].target[v]).collect(),
            constraint: old_vertex.iter().map(|&(i, v)| constraint(i, v)).collect(),
            mark: IdVec::with_capacity(slots),
            spans: IdVec::new(),
            corner_wedge: IdVec::with_capacity(slots),
            wedges: IdVec::with_capacity(patches.iter().map(|p| p.wedges.len()).sum()),
            patch_vertices: IdVec::new(),
            topology,
        };
        for patch in patches {
            let (spans, wedges) = (mesh.spans.len(), mesh.wedges.len());
            mesh.mark.extend(patch.mark.iter().map(|m| m.map(|m| m.shifted(spans))));
            mesh.corner_wedge.extend(patch.corner_wedge.iter().map(|s| WedgeId::new(wedges + s.index())));
            mesh.spans.extend_from_slice(&patch.spans);
            mesh.wedges.extend_from_slice(&patch.wedges);
        }
        // Both sides of a seam had a span and sites of their own; they are the same.
        for [half, _] in seams {
            if let Some(mark) = mesh.mark[half] {
                mesh.set_mark(half, mark);
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

    /// Whether an edge is on the border of a patch, where other patches have it too.
    pub(crate) fn is_patch_border(&self, half: CornerId) -> bool {
        self.topology.twin(half).is_none()
            && self.patch_vertex(self.topology.vertex(half)) != PatchVertex::Open
            && self.patch_vertex(self.topology.target(half)) != PatchVertex::Open
    }

    /// Whether an edge may be made that no other patch could make too.
    pub(crate) fn may_connect(&self, a: VertexId, b: VertexId) -> bool {
        match (self.patch_vertex(a), self.patch_vertex(b)) {
            (PatchVertex::Pinched, _) | (_, PatchVertex::Pinched) => false,
            (a, b) => a == PatchVertex::Open || b == PatchVertex::Open,
        }
    }

    /// Whether merging an end of an edge into the other makes only such edges.
    pub(crate) fn may_merge(&self, half: CornerId, removed: VertexId) -> bool {
        if self.patch_vertices.is_empty() {
            return true;
        }
        let ends = [self.topology.vertex(half), self.topology.target(half)];
        let kept = if ends[0] == removed { ends[1] } else { ends[0] };
        let apexes = [Some(half), self.topology.twin(half)].map(|h| h.map(|h| self.topology.vertex(prev(h))));
        self.topology.ring(removed).all(|v| v == kept || apexes.contains(&Some(v)) || self.may_connect(kept, v))
    }
}
