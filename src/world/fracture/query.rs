//! Settings and results of fracture, for the host.

use glam::{Quat, Vec3};

use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::fracture::{FractureSettings, JointBreak, JointLoad, JointStress, Piece, Split, Strength};
use crate::id::{JointId, in_world};
use crate::joint_record::Joint;
use crate::solve::joint::kinds::is_distance;
use crate::world::World;
use crate::world::wake::Edited;

impl World {
    /// Sets what a joint bears before it breaks; what it has borne so far is kept while it can break.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a number of `strength` is out of range.
    pub fn set_joint_strength(&mut self, joint: JointId, strength: Strength) -> Result<()> {
        strength.check()?;
        let slot = self.joints.find(joint)?;
        let record = &mut self.joints[slot];
        if record.def.strength == strength {
            return Ok(());
        }
        record.def.strength = strength;
        record.strain = match record.strain.take() {
            kept if strength.can_break() => kept.or_else(|| Some(Box::default())),
            _ => None,
        };
        self.fracture.joints_changed();
        self.limits_changed(slot);
        // What bears more than that already breaks in the next step.
        self.wake_for(Edited::Joint(slot));
        Ok(())
    }

    /// Sets whether and how fast joints break, and wakes everything: what bears too much already may break now.
    ///
    /// # Errors
    /// The budget is zero.
    pub fn set_fracture_settings(&mut self, settings: FractureSettings) -> Result<()> {
        settings.check()?;
        if self.def.fracture != settings {
            self.def.fracture = settings;
            self.wake_all();
        }
        Ok(())
    }

    /// Has these joints break in the next step, in the place where a step breaks joints: what a server's step broke, as listed in
    /// its [`broken`](Self::broken), makes a client that was in the same state before the step the same after it, bit for bit.
    ///
    /// Of the handles, the number of the world is not looked at: they come from another world with the same content. Joints that
    /// have been destroyed are passed over. Lists given before the same step add up.
    ///
    /// # Errors
    /// A handle is no joint's; nothing has changed then.
    pub fn apply_fractures(&mut self, joints: &[JointId]) -> Result<()> {
        let tag = self._tag.number();
        let named = |error: Error| Error { argument: "joints", ..error };
        let mut asked = Vec::with_capacity(joints.len());
        for &joint in joints {
            match self.joints.find(in_world(joint, tag)) {
                Ok(slot) => asked.push(self.joints.handle_of(slot)),
                Err(Error { kind: ErrorKind::StaleHandle, .. }) => {}
                Err(error) => return Err(named(error)),
            }
        }
        self.fracture.asked.append(&mut asked);
        self.fracture.asked.sort_unstable();
        self.fracture.asked.dedup();
        Ok(())
    }

    /// Joints that broke in the last step, in the order in which they did.
    pub fn broken(&self) -> &[JointBreak] {
        &self.events.broken
    }

    /// Unions that fell into pieces in the last step, by their lowest member.
    pub fn splits(&self) -> &[Split] {
        &self.events.splits
    }

    /// The pieces of all splits of the last step, split by split, each by its lowest member.
    pub fn pieces(&self) -> &[Piece] {
        &self.events.pieces
    }

    /// The members of all pieces, piece by piece, by slot.
    pub fn piece_bodies(&self) -> &[crate::id::BodyId] {
        &self.events.piece_bodies
    }

    /// What a joint bears at present, against what it can. Without limits the share is 0 and the load that of the last step.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn joint_stress(&self, joint: JointId) -> Result<JointStress> {
        Ok(self.stress_of(self.joints.find(joint)?))
    }

    /// As the share of [`joint_stress`](Self::joint_stress), for many joints at once.
    ///
    /// # Errors
    /// `out` is not as long as `joints`, or a handle is not a joint of this world; nothing is written then.
    pub fn joint_shares_into(&self, joints: &[JointId], out: &mut [f32]) -> Result<()> {
        if joints.len() != out.len() {
            return Err(Error::new(ErrorKind::OutOfRange, "out", "is not as long as the list of joints"));
        }
        for &joint in joints {
            self.joints.find(joint)?;
        }
        for (&joint, share) in joints.iter().zip(out) {
            *share = self.joint_stress(joint)?.share;
        }
        Ok(())
    }

    /// Joints that bear at least this share of a limit, those closest to breaking first.
    ///
    /// # Errors
    /// `least` is NaN or negative.
    pub fn joints_near_breaking(&self, least: f32) -> Result<Vec<(JointId, f32)>> {
        check::bound("least", least)?;
        let limited = self.joints.iter().filter(|(_, joint)| joint.strain.is_some());
        let shares = limited.map(|(slot, _)| (self.joints.handle_of(slot), self.stress_of(slot).share));
        let mut near: Vec<(JointId, f32)> = shares.filter(|&(_, share)| share >= least).collect();
        near.sort_by(|a, b| b.1.total_cmp(&a.1));
        Ok(near)
    }

    /// Axes whose x a joint's strength is told along, as they are now: those of its frame on A; of a joint that holds a distance turned the shortest
    /// way so that x goes from its point on A to that on B, as its frame says nothing of that line.
    pub(super) fn strength_axes(&self, joint: &Joint) -> Quat {
        let frame = self.end(joint, 0).frame;
        let [a, b] = [0, 1].map(|side| self.joint_point(joint, side));
        match (b - a).as_vec3().try_normalize().filter(|_| is_distance(&joint.def)) {
            Some(line) => Quat::from_rotation_arc(frame * Vec3::X, line) * frame,
            None => frame,
        }
    }

    /// Load of the last step in these axes. That of a joint that holds a distance is along its line, wherever that has turned to in the step.
    pub(super) fn load_in(&self, slot: u32, axes: Quat) -> JointLoad {
        let joint = &self.joints[slot];
        let (force, torque) = self.load_inside(slot).unwrap_or((joint.force, joint.torque));
        let (force, torque) = (axes.conjugate() * force, axes.conjugate() * torque);
        let force = if is_distance(&joint.def) { Vec3::X * force.length().copysign(force.x) } else { force };
        JointLoad { force, torque }
    }

    fn stress_of(&self, slot: u32) -> JointStress {
        let joint = &self.joints[slot];
        let strength = &joint.def.strength;
        let (load, damage) = match &joint.strain {
            Some(strain) => (strain.present(strength), strain.damage),
            None => (self.load_in(slot, self.strength_axes(joint)), 0.0),
        };
        let (share, limit) = strength.share(&load);
        JointStress { load, share, limit, damage }
    }
}
