//! A recording played again, and the first call that came out otherwise.

use super::argument::Pages;
use super::{FORMAT, HASH_EVERY_CALL, HEADER, MAGIC, RESTORE, SET_SUPPORT, STEP, calls, form, stage};
use crate::error::{Error, ErrorKind, Result};
use crate::world::World;

/// Where a replay first differed from what was recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Divergence {
    /// Number of the call, from 0.
    pub call: u64,
    /// Steps taken when it was made, itself included.
    pub step: u64,
    /// The method.
    pub method: &'static str,
    /// What was recorded: the state's hash, or what the call returned.
    pub recorded: u64,
    /// What came out now.
    pub found: u64,
    /// Whether these are hashes of the state; if not, the call succeeded then and failed now, or returned something else.
    pub in_state: bool,
}

/// What a replay has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Replayed {
    /// Calls read, those included that had been refused.
    pub calls: u64,
    /// Calls that had been refused: they are not made again.
    pub refused: u64,
    /// Steps taken.
    pub steps: u64,
    /// Where it first differed; nothing was played after that.
    pub divergence: Option<Divergence>,
    /// Whether the recording ends in the middle of a call, as after a crash.
    pub cut_short: bool,
}

/// A recording on its way through a world of its own.
pub struct Replay<'a> {
    world: World,
    pages: Pages<'a>,
    hash_every_call: bool,
    done: Replayed,
}

/// What a call came to.
enum Played {
    Same,
    Differs(Divergence),
    /// Its bytes end before it does.
    CutShort,
}

impl<'a> Replay<'a> {
    /// Puts a world where the recording began.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidSnapshot`] if the bytes are not a recording of this version of the library, or its beginning is
    /// corrupted; [`ErrorKind::CapacityExceeded`] when 1023 worlds are alive.
    pub fn new(recording: &'a [u8]) -> Result<Self> {
        let (header, rest) = recording.split_first_chunk::<HEADER>().ok_or(refused("is not a recording"))?;
        let word = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| header[at + i]));
        if header[..8] != MAGIC {
            return Err(refused("is not a recording"));
        }
        if word(8) as u32 != FORMAT || word(16) != form() {
            return Err(refused("was made by another version of the library"));
        }
        let seed = usize::try_from(word(24)).ok().and_then(|length| rest.get(..length)).ok_or(refused("is cut short"))?;
        let mut world = stage()?;
        world.restore(seed).map_err(|error| Error { argument: "recording", ..error })?;
        let hash_every_call = (word(8) >> 32) as u32 & HASH_EVERY_CALL != 0;
        Ok(Self { world, pages: Pages(&rest[seed.len()..]), hash_every_call, done: Replayed::default() })
    }

    /// Plays until so many steps have been taken, or to the end or the first difference.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidSnapshot`] if a call makes no sense; what came before it has been played.
    pub fn run(&mut self, most_steps: u64) -> Result<Replayed> {
        while self.done.steps < most_steps && self.done.divergence.is_none() && !self.pages.0.is_empty() && !self.done.cut_short {
            match self.play()? {
                Played::Same => {}
                Played::Differs(divergence) => self.done.divergence = Some(divergence),
                Played::CutShort => self.done.cut_short = true,
            }
        }
        Ok(self.done)
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world as it is now, to go on with.
    pub fn into_world(self) -> World {
        self.world
    }

    fn play(&mut self) -> Result<Played> {
        let (Some(number), Some(refusal)) = (self.pages.number(), self.pages.number()) else { return Ok(Played::CutShort) };
        let method = calls::name_of(number).ok_or(refused("names a method that does not exist"))?;
        let call = self.done.calls;
        self.done.calls += 1;
        if refusal > 0 {
            self.done.refused += 1;
            return Ok(Played::Same);
        }
        let Some(outcome) = self.call_again(number) else { return Ok(Played::CutShort) };
        let Some(recorded) = self.pages.number() else { return Ok(Played::CutShort) };
        let differs = |step, recorded, found, in_state| Divergence { call, step, method, recorded, found, in_state };
        let found = outcome.unwrap_or(u64::MAX);
        if found != recorded {
            return Ok(Played::Differs(differs(self.done.steps, recorded, found, false)));
        }
        if number == STEP || number == RESTORE || self.hash_every_call {
            let Some(recorded) = self.pages.u64() else { return Ok(Played::CutShort) };
            let found = self.world.state_hash();
            if found != recorded {
                return Ok(Played::Differs(differs(self.done.steps, recorded, found, true)));
            }
        }
        Ok(Played::Same)
    }

    fn call_again(&mut self, number: u64) -> Option<Result<u64>> {
        match number {
            STEP => {
                let dt = f32::from_bits(self.pages.u32()?);
                self.done.steps += 1;
                Some(self.world.step(dt).map(|_| 0))
            }
            RESTORE => Some(self.world.restore(self.pages.bytes()?).map(|()| 0)),
            SET_SUPPORT => {
                let on = self.pages.u32()? != 0;
                self.world.set_support(on);
                Some(Ok(0))
            }
            _ => calls::play(&mut self.world, number, &mut self.pages),
        }
    }
}

const fn refused(problem: &'static str) -> Error {
    Error::new(ErrorKind::InvalidSnapshot, "recording", problem)
}
