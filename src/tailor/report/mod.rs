//! Quality figures of the simulation and render meshes.
//!
//! The summary, the JSON report, tests and benches all use these definitions. Shares are between 0 and 1.

mod costs;
mod surface;

pub use costs::ConstraintCost;
pub use surface::{BluntRidge, NarrowFeature, facing};

use crate::sim::SimProduct;
use crate::transfer::{SetCurve, TransferResult};
use glam::Vec3;
use serde::Serialize;
use tailor_mesh::connectivity::{CornerId, IdVec, Topology, VertexId};
use tailor_mesh::garment::{Elements, Mesh};

/// Share of its target below which an edge costs a solver its time step.
const SHORT: f32 = 0.2;

/// Figures of a simulation mesh.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SimFigures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub faces: usize,
    /// Smallest angle of any triangle. \[degrees\]
    pub min_angle: f32,
    /// 1st percentile of the triangles' smallest angles. \[degrees\]
    pub min_angle_p1: f32,
    /// 5th percentile of the triangles' smallest angles. \[degrees\]
    pub min_angle_p5: f32,
    /// Share of triangles with an angle below 20 degrees.
    pub share_under20: f32,
    /// Share of triangles with an angle below 30 degrees.
    pub share_under30: f32,
    /// Share of interior vertices with six neighbours.
    pub valence6: f32,
    /// Share of interior vertices with five to seven neighbours.
    pub valence5to7: f32,
    /// Mean of |length / target - 1| over the edges.
    pub length_error_mean: f32,
    /// Root mean square of length / target - 1 over the edges.
    pub length_error_rms: f32,
    /// Share of edges between 4/5 and 4/3 of their target length (the split and collapse bounds of Botsch and Kobbelt
    /// 2004).
    pub lengths_in_band: f32,
    /// Length of the shortest edge, as a share of its target.
    pub shortest_edge: f32,
    /// The edges that are shorter than a fifth of their target, shortest first, as vertices of the simulation mesh.
    pub short_edges: Vec<[usize; 2]>,
    /// Share of interior edges whose opposite angles sum to more than π, including constrained edges.
    pub non_delaunay: f32,
    /// Largest distance of the mesh from the baseline, as a share of the target length.
    pub distance_max: f32,
    /// Mean distance of the mesh from the baseline, as a share of the target length.
    pub distance_mean: f32,
    /// Smallest ratio of a constraint chain's length on the mesh to that of its curve.
    pub chain_length_min: f32,
    /// Largest distance of a chain's curve from the edges that follow it, as a share of the target length.
    pub chain_distance_max: f32,
    /// Number of triangles that are flipped in UV space relative to their shell, where the garment's UVs are not flipped.
    pub uv_flips: usize,
    /// Number of triangles that face away from the surface that they lie on.
    pub facing_away: usize,
    /// Share of triangles at more than 60 degrees to the surface that they lie on.
    pub share_steep: f32,
    /// Sharp edges that are too near to a border, a seam or other sharp edges for a feature line of their own.
    pub narrow_features: Vec<NarrowFeature>,
    /// Lines of edges that are nearly sharp enough for a feature line, so that triangles may cut them off.
    pub blunt_ridges: Vec<BluntRidge>,
    /// The constraints by the thin triangles beside them.
    pub constraint_costs: Vec<ConstraintCost>,
    /// Area of each face subset on the mesh and on the baseline.
    pub subset_areas: Vec<SubsetArea>,
    /// Length of each edge subset on the mesh and on the baseline.
    pub edge_sets: Vec<EdgeSet>,
    /// Number of stray faces that `sim.cleanIslands` merged into the face set around them.
    pub islands_cleaned: usize,
}

/// Length of an edge subset.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EdgeSet {
    /// Name of the subset.
    pub name: String,
    /// Length on the product. \[mesh units\]
    pub length: f64,
    /// Length on the baseline. \[mesh units\]
    pub source_length: f64,
    /// Largest distance of a vertex of the product's set from the baseline's, in local target lengths.
    pub farthest: f32,
}

/// Area of a face subset.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SubsetArea {
    /// Name of the subset.
    pub name: String,
    /// Area on the product. \[square mesh units\]
    pub area: f64,
    /// Area on the baseline. \[square mesh units\]
    pub source_area: f64,
    /// Area of the intersection of the set and its source over that of their union; 1 if they are equal. Both are
    /// measured on the baseline by the transfer samples.
    pub overlap: f64,
}

/// Figures of a render mesh.
#[derive(Clone, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RenderFigures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of faces, holes included.
    pub faces: usize,
    /// Share of faces with four corners.
    pub quads: f32,
}

impl RenderFigures {
    /// The figures of a render mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let quads = mesh.faces.ids().filter(|&f| mesh.faces.valence(f) == 4).count();
        Self { vertices: mesh.points.len(), faces: mesh.faces.len(), quads: share(quads, mesh.faces.len()) }
    }
}

/// The quality of each triangle of a simulation mesh.
#[derive(Clone, Debug, Default)]
pub struct TriangleQuality {
    /// Smallest angle. \[degrees\]
    pub angles: Vec<f32>,
    /// Mean length of the edges. \[target lengths\]
    pub lengths: Vec<f32>,
}

impl TriangleQuality {
    /// Measures a simulation mesh.
    pub fn new(product: &SimProduct) -> Self {
        let of_points = |t: &[VertexId; 3]| t.map(|v| product.points[v]);
        let length = |t: &[VertexId; 3]| {
            let [a, b, c] = of_points(t);
            let target: f32 = t.iter().map(|&v| product.target[v]).sum();
            (a.distance(b) + b.distance(c) + c.distance(a)) / target
        };
        Self {
            angles: product.triangles.iter().map(|t| min_angle(of_points(t))).collect(),
            lengths: product.triangles.iter().map(length).collect(),
        }
    }
}

impl SimFigures {
    /// Measures a simulation mesh.
    ///
    /// `topology` is its own, `mesh` the product with its attributes, and `curves` are the edge subsets on the baseline.
    pub fn new(
        product: &SimProduct,
        topology: &Topology,
        mesh: &Mesh,
        curves: &[SetCurve],
        subset_areas: Vec<SubsetArea>,
        islands_cleaned: usize,
    ) -> Self {
        let mut figures = Self {
            vertices: product.points.len(),
            faces: product.triangles.len(),
            uv_flips: uv_flips(product).len(),
            subset_areas,
            edge_sets: edge_sets(product, mesh, curves),
            islands_cleaned,
            constraint_costs: costs::constraint_costs(product, mesh),
            chain_length_min: chain_length_min(product),
            chain_distance_max: product.gaps.iter().map(|gap| gap.distance).fold(0.0, f32::max),
            ..Self::default()
        };
        figures.set_angles(product);
        figures.set_edges(product, topology);
        figures.set_surface(product);
        figures
    }

    fn set_angles(&mut self, product: &SimProduct) {
        let mut smallest: Vec<f32> =
            product.triangles.iter().map(|t| min_angle(t.map(|v| product.points[v]))).collect();
        smallest.sort_by(f32::total_cmp);
        let at = |share: f64| smallest.get((smallest.len() as f64 * share) as usize).copied().unwrap_or(0.0);
        self.min_angle = at(0.0);
        self.min_angle_p1 = at(0.01);
        self.min_angle_p5 = at(0.05);
        self.share_under20 = share(smallest.partition_point(|&a| a < 20.0), smallest.len());
        self.share_under30 = share(smallest.partition_point(|&a| a < 30.0), smallest.len());
    }

    fn set_edges(&mut self, product: &SimProduct, t: &Topology) {
        let mut errors = Vec::with_capacity(t.edges.len());
        let mut border = IdVec::<VertexId, bool>::filled(false, t.vertex_count());
        let mut valence = IdVec::<VertexId, u32>::filled(0, t.vertex_count());
        let (mut non_delaunay, mut interior_edges) = (0, 0);
        for (edge, &[a, b]) in t.edges.enumerated() {
            let target = 0.5 * (product.target[a] + product.target[b]);
            errors.push(product.points[a].distance(product.points[b]) / target - 1.0);
            valence[a] += 1;
            valence[b] += 1;
            match t.edge_corners.row(edge) {
                &[c, d] => {
                    interior_edges += 1;
                    let opposite = |c: CornerId| angle_at(&product.points, t.faces.vertex(t.faces.prev(c)), a, b);
                    non_delaunay += usize::from(opposite(c) + opposite(d) > std::f32::consts::PI + 1e-4);
                }
                _ => {
                    border[a] = true;
                    border[b] = true;
                }
            }
        }
        let mean = |f: &dyn Fn(f32) -> f32| {
            (errors.iter().map(|&e| f64::from(f(e))).sum::<f64>() / errors.len().max(1) as f64) as f32
        };
        let mut short: Vec<(f32, [usize; 2])> = errors
            .iter()
            .zip(t.edges.iter())
            .filter(|(e, _)| **e + 1.0 < SHORT)
            .map(|(e, ends)| (*e, ends.map(|v| v.index())))
            .collect();
        short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.shortest_edge = 1.0 + errors.iter().copied().fold(f32::INFINITY, f32::min);
        self.short_edges = short.into_iter().map(|(_, ends)| ends).collect();
        self.length_error_mean = mean(&f32::abs);
        self.length_error_rms = mean(&|e| e * e).sqrt();
        let in_band = errors.iter().filter(|&&e| (0.8..=4.0 / 3.0).contains(&(e + 1.0))).count();
        self.lengths_in_band = share(in_band, errors.len());
        self.non_delaunay = share(non_delaunay, interior_edges);
        let interior: Vec<u32> =
            valence.enumerated().filter(|(v, n)| !border[*v] && **n > 0).map(|(_, &n)| n).collect();
        self.valence6 = share(interior.iter().filter(|&&n| n == 6).count(), interior.len());
        self.valence5to7 = share(interior.iter().filter(|&&n| (5..=7).contains(&n)).count(), interior.len());
    }

    /// Samples the distance to the baseline at the centre and the edge midpoints of each triangle, and its angle to it.
    fn set_surface(&mut self, product: &SimProduct) {
        let triangles = surface::on_surface(product);
        let all = || triangles.iter().flat_map(|triangle| triangle.distances);
        let beyond = |most: f32| triangles.iter().filter(|triangle| triangle.angle > most).count();
        self.distance_max = all().fold(0.0, f32::max);
        self.distance_mean = (all().map(f64::from).sum::<f64>() / (4 * triangles.len()).max(1) as f64) as f32;
        self.facing_away = beyond(90.0);
        self.share_steep = share(beyond(surface::STEEP), triangles.len());
        self.narrow_features = surface::narrow_features(product);
        self.blunt_ridges = surface::blunt_ridges(product);
    }
}

fn share(part: usize, whole: usize) -> f32 {
    if whole == 0 { 0.0 } else { (part as f64 / whole as f64) as f32 }
}

/// The angle at `apex` between two other points. \[radians\]
fn angle_at(points: &IdVec<VertexId, Vec3>, apex: VertexId, a: VertexId, b: VertexId) -> f32 {
    angle(points[a] - points[apex], points[b] - points[apex])
}

fn angle(u: Vec3, v: Vec3) -> f32 {
    u.cross(v).length().atan2(u.dot(v))
}

/// The smallest angle of a triangle. \[degrees\]
pub fn min_angle([a, b, c]: [Vec3; 3]) -> f32 {
    angle(b - a, c - a).min(angle(c - b, a - b)).min(angle(a - c, b - c)).to_degrees()
}

/// The triangles that are flipped, or have no area, in the UVs.
pub fn uv_flips(product: &SimProduct) -> Vec<usize> {
    if !product.baseline.has_uvs {
        return Vec::new();
    }
    let flipped = |i: &usize| {
        let [a, b, c] = [0, 1, 2].map(|k| product.places[CornerId::new(3 * i + k)]);
        let area = (b.uv - a.uv).perp_dot(c.uv - a.uv);
        let senses = [a, b, c].map(|place| product.baseline.facets[place.location.face].sense);
        // Where the layout is free, UVs are approximate.
        area * senses[0] <= 0.0 && senses.iter().all(|&sense| sense != 0.0)
    };
    (0..product.triangles.len()).filter(flipped).collect()
}

fn chain_length_min(product: &SimProduct) -> f32 {
    let kept = product.baseline.chains.enumerated().map(|(id, chain)| {
        let own: f64 = product.chain_edges[id]
            .iter()
            .map(|&[a, b]| f64::from(product.points[a].distance(product.points[b])))
            .sum();
        if chain.length() > 0.0 { own as f32 / chain.length() } else { 1.0 }
    });
    kept.fold(1.0, f32::min)
}

/// The areas of the face subsets of `garment` on the baseline and on the simulation mesh.
pub fn subset_areas(product: &SimProduct, transferred: &TransferResult, garment: &Mesh) -> Vec<SubsetArea> {
    let TransferResult { mesh, coverage, .. } = transferred;
    let triangle_area = |[a, b, c]: [Vec3; 3]| 0.5 * f64::from((b - a).cross(c - a).length());
    let own: Vec<f64> = product.triangles.iter().map(|t| triangle_area(t.map(|v| product.points[v]))).collect();
    let sets = garment.subsets.iter().filter_map(|s| match (&s.elements, mesh.subset(&s.name).map(|m| &m.elements)) {
        (Elements::Faces(of), Some(Elements::Faces(on))) => Some(SubsetArea {
            name: s.name.clone(),
            area: on.iter().map(|f| own[f.index()]).sum(),
            source_area: of.iter().map(|&f| coverage.source_area[f]).sum(),
            overlap: coverage.overlap(of, on),
        }),
        _ => None,
    });
    sets.collect()
}

fn edge_sets(product: &SimProduct, mesh: &Mesh, curves: &[SetCurve]) -> Vec<EdgeSet> {
    let length = |name: &str| match mesh.subset(name).map(|s| &s.elements) {
        Some(Elements::Edges(edges)) => {
            edges.iter().map(|&[a, b]| f64::from(product.points[a].distance(product.points[b]))).sum()
        }
        _ => 0.0,
    };
    let set = |c: &SetCurve| EdgeSet {
        name: c.name.clone(),
        length: length(&c.name),
        source_length: c.length,
        farthest: c.farthest,
    };
    curves.iter().map(set).collect()
}
