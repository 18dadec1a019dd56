//! Making, changing and destroying bodies.

use glam::Vec3;

use super::World;
use super::wake::Edited;
use crate::body::{Anchored, Body, BodyDef, BodyKind, LockedAxes, checked_velocity};
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::BodyId;
use crate::mass::Mass;
use crate::pose::Pose;
use crate::shape::{self, ShapeDef};
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

impl World {
    /// Makes a body with its shapes.
    ///
    /// # Errors
    /// Names the field of `def` at fault; the world is unchanged then.
    pub fn create_body(&mut self, def: &BodyDef) -> Result<BodyId> {
        let def = def.clone().checked()?;
        let mass = if def.kind == BodyKind::Dynamic { Some(shape::resolve_mass(def.mass, &def.shapes)?) } else { None };
        if self.colliders.len() + def.shapes.len() > crate::id::MAX_OBJECTS {
            return Err(Error::new(ErrorKind::CapacityExceeded, "shapes", "the world holds no more shapes"));
        }
        let (index, id) = self.bodies.insert(Body::new(&def, mass))?;
        self.collision.index.forget_force(index);
        for shape in &def.shapes {
            self.add_collider(index, shape)?;
        }
        self.note_mover(index);
        self.topology_changed();
        // What is dynamic is awake, and wakes what it touches.
        if def.kind != BodyKind::Dynamic {
            self.wake_for(Edited::Place(index));
        }
        Ok(id)
    }

    /// Destroys a body with its shapes and joints, and wakes what touched it.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn destroy_body(&mut self, body: BodyId) -> Result<()> {
        let index = self.bodies.find_to_destroy(body)?;
        self.wake_for(Edited::Place(index));
        for joint in self.bodies[index].joints.clone() {
            self.destroy_joint(joint)?;
        }
        for shape in self.bodies[index].shapes.clone() {
            let slot = self.colliders.find(shape)?;
            self.remove_collider(slot);
        }
        self.forget_support(index);
        self.bodies.remove(index);
        // The next step strikes it off the list of movers: once for all that were destroyed.
        self.movers.are_sorted = false;
        Ok(())
    }

    /// Puts a body somewhere else at once, and wakes it and what it touched.
    ///
    /// # Errors
    /// The handle is not a body of this world; the pose is not finite, too far out, or not a rotation.
    pub fn set_pose(&mut self, body: BodyId, pose: Pose) -> Result<()> {
        let pose = pose.checked("pose.position", "pose.rotation")?;
        let index = self.bodies.find(body)?;
        self.wake_for(Edited::Place(index));
        let record = &mut self.bodies[index];
        record.set_pose(pose);
        record.take_target();
        record.times.settling.put();
        let (returned, follows) = (std::mem::take(&mut record.quarantined), !record.is_free());
        if returned {
            self.topology_changed();
            self.long_range.graph_changed();
        }
        if (returned || follows) && !self.bodies[index].joints.is_empty() {
            self.welds_changed(index);
        }
        if follows {
            // What lies on it may still do so, with the same load: friction without one would let it creep.
            self.take_boxes_along(index);
        } else {
            self.forget_contacts_of(index);
            self.refresh_boxes(index);
        }
        self.forget_joints_of(index);
        self.bodies[index].history.forget();
        self.wake_for(Edited::Place(index));
        self.note_mover(index);
        Ok(())
    }

    /// Gives a body another velocity of its centre of mass (m/s), and wakes it.
    ///
    /// # Errors
    /// The handle is not a body of this world; the body is static; the velocity is not finite or above 1e4 m/s.
    pub fn set_linear_velocity(&mut self, body: BodyId, velocity: Vec3) -> Result<()> {
        checked_velocity("linear_velocity", velocity, MAX_LINEAR_SPEED)?;
        self.change_velocities(body, |record| record.linear_velocity = velocity)
    }

    /// Gives a body another angular velocity (rad/s), and wakes it.
    ///
    /// # Errors
    /// The handle is not a body of this world; the body is static; the velocity is not finite or above 1e4 rad/s.
    pub fn set_angular_velocity(&mut self, body: BodyId, velocity: Vec3) -> Result<()> {
        checked_velocity("angular_velocity", velocity, MAX_ANGULAR_SPEED)?;
        self.change_velocities(body, |record| record.angular_velocity = velocity)
    }

    /// Moves a kinematic body so that it has this pose at the end of the next step, unless it is given a velocity or a pose before: the last
    /// call is what counts.
    ///
    /// # Errors
    /// The handle is not a body of this world; the body is not kinematic; the pose is refused as in
    /// [`set_pose`](Self::set_pose).
    pub fn move_to(&mut self, body: BodyId, target: Pose) -> Result<()> {
        let target = target.checked("target.position", "target.rotation")?;
        let index = self.bodies.find(body)?;
        if self.bodies[index].kind != BodyKind::Kinematic {
            return Err(Error::new(ErrorKind::NotApplicable, "body", "only kinematic bodies are moved by target"));
        }
        let record = &mut self.bodies[index];
        let at = record.pose();
        if at.position == target.position && (at.rotation == target.rotation || at.rotation == -target.rotation) {
            // It stands, and what lies on it may sleep: a velocity that it has ends as the next step begins.
            record.take_target();
            record.kinematic.driven = true;
            return Ok(());
        }
        let stood = !record.is_mover();
        record.kinematic.path.get_or_insert_default().target = Some(target);
        if stood {
            self.wake_for(Edited::Body(index));
        }
        self.note_mover(index);
        Ok(())
    }

    /// Gives a body another mass.
    ///
    /// # Errors
    /// The handle is not a body of this world; the body is not dynamic; the mass is refused as in
    /// [`create_body`](Self::create_body).
    pub fn set_mass(&mut self, body: BodyId, mass: Mass) -> Result<()> {
        let index = self.bodies.find(body)?;
        if !self.bodies[index].is_dynamic() {
            return Err(Error::new(ErrorKind::NotApplicable, "body", "only dynamic bodies have mass"));
        }
        let resolved = shape::resolve_mass(mass, &self.shape_defs(index))?;
        self.bodies[index].settings.mass_source = mass;
        self.apply_mass(index, Some(resolved));
        Ok(())
    }

    /// Rates at which linear and angular velocity decay (1/s).
    ///
    /// # Errors
    /// The handle is not a body of this world; a rate is negative or not finite.
    pub fn set_damping(&mut self, body: BodyId, linear: f32, angular: f32) -> Result<()> {
        check::not_negative("linear", linear)?;
        check::not_negative("angular", angular)?;
        self.change(body, |body| (body.settings.linear_damping, body.settings.angular_damping) = (linear, angular))
    }

    /// Factor on the world's gravity.
    ///
    /// # Errors
    /// The handle is not a body of this world; the factor is not finite.
    pub fn set_gravity_scale(&mut self, body: BodyId, scale: f32) -> Result<()> {
        check::finite("scale", scale)?;
        self.change(body, |body| body.settings.gravity_scale = scale)
    }

    /// Degrees of freedom taken away.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn set_locked_axes(&mut self, body: BodyId, locked: LockedAxes) -> Result<()> {
        self.change(body, |body| {
            body.settings.locked_axes = locked;
            body.stop_along_locked_axes();
        })?;
        let index = self.bodies.find(body)?;
        if !self.bodies[index].joints.is_empty() {
            self.welds_changed(index);
        }
        Ok(())
    }

    /// Whether the body is swept through each step.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn set_fast(&mut self, body: BodyId, fast: bool) -> Result<()> {
        let index = self.bodies.find(body)?;
        self.bodies[index].settings.fast = fast;
        Ok(())
    }

    /// Whether the body may fall asleep; if not, it wakes now.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn set_can_sleep(&mut self, body: BodyId, can_sleep: bool) -> Result<()> {
        self.change(body, |body| body.settings.can_sleep = can_sleep)
    }

    /// The host's own word on the body.
    ///
    /// # Errors
    /// The handle is not a body of this world.
    pub fn set_user_word(&mut self, body: BodyId, word: u64) -> Result<()> {
        let index = self.bodies.find(body)?;
        self.bodies[index].settings.user_word = word;
        Ok(())
    }

    /// Changes a body's record and wakes it.
    fn change(&mut self, body: BodyId, edit: impl FnOnce(&mut Body)) -> Result<()> {
        let index = self.bodies.find(body)?;
        edit(&mut self.bodies[index]);
        self.wake_for(Edited::Body(index));
        Ok(())
    }

    /// Gives a body other velocities, in place of a target that it was to move to, and wakes what they may move. A kinematic body that
    /// moves already has nothing asleep on it.
    fn change_velocities(&mut self, body: BodyId, edit: impl FnOnce(&mut Body)) -> Result<()> {
        let index = self.bodies.find(body)?;
        let record = &mut self.bodies[index];
        if record.kind == BodyKind::Static {
            return Err(Error::new(ErrorKind::NotApplicable, "body", "static bodies have no velocity"));
        }
        let stood = !record.is_mover();
        edit(record);
        record.stop_along_locked_axes();
        record.kinematic.driven = false;
        record.take_target();
        if record.acts_as() == BodyKind::Dynamic || (stood && record.is_mover()) {
            self.wake_for(Edited::Body(index));
        }
        let record = &mut self.bodies[index];
        if std::mem::take(&mut record.quarantined) {
            self.topology_changed();
            self.long_range.graph_changed();
            self.welds_changed(index);
        }
        self.keep_anchored(index);
        self.strike(index);
        self.note_mover(index);
        self.rest_boxes(index);
        Ok(())
    }

    /// What is anchored moves as its anchor does. Another velocity is a blow to its joints in the next step; where those have limits it is found
    /// there.
    pub(super) fn keep_anchored(&mut self, index: u32) {
        let Self { unions, bodies, .. } = self;
        let body = &mut bodies[index];
        if body.anchored != Anchored::No && !unions.of(index).is_some_and(|union| union.wanted) {
            unions.stop(index, body);
        }
    }

    /// Adds a body to the list of movers where it belongs, and has its neighbours looked for.
    pub(super) fn note_mover(&mut self, index: u32) {
        if !self.bodies[index].is_mover() {
            return;
        }
        for &id in &self.bodies[index].shapes {
            if let Ok(shape) = self.colliders.find(id) {
                self.collision.broad.revisit(shape);
            }
        }
        self.movers.slots.push(index);
        self.movers.are_sorted = false;
    }

    /// Gives kinematic bodies the velocity that takes them to their target in `dt` seconds, and finds how it goes on within the step.
    pub(super) fn drive_kinematic_bodies(&mut self, dt: f32) {
        if self.movers.are_sorted && !self.movers.some_are_driven {
            return;
        }
        for place in 0..self.movers.slots.len() {
            let index = self.movers.slots[place];
            let Some(body) = self.bodies.get(index) else { continue };
            if body.kind != BodyKind::Kinematic {
                continue;
            }
            let body = &mut self.bodies[index];
            match body.target() {
                Some(target) => {
                    let center = target.transform_point(body.local_center);
                    body.linear_velocity = ((center - body.center) / f64::from(dt)).as_vec3().clamp_length_max(MAX_LINEAR_SPEED);
                    let turn = target.rotation * body.rotation.conjugate();
                    let turn = if turn.w < 0.0 { -turn } else { turn };
                    body.angular_velocity = (turn.to_scaled_axis() / dt).clamp_length_max(MAX_ANGULAR_SPEED);
                    body.kinematic.driven = true;
                }
                None if body.stops() => {
                    body.linear_velocity = Vec3::ZERO;
                    body.angular_velocity = Vec3::ZERO;
                    body.kinematic.driven = false;
                }
                None => {}
            }
            let velocity = [body.linear_velocity, body.angular_velocity];
            if body.kinematic.path.get_or_insert_default().begin_step(self.report.step, dt, velocity) {
                self.jolt_what_hangs_on(index);
            }
        }
        self.movers.are_sorted = false;
    }

    /// The shapes of a body as they were defined.
    pub(super) fn shape_defs(&self, index: u32) -> Vec<ShapeDef> {
        let live = self.bodies[index].shapes.iter().filter_map(|&id| self.colliders.find(id).ok());
        live.map(|slot| self.colliders[slot].def()).collect()
    }

    /// Gives a body mass properties and tells its shapes where the centre of mass is now.
    pub(super) fn apply_mass(&mut self, index: u32, mass: Option<crate::mass::MassProperties>) {
        let before = self.bodies[index].local_center;
        self.bodies[index].set_mass(mass);
        self.bodies[index].history.mass_changed();
        if !self.bodies[index].joints.is_empty() {
            self.long_range.graph_changed();
            self.welds_changed(index);
        }
        let center = self.bodies[index].local_center;
        if center != before {
            for id in self.bodies[index].shapes.clone() {
                if let Ok(shape) = self.colliders.find(id) {
                    self.colliders[shape].center_moved(center);
                }
            }
            self.center_changed(index);
        }
        if self.bodies[index].is_dynamic() {
            self.wake_for(Edited::Body(index));
        }
    }
}
