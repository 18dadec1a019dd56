//! Prefetching. In a large world every record that a loop reaches is a cache miss; asking for it some elements ahead hides the
//! wait.

pub(crate) use crate::platform::prefetch;

/// How many records ahead of its use memory is asked for; what says where that memory is, twice as many.
pub(crate) const AHEAD: usize = 6;
