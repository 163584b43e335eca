//! The number of threads.

use crate::codes;
use crate::text::Wording;
use crate::{text, usage};
use std::thread::available_parallelism;
use tailor_mesh::error::{Error, Warning};

/// Most threads for each core. More are slower to start than any work is to share.
const PER_CORE: usize = 4;

/// The variable of the environment that the threads are counted by where no option gives their number.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// The number of threads to start of those that are asked for.
///
/// # Errors
/// No threads.
pub fn capped(wanted: Option<usize>, quiet: bool) -> Result<Option<usize>, Error> {
    let of_environment = || std::env::var(VARIABLE).ok()?.parse().ok().filter(|count| *count > 0);
    let given = wanted.map(|count| ("--threads", count)).or_else(|| Some((VARIABLE, of_environment()?)));
    let Some((name, wanted)) = given else { return Ok(None) };
    if wanted == 0 {
        return Err(usage("--threads 0", "at least one thread is needed").remedy("give 1 or more"));
    }
    let cores = available_parallelism().map_or(1, usize::from);
    let most = PER_CORE * cores;
    if wanted > most {
        let problem = format!("{most} threads are started, {PER_CORE} for each of {cores} cores");
        let warning = Warning::new(codes::THREADS_CAPPED, format!("{name} {wanted}"), problem);
        let wording = if quiet { Wording::Silent } else { Wording::Full };
        text::print_warnings([&warning.remedy(format!("Give at most {most}"))], wording, None);
    }
    Ok(Some(wanted.min(most)))
}
