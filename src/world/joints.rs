//! Making, changing, reading and destroying joints.

use glam::{DVec3, Quat, Vec3};

use super::World;
use super::long_range::holds_points;
use super::wake::Edited;
use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, JointId};
use crate::joint::{JointAxisState, JointDef, JointKind, JointState, Softness};
use crate::joint_record::Joint;
use crate::settings::Solver;
use crate::solve::joint::geometry::Placement;
use crate::solve::joint::{angles, axis_of, coordinate, gap_of, placement_of};

impl World {
    /// Makes a joint and wakes its bodies.
    ///
    /// # Errors
    /// Names the field of `def` at fault: a handle that is not a body of this world, the same body twice,
    /// a number out of range.
    pub fn create_joint(&mut self, def: &JointDef) -> Result<JointId> {
        let def = def.checked()?;
        let bodies = [self.joint_body(def.body_a, "body_a")?, self.joint_body(def.body_b, "body_b")?];
        if bodies[0] == bodies[1] {
            return Err(Error::new(ErrorKind::NotApplicable, "body_b", "is the same as body_a"));
        }
        let (slot, id) = self.joints.insert(Joint::new(def, bodies))?;
        self.joints[slot].angles = angles::first(&def.kind, &self.placement(&self.joints[slot]));
        self.fracture.joints_changed();
        for index in bodies.into_iter().flatten() {
            self.bodies[index].joints.push(id);
            // What moved without the joint says nothing about how it will move with it.
            self.bodies[index].history.forget();
        }
        self.wake_for(Edited::Joint(slot));
        if let ([Some(a), Some(b)], false) = (bodies, def.collide_connected) {
            self.drop_pairs_between(a, b);
        }
        self.review_pairs_of_joint(slot);
        self.topology_changed();
        self.long_range.graph_changed();
        self.joint_changed(slot);
        Ok(id)
    }

    /// Destroys a joint and wakes its bodies.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn destroy_joint(&mut self, joint: JointId) -> Result<()> {
        let slot = self.joints.find_to_destroy(joint)?;
        self.remove_joint(slot);
        Ok(())
    }

    /// Takes a joint out and wakes its bodies.
    pub(super) fn remove_joint(&mut self, slot: u32) {
        self.joint_changed(slot);
        self.wake_for(Edited::Joint(slot));
        let (joint, bodies) = (self.joints.handle_of(slot), self.joints[slot].bodies);
        self.joints.remove(slot);
        self.fracture.joints_changed();
        self.topology_changed();
        self.long_range.graph_changed();
        for index in bodies.into_iter().flatten() {
            self.bodies[index].joints.retain(|&other| other != joint);
            self.bodies[index].history.forget();
            // The two may collide from now on.
            for &id in &self.bodies[index].shapes {
                if let Ok(shape) = self.colliders.find(id) {
                    self.collision.broad.revisit(shape);
                }
            }
        }
    }

    /// The joint's definition as it is now.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn joint_def(&self, joint: JointId) -> Result<JointDef> {
        Ok(self.joints[self.joints.find(joint)?].def)
    }

    /// Gives a joint other limits or motors.
    ///
    /// # Errors
    /// The handle is not a joint of this world; `kind` is another kind of joint; a number is out of range.
    pub fn set_joint_kind(&mut self, joint: JointId, kind: JointKind) -> Result<()> {
        let kind = kind.checked()?;
        let slot = self.joints.find(joint)?;
        if std::mem::discriminant(&kind) != std::mem::discriminant(&self.joints[slot].def.kind) {
            return Err(Error::new(ErrorKind::NotApplicable, "kind", "a joint cannot become another kind of joint"));
        }
        self.change_joint(slot, |def| def.kind = kind);
        Ok(())
    }

    /// Gives a joint other compliances and dampings.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a number is negative or not finite.
    pub fn set_joint_softness(&mut self, joint: JointId, linear: Softness, angular: Softness, limit: Softness) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { linear, angular, limit, ..self.joints[slot].def }.checked()?;
        self.change_joint(slot, |old| *old = def);
        Ok(())
    }

    /// Sets the dry friction of a hinge (N·m), prismatic (N) or spherical joint (N·m), as [`JointDef::friction`], and wakes its bodies.
    ///
    /// # Errors
    /// The handle is not a joint of this world; `friction` is negative or not finite.
    pub fn set_joint_friction(&mut self, joint: JointId, friction: f32) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { friction, ..self.joints[slot].def }.checked()?;
        self.take_friction(slot, def);
        Ok(())
    }

    /// Sets the dry friction of a six-axis joint's axes (N, N·m), as [`JointDef::axis_friction`], and wakes its bodies.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a number is negative or not finite.
    pub fn set_joint_axis_friction(&mut self, joint: JointId, friction: [f32; 6]) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { axis_friction: friction, ..self.joints[slot].def }.checked()?;
        self.take_friction(slot, def);
        Ok(())
    }

    /// Sets the restitution of a joint's stops, as [`JointDef::restitution`], and wakes its bodies.
    ///
    /// # Errors
    /// The handle is not a joint of this world; `restitution` is not within 0 … 1.
    pub fn set_joint_restitution(&mut self, joint: JointId, restitution: f32) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { restitution, ..self.joints[slot].def }.checked()?;
        self.take_friction(slot, def);
        Ok(())
    }

    /// Sets the force (N) and torque (N·m) above which a joint is reported as overloaded.
    ///
    /// # Errors
    /// The handle is not a joint of this world; a limit is negative or NaN.
    pub fn set_joint_break(&mut self, joint: JointId, force: f32, torque: f32) -> Result<()> {
        let slot = self.joints.find(joint)?;
        let def = JointDef { break_force: force, break_torque: torque, ..self.joints[slot].def }.checked()?;
        if self.joints[slot].def != def {
            self.joints[slot].def = def;
            self.limits_changed(slot);
            self.wake_for(Edited::Joint(slot));
        }
        Ok(())
    }

    /// Says whether long-range constraints are derived from a joint: bounds past it, planes of hinges, unions of fixed joints; and
    /// wakes its bodies. Without it a chain ends there.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn set_joint_long_range(&mut self, joint: JointId, long_range: bool) -> Result<()> {
        let slot = self.joints.find(joint)?;
        self.change_joint(slot, |def| def.long_range = long_range);
        Ok(())
    }

    /// Says how the articulation of a joint is solved, as [`JointDef::solver`], and wakes its bodies.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn set_joint_solver(&mut self, joint: JointId, solver: Solver) -> Result<()> {
        let slot = self.joints.find(joint)?;
        self.change_joint(slot, |def| def.solver = solver);
        Ok(())
    }

    /// What the joint does at the end of the last step.
    ///
    /// # Errors
    /// The handle is not a joint of this world.
    pub fn joint_state(&self, joint: JointId) -> Result<JointState> {
        let slot = self.joints.find(joint)?;
        let joint = &self.joints[slot];
        let (force, torque) = self.load_inside(slot).unwrap_or((joint.force, joint.torque));
        let [velocity_a, velocity_b] = [self.velocity(joint, 0), self.velocity(joint, 1)];
        let placement = self.placement(joint);
        let (position, axis) = coordinate(&joint.def.kind, &placement, joint.angles);
        let axis = axis.as_vec3();
        let [lever_a, lever_b] = [placement.a.lever, placement.b.lever].map(|lever| lever.as_vec3());
        let angular_rate = (velocity_b.1 - velocity_a.1).dot(axis);
        let point_rate =
            velocity_b.0 + velocity_b.1.cross(lever_b) - velocity_a.0 - velocity_a.1.cross(lever_a + placement.gap.as_vec3());
        let turns = matches!(joint.def.kind, JointKind::Hinge { .. });
        Ok(JointState {
            position: position as f32,
            velocity: if turns { angular_rate } else { point_rate.dot(axis) },
            effort: if turns { torque.dot(axis) } else { force.dot(axis) },
            force,
            torque,
            gap: gap_of(&joint.def.kind, &placement) as f32,
        })
    }

    /// One axis of a joint at the end of the last step: axis 0 of a hinge, a prismatic or a distance joint; the twist (0) and the swing (1)
    /// of a spherical joint; of a six-axis joint the translations (0 to 2) and the rotations (3 to 5) in the order of its definition.
    /// Axes are numbered as in [`JointStop`](crate::JointStop).
    ///
    /// # Errors
    /// The handle is not a joint of this world; the joint has no such axis.
    pub fn joint_axis_state(&self, joint: JointId, axis: u32) -> Result<JointAxisState> {
        let slot = self.joints.find(joint)?;
        let joint = &self.joints[slot];
        let (force, torque) = self.load_inside(slot).unwrap_or((joint.force, joint.torque));
        let placement = self.placement(joint);
        let Some(found) = axis_of(&joint.def.kind, &placement, joint.angles, axis as usize) else {
            return Err(Error::new(ErrorKind::OutOfRange, "axis", "is not one that this kind of joint has"));
        };
        let [a, b] = [self.velocity(joint, 0), self.velocity(joint, 1)];
        let [lever_a, lever_b] = [placement.a.lever + placement.gap, placement.b.lever].map(|lever| lever.as_vec3());
        let along = b.0 + b.1.cross(lever_b) - a.0 - a.1.cross(lever_a);
        let (gradient, direction) = (found.gradient.as_vec3(), found.direction.as_vec3());
        let (rate, load) = if found.turns { (b.1 - a.1, torque) } else { (along, force) };
        let motors = self.idle_load(slot, self.last.dt).map_or(joint.motors, |idle| idle.motors);
        let motor = if matches!(joint.def.kind, JointKind::Spherical { .. }) {
            let [x, y, z, ..] = motors;
            (placement.a.frame.as_quat() * Vec3::new(x, y, z)).dot(direction)
        } else {
            motors[axis as usize]
        };
        Ok(JointAxisState { position: found.position as f32, velocity: rate.dot(gradient), effort: load.dot(direction), motor })
    }

    /// Every joint, by slot.
    pub fn joints(&self) -> impl Iterator<Item = JointId> + '_ {
        self.joints.iter().map(|(slot, _)| self.joints.handle_of(slot))
    }

    fn joint_body(&self, body: BodyId, argument: &'static str) -> Result<Option<u32>> {
        if body == BodyId::NULL {
            return Ok(None);
        }
        self.bodies.find(body).map(Some).map_err(|error| Error { argument, ..error })
    }

    /// Where friction or restitution alone differs, neither bounds nor unions do: a brake may be set in every step.
    fn take_friction(&mut self, slot: u32, def: JointDef) {
        if self.joints[slot].def != def {
            self.joints[slot].def = def;
            self.islands.groups.joint_changed(slot, &self.joints[slot]);
            self.topology_changed();
            self.wake_for(Edited::Joint(slot));
        }
    }

    /// Gives a joint another definition and wakes its bodies. One that is as it was changes nothing: a host may set a target in every step.
    pub(super) fn change_joint(&mut self, slot: u32, edit: impl FnOnce(&mut JointDef)) {
        let before = self.joints[slot].def;
        let mut def = before;
        edit(&mut def);
        if def == before {
            return;
        }
        self.joint_changed(slot);
        self.joints[slot].def = def;
        let holds = |def: &JointDef| holds_points(def).then_some([def.frame_a.position, def.frame_b.position]);
        if holds(&before) != holds(&def) {
            self.review_pairs_of_joint(slot);
        }
        self.note_drive(slot, &before);
        self.note_motor_speed(slot, &before);
        self.islands.groups.joint_changed(slot, &self.joints[slot]);
        self.joint_changed(slot);
        self.topology_changed();
        self.long_range.graph_changed();
        self.wake_for(Edited::Joint(slot));
    }

    /// Starts all joints of a body from nothing, as after a teleport.
    pub(super) fn forget_joints_of(&mut self, index: u32) {
        for id in self.bodies[index].joints.clone() {
            if let Ok(slot) = self.joints.find(id) {
                self.joints[slot].forget_impulses();
            }
        }
    }

    /// Where a joint's two frames are.
    pub(super) fn placement(&self, joint: &Joint) -> Placement {
        let [a, b] = [self.end(joint, 0), self.end(joint, 1)];
        let levers = [a.lever, b.lever].map(|lever| lever.as_dvec3());
        placement_of(b.origin - a.origin, levers, [a.frame, b.frame].map(|frame| frame.as_dquat().normalize()))
    }

    pub(super) fn end(&self, joint: &Joint, side: usize) -> End {
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        match joint.bodies[side] {
            None => End { origin: frame.position, lever: Vec3::ZERO, frame: frame.rotation },
            Some(index) => {
                let body = &self.bodies[index];
                let lever = body.rotation * (frame.position.as_vec3() - body.local_center);
                End { origin: body.center, lever, frame: body.rotation * frame.rotation }
            }
        }
    }

    pub(super) fn velocity(&self, joint: &Joint, side: usize) -> (Vec3, Vec3) {
        joint.bodies[side].map_or((Vec3::ZERO, Vec3::ZERO), |index| {
            let body = &self.bodies[index];
            (body.linear_velocity, body.angular_velocity)
        })
    }
}

/// One side of a joint in world axes.
pub(super) struct End {
    /// The body's centre of mass, or the joint point itself on the world's side (m).
    pub origin: DVec3,
    /// From there to the joint point (m).
    pub lever: Vec3,
    pub frame: Quat,
}
