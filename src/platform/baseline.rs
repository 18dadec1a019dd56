//! The registers that every processor of the target has: of SSE2 on x86-64, elsewhere plain arrays.
//!
//! Kernels are entered with them where the processor lacks the best ones, and where a test asks for them to compare the two. A
//! test that made kernels of its own for this would compile each of them twice more, whole, in one function.

#[cfg(test)]
pub(crate) use held::{holds_to_baseline, with_baseline};

#[cfg(target_arch = "x86_64")]
pub(crate) use super::halves::{F32x8 as Baseline32, F64x4 as Baseline64};
#[cfg(all(test, not(target_arch = "x86_64")))]
pub(crate) use crate::lanes::{four::Plain as Baseline64, wide::Plain as Baseline32};

/// Whether this thread enters kernels with these registers although the processor has better ones.
#[cfg(all(target_arch = "x86_64", not(test)))]
#[inline(always)]
pub(crate) const fn holds_to_baseline() -> bool {
    false
}

#[cfg(test)]
mod held {
    use std::cell::Cell;

    thread_local! {
        static HOLDS: Cell<bool> = const { Cell::new(false) };
    }

    /// Whether this thread enters kernels with the registers of the baseline although the processor has better ones.
    pub(crate) fn holds_to_baseline() -> bool {
        HOLDS.get()
    }

    /// What `run` gives where this thread enters every kernel with the registers of the baseline.
    pub(crate) fn with_baseline<R>(run: impl FnOnce() -> R) -> R {
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
}
