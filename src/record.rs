//! Records every call that changes a world, and replays it.
//!
//! ```text
//! header     magic, format, form, flags
//! seed       snapshot of the world when recording began
//! calls      number of the method, 0 or the error's kind plus one; of a call that succeeded its arguments, what it returned
//!            and, after a step (or after each call, if asked for), the hash of the world's state
//! ```
//!
//! A [`RecordedWorld`] can be changed through the methods of `calls.rs` only, and that table writes both the recorder and the
//! player: what can change a recorded world is recorded. Calls that were refused change nothing, so that they are listed but not
//! played. What does not reach the state is not recorded: threads, profilers, reads.

mod argument;
mod calls;
mod cells;
mod replay;
#[cfg(test)]
mod tests;

use std::ops::Deref;

pub use replay::{Divergence, Replay, Replayed};

use crate::error::{Error, ErrorKind, Result};
use crate::report::StepReport;
use crate::settings::WorldDef;
use crate::snapshot::{LISTED, seal};
use crate::workers::ParallelFor;
use crate::world::World;
use argument::{Answer, Log};

const MAGIC: [u8; 8] = *b"lsrecord";

/// Number of the way in which calls are written.
const FORMAT: u32 = 1;

/// magic (8), format (4), flags (4), form (8), length of the seed (8)
const HEADER: usize = 32;

/// Flag: the state's hash follows every call, not steps only.
const HASH_EVERY_CALL: u32 = 1;

/// Numbers of methods that are written otherwise than those of the table.
const STEP: u64 = 0;
const RESTORE: u64 = 1;
const SET_SUPPORT: u64 = 44;

/// Takes the bytes of a recording, in order.
pub trait RecordingSink: Send + Sync {
    /// Keeps some bytes; `false` if that failed, which ends the recording.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

impl<W: std::io::Write + Send + Sync> RecordingSink for W {
    fn write(&mut self, bytes: &[u8]) -> bool {
        self.write_all(bytes).is_ok()
    }
}

/// A world whose every change can be recorded; reads go to the [`World`] itself.
pub struct RecordedWorld {
    world: World,
    recorder: Option<Recorder>,
    failed: bool,
}

struct Recorder {
    sink: Box<dyn RecordingSink>,
    log: Log,
    hash_every_call: bool,
}

impl Deref for RecordedWorld {
    type Target = World;
    fn deref(&self) -> &World {
        &self.world
    }
}

impl RecordedWorld {
    /// A world that is not recorded yet.
    pub fn new(world: World) -> Self {
        Self { world, recorder: None, failed: false }
    }

    /// The world, no longer recorded.
    pub fn into_world(self) -> World {
        self.world
    }

    /// Begins a recording with the world as it is now; one under way ends. With `hash_every_call` the state's hash follows each
    /// call that changed something, which finds the call that first differs, at a price by the size of the world.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] if the sink takes nothing.
    pub fn record(&mut self, mut sink: Box<dyn RecordingSink>, hash_every_call: bool) -> Result<()> {
        let mut seed = Vec::new();
        self.world.save(&mut seed);
        let flags = if hash_every_call { HASH_EVERY_CALL } else { 0 };
        if !sink.write(&header(flags, seed.len())) || !sink.write(&seed) {
            return Err(Error::new(ErrorKind::Unsupported, "sink", "did not take the recording"));
        }
        self.recorder = Some(Recorder { sink, log: Log::default(), hash_every_call });
        self.failed = false;
        Ok(())
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// [`ErrorKind::NotApplicable`] if there is none; [`ErrorKind::Unsupported`] if the sink has refused a part of it.
    pub fn stop_recording(&mut self) -> Result<()> {
        if std::mem::take(&mut self.failed) {
            return Err(Error::new(ErrorKind::Unsupported, "sink", "did not take all of the recording"));
        }
        let none = Error::new(ErrorKind::NotApplicable, "world", "is not being recorded");
        self.recorder.take().map(drop).ok_or(none)
    }

    /// Whether calls are being written down.
    pub fn is_recording(&self) -> bool {
        self.recorder.is_some()
    }

    /// As [`World::step`].
    ///
    /// # Errors
    /// As [`World::step`].
    pub fn step(&mut self, dt: f32) -> Result<&StepReport> {
        let outcome = self.world.step(dt).map(drop);
        self.note(STEP, &outcome, |log| log.u32(dt.to_bits()), true);
        outcome.map(|()| self.world.report())
    }

    /// As [`World::restore`].
    ///
    /// # Errors
    /// As [`World::restore`].
    pub fn restore(&mut self, snapshot: &[u8]) -> Result<()> {
        let outcome = self.world.restore(snapshot);
        self.note(RESTORE, &outcome, |log| log.bytes(snapshot), true);
        outcome
    }

    /// As [`World::set_support`].
    pub fn set_support(&mut self, on: bool) {
        self.world.set_support(on);
        self.note(SET_SUPPORT, &Ok(()), |log| log.u32(on.into()), false);
    }

    /// As [`World::set_parallel_for`]; not recorded.
    pub fn set_parallel_for(&mut self, jobs: Option<std::sync::Arc<dyn ParallelFor>>) {
        self.world.set_parallel_for(jobs);
    }

    /// As [`World::set_profiler`]; not recorded.
    pub fn set_profiler(&mut self, profiler: Option<std::sync::Arc<dyn crate::Profiler>>) {
        self.world.set_profiler(profiler);
    }

    /// Writes a call down, if there is a recording.
    fn note<R: Answer>(&mut self, method: u64, outcome: &Result<R>, arguments: impl FnOnce(&mut Log), hashed: bool) {
        let Some(Recorder { sink, log, hash_every_call }) = &mut self.recorder else { return };
        log.clear();
        log.number(method);
        match outcome {
            Err(error) => log.number(1 + error.kind as u64),
            Ok(answer) => {
                log.number(0);
                arguments(log);
                log.number(answer.word());
                if hashed || *hash_every_call {
                    log.u64(self.world.state_hash());
                }
            }
        }
        if !sink.write(log.content()) {
            (self.recorder, self.failed) = (None, true);
        }
    }
}

impl From<World> for RecordedWorld {
    fn from(world: World) -> Self {
        Self::new(world)
    }
}

fn header(flags: u32, seed: usize) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..8].copy_from_slice(&MAGIC);
    header[8..12].copy_from_slice(&FORMAT.to_le_bytes());
    header[12..16].copy_from_slice(&flags.to_le_bytes());
    header[16..24].copy_from_slice(&form().to_le_bytes());
    header[24..].copy_from_slice(&(seed as u64).to_le_bytes());
    header
}

/// What a recording must agree on: what a snapshot holds, and the methods by number.
fn form() -> u64 {
    seal::form(&[LISTED, calls::METHODS].concat())
}

/// An empty world for a recording to be played in.
fn stage() -> Result<World> {
    World::new(&WorldDef::default())
}
