//! Elements that are near each other on the baseline get numbers near each other, so that a pass finds most of what it
//! needs in the cache.

use super::mesh::{Mark, SimMesh};
use crate::mesh::{CornerId, FaceId, IdVec, Part, SiteId, SpanId, VertexId};

impl SimMesh<'_> {
    /// Numbers triangles by their places on the baseline and vertices by their triangles, and drops what is gone. Returns
    /// the old vertex of each new one.
    pub(super) fn reorder(&mut self) -> IdVec<VertexId, VertexId> {
        let Part { mesh, old_vertex, old_corner } = self.topology.reordered(&self.faces_by_place());
        self.topology = mesh;
        self.points = old_vertex.iter().map(|&v| self.points[v]).collect();
        self.target = old_vertex.iter().map(|&v| self.target[v]).collect();
        self.grade = old_vertex.iter().map(|&v| self.grade[v]).collect();
        let (mut sites, mut spans) = (IdVec::with_capacity(2 * old_vertex.len()), IdVec::new());
        let mut new_site = IdVec::<SiteId, Option<SiteId>>::filled(None, self.sites.len());
        let mut new_span = IdVec::<SpanId, Option<SpanId>>::filled(None, self.spans.len());
        let site_of = old_corner.iter().map(|&c| {
            let old = self.site_of[c];
            *new_site[old].get_or_insert_with(|| sites.push(self.sites[old]))
        });
        self.site_of = site_of.collect();
        let mark = old_corner.iter().map(|&c| {
            let mark = self.mark[c]?;
            let old = mark.span();
            let new = *new_span[old].get_or_insert_with(|| spans.push(self.spans[old]));
            Some(Mark::new(new, mark.is_forward()))
        });
        self.mark = mark.collect();
        (self.sites, self.spans) = (sites, spans);
        old_vertex
    }

    /// The triangles by the baseline's triangle at their first corners; of equals the older first.
    fn faces_by_place(&self) -> Vec<FaceId> {
        let place = |f: FaceId| (self.place(CornerId::new(3 * f.index())).location.face, f);
        let mut faces: Vec<(FaceId, FaceId)> = self.topology.faces().map(place).collect();
        faces.sort_unstable();
        faces.into_iter().map(|(_, f)| f).collect()
    }
}
