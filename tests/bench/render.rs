//! Time of the render mesh: seams on all UV seams, hems on all panels at a border, two refinements, all attributes; and
//! of one edit of a seam.

#![allow(clippy::print_stderr)]

#[path = "../common/operators.rs"]
mod operators;

use criterion::Criterion;
use operators::{border_panels, rendered};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use tailor::internals::garment::{Garment, check_garment};
use tailor::recipe::Layers;
use tailor::usd::{ReadOptions, Source};
use tailor::{Builder, Recipe};

/// Name, file and edge set of the garments; those that are not here are not measured.
const GARMENTS: [(&str, &str, &str); 2] =
    [("coat", "examples/coat.usda", "side_seams"), ("worksuit", "../shared/garments/male_worksuit01.usdc", "uvSeams")];

fn file(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(name)
}

/// Seams and hems of sizes that the garment's edges have room for.
fn options(garment: &Garment, seams: &str) -> Vec<(String, String)> {
    let size = tailor::internals::pipeline::mean_edge_length(garment);
    let panels = border_panels(garment);
    let pairs = [
        ("seam.all.edges", seams.to_owned()),
        ("seam.all.width", format!("{}", 0.3 * size)),
        ("seam.all.normalOffset", format!("{}", -0.05 * size)),
        ("fold.hem.faces", panels),
        ("fold.hem.thickness", format!("{}", 0.08 * size)),
        ("render.level", "2".to_owned()),
    ];
    pairs.map(|(key, value)| (key.to_owned(), value)).to_vec()
}

fn recipe(options: &[(String, String)]) -> Recipe {
    let mut layers = Layers::default();
    options.iter().for_each(|(key, value)| layers.add_text("bench", key, value).expect("an option"));
    layers.recipe().expect("a recipe")
}

fn measure(c: &mut Criterion, name: &str, path: &Path, seams: &str) {
    let source = Source::open(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (input, _) = source.garment().unwrap_or_else(|e| panic!("{name}: {e}"));
    let (garment, _) = check_garment(input).unwrap_or_else(|e| panic!("{name}: {e}"));
    let options = options(&garment, seams);
    let assigned: Vec<String> = options.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let mut group = c.benchmark_group(format!("render/{name}"));
    group.bench_function("whole", |b| {
        b.iter(|| black_box(rendered(&garment, &assigned)));
    });
    group.bench_function("no operators", |b| {
        b.iter(|| black_box(rendered(&garment, &["render.level=2"])));
    });
    let (mesh, _) = source.garment().unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut builder = Builder::new(mesh).expect("a garment");
    let mut edit = |key: &str, value: &str| {
        let of = |(k, v): &(String, String)| (k.clone(), if k == key { value.to_owned() } else { v.clone() });
        builder.update(&recipe(&options.iter().map(of).collect::<Vec<_>>())).expect("a mesh").render
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
