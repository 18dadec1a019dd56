//! Plain arrays, for processors without a register type of their own here.

pub(crate) use crate::lanes::four::Plain as F64x4;
pub(crate) use crate::lanes::wide::Plain as F32x8;

/// Memory cannot be asked for.
#[inline(always)]
pub(crate) fn prefetch<T: ?Sized>(_: &T) {}
