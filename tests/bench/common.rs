//! The garments that the benches work on, and how they are measured.

use criterion::Criterion;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tailor::internals::garment::{Garment, Interpolation, Primvar, check_garment};
use tailor::usd::{ReadOptions, Source};

/// The garments of this repository, and one of production size that is only measured where it has been downloaded.
const GARMENTS: [(&str, &str); 4] = [
    ("tshirt", "examples/tshirt.usda"),
    ("trousers", "examples/trousers.usda"),
    ("coat", "examples/coat.usda"),
    ("worksuit", "../shared/garments/male_worksuit01.usdc"),
];

/// A garment under the name that its measurements have.
pub struct Sample {
    /// The name.
    pub name: &'static str,
    /// The garment.
    pub garment: Garment,
}

impl Sample {
    /// The garment's UV set.
    pub fn uv_set(&self) -> &Primvar {
        let is_uv_set = |p: &&Primvar| p.interpolation == Interpolation::FaceVarying && p.width() == 2;
        self.garment.primvars.iter().find(is_uv_set).unwrap_or_else(|| panic!("{} has no UV set", self.name))
    }
}

/// All garments that are here; standard error names those that are not.
pub fn garments() -> Vec<Sample> {
    GARMENTS.iter().filter_map(|&(name, file)| load(name, file)).collect()
}

fn load(name: &'static str, file: &str) -> Option<Sample> {
    let path: PathBuf = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(file);
    if !path.exists() {
        eprintln!("NOTE: {name} is not measured, as {} is not there", path.display());
        return None;
    }
    let source = Source::open(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{file}: {e}"));
    let (input, _) = source.garment().unwrap_or_else(|e| panic!("{file}: {e}"));
    let (garment, _) = check_garment(input).unwrap_or_else(|e| panic!("{file}: {e}"));
    Some(Sample { name, garment })
}

/// Few samples and short times: all benches together take about two minutes.
pub fn criterion() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(500))
        .without_plots()
        .configure_from_args()
}
