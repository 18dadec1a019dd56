//! What island building reads of every awake body, in a few bytes. All threads fill it once a step; the full records are hundreds
//! of bytes each.

use std::sync::atomic::{AtomicU8, Ordering};

use super::substep_multiplier::is_smooth;
use super::{Islands, Movers, World};
use crate::body::{Body, BodyKind};
use crate::tuning::{hold, units};

/// Bodies from which on all threads are at it, and those that are worth another thread's while: some 5 µs.
const SHARED_MOVERS: usize = 1024;
const MIN_SLOTS: usize = 512;

/// What is asked of one body.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BodySummary {
    flags: u8,
}

impl BodySummary {
    const FREE: u8 = 1;
    const DRIVES: u8 = 2;
    const HELD: u8 = 4;
    const JOINTED: u8 = 8;
    const FAST: u8 = 16;
    const SMOOTH: u8 = 32;
    const CALM: u8 = 64;
    const CALM_UNIT: u8 = 128;
    /// What is told of all bodies together.
    const TOLD: u8 = Self::DRIVES | Self::FAST;

    fn of(body: &Body) -> Self {
        let kind = body.acts_as();
        let flags = [
            (kind == BodyKind::Dynamic, Self::FREE),
            (kind == BodyKind::Kinematic, Self::DRIVES),
            (body.held, Self::HELD),
            (!body.joints.is_empty(), Self::JOINTED),
            (body.settings.fast, Self::FAST),
            (is_smooth(body), Self::SMOOTH),
            (body.times.calm_for.reaches(hold::CALM_TIME), Self::CALM),
            (body.times.calm_for.reaches(units::CALM_TIME), Self::CALM_UNIT),
        ];
        let flags = flags.into_iter().map(|(is_so, flag)| if is_so { flag } else { 0 }).sum();
        Self { flags }
    }

    /// As [`Body::is_free`].
    pub(super) fn is_free(self) -> bool {
        self.flags & Self::FREE != 0
    }

    pub(super) fn is_held(self) -> bool {
        self.flags & Self::HELD != 0
    }

    pub(super) fn is_jointed(self) -> bool {
        self.flags & Self::JOINTED != 0
    }

    /// Whether it has been calm for long enough to be held with its island.
    pub(super) fn is_calm(self) -> bool {
        self.flags & Self::CALM != 0
    }

    /// Whether it has been calm for long enough to be held with its unit.
    pub(super) fn is_calm_in_unit(self) -> bool {
        self.flags & Self::CALM_UNIT != 0
    }

    /// Whether it has moved smoothly for long enough.
    pub(super) fn is_smooth(self) -> bool {
        self.flags & Self::SMOOTH != 0
    }
}

/// What is known of the bodies that a step may move, by slot; of others, what was at some time.
#[derive(Debug, Default)]
pub(super) struct BodySummaries {
    known: Vec<BodySummary>,
    /// Flags that any of those bodies has, of those that are told.
    told: u8,
}

impl BodySummaries {
    /// Of a body that the step may move.
    pub(super) fn of(&self, body: u32) -> BodySummary {
        self.known[body as usize]
    }

    /// Takes note that a body is held, or let go of.
    pub(super) fn note_held(&mut self, body: u32, is_held: bool) {
        let known = &mut self.known[body as usize];
        known.flags = known.flags & !BodySummary::HELD | if is_held { BodySummary::HELD } else { 0 };
    }

    /// Whether any of them is kinematic.
    pub(super) fn some_drive(&self) -> bool {
        self.told & BodySummary::DRIVES != 0
    }

    /// Whether any of them is flagged fast.
    pub(super) fn some_are_fast(&self) -> bool {
        self.told & BodySummary::FAST != 0
    }
}

impl World {
    /// Takes note of every body that the step may move.
    pub(super) fn take_census(&mut self) {
        let Self {
            islands: Islands { summaries: BodySummaries { known, told }, .. },
            movers: Movers { slots: movers, .. },
            bodies,
            threads,
            ..
        } = self;
        known.resize(bodies.slot_count(), BodySummary::default());
        let flags = AtomicU8::new(0);
        let is_shared = threads.has_team() && movers.len() >= SHARED_MOVERS;
        let piece = if is_shared { threads.piece(known.len(), MIN_SLOTS) } else { known.len().max(1) };
        let mut rest = &movers[..];
        let pieces = known.chunks_mut(piece).zip((0..).step_by(piece)).map(|(known, first)| {
            let own;
            (own, rest) = rest.split_at(rest.partition_point(|&body| (body as usize) < first + piece));
            (known, own, first)
        });
        threads.share(pieces, |(known, own, first)| {
            for &body in own {
                let entry = BodySummary::of(&bodies[body]);
                known[body as usize - first] = entry;
                if entry.flags & BodySummary::TOLD != 0 {
                    flags.fetch_or(entry.flags & BodySummary::TOLD, Ordering::Relaxed);
                }
            }
        });
        *told = flags.into_inner();
    }
}
