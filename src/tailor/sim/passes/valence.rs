//! Valence excess: how far vertices are from regular.

use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_3;
use tailor_mesh::connectivity::edit::{next, prev};
use tailor_mesh::connectivity::{CornerId, IdVec, VertexId, WedgeId};

/// Triangles in each wedge above the regular number: six at a free vertex, three on each side of a chain, and between the
/// chains of an anchor as many as make angles of 60 degrees.
pub struct ValenceExcess(IdVec<WedgeId, i8>);

impl ValenceExcess {
    pub fn new(mesh: &SimMesh<'_>) -> Self {
        let vertices = (0..mesh.topology.vertex_slots()).into_par_iter().map(VertexId::new);
        let found = vertices.fold(Vec::new, |mut found, v| {
            excess_at(mesh, v, &mut found);
            found
        });
        let mut excess = IdVec::filled(0, mesh.wedges.len());
        found.collect::<Vec<_>>().into_iter().flatten().for_each(|(wedge, own)| excess[wedge] = own);
        Self(excess)
    }

    /// The change of the sum of squares when an edge of two triangles is flipped.
    #[inline]
    pub fn change(&self, mesh: &SimMesh<'_>, half: CornerId) -> i32 {
        let Some(twin) = mesh.topology.twin(half) else { return 0 };
        let excess = |x: CornerId| i32::from(self.0[mesh.corner_wedge[x]]);
        4 + 2 * (excess(prev(half)) + excess(prev(twin)) - excess(half) - excess(twin))
    }

    /// Flips an edge of two triangles.
    pub fn flip(&mut self, mesh: &mut SimMesh<'_>, half: CornerId) {
        self.count_flip(mesh, half, 1);
        mesh.flip(half);
    }

    /// Undoes a flip.
    pub fn unflip(&mut self, mesh: &mut SimMesh<'_>, half: CornerId) {
        mesh.unflip(half);
        self.count_flip(mesh, half, -1);
    }

    /// Counts a flip before it is made (`sign` 1), or subtracts one that is undone (-1).
    fn count_flip(&mut self, mesh: &SimMesh<'_>, half: CornerId, sign: i8) {
        let Some(twin) = mesh.topology.twin(half) else { return };
        let wedges = [half, twin, prev(half), prev(twin)].map(|c| mesh.corner_wedge[c]);
        wedges.into_iter().zip([-sign, -sign, sign, sign]).for_each(|(wedge, by)| self.0[wedge] += by);
    }
}

/// The excess in each wedge of a vertex.
fn excess_at(mesh: &SimMesh<'_>, vertex: VertexId, found: &mut Vec<(WedgeId, i8)>) {
    let constraint = mesh.constraint[vertex];
    let mut fan = mesh.topology.fan(vertex);
    if constraint == VertexConstraint::Free {
        let Some(first) = fan.next() else { return };
        found.push((mesh.corner_wedge[first], (fan.count() + 1).min(100) as i8 - 6));
        return;
    }
    let mut sectors: Vec<(WedgeId, i8, f32)> = Vec::with_capacity(4);
    for c in fan {
        let wedge = mesh.corner_wedge[c];
        let angle = if constraint == VertexConstraint::Fixed { angle(mesh, c) } else { 0.0 };
        match sectors.iter_mut().find(|s| s.0 == wedge) {
            Some(own) => (own.1, own.2) = (own.1.saturating_add(1).min(100), own.2 + angle),
            None => sectors.push((wedge, 1, angle)),
        }
    }
    let regular = |angle: f32| match constraint {
        VertexConstraint::Fixed => (angle / FRAC_PI_3).round().clamp(1.0, 12.0) as i8,
        _ => 3,
    };
    found.extend(sectors.into_iter().map(|(wedge, count, angle)| (wedge, count - regular(angle))));
}

/// The angle of a corner. \[radians\]
fn angle(mesh: &SimMesh<'_>, corner: CornerId) -> f32 {
    let [p, q, r] = [corner, next(corner), prev(corner)].map(|c| mesh.points[mesh.topology.vertex(c)]);
    (q - p).angle_between(r - p)
}

#[cfg(test)]
mod tests {
    use super::*;

    impl SimMesh<'_> {
        /// The sum over all wedges of their squared valence excess.
        pub fn irregularity(&self) -> i64 {
            let excess = ValenceExcess::new(self);
            let wedges: std::collections::BTreeSet<WedgeId> =
                self.topology.corners().map(|c| self.corner_wedge[c]).collect();
            wedges.into_iter().map(|wedge| i64::from(excess.0[wedge]).pow(2)).sum()
        }
    }
}
