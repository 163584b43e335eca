//! Time of the render mesh: seams on all UV seams, hems on all panels at a border, two refinements, all attributes; and
//! of one edit of a seam through a session.

#![allow(clippy::print_stderr)]

#[path = "../common/operators.rs"]
mod operators;

use criterion::Criterion;
use operators::{border_panels, rendered};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use tailor::error::Warnings;
use tailor::garment::{Garment, check_garment};
use tailor::recipe::Document;
use tailor::session::Session;
use tailor::usd::{ReadOptions, Source, WriteOptions, write};

/// Name, file and edge set of the garments; those that are not here are not measured.
const GARMENTS: [(&str, &str, &str); 2] =
    [("coat", "examples/coat.usda", "side_seams"), ("worksuit", "../shared/garments/male_worksuit01.usdc", "uvSeams")];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Seams and hems of sizes that the garment's edges have room for.
fn options(garment: &Garment, seams: &str) -> Vec<(String, String)> {
    let size = tailor::pipeline::mean_edge_length(garment);
    let panels = border_panels(garment);
    let pairs = [
        ("seam.all.edges", seams.to_owned()),
        ("seam.all.width", format!("{}", 0.3 * size)),
        ("seam.all.normalOffset", format!("{}", -0.05 * size)),
        ("thickness.hem.faces", panels),
        ("thickness.hem.amount", format!("{}", 0.08 * size)),
        ("render.level", "2".to_owned()),
    ];
    pairs.map(|(key, value)| (key.to_owned(), value)).to_vec()
}

fn composed(source: &Source) -> Vec<u8> {
    let temporary = tempfile::tempdir().expect("a folder");
    let flat = temporary.path().join("flat.usdc");
    let options = WriteOptions { flatten: true, model_guide: false, ..WriteOptions::default() };
    write(source, &[], &flat, &options, &mut Warnings::default()).expect("a flat layer");
    std::fs::read(flat).expect("a flat layer")
}

fn measure(c: &mut Criterion, name: &str, path: &Path, seams: &str) {
    let source = Source::open(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let input = source.garment(&mut Warnings::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let garment = check_garment(input, &mut Warnings::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let options = options(&garment, seams);
    let assigned: Vec<String> = options.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let mut group = c.benchmark_group(format!("render/{name}"));
    group.bench_function("whole", |b| {
        b.iter(|| black_box(rendered(&garment, &assigned)));
    });
    group.bench_function("no operators", |b| {
        b.iter(|| black_box(rendered(&garment, &["render.level=2"])));
    });
    let (session, content) = (Session::new(1 << 30, None).expect("threads"), composed(&source));
    let edit = |key: &str, value: &str| {
        let text = format!("{{\"source\": {:?}}}", path.file_name().unwrap_or_default().to_string_lossy());
        let of = options.iter().map(|(k, v)| (k.as_str(), if k == key { value } else { v.as_str() }));
        let document = Document::new(&path.with_extension("tailor"), &text, of).expect("a document");
        let opened = session.open(&content, &document.source_file(), document.options()).expect("a garment");
        let layers = document.layers(&opened.source, &mut Warnings::default()).expect("a recipe");
        let prepared = opened.checked.prepare(&layers).expect("a recipe");
        session.render(&opened, &prepared).expect("a mesh")
    };
    edit("", "");
    // Each value is asked for once, as by somebody who drags a slider.
    for (key, start) in [("seam.all.normalOffset", -0.01), ("seam.all.width", 0.05)] {
        let mut step = 0;
        group.bench_function(format!("edit of {key}"), |b| {
            b.iter(|| {
                step += 1;
                black_box(edit(key, &format!("{}", start + 1e-5 * f64::from(step))))
            });
        });
    }
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().sample_size(20).without_plots().configure_from_args();
    for (name, path, seams) in GARMENTS {
        let path = file(path);
        if path.exists() {
            measure(&mut criterion, name, &path, seams);
        } else {
            eprintln!("NOTE: {name} is not measured, as {} is not there", path.display());
        }
    }
    criterion.final_summary();
}
