//! The machine's clock, for time that is reported and for how long a thread looks for work. No state depends on it.

use std::time::{Duration, Instant};

/// A moment.
#[derive(Clone, Copy)]
pub(crate) struct Moment(Instant);

impl Moment {
    pub(crate) fn now() -> Self {
        Self(Instant::now())
    }

    /// Time since an earlier moment.
    pub(crate) fn since(self, earlier: Self) -> Duration {
        self.0 - earlier.0
    }
}
