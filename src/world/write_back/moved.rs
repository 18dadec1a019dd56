//! Event lists of a step: bodies that moved, contacts that began or ended.

use std::sync::atomic::{AtomicBool, Ordering};

use super::report_contact;
use crate::body::{Anchored, Body};
use crate::id::{BodyId, Pool};
use crate::report::Moved;
use crate::tight_vec::{make_room, make_room_behind};
use crate::workers::MAX_PIECES;
use crate::world::{Collision, Islands, Movers, StepScratch, World};

/// Bodies from which on all threads list those that moved, and those that are worth another thread's while: some 5 µs.
const SHARED_MOVERS: usize = 512;
const MIN_MOVERS: usize = 128;

impl World {
    /// Lists every body that moved; none where nothing stirs and nothing has fallen asleep.
    pub(in crate::world) fn list_moved(&mut self, stirs: bool) {
        if !stirs && self.movers.are_sorted {
            return self.events.moved.clear();
        }
        let Self { movers: Movers { slots: movers, .. }, bodies, events, threads, .. } = self;
        let has_woken = AtomicBool::new(false);
        let moved = |&index: &u32| {
            let body = Some(&bodies[index]).filter(|body| is_listed(body))?;
            if body.woke {
                has_woken.store(true, Ordering::Relaxed);
            }
            Some(Moved {
                body: bodies.handle_of(index),
                user_word: body.settings.user_word,
                pose: body.pose(),
                linear_velocity: body.linear_velocity,
                angular_velocity: body.angular_velocity,
                fell_asleep: !body.is_awake(),
                woke: body.woke,
            })
        };
        let list = &mut events.moved;
        let first = movers.iter().find_map(moved).filter(|_| movers.len() >= SHARED_MOVERS && threads.has_team());
        if let Some(first) = first {
            // Those of the step before are as good as any to be written over: most are as many.
            make_room_behind(list, movers.len().saturating_sub(list.len()));
            list.resize(movers.len(), first);
            let piece = threads.piece(movers.len(), MIN_MOVERS);
            let mut counts = [0; MAX_PIECES];
            threads.share(list.chunks_mut(piece).zip(movers.chunks(piece)).zip(&mut counts), |((list, movers), count)| {
                *count = list.iter_mut().zip(movers.iter().filter_map(moved)).map(|(place, moved)| *place = moved).count();
            });
            let mut end = 0;
            for (count, start) in counts.into_iter().zip((0..movers.len()).step_by(piece)) {
                list.copy_within(start..start + count, end);
                end += count;
            }
            list.truncate(end);
        } else {
            list.clear();
            make_room(list, movers.len());
            list.extend(movers.iter().filter_map(moved));
        }
        if has_woken.into_inner() {
            movers.iter().for_each(|&index| bodies[index].woke &= !is_listed(&bodies[index]));
        }
        self.movers.are_sorted &= !self.movers.some_are_driven;
        self.list_stopped();
        self.report.counts.moved = self.events.moved.len() as u32;
    }

    /// Adds the bodies that moved until fixed joints came to hold them: nothing tells of them from now on.
    fn list_stopped(&mut self) {
        let mut stopped = std::mem::take(&mut self.movers.stopped);
        stopped.sort_unstable();
        stopped.dedup();
        for index in stopped.drain(..) {
            let Some(body) = self.bodies.get(index).filter(|body| body.anchored == Anchored::Still) else { continue };
            let moved = Moved {
                body: self.bodies.handle_of(index),
                user_word: body.settings.user_word,
                pose: body.pose(),
                linear_velocity: body.linear_velocity,
                angular_velocity: body.angular_velocity,
                fell_asleep: self.stands_welded(index),
                woke: false,
            };
            let list = &mut self.events.moved;
            let place = list.partition_point(|other| Pool::<Body, BodyId>::place_of(other.body) < index);
            list.insert(place, moved);
        }
        self.movers.stopped = stopped;
    }

    /// Lists what began or ended to touch, where nobody asks for more: of what was solved that is noted as it is written back.
    pub(super) fn report_touches(&mut self) {
        let Self {
            collision: Collision { touches, pairs, .. },
            colliders,
            bodies,
            events,
            islands: Islands { hold, .. },
            scratch: StepScratch { changed, .. },
            ..
        } = self;
        changed.extend(touches.parted().map(|touch| touch.slot));
        changed.sort_unstable_by_key(|&slot| pairs.get(slot).key);
        for slot in changed.drain(..) {
            let pair = pairs.get_mut(slot);
            if pair.is_active() && (hold.let_go || !pair.still) {
                report_contact(pair, colliders, bodies, events);
            }
        }
    }
}

/// Whether a body that a step may move is listed after it.
fn is_listed(body: &Body) -> bool {
    !(body.quarantined || body.held && body.is_awake())
}
