//! SIMD lanes: eight of single precision, four of double.

pub(crate) mod four;
pub(crate) mod wide;
