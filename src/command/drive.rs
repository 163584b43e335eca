//! `usdtailor drive`.

use super::process::folders::MadeFolders;
use super::process::memory;
use super::text::{Wording, print_warnings};
use super::{Output, choice};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tailor_mesh::error::Error;
use tailor_mesh::files::folder_of;
use tailor_usd::{CacheFile, CacheSpace, DriveOptions, drive};

#[derive(Args)]
pub struct Drive {
    /// A garment that `usdtailor build` wrote, or a stage that has it
    #[arg(value_name = "RENDER")]
    render: PathBuf,
    /// The simulated cache: a USD file with the points of the simulation mesh over time, or .npz or .npy with an array of
    /// shape (frames, points, 3)
    #[arg(long, value_name = "FILE")]
    cache: PathBuf,
    /// The shot: a layer over RENDER with the moved points (.usdc, .usd or .usda)
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Path of the render mesh to drive, or of a simulation mesh for all that are bound to it [default: the only simulation
    /// mesh]
    #[arg(long, value_name = "PATH")]
    prim: Option<String>,
    #[command(flatten)]
    mesh: CacheMesh,
    /// Drive the garment's own mesh too, or the panels of which it is sewn
    #[arg(long)]
    model: bool,
    /// Write a file for each frame, in the folder OUT.clips, which OUT has as value clips; a folder of OUT that is missing is made
    #[arg(long)]
    clips: bool,
    /// Accept gaps between the frames of the cache
    #[arg(long)]
    gaps: bool,
    /// Overwrite an existing output
    #[arg(long)]
    force: bool,
    /// Largest shot to write, such as 20G [default: 1,000 times the cache on the disk, and at least 1G]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    max_size: Option<u64>,
    /// Number of threads [default: one for each core]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Print only errors
    #[arg(short, long)]
    pub quiet: bool,
}

/// The mesh of a cache.
#[derive(Args)]
pub struct CacheMesh {
    /// Path of the mesh in the cache [default: that of the simulation mesh, or the only one]
    #[arg(long, value_name = "PATH", requires = "cache")]
    cache_prim: Option<String>,
    /// The space of the cache's points: that of its stage (world), or that of the simulation mesh (local) [default: what the
    /// transforms of a USD cache say, and local for .npz and .npy]
    #[arg(long, value_name = "SPACE", requires = "cache", value_parser = choice::<CacheSpace>(["world", "local"]), hide_possible_values = true)]
    cache_space: Option<CacheSpace>,
}

impl CacheMesh {
    /// The mesh of a cache in a file.
    pub fn of(&self, file: &Path) -> CacheFile {
        CacheFile { file: file.to_path_buf(), prim: self.cache_prim.clone(), space: self.cache_space }
    }
}

/// Drives a garment.
pub fn run(args: &Drive) -> Result<Output, Error> {
    let options = DriveOptions {
        render: args.render.clone(),
        cache: args.mesh.of(&args.cache),
        output: args.output.clone(),
        prim: args.prim.clone(),
        model: args.model,
        clips: args.clips,
        gaps: args.gaps,
        force: args.force,
        max_size: args.max_size,
    };
    let bar = bar(args.quiet);
    let start = Instant::now();
    // Clips have a folder beside the shot, which is made in any case.
    let _made = args.clips.then(|| MadeFolders::new(folder_of(&args.output))).transpose()?;
    let driven = drive(&options, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    if args.quiet {
        return Ok(Output { text: String::new(), code: 0 });
    }
    print_warnings(driven.warnings.iter(), Wording::Full, None);
    let seconds = start.elapsed().as_secs_f64();
    let [first, last] = driven.times;
    let text = format!(
        "{} -> {}\n  {} frames, {first} to {last}, of {} points; {:.1} frames a second\n",
        args.cache.display(),
        args.output.display(),
        driven.frames,
        driven.points,
        driven.frames as f64 / seconds
    );
    let conversions = driven.conversions.iter().map(|words| format!("  {words}\n"));
    Ok(Output { text: text + &conversions.collect::<String>(), code: 0 })
}

/// A progress bar; hidden unless standard error is a terminal.
fn bar(quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left");
    ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
