//! The start of remeshing.

use super::patches::PatchVertex;
use super::{BaselineUvPoint, CurveSpan, SimMesh, VertexConstraint};
use crate::sim::baseline::Baseline;
use tailor_mesh::connectivity::edit::{EditMesh, next};
use tailor_mesh::connectivity::{CornerId, IdVec, VertexId, WedgeId};

/// Sharpness of a corner from which it is a vertex of the simulation mesh.
const SHARP_CORNER: f32 = 1.0;

impl<'a> SimMesh<'a> {
    /// The start mesh of a baseline.
    pub fn new(baseline: &'a Baseline) -> Self {
        let vertex = |c: CornerId| baseline.topology.faces.vertex(c);
        let triangles: Vec<[VertexId; 3]> = baseline.start.iter().map(|t| t.map(vertex)).collect();
        let topology = EditMesh::new(&triangles, baseline.points.len());
        let mut mesh = Self {
            points: baseline.points.clone(),
            target: baseline.sizing.clone(),
            constraint: IdVec::filled(VertexConstraint::Free, baseline.points.len()),
            ..Self::empty(baseline, topology)
        };
        mesh.set_curve_constraints();
        mesh.fix_anchors();
        mesh.set_wedges();
        mesh
    }

    /// A topology without constraints; vertices and wedges are left to the caller.
    pub(super) fn empty(baseline: &'a Baseline, topology: EditMesh) -> Self {
        let corners = topology.corner_slots();
        Self {
            baseline,
            points: IdVec::new(),
            target: IdVec::new(),
            constraint: IdVec::new(),
            corner_span: IdVec::filled(None, corners),
            spans: IdVec::new(),
            // `make_wedges` sets every corner's own.
            corner_wedge: IdVec::filled(WedgeId::new(0), corners),
            wedges: IdVec::new(),
            patch_vertices: IdVec::<VertexId, PatchVertex>::new(),
            topology,
        }
    }

    /// Constrains the edges of the start that lie on chains, and their vertices.
    fn set_curve_constraints(&mut self) {
        let baseline = self.baseline;
        let level_ends = |mesh: &Self, half| mesh.topology.ends(half).map(|v| baseline.level_vertex[v]);
        let mut is_on_chain = IdVec::<VertexId, bool>::filled(false, self.points.len());
        baseline.chains.iter().flat_map(|c| &c.vertices).for_each(|&v| is_on_chain[v] = true);
        let may_follow = |&half: &CornerId| level_ends(self, half).iter().all(|&v| is_on_chain[v]);
        let halves: Vec<CornerId> = self.topology.edges().filter(may_follow).collect();
        for half in halves {
            let [a, b] = level_ends(self, half);
            let Some(start) = baseline.start_spans.get(&[a.min(b), a.max(b)]) else { continue };
            let chain = self.chain(start.chain);
            let counts = [start.from, start.to].map(|s| chain.count_to(s));
            let span = CurveSpan { chain: start.chain, from: start.from, to: start.to, counts, forward: true };
            let span = if start.first == a { span } else { span.reversed() };
            self.add_span(half, span);
            for (v, s) in self.topology.ends(half).into_iter().zip([span.from, span.to]) {
                self.constraint[v] = VertexConstraint::OnCurve(span.chain);
                self.target[v] = self.target[v].min(chain.length_at(chain.at(s)));
            }
        }
    }

    /// Fixes the ends and corners of chains, and corners of the cage, which would be cut off inside the cloth.
    fn fix_anchors(&mut self) {
        let mut is_anchor = IdVec::<VertexId, bool>::filled(false, self.points.len());
        let mut is_on_chain = IdVec::<VertexId, bool>::filled(false, self.points.len());
        self.baseline.chains.iter().flat_map(|c| &c.vertices).for_each(|&v| is_on_chain[v] = true);
        // The vertices of the cage are the first of each level. Chains turn at theirs.
        for (vertex, sharpness) in self.baseline.manifold.level.vertex_sharpness.enumerated() {
            is_anchor[vertex] = *sharpness >= SHARP_CORNER && !is_on_chain[vertex];
        }
        for chain in self.baseline.chains.iter() {
            let corners = chain.pins.iter().map(|&i| chain.vertices[i]);
            corners.chain(chain.ends()).for_each(|v| is_anchor[v] = true);
        }
        for (vertex, &level_vertex) in self.baseline.level_vertex.enumerated() {
            if is_anchor[level_vertex] {
                self.constraint[vertex] = VertexConstraint::Fixed;
            }
        }
    }

    /// Makes the wedges. Beside chains they have the normals of the curves.
    fn set_wedges(&mut self) {
        let baseline = self.baseline;
        self.make_wedges(|corner| {
            let own = baseline.start[corner.index() / 3][corner.index() % 3];
            baseline.wedge(BaselineUvPoint { location: baseline.corner_location(own), uv: baseline.uvs[own] })
        });
        for half in self.topology.corners() {
            let Some(span) = self.span(half) else { continue };
            for (corner, s) in [(half, span.from), (next(half), span.to)] {
                let chain = self.chain(span.chain);
                self.wedges[self.corner_wedge[corner]].normal = chain.normal_at(chain.at(s), span.forward);
            }
        }
    }
}
