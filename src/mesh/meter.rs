//! The memory that the process has taken, where the program counts it, and a limit of it.
//!
//! The command counts with its global allocator, [`Counting`]. In the processes of other programs nothing is counted, and
//! no limit holds. Work that passes the limit ends by unwinding at its next [`check`], up to [`within_limit`].

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicIsize, Ordering};

/// The bytes in use, without those that threads have not added yet.
static USED: AtomicIsize = AtomicIsize::new(0);
/// The bytes that may be in use.
static LIMIT: AtomicIsize = AtomicIsize::new(isize::MAX);

/// The panic of work that has passed the limit.
pub struct PassedLimit;

/// Unwinds, with [`PassedLimit`], if more memory is in use than the limit allows. Steps call it before they begin, and loops
/// that grow as they run.
#[inline]
pub fn check() {
    check_for(0);
}

/// As [`check`], before work that takes so many bytes at once.
#[inline]
pub fn check_for(bytes: usize) {
    let more = isize::try_from(bytes).unwrap_or(isize::MAX);
    if USED.load(Ordering::Relaxed).saturating_add(more) > LIMIT.load(Ordering::Relaxed) {
        resume_unwind(Box::new(PassedLimit));
    }
}

/// The result of work that stays within the limit.
///
/// # Errors
/// Work that has passed the limit. Its memory is free again.
pub fn within_limit<T>(work: impl FnOnce() -> T) -> Result<T, PassedLimit> {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| match panic.downcast::<PassedLimit>() {
        Ok(passed) => *passed,
        Err(other) => resume_unwind(other),
    })
}

/// Sets the bytes that may be in use.
pub fn set_limit(bytes: usize) {
    LIMIT.store(isize::try_from(bytes).unwrap_or(isize::MAX), Ordering::Relaxed);
}

/// The system's allocator, which counts the bytes in use.
pub struct Counting;

thread_local! {
    /// Bytes that this thread has taken or given back and not added to [`USED`] yet.
    static PENDING: Cell<isize> = const { Cell::new(0) };
    /// Bytes that this thread has taken and not given back.
    static OWN: Cell<isize> = const { Cell::new(0) };
}

/// The bytes that this thread has taken and not given back, for bounds of work in one thread beside others.
pub fn of_thread() -> isize {
    OWN.get()
}

fn count(bytes: isize) {
    /// Bytes from which on a thread adds them. A shared counter is slow.
    const MOST_PENDING: isize = 1 << 16;
    OWN.set(OWN.get() + bytes);
    let sum = PENDING.get() + bytes;
    let is_due = sum.abs() >= MOST_PENDING;
    PENDING.set(if is_due { 0 } else { sum });
    if is_due {
        USED.fetch_add(sum, Ordering::Relaxed);
    }
}

// SAFETY: every call goes to the system's allocator unchanged. Counting neither allocates nor unwinds: `PENDING` and `OWN` have
// a constant start and no destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as isize - layout.size() as isize);
        // SAFETY: the caller's.
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller's.
        unsafe { System.dealloc(block, layout) }
    }
}
