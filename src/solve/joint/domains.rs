//! Domains of a large net: ranges of slots whose joints are swept beside those of the others.
//!
//! Joints between bodies of one strip read and write nothing of the next, so strips are worked on side by side, by as many threads
//! as there are. What is left (joints between strips, on what is fixed, one by one, and those that fill no block of eight) is swept
//! after them, and on the way back before them: to and fro stay symmetric. Where a net is cut follows from its bodies and joints
//! alone, never from the number of threads.

use std::ops::Range;

use super::lanes::JointLanes;
use super::{JointLink, in_order};
use crate::joint_graph::mesh::is_sheet;
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::workers::Workers;

/// Bodies of a strip: some 50 µs of each sweep, about what a thread that has gone to sleep takes to begin.
const BODIES: usize = 1024;

/// Strips at most.
const MOST: usize = 16;

/// Share of joints between strips from which on a net is left whole: they are swept by one thread.
const MAX_BETWEEN: f32 = 0.125;

/// Whether a batch of so many joints and moving bodies is a net that may be cut.
pub(crate) fn may_be_cut(joints: usize, bodies: usize) -> bool {
    bodies >= 2 * BODIES && is_sheet(joints, bodies)
}

/// The slots of one strip, and what is swept of its joints.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    /// Slots of the batch; those of its lanes count from the first.
    pub slots: Range<usize>,
    pub lanes: JointLanes,
    pub visits: Vec<Range<usize>>,
    /// Products of its biases with the last changes of its multipliers.
    pub products: [f64; 2],
    /// Worst distance between joint points beyond what the joints allow, as found last (m).
    pub gap: f32,
}

impl Strip {
    /// One sweep over its joints; `own` are the velocities of its bodies.
    pub(super) fn sweep(&mut self, own: &mut [BodyVelocity], backwards: bool) {
        let Self { lanes, visits, .. } = self;
        in_order(visits, backwards, |blocks| lanes.sweep(blocks.clone(), own, backwards));
    }

    /// One sweep of displacements, each error at most `most` (m or rad).
    pub(super) fn push(&self, own: &mut [BodyVelocity], most: f32, backwards: bool) {
        in_order(&self.visits, backwards, |blocks| self.lanes.push(blocks.clone(), own, most, backwards));
    }
}

/// All strips of a batch; none of most.
#[derive(Debug, Default)]
pub(crate) struct Strips {
    domains: Vec<Strip>,
    count: usize,
    /// Slots of each, but for the last, which may have more.
    length: usize,
}

impl Strips {
    /// Cuts a batch of so many slots, the first of which is the world's.
    pub(super) fn cut(&mut self, links: &[JointLink], slots: usize) {
        let bodies = slots - 1;
        self.count = 0;
        if !may_be_cut(links.len(), bodies) {
            return;
        }
        let count = (bodies / BODIES).min(MOST);
        self.length = bodies / count;
        self.count = count;
        let between = links.iter().filter(|link| self.strip_of(link).is_none()).count();
        if between as f32 > MAX_BETWEEN * links.len() as f32 {
            self.count = 0;
            return;
        }
        if self.domains.len() < count {
            self.domains.resize_with(count, Strip::default);
        }
        for (number, strip) in self.domains[..count].iter_mut().enumerate() {
            let end = if number + 1 == count { slots } else { 1 + (number + 1) * self.length };
            strip.slots = 1 + number * self.length..end;
            strip.lanes.clear(strip.slots.start as u32);
            strip.visits.clear();
        }
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The strip of a joint, if both of its bodies are in one.
    pub(super) fn strip_of(&self, link: &JointLink) -> Option<usize> {
        let last = self.count.checked_sub(1)?;
        let strip = |slot: u32| Some((slot.checked_sub(1)? as usize / self.length).min(last));
        let (a, b) = (strip(link.a)?, strip(link.b)?);
        (a == b).then_some(a)
    }

    pub(super) fn all(&self) -> &[Strip] {
        &self.domains[..self.count]
    }

    pub(super) fn all_mut(&mut self) -> &mut [Strip] {
        &mut self.domains[..self.count]
    }

    /// Works on all strips, side by side.
    pub(super) fn each(&mut self, threads: &Workers, work: impl Fn(&mut Strip) + Sync) {
        threads.share(self.all_mut().iter_mut(), work);
    }

    /// Works on all strips and their bodies.
    pub(super) fn each_with(
        &mut self,
        threads: &Workers,
        bodies: &mut [BodyVelocity],
        work: impl Fn(&mut Strip, &mut [BodyVelocity]) + Sync,
    ) {
        let own = own_of(bodies, self.length, self.count);
        threads.share(self.all_mut().iter_mut().zip(own), |(strip, own)| work(strip, own));
    }

    /// Works on all strips, their bodies and where those are.
    pub(super) fn each_moved(
        &mut self,
        threads: &Workers,
        bodies: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        work: impl Fn(&mut Strip, &mut [BodyVelocity], &mut [BodyMotion]) + Sync,
    ) {
        let own = own_of(bodies, self.length, self.count).zip(own_of(motions, self.length, self.count));
        threads.share(self.all_mut().iter_mut().zip(own), |(strip, (bodies, motions))| work(strip, bodies, motions));
    }
}

/// The parts that strips have of an array by slot.
fn own_of<T>(slots: &mut [T], length: usize, count: usize) -> impl Iterator<Item = &mut [T]> {
    // The world's.
    let mut rest = slots.get_mut(1..).unwrap_or_default();
    (1..=count).map(move |number| {
        let length = if number == count { rest.len() } else { length };
        rest.split_off_mut(..length).unwrap_or_default()
    })
}
