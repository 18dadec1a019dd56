//! The bytes of a longspan stream.
//!
//! ```text
//! message  = header (LsStreamHeader), section, section, …
//! section  = section header (LsStreamSection), records, padding to 8 bytes
//! record   = one of the structs here, `stride` bytes apart
//! ```
//!
//! A message is the same in shared memory and in a recording. Numbers are little-endian, in the layout of C. A reader takes as many
//! bytes of a record as it knows, up to the stride, and skips sections of a kind that it does not know: records may grow at their
//! end, and kinds may be added, without a new schema number. docs/reference/stream-bytes.md has the bytes in a table.
//!
//! Names and comments are those of the C header, which is generated from them.

mod event;
mod frame;
mod header;
mod layout;
mod scene;

pub use event::*;
pub use frame::*;
pub use header::*;
pub use layout::{Field, LAYOUT_HASH, RECORDS, Record};
pub use scene::*;

/// A record of a stream: plain numbers, without padding, each pattern of bits a value.
pub trait Wire: bytemuck::Pod {
    /// `LS_STREAM_SECTION_` constant of the sections that hold it.
    const SECTION: u32;
    /// Whether the numbers in it can be drawn and computed with.
    fn is_finite(&self) -> bool;
}
