//! Ways to share work between the threads of a pool, where the points of a render mesh and its attributes are made at the
//! same time.
//!
//! A thread that waits takes up whatever else there is to do, and is not back before it is done. So nothing long may lie
//! about: the points are not a task of their own before there is something to do for them, and the attributes, of which
//! nothing else waits, are many short ones.

use rayon::{Scope, Yield};
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Works on all parts, each by a thread of the pool that has nothing else to do.
pub fn when_idle<T: Send>(parts: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
    let parts = Mutex::new(parts);
    rayon::scope(|scope| next_part(scope, &parts, &work));
}

/// Works on the next part once nothing else is to be done. The one after it is another task, for who has nothing to do, so
/// that a thread that waits for something else is soon back. There is only one at a time, which nobody finds in place of
/// other work.
fn next_part<'s, T: Send + 's>(
    scope: &Scope<'s>,
    parts: &'s Mutex<impl Iterator<Item = T> + Send>,
    work: &'s (impl Fn(T) + Sync),
) {
    while rayon::yield_now() == Some(Yield::Executed) {}
    let part = lock(parts).next();
    if let Some(part) = part {
        scope.spawn(|scope| next_part(scope, parts, work));
        work(part);
    }
}

/// Work that is done step by step, in the order in which the steps are sent, beside what sends them. Nobody waits for it
/// but the scope.
pub struct Follower<T, W> {
    steps: Mutex<Steps<T>>,
    /// Held by who is at the steps.
    work: Mutex<W>,
}

struct Steps<T> {
    waiting: VecDeque<T>,
    /// Whether a thread is at them.
    is_followed: bool,
}

impl<T: Send, W: FnMut(T) + Send> Follower<T, W> {
    /// What does `work` with each step.
    pub fn new(work: W) -> Self {
        Self { steps: Mutex::new(Steps { waiting: VecDeque::new(), is_followed: false }), work: Mutex::new(work) }
    }

    /// Adds a step, which is done within the scope.
    pub fn send<'s>(&'s self, scope: &Scope<'s>, step: T) {
        let mut steps = lock(&self.steps);
        steps.waiting.push_back(step);
        if !std::mem::replace(&mut steps.is_followed, true) {
            scope.spawn(|_| self.follow());
        }
    }

    fn follow(&self) {
        while let Some(step) = self.next() {
            lock(&self.work)(step);
        }
    }

    fn next(&self) -> Option<T> {
        let mut steps = lock(&self.steps);
        let next = steps.waiting.pop_front();
        steps.is_followed = next.is_some();
        next
    }
}

/// What a panic elsewhere leaves is not used: the scope passes the panic on.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::ThreadPoolBuilder;

    fn with_threads(test: impl Fn() + Sync) {
        for threads in [1, 2, 5] {
            ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(&test);
        }
    }

    #[test]
    fn each_part_is_worked_on_once() {
        with_threads(|| {
            for count in [0, 1, 2, 1000] {
                let mut numbers = vec![0; count];
                when_idle(numbers.iter_mut().enumerate(), |(i, number)| *number += i + 1);
                assert!(numbers.into_iter().eq(1..=count));
            }
        });
    }

    #[test]
    fn steps_are_followed_in_their_order() {
        with_threads(|| {
            let mut followed = Vec::new();
            let follower = Follower::new(|step: usize| {
                let mut sums = vec![0; 1000];
                when_idle(sums.iter_mut(), |sum| *sum += step);
                followed.push(sums.iter().sum::<usize>());
            });
            rayon::scope(|scope| (0..100).for_each(|step| follower.send(scope, step)));
            assert_eq!(lock(&follower.steps).waiting.len(), 0);
            drop(follower);
            assert!(followed.into_iter().eq((0..100).map(|step| 1000 * step)));
        });
    }
}
