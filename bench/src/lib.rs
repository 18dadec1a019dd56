//! Measures longspan and its peers on the same scenes.

pub mod peers;
