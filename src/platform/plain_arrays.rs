//! Kernels entered with plain arrays although the processor has registers: for tests that compare the two.
//!
//! A test that made kernels of its own for this would compile each of them twice more, whole, in one function.

use std::cell::Cell;

thread_local! {
    static HOLDS: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread enters kernels with plain arrays.
pub(crate) fn holds_plain_arrays() -> bool {
    HOLDS.get()
}

/// What `run` gives where this thread enters every kernel with plain arrays.
pub(crate) fn with_plain_arrays<R>(run: impl FnOnce() -> R) -> R {
    /// Lets go also where `run` fails, which a test of random cases goes on after.
    struct Hold;
    impl Drop for Hold {
        fn drop(&mut self) {
            HOLDS.set(false);
        }
    }
    HOLDS.set(true);
    let _hold = Hold;
    run()
}
