//! Our simulation mesh against one that is stitched from hexagonal lattices, one for each UV panel, clipped at the constraints: the
//! way that figure 1 of Waggoner and de Goes 2022 compares with.
//!
//! Both have the same vertices on the constraints and one target length. *Irregular* counts inner vertices within three edges of a
//! constraint that have not six neighbours, *far* those farther away. Angles are the smallest of each triangle, in degrees.

use super::{folder, remeshed};
use crate::prepared::{Prepared, of_file};
use glam::{Vec2, Vec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;
use std::path::Path;
use tailor::report::min_angle;
use tailor::sim::{Baseline, SimProduct};
use tailor_mesh::connectivity::{CornerId, FaceId, Groups, IdVec, VertexId};
use tailor_testing::garments::garments;

/// Distance of lattice points from constraints, in lengths. Smaller values make slivers along them.
const MARGIN: f32 = 0.5;
/// Rings of edges that are near a constraint.
const NEAR: usize = 3;

struct LatticeMesh {
    points: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
    /// Vertices on constraints and borders.
    constrained: BTreeSet<usize>,
}

#[test]
#[ignore = "prints a table; run cargo xtask peers"]
fn table() {
    println!(
        "{:24} {:8} {:>8} {:>10} {:>7} {:>6} {:>6} {:>7}",
        "garment", "mesh", "vertices", "irregular", "far", "p1", "p5", "<30 %"
    );
    for file in garments() {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let prepared = of_file(&file, ["sim.density=", "sim.minEdgeLength=0"]);
        if prepared.garment.primvar(&prepared.recipe.sim.uv_set).is_none() {
            println!("{name:24} has no UV panels");
            continue;
        }
        let product = remeshed(&prepared);
        for (kind, mesh) in [("ours", own(&product)), ("lattice", lattice(&prepared, &product))] {
            println!("{name:24} {kind:8} {}", figures(&mesh));
            if let Some(folder) = folder("PEERS_EXPORT") {
                write(&folder.join(format!("{name}.{kind}.obj")), &mesh);
            }
        }
    }
}

fn on_chains(product: &SimProduct) -> BTreeSet<usize> {
    product.chain_edges.iter().flatten().flatten().map(|v| v.index()).collect()
}

fn own(product: &SimProduct) -> LatticeMesh {
    LatticeMesh {
        points: product.points.iter().copied().collect(),
        triangles: product.triangles.iter().map(|t| t.map(VertexId::index)).collect(),
        constrained: on_chains(product),
    }
}

/// The region of each triangle of the baseline between chains.
fn regions(base: &Baseline) -> Vec<FaceId> {
    let mut groups = Groups::<FaceId>::new(base.topology.faces.len());
    for corner in base.topology.faces.corners().ids().filter(|&c| !base.barrier[c]) {
        if let Some(twin) = base.topology.twin(corner) {
            groups.join(base.topology.faces.face_of(corner), base.topology.faces.face_of(twin));
        }
    }
    base.topology.faces.ids().map(|face| groups.first(face)).collect()
}

/// The mesh of lattices: our vertices on the chains, and a lattice inside each panel.
fn lattice(prepared: &Prepared, product: &SimProduct) -> LatticeMesh {
    let base = &product.baseline;
    let region_of = regions(base);
    let mut own: BTreeMap<FaceId, Vec<usize>> = BTreeMap::new();
    for face in 0..product.triangles.len() {
        let [a, b, c] = [0, 1, 2].map(|k| region_of[product.places[CornerId::new(3 * face + k)].location.face.index()]);
        own.entry(if b == c { b } else { a }).or_default().push(face);
    }
    let mut surface: BTreeMap<FaceId, Vec<FaceId>> = BTreeMap::new();
    base.topology.faces.ids().for_each(|face| surface.entry(region_of[face.index()]).or_default().push(face));
    let mut mesh = self::own(product);
    mesh.triangles.clear();
    let chain: BTreeSet<[usize; 2]> = product
        .chain_edges
        .iter()
        .flatten()
        .map(|e| e.map(VertexId::index))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    for (region, faces) in &own {
        panel(prepared, product, faces, &surface[region], &chain, &mut mesh);
    }
    mesh
}

/// Adds the lattice of one panel.
fn panel(
    prepared: &Prepared,
    product: &SimProduct,
    faces: &[usize],
    surface: &[FaceId],
    chain: &BTreeSet<[usize; 2]>,
    mesh: &mut LatticeMesh,
) {
    let base = &product.baseline;
    let uvs = |face: FaceId| [0, 1, 2].map(|k| base.uvs[CornerId::new(3 * face.index() + k)]);
    let area = |[a, b, c]: [Vec2; 3]| 0.5 * (b - a).perp_dot(c - a);
    let of_uvs: f32 = surface.iter().map(|&f| area(uvs(f)).abs()).sum();
    let in_space: f32 = surface.iter().map(|&f| 0.5 * base.normal(f).length()).sum();
    let sense = surface.iter().map(|&f| area(uvs(f))).sum::<f32>().signum();
    let length = prepared.recipe.sim.max_edge_length * (of_uvs / in_space).sqrt();
    let grid = Grid::new(surface.iter().map(|&f| (f, uvs(f))).collect(), length);
    // Constrained edges of this panel, by vertex and UV.
    let mut vertices: HashMap<(usize, [u32; 2]), usize> = HashMap::new();
    let (mut points, mut global): (Vec<Vec2>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut edges = Vec::new();
    for &face in faces {
        for k in 0..3 {
            let corners = [k, (k + 1) % 3].map(|k| CornerId::new(3 * face + k));
            let ends = [k, (k + 1) % 3].map(|k| product.triangles[face][k].index());
            if chain.contains(&[ends[0].min(ends[1]), ends[0].max(ends[1])]) {
                edges.push([0, 1].map(|i| {
                    let uv = product.places[corners[i]].uv;
                    *vertices.entry((ends[i], uv.to_array().map(f32::to_bits))).or_insert_with(|| {
                        points.push(uv);
                        global.push(ends[i]);
                        points.len() - 1
                    })
                }));
            }
        }
    }
    let near = Near::new(edges.iter().map(|e| e.map(|i| points[i])).collect(), length);
    for uv in hexagonal(&points, length) {
        if let Some(position) = grid.position(uv, base).filter(|_| near.distance(uv) > MARGIN * length) {
            points.push(uv);
            global.push(mesh.points.len());
            mesh.points.push(position);
        }
    }
    let mut delaunay = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut index = HashMap::new();
    let mut handles = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        let Ok(handle) = delaunay.insert(Point2::new(f64::from(p.x), f64::from(p.y))) else { return };
        index.entry(handle.index()).or_insert(i);
        handles.push(handle);
    }
    for [a, b] in edges {
        if handles[a] != handles[b] && delaunay.can_add_constraint(handles[a], handles[b]) {
            delaunay.add_constraint(handles[a], handles[b]);
        }
    }
    for face in delaunay.inner_faces() {
        let corners = face.vertices().map(|v| index[&v.fix().index()]);
        let centre = corners.iter().map(|&i| points[i]).sum::<Vec2>() / 3.0;
        let mut triangle = corners.map(|i| global[i]);
        let is_apart = triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0];
        if is_apart && grid.position(centre, base).is_some() {
            if sense < 0.0 {
                triangle.swap(1, 2);
            }
            mesh.triangles.push(triangle);
        }
    }
}

/// The points of a hexagonal lattice over the box of some points.
fn hexagonal(points: &[Vec2], length: f32) -> Vec<Vec2> {
    let Some(&first) = points.first() else { return Vec::new() };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)));
    let row = length * 0.75f32.sqrt();
    let rows = ((high.y - low.y) / row) as usize + 1;
    let columns = ((high.x - low.x) / length) as usize + 2;
    let at = |i: usize, j: usize| low + Vec2::new(length * (i as f32 - 0.5 * (j % 2) as f32), row * j as f32);
    (0..rows).flat_map(|j| (0..columns).map(move |i| at(i, j))).collect()
}

/// Cells of a plane with what lies in each.
type Cells<T> = HashMap<[i32; 2], Vec<T>>;

fn cells_of(low: Vec2, high: Vec2, size: f32) -> impl Iterator<Item = [i32; 2]> {
    let [x0, y0, x1, y1] = [low.x, low.y, high.x, high.y].map(|v| (v / size).floor() as i32);
    (x0..=x1).flat_map(move |x| (y0..=y1).map(move |y| [x, y]))
}

/// Triangles of the surface in UV.
struct Grid {
    cells: Cells<(FaceId, [Vec2; 3])>,
    size: f32,
}

impl Grid {
    fn new(triangles: Vec<(FaceId, [Vec2; 3])>, size: f32) -> Self {
        let mut cells: Cells<(FaceId, [Vec2; 3])> = HashMap::new();
        for (face, [a, b, c]) in triangles {
            for cell in cells_of(a.min(b).min(c), a.max(b).max(c), size) {
                cells.entry(cell).or_default().push((face, [a, b, c]));
            }
        }
        Self { cells, size }
    }

    /// The point of the surface at a UV; none outside.
    fn position(&self, uv: Vec2, base: &Baseline) -> Option<Vec3> {
        let cell = [uv.x, uv.y].map(|v| (v / self.size).floor() as i32);
        self.cells.get(&cell)?.iter().find_map(|&(face, [a, b, c])| {
            let whole = (b - a).perp_dot(c - a);
            let weights =
                [(c - b).perp_dot(uv - b), (a - c).perp_dot(uv - c), (b - a).perp_dot(uv - a)].map(|w| w / whole);
            let corners = base.triangle(face);
            let inside = weights.iter().all(|w| *w >= -1e-5);
            inside.then(|| corners.iter().zip(weights).map(|(&p, w)| w * p).sum())
        })
    }
}

/// Constrained edges in UV.
struct Near {
    cells: Cells<[Vec2; 2]>,
    size: f32,
}

impl Near {
    fn new(edges: Vec<[Vec2; 2]>, size: f32) -> Self {
        let mut cells: Cells<[Vec2; 2]> = HashMap::new();
        for [a, b] in edges {
            for cell in cells_of(a.min(b) - size, a.max(b) + size, size) {
                cells.entry(cell).or_default().push([a, b]);
            }
        }
        Self { cells, size }
    }

    /// The distance of the nearest edge; infinite beyond a cell.
    fn distance(&self, p: Vec2) -> f32 {
        let cell = [p.x, p.y].map(|v| (v / self.size).floor() as i32);
        let to = |&[a, b]: &[Vec2; 2]| {
            let t = (p - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE);
            p.distance(a.lerp(b, t.clamp(0.0, 1.0)))
        };
        self.cells.get(&cell).into_iter().flatten().map(to).fold(f32::INFINITY, f32::min)
    }
}

fn figures(mesh: &LatticeMesh) -> String {
    let mut neighbours: IdVec<VertexId, BTreeSet<usize>> = IdVec::filled(BTreeSet::new(), mesh.points.len());
    let mut edges: HashMap<[usize; 2], u32> = HashMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]];
            neighbours[VertexId::new(a)].insert(b);
            neighbours[VertexId::new(b)].insert(a);
            *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut rings = vec![usize::MAX; mesh.points.len()];
    let mut front: Vec<usize> = mesh.constrained.iter().copied().collect();
    for ring in 0.. {
        front.retain(|&v| rings[v] == usize::MAX);
        if front.is_empty() {
            break;
        }
        front.iter().for_each(|&v| rings[v] = ring);
        front = front.iter().flat_map(|&v| neighbours[VertexId::new(v)].iter().copied()).collect();
    }
    let border: BTreeSet<usize> = edges.iter().filter(|(_, n)| **n != 2).flat_map(|(e, _)| *e).collect();
    let share = |near: bool| {
        let inner = |v: &usize| {
            rings[*v] > 0
                && (rings[*v] <= NEAR) == near
                && !border.contains(v)
                && !neighbours[VertexId::new(*v)].is_empty()
        };
        let all: Vec<usize> = (0..mesh.points.len()).filter(inner).collect();
        let irregular = all.iter().filter(|v| neighbours[VertexId::new(**v)].len() != 6).count();
        100.0 * irregular as f64 / all.len().max(1) as f64
    };
    let mut angles: Vec<f32> = mesh.triangles.iter().map(|t| min_angle(t.map(|v| mesh.points[v]))).collect();
    angles.sort_by(f32::total_cmp);
    let at = |part: f64| angles.get((part * angles.len() as f64) as usize).copied().unwrap_or_default();
    let under = 100.0 * angles.iter().filter(|a| **a < 30.0).count() as f64 / angles.len().max(1) as f64;
    let used = neighbours.iter().filter(|n| !n.is_empty()).count();
    format!("{used:8} {:9.1}% {:6.1}% {:6.1} {:6.1} {under:7.2}", share(true), share(false), at(0.01), at(0.05))
}

fn write(file: &Path, mesh: &LatticeMesh) {
    let mut text = String::new();
    for p in &mesh.points {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    std::fs::write(file, text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
}
