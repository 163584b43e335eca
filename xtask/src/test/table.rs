//! The announcement before the first step of a run, and the table after the last one.

use std::time::Duration;

use super::lanes::{Done, End};
use super::steps::{Download, Step};
use super::times::{Times, shown};
use crate::project::Project;

/// Says which steps run, how long they take, and what they download.
pub fn announce(project: &Project, steps: &[&Step], times: &Times) {
    let total = times.total(steps).map_or(String::new(), |(time, of)| format!(", {} {of}", shown(time)));
    eprintln!("{} steps{total}", steps.len());
    let missing = |d: &&Download| !project.target.join(d.kept).exists();
    let downloads: Vec<&Download> = steps.iter().flat_map(|step| step.downloads).filter(missing).collect();
    if downloads.is_empty() {
        return;
    }
    eprintln!("Downloads, at most {} MB:", downloads.iter().map(|d| d.megabytes).sum::<u32>());
    downloads.iter().for_each(|d| eprintln!("  {:>4} MB  {}", d.megabytes, d.what));
}

pub fn verdict(end: &End) -> &'static str {
    match end {
        End::Passed => "passed",
        End::Failed(_) => "FAILED",
        End::NotRun(_) => "NOT RUN",
    }
}

/// Prints a row for each step, and below it what failed.
pub fn print(steps: &[Done], total: Duration) {
    eprintln!("\nstep       time [s]");
    for done in steps {
        let why = match &done.end {
            End::NotRun(need) => format!(": needs {need}"),
            _ => String::new(),
        };
        eprintln!("{:<8} {:>10.1}  {}{why}", done.name, done.time.as_secs_f64(), verdict(&done.end));
        if let End::Failed(names) = &done.end {
            names.iter().for_each(|name| eprintln!("{:21}{name}", ""));
        }
    }
    eprintln!("{:<8} {:>10.1}", "total", total.as_secs_f64());
}
