//! Time of the simulation mesh: the baseline that it lies on, the remeshing, and each pass of its first round, at three
//! target lengths.
//!
//! ```text
//! cargo benches --bench simulate                 (an alias, see .cargo/config.toml)
//! cargo benches --bench simulate -- remesh/coat  those whose name matches
//! ```
//!
//! Names end in the target length as a part of the cage's mean edge length. The throughput is in triangles: those of
//! the baseline, and those of the finished mesh.

#![allow(clippy::print_stderr)]

mod common;

use common::Sample;
use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, BenchmarkId, SamplingMode, Throughput};
use tailor::internals::garment::Garment;
use tailor::internals::mesh::Topology;
use tailor::internals::sim::{Baseline, Lengths, Pass, SimMesh, SimOptions, simulate};

/// Target lengths, as parts of the cage's mean edge length.
const PARTS: [f32; 3] = [1.0, 0.5, 0.25];
/// A bound that no bench reaches.
const MAX_FACES: usize = 10_000_000;

fn main() {
    let garments = common::garments();
    let mut criterion = common::criterion();
    let mut group = criterion.benchmark_group("simulate/baseline");
    garments.iter().for_each(|sample| measure_baseline(&mut group, sample));
    group.finish();
    let mut group = criterion.benchmark_group("simulate/remesh");
    garments.iter().for_each(|sample| measure_remesh(&mut group, sample));
    group.finish();
    let mut group = criterion.benchmark_group("simulate/pass");
    garments.iter().for_each(|sample| measure_passes(&mut group, sample));
    group.finish();
    criterion.final_summary();
}

fn measure_baseline(group: &mut BenchmarkGroup<'_, WallTime>, sample: &Sample) {
    let options = SimOptions::default();
    for part in PARTS {
        let new = || baseline(sample, &options, part);
        group.throughput(Throughput::Elements(new().topology.faces.len() as u64));
        group.bench_function(BenchmarkId::new(sample.name, part), |bencher| bencher.iter(new));
    }
}

fn measure_remesh(group: &mut BenchmarkGroup<'_, WallTime>, sample: &Sample) {
    group.sampling_mode(SamplingMode::Flat);
    let options = SimOptions::default();
    for part in PARTS {
        let new = || baseline(sample, &options, part);
        let remesh = |baseline| simulate(baseline, options.iterations, MAX_FACES);
        group.throughput(Throughput::Elements(remesh(new()).triangles.len() as u64));
        group.bench_function(BenchmarkId::new(sample.name, part), |bencher| {
            bencher.iter_batched(new, remesh, BatchSize::PerIteration);
        });
    }
}

fn measure_passes(group: &mut BenchmarkGroup<'_, WallTime>, sample: &Sample) {
    let options = SimOptions::default();
    for part in PARTS {
        let baseline = baseline(sample, &options, part);
        let mut mesh = SimMesh::new(&baseline);
        for pass in Pass::ROUND {
            group.throughput(Throughput::Elements(mesh.topology.face_count() as u64));
            group.bench_function(BenchmarkId::new(format!("{pass:?}/{}", sample.name), part), |bencher| {
                bencher.iter_batched_ref(|| mesh.clone(), |mesh| pass.run(mesh), BatchSize::PerIteration);
            });
            pass.run(&mut mesh);
        }
    }
}

/// The baseline for one target length everywhere.
fn baseline(sample: &Sample, options: &SimOptions, part: f32) -> Baseline {
    let length = part * mean_edge_length(&sample.garment);
    let lengths = Lengths { min: length, max: length, density: None };
    Baseline::new(&sample.garment, options, lengths, Some(sample.uv_set()))
}

fn mean_edge_length(garment: &Garment) -> f32 {
    let topology = Topology::new(garment.faces.clone(), garment.points.len());
    let length = |[a, b]: [tailor::internals::mesh::VertexId; 2]| garment.points[a].distance(garment.points[b]);
    let sum: f32 = topology.edges.iter().copied().map(length).sum();
    sum / topology.edges.len() as f32
}
