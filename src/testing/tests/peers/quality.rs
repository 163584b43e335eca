//! Time and quality of remeshing with each garment's own recipe, in one table.
//!
//! With `PEERS_EXPORT`, a folder gets what other remeshers are given; with `PEERS_MEASURE`, their meshes in a folder are measured
//! beside ours. Times are of `simulate` alone, the least of a few runs: processor time on one thread, and wall time on one and
//! two.

use super::{MAX_FACES, folder, objects, remeshed};
use crate::prepared::{Prepared, baseline, of_file};
use crate::quality::{Quality, Reference, measure, of_product};
use rayon::ThreadPoolBuilder;
use std::path::Path;
use std::time::Instant;
use tailor::sim::{SimProduct, simulate};
use tailor_testing::garments;

/// Runs of which the fastest counts.
const RUNS: usize = 5;
/// Refinements of the mesh that other remeshers start from.
const PEER_LEVEL: u32 = 1;

#[test]
#[ignore = "prints a table; run cargo xtask peers"]
fn table() {
    let (export, peers) = (folder("PEERS_EXPORT"), folder("PEERS_MEASURE"));
    if export.is_none() {
        println!("{:32} {:>7} {:>6} {:>6} {:>6} {}", "garment", "tris", "cpu", "1 thr", "2 thr", Quality::HEAD);
    }
    for file in garments::garments() {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let prepared = of_file(&file, []);
        match &export {
            Some(folder) => objects::write(folder, &name, &baseline(&prepared, PEER_LEVEL)),
            None => rows(&name, &prepared, peers.as_deref()),
        }
    }
}

/// Our row, and those of others.
fn rows(name: &str, prepared: &Prepared, peers: Option<&Path>) {
    let least = |threads| (0..RUNS).map(|_| timed(prepared, threads)).reduce(|a, b| (a.0.min(b.0), a.1.min(b.1)));
    let ((cpu, one), (_, two)) = (least(1).unwrap_or_default(), least(2).unwrap_or_default());
    let product = remeshed(prepared);
    Reference::of(&product, |reference| compare(name, &product, [cpu, one, two], reference, peers));
}

fn compare(
    name: &str,
    product: &SimProduct,
    [cpu, one, two]: [f64; 3],
    reference: &Reference<'_>,
    peers: Option<&Path>,
) {
    let own = of_product(product, reference);
    println!("{name:32} {:7} {cpu:6.1} {one:6.1} {two:6.1} {own}", product.triangles.len());
    for other in peers.into_iter().flat_map(|folder| objects::others(folder, name)) {
        let wanted: Vec<f32> = other.points.iter().map(|&p| (reference.target)(p)).collect();
        let q = measure(&other.points, &other.triangles, &wanted, reference);
        println!("  {:30} {:7} {:>6} {:6.1} {:>6} {q}", other.name, other.triangles.len(), "", other.milliseconds, "");
    }
}

/// Processor and wall time of one run. \[milliseconds\]
fn timed(prepared: &Prepared, threads: usize) -> (f64, f64) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap_or_else(|e| panic!("{e}"));
    let baseline = pool.install(|| baseline(prepared, prepared.recipe.sim.baseline_level));
    pool.install(|| {
        let (cpu, wall) = (cpu_time(), Instant::now());
        let product = simulate(baseline, &prepared.recipe.sim, MAX_FACES);
        let times = (cpu_time() - cpu, wall.elapsed().as_secs_f64() * 1e3);
        drop(product);
        times
    })
}

/// Processor time of this thread, where the system tells; 0 elsewhere. \[milliseconds\]
fn cpu_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}
