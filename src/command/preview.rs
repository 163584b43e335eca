//! `usdtailor preview`.

use super::drive::CacheMesh;
use super::{Inputs, Output, usage};
use clap::Args;
use std::io::Write;
use std::path::PathBuf;
use tailor_mesh::error::Error;
use tailor_usd::session::Input;

#[derive(Args)]
pub struct Preview {
    #[command(flatten)]
    inputs: Inputs,
    /// A simulated cache to play, as for `usdtailor drive`
    #[arg(long, value_name = "FILE", help_heading = "Preview")]
    cache: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Preview")]
    mesh: CacheMesh,
    /// A body to show under the garment [default: that of the recipe's fit.to]
    #[arg(long, value_name = "FILE", help_heading = "Preview")]
    body: Option<PathBuf>,
    /// Port of the page on 127.0.0.1 [default: any that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true, help_heading = "Preview")]
    port: u16,
    /// Print the address and open no browser
    #[arg(long, help_heading = "Preview")]
    no_open: bool,
}

impl Preview {
    /// The inputs.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }
}

/// Serves the preview until Ctrl-C, each of its two builds with `threads` threads.
pub fn run(preview: &Preview, threads: Option<usize>) -> Result<Output, Error> {
    let files = preview.inputs.files()?;
    let [file] = files.as_slice() else {
        return Err(usage("", format!("{} inputs, and the preview shows one", files.len())).remedy("name one garment"));
    };
    if preview.inputs.several.all || !preview.inputs.several.exclude.is_empty() {
        return Err(usage("", "the preview shows one mesh").remedy("name it by --prim, without --all and --exclude"));
    }
    let shown = file.display().to_string();
    let ready = |address: &str| {
        // The address is also the way in where no browser opens.
        let _ = writeln!(std::io::stdout(), "preview of {shown}: {address}\nCtrl-C ends it");
        let _ = std::io::stdout().flush();
        if !preview.no_open && open::that_detached(address).is_err() {
            let _ = writeln!(std::io::stderr(), "warning: no browser could be opened. Open the address in one");
        }
    };
    let cache = preview.cache.as_ref().map(|file| preview.mesh.of(file));
    let input = Input { body: preview.body.clone(), ..preview.inputs.input(file) };
    tailor_preview::serve(input, cache, preview.port, threads, ready)?;
    // A page may be saving yet.
    tailor_usd::remove_unfinished();
    Ok(Output { text: String::new(), code: 0 })
}
