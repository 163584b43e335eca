//! The times of the steps: those of the last run here, and those of docs/developing.md.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use super::steps::{Lane, STEPS, Step};
use crate::process::{Failure, Outcome};
use crate::project::Project;

/// The document with a row of times for each step: cold and warm. \[s\]
const DOCUMENT: &str = "docs/developing.md";

/// Times by the names of the steps. \[s\]
type Seconds = BTreeMap<String, f64>;

/// The expected times of steps.
pub struct Times {
    last: Seconds,
    /// Of an empty target folder if this one is, or else of a later run.
    documented: Seconds,
}

impl Times {
    pub fn read(project: &Project) -> Outcome<Self> {
        let last = fs::read_to_string(file(project)).map(|text| parse(&text)).unwrap_or_default();
        let [cold, warm] = documented(&project.read(DOCUMENT)?);
        Ok(Self { documented: if last.is_empty() { cold } else { warm }, last })
    }

    /// The time to expect of a step, as the end of a sentence.
    pub fn told(&self, step: &str) -> String {
        match (self.last.get(step), self.documented.get(step)) {
            (Some(time), _) => format!(" ({} last time)", shown(*time)),
            (None, Some(time)) => format!(" ({} on two quiet cores)", shown(*time)),
            (None, None) => String::new(),
        }
    }

    /// The time to expect of some steps, which run two at a time, and where that was measured.
    pub fn total(&self, steps: &[&Step]) -> Option<(f64, &'static str)> {
        let sum = |of: &Seconds, lane| {
            let times = steps.iter().filter(|step| step.lane == lane).map(|step| of.get(step.name).copied());
            times.sum::<Option<f64>>()
        };
        let longer = |of| Some(f64::max(sum(of, Lane::Main)?, sum(of, Lane::Beside)?));
        let last = longer(&self.last).map(|time| (time, "last time"));
        last.or_else(|| longer(&self.documented).map(|time| (time, "on two quiet cores")))
    }

    /// Notes the times of steps that have passed.
    pub fn write(mut self, project: &Project, measured: &BTreeMap<&str, f64>) -> Outcome {
        self.last.extend(measured.iter().map(|(name, time)| ((*name).to_owned(), *time)));
        let mut text = String::new();
        for (name, time) in &self.last {
            let _ = writeln!(text, "{name} {time:.1}");
        }
        fs::write(file(project), text).map_err(|error| Failure::new(format!("cannot note the times of steps: {error}")))
    }
}

fn file(project: &Project) -> PathBuf {
    project.target.join("test-times.txt")
}

fn parse(text: &str) -> Seconds {
    text.lines()
        .filter_map(|line| line.split_once(' '))
        .filter_map(|(n, t)| Some((n.to_owned(), t.parse().ok()?)))
        .collect()
}

/// The cold and the warm times in the rows of the document: `| page | 6 | 2 |`.
fn documented(text: &str) -> [Seconds; 2] {
    let mut times = [Seconds::new(), Seconds::new()];
    for line in text.lines().filter(|line| line.starts_with('|')) {
        let mut cells = line.split('|').skip(1).map(|cell| cell.trim().trim_matches('`'));
        let Some(name) = cells.next().filter(|name| STEPS.iter().any(|step| step.name == *name)) else { continue };
        for (times, cell) in times.iter_mut().zip(cells) {
            times.extend(cell.parse().ok().map(|time| (name.to_owned(), time)));
        }
    }
    times
}

/// A time as people say it.
pub fn shown(seconds: f64) -> String {
    if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.1} minutes", seconds / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_has_the_times_of_all_steps() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let [cold, warm] = documented(&fs::read_to_string(root.join(DOCUMENT)).unwrap());
        for step in &STEPS {
            assert!(
                cold.contains_key(step.name) && warm.contains_key(step.name),
                "{DOCUMENT}: no times of {}",
                step.name
            );
        }
    }

    #[test]
    fn the_last_time_is_told_before_that_of_the_document() {
        let times = |seconds: f64| Seconds::from([("rust".to_owned(), seconds)]);
        let told = |last, documented| Times { last, documented }.told("rust");
        assert_eq!(told(times(12.3), times(400.0)), " (12 s last time)");
        assert_eq!(told(Seconds::new(), times(400.0)), " (6.7 minutes on two quiet cores)");
        assert_eq!(parse("rust 12.3\nodd\n"), times(12.3));
    }
}
