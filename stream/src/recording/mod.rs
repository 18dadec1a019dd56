//! Recordings: the messages of a stream in a file.
//!
//! ```text
//! file    = file header, chunk, chunk, …, closing chunk
//! chunk   = chunk header, messages (perhaps compressed)
//! ```
//!
//! A chunk begins with two messages that make a scene what it was ([`crate::scene::Scene`]); so it can be read alone, which is how a
//! player seeks, and how it goes on behind a place that is damaged. Headers and contents have checksums. A file that was cut short
//! is read up to its last whole chunk.

mod format;
mod playback;
mod recorder;

pub use playback::{End, Playback, RecordingInfo};
pub use recorder::Recorder;
