//! Joints whose stops or frames the host moves: see [`crate::joint_drive`].

use glam::Quat;

use super::World;
use crate::body::BodyKind;
use crate::joint::JointDef;
use crate::joint_drive::JointDrive;

impl World {
    /// Notes that an edit of a joint, which was `before`, may have moved a stop or a frame.
    pub(super) fn note_drive(&mut self, slot: u32, before: &JointDef) {
        let joint = &mut self.joints[slot];
        if joint.drive.is_none() && JointDrive::is_moved(before, &joint.def) {
            joint.drive = Some(Box::new(JointDrive::from(before)));
            self.movers.driven_joints.push(slot);
        }
    }

    /// Notes that an edit of a joint, which was `before`, may have its motor ask for another speed at once. Bodies that sweeps move go on from
    /// no earlier substep, and what was told of them stays known.
    pub(super) fn note_motor_speed(&mut self, slot: u32, before: &JointDef) {
        let (bodies, def) = (self.joints[slot].bodies, self.joints[slot].def);
        if JointDrive::is_motor_jolted(before, &def) {
            for index in bodies.into_iter().flatten() {
                if self.bodies[index].history.lead().is_none() {
                    self.jolt(index);
                }
            }
        }
    }

    /// Finds how fast the host moves stops and frames of joints, and has those start from nothing that have been put somewhere else.
    pub(super) fn drive_joints(&mut self, dt: f32) {
        let mut driven = std::mem::take(&mut self.movers.driven_joints);
        // A slot may have been given to another joint.
        driven.sort_unstable();
        driven.dedup();
        driven.retain(|&slot| self.drive_joint(slot, dt));
        self.movers.driven_joints = driven;
    }

    /// The same for one joint; says whether it is still driven.
    fn drive_joint(&mut self, slot: u32, dt: f32) -> bool {
        let Some(joint) = self.joints.get(slot).filter(|joint| joint.drive.is_some()) else { return false };
        let (bodies, def) = (joint.bodies, joint.def);
        let turns = bodies.map(|body| body.map_or(Quat::IDENTITY, |index| self.solved_turn(index)));
        let joint = &mut self.joints[slot];
        let Some(drive) = &mut joint.drive else { return false };
        let change = drive.begin_step(&def, dt);
        for (side, turn) in turns.into_iter().enumerate() {
            drive.solved.frames[side] = drive.carried.frames[side].map(|rate| turn * rate);
        }
        if change.is_over {
            joint.drive = None;
        }
        if change.is_put {
            joint.forget_impulses();
        }
        if change.is_put || change.is_sudden {
            for index in bodies.into_iter().flatten() {
                self.jolt(index);
            }
        }
        if change.is_over {
            // It may weld its bodies again, from the next step on.
            self.joint_changed(slot);
        }
        // Whether a joint is driven decides how it is solved.
        self.islands.groups.joint_changed(slot, &self.joints[slot]);
        !change.is_over
    }

    /// Notes that what holds a body has changed its velocity at once.
    fn jolt(&mut self, index: u32) {
        let solved = self.unions.moving(index).map_or(index, |union| union.lead);
        if self.bodies[solved].is_free() {
            self.bodies[solved].history.jolt();
        }
    }

    /// Notes that the host has changed the velocity of a body, which joints may not allow.
    pub(super) fn strike(&mut self, index: u32) {
        let solved = self.unions.moving(index).map_or(index, |union| union.lead);
        if self.bodies[solved].is_free() && !self.bodies[index].joints.is_empty() {
            self.bodies[solved].history.strike();
        }
    }

    /// The same as [`jolt`](Self::jolt) of all that hangs on a kinematic body, or on what is welded to it.
    pub(super) fn jolt_what_hangs_on(&mut self, kinematic: u32) {
        let mut hangs = std::mem::take(&mut self.scratch.slots);
        hangs.clear();
        hangs.extend(self.jointed_to(kinematic));
        for union in self.unions.driven_by(kinematic) {
            let outer = union.outer.iter().filter_map(|&slot| self.joints.get(slot));
            hangs.extend(outer.flat_map(|joint| joint.bodies).flatten());
        }
        hangs.iter().for_each(|&index| self.jolt(index));
        self.scratch.slots = hangs;
    }

    /// Rotation from a body's axes to those of what the solver moves: its union, or the world where the body is static.
    fn solved_turn(&self, index: u32) -> Quat {
        let body = &self.bodies[index];
        if self.unions.moving(index).is_some() {
            return self.unions.place(index).rotation;
        }
        if body.kind == BodyKind::Static { body.rotation } else { Quat::IDENTITY }
    }
}
