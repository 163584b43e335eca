//! How the work of remeshing grows with a garment: as n log n.

use super::{MAX_FACES, baseline, prepare};
use tailor::sim::{SimProduct, simulate};
use tailor_mesh::garment::Garment;
use tailor_testing::sheets;

/// The growth of the work for each triangle that n log n allows from one size to one four times as large.
const GROWTH: f64 = 1.4;

fn product(input: Garment, options: &[&str]) -> SimProduct {
    let prepared = prepare(input, options);
    simulate(baseline(&prepared), &prepared.recipe.sim, MAX_FACES)
}

/// Edits of all passes, and vertices of all chains, for each triangle of the baseline and of the mesh.
fn work(product: &SimProduct) -> [f64; 2] {
    let edits = product.report.splits + product.report.collapses + product.report.flips;
    let chains: usize = product.baseline.chains.iter().map(|chain| chain.vertices.len()).sum();
    let triangles = product.baseline.start.len() + product.baseline.topology.faces.len() + product.triangles.len();
    [edits, chains].map(|work| work as f64 / triangles as f64)
}

/// A sheet with a shell for each face.
fn shells(n: usize) -> Garment {
    let mut input = sheets::grid(n, n, |_, _| true);
    input.primvars.retain(|p| p.name != "st");
    sheets::with_uvs(input, move |face, v| [(v % (n + 1)) as f32 + 3.0 * n as f32 * face as f32, (v / (n + 1)) as f32])
}

/// A sheet of which some quarters have all points in one place.
fn coincident(n: usize, share: usize) -> Garment {
    let mut input = sheets::grid(n, n, |_, _| true);
    let last = share * (n + 1) / 4;
    input.points.iter_mut().enumerate().filter(|(i, _)| i % (n + 1) < last).for_each(|(_, p)| *p = glam::Vec3::ONE);
    input
}

#[test]
fn edits_and_chains_grow_as_n_log_n() {
    let comb = |n: usize| sheets::grid(n, n, |x, y| y < 2 || x % 2 == 0);
    let cases: [(&str, [Garment; 2], &[&str]); 5] = [
        ("line", [40, 160].map(|n| sheets::grid(n, 1, |_, _| true)), &["sim.maxEdgeLength=0.5"]),
        ("grid", [8, 16].map(|n| sheets::grid(n, n, |_, _| true)), &["sim.maxEdgeLength=0.5"]),
        ("comb", [8, 16].map(comb), &["sim.maxEdgeLength=0.5"]),
        ("seams", [8, 16].map(shells), &["sim.maxEdgeLength=0.5", "sim.smallestShell=0"]),
        ("tiny shells", [8, 16].map(shells), &["sim.maxEdgeLength=2"]),
    ];
    for (name, inputs, options) in cases {
        let [small, large] = inputs.map(|input| work(&product(input, options)));
        for (small, large) in small.into_iter().zip(large) {
            assert!(large <= GROWTH * small.max(0.1), "{name}: {small} grows to {large}");
        }
    }
}

#[test]
fn a_shell_for_each_face_and_coincident_points_neither_hang_nor_panic() {
    for length in ["sim.maxEdgeLength=0.4", "sim.maxEdgeLength=5"] {
        for smallest in ["sim.smallestShell=0", "sim.smallestShell=4"] {
            for input in [shells(12), coincident(12, 1), coincident(12, 2)] {
                assert!(!product(input, &[length, smallest]).triangles.is_empty());
            }
        }
    }
}
