//! The joints of a batch as it solves them, written by all threads where they are many.

use glam::Vec3;

use super::{REPLICA, Records};
use crate::joint::Joint;
use crate::solve::batch::{Batch, JointEnd};
use crate::solve::joint::{JointEntry, friction, kinds};
use crate::solve::state::WORLD_SLOT;
use crate::workers::Workers;

/// Joints of a batch from which on all threads write them, and those that are worth another thread's while: some 5 µs.
const SHARED_JOINTS: usize = 512;
const LEAST_JOINTS: usize = 64;

impl Records<'_> {
    pub(super) fn list_joints(&self, batch: &mut Batch, threads: &Workers) {
        if batch.joint_slots.len() >= SHARED_JOINTS && threads.has_team() {
            return self.list_joints_on_all_threads(batch, threads);
        }
        let scale = self.scale_for(batch);
        batch.joints.entries.clear();
        for number in 0..batch.joint_slots.len() {
            let slot = batch.joint_slots[number];
            let joint = &self.joints[slot];
            let ends = [0, 1].map(|side| self.find_joint_end(batch, joint, side));
            batch.joints.entries.push(joint_entry(slot, joint, ends, scale, batch.stride));
        }
    }

    /// Lists both ends of each joint, where bounds ask for them.
    pub(super) fn list_joint_ends(&self, batch: &mut Batch) {
        for number in 0..batch.joint_slots.len() {
            let joint = &self.joints[batch.joint_slots[number]];
            let ends = [0, 1].map(|side| self.find_joint_end(batch, joint, side));
            batch.joint_ends.push(ends);
        }
    }

    fn list_joints_on_all_threads(&self, batch: &mut Batch, threads: &Workers) {
        let (scale, stride) = (self.scale_for(batch), batch.stride);
        let entry_of = |slot: u32| {
            let joint = &self.joints[slot];
            let end = |side: usize| {
                let slot = joint.bodies[side].map_or(WORLD_SLOT, |index| self.known_slot(index).unwrap_or(REPLICA));
                self.joint_end_at(joint, side, slot)
            };
            joint_entry(slot, joint, [end(0), end(1)], scale, stride)
        };
        let Batch { joints, joint_slots, direct, .. } = batch;
        // Those of the step before are as good as any to be written over: most are as many.
        direct.give_back(&mut joints.entries);
        joints.entries.resize_with(joint_slots.len(), || entry_of(joint_slots[0]));
        let piece = threads.piece(joint_slots.len(), LEAST_JOINTS);
        threads.share(joints.entries.chunks_mut(piece).zip(joint_slots.chunks(piece)), |(entries, slots)| {
            entries.iter_mut().zip(slots).for_each(|(entry, &slot)| *entry = entry_of(slot));
        });
        for number in 0..batch.joints.entries.len() {
            let entry = &batch.joints.entries[number];
            if entry.a == REPLICA || entry.b == REPLICA {
                let joint = &self.joints[entry.joint];
                let [a, b] = [0, 1].map(|side| self.find_joint_end(batch, joint, side).slot);
                (batch.joints.entries[number].a, batch.joints.entries[number].b) = (a, b);
            }
        }
    }

    pub(super) fn find_joint_end(&self, batch: &mut Batch, joint: &Joint, side: usize) -> JointEnd {
        let slot = joint.bodies[side].map_or(WORLD_SLOT, |index| self.slot(batch, index));
        self.joint_end_at(joint, side, slot)
    }

    /// One side of a joint, whose body has this slot.
    #[inline(always)]
    fn joint_end_at(&self, joint: &Joint, side: usize, slot: u32) -> JointEnd {
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        let Some(index) = joint.bodies[side] else {
            return JointEnd { slot, origin: frame.position, lever: Vec3::ZERO, frame: frame.rotation };
        };
        let body = &self.bodies[index];
        if slot == WORLD_SLOT {
            let world = body.pose().transform(frame);
            return JointEnd { slot, origin: world.position, lever: Vec3::ZERO, frame: world.rotation };
        }
        let lever = frame.position.as_vec3() - body.local_center;
        if let Some(union) = self.unions.moving(index) {
            let place = self.unions.place(index);
            return JointEnd {
                slot,
                origin: union.motion.center,
                lever: place.offset + place.rotation * lever,
                frame: (place.rotation * frame.rotation).normalize(),
            };
        }
        JointEnd { slot, origin: body.center, lever, frame: frame.rotation }
    }
}

/// A joint between these ends, whose multipliers grow by `scale`, in a batch that takes so many substeps at once.
#[inline(always)]
fn joint_entry(slot: u32, joint: &Joint, [a, b]: [JointEnd; 2], scale: f32, stride: f32) -> JointEntry {
    let def = &joint.def;
    let most_rows = kinds::most_rows(def);
    JointEntry {
        joint: slot,
        a: a.slot,
        b: b.slot,
        offset: b.origin - a.origin,
        local_lever: [a.lever, b.lever].map(|lever| lever.as_dvec3()),
        local_frame: [a.frame, b.frame].map(|frame| frame.as_dquat().normalize()),
        impulses: joint.impulses.scaled(scale),
        linear_sum: Vec3::ZERO,
        angular_sum: Vec3::ZERO,
        acted: joint.acted.map(|acted| acted * stride),
        pressed: 0,
        solver: def.solver,
        most_rows: most_rows as u8,
        is_plain: kinds::is_plain(&def.kind, most_rows) && def.linear.compliance == 0.0,
        is_hinge: kinds::is_hinge(&def.kind),
        is_distance: kinds::is_distance(&def.kind),
        gives_by_motors_alone: kinds::gives_by_motors_alone(def),
        has_motor: kinds::has_motor(&def.kind),
        has_friction: friction::rows_of(def) > 0,
        can_be_overloaded: def.break_force.min(def.break_torque) < f32::INFINITY,
    }
}
