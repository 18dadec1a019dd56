//! A whole world as bytes, and back: every later step gives the same bits.
//!
//! ```text
//! header     magic, format, form, length, checksum
//! forms      every distinct geometry, once
//! tables     world, bodies, shapes, joints, pairs and their contacts, sleeping islands: one after the other
//! ```
//!
//! `list.rs` is the one place that says what is stored. It takes records apart field by field, so a new field that is not listed
//! does not compile; what can be made anew is listed there too, with how. The names of all stored fields make up the *form* in
//! the header: a snapshot of a library that stores something else is refused.
//!
//! A record is a row of 32-bit words. Rows of a table resemble each other (same mass, same material, same box), so each is
//! written as its difference from the row before, in as many bytes as that takes: two bits for each word, then the bytes. What is
//! stored does not depend on where it is stored: slots of the pair cache are numbered anew, and the broad phase is built anew.

pub(crate) mod carried;
pub(crate) mod contacts;
mod form_table;
pub(crate) mod forms;
mod list;
pub(crate) mod seal;
pub(crate) mod stored;
pub(crate) mod table;

#[cfg(test)]
mod tests;

pub(crate) use list::{Displaced, FreeSlots, IslandRow, LISTED, LastBox, Runs, WorldRow};

use crate::error::{Error, ErrorKind};

pub(crate) const fn refused(problem: &'static str) -> Error {
    Error::new(ErrorKind::InvalidSnapshot, "snapshot", problem)
}
