//! The command line: flags as typed options, and the subcommands `build`, `info` and `check`.

mod build;
mod info;
mod report;
mod text;

use clap::{Args, Parser, Subcommand};
use std::path::{Path, PathBuf};
use tailor::error::{Error, ErrorKind, Warnings};
use tailor::recipe::{Layers, RecipeFile, is_recipe};
use tailor::usd::{ReadOptions, Source};
use tailor::{Builder, DEFAULT_MAX_FACES, GarmentInput, Recipe};

/// One coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.
#[derive(Parser)]
#[command(name = "usdtailor", version, disable_help_subcommand = true, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a simulation mesh and a render mesh beside the garment
    #[command(after_help = tailor::recipe::help())]
    Build(Build),
    /// Describe a garment and the meshes that `build` would write for it
    #[command(after_help = tailor::recipe::help())]
    Info(Inputs),
    /// Check garments; exit 1 if one has a problem
    Check(Inputs),
}

/// The inputs and how to read them.
#[derive(Args)]
struct Inputs {
    /// Garments: .usd, .usda, .usdc or .usdz files, or .tailor files that name one as their source
    #[arg(value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// Path of the mesh, such as /Coat/model [default: the only mesh]
    #[arg(long, value_name = "PATH", help_heading = "Input")]
    prim: Option<String>,
    /// Time at which values are read [time codes] [default: the default time]
    #[arg(long, value_name = "TIME", help_heading = "Input", allow_negative_numbers = true)]
    time: Option<f64>,
    /// A .tailor file (JSON) with options for all inputs; it may name the source and the prim
    #[arg(long, value_name = "FILE", help_heading = "Recipe")]
    recipe: Option<PathBuf>,
    /// Override one option, such as sim.maxEdgeLength=2 [stage units] or render.level=2 [levels]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Recipe")]
    set: Vec<String>,
    /// Store the source face of each vertex of the simulation mesh: --set sim.provenance=true
    #[arg(long, help_heading = "Recipe")]
    provenance: bool,
    /// Number of threads [default: one for each core]
    #[arg(long, value_name = "N", help_heading = "Run", allow_negative_numbers = true)]
    threads: Option<usize>,
    /// Print only errors
    #[arg(short, long, help_heading = "Run", conflicts_with = "verbose")]
    quiet: bool,
    /// Print more: the complete recipe, and the properties that stay on the model
    #[arg(short, long, help_heading = "Run")]
    verbose: bool,
}

#[derive(Args)]
struct Build {
    #[command(flatten)]
    inputs: Inputs,
    /// Output file (.usd, .usda, .usdc, or .usdz, which is always self-contained), or a folder for several inputs
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: PathBuf,
    /// Write one self-contained file instead of a layer over the input
    #[arg(long, help_heading = "Output")]
    flatten: bool,
    /// Overwrite an existing output; the input is never overwritten
    #[arg(long, help_heading = "Output")]
    force: bool,
    /// Write counts, quality figures, times and warnings as JSON
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    report: Option<PathBuf>,
    /// Name of the simulation mesh
    #[arg(long, value_name = "NAME", default_value = "sim", help_heading = "Output")]
    sim_name: String,
    /// Name of the render mesh
    #[arg(long, value_name = "NAME", default_value = "render", help_heading = "Output")]
    render_name: String,
    /// Keep the model's purpose instead of setting it to "guide"
    #[arg(long, help_heading = "Output")]
    keep_model_purpose: bool,
    /// Largest simulation mesh to build [triangles]
    #[arg(long, value_name = "N", default_value_t = DEFAULT_MAX_FACES, help_heading = "Run", allow_negative_numbers = true)]
    max_faces: usize,
}

/// The standard output of a subcommand, and its exit code.
pub struct Output {
    /// The text.
    pub text: String,
    /// The exit code.
    pub code: u8,
}

/// Runs the subcommand.
///
/// # Errors
/// Faults of the input, the recipe or the output.
pub fn run(cli: &Cli) -> Result<Output, Error> {
    let inputs = match &cli.command {
        Command::Build(build) => &build.inputs,
        Command::Info(inputs) | Command::Check(inputs) => inputs,
    };
    if let Some(threads) = inputs.threads {
        if threads == 0 {
            return Err(usage("--threads 0", "at least one thread is needed").remedy("give 1 or more"));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        pool.map_err(|e| Error::internal(format!("cannot start {threads} threads: {e}")))?;
    }
    match &cli.command {
        Command::Build(build) => build::run(build),
        Command::Info(inputs) => info::info(inputs),
        Command::Check(inputs) => info::check(inputs),
    }
}

/// An opened input, before its mesh and its recipe are checked.
struct Opened {
    source: Source,
    mesh: GarmentInput,
    layers: Layers,
    warnings: Warnings,
}

impl Opened {
    /// Checks the mesh, and the recipe against it. The builder has the warnings of both.
    fn check(self) -> Result<(Source, Builder, Recipe), Error> {
        let builder = Builder::new(self.mesh)?.with_warnings(self.warnings);
        let recipe = self.layers.recipe_for(builder.garment())?;
        Ok((self.source, builder, recipe))
    }
}

/// An error in the command line.
fn usage(place: impl std::fmt::Display, text: impl Into<String>) -> Error {
    Error::new(ErrorKind::Usage, place, text)
}

impl Inputs {
    /// The recipe file, if one was given.
    fn recipe_file(&self) -> Result<Option<RecipeFile>, Error> {
        self.recipe.as_deref().map(RecipeFile::read).transpose()
    }

    /// The files of the command line, or else the recipe's source.
    fn files(&self) -> Result<Vec<PathBuf>, Error> {
        if !self.inputs.is_empty() {
            return Ok(self.inputs.clone());
        }
        let source = match (&self.recipe, self.recipe_file()?) {
            (Some(path), Some(file)) => file.source.map(|s| beside(path, &s)),
            _ => None,
        };
        source
            .map(|s| vec![s])
            .ok_or_else(|| usage("", "no input").remedy("name a USD file, or a recipe with a \"source\"; see --help"))
    }

    /// Opens an input: a USD file, or the source of a `.tailor` file.
    fn open(&self, input: &Path) -> Result<Opened, Error> {
        let own = if is_recipe(input) { Some(RecipeFile::read(input)?) } else { None };
        let file = match &own {
            Some(own) => beside(input, own.required_source(input)?),
            None => input.to_path_buf(),
        };
        // Weakest first.
        let recipes: Vec<RecipeFile> = own.into_iter().chain(self.recipe_file()?).collect();
        let prim = self.prim.clone().or_else(|| recipes.iter().rev().find_map(|r| r.prim.clone()));
        let source = Source::open(&file, &ReadOptions { prim, time: self.time })?;
        let mut warnings = Warnings::default();
        let mut layers = Layers::default();
        layers.add_attributes(source.recipe()?, &mut warnings);
        recipes.into_iter().for_each(|recipe| layers.add(recipe.into_layer()));
        if self.provenance {
            layers.add_override("sim.provenance=true")?;
        }
        for assignment in &self.set {
            layers.add_override(assignment)?;
        }
        let mesh = source.garment(&mut warnings)?;
        Ok(Opened { source, mesh, layers, warnings })
    }
}

/// The path of `source`, which the recipe at `path` names relative to itself.
fn beside(path: &Path, source: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(source)
}
