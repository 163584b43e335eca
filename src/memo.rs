//! Values that were made before, by key, within a bound of memory.

use crate::error::{Error, Warnings};
use std::any::Any;
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Something whose size in memory can be told.
pub trait Footprint {
    /// An estimate of the memory that it holds. \[bytes\]
    fn footprint(&self) -> usize;
}

/// A result with its warnings.
pub struct Made<T> {
    /// The result.
    pub value: T,
    /// What was met on the way.
    pub warnings: Warnings,
}

/// A result without warnings.
impl<T> From<T> for Made<T> {
    fn from(value: T) -> Self {
        Self { value, warnings: Warnings::default() }
    }
}

/// A cache of values of any type. Each is made once, however many threads ask for it: the others wait. Only a thread of a
/// pool makes it for itself: what it would wait for may be left to it. Values that were not used for longest are forgotten
/// first, when all together are larger than the capacity.
pub struct Memo<K> {
    entries: Mutex<Entries<K>>,
    made: Condvar,
    capacity: usize,
}

struct Entries<K> {
    slots: HashMap<K, Slot>,
    used: usize,
    clock: u64,
}

enum Slot {
    /// A thread is at it.
    Pending,
    /// It is here.
    Ready { value: Arc<dyn Any + Send + Sync>, bytes: usize, last_use: u64 },
}

impl<K: Clone + Eq + Hash> Memo<K> {
    /// A cache that keeps at most `capacity` bytes.
    pub fn new(capacity: usize) -> Self {
        let entries = Entries { slots: HashMap::new(), used: 0, clock: 0 };
        Self { entries: Mutex::new(entries), made: Condvar::new(), capacity }
    }

    /// The value of `key`, made by `make` unless it is here. A failure is not kept.
    ///
    /// `make` may ask for other keys, but not for `key`, and must not wait for another thread that does.
    ///
    /// # Errors
    /// What `make` reports.
    pub fn get<V>(&self, key: &K, make: impl FnOnce() -> Result<V, Error>) -> Result<Arc<V>, Error>
    where
        V: Footprint + Send + Sync + 'static,
    {
        match self.find_or_claim(key) {
            Found::Ready(value) => {
                return value.downcast().map_err(|_| Error::Internal("a stage's key names two kinds of result".into()));
            }
            Found::Pending => return make().map(Arc::new),
            Found::Claimed => {}
        }
        // Gives the key up again when `make` fails or panics.
        let claim = Claim { memo: self, key };
        let value = Arc::new(make()?);
        let bytes = value.footprint();
        self.lock().keep(key, Arc::<V>::clone(&value), bytes, self.capacity);
        drop(claim);
        Ok(value)
    }

    /// Memory in use. \[bytes\]
    pub fn used(&self) -> usize {
        self.lock().used
    }

    /// The value, or the duty to make it.
    fn find_or_claim(&self, key: &K) -> Found {
        let mut entries = self.lock();
        loop {
            entries.clock += 1;
            let now = entries.clock;
            match entries.slots.get_mut(key) {
                Some(Slot::Ready { value, last_use, .. }) => {
                    *last_use = now;
                    return Found::Ready(Arc::clone(value));
                }
                Some(Slot::Pending) if rayon::current_thread_index().is_some() => return Found::Pending,
                Some(Slot::Pending) => {
                    entries = self.made.wait(entries).unwrap_or_else(PoisonError::into_inner);
                }
                None => {
                    entries.slots.insert(key.clone(), Slot::Pending);
                    return Found::Claimed;
                }
            }
        }
    }

    /// No code of others runs under the lock, so that a panic elsewhere leaves the entries as they should be.
    fn lock(&self) -> MutexGuard<'_, Entries<K>> {
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<K: Clone + Eq + Hash> Entries<K> {
    fn keep(&mut self, key: &K, value: Arc<dyn Any + Send + Sync>, bytes: usize, capacity: usize) {
        if bytes > capacity {
            return;
        }
        while self.used + bytes > capacity && self.forget_oldest() {}
        self.clock += 1;
        self.used += bytes;
        self.slots.insert(key.clone(), Slot::Ready { value, bytes, last_use: self.clock });
    }

    fn forget_oldest(&mut self) -> bool {
        let age = |slot: &Slot| match slot {
            Slot::Ready { last_use, .. } => Some(*last_use),
            Slot::Pending => None,
        };
        let oldest = self.slots.iter().filter_map(|(key, slot)| Some((age(slot)?, key))).min_by_key(|(age, _)| *age);
        let Some(key) = oldest.map(|(_, key)| key.clone()) else { return false };
        if let Some(Slot::Ready { bytes, .. }) = self.slots.remove(&key) {
            self.used -= bytes;
        }
        true
    }
}

/// What there is of a key.
enum Found {
    Ready(Arc<dyn Any + Send + Sync>),
    /// Another thread is at it, for which this one may not wait.
    Pending,
    /// Nothing: who asks is to make it.
    Claimed,
}

/// The duty to make a value.
struct Claim<'a, K: Clone + Eq + Hash> {
    memo: &'a Memo<K>,
    key: &'a K,
}

impl<K: Clone + Eq + Hash> Drop for Claim<'_, K> {
    fn drop(&mut self) {
        let mut entries = self.memo.lock();
        if matches!(entries.slots.get(self.key), Some(Slot::Pending)) {
            entries.slots.remove(self.key);
        }
        drop(entries);
        self.memo.made.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    struct Block(usize);

    impl Footprint for Block {
        fn footprint(&self) -> usize {
            self.0
        }
    }

    #[test]
    fn a_value_is_made_once_for_all_threads() {
        let (memo, made) = (Memo::new(100), AtomicUsize::new(0));
        let make = || {
            made.fetch_add(1, Ordering::Relaxed);
            std::thread::sleep(std::time::Duration::from_millis(20));
            Ok(Block(10))
        };
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| assert_eq!(memo.get(&1, make).expect("a block").0, 10));
            }
        });
        assert_eq!((made.into_inner(), memo.used()), (1, 10));
    }

    #[test]
    fn a_thread_of_a_pool_does_not_wait() {
        let (memo, pool) = (Memo::new(100), rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread"));
        let made = memo.get(&1, || {
            // It would wait for this thread, which waits for it.
            assert_eq!(pool.install(|| memo.get(&1, || Ok(Block(10)))).expect("a block").0, 10);
            Ok(Block(20))
        });
        assert_eq!(made.expect("a block").0, 20);
        assert_eq!((pool.install(|| memo.get(&1, || Ok(Block(10)))).expect("a block").0, memo.used()), (20, 20));
    }

    #[test]
    fn the_oldest_goes_and_memory_is_bounded() {
        let memo = Memo::new(100);
        let get = |key: usize, bytes: usize| {
            let mut made = false;
            let make = || {
                made = true;
                Ok(Block(bytes))
            };
            memo.get(&key, make).expect("a block");
            assert!(memo.used() <= 100);
            made
        };
        assert!(get(1, 40) && get(2, 40) && !get(1, 40), "two fit");
        assert!(get(3, 40), "and a third");
        assert!(!get(1, 40) && get(2, 40), "in the place of the one that was not used for longest");
        assert!(get(4, 1000) && get(4, 1000), "what is larger than the capacity is not kept");
    }

    #[test]
    fn failures_and_panics_leave_the_key_free() {
        let memo = Memo::new(100);
        assert!(memo.get::<Block>(&1, || Err(Error::Usage("no".into()))).is_err());
        let panicked = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            let _ = memo.get::<Block>(&1, || panic!("on purpose"));
        }));
        assert!(panicked.is_err());
        assert_eq!(memo.get(&1, || Ok(Block(7))).expect("a block").0, 7);
    }
}
