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
    /// The error of the first part, or else that of the second.
    pub fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> Result<A, Error> + Send,
        second: impl FnOnce() -> Result<B, Error> + Send,
    ) -> Result<(A, B), Error> {
        let was_cancelled = AtomicBool::new(false);
        // The part that hears of a cancellation passes it on to the other.
        let pass_on = |error: &Error| {
            if error.kind == ErrorKind::Cancelled {
                was_cancelled.store(true, Ordering::Relaxed);
                self.cancel();
            }
        };
        let (first, second) = rayon::join(|| first().inspect_err(pass_on), || second().inspect_err(pass_on));
        if was_cancelled.into_inner() {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs ten steps, and cancels before the one of this number.
    fn steps(progress: &Progress, cancelled: Option<usize>) -> Result<usize, Error> {
        let mut clock = Clock::new(progress);
        for step in 0..10 {
            if cancelled == Some(step) {
                progress.cancel();
            }
            clock.run("step", || Ok(()))?;
        }
        Ok(clock.timings.len())
    }

    #[test]
    fn a_cancellation_ends_both_parts_and_no_later_build() {
        let progress = Progress::default();
        let never_ends = || loop {
            steps(&progress, None)?;
        };
        for _ in 0..20 {
            let joined = progress.join(|| steps(&progress, Some(3)), never_ends);
            assert_eq!(joined.map(|_: (usize, ())| ()).map_err(|e| e.kind), Err(ErrorKind::Cancelled));
            assert_eq!(progress.join(|| steps(&progress, None), || steps(&progress, None)).expect("a build"), (10, 10));
        }
    }

    #[test]
    fn another_error_leaves_a_cancellation_to_the_next_build() {
        let progress = Progress::default();
        let fault = || Err::<(), _>(Error::new(ErrorKind::Internal, "", "a fault"));
        let cancels = || {
            progress.cancel();
            Ok(())
        };
        assert_eq!(progress.join(fault, cancels).expect_err("a fault").kind, ErrorKind::Internal);
        assert_eq!(steps(&progress, None).expect_err("it is cancelled").kind, ErrorKind::Cancelled);
        assert!(steps(&progress, None).is_ok());
    }
}
