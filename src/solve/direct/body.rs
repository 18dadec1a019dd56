//! Bodies of an articulation, in the precision that its solve needs: `f64`.
//!
//! Damping is implicit. Of M (v − v₀) = h f + Jᵀ p − h c M v follows v = v* + (M (1 + h c))⁻¹ Jᵀ p with v* = (v₀ + h f/M)/(1 + h c), so
//! that what is damped answers to its joints as if it were heavier by h c: with M alone it would move as well where all is damped
//! alike, but p would be short of what the joints bear by 1/(1 + h c).

use glam::{DMat3, DQuat, DVec3};

use super::super::integrate;
use super::super::joint::LocalPose;
use super::super::joint::body_response::BodyResponse;
use super::super::joint::locks::Freedom;
use super::super::joint::rows::Rate;
use super::super::rotation::{self, SubstepRotation, Top};
use super::super::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};
use crate::linalg::held_axes::held;
use crate::linalg::narrowing;
use crate::step_history::{History, Twist};

/// Largest rotation by which a projection turns a body at once (rad); beyond it a lever's direction has no meaning.
const MAX_PROJECTED_TURN: f64 = 0.5;

/// Greatest over least moment of inertia beyond which a body counts as slender: a rod, a shaft, a blade. A small tilt of its momentum is a
/// large spin about its length, so its axis is always its length, and the momentum about that is extrapolated by itself. Taken as others
/// are, with 76 a gyroscope lost all its spin in a second.
const MAX_SHEAR: f64 = 4.0;

/// One body: what stays as it is for a substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectBody {
    /// Slot in the batch.
    pub slot: u32,
    pub kind: MotionKind,
    /// Whether it moves and no joint holds it.
    pub is_rider: bool,
    /// 1/mass along the world axes (1/kg); zero where locked.
    undamped: DVec3,
    /// The same with the damping of the substep, 1/(m (1 + h c)): with which it answers.
    pub inverse_mass: DVec3,
    /// (I (1 + h c) + G)⁻¹ in world axes (1/(kg·m²)), zero about locked axes.
    pub inverse_inertia: DMat3,
    /// I where it responds (kg·m²).
    pub(super) inertia: DMat3,
    pub(super) top: Top,
    /// Acceleration, and torque; of what the host moves, linear and angular acceleration.
    pub(crate) acceleration: DVec3,
    pub(super) torque: DVec3,
    pub(crate) linear_damping: f64,
    pub(super) angular_damping: f64,
}

impl DirectBody {
    /// Writes its state back, which ends in this rate and pose.
    pub(crate) fn store(&self, rate: &Rate, pose: &LocalPose, velocity: &mut BodyVelocity, motion: &mut BodyMotion) {
        velocity.linear = narrowing::speed(rate.linear);
        velocity.angular = narrowing::speed(rate.angular);
        motion.displacement = narrowing::way(pose.0);
        motion.rotation = narrowing::rotation(pose.1);
    }

    pub(crate) fn new(slot: u32, velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        Self {
            slot,
            kind: motion.kind,
            is_rider: motion.is_dynamic() && !motion.jointed,
            undamped: velocity.inverse_mass.as_dvec3(),
            inverse_mass: velocity.inverse_mass.as_dvec3(),
            inverse_inertia: DMat3::ZERO,
            inertia: DMat3::ZERO,
            top: motion.top(),
            acceleration: motion.acceleration.as_dvec3(),
            torque: motion.torque.as_dvec3(),
            linear_damping: f64::from(motion.linear_damping),
            angular_damping: f64::from(motion.angular_damping),
        }
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        matches!(self.kind, MotionKind::Round | MotionKind::Tumbling)
    }

    /// 1 along and about free axes, 0 along and about locked ones.
    pub(crate) fn free_axes(&self) -> [f64; 6] {
        let (along, about) = (self.undamped.to_array(), self.top.free.to_array());
        std::array::from_fn(|i| if i < 3 { f64::from(u8::from(along[i] > 0.0)) } else { about[i - 3] })
    }

    /// Whether none of its axes is locked.
    pub(crate) fn is_free(&self) -> bool {
        self.free_mass().is_some()
    }

    /// Along and about what rows move it.
    pub(crate) fn freedom(&self) -> Freedom {
        if self.is_dynamic() { Freedom::new(self.undamped, self.top.free, self.top.inertia) } else { Freedom::NONE }
    }

    /// Inertia in world axes (kg·m²).
    pub(crate) fn inertia_at(&self, stance: &LocalPose) -> DMat3 {
        if self.top.round {
            return DMat3::from_diagonal(self.top.inertia);
        }
        let axes = DMat3::from_quat(stance.1 * self.top.frame);
        axes * DMat3::from_diagonal(self.top.inertia) * axes.transpose()
    }

    /// Inverse of the inertia with which it answers, as contacts see it (1/(kg·m²)).
    pub(super) fn answer(&self) -> Symmetric {
        Symmetric::from_mat3(self.inverse_inertia.as_mat3())
    }

    /// What a push along a row is worth in its rate, r·M⁻¹ r, as if nothing but its mass held it back.
    pub(super) fn own_response(&self, linear: DVec3, angular: DVec3) -> f64 {
        let has_inertia = self.is_dynamic() && self.inertia != DMat3::ZERO;
        let ease = if has_inertia { held(self.inertia.inverse(), self.top.free) } else { self.inverse_inertia };
        (self.inverse_mass * linear).dot(linear) + (ease * angular).dot(angular)
    }

    /// How it answers to what a motor pushes it with.
    pub(crate) fn answer_at(&self, stance: &LocalPose) -> BodyResponse {
        if !self.is_dynamic() {
            return BodyResponse::NONE;
        }
        let inverse_inertia = held(self.inertia_at(stance).inverse(), self.top.free);
        let acceleration = Rate { linear: self.acceleration, angular: inverse_inertia * self.torque };
        BodyResponse { inverse_mass: self.undamped, inverse_inertia, acceleration, center: DVec3::ZERO }
    }

    /// Whether it loses speed by itself.
    pub(super) fn is_damped(&self) -> bool {
        self.linear_damping != 0.0 || self.angular_damping != 0.0
    }

    /// As [`integrate::share_gained`].
    pub(crate) fn share_gained(&self, rate: &Rate, h: f64) -> f64 {
        let (v, a) = (rate.linear.as_vec3(), self.acceleration.as_vec3());
        f64::from(integrate::share_gained(v, a, self.linear_damping as f32, h as f32))
    }

    /// By how much heavier it answers along and about its axes in a substep of length `h` (s): 1 + h c.
    pub(crate) fn weights(&self, h: f64) -> [f64; 2] {
        [self.linear_damping, self.angular_damping].map(|damping| 1.0 + h * damping)
    }

    /// Makes it answer along its axes as in a substep of length `h` (s).
    pub(crate) fn weigh(&mut self, h: f64) {
        self.inverse_mass = self.undamped / self.weights(h)[0];
    }

    /// Its angular velocity taken through the inertia that answers to impulses, (J + G) ω' = J ω with J = I (1 + h c), whose kinetic energy
    /// is no greater.
    pub(crate) fn damped(&self, stiffness: &DMat3, rate: &Rate, h: f64) -> DVec3 {
        if !self.is_dynamic() || *stiffness == DMat3::ZERO {
            return rate.angular;
        }
        self.inverse_inertia * (self.inertia * rate.angular * self.weights(h)[1])
    }

    /// Axis of its length in its frame, zero where it is not slender.
    pub(crate) fn length(&self) -> DVec3 {
        let moments = &self.top.inertia;
        if !self.is_dynamic() || self.top.round || !is_slender(moments) {
            return DVec3::ZERO;
        }
        self.top.frame * DVec3::AXES[thinnest(moments)]
    }

    /// Greatest radius of gyration (m); zero where it moves along no axis.
    pub(crate) fn gyration(&self) -> f64 {
        self.mass().map_or(0.0, |mass| (self.top.inertia.max_element() / mass).sqrt())
    }

    /// How readily a force across `lever` turns the body, over the lever's length: |r| tr(I⁻¹ across r) (1/(kg·m)), with I round.
    pub(crate) fn turning_ease(&self, lever: DVec3) -> f64 {
        if self.is_dynamic() { 2.0 * lever.length() / self.top.inertia.max_element() } else { 0.0 }
    }

    /// Whether the host moves it, at a velocity that changes within the step.
    pub(crate) fn is_bent(&self) -> bool {
        !self.is_dynamic() && (self.acceleration != DVec3::ZERO || self.torque != DVec3::ZERO)
    }

    /// Its velocity so long (s) after it had this one.
    pub(crate) fn bent(&self, rate: &Rate, after: f64) -> Rate {
        Rate { linear: rate.linear + self.acceleration * after, angular: rate.angular + self.torque * after }
    }

    /// Makes its last substep what it would have been with the forces of now, which may act for this step alone: the acceleration and torque `now`
    /// (m/s², N·m). Whether there is one, and they are others.
    ///
    /// What a two-step method takes from the last substep is an impulse that is neither given nor taken where forces change: of a force that acts for
    /// one step, in which substeps get shorter, joints passed on three quarters. What the change Δa would have done in that substep of length h is
    /// h Δa in the velocity and ½ h² Δa on the way. With it a constant force gives exactly its impulse, wherever it sets in.
    pub(super) fn push_before(&self, history: &mut History, now: Twist) -> bool {
        let before = std::mem::replace(&mut history.pushed, now);
        if history.h <= 0.0 || before == now || !self.is_dynamic() {
            return false;
        }
        let h = history.h;
        let along = DVec3::select(self.undamped.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO).as_vec3();
        let push = (now[0] - before[0]) * along;
        let about = now[1] - before[1];
        history.linear_before -= push * h;
        history.acceleration += push;
        history.displacement -= push * (0.5 * h * h);
        history.momentum_before -= about * h;
        history.torque += about;
        if history.spin_turn == 0.0 {
            let gained = held(self.inertia_at(&(DVec3::ZERO, DQuat::IDENTITY)).inverse(), self.top.free) * about.as_dvec3();
            history.turn -= gained.as_vec3() * (0.5 * h * h);
        }
        true
    }

    /// Adds a substep's forces.
    pub(crate) fn apply_forces(&self, stance: &LocalPose, rate: &mut Rate, h: f64) {
        if !self.is_dynamic() {
            return;
        }
        if self.torque != DVec3::ZERO {
            rate.angular += held(self.inertia_at(stance).inverse(), self.top.free) * self.torque * h;
        }
        rate.angular /= 1.0 + h * self.angular_damping;
        self.apply_linear_forces(rate, h);
    }

    fn apply_linear_forces(&self, rate: &mut Rate, h: f64) {
        let free = self.undamped.cmpgt(DVec3::ZERO);
        rate.linear += DVec3::select(free, self.acceleration * h, DVec3::ZERO);
        rate.linear /= 1.0 + h * self.linear_damping;
        self.limit_speed(rate);
    }

    /// No speed is beyond what the world allows.
    pub(crate) fn limit_speed(&self, rate: &mut Rate) {
        rate.linear = rate.linear.clamp_length_max(f64::from(crate::speed_limits::MAX_LINEAR_SPEED));
        rate.angular = rate.angular.clamp_length_max(f64::from(crate::speed_limits::MAX_ANGULAR_SPEED));
    }

    /// Rotation through a substep at this rate.
    pub(crate) fn turn(&self, stance: &LocalPose, rate: &Rate, h: f64) -> SubstepRotation {
        if self.is_dynamic() {
            return rotation::turn(stance.1, rate.angular, &self.top, h);
        }
        SubstepRotation { rotation: rotation::rotated(stance.1, rate.angular * h), mean: rate.angular, angular: rate.angular }
    }

    /// Moves by a displacement (m) and a rotation vector (rad) that leave no velocity behind.
    pub(crate) fn displace(&self, stance: &mut LocalPose, change: &Rate, factor: f64) {
        if !self.is_dynamic() {
            return;
        }
        stance.0 += change.linear * factor;
        stance.1 = rotation::rotated(stance.1, (change.angular * factor).clamp_length_max(MAX_PROJECTED_TURN));
    }

    /// Kinetic energy less the work of the forces on the way from `start` (J).
    pub(crate) fn energy(&self, stance: &LocalPose, rate: &Rate, start: &LocalPose) -> f64 {
        if !self.is_dynamic() {
            return 0.0;
        }
        let mass = self.mass().unwrap_or(0.0);
        let local = if self.top.round { rate.angular } else { (stance.1 * self.top.frame).conjugate() * rate.angular };
        let kinetic = 0.5 * (mass * rate.linear.length_squared() + local.dot(self.top.inertia * local));
        let excess = kinetic - mass * self.acceleration.dot(stance.0 - start.0);
        if self.torque == DVec3::ZERO {
            return excess;
        }
        let turned = stance.1 * start.1.conjugate();
        let turn = 2.0 * turned.w.signum() * DVec3::new(turned.x, turned.y, turned.z);
        excess - self.torque.dot(turn)
    }

    /// Power of gravity, forces and torques at this rate (W).
    pub(super) fn power(&self, rate: &Rate) -> f64 {
        let free = self.undamped.cmpgt(DVec3::ZERO);
        let force = DVec3::select(free, self.acceleration / DVec3::select(free, self.undamped, DVec3::ONE), DVec3::ZERO);
        force.dot(rate.linear) + if self.is_dynamic() { self.torque.dot(rate.angular) } else { 0.0 }
    }

    /// Acceleration by gravity and forces (m/s²).
    pub(crate) fn pull(&self) -> f64 {
        self.acceleration.length()
    }

    /// Mass with which it moves along those axes that are not locked (kg).
    pub(crate) fn mass(&self) -> Option<f64> {
        let ease = self.undamped.max_element();
        (self.is_dynamic() && ease > 0.0).then(|| 1.0 / ease)
    }

    /// Mass of a body that moves freely (kg).
    pub(crate) fn free_mass(&self) -> Option<f64> {
        let free = self.is_dynamic() && self.top.free == DVec3::ONE && self.undamped.min_element() > 0.0;
        free.then(|| 1.0 / self.undamped.x)
    }

    /// Angular momentum about the centre of mass at this rate (N·m·s).
    pub(crate) fn spin(&self, stance: &LocalPose, rate: &Rate) -> DVec3 {
        if self.top.round {
            return rate.angular * self.top.inertia;
        }
        let axes = stance.1 * self.top.frame;
        axes * ((axes.conjugate() * rate.angular) * self.top.inertia)
    }
}

/// Number of the principal axis about which a slender body has the least moment: its length.
pub(super) fn thinnest(moments: &DVec3) -> usize {
    (0..3).fold(0, |least, axis| if moments[axis] < moments[least] { axis } else { least })
}

pub(super) fn is_slender(moments: &DVec3) -> bool {
    moments.max_element() > MAX_SHEAR * moments.min_element()
}
