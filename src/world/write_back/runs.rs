//! Small batches that one thread writes back, one after another: each by itself is too little for another thread, all of them are not.

use std::ops::Range;

use super::bodies::{BodyNotes, MIN_SLOTS, SHARED_SLOTS};
use super::contacts::{Pull, SHARED_MANIFOLDS};
use super::joints::{JointNotes, SHARED_JOINTS};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::batch::Batch;
use crate::solve::disjoint::{DisjointSlices, Slots};
use crate::solve::joint::JointEntry;
use crate::workers::Workers;

/// Batches in runs that are worth a thread's while; none where one thread does everything.
#[derive(Debug, Default)]
pub(in crate::world) struct Runs {
    batches: Vec<Range<usize>>,
    notes: Vec<RunNotes>,
}

/// What is noted while a run is written back, of its batches in their order.
#[derive(Debug, Default)]
pub(super) struct RunNotes {
    pub bodies: BodyNotes,
    pub pulls: Vec<Pull>,
    pub joints: JointNotes,
}

impl Runs {
    /// Finds the runs of these batches.
    pub(in crate::world) fn find(&mut self, batches: &[Batch], threads: &Workers) {
        self.batches.clear();
        let small = |batch: &Batch| is_small(batch).then_some(batch.bodies.len());
        let all: usize = if threads.has_team() { batches.iter().filter_map(small).sum() } else { 0 };
        if all < SHARED_SLOTS {
            return;
        }
        let (piece, mut length) = (threads.piece(all, MIN_SLOTS), 0);
        for (number, batch) in batches.iter().enumerate() {
            let Some(slots) = small(batch) else { continue };
            match self.batches.last_mut().filter(|run| run.end == number && length < piece) {
                Some(run) => (run.end, length) = (number + 1, length + slots),
                None => {
                    self.batches.push(number..number + 1);
                    length = slots;
                }
            }
        }
        self.notes.resize_with(self.batches.len().max(self.notes.len()), RunNotes::default);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.batches.is_empty()
    }

    /// Whether a batch is in a run.
    pub(super) fn has(&self, batch: usize) -> bool {
        self.run_of(batch).is_some()
    }

    /// What is noted of the run that begins with a batch.
    pub(super) fn notes_from(&mut self, batch: usize) -> Option<&mut RunNotes> {
        let run = self.run_of(batch).filter(|&run| self.batches[run].start == batch)?;
        self.notes.get_mut(run)
    }

    fn run_of(&self, batch: usize) -> Option<usize> {
        let run = self.batches.partition_point(|run| run.end <= batch);
        self.batches.get(run).filter(|batches| batches.contains(&batch)).map(|_| run)
    }

    /// Works on all runs, side by side.
    pub(super) fn each(&mut self, threads: &Workers, work: impl Fn(Range<usize>, &mut RunNotes) + Sync) {
        threads.share(self.batches.iter().cloned().zip(&mut self.notes), |(batches, notes)| work(batches, notes));
    }

    /// Has `write` bring the record of each joint of all runs up to date with its entry.
    pub(super) fn each_joint(
        &mut self,
        batches: &[Batch],
        joints: &mut Pool<Joint, JointId>,
        threads: &Workers,
        write: impl Fn(&Batch, &JointEntry, &mut Joint, &mut JointNotes) + Sync,
    ) {
        let slots = DisjointSlices::new(joints.slots_mut());
        self.each(threads, |run, notes| {
            // SAFETY: each joint has one entry, which is in one batch.
            let mut slots = unsafe { slots.part() };
            for batch in &batches[run] {
                let entries = batch.joints.entries.iter().chain(batch.direct.entries()).chain(batch.newton.entries());
                for entry in entries {
                    if let Some(joint) = &mut slots.get_mut(entry.joint).value {
                        write(batch, entry, joint, &mut notes.joints);
                    }
                }
            }
        });
    }
}

/// Whether a batch is not written back by several threads.
fn is_small(batch: &Batch) -> bool {
    batch.bodies.len() < SHARED_SLOTS
        && batch.manifolds.list.len() < SHARED_MANIFOLDS
        && batch.joints.entries.len() < SHARED_JOINTS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_batches_are_in_one_run_each_and_large_ones_in_none() {
        let batch = |number| {
            let mut batch = Batch::default();
            batch.bodies.resize(if number == 17 { SHARED_SLOTS } else { 60 }, 0);
            batch
        };
        let batches: Vec<Batch> = (0..40).map(batch).collect();
        let threads = Workers::new(2).unwrap();
        let mut runs = Runs::default();
        runs.find(&batches, &threads);
        let all: Vec<usize> = runs.batches.iter().cloned().flatten().collect();
        let small: Vec<usize> = (0..40).filter(|&number| number != 17).collect();
        assert_eq!(all, small);
        assert!(!runs.has(17) && runs.has(18) && runs.notes_from(18).is_some() && runs.notes_from(17).is_none());
        assert!(runs.batches.len() > 3, "{:?}", runs.batches);
        runs.find(&batches, &Workers::default());
        assert!(runs.is_empty() && !runs.has(3));
    }
}
