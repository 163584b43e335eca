//! Several builds side by side, within a bound of memory.

use super::{Outcome, Task};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, RwLock, mpsc};
use std::thread;
use tailor_mesh::error::Error;
use tailor_mesh::meter::{PassedLimit, within_limit};

/// Runs `work` on every task, on `jobs` threads, and hands the outcomes to `take` in the order of the tasks. The work of
/// one task spreads over the threads of the process; a task whose work panics has failed, and the others go on.
pub fn run_all(
    tasks: &[Task],
    jobs: usize,
    work: impl Fn(&Task) -> Outcome + Sync,
    mut take: impl FnMut(&Task, Outcome),
) {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        let (mut started, mut failure) = (0, None);
        for _ in 0..jobs.max(1) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            let job = move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(task) = tasks.get(at) else { break };
                    let outcome = catch_unwind(AssertUnwindSafe(|| work(task))).unwrap_or_else(|panic| {
                        Outcome::Failed(Error::internal(crate::program::panic_text(panic.as_ref())))
                    });
                    if sender.send((at, outcome)).is_err() {
                        break;
                    }
                }
            };
            // The jobs that have started do the work of a job that cannot start.
            if let Err(e) = thread::Builder::new().name("job".into()).spawn_scoped(scope, job) {
                failure = Some(Error::no_thread(e));
                break;
            }
            started += 1;
        }
        drop(sender);
        if let Some(failure) = failure.filter(|_| started == 0) {
            tasks.iter().for_each(|task| take(task, Outcome::Failed(failure.clone())));
            return;
        }
        let (mut waiting, mut due) = (BTreeMap::new(), 0);
        for (at, outcome) in receiver {
            waiting.insert(at, outcome);
            while let Some(outcome) = waiting.remove(&due) {
                take(&tasks[due], outcome);
                due += 1;
            }
        }
    });
}

/// The memory that the builds of a run share. \[bytes\]
pub struct Budget {
    limit: usize,
    used: Mutex<usize>,
    freed: Condvar,
    /// Held for writing by a build that runs alone, and for reading by each other one.
    turns: RwLock<()>,
}

/// A part of a budget, which is given back when it is dropped.
pub struct BudgetShare<'a> {
    budget: &'a Budget,
    bytes: usize,
}

impl Budget {
    /// A budget of `limit` bytes.
    pub fn new(limit: usize) -> Self {
        Self { limit, used: Mutex::new(0), freed: Condvar::new(), turns: RwLock::new(()) }
    }

    /// All of it.
    pub fn limit(&self) -> usize {
        self.limit
    }

    /// The result of a build beside others. If all of them pass the limit together, it is built again alone.
    ///
    /// # Errors
    /// A build that passes the limit alone.
    pub fn build<T>(&self, is_lone: bool, work: impl Fn() -> T) -> Result<T, PassedLimit> {
        let beside_others = {
            let _turn = self.turns.read().unwrap_or_else(PoisonError::into_inner);
            within_limit(&work)
        };
        match beside_others {
            Err(_) if !is_lone => {
                let _turn = self.turns.write().unwrap_or_else(PoisonError::into_inner);
                within_limit(work)
            }
            result => result,
        }
    }

    /// Waits until `bytes` are free, or nothing else is reserved.
    pub fn reserve(&self, bytes: usize) -> BudgetShare<'_> {
        let mut used = lock(&self.used);
        while *used > 0 && used.saturating_add(bytes) > self.limit {
            used = self.freed.wait(used).unwrap_or_else(PoisonError::into_inner);
        }
        *used = used.saturating_add(bytes);
        BudgetShare { budget: self, bytes }
    }
}

impl Drop for BudgetShare<'_> {
    fn drop(&mut self) {
        let mut used = lock(&self.budget.used);
        *used = used.saturating_sub(self.bytes);
        self.budget.freed.notify_all();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn tasks(count: usize) -> Vec<Task> {
        let task = |i: usize| Task { input: PathBuf::from(i.to_string()), ..Task::default() };
        (0..count).map(task).collect()
    }

    #[test]
    fn outcomes_come_in_the_order_of_the_tasks_and_a_panic_fails_one_alone() {
        let tasks = tasks(40);
        let work = |task: &Task| {
            let number: usize = task.input.to_str().and_then(|n| n.parse().ok()).expect("a number");
            thread::sleep(std::time::Duration::from_micros((40 - number as u64) * 50));
            assert!(number != 7, "the seventh");
            Outcome::Fresh(Vec::new())
        };
        let mut seen = Vec::new();
        run_all(&tasks, 4, work, |task, outcome| {
            seen.push((task.input.clone(), matches!(outcome, Outcome::Failed(_))));
        });
        let wanted: Vec<_> = tasks.iter().enumerate().map(|(i, task)| (task.input.clone(), i == 7)).collect();
        assert_eq!(seen, wanted);
    }

    #[test]
    fn no_more_is_reserved_than_the_limit_unless_one_alone_needs_it() {
        let budget = Budget::new(100);
        let most = AtomicUsize::new(0);
        let small = Mutex::new(0);
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    for _ in 0..20 {
                        let _part = budget.reserve(40);
                        let now = {
                            let mut now = lock(&small);
                            *now += 40;
                            *now
                        };
                        most.fetch_max(now, Ordering::Relaxed);
                        *lock(&small) -= 40;
                    }
                });
            }
        });
        assert!(most.load(Ordering::Relaxed) <= 100);
        drop(budget.reserve(1000));
        assert_eq!(*lock(&budget.used), 0);
    }
}
