//! Wedges: the corners of a vertex between constrained edges, which share a location, UV and normal.
//!
//! Source: Hoppe, *Efficient Implementation of Progressive Meshes* (1998), section 2.

use super::SimMesh;
use crate::sim::baseline::{Baseline, BaselinePoint};
use crate::sim::constraints::chain::{Chain, CurvePoint};
use glam::{Vec2, Vec3};
use tailor_mesh::connectivity::edit::{face, next, prev};
use tailor_mesh::connectivity::{CornerId, IdVec};

/// A location on the baseline with its UV, which is one of several where shells meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaselineUvPoint {
    /// The baseline's triangle, and the point in it.
    pub location: BaselinePoint,
    /// Constraint UVs.
    pub uv: Vec2,
}

/// Attributes that the corners of a vertex share between two constrained edges. A free vertex has one wedge.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    /// Location and UV.
    pub place: BaselineUvPoint,
    /// Unit normal of the surface.
    pub normal: Vec3,
    /// +1 or -1: the orientation of the shell in UV space; 0 where the layout is free, on flipped and small shells.
    pub sense: f32,
}

impl Baseline {
    /// The wedge of a location.
    pub fn wedge(&self, place: BaselineUvPoint) -> Wedge {
        let facet = &self.facets[place.location.face];
        Wedge { place, normal: facet.normal, sense: facet.sense }
    }
}

impl SimMesh<'_> {
    /// Makes a wedge for each sector of each vertex, as `wedge` returns it for one of its corners.
    pub(super) fn make_wedges(&mut self, wedge: impl Fn(CornerId) -> Wedge) {
        let mut is_done = IdVec::<CornerId, bool>::filled(false, self.topology.corner_slots());
        let mut sector = Vec::new();
        for corner in is_done.ids() {
            if is_done[corner] {
                continue;
            }
            let own = self.wedges.push(wedge(corner));
            self.sector(corner, &mut sector);
            for &c in &sector {
                self.corner_wedge[c] = own;
                is_done[c] = true;
            }
        }
    }

    /// The wedge of a location.
    pub fn wedge_at(&self, location: BaselinePoint) -> Wedge {
        self.baseline.wedge(BaselineUvPoint { location, uv: self.baseline.uv(location) })
    }

    /// The wedge of a corner.
    #[inline]
    pub fn wedge(&self, corner: CornerId) -> &Wedge {
        &self.wedges[self.corner_wedge[corner]]
    }

    /// Location and UV of a corner.
    pub fn place(&self, corner: CornerId) -> BaselineUvPoint {
        self.wedge(corner).place
    }

    /// The wedge of a point of a chain's curve, on the left of a half-edge that runs `forward` along it or backward; none
    /// where the surface has no face there.
    pub(super) fn wedge_on_curve(&self, curve: &Chain, at: CurvePoint, forward: bool) -> Option<Wedge> {
        let half = if forward { curve.left[at.segment] } else { curve.right[at.segment] }?;
        let t = if forward { at.t } else { 1.0 - at.t };
        let mut weights = [0.0; 3];
        weights[half.index() % 3] = 1.0 - t;
        weights[next(half).index() % 3] = t;
        let location = BaselinePoint { face: face(half), weights: weights.into() };
        // In the chain's direction on both sides, so that UVs which agree there stay bit for bit the same.
        let [from, to] = if forward { [half, next(half)] } else { [next(half), half] };
        let place = BaselineUvPoint { location, uv: self.baseline.uvs[from].lerp(self.baseline.uvs[to], at.t) };
        Some(Wedge { normal: curve.normal_at(at, forward), ..self.baseline.wedge(place) })
    }

    /// The corners at the vertex of `corner` that are reached from it without crossing a constrained edge.
    pub(super) fn sector(&self, corner: CornerId, sector: &mut Vec<CornerId>) {
        sector.clear();
        sector.push(corner);
        let mut at = corner;
        while !self.is_constrained(prev(at))
            && let Some(c) = self.topology.twin(prev(at))
        {
            if c == corner {
                return;
            }
            sector.push(c);
            at = c;
        }
        at = corner;
        while !self.is_constrained(at)
            && let Some(t) = self.topology.twin(at)
        {
            at = next(t);
            sector.push(at);
        }
    }
}
