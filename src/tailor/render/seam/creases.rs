//! Seams as creases of the coarse cage: what is left of a seam that is too thin to be seen.

use super::SeamOptions;
use crate::render::child::ChildBuilder;
use crate::render::operator::{Operator, OperatorInput, OperatorOutput};
use std::any::Any;
use std::collections::BTreeSet;
use tailor_mesh::connectivity::VertexId;
use tailor_mesh::error::Error;
use tailor_mesh::garment::Mesh;
use tailor_mesh::subdivide::edges_at;

/// Consecutive seams that are creases, with their names.
#[derive(Clone, Debug, PartialEq)]
pub struct Creases {
    pub seams: Vec<(String, SeamOptions)>,
}

impl Operator for Creases {
    fn label(&self) -> String {
        super::label(&self.seams)
    }

    fn reach(&self, _: &Mesh) -> f32 {
        0.0
    }

    fn is_same(&self, other: &dyn Operator) -> bool {
        (other as &dyn Any).downcast_ref::<Self>() == Some(self)
    }

    fn apply(&self, cage: &OperatorInput) -> Result<OperatorOutput, Error> {
        let t = cage.topology();
        let mut builder = ChildBuilder::new(t);
        for face in t.faces.ids() {
            builder.face(face, t.faces.vertices_of(face));
        }
        t.edges.enumerated().for_each(|(edge, &ends)| builder.edge(edge, ends));
        // A crease that reached a border would be a corner of it, and bend the outline.
        let is_inner = |v: VertexId| !edges_at(t, v).any(|edge| t.is_border(edge));
        let edges = self.seams.iter().flat_map(|(_, options)| options.edges_of(cage.garment));
        let edges =
            edges.filter_map(|[a, b]| t.find_edge(a, b)).filter(|&edge| t.edges[edge].into_iter().all(is_inner));
        let creases: BTreeSet<_> = edges.collect();
        let creases = creases.into_iter().map(|edge| t.edges[edge]).collect();
        Ok(OperatorOutput { creases, ..OperatorOutput::new(builder.finish(), cage) })
    }

    fn heights(&self, _: &OperatorOutput) -> Vec<f32> {
        Vec::new()
    }
}
