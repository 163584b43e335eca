//! The frame of a build. Single precision has few digits left far from the origin, so a garment there is built near it, and
//! its products are moved back.

use crate::codes;
use glam::Vec3;
use std::sync::Arc;
use tailor_mesh::error::{Error, ErrorKind, Warning};
use tailor_mesh::garment::Mesh;
use tailor_mesh::step::{Same, Step};

/// A garment is moved along the axes on which it lies farther from the origin than this many of its own sizes. Nearer ones
/// lose at most four bits. From 2 on a move and the way back are exact for its own points. \[factor\]
const FAR: f32 = 8.0;
/// Share of the mean edge length by which the points of products may be rounded before a warning is given.
const ROUNDED: f32 = 0.01;

/// The frame of one garment, and its products in the garment's own space.
#[derive(Default)]
pub struct LocalFrame {
    /// The origin of the frame in the garment's space. \[mesh units\]
    origin: Vec3,
    sim: Step<Same<Mesh>, Arc<Mesh>>,
    render: Step<Same<Mesh>, Arc<Mesh>>,
}

impl LocalFrame {
    /// The frame of a garment: its own space, unless it is far from the origin.
    pub fn of(garment: &Mesh) -> Self {
        let [low, high] = garment.bounds();
        let (centre, far) = (low.midpoint(high), FAR * garment.size());
        let origin = Vec3::select(centre.abs().cmpgt(Vec3::splat(far)), centre, Vec3::ZERO);
        Self { origin, ..Self::default() }
    }

    /// The frame of the same garment, which keeps no product yet.
    pub fn sibling(&self) -> Self {
        Self { origin: self.origin, ..Self::default() }
    }

    /// Its origin in the garment's space. \[mesh units\]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The spacing of numbers at its origin. \[mesh units\]
    fn resolution(&self) -> f32 {
        self.origin.abs().max_element() * f32::EPSILON
    }

    /// The warning of a garment so far away that the points of its products are rounded.
    ///
    /// # Errors
    /// A garment whose edges are shorter than the spacing of numbers there.
    pub fn check(&self, garment: &Mesh, mean_edge: f32) -> Result<Option<Warning>, Error> {
        let (place, step) = (format!("{}.points", garment.prim), self.resolution());
        let far = self.origin.abs().max_element();
        let remedy = "Move the points to the origin, and put the offset into the transform of the prim";
        if step > mean_edge {
            let fault = format!(
                "the mesh is {far:e} units from the origin, where points are {step} apart: more than its mean edge \
                 length, {mean_edge}"
            );
            return Err(Error::new(ErrorKind::Mesh, place, fault).remedy(remedy));
        }
        let problem =
            format!("the mesh is {far:e} units from the origin: points of the products are rounded to {step}");
        let warning = Warning::new(codes::FAR_FROM_ORIGIN, place, problem).amount(step / mean_edge).remedy(remedy);
        Ok((step > ROUNDED * mean_edge).then_some(warning))
    }

    /// A garment in this frame.
    pub fn enter(&self, garment: &Arc<Mesh>) -> Arc<Mesh> {
        if self.origin == Vec3::ZERO { Arc::clone(garment) } else { Arc::new(moved(garment, -self.origin)) }
    }

    /// A simulation mesh in the garment's space.
    pub fn sim(&mut self, mesh: &Arc<Mesh>) -> Result<Arc<Mesh>, Error> {
        back(&mut self.sim, self.origin, mesh, moved)
    }

    /// A render mesh in the garment's space.
    pub fn render(&mut self, mesh: &Arc<Mesh>) -> Result<Arc<Mesh>, Error> {
        back(&mut self.render, self.origin, mesh, moved)
    }

    /// An estimate of the memory of the moved products. \[bytes\]
    pub fn bytes(&self) -> usize {
        let meshes = [self.sim.last(), self.render.last()].into_iter().flatten();
        meshes.map(|mesh| mesh.bytes()).sum()
    }
}

/// A product moved to `origin` \[mesh units\]; itself if that is zero.
///
/// # Errors
/// None of its own.
pub fn back<T>(
    step: &mut Step<Same<T>, Arc<T>>,
    origin: Vec3,
    product: &Arc<T>,
    moved: impl FnOnce(&T, Vec3) -> T,
) -> Result<Arc<T>, Error> {
    if origin == Vec3::ZERO {
        return Ok(Arc::clone(product));
    }
    step.get(Same::from(product), |product| Ok(Arc::new(moved(product, origin))))
}

/// A mesh with its points moved. Primvars, normals among them, are not places in its space.
fn moved(mesh: &Mesh, by: Vec3) -> Mesh {
    Mesh { points: mesh.points.iter().map(|&p| p + by).collect(), ..mesh.clone() }
}
