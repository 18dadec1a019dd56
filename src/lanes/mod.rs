//! Numbers side by side, as kernels compute with them: eight of single precision, four of double.

pub(crate) mod four;
pub(crate) mod wide;
