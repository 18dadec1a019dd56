//! Writes loads and multipliers of joints back, on all threads where there are many: each joint has one entry.

use crate::id::{JointId, Pool, Slot};
use crate::joint_record::{Joint, told_load};
use crate::report::{Events, JointOverload, JointStop};
use crate::solve::batch::Batch;
use crate::solve::disjoint::{DisjointPart, DisjointSlices, Slots};
use crate::solve::joint::JointEntry;
use crate::workers::Workers;
use crate::world::drift::straining;
use crate::world::{Batches, World};

/// Joints of a batch from which on all threads write them back, and those that are worth another thread's while: some 5 µs.
pub(super) const SHARED_JOINTS: usize = 512;
const MIN_JOINTS: usize = 64;

/// What is noted of joints as they are written back, for each piece of a batch: each joint by its slot.
#[derive(Debug, Default)]
pub(in crate::world) struct JointNotes {
    /// Stops that press and have not before, as bits.
    stops: Vec<(u32, u32)>,
    /// Joints whose load has passed a limit.
    overloaded: Vec<u32>,
}

impl JointNotes {
    /// Hands everything over as events.
    fn tell(&mut self, joints: &Pool<Joint, JointId>, events: &mut Events) {
        for (slot, bits) in self.stops.drain(..) {
            let (joint, user_word) = (joints.handle_of(slot), joints[slot].def.user_word);
            events.joint_stops.extend(Joint::stops(bits).map(|(axis, upper)| JointStop { joint, user_word, axis, upper }));
        }
        for slot in self.overloaded.drain(..) {
            let (handle, joint) = (joints.handle_of(slot), &joints[slot]);
            let (force, torque) = (joint.force.length(), joint.torque.length());
            events.overloaded.push(JointOverload { joint: handle, user_word: joint.def.user_word, force, torque });
        }
    }
}

impl World {
    /// Finds what each joint has borne in the mean of the step, as far as its rows say.
    pub(in crate::world) fn read_row_loads(&mut self, dt: f32) {
        let Self { batches: Batches { list: batches, count: batch_count, .. }, joints, scratch, threads, .. } = self;
        let write = |entry: &JointEntry, joint: &mut Joint| {
            (joint.force, joint.torque) = told_load(entry.linear_sum / dt, entry.angular_sum / dt);
            if entry.traits.has_motor || joint.motors != [0.0; 6] {
                let before = joint.motors;
                joint.motors = entry.motors.sums.map(|impulse| if impulse.is_finite() { impulse / dt } else { 0.0 });
                joint.straining = straining(&before, &joint.motors, dt);
            }
        };
        if !scratch.runs.is_empty() {
            scratch.runs.each_joint(batches, joints, threads, |_, entry, joint, _| write(entry, joint));
        }
        for (number, batch) in batches[..*batch_count].iter().enumerate() {
            if !scratch.runs.has(number) {
                each_joint(batch, joints, threads, &mut scratch.noted_joints, |entry, joint, _| write(entry, joint));
            }
        }
    }

    /// Writes back the joints of runs of small batches.
    pub(super) fn store_joints_of_runs(&mut self) {
        let Self { batches: Batches { list: batches, .. }, joints, scratch, threads, .. } = self;
        scratch.runs.each_joint(batches, joints, threads, |batch, entry, joint, noted| {
            store_joint(1.0 / batch.stride, entry, joint, noted);
        });
    }

    pub(super) fn store_joints(&mut self, number: usize) {
        let Self { batches: Batches { list: batches, .. }, joints, events, scratch, threads, .. } = self;
        if scratch.runs.has(number) {
            if let Some(notes) = scratch.runs.notes_from(number) {
                notes.joints.tell(joints, events);
            }
            return;
        }
        let share = 1.0 / batches[number].stride;
        let noted = &mut scratch.noted_joints;
        each_joint(&batches[number], joints, threads, noted, |entry, joint, noted| store_joint(share, entry, joint, noted));
        noted.iter_mut().for_each(|noted| noted.tell(joints, events));
    }
}

/// Keeps what a joint has done in the step, of whose multipliers one of the world's substeps has a share.
fn store_joint(share: f32, entry: &JointEntry, joint: &mut Joint, noted: &mut JointNotes) {
    (joint.impulses, joint.acted) = (entry.impulses.scaled(share), entry.acted.map(|acted| acted * share));
    if entry.counts_turns && entry.angles.iter().all(|angle| angle.is_finite()) {
        joint.angles = entry.angles;
    }
    joint.rebounds = entry.rebounds;
    if !entry.impulses.is_finite() {
        return joint.forget_impulses();
    }
    // A stop that was met and left within the step has pressed too.
    let pressed = if entry.pressed == 0 { 0 } else { joint.stops_of(entry.pressed) };
    if pressed & !joint.pressed != 0 {
        noted.stops.push((entry.joint, pressed & !joint.pressed));
    }
    joint.pressed = pressed;
    if entry.can_be_overloaded && joint.is_overloaded() {
        noted.overloaded.push(entry.joint);
    }
}

/// Has `write` bring the record of each joint of a batch up to date with its entry.
fn each_joint(
    batch: &Batch,
    joints: &mut Pool<Joint, JointId>,
    threads: &Workers,
    noted: &mut Vec<JointNotes>,
    write: impl Fn(&JointEntry, &mut Joint, &mut JointNotes) + Sync,
) {
    let entries = &batch.joints.entries;
    let is_shared = entries.len() >= SHARED_JOINTS && threads.has_team();
    let piece = if is_shared { threads.piece(entries.len(), MIN_JOINTS) } else { entries.len().max(1) };
    noted.resize_with(entries.len().div_ceil(piece).max(noted.len()).max(1), JointNotes::default);
    let slots = DisjointSlices::new(joints.slots_mut());
    let write = |entry: &JointEntry, slots: &mut DisjointPart<'_, Slot<Joint>>, noted: &mut JointNotes| {
        if let Some(joint) = &mut slots.get_mut(entry.joint).value {
            write(entry, joint, noted);
        }
    };
    if is_shared {
        threads.share(entries.chunks(piece).zip(&mut *noted), |(entries, noted)| {
            // SAFETY: each joint has one entry, which is in one piece.
            let mut slots = unsafe { slots.part() };
            entries.iter().for_each(|entry| write(entry, &mut slots, noted));
        });
    }
    let rest = if is_shared { &[][..] } else { &entries[..] };
    let Some(last) = noted.last_mut() else { return };
    // SAFETY: no other part is in use.
    let mut slots = unsafe { slots.part() };
    rest.iter().chain(batch.direct.entries()).chain(batch.newton.entries()).for_each(|entry| write(entry, &mut slots, last));
}
