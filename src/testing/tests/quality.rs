//! Quality of a triangle mesh against the surface, the curves and the lengths that it was asked for: the same numbers
//! for our meshes and those of others.

use crate::nearest::Nearest;
use glam::Vec3;
use std::collections::HashMap;
use std::fmt;
use tailor::report::min_angle;
use tailor::sim::{ChainKind, SimProduct};
use tailor_mesh::connectivity::VertexId;

/// The surface, curves and lengths that a mesh is held to.
pub struct Reference<'a> {
    /// Triangles of the surface.
    pub surface: &'a [[Vec3; 3]],
    /// Constrained curves: borders, seams and chosen edges.
    pub curves: &'a [Vec<Vec3>],
    /// Target length at a point. \[mesh units\]
    pub target: &'a dyn Fn(Vec3) -> f32,
}

impl Reference<'_> {
    /// Does work with what a product is held to: its baseline, and the curves of borders, seams and chosen edges, but not
    /// our own feature lines.
    pub fn of<T>(product: &SimProduct, work: impl FnOnce(&Reference<'_>) -> T) -> T {
        let base = &product.baseline;
        let surface: Vec<[Vec3; 3]> = base.topology.faces.ids().map(|f| base.triangle(f)).collect();
        let chains = base.chains.iter().filter(|c| c.kind != ChainKind::FEATURE);
        let curves: Vec<Vec<Vec3>> = chains.map(|c| c.vertices.iter().map(|&v| base.points[v]).collect()).collect();
        let vertices = Nearest::new(base.points.iter().map(|&p| [p; 3]).collect());
        let target = |p: Vec3| base.target[VertexId::new(vertices.find(p).0)];
        work(&Reference { surface: &surface, curves: &curves, target: &target })
    }
}

/// Figures of a mesh. Angles in degrees, lengths as shares of the target length.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quality {
    pub min_angle: f32,
    pub p5: f32,
    pub under30: f32,
    pub valence6: f32,
    pub rms: f32,
    /// Farthest point of the curves from the mesh's edges.
    pub curve_max: f32,
    /// Share of the curves within 0.02 of an edge.
    pub curve_near: f32,
    /// Farthest point of the mesh from the surface.
    pub to_surface: f32,
    /// Farthest point of the surface from the mesh.
    pub from_surface: f32,
}

impl Quality {
    /// The heads of the columns that its display has.
    pub const HEAD: &str = "  min    p5   <30 %  val6    rms   seam   near     to   from";
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { min_angle, p5, rms, curve_max, to_surface, from_surface, .. } = *self;
        let [under30, valence6, near] = [self.under30, self.valence6, self.curve_near].map(|share| 100.0 * share);
        write!(f, "{min_angle:5.1} {p5:5.2} {under30:7.3} {valence6:5.1} {rms:6.4} ")?;
        write!(f, "{curve_max:6.3} {near:6.2} {to_surface:6.3} {from_surface:6.3}")
    }
}

/// Points on each segment of a curve, and on each side of the triangles, at which distances are taken.
const STEPS: usize = 4;

/// The figures of a product.
pub fn of_product(product: &SimProduct, reference: &Reference<'_>) -> Quality {
    let triangles: Vec<[usize; 3]> = product.triangles.iter().map(|t| t.map(VertexId::index)).collect();
    measure(&product.points, &triangles, &product.target, reference)
}

pub fn measure(points: &[Vec3], triangles: &[[usize; 3]], target: &[f32], reference: &Reference<'_>) -> Quality {
    let mut q = Quality::default();
    let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|v| points[v])).collect();
    let mut angles: Vec<f32> = corners.iter().map(|&t| min_angle(t)).collect();
    angles.sort_by(f32::total_cmp);
    q.min_angle = angles.first().copied().unwrap_or(0.0);
    q.p5 = angles.get(angles.len() / 20).copied().unwrap_or(0.0);
    q.under30 = angles.partition_point(|&a| a < 30.0) as f32 / angles.len().max(1) as f32;
    let edges = edges(triangles);
    (q.valence6, q.rms) = of_edges(&edges, points, target);
    let segments = edges.keys().map(|&[a, b]| [points[a], points[b], points[b]]).collect();
    (q.curve_max, q.curve_near) = of_curves(&Nearest::new(segments), reference);
    q.to_surface = farthest(&Nearest::new(reference.surface.to_vec()), &corners, reference.target);
    q.from_surface = farthest(&Nearest::new(corners), reference.surface, reference.target);
    q
}

/// The edges with the number of their triangles.
fn edges(triangles: &[[usize; 3]]) -> HashMap<[usize; 2], usize> {
    let mut edges = HashMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    edges
}

/// Share of interior vertices of valence 6, and the root mean square of length / target - 1.
fn of_edges(edges: &HashMap<[usize; 2], usize>, points: &[Vec3], target: &[f32]) -> (f32, f32) {
    let mut valence = vec![0usize; points.len()];
    let mut border = vec![false; points.len()];
    let mut sum = 0.0f64;
    for (&[a, b], &faces) in edges {
        let wanted = 0.5 * (target[a] + target[b]);
        sum += f64::from(points[a].distance(points[b]) / wanted - 1.0).powi(2);
        for v in [a, b] {
            valence[v] += 1;
            border[v] |= faces != 2;
        }
    }
    let interior: Vec<usize> = (0..points.len()).filter(|&v| !border[v] && valence[v] > 0).collect();
    let regular = interior.iter().filter(|&&v| valence[v] == 6).count();
    (regular as f32 / interior.len().max(1) as f32, (sum / edges.len().max(1) as f64).sqrt() as f32)
}

fn of_curves(edges: &Nearest, reference: &Reference<'_>) -> (f32, f32) {
    let (mut most, mut near, mut whole) = (0.0f32, 0.0f64, 0.0f64);
    for pair in reference.curves.iter().flat_map(|c| c.windows(2)) {
        let length = f64::from(pair[0].distance(pair[1])) / STEPS as f64;
        for k in 0..STEPS {
            let p = pair[0].lerp(pair[1], (k as f32 + 0.5) / STEPS as f32);
            let off = edges.find(p).1 / (reference.target)(p);
            most = most.max(off);
            whole += length;
            near += if off <= 0.02 { length } else { 0.0 };
        }
    }
    (most, if whole > 0.0 { (near / whole) as f32 } else { 1.0 })
}

/// The farthest of corners, centres and points on the sides of triangles.
fn farthest(from: &Nearest, triangles: &[[Vec3; 3]], target: &dyn Fn(Vec3) -> f32) -> f32 {
    let samples = triangles.iter().flat_map(|&[a, b, c]| {
        let side = |p: Vec3, q: Vec3| (0..STEPS).map(move |k| p.lerp(q, k as f32 / STEPS as f32));
        std::iter::once((a + b + c) / 3.0).chain(side(a, b)).chain(side(b, c)).chain(side(c, a))
    });
    samples.map(|p| from.find(p).1 / target(p)).fold(0.0, f32::max)
}
