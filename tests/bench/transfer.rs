//! Time of transfer beside that of the remeshing it follows: garments with 20 face sets, 10 edge sets, 3 UV sets and 10
//! primvars more.
//!
//! ```text
//! cargo benches --bench transfer                  (an alias, see .cargo/config.toml)
//! cargo benches --bench transfer -- worksuit      those whose name matches
//! ```
//!
//! The throughput is in triangles of the simulation mesh. `transfer/samples` is the pass that counts what faces cover,
//! with 8, 32 and 128 samples a face.

#![allow(clippy::print_stderr)]

mod common;

use common::Sample;
use criterion::{BatchSize, BenchmarkId, SamplingMode, Throughput};
use std::collections::BTreeSet;
use std::sync::Arc;
use tailor::internals::garment::{Elements, Garment, Interpolation, Meaning, Primvar, PrimvarRole, Subset, Values};
use tailor::internals::mesh::{FaceId, Topology, VertexId};
use tailor::internals::sim::{Baseline, Lengths, SimOptions, SimProduct, simulate};
use tailor::internals::transfer::{Coverage, transfer};

const FACE_SETS: usize = 20;
const EDGE_SETS: usize = 10;
const PRIMVARS: usize = 10;

fn main() {
    let options = SimOptions::default();
    let mut criterion = common::criterion();
    let mut group = criterion.benchmark_group("transfer");
    group.sampling_mode(SamplingMode::Flat);
    for sample in common::garments() {
        let name = sample.name;
        let garment = dressed(&sample);
        let new = || baseline(&garment, &sample, &options);
        let product = simulate(new(), options.iterations, usize::MAX);
        group.throughput(Throughput::Elements(product.triangles.len() as u64));
        group.bench_function(BenchmarkId::new("remesh", name), |bencher| {
            let remesh = |baseline| simulate(baseline, options.iterations, usize::MAX);
            bencher.iter_batched(new, remesh, BatchSize::PerIteration);
        });
        group.bench_function(BenchmarkId::new("all", name), |bencher| {
            bencher.iter(|| carried(&garment, &product, &sample));
        });
        for samples in [8, 32, 128] {
            let options = SimOptions { transfer_samples: samples, ..options.clone() };
            let count = || Coverage::new(&product, garment.faces.len(), &options);
            group.bench_function(BenchmarkId::new(format!("samples {samples}"), name), |bencher| bencher.iter(count));
        }
    }
    group.finish();
    criterion.final_summary();
}

fn carried(garment: &Garment, product: &SimProduct, sample: &Sample) -> Garment {
    transfer(garment, product, &SimOptions::default(), Some(sample.uv_set())).0.mesh
}

/// The baseline for half the mean edge length everywhere.
fn baseline(garment: &Garment, sample: &Sample, options: &SimOptions) -> Baseline {
    let length = 0.5 * tailor::internals::pipeline::mean_edge_length(garment);
    Baseline::new(garment, options, Lengths { min: length, max: length, density: None }, Some(sample.uv_set()))
}

/// The garment with attributes of every kind.
fn dressed(sample: &Sample) -> Garment {
    let mut garment = sample.garment.clone();
    let block = |face: usize| face * FACE_SETS / sample.garment.faces.len();
    let faces: Vec<FaceId> = garment.faces.ids().collect();
    for k in 0..FACE_SETS {
        let own = faces.iter().copied().filter(|f| block(f.index()) == k).collect();
        Arc::make_mut(&mut garment.subsets).push(set(format!("faces{k}"), Elements::Faces(own)));
    }
    for k in 0..EDGE_SETS {
        Arc::make_mut(&mut garment.subsets)
            .push(set(format!("edges{k}"), Elements::Edges(borders(&sample.garment, |f| block(f.index()) == k))));
    }
    let corners = garment.faces.corners().len();
    let point = |corner: usize| sample.garment.points[sample.garment.faces.corners().as_slice()[corner]];
    let of_corner =
        |corner: usize| block(sample.garment.faces.face_of(tailor::internals::mesh::CornerId::new(corner)).index());
    // One layout in blocks, one in a piece.
    let blocks = (0..corners).flat_map(|c| [point(c).x + 10.0 * of_corner(c) as f32, point(c).y]);
    Arc::make_mut(&mut garment.primvars).push(primvar(
        "blocks",
        Interpolation::FaceVarying,
        2,
        Values::F32(blocks.collect()),
    ));
    let whole = (0..corners).flat_map(|c| [point(c).x, point(c).y]);
    Arc::make_mut(&mut garment.primvars).push(primvar(
        "whole",
        Interpolation::FaceVarying,
        2,
        Values::F32(whole.collect()),
    ));
    for k in 0..PRIMVARS {
        let (points, faces) = (garment.points.len(), garment.faces.len());
        let floats = |n: usize| Values::F32((0..n).map(|i| ((i * (k + 3)) % 101) as f32).collect());
        Arc::make_mut(&mut garment.primvars).push(match k % 4 {
            0 => primvar(&format!("vertex{k}"), Interpolation::Vertex, 3, floats(3 * points)),
            1 => primvar(&format!("varying{k}"), Interpolation::Varying, 1, floats(points)),
            2 => primvar(&format!("colour{k}"), Interpolation::Uniform, 3, floats(3 * faces)),
            _ => primvar(&format!("number{k}"), Interpolation::Uniform, 1, Values::I32((0..faces as i32).collect())),
        });
    }
    garment
}

fn set(name: String, elements: Elements) -> Subset {
    Subset { name, family: String::new(), elements, sharpness: None }
}

fn primvar(name: &str, interpolation: Interpolation, components: usize, values: Values) -> Primvar {
    let (name, role, meaning, half) = (name.into(), PrimvarRole::Primvar, Meaning::Plain, false);
    Primvar { name, role, meaning, half, interpolation, components, element_size: 1, values, indices: None }
}

/// The edges between faces inside and outside.
fn borders(garment: &Garment, inside: impl Fn(FaceId) -> bool) -> Vec<[VertexId; 2]> {
    let t = Topology::new(garment.faces.clone(), garment.points.len());
    let sides = |e| t.edge_corners.row(e).iter().map(|&c| inside(t.faces.face_of(c))).collect::<BTreeSet<_>>();
    t.edges.enumerated().filter(|(e, _)| sides(*e).len() == 2).map(|(_, &ends)| ends).collect()
}
