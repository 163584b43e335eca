//! The command line: flags as typed options, and the subcommands.

mod build;
pub mod codes;
mod drive;
mod example;
mod explain;
mod fit;
mod info;
mod preview;
mod process;
mod program;
mod report;
mod sets;
mod strict;
mod text;
mod variants;

pub use program::main;
pub use tailor_mesh::meter::Counting;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ColorChoice, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use process::{interrupt, memory, openusd, threads};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use strict::Strictness;
use tailor_costume::DEFAULT_MAX_FACES;
use tailor_costume::recipe::RecipeFile;
use tailor_mesh::error::{Error, ErrorKind, plain};
use tailor_usd::session::{Input, OpenGarment, beside, is_usd};
use tailor_usd::{LodSchema, ReadOptions, SetChoice};
use text::Wording;

/// One coarse garment mesh in, a simulation mesh and a render mesh out, in OpenUSD.
#[derive(Parser)]
#[command(name = "usdtailor", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Colours of messages; NO_COLOR is respected
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = ColorChoice::Auto, global = true, help_heading = "Run")]
    color: ColorChoice,
    /// Refuse layers that only OpenUSD reads, instead of having them read by its Python or usdcat where one is installed
    #[arg(long, global = true, help_heading = "Run")]
    no_fallback: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Write a simulation mesh and a render mesh beside the garment
    #[command(after_help = tailor_costume::recipe::help())]
    Build(Build),
    /// Move the render mesh of a garment with a simulated cache
    Drive(drive::Drive),
    /// Fit a garment to another body
    Fit(fit::Fit),
    /// Describe a garment and the meshes that `build` would write for it
    #[command(after_help = tailor_costume::recipe::help())]
    Info(ExamineArgs),
    /// Show a garment in the browser while its recipe is edited
    #[command(after_help = tailor_costume::recipe::help())]
    Preview(preview::Preview),
    /// Check garments; exit 1 if one has a problem
    Check(ExamineArgs),
    /// List the sets of a garment that a recipe can name, or write some of them into a layer
    #[command(after_help = tailor::sets::help())]
    Sets(sets::SetsCommand),
    /// Write an example garment to work on, or list all
    Example(example::Example),
    /// Explain a code of an error or warning, or list all codes
    Explain(explain::Explain),
    /// Print the options of the recipe as JSON, with their ranges, defaults and meanings
    Options,
    /// Print completions for a shell, such as: usdtailor completions zsh > _usdtailor
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write a man page for each subcommand into a folder
    Man {
        /// An existing folder, such as ~/.local/share/man/man1
        #[arg(value_name = "FOLDER")]
        folder: PathBuf,
    },
}

/// The inputs and how to read them.
#[derive(Args)]
struct Inputs {
    /// Garments: .usd, .usda, .usdc or .usdz files, or .tailor files that name one as their source
    #[arg(value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// Path of the mesh, such as /Coat/model, or of a prim that has one or several below it [default: the only mesh]
    #[arg(long, value_name = "PATH", help_heading = "Input")]
    prim: Option<String>,
    #[command(flatten)]
    several: Several,
    /// Time at which values are read [time codes] [default: the default time]
    #[arg(long, value_name = "TIME", help_heading = "Input", allow_negative_numbers = true)]
    time: Option<f64>,
    /// A .tailor file (JSON) with options for all inputs, which may name the source and the prim; or a USD layer that the
    /// preview saved
    #[arg(long, value_name = "FILE", help_heading = "Recipe")]
    recipe: Option<PathBuf>,
    /// Override one option, such as sim.maxEdgeLength=2 [mesh units] or render.level=2 [levels]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Recipe")]
    set: Vec<String>,
    /// Dialects of USD physics to write, of aousd, omni and chaos; or none: --set cloth.physics=... [default: aousd]
    #[arg(long, value_name = "NAMES", help_heading = "Recipe")]
    physics: Option<String>,
    /// Levels of detail, each with meshes of its own: --set lod.levels=N
    #[arg(long, value_name = "N", help_heading = "Recipe")]
    lods: Option<u32>,
    /// Store the source face of each vertex of the simulation mesh: --set sim.provenance=true
    #[arg(long, help_heading = "Recipe")]
    provenance: bool,
    /// Number of threads [default: one for each core]
    #[arg(long, value_name = "N", help_heading = "Run", allow_negative_numbers = true)]
    threads: Option<usize>,
    /// Print only errors
    #[arg(short, long, help_heading = "Run", conflicts_with = "verbose")]
    quiet: bool,
    /// Print more: what to do about warnings, the complete recipe, and the properties that stay on the model
    #[arg(short, long, help_heading = "Run")]
    verbose: bool,
}

/// Which of several meshes are garments, and how they are sewn.
#[derive(Args)]
struct Several {
    /// All meshes of the file, or below --prim: those whose borders coincide are sewn into one garment
    #[arg(long, help_heading = "Input")]
    all: bool,
    /// Leave out prims of this name or path and all below them, and take all other meshes; * stands for any letters, and
    /// /Suit.collection:props for the members of a collection; repeatable
    #[arg(long, value_name = "PATTERN", help_heading = "Input")]
    exclude: Vec<String>,
    /// Distance at which borders are sewn [share of the mean edge length] [default: 0.001]
    #[arg(long, value_name = "SHARE", help_heading = "Input", allow_negative_numbers = true)]
    sew_tolerance: Option<f64>,
}

#[derive(Args)]
struct Build {
    #[command(flatten)]
    inputs: Inputs,
    /// Output file (.usd, .usda, .usdc, or .usdz, which is always self-contained), or a folder for several inputs, which is made
    /// where it is missing
    #[arg(short, long, value_name = "OUT", help_heading = "Output")]
    output: PathBuf,
    /// Write one self-contained file instead of a layer over the input
    #[arg(long, help_heading = "Output")]
    flatten: bool,
    /// Build for each variant of this set, and write the products inside the variants
    #[arg(long, value_name = "SET", help_heading = "Output", conflicts_with = "flatten")]
    variants: Option<String>,
    /// Overwrite an existing output; the input is never overwritten
    #[arg(long, help_heading = "Output")]
    force: bool,
    /// Leave outputs that were made of the same files with the same options and version
    #[arg(long, help_heading = "Output")]
    skip_fresh: bool,
    /// Write counts, quality figures, times and warnings as JSON; - prints them instead of the summary
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    report: Option<PathBuf>,
    /// Write a render mesh for each of the panels that are sewn together, named after it
    #[arg(long, help_heading = "Output")]
    render_per_panel: bool,
    /// Write the simulation mesh with its physics, and no render mesh
    #[arg(long, help_heading = "Output", conflicts_with_all = ["render_per_panel", "mark"])]
    sim_only: bool,
    /// How levels of detail are written: as variants of the set LOD, or below a prim with LODRootAPI (OpenUSD 26.11)
    #[arg(long, value_name = "WHICH", default_value = "variants", value_parser = choice::<LodSchema>(["variants", "usdLod"]), help_heading = "Output")]
    lod_schema: LodSchema,
    /// Give the render mesh a set of the elements that each kind of warning names, such as mark_flipped_uvs
    #[arg(long, help_heading = "Output")]
    mark: bool,
    /// Sets of the products: none without a material, those of the model, or all, also of borders, seams and the recipe's
    /// expressions
    #[arg(long, value_name = "WHICH", default_value = "authored", value_parser = choice::<SetChoice>(["none", "authored", "all"]), help_heading = "Output")]
    sets: SetChoice,
    #[command(flatten)]
    strictness: Strictness,
    /// Say what would be written, and write nothing
    #[arg(long, help_heading = "Output", conflicts_with_all = ["report", "skip_fresh"])]
    dry_run: bool,
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
    #[command(flatten)]
    limits: Limits,
    /// Inputs that are built side by side [default: one for each thread]
    #[arg(long, value_name = "N", help_heading = "Run")]
    jobs: Option<NonZeroUsize>,
}

/// A parser of the names of the values of a type.
fn choice<T: DeserializeOwned + Clone + Send + Sync + 'static>(
    names: impl IntoIterator<Item = &'static str>,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(|name| serde_json::from_value(Value::String(name)))
}

#[derive(Args)]
struct ExamineArgs {
    #[command(flatten)]
    inputs: Inputs,
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    strictness: Strictness,
    /// Print one JSON object instead of text
    #[arg(long, help_heading = "Output")]
    json: bool,
}

#[derive(Args)]
struct Limits {
    /// Memory that the run may take, such as 8G or 500M [default: three quarters of what the machine leaves]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse, help_heading = "Run")]
    max_memory: Option<u64>,
}

/// The standard output of a subcommand, and its exit code.
struct Output {
    /// The text.
    text: String,
    /// The exit code.
    code: u8,
}

/// Runs the subcommand.
///
/// # Errors
/// Faults of the input, the recipe or the output.
fn run(cli: &Cli) -> Result<Output, Error> {
    text::set_colors(cli.color);
    if !cli.no_fallback {
        tailor_usd::set_converter(openusd::converted);
    }
    // Threads start where a subcommand works on meshes. The preview has pools of its own.
    let (threads, quiet, works) = match &cli.command {
        Command::Build(build) => (build.inputs.threads, build.inputs.quiet, true),
        Command::Drive(drive) => (drive.threads, drive.quiet, true),
        Command::Fit(fit) => (fit.inputs().threads, fit.inputs().quiet, true),
        Command::Info(args) | Command::Check(args) => (args.inputs.threads, args.inputs.quiet, true),
        Command::Sets(sets) => (sets.threads(), false, true),
        Command::Preview(preview) => (preview.inputs().threads, preview.inputs().quiet, false),
        _ => (None, false, false),
    };
    interrupt::tidy_up(matches!(cli.command, Command::Preview(_))).map_err(Error::no_thread)?;
    let threads = threads::capped(threads, quiet)?;
    if threads.is_some() || works {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build_global();
        pool.map_err(Error::no_thread)?;
    }
    match &cli.command {
        Command::Build(build) => build.strictness.check_codes().and_then(|()| build::run(build)),
        Command::Drive(drive) => drive::run(drive),
        Command::Fit(fit) => fit.strictness().check_codes().and_then(|()| fit::run(fit)),
        Command::Info(args) => args.strictness.check_codes().and_then(|()| info::info(args)),
        Command::Check(args) => args.strictness.check_codes().and_then(|()| info::check(args)),
        Command::Sets(sets) => sets::run(sets),
        Command::Example(example) => example::run(example),
        Command::Explain(explain) => explain::run(explain),
        Command::Options => Ok(options()),
        Command::Completions { shell } => Ok(completions(*shell)),
        Command::Man { folder } => man(folder),
        Command::Preview(preview) => preview::run(preview, threads),
    }
}

fn options() -> Output {
    let text = serde_json::to_string_pretty(&tailor_costume::recipe::table()).unwrap_or_default();
    Output { text: text + "\n", code: 0 }
}

fn completions(shell: Shell) -> Output {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "usdtailor", &mut text);
    Output { text: String::from_utf8_lossy(&text).into_owned(), code: 0 }
}

fn man(folder: &Path) -> Result<Output, Error> {
    clap_mangen::generate_to(Cli::command(), folder).map_err(|e| {
        let fault = usage(folder.display(), format!("cannot write man pages: {}", plain(&e)));
        fault.code(tailor_usd::codes::WRITE_FAILED).remedy("name an existing folder that you may write to")
    })?;
    Ok(Output { text: String::new(), code: 0 })
}

/// Writes an error to standard error.
fn print_error(error: &Error) {
    text::print_error(error, None);
}

/// An error in the command line.
fn usage(place: impl std::fmt::Display, text: impl Into<String>) -> Error {
    Error::new(ErrorKind::Usage, place, text)
}

impl Inputs {
    /// How much of warnings is printed.
    fn wording(&self) -> Wording {
        match (self.quiet, self.verbose) {
            (true, _) => Wording::Silent,
            (_, true) => Wording::Full,
            _ => Wording::Short,
        }
    }

    /// The files of the command line, or else the recipe's source.
    fn files(&self) -> Result<Vec<PathBuf>, Error> {
        if !self.inputs.is_empty() {
            return Ok(self.inputs.clone());
        }
        let source = match &self.recipe {
            Some(path) if !is_usd(path) => RecipeFile::read(path)?.source.map(|s| beside(path, &s)),
            _ => None,
        };
        source.map(|s| vec![s]).ok_or_else(|| {
            usage("", "no input")
                .code(codes::NO_INPUT)
                .remedy("name a USD file, or a recipe with a \"source\"; see --help")
        })
    }

    /// Refuses flags of products, where none are made.
    fn refuse_options_of_build(&self) -> Result<(), Error> {
        let flags =
            [("--lods", self.lods.is_some()), ("--physics", self.physics.is_some()), ("--provenance", self.provenance)];
        let Some((flag, _)) = flags.into_iter().find(|(_, is_given)| *is_given) else { return Ok(()) };
        let fault = usage(flag, "it sets up products, and this command makes none");
        Err(fault.code(tailor_mesh::codes::COMMAND_LINE).remedy("leave it out, and give it to `usdtailor build`"))
    }

    /// An input file with the options of the command line.
    fn input(&self, file: &Path) -> Input {
        let provenance = self.provenance.then(|| "sim.provenance=true".to_owned());
        let physics = self.physics.as_deref().map(|names| if names == "none" { "" } else { names });
        let physics = physics.map(|names| format!("cloth.physics={names}"));
        let lods = self.lods.map(|levels| format!("lod.levels={levels}"));
        Input {
            file: file.to_path_buf(),
            read: ReadOptions {
                prim: self.prim.clone(),
                time: self.time,
                all: self.several.all,
                exclude: self.several.exclude.clone(),
                sew_tolerance: self.several.sew_tolerance,
                ..ReadOptions::default()
            },
            base: None,
            recipe: self.recipe.clone(),
            body: None,
            overrides: provenance.into_iter().chain(physics).chain(lods).chain(self.set.iter().cloned()).collect(),
        }
    }

    /// Opens the garments of an input, of which there is at least one.
    fn open(&self, file: &Path) -> Result<Vec<OpenGarment>, Error> {
        self.input(file).open_all()
    }
}
