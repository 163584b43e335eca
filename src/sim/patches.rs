//! Patches of a mesh that are worked on apart, at the same time: each fits the cache, and none sees another.
//!
//! What patches share stays as it is: vertices on their borders are sealed. So the parts fit together again, and the
//! result is the same for any number of threads. What was left along the borders is for a pass over the whole.

use super::baseline::Baseline;
use super::mesh::{Grade, SimMesh, Site, Span};
use crate::mesh::edit::{EditMesh, face, prev};
use crate::mesh::{CornerId, FaceId, IdVec, Joined, Part, Piece, SiteId, VertexId, join};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Triangles of a patch. Larger ones have fewer edges along their borders, smaller ones fit a core's cache better and
/// are shared out more evenly.
pub(super) const PATCH: usize = 4096;

/// Whether a vertex is on the border of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Seal {
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
pub(super) fn in_patches<'a, T: Send>(
    mesh: &mut SimMesh<'a>,
    size: usize,
    work: impl Fn(&mut SimMesh<'a>) -> T + Sync,
) -> Option<Vec<T>> {
    let patches = Patches::new(&mesh.topology, size);
    let whole = &*mesh;
    let done = (0..patches.faces.len()).into_par_iter().map(|i| {
        let (mut patch, names) = whole.patch(&patches, i);
        let result = work(&mut patch);
        (patch, names, result)
    });
    let done: Vec<(SimMesh<'a>, Names, T)> = done.collect();
    let pieces = done.iter().map(|(patch, names, _)| Piece {
        mesh: &patch.topology,
        order: patch.faces_by_place(),
        names,
    });
    let joined = join(&pieces.collect::<Vec<_>>(), mesh.topology.vertex_slots())?;
    let grade = &mesh.grade;
    *mesh = SimMesh::joined(joined, mesh.baseline, |i| &done[i].0, |i, v| done[i].1.get(v.index())?.map(|v| grade[v]));
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
                let corners = (0..3).map(|k| CornerId::new(3 * f.index() + k));
                queue.extend(corners.filter_map(|c| topology.twin(c)).map(face));
            }
            faces.push(own);
        }
        Self { faces, place: place.iter().map(|p| p.unwrap_or_default()).collect() }
    }
}

/// What a mesh knows of its vertices.
struct Vertices {
    points: IdVec<VertexId, Vec3>,
    target: IdVec<VertexId, f32>,
    grade: IdVec<VertexId, Grade>,
}

impl<'a> SimMesh<'a> {
    /// A patch with its border sealed, and what the whole calls the vertices there.
    fn patch(&self, patches: &Patches, number: usize) -> (Self, Names) {
        let place = |f: FaceId| Some(patches.place[f]).filter(|p| p.0 as usize == number).map(|p| p.1 as usize);
        let Part { mesh: topology, old_vertex, old_corner } = self.topology.part(&patches.faces[number], place);
        let mut names = IdVec::filled(None, old_vertex.len());
        for c in topology.corners().filter(|&c| topology.twin(c).is_none()) {
            if self.topology.twin(old_corner[c]).is_some() {
                [topology.vertex(c), topology.target(c)].into_iter().for_each(|v| names[v] = Some(old_vertex[v]));
            }
        }
        let mut sealed: Vec<(VertexId, VertexId)> = names.enumerated().filter_map(|(v, n)| Some(((*n)?, v))).collect();
        sealed.sort_unstable();
        let mut seals = IdVec::filled(Seal::Open, old_vertex.len());
        for same in sealed.chunk_by(|a, b| a.0 == b.0) {
            let seal = if same.len() > 1 { Seal::Pinched } else { Seal::Shared };
            same.iter().for_each(|&(_, v)| seals[v] = seal);
        }
        let grade = old_vertex.enumerated().map(|(v, &old)| match seals[v] {
            Seal::Open => self.grade[old],
            Seal::Shared | Seal::Pinched => Grade::Frozen,
        });
        let grade = grade.collect();
        let site = |c: CornerId| *self.site(old_corner[c]);
        let span = |c: CornerId| self.span(old_corner[c]);
        let points = old_vertex.iter().map(|&v| self.points[v]).collect();
        let target = old_vertex.iter().map(|&v| self.target[v]).collect();
        let patch = Self::assembled(self.baseline, topology, Vertices { points, target, grade }, site, span);
        (Self { seals, ..patch }, names)
    }

    /// Patches joined; `grade` tells what a shared vertex may do.
    fn joined<'p>(
        joined: Joined,
        baseline: &'a Baseline,
        patch: impl Fn(usize) -> &'p Self,
        grade: impl Fn(usize, VertexId) -> Option<Grade>,
    ) -> Self
    where
        'a: 'p,
    {
        let Joined { mesh, old_vertex, old_corner } = joined;
        let site = |c: CornerId| *patch(old_corner[c].0).site(old_corner[c].1);
        let span = |c: CornerId| patch(old_corner[c].0).span(old_corner[c].1);
        let points = old_vertex.iter().map(|&(i, v)| patch(i).points[v]).collect();
        let target = old_vertex.iter().map(|&(i, v)| patch(i).target[v]).collect();
        let grade = old_vertex.iter().map(|&(i, v)| grade(i, v).unwrap_or(patch(i).grade[v])).collect();
        Self::assembled(baseline, mesh, Vertices { points, target, grade }, site, span)
    }

    /// A mesh of which `site` and `span` tell what each corner has.
    fn assembled(
        baseline: &'a Baseline,
        topology: EditMesh,
        Vertices { points, target, grade }: Vertices,
        site: impl Fn(CornerId) -> Site,
        span: impl Fn(CornerId) -> Option<Span>,
    ) -> Self {
        let corners = topology.corner_slots();
        let mut mesh = Self {
            mark: IdVec::filled(None, corners),
            spans: IdVec::new(),
            site_of: IdVec::filled(SiteId::new(0), corners),
            sites: IdVec::with_capacity(points.len() + points.len() / 4),
            seals: IdVec::new(),
            baseline,
            topology,
            points,
            target,
            grade,
        };
        for half in (0..corners).map(CornerId::new) {
            if mesh.mark[half].is_none()
                && let Some(span) = span(half)
            {
                mesh.add_span(half, span);
            }
        }
        mesh.make_sites(site);
        mesh
    }

    /// The triangles by the baseline's triangle at their first corners; of equals the older first.
    fn faces_by_place(&self) -> Vec<FaceId> {
        let place = |f: &FaceId| (self.place(CornerId::new(3 * f.index())).location.face, *f);
        let mut faces: Vec<FaceId> = self.topology.faces().collect();
        faces.sort_unstable_by_key(place);
        faces
    }

    fn seal(&self, vertex: VertexId) -> Seal {
        self.seals.get(vertex.index()).copied().unwrap_or_default()
    }

    /// Whether an edge is on the border of a patch, where other patches have it too.
    pub(super) fn is_sealed(&self, half: CornerId) -> bool {
        self.topology.twin(half).is_none()
            && self.seal(self.topology.vertex(half)) != Seal::Open
            && self.seal(self.topology.target(half)) != Seal::Open
    }

    /// Whether an edge may be made that no other patch could make too.
    pub(super) fn may_join(&self, a: VertexId, b: VertexId) -> bool {
        match (self.seal(a), self.seal(b)) {
            (Seal::Pinched, _) | (_, Seal::Pinched) => false,
            (a, b) => a == Seal::Open || b == Seal::Open,
        }
    }

    /// Whether merging an end of an edge into the other makes only such edges.
    pub(super) fn may_merge(&self, half: CornerId, removed: VertexId) -> bool {
        if self.seals.is_empty() {
            return true;
        }
        let ends = [self.topology.vertex(half), self.topology.target(half)];
        let kept = if ends[0] == removed { ends[1] } else { ends[0] };
        let apexes = [Some(half), self.topology.twin(half)].map(|h| h.map(|h| self.topology.vertex(prev(h))));
        self.topology.ring(removed).all(|v| v == kept || apexes.contains(&Some(v)) || self.may_join(kept, v))
    }
}
