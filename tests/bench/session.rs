//! Time of one edit through a session: what the OpenUSD plugin waits for besides composition.

use criterion::Criterion;
use std::hint::black_box;
use std::path::Path;
use tailor::session::{Document, Session};
use tailor::usd::{ReadOptions, Source, WriteOptions, write};

/// The coat as the plugin hands it over: composed, as crate bytes.
fn composed() -> Vec<u8> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("examples");
    let source = Source::open(&folder.join("coat.usda"), &ReadOptions::default()).expect("the coat");
    let temporary = tempfile::tempdir().expect("a folder");
    let flat = temporary.path().join("flat.usdc");
    let options = WriteOptions { flatten: true, model_guide: false, ..WriteOptions::default() };
    write(&source, &[], &flat, &options).expect("a flat layer");
    std::fs::read(flat).expect("a flat layer")
}

fn edits(c: &mut Criterion) {
    let content = composed();
    let session = Session::new(1 << 30, None).expect("threads");
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("examples/coat.tailor");
    let layer = |arguments: &[(&str, &str)], metadata_only: bool| {
        let document =
            Document::new(&file, r#"{"source": "coat.usda"}"#, arguments.iter().copied()).expect("a document");
        session.layer(&document, &content, metadata_only).expect("a layer").0
    };
    let mut group = c.benchmark_group("session");
    layer(&[], false);
    group.bench_function("metadata", |b| b.iter(|| black_box(layer(&[], true))));
    group.bench_function("no edit", |b| b.iter(|| black_box(layer(&[], false))));
    // Each value is asked for once, as by somebody who drags a slider.
    let mut step = 0;
    let mut next = || {
        step += 1;
        format!("{}", 2.6 + 1e-4 * f64::from(step))
    };
    group
        .bench_function("sim.maxEdgeLength", |b| b.iter(|| black_box(layer(&[("sim.maxEdgeLength", &next())], false))));
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().sample_size(10).without_plots().configure_from_args();
    edits(&mut criterion);
    criterion.final_summary();
}
