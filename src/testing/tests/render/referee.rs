//! The limit surface of a mesh to measure against, and what is measured on render meshes. Facets would be a third of the
//! tolerance off where cloth turns sharply. A patch through nine points of each face is not: its error falls with the
//! cube of the faces' size, and a test of `surface` holds it to a tenth of the tolerance.

use super::cloth::limit;
use crate::nearest::Nearest;
use crate::operators::rendered;
use glam::Vec3;
use std::collections::BTreeSet;
use tailor::pipeline::mean_edge_length;
use tailor_mesh::connectivity::{FaceId, IdVec, VertexId};
use tailor_mesh::garment::{Elements, Mesh};
use tailor_mesh::subdivide::child_corner;

/// Steps to the nearest point of a patch. They start within a quarter of it, and three suffice nearly everywhere.
const STEPS: usize = 6;

/// The nearest point of a surface.
#[derive(Clone, Copy)]
pub struct Foot {
    pub place: Vec3,
    /// The surface's normal there, by the winding of its faces.
    pub normal: Vec3,
    /// Distance of what was looked from.
    pub off: f32,
}

/// A limit surface as patches of degree two either way, through limit points on a grid of three by three for each face.
pub struct LimitPatches {
    patches: Vec<[Vec3; 9]>,
    /// Eight triangles for each patch, in its order.
    triangles: Nearest,
}

impl LimitPatches {
    /// The limit surface of a mesh, with a patch for each of its faces after `level` refinements, which are quads.
    pub fn new(mesh: &Mesh, level: u32) -> Self {
        let coarse = plain(mesh, level);
        let fine = plain(mesh, level + 1);
        let places = limit(&fine);
        let patches: Vec<[Vec3; 9]> = coarse.faces.ids().map(|face| grid_of(&coarse, face, &fine, &places)).collect();
        let cells = |p: &[Vec3; 9]| {
            let cell = |i: usize| [[p[i], p[i + 1], p[i + 4]], [p[i], p[i + 4], p[i + 3]]];
            [0, 1, 3, 4].map(cell).into_iter().flatten().collect::<Vec<_>>()
        };
        let triangles = Nearest::new(patches.iter().flat_map(cells).collect());
        Self { patches, triangles }
    }

    /// The nearest point of the surface.
    pub fn foot(&self, from: Vec3) -> Foot {
        let (triangle, flat) = self.triangles.find(from);
        let (patch, cell) = (&self.patches[triangle / 8], triangle % 8 / 2);
        let at = |[u, v]: [f32; 2]| (evaluated(patch, u, v), [u, v]);
        let off = |((place, ..), _): &((Vec3, Vec3, Vec3), [f32; 2])| from.distance(*place);
        let mut now = at([0.25 + 0.5 * (cell % 2) as f32, 0.25 + 0.5 * (cell / 2) as f32]);
        let mut best = now;
        for _ in 0..STEPS {
            let ((place, along_u, along_v), uv) = now;
            now = at(stepped(uv, from - place, along_u, along_v));
            if off(&now) < off(&best) {
                best = now;
            }
        }
        let (place, along_u, along_v) = best.0;
        // A face without area gives no step: its triangles are as near as anything.
        let off = off(&best);
        let off = if off > 2.0 * flat + patch[0].distance(patch[8]) { flat } else { off };
        Foot { place, normal: along_u.cross(along_v).normalize_or_zero(), off }
    }

    /// Height of a point over the surface, along its normal.
    pub fn height(&self, from: Vec3) -> f32 {
        let foot = self.foot(from);
        foot.off.copysign((from - foot.place).dot(foot.normal))
    }
}

/// A mesh after refinements alone, with its subsets.
pub fn plain(mesh: &Mesh, level: u32) -> Mesh {
    rendered(mesh, &[format!("render.level={level}")]).0
}

/// Limit points on a quad: its vertices, the middles of its edges and its centre, row by row.
fn grid_of(coarse: &Mesh, face: FaceId, fine: &Mesh, places: &IdVec<VertexId, Vec3>) -> [Vec3; 9] {
    let corners: Vec<_> = coarse.faces.corners_of(face).collect();
    assert_eq!(corners.len(), 4, "refined faces are quads");
    let at = |k: usize, step: usize| places[fine.faces.vertex(child_corner(&coarse.faces, corners[k], step))];
    [at(0, 0), at(0, 1), at(1, 0), at(0, 3), at(0, 2), at(1, 1), at(3, 0), at(2, 1), at(2, 0)]
}

/// Weights of three even knots at a parameter from 0 to 1, and their derivatives.
fn weights(t: f32) -> ([f32; 3], [f32; 3]) {
    let values = [(2.0 * t - 1.0) * (t - 1.0), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)];
    (values, [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0])
}

/// The point of a patch and its derivatives.
fn evaluated(patch: &[Vec3; 9], u: f32, v: f32) -> (Vec3, Vec3, Vec3) {
    let ((wu, du), (wv, dv)) = (weights(u), weights(v));
    let sum = |a: &[f32; 3], b: &[f32; 3]| (0..9).map(|i| a[i % 3] * b[i / 3] * patch[i]).sum::<Vec3>();
    (sum(&wu, &wv), sum(&du, &wv), sum(&wu, &dv))
}

/// One step of Gauss and Newton within the patch. At a side of it, the other parameter goes as far as it would alone.
fn stepped([u, v]: [f32; 2], rest: Vec3, along_u: Vec3, along_v: Vec3) -> [f32; 2] {
    let (a, b, c) = (along_u.length_squared(), along_u.dot(along_v), along_v.length_squared());
    let (p, q) = (rest.dot(along_u), rest.dot(along_v));
    let safe = |x: f32, y: f32| if y > f32::MIN_POSITIVE { x / y } else { 0.0 };
    let area = a * c - b * b;
    let is_flat = area <= 1e-6 * a * c;
    let (du, dv) = if is_flat { (safe(p, a), safe(q, c)) } else { ((p * c - q * b) / area, (q * a - p * b) / area) };
    let within = |t: f32, dt: f32| (t + dt).clamp(0.0, 1.0);
    let (new_u, new_v) = (within(u, du), within(v, dv));
    if new_u != u + du {
        return [new_u, within(v, safe(q - b * (new_u - u), c))];
    }
    if new_v != v + dv {
        return [within(u, safe(p - b * (new_v - v), a)), new_v];
    }
    [new_u, new_v]
}

/// The edges of an edge set; none where there is no such.
pub fn edges_in(mesh: &Mesh, name: &str) -> Vec<[VertexId; 2]> {
    match mesh.subset(name).map(|s| &s.elements) {
        Some(Elements::Edges(edges)) => edges.clone(),
        _ => Vec::new(),
    }
}

/// Edges between places.
pub fn segments(edges: &[[VertexId; 2]], places: &IdVec<VertexId, Vec3>) -> Nearest {
    Nearest::new(edges.iter().map(|&[a, b]| [places[a], places[b], places[b]]).collect())
}

/// The measure of a render mesh: a garment's limit surface, and the limit curves of edge sets of it.
pub struct Held {
    pub surface: LimitPatches,
    pub seams: Nearest,
    /// Mean edge of the garment, the measure of all.
    pub edge: f32,
}

/// A point and how far it is from where it should be. \[mean edges\]
#[derive(Clone, Copy)]
pub struct Off {
    pub off: f32,
    pub vertex: VertexId,
    pub place: Vec3,
}

impl Held {
    /// The garment's own, with patches of `level` refinements.
    pub fn new(garment: &Mesh, seams: &[&str], level: u32) -> Self {
        let fine = plain(garment, level + 1);
        let edges: Vec<_> = seams.iter().flat_map(|name| edges_in(&fine, name)).collect();
        assert!(!edges.is_empty(), "no edges in {seams:?}");
        let (surface, seams) = (LimitPatches::new(garment, level), segments(&edges, &limit(&fine)));
        Self { surface, seams, edge: mean_edge_length(garment) }
    }

    /// The limit points of a mesh that are farther from the seams than `width`, from the worst on.
    pub fn beyond(&self, mesh: &Mesh, width: f32) -> Vec<Off> {
        let places = limit(mesh);
        let used: BTreeSet<VertexId> = mesh.faces.corners().iter().copied().collect();
        let all = places.enumerated().map(|(v, &p)| (v, p)).filter(|(v, _)| used.contains(v));
        let far = all.filter(|&(_, p)| self.seams.find(p).1 > width);
        let judged = |(vertex, place)| Off { off: self.surface.foot(place).off / self.edge, vertex, place };
        let mut all: Vec<Off> = far.map(judged).collect();
        all.sort_by(|a, b| b.off.total_cmp(&a.off));
        all
    }

    /// A point with its distances, for a message.
    pub fn tell(&self, worst: &Off) -> String {
        let from_seam = self.seams.find(worst.place).1 / self.edge;
        format!("{:.4} edges off at {}, which is {from_seam:.3} from the seam", worst.off, worst.place)
    }
}
