//! A garment as it was made, which one that is fitted to another body knows. Bodies of a crowd share the triangles that its
//! simulation mesh has there.

use super::baseline::Baseline;
use super::options::SimOptions;
use super::product::SimProduct;
use glam::Vec3;
use std::borrow::Cow;
use tailor_mesh::connectivity::{CornerId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{FIT_FROM, Interpolation, Mesh, Values};

/// The points of a garment as it was made: of a fitted one, those on the first body.
pub fn made_points(garment: &Mesh) -> Cow<'_, IdVec<VertexId, Vec3>> {
    let fitted = garment.primvar(FIT_FROM).filter(|p| p.interpolation == Interpolation::Vertex && p.width() == 3);
    match fitted.map(|primvar| (primvar, &primvar.values)) {
        Some((primvar, Values::F32(values))) => {
            let at = |v: VertexId| Vec3::from_slice(&values[3 * primvar.row(v.index())..]);
            Cow::Owned(garment.points.ids().map(at).collect())
        }
        _ => Cow::Borrowed(&garment.points),
    }
}

/// The garment as it was made, if it is on another body and the options ask for the triangles of the first.
pub fn as_made(garment: &Mesh, options: &SimOptions) -> Option<Mesh> {
    match made_points(garment) {
        Cow::Owned(points) if options.as_made => Some(Mesh { points, ..garment.clone() }),
        _ => None,
    }
}

/// The edge length that automatic lengths are multiples of; `mean` is that of the garment. \[mesh units\]
pub fn length_scale(garment: &Mesh, options: &SimOptions, mean: f32) -> f32 {
    as_made(garment, options).map_or(mean, |made| mean_edge_length(&made))
}

/// Mean length of a garment's edges. \[mesh units\]
pub fn mean_edge_length(garment: &Mesh) -> f32 {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let length = |&[a, b]: &[VertexId; 2]| f64::from(garment.points[a].distance(garment.points[b]));
    (t.edges.iter().map(length).sum::<f64>() / t.edges.len().max(1) as f64) as f32
}

impl SimProduct {
    /// The product on another shape of the garment, with the same triangles. Both baselines have the same refinement level.
    #[must_use]
    pub fn on(mut self, form: Baseline) -> Self {
        self.baseline.move_to(form.points);
        for (corner, &vertex) in self.triangles.as_flattened().iter().enumerate() {
            self.points[vertex] = self.baseline.position(self.places[CornerId::new(corner)].location);
        }
        self
    }
}
