//! Where shapes meet.
pub(crate) mod narrow;
