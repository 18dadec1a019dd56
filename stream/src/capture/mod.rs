//! A world as records.
//!
//! The hot channel is simple: all that moved ([`frame`]). For the cold one, what is said of bodies, shapes and joints comes from two
//! sides ([`Cold`]):
//!
//! - *What changed.* After each step the lists of what there is are compared with those of before, if the world says that anything
//!   has come or gone; events of the step follow.
//! - *All there is, over and over.* A cursor goes through the world, some records further with each published step. One round of it
//!   is a cycle. A record states how its object is now, and replaces what was known of it; so a reader that begins anywhere knows
//!   the whole world when it has seen one cycle from begin to end, and what a cycle did not mention is gone. A step costs the same
//!   whether somebody joins or not, nothing has to be asked for, and what a reader missed heals.

mod census;
mod cold;
mod frame;
mod meshes;
mod records;

pub(crate) use cold::{BLOCK, Cold};
pub(crate) use frame::Hot;
