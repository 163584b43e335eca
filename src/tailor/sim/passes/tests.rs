//! Every pass of remeshing, on random grids, tubes and tees with random constraints, weights and lengths: what must hold
//! after each.

use super::collapse::{COLLAPSE_RATIO, collapse_short_edges, length_deficit};
use super::drift::drift;
use super::finish::follow_curves;
use super::flip::flip_edges;
use super::queue::keyed_by_both;
use super::remesh::{LAST_REGULARITY, Pass, PassContext, RemeshReport, remesh};
use super::split::{length_excess, split_long_edges};
use crate::sim::sim_mesh::{SimMesh, VertexConstraint};
use crate::sim::surface::lengths::{Lengths, SPLIT_RATIO};
use crate::sim::{Baseline, Relaxation, SimOptions, simulate};
use glam::Vec3;
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use std::collections::{BTreeMap, BTreeSet};
use tailor_mesh::connectivity::edit::face;
use tailor_mesh::connectivity::{ChainId, CornerId, VertexId};
use tailor_mesh::garment::{Garment, Mesh, check_garment};
use tailor_testing::cases::few;
use tailor_testing::sheets;

/// A bound that no mesh here reaches.
const MAX_FACES: usize = 200_000;

/// A checked garment with options whose lengths are given.
struct Prepared {
    garment: Mesh,
    options: SimOptions,
}

impl Prepared {
    fn new(input: Garment, options: SimOptions) -> Self {
        Self { garment: check_garment(input).expect("a good mesh").0, options }
    }

    fn baseline(&self) -> Baseline {
        let Self { garment, options } = self;
        let density = garment.primvar(&options.density);
        let lengths = Lengths { min: options.min_edge_length, max: options.max_edge_length, density };
        Baseline::new(garment, options, lengths, garment.primvar(&options.uv_set), options.baseline_level)
    }
}

/// The form of a garment.
#[derive(Clone, Debug)]
enum Shape {
    Grid(usize, usize),
    Tube(usize, usize),
    /// Lengths of the arms of a tee of square tubes.
    Tee([usize; 3]),
}

#[derive(Clone, Debug)]
struct Case {
    shape: Shape,
    shifts: Vec<f32>,
    constraints: Vec<usize>,
    length: f32,
    level: u32,
    is_graded: bool,
}

fn cases() -> impl Strategy<Value = Case> {
    let shape = prop_oneof![
        (1usize..6, 1usize..6).prop_map(|(x, y)| Shape::Grid(x, y)),
        (3usize..9, 1usize..6).prop_map(|(around, along)| Shape::Tube(around, along)),
        prop::array::uniform3(1usize..4).prop_map(Shape::Tee),
    ];
    let shifts = prop::collection::vec(-0.2f32..0.2, 64);
    let constraints = prop::collection::vec(0usize..400, 0..12);
    (shape, shifts, constraints, 0.15f32..2.0, 0u32..3, any::<bool>()).prop_map(
        |(shape, shifts, constraints, length, level, is_graded)| Case {
            shape,
            shifts,
            constraints,
            length,
            level,
            is_graded,
        },
    )
}

/// The surface of unit cubes in the form of a T, open at its three ends, as quads without UVs.
fn tee(arms: [usize; 3]) -> Garment {
    let [left, right, down] = arms.map(|n| n as i32);
    let inside =
        |[x, y, z]: [i32; 3]| z == 0 && (y == 0 && (-left..=right).contains(&x) || x == 0 && (-down..0).contains(&y));
    let is_open =
        |[x, y, z]: [i32; 3]| z == 0 && (y == 0 && (x == -left - 1 || x == right + 1) || x == 0 && y == -down - 1);
    let mut points: Vec<[f32; 3]> = Vec::new();
    let mut number: BTreeMap<[i32; 3], i32> = BTreeMap::new();
    let mut faces: Vec<Vec<i32>> = Vec::new();
    let cubes = (-left..=right).map(|x| [x, 0, 0]).chain((-down..0).map(|y| [0, y, 0]));
    for cube in cubes {
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
            let mut beyond = cube;
            beyond[axis] += sign;
            if inside(beyond) || is_open(beyond) {
                continue;
            }
            let (u, v) = if sign > 0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
            let corner = |(i, j): (i32, i32)| {
                let mut at = cube;
                at[axis] += i32::from(sign > 0);
                at[u] += i;
                at[v] += j;
                at
            };
            let quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(corner).map(|at| {
                *number.entry(at).or_insert_with(|| {
                    points.push(at.map(|c| c as f32));
                    points.len() as i32 - 1
                })
            });
            faces.push(quad.to_vec());
        }
    }
    sheets::mesh(points, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>())
}

impl Case {
    fn input(&self) -> Garment {
        let mut input = match self.shape {
            Shape::Grid(x, y) => sheets::grid(x, y, |_, _| true),
            Shape::Tube(around, along) => sheets::tube(around, along),
            Shape::Tee(arms) => tee(arms),
        };
        for (i, point) in input.points.iter_mut().enumerate() {
            point.z += self.shifts[i % self.shifts.len()];
        }
        let mut edges = BTreeSet::new();
        let mut start = 0;
        for &n in &input.face_vertex_counts {
            let face = &input.face_vertex_indices[start..start + n as usize];
            edges.extend(
                (0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()])).map(|(a, b)| [a.min(b), a.max(b)]),
            );
            start += n as usize;
        }
        let edges: Vec<[i32; 2]> = edges.into_iter().collect();
        let chosen: BTreeSet<[i32; 2]> = self.constraints.iter().map(|&i| edges[i % edges.len()]).collect();
        match chosen.is_empty() {
            true => input,
            false => sheets::with_edges(input, "line", &chosen.into_iter().collect::<Vec<_>>()),
        }
    }

    fn prepared(&self) -> Prepared {
        let mut options = SimOptions { baseline_level: self.level, ..lengths(self.length) };
        if self.is_graded {
            options = SimOptions { density: "density".into(), min_edge_length: 0.25 * self.length, ..options };
        }
        if !self.constraints.is_empty() {
            options.constraints = vec!["line".into()];
        }
        if self.level == 0 {
            // Else the shells of small shapes are not held.
            options.smallest_shell = 0.0;
        }
        Prepared::new(self.input(), options)
    }
}

/// Options for edges of one length.
fn lengths(length: f32) -> SimOptions {
    SimOptions { max_edge_length: length, min_edge_length: length, ..SimOptions::default() }
}

/// The invariants of passes: vertices - edges + faces, border loops, and the curve that the edges of each chain cover.
#[derive(Debug, PartialEq)]
struct Kept {
    euler: i64,
    border_loops: usize,
    /// Where they are, bit by bit.
    anchors: Vec<[u32; 3]>,
}

fn kept(mesh: &SimMesh<'_>) -> Kept {
    let t = &mesh.topology;
    let euler = t.vertices().count() as i64 - t.edges().count() as i64 + t.faces().count() as i64;
    let next_border: BTreeMap<VertexId, VertexId> =
        t.corners().filter(|&c| t.twin(c).is_none()).map(|c| (t.vertex(c), t.target(c))).collect();
    let mut seen = BTreeSet::new();
    let mut border_loops = 0;
    for &start in next_border.keys() {
        let mut at = start;
        border_loops += usize::from(!seen.contains(&start));
        while seen.insert(at) {
            at = next_border[&at];
        }
    }
    let frozen = t.vertices().filter(|&v| mesh.constraint[v] == VertexConstraint::Fixed);
    let mut anchors: Vec<[u32; 3]> = frozen.map(|v| mesh.points[v].to_array().map(f32::to_bits)).collect();
    anchors.sort_unstable();
    Kept { euler, border_loops, anchors }
}

/// A pass alone. In a round, one search finds the edges to split and those to collapse.
#[derive(Clone, Copy, Debug)]
enum Step {
    Split,
    Collapse,
    Pass(Pass),
}

/// The steps of a round in the order of the paper.
const ROUND: [Step; 4] = [Step::Split, Step::Collapse, Step::Pass(Pass::Drift), Step::Pass(Pass::Relax(3))];

impl Step {
    fn run(self, mesh: &mut SimMesh<'_>) {
        match self {
            Self::Split => {
                let (long, _) = keyed_by_both(mesh, |mesh, half| length_excess(mesh, half, SPLIT_RATIO), |_, _| None);
                split_long_edges(mesh, long, SPLIT_RATIO, usize::MAX);
            }
            Self::Collapse => {
                let deficit = |mesh: &SimMesh<'_>, half| length_deficit(mesh, half, COLLAPSE_RATIO);
                let (short, _) = keyed_by_both(mesh, deficit, |_, _| None);
                collapse_short_edges(mesh, short, COLLAPSE_RATIO);
            }
            Self::Pass(pass) => {
                let context = PassContext { relaxation: Relaxation::Surface, max_faces: usize::MAX };
                pass.run(mesh, &context, &mut RemeshReport::default());
            }
        }
    }
}

/// Length of the part of each curve that the mesh's edges follow.
fn covered(mesh: &SimMesh<'_>) -> BTreeMap<ChainId, f64> {
    let mut covered = BTreeMap::new();
    for span in mesh.topology.edges().filter_map(|h| mesh.span(h)) {
        *covered.entry(span.chain).or_default() += f64::from((span.to - span.from).abs());
    }
    covered
}

/// Triangles that lie the wrong way round in UV space.
fn flipped(mesh: &SimMesh<'_>) -> usize {
    let base = mesh.baseline;
    let is_flipped = |f: &tailor_mesh::connectivity::FaceId| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.place(CornerId::new(3 * f.index() + k)));
        let senses = [a, b, c].map(|place| base.facets[place.location.face].sense);
        // Beside small shells UVs are approximate.
        (b.uv - a.uv).perp_dot(c.uv - a.uv) * senses[0] <= 0.0 && senses.iter().all(|&sense| sense != 0.0)
    };
    if base.has_uvs { mesh.topology.faces().filter(is_flipped).count() } else { 0 }
}

/// A sheet of `n` by `n` rhombs, which are two equilateral triangles each.
fn rhombs(n: usize) -> Prepared {
    let mut input = sheets::grid(n, n, |_, _| true);
    for (i, point) in input.points.iter_mut().enumerate() {
        let (x, y) = ((i % (n + 1)) as f32, (i / (n + 1)) as f32);
        *point = Vec3::new(x - 0.5 * y, 0.75f32.sqrt() * y, 0.0);
    }
    Prepared::new(input, SimOptions { baseline_level: 0, ..lengths(1.0) })
}

/// The half-edge that is the `n`th of those inside a sheet, away from its borders.
fn inner_half(mesh: &SimMesh<'_>, n: usize) -> CornerId {
    let t = &mesh.topology;
    let is_free = |v: VertexId| t.ring(v).all(|w| mesh.constraint[w] == VertexConstraint::Free);
    let inner: Vec<CornerId> = t.edges().filter(|&h| is_free(t.vertex(h)) && is_free(t.target(h))).collect();
    inner[n % inner.len()]
}

/// Flips an inner edge, unless a triangle would be turned over.
fn turn(mesh: &mut SimMesh<'_>, n: usize) {
    let half = inner_half(mesh, n);
    mesh.flip(half);
    let t = &mesh.topology;
    let faces = [Some(half), t.twin(half)].into_iter().flatten().map(|c| t.triangle(face(c)));
    let mut normals = faces.map(|f| f.map(|v| mesh.points[v])).map(|[a, b, c]| (b - a).cross(c - a).z);
    if normals.any(|z| z < 0.1) {
        mesh.flip(half);
    }
}

proptest! {
    #![proptest_config(few(64, 20_040_308))]

    #[test]
    fn two_pairs_of_irregular_vertices_drift_together(n in 0usize..400, step in 0usize..24) {
        let baseline = rhombs(10).baseline();
        let mut mesh = SimMesh::new(&baseline);
        let regular = mesh.irregularity();
        let half = inner_half(&mesh, n);
        mesh.flip(half);
        prop_assert_eq!(mesh.irregularity(), regular + 4);
        // One of the pairs goes a step away from the other, where it can.
        let around: Vec<CornerId> = mesh.topology.fan(mesh.topology.vertex(half)).collect();
        let other = around[step % around.len()];
        mesh.flip(other);
        if mesh.irregularity() != regular + 4 {
            mesh.flip(other);
        }
        prop_assert!(drift(&mut mesh) > 0);
        prop_assert_eq!(mesh.irregularity(), regular);
    }

    #[test]
    fn following_curves_leaves_less_of_them_astray(case in cases()) {
        let baseline = case.prepared().baseline();
        let mut mesh = SimMesh::new(&baseline);
        ROUND.into_iter().for_each(|step| step.run(&mut mesh));
        let (before, kept_before, curves, flips) = (mesh.length_off_chords(), kept(&mesh), covered(&mesh), flipped(&mesh));
        let moved = follow_curves(&mut mesh);
        mesh.assert_consistent();
        prop_assert_eq!(kept(&mesh), kept_before);
        prop_assert!(flipped(&mesh) <= flips, "a triangle was turned over in UV");
        for (chain, length) in covered(&mesh) {
            prop_assert!((length - curves[&chain]).abs() <= 1e-4 * curves[&chain], "{chain:?} covers {length}");
        }
        let after = mesh.length_off_chords();
        prop_assert!(after <= before * 1.001 && (moved == 0 || after < before), "{before} to {after} by {moved}");
    }

    #[test]
    fn drifting_makes_vertices_more_regular(turns in prop::collection::vec(0usize..400, 1..40)) {
        let baseline = rhombs(10).baseline();
        let mut mesh = SimMesh::new(&baseline);
        turns.into_iter().for_each(|n| turn(&mut mesh, n));
        let (before, kept_before) = (mesh.irregularity(), kept(&mesh));
        let flips = drift(&mut mesh);
        mesh.assert_consistent();
        prop_assert_eq!(kept(&mesh), kept_before);
        // A run of flips is not longer than four, and squares change by even numbers.
        prop_assert!(before - mesh.irregularity() >= 2 * flips.div_ceil(4) as i64, "{flips} flips");
    }

    #[test]
    fn every_pass_keeps_what_it_must(case in cases(), patch in 1usize..60) {
        let baseline = case.prepared().baseline();
        let mut mesh = SimMesh::new(&baseline);
        mesh.assert_consistent();
        let (before, curves, flips) = (kept(&mesh), covered(&mesh), flipped(&mesh));
        // Patches of a mesh that is far from its lengths, and of one that is near.
        let in_patches = [Step::Pass(Pass::InPatches(patch))];
        for pass in [&in_patches[..], &ROUND, &in_patches, &ROUND].concat() {
            pass.run(&mut mesh);
            mesh.assert_consistent();
            prop_assert_eq!(&kept(&mesh), &before, "after {:?}", pass);
            prop_assert!(flipped(&mesh) <= flips, "{:?} turned a triangle over in UV", pass);
            for (chain, length) in covered(&mesh) {
                let whole = curves[&chain];
                prop_assert!((length - whole).abs() <= 1e-4 * whole, "{chain:?} covers {length} of {whole} after {pass:?}");
            }
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bytes(case in cases()) {
        let prepared = case.prepared();
        let run = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap_or_else(|e| panic!("{e}"));
            pool.install(|| simulate(prepared.baseline(), &SimOptions { iterations: 2, ..prepared.options.clone() }, MAX_FACES))
        };
        let (one, many) = (run(1), run(8));
        prop_assert_eq!(one.triangles, many.triangles);
        prop_assert!(one.points.iter().zip(many.points.iter()).all(|(a, b)| a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits)));
    }
}

#[test]
fn no_edge_waits_for_a_flip_in_the_end() {
    let tubes = (3..9).flat_map(|around| [0.15, 0.22, 0.3].map(|length| (sheets::tube(around, 5), length)));
    for (input, length) in tubes.chain([0.21, 0.3, 0.4].map(|length| (tee([2, 3, 2]), length))) {
        let prepared = Prepared::new(input, lengths(length));
        let baseline = prepared.baseline();
        let mut mesh = SimMesh::new(&baseline);
        remesh(&mut mesh, &prepared.options, MAX_FACES);
        // The finish moves vertices of edges that were good before.
        assert_eq!(flip_edges(&mut mesh, LAST_REGULARITY), 0, "at {length}");
    }
}
