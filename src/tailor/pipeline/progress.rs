//! Progress, cancellation, and times of steps.

use serde::Serialize;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use tailor_mesh::error::{Error, ErrorKind};

type Report = dyn Fn(&str) + Send + Sync;

/// Hears the name of each step as it begins, and can cancel a build from another thread. Copies are one handle.
#[derive(Clone, Default)]
pub struct Progress {
    report: Option<Arc<Report>>,
    is_cancelled: Arc<AtomicBool>,
}

impl Progress {
    /// A handle that tells `report` the name of each step.
    pub fn new(report: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self { report: Some(Arc::new(report)), ..Self::default() }
    }

    /// Ends the build before its next step or at its end, with an error of the kind [`ErrorKind::Cancelled`]. A build that
    /// has not begun yet ends at once. The one after it runs again.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Runs two parts of a build beside each other. A cancellation ends both.
    ///
    /// # Errors
    /// Those of the first part, then those of the second.
    pub fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> Result<A, Error> + Send,
        second: impl FnOnce() -> Result<B, Error> + Send,
    ) -> Result<(A, B), Error> {
        // Whichever part hears of it tells the other.
        let heard = |error: &Error| {
            if error.kind == ErrorKind::Cancelled {
                self.cancel();
            }
        };
        let (first, second) = rayon::join(|| first().inspect_err(heard), || second().inspect_err(heard));
        if first.is_err() || second.is_err() {
            self.is_cancelled.store(false, Ordering::Relaxed);
        }
        Ok((first?, second?))
    }

    /// Fails, once, if the build was cancelled.
    fn check(&self) -> Result<(), Error> {
        if self.is_cancelled.swap(false, Ordering::Relaxed) {
            return Err(Error::new(ErrorKind::Cancelled, "", "the build was cancelled"));
        }
        Ok(())
    }
}

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress").field("is_cancelled", &self.is_cancelled).finish_non_exhaustive()
    }
}

/// The time of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Name of the step.
    pub name: &'static str,
    /// \[seconds\]
    pub seconds: f64,
}

/// Runs steps, tells of them and takes their times.
pub struct Clock<'a> {
    progress: &'a Progress,
    /// The times of the steps so far.
    pub timings: Vec<Timing>,
}

impl<'a> Clock<'a> {
    /// A clock that tells of each step by `progress`.
    pub fn new(progress: &'a Progress) -> Self {
        Self { progress, timings: Vec::new() }
    }

    /// Runs a step.
    ///
    /// # Errors
    /// Errors of the step; cancellation before the step.
    pub fn run<T>(&mut self, name: &'static str, work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        self.progress.check()?;
        self.progress.report.iter().for_each(|report| report(name));
        let start = Instant::now();
        let result = work();
        self.timings.push(Timing { name, seconds: start.elapsed().as_secs_f64() });
        result
    }

    /// Fails if the build was cancelled during its last step, so that the next one is not.
    ///
    /// # Errors
    /// Cancellation.
    pub fn finish(&self) -> Result<(), Error> {
        self.progress.check()
    }
}
