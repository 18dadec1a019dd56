//! Memory asked for before it is used: of a large world each record that a walk comes to is far away, and a processor waits for one
//! at a time where there is much to do about each.

pub(crate) use crate::platform::prefetch;

/// How many records ahead of its use memory is asked for; what says where that memory is, twice as many.
pub(crate) const AHEAD: usize = 6;
