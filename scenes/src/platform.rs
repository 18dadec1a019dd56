//! All that differs by platform in the scenes: the clocks.

use std::time::Duration;

/// CPU time (of this thread) that `work` takes, where threads have such a clock, else its time.
pub(crate) fn thread_time_of(work: impl FnOnce()) -> Duration {
    #[cfg(any(unix, windows))]
    {
        let start = cpu_time::ThreadTime::now();
        work();
        start.elapsed()
    }
    #[cfg(not(any(unix, windows)))]
    time_of(work)
}

/// Time that `work` takes; none where there is no clock.
pub(crate) fn time_of(work: impl FnOnce()) -> Duration {
    #[cfg(not(all(target_arch = "wasm32", target_os = "unknown")))]
    {
        let start = std::time::Instant::now();
        work();
        start.elapsed()
    }
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    {
        work();
        Duration::ZERO
    }
}
