//! The joint entries of a batch, written by all threads where they are many.

use glam::Vec3;

use super::{BatchInput, REPLICA};
use crate::joint_record::Joint;
use crate::solve::batch::Batch;
use crate::solve::joint::kinds::MotorRows;
use crate::solve::joint::{BatchJoints, JointEnd, JointEntry, JointLink, JointMotors, angles, kinds};
use crate::solve::state::WORLD_SLOT;
use crate::workers::Workers;
use crate::world::islands::NO_BODY;

/// Joints of a batch from which on all threads write them, and those that are worth another thread's while: some 5 µs.
const SHARED_JOINTS: usize = 512;
const MIN_JOINTS: usize = 64;

impl BatchInput<'_> {
    /// Lists what the joints of a batch connect.
    pub(super) fn list_joints(&self, batch: &mut Batch, threads: &Workers) {
        let link_at = |slot: u32, [a, b]: [u32; 2]| JointLink {
            joint: slot,
            a,
            b,
            traits: self.groups.joint_heads[slot as usize].traits,
            is_withheld: false,
        };
        let bodies_of = |slot: u32| self.groups.joint_heads[slot as usize].bodies;
        batch.joints.links.clear();
        if batch.joints.slots.len() < SHARED_JOINTS || !threads.has_team() {
            for number in 0..batch.joints.slots.len() {
                let slot = batch.joints.slots[number];
                let ends = bodies_of(slot).map(|body| if body == NO_BODY { WORLD_SLOT } else { self.slot(batch, body) });
                batch.joints.links.push(link_at(slot, ends));
            }
            return;
        }
        let BatchJoints { links, slots, .. } = &mut batch.joints;
        links.resize(slots.len(), link_at(slots[0], [REPLICA; 2]));
        let piece = threads.piece(slots.len(), MIN_JOINTS);
        threads.share(links.chunks_mut(piece).zip(slots.chunks(piece)), |(links, slots)| {
            for (link, &slot) in links.iter_mut().zip(slots) {
                let known = |body: u32| if body == NO_BODY { WORLD_SLOT } else { self.known_slot(body).unwrap_or(REPLICA) };
                *link = link_at(slot, bodies_of(slot).map(known));
            }
        });
        for number in 0..batch.joints.links.len() {
            let JointLink { joint, a, b, .. } = batch.joints.links[number];
            if a == REPLICA || b == REPLICA {
                let [a, b] = bodies_of(joint).map(|body| if body == NO_BODY { WORLD_SLOT } else { self.slot(batch, body) });
                (batch.joints.links[number].a, batch.joints.links[number].b) = (a, b);
            }
        }
    }

    /// Writes the joints that no direct solve takes as they are swept.
    pub(super) fn write_entries(&self, batch: &mut Batch, threads: &Workers) {
        let scale = self.scale_for(batch);
        let Batch { joints: BatchJoints { links, entries, .. }, direct, stride, .. } = batch;
        let left = direct.left(links);
        let entry_of = |link: &JointLink| self.joint_entry(link, scale, *stride);
        if left.len() < SHARED_JOINTS || !threads.has_team() {
            entries.clear();
            return entries.extend(left.iter().map(entry_of));
        }
        // Those of the step before are as good as any to be written over: most are as many.
        entries.resize_with(left.len(), || entry_of(&left[0]));
        let piece = threads.piece(left.len(), MIN_JOINTS);
        threads.share(entries.chunks_mut(piece).zip(left.chunks(piece)), |(entries, links)| {
            entries.iter_mut().zip(links).for_each(|(entry, link)| *entry = entry_of(link));
        });
    }

    /// Lists both ends of each joint, where bounds ask for them.
    pub(super) fn list_joint_ends(&self, batch: &mut Batch) {
        for number in 0..batch.joints.slots.len() {
            let joint = &self.joints[batch.joints.slots[number]];
            let ends = [0, 1].map(|side| self.find_joint_end(batch, joint, side));
            batch.joints.ends.push(ends);
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

    /// A joint as it is solved, whose multipliers grow by `scale`, in a batch that takes so many substeps at once.
    #[inline(always)]
    pub(super) fn joint_entry(&self, link: &JointLink, scale: f32, stride: f32) -> JointEntry {
        let joint = &self.joints[link.joint];
        let [a, b] = [(0, link.a), (1, link.b)].map(|(side, slot)| self.joint_end_at(joint, side, slot));
        let (def, traits) = (&joint.def, &link.traits);
        JointEntry {
            joint: link.joint,
            a: a.slot,
            b: b.slot,
            offset: b.origin - a.origin,
            local_lever: [a.lever, b.lever].map(|lever| lever.as_dvec3()),
            local_frame: [a.frame, b.frame].map(|frame| frame.as_dquat().normalize()),
            impulses: joint.impulses.scaled(scale),
            angles: joint.angles,
            linear_sum: Vec3::ZERO,
            angular_sum: Vec3::ZERO,
            acted: joint.acted.map(|acted| acted * stride),
            // What gives comes back by itself.
            restitution: if traits.has_soft_stops { 0.0 } else { def.restitution },
            rebounds: joint.rebounds,
            pressed: 0,
            motors: if traits.has_motor {
                let is_chained = |&body: &u32| self.bodies[body].joints.len() > 1;
                let are_chained = joint.bodies.iter().flatten().any(is_chained);
                JointMotors { rows: MotorRows::of(&def.kind), are_chained, ..JointMotors::NONE }
            } else {
                JointMotors::NONE
            },
            traits: *traits,
            is_hinge: kinds::is_hinge(&def.kind),
            is_distance: kinds::is_distance(def),
            counts_turns: angles::counts_turns(&def.kind),
            can_be_overloaded: def.break_force.min(def.break_torque) < f32::INFINITY,
        }
    }
}
