//! Forces and impulses on dynamic bodies.

use glam::{DVec3, Vec3};

use super::World;
use super::wake::Edited;
use crate::body::{Body, checked_velocity};
use crate::check;
use crate::error::{Error, ErrorKind, Result};
use crate::id::BodyId;
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

impl World {
    /// Pushes a body at its centre of mass with `force` (N) during the next step, and wakes it.
    ///
    /// The step changes its velocity by force · step / mass. What touches nothing and has no joints is moved by the velocity at the step's end, gravity
    /// included (symplectic Euler), and so is, as a whole, what touches or is jointed only among itself: springs, orbits, magnets and buoyancy that are worked
    /// out of the poses before each step keep their energy, and a constant thrust is half a step ahead of its parabola. On what touches or is jointed to
    /// something fixed the force is spread over the step.
    ///
    /// # Errors
    /// A handle that is not a body of this world, a body that is not dynamic, a number that is not finite.
    pub fn add_force(&mut self, body: BodyId, force: Vec3) -> Result<()> {
        check::finite_vec("force", force)?;
        self.change_forces(body, |_| (force, Vec3::ZERO))
    }

    /// Pushes a body at `point` (world, m) with `force` (N) during the next step, and wakes it.
    ///
    /// # Errors
    /// As [`add_force`](Self::add_force).
    pub fn add_force_at(&mut self, body: BodyId, force: Vec3, point: DVec3) -> Result<()> {
        check::finite_vec("force", force)?;
        check::position("point", point)?;
        self.change_forces(body, |body| (force, (point - body.center).as_vec3().cross(force)))
    }

    /// Turns a body with `torque` (N·m) during the next step, and wakes it.
    ///
    /// # Errors
    /// As [`add_force`](Self::add_force).
    pub fn add_torque(&mut self, body: BodyId, torque: Vec3) -> Result<()> {
        check::finite_vec("torque", torque)?;
        self.change_forces(body, |_| (Vec3::ZERO, torque))
    }

    /// Changes a body's velocity at once by `impulse` (N·s) at its centre of mass, and wakes it.
    ///
    /// # Errors
    /// As [`add_force`](Self::add_force); a change to more than 1e4 m/s or rad/s is out of range.
    pub fn add_impulse(&mut self, body: BodyId, impulse: Vec3) -> Result<()> {
        check::finite_vec("impulse", impulse)?;
        self.change_velocity(body, |_| (impulse, Vec3::ZERO))
    }

    /// Changes a body's velocities at once by `impulse` (N·s) at `point` (world, m), and wakes it.
    ///
    /// # Errors
    /// As [`add_impulse`](Self::add_impulse).
    pub fn add_impulse_at(&mut self, body: BodyId, impulse: Vec3, point: DVec3) -> Result<()> {
        check::finite_vec("impulse", impulse)?;
        check::position("point", point)?;
        self.change_velocity(body, |body| (impulse, (point - body.center).as_vec3().cross(impulse)))
    }

    /// Changes a body's angular velocity at once by `impulse` (N·m·s), and wakes it.
    ///
    /// # Errors
    /// As [`add_impulse`](Self::add_impulse).
    pub fn add_angular_impulse(&mut self, body: BodyId, impulse: Vec3) -> Result<()> {
        check::finite_vec("impulse", impulse)?;
        self.change_velocity(body, |_| (Vec3::ZERO, impulse))
    }

    fn dynamic_body(&self, body: BodyId) -> Result<u32> {
        let index = self.bodies.find(body)?;
        if self.bodies[index].is_dynamic() {
            return Ok(index);
        }
        Err(Error::new(ErrorKind::NotApplicable, "body", "only dynamic bodies take forces"))
    }

    fn change_forces(&mut self, body: BodyId, load: impl FnOnce(&Body) -> (Vec3, Vec3)) -> Result<()> {
        let index = self.dynamic_body(body)?;
        let record = &self.bodies[index];
        let (force, torque) = load(record);
        let (force, torque) = (record.force + force, record.torque + torque);
        check::finite_vec("force", force)?;
        check::finite_vec("torque", torque)?;
        self.bodies[index].force = force;
        self.bodies[index].torque = torque;
        // What joints have not been looked at yet may be found to be held.
        if !self.bodies[index].is_free() || !self.unions.stale.is_empty() {
            self.unions.pushed.push(index);
        }
        self.wake_for(Edited::Body(index));
        Ok(())
    }

    fn change_velocity(&mut self, body: BodyId, load: impl FnOnce(&Body) -> (Vec3, Vec3)) -> Result<()> {
        let index = self.dynamic_body(body)?;
        let record = &self.bodies[index];
        let (impulse, angular) = load(record);
        let free = crate::body::free_axes(record.settings.locked_axes.translation);
        let linear = record.linear_velocity + impulse * free * record.own_inverse_mass();
        let angular = record.angular_velocity + record.own_inverse_inertia() * angular;
        checked_velocity("impulse", linear, MAX_LINEAR_SPEED)?;
        checked_velocity("impulse", angular, MAX_ANGULAR_SPEED)?;
        self.bodies[index].linear_velocity = linear;
        self.bodies[index].angular_velocity = angular;
        self.keep_anchored(index);
        self.strike(index);
        self.wake_for(Edited::Body(index));
        Ok(())
    }
}
