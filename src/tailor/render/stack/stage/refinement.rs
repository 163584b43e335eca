//! The refinements after the operators.

use super::{Cage, InputVertices};
use glam::Vec3;
use std::sync::Arc;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::error::Error;
use tailor_mesh::garment::{Mesh, Subset};
use tailor_mesh::step::{Same, Step};
use tailor_mesh::subdivide::{
    Carrier, Connectivity, Derivation, Refinement, carried_points, child_values, share_values_alike,
};

/// Memory per corner of a refined level, measured on garments of 10 to 100 thousand corners. \[bytes\]
const LEVEL_CORNER: usize = 40;

/// The garment after all refinements without its points, and the refinements.
pub type Refined = (Arc<Mesh>, Vec<Arc<Refinement>>);

/// A cage with its level, compared by the inputs of its refinement.
struct SameRefinement(Cage);

impl PartialEq for SameRefinement {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.level, &other.0.level) && share_values_alike(&self.0.garment, &other.0.garment)
    }
}

/// The subsets of a product.
type Subsets = Arc<Vec<Subset>>;

/// Steps of a refinement.
#[derive(Default)]
pub struct RefinementSteps {
    of_cage: Step<SameRefinement, Arc<Refinement>>,
    of_refinement: Step<Same<Refinement>, Arc<Refinement>>,
    subsets: Step<(Same<Refinement>, Subsets), Subsets>,
    attributes: Step<(Same<Refinement>, Same<Mesh>), Arc<Mesh>>,
}

impl RefinementSteps {
    /// The last refinement.
    pub fn last(&self) -> Option<Arc<Refinement>> {
        self.of_cage.last().or(self.of_refinement.last()).cloned()
    }

    /// The refinement after `last`, or the first of `cage`.
    fn refinement(&mut self, cage: &Cage, last: Option<&Arc<Refinement>>) -> Result<Arc<Refinement>, Error> {
        match last {
            None => self.of_cage.get(SameRefinement(cage.clone()), |SameRefinement(cage)| {
                Ok(Arc::new(Refinement::of_cage(Arc::clone(&cage.level), &cage.garment)))
            }),
            Some(last) => self.of_refinement.get(Same::from(last), |last| Ok(Arc::new(last.next()))),
        }
    }

    /// An estimate of the memory of its cached steps. \[bytes\]
    pub fn bytes(&self) -> usize {
        let corners = |r: &Arc<Refinement>| r.level().topology.faces.corners().len();
        let refinement = self.last().map_or(0, |r| r.bytes() + LEVEL_CORNER * corners(&r));
        refinement + self.attributes.last().map_or(0, |garment| garment.bytes())
    }

    /// The refined garment, without points.
    fn attributes(&mut self, by: &Arc<Refinement>, of: &Arc<Mesh>) -> Result<Arc<Mesh>, Error> {
        let carrier = Carrier::new(of, by.as_ref());
        let input = (Same::from(by), Arc::clone(&of.subsets));
        let subsets = self.subsets.get(input, |_| Ok(carrier.subsets()))?;
        self.attributes.get((Same::from(by), Same::from(of)), |_| {
            let (primvars, influences) = (carrier.primvars(), carrier.influences());
            Ok(Arc::new(Mesh { primvars, influences, ..carrier.frame(subsets) }))
        })
    }
}

/// A cage after all refinements, without its points.
pub fn refined(steps: &mut [RefinementSteps], cage: &Cage) -> Result<Refined, Error> {
    let mut garment = Arc::clone(&cage.garment);
    let mut refinements: Vec<Arc<Refinement>> = Vec::with_capacity(steps.len());
    for steps in steps {
        let refinement = steps.refinement(cage, refinements.last())?;
        garment = steps.attributes(&refinement, &garment)?;
        refinements.push(refinement);
    }
    Ok((garment, refinements))
}

/// The input vertices after refinements: of an edge or a face, those of its first vertex.
pub fn refined_inputs(mut inputs: InputVertices, refinements: &[Arc<Refinement>]) -> InputVertices {
    for refinement in refinements {
        let t = &refinement.level().topology;
        let first = |vertices: &[VertexId]| inputs[vertices[0]];
        inputs = child_values(refinement.level(), &inputs, |f| first(t.faces.vertices_of(f)), |e| first(&t.edges[e]));
    }
    inputs
}

/// Values of faces after refinements: those of the parents.
pub fn from_parents<T: Copy>(mut values: IdVec<FaceId, T>, refinements: &[Arc<Refinement>]) -> IdVec<FaceId, T> {
    for refinement in refinements {
        values = refinement.faces().ids().map(|face| values[refinement.parent_face(face)]).collect();
    }
    values
}

/// Points after all refinements. `known` holds the masks of the first refinement if an operator computed them.
pub fn refined_points(
    points: &IdVec<VertexId, Vec3>,
    known: Option<&Connectivity>,
    refinements: &[Arc<Refinement>],
) -> IdVec<VertexId, Vec3> {
    let Some((first, others)) = refinements.split_first() else { return points.clone() };
    let rows = known.map_or_else(|| first.level().vertex_rows(), Connectivity::vertex_rows);
    let points = carried_points(&rows, points);
    others.iter().fold(points, |points, next| carried_points(&next.vertex(), &points))
}
