//! Time and quality of remeshing with each garment's own recipe, in one table.
//!
//! ```text
//! cargo benches --bench quality              all garments that are here
//! cargo benches --bench quality -- coat      those whose name holds the word; more words: more garments
//! ```
//!
//! Times are of `simulate` alone, the least of a few runs: processor time on one thread, and wall time on one and two.

#![allow(clippy::print_stdout)]

#[path = "../common/garments.rs"]
mod garments;
#[path = "../common/nearest.rs"]
mod nearest;
#[path = "../common/quality.rs"]
mod quality;

use glam::Vec3;
use quality::{Quality, Reference, measure};
use rayon::ThreadPoolBuilder;
use std::path::Path;
use std::time::Instant;
use tailor::error::Warnings;
use tailor::pipeline::Prepared;
use tailor::recipe::{Layers, bind};
use tailor::sim::{Baseline, Lengths, SimProduct, simulate};
use tailor::usd::{ReadOptions, Source};

/// Runs of which the fastest counts.
const RUNS: usize = 3;
/// A bound that nothing here reaches.
const MAX_FACES: usize = 20_000_000;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    println!(
        "{:24} {:>6} {:>6} {:>6} {:>6} {:>5} {:>5} {:>6} {:>5} {:>6} {:>6} {:>6} {:>6} {:>6}",
        "garment", "tris", "cpu", "1 thr", "2 thr", "min", "p5", "<30 %", "val6", "rms", "seam", "near", "to", "from"
    );
    for file in garments::garments() {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if words.is_empty() || words.iter().any(|w| name.contains(w)) {
            row(&name, &file);
        }
    }
}

fn row(name: &str, file: &Path) {
    let prepared = prepare(file);
    let (cpu, one) = (0..std::env::var("RUNS").ok().and_then(|r| r.parse().ok()).unwrap_or(RUNS))
        .map(|_| timed(&prepared, 1))
        .fold((f64::MAX, f64::MAX), |m, t| (m.0.min(t.0), m.1.min(t.1)));
    let runs: usize = std::env::var("RUNS").ok().and_then(|r| r.parse().ok()).unwrap_or(RUNS);
    let two = (0..runs).map(|_| timed(&prepared, 2).1).fold(f64::MAX, f64::min);
    let q = quality(&simulate(baseline(&prepared), prepared.recipe.sim.iterations, MAX_FACES));
    println!(
        "{name:24} {:6} {cpu:6.1} {one:6.1} {two:6.1} {:5.1} {:5.2} {:6.3} {:5.1} {:6.4} {:6.3} {:6.2} {:6.3} {:6.3}",
        q.triangles,
        q.min_angle,
        q.p5,
        100.0 * q.under30,
        100.0 * q.valence6,
        q.rms,
        q.curve_max,
        100.0 * q.curve_near,
        q.to_surface,
        q.from_surface
    );
}

fn prepare(file: &Path) -> Prepared {
    let mut warnings = Warnings::default();
    let source = Source::open(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let input = source.garment(&mut warnings).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let mut layers = Layers::default();
    layers.add_attributes(source.recipe().unwrap_or_default(), &mut warnings);
    if let Ok(more) = std::env::var("TAILOR_SET") {
        more.split(',').filter(|s| !s.is_empty()).for_each(|s| layers.add_override(s).expect("an option"));
    }
    Prepared::new(input, &layers, &mut warnings).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

fn baseline(prepared: &Prepared) -> Baseline {
    let bound = bind(&prepared.recipe, &prepared.garment, false).unwrap_or_else(|e| panic!("{e}"));
    let sim = &prepared.recipe.sim;
    let lengths = Lengths { min: sim.min_edge_length, max: sim.max_edge_length, density: bound.density };
    Baseline::new(&prepared.garment, sim, lengths, bound.uv_set)
}

/// Processor and wall time of one run. \[milliseconds\]
fn timed(prepared: &Prepared, threads: usize) -> (f64, f64) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
    let baseline = pool.install(|| baseline(prepared));
    pool.install(|| {
        let (cpu, wall) = (cpu_time(), Instant::now());
        let product = simulate(baseline, prepared.recipe.sim.iterations, MAX_FACES);
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

fn diag(product: &SimProduct) {
    use std::collections::*;
    let mut cnt: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut edges = HashSet::new();
    for (id, list) in product.chain_edges.enumerated() {
        for &[a, b] in list {
            cnt.entry(a.index()).or_default().push(id.index());
            cnt.entry(b.index()).or_default().push(id.index());
            edges.insert([a.min(b).index(), a.max(b).index()]);
        }
    }
    let mut val: HashMap<usize, usize> = HashMap::new();
    for t in &product.triangles {
        for v in t {
            *val.entry(v.index()).or_default() += 1;
        }
    }
    let mut hist: BTreeMap<String, [usize; 3]> = BTreeMap::new();
    for t in &product.triangles {
        let a = tailor::report::min_angle(t.map(|v| product.points[v]));
        let on = t.iter().filter(|v| cnt.contains_key(&v.index())).count();
        let anchors = t.iter().filter(|v| cnt.get(&v.index()).is_some_and(|c| c.len() != 2 || c[0] != c[1])).count();
        let ce = (0..3)
            .filter(|&k| {
                let (x, y) = (t[k], t[(k + 1) % 3]);
                edges.contains(&[x.min(y).index(), x.max(y).index()])
            })
            .count();
        let len = (0..3).map(|k| {
            let (x, y) = (t[k], t[(k + 1) % 3]);
            product.points[x].distance(product.points[y]) / product.target[x]
        });
        let short = len.clone().fold(f32::MAX, f32::min) < 0.6;
        let e = hist.entry(format!("on{on} anchors{anchors} cedges{ce} short{}", u8::from(short))).or_default();
        e[0] += 1;
        if a < 30.0 {
            e[1] += 1;
        }
        if a < 41.0 {
            e[2] += 1;
        }
    }
    for (k, v) in hist {
        if v[1] > 0 || v[2] > 20 {
            println!("   {k:40} all {:6} <30 {:5} <41 {:5}", v[0], v[1], v[2]);
        }
    }
}

fn diag2(product: &SimProduct) {
    let b = &product.baseline;
    let mut worst: Vec<(f32, String)> = Vec::new();
    for (id, chain) in b.chains.enumerated() {
        let own: Vec<[Vec3; 3]> = product.chain_edges[id]
            .iter()
            .map(|&[x, y]| [product.points[x], product.points[y], product.points[y]])
            .collect();
        let near = nearest::Nearest::new(own.clone());
        let t = b.target[chain.vertices[0]];
        let far = (0..chain.vertices.len())
            .map(|i| (near.distance(b.points[chain.vertices[i]]) / t, i))
            .fold((0.0, 0), |m, x| if x.0 > m.0 { x } else { m });
        let i = far.1;
        let n = chain.vertices.len();
        let turn = |i: usize| {
            if i == 0 || i + 1 >= n {
                return 0.0;
            }
            let (p, q, r) =
                (b.points[chain.vertices[i - 1]], b.points[chain.vertices[i]], b.points[chain.vertices[i + 1]]);
            (q - p).angle_between(r - q).to_degrees()
        };
        let around: Vec<String> = (i.saturating_sub(5)..(i + 6).min(n))
            .map(|j| format!("{:.0}@{:.2}", turn(j), (chain.along[j] - chain.along[i]) / t))
            .collect();
        worst.push((
            far.0,
            format!(
                "chain {id:?} loop {} len/t {:.1} edges {} pins {:?} at {i}/{n} {} marks {:?} turns {}",
                chain.is_loop,
                chain.length() / t,
                own.len(),
                chain.pins.len(),
                b.points[chain.vertices[i]],
                chain.marks.seam,
                around.join(" ")
            ),
        ));
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (d, s) in worst.iter().take(6) {
        println!("   seam {d:.3} {s}");
    }
    let mut tris: Vec<(f32, [Vec3; 3])> = product
        .triangles
        .iter()
        .map(|t| {
            let p = t.map(|v| product.points[v]);
            (tailor::report::min_angle(p), p)
        })
        .collect();
    tris.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (a, p) in tris.iter().take(4) {
        let t = b.target[tailor::mesh::VertexId::new(0)];
        println!(
            "   angle {a:.1} sides {:.2} {:.2} {:.2} at {}",
            p[0].distance(p[1]) / t,
            p[1].distance(p[2]) / t,
            p[2].distance(p[0]) / t,
            p[0]
        );
    }
}

fn quality(product: &SimProduct) -> Quality {
    if std::env::var("DIAG2").is_ok() {
        diag2(product);
    }
    if std::env::var("DIAG").is_ok() {
        diag(product);
    }
    let baseline = &product.baseline;
    let surface: Vec<[Vec3; 3]> = baseline.topology.faces.ids().map(|f| baseline.triangle(f)).collect();
    let curves: Vec<Vec<Vec3>> =
        baseline.chains.iter().map(|c| c.vertices.iter().map(|&v| baseline.points[v]).collect()).collect();
    let grid = tailor::spatial::PointGrid::new(&baseline.points);
    let target = |p: Vec3| grid.nearest(&baseline.points, p).map_or(1.0, |v| baseline.target[v]);
    let triangles: Vec<[usize; 3]> = product.triangles.iter().map(|t| t.map(|v| v.index())).collect();
    let reference = Reference { surface: &surface, curves: &curves, target: &target };
    measure(&product.points, &triangles, &product.target, &reference)
}
