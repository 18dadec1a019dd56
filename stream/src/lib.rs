//! What a longspan world does, to other processes: live through shared memory, or recorded in a file.
//!
//! ```text
//! World ──Publisher──▶ shared memory ──▶ Reader ──▶ Scene        (any number of processes, which come and go)
//!                                          │
//!                                          └──▶ Recorder ──▶ file ──▶ Playback ──▶ Scene
//! ```
//!
//! There are two channels. On the *hot* one each published step is one message with all that moved; a reader that is late gets the
//! latest. On the *cold* one go what a world consists of and what happened to it, in order and without gaps. Whoever joins late
//! needs no answer from the publisher: beside what changes, the publisher tells the whole scene over and over, a little with each
//! step (`capture`), and a [`Scene`] is complete as soon as it has been told once.
//!
//! The publisher never waits, never allocates in a step and never reads what readers could have written. A reader takes every
//! message out of shared memory before it looks at it, and believes nothing (`message`). The bytes are those of
//! `longspan-stream-schema`; iceoryx2 carries them (`channel`).

#![deny(unsafe_code)]

mod arrivals;
mod capture;
mod channel;
mod domain;
mod foreign;
mod live;
mod message;
mod platform;
mod problem;
mod publisher;
mod reader;
mod recording;
mod scene;

pub use domain::{Domain, MAX_NAME, Source};
pub use longspan_stream_schema as schema;
pub use message::{Message, Section};
pub use problem::{Problem, Result};
pub use publisher::{Publisher, PublisherDef, PublisherStats};
pub use reader::{Poll, Reader};
pub use recording::{End, Playback, Recorder, RecordingInfo};
pub use scene::{Mesh, Scene};
