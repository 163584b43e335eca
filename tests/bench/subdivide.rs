//! Time of uniform subdivision: topology, points and one UV set, from the cage to levels 1 to 3.
//!
//! ```text
//! cargo benches                                  all benches (an alias, see .cargo/config.toml)
//! cargo benches --bench subdivide -- worksuit/3  those whose name matches
//! cargo xtask golden --bench MESH.txt            the same work by OpenSubdiv, on a text mesh
//! ```
//!
//! The throughput is in faces of the finest level. As in the OpenSubdiv bench, the finest level gets its faces but not
//! the adjacency that only a further level would need.

#![allow(clippy::print_stderr)]

mod common;

use common::Sample;
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Throughput};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use tailor::internals::garment::{Garment, Values};
use tailor::internals::mesh::{CornerId, Faces, IdVec};
use tailor::internals::subdivide::{Channel, ChannelChild, Level, Stencils};

const LEVELS: [usize; 3] = [1, 2, 3];
const THREADS: [usize; 2] = [1, 2];

fn main() {
    let garments = common::garments();
    let mut criterion = common::criterion();
    for threads in THREADS {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        let mut group = criterion.benchmark_group(format!("subdivide/threads {threads}"));
        garments.iter().for_each(|sample| measure(&mut group, &pool, sample));
    }
    criterion.final_summary();
}

fn measure(group: &mut BenchmarkGroup<'_, WallTime>, pool: &ThreadPool, sample: &Sample) {
    let cage = Cage::new(sample);
    for levels in LEVELS {
        let faces = pool.install(|| cage.refine(levels)).faces.len();
        group.throughput(Throughput::Elements(faces as u64));
        group.bench_function(BenchmarkId::new(sample.name, levels), |bencher| {
            pool.install(|| bencher.iter(|| black_box(cage.refine(levels))));
        });
    }
}

/// What is refined, in the form in which the reader gives it.
struct Cage<'a> {
    garment: &'a Garment,
    points: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    uv_rows: IdVec<CornerId, u32>,
}

/// The finest level.
struct RefinedLevels {
    faces: Faces,
    _points: Vec<[f32; 3]>,
    _uvs: Vec<[f32; 2]>,
}

impl<'a> Cage<'a> {
    fn new(sample: &'a Sample) -> Self {
        let garment = &sample.garment;
        let uv_set = sample.uv_set();
        let Values::F32(uvs) = &uv_set.values else { panic!("the UV set of {} holds no floats", sample.name) };
        Self {
            points: garment.points.iter().map(|p| p.to_array()).collect(),
            uvs: uvs.chunks_exact(2).map(|uv| [uv[0], uv[1]]).collect(),
            uv_rows: uv_set.corner_rows(&garment.faces, garment.points.len()),
            garment,
        }
    }

    /// Everything from the cage's faces on: `levels` times topology, points and UVs.
    fn refine(&self, levels: usize) -> RefinedLevels {
        let mut level = Level::base(self.garment);
        let rules = self.garment.rules;
        let (mut channel, rows) =
            Channel::base(&level, |c| self.uv_rows[c] as usize, rules.face_varying, rules.boundary);
        let mut points = self.points.clone();
        let mut uvs: Vec<[f32; 2]> = rows.iter().map(|&row| self.uvs[row as usize]).collect();
        for _ in 1..levels {
            let child = level.refined();
            points = level.vertex_stencils().apply(&points);
            let refined_uvs = ChannelChild::new(&level, &channel);
            uvs = refined_uvs.apply(&uvs);
            channel = refined_uvs.into_channel(&child);
            level = child;
        }
        let refined_uvs = ChannelChild::new(&level, &channel);
        RefinedLevels {
            _points: level.vertex_stencils().apply(&points),
            _uvs: refined_uvs.apply(&uvs),
            faces: level.refined_faces(),
        }
    }
}
