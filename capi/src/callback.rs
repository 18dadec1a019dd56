//! Which thread is inside which world's callbacks.
//!
//! While a world's callbacks run, its lock is held for reading: reads work on every thread, edits find the lock taken. Whether
//! that is "busy" or "locked" depends on who asks, so the world notes the thread that runs them.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// A number per thread that is never reused, unlike the system's.
fn this_thread() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    thread_local! {
        static NUMBER: Cell<u64> = const { Cell::new(0) };
    }
    if NUMBER.get() == 0 {
        NUMBER.set(NEXT.fetch_add(1, Ordering::Relaxed));
    }
    NUMBER.get()
}

thread_local! {
    static DEPTH: Cell<u32> = const { Cell::new(0) };
}

/// Notes that this thread is inside callbacks of the host that no world owns, until the guard is dropped.
pub(crate) fn enter_any() -> impl Drop {
    struct Leave;
    impl Drop for Leave {
        fn drop(&mut self) {
            DEPTH.set(DEPTH.get() - 1);
        }
    }
    DEPTH.set(DEPTH.get() + 1);
    Leave
}

/// Whether this thread is inside such a callback.
pub(crate) fn inside_any() -> bool {
    DEPTH.get() > 0
}

/// The thread that runs a world's callbacks now.
#[derive(Debug, Default)]
pub(crate) struct CallbackThread(AtomicU64);

impl CallbackThread {
    /// Notes this thread until the guard is dropped.
    pub(crate) fn enter(&self) -> impl Drop + '_ {
        struct Leave<'a>(&'a AtomicU64);
        impl Drop for Leave<'_> {
            fn drop(&mut self) {
                self.0.store(0, Ordering::Relaxed);
            }
        }
        self.0.store(this_thread(), Ordering::Relaxed);
        Leave(&self.0)
    }

    pub(crate) fn is_this(&self) -> bool {
        self.0.load(Ordering::Relaxed) == this_thread()
    }
}
