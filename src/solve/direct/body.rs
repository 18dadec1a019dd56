//! Bodies of an articulation, in the precision that its solve needs: `f64`.

use glam::{DMat3, DQuat, DVec3};

use super::super::joint::Stance;
use super::super::joint::rows::Rate;
use super::super::rotation::{self, Top, Turn};
use super::super::state::{BodyMotion, BodyVelocity, MotionKind};
use super::stiffness;

/// Largest rotation by which a projection turns a body at once (rad); beyond it a lever's direction has no meaning.
const MAX_PROJECTED_TURN: f64 = 0.5;

/// Passes in which the angular velocity at the end of a substep is found from an angular momentum.
const MOMENTUM_PASSES: usize = 2;

/// Rotation that makes no difference to the inertia of a body that has turned by it (rad).
const NEGLIGIBLE_TURN: f64 = 1.0e-9;

/// Relative gain of rotational energy beyond which a body's angular momentum is not carried into its new pose.
const MOST_GAIN: f64 = 1.0e-6;

/// One body: what stays as it is for a substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectBody {
    /// Slot in the batch.
    pub slot: u32,
    pub kind: MotionKind,
    /// Whether it moves and no joint holds it.
    pub is_rider: bool,
    /// 1/mass along the world axes (1/kg); zero where locked.
    pub inverse_mass: DVec3,
    /// (I + G)⁻¹ in world axes (1/(kg·m²)), zero about locked axes.
    pub inverse_inertia: DMat3,
    /// I where it responds (kg·m²).
    inertia: DMat3,
    top: Top,
    acceleration: DVec3,
    torque: DVec3,
    linear_damping: f64,
    angular_damping: f64,
}

impl DirectBody {
    pub(crate) fn new(slot: u32, velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        Self {
            slot,
            kind: motion.kind,
            is_rider: motion.is_dynamic() && !motion.jointed,
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

    /// Inertia in world axes (kg·m²).
    pub(super) fn inertia_at(&self, stance: &Stance) -> DMat3 {
        if self.top.round {
            return DMat3::from_diagonal(self.top.inertia);
        }
        let axes = DMat3::from_quat(stance.1 * self.top.frame);
        axes * DMat3::from_diagonal(self.top.inertia) * axes.transpose()
    }

    /// Adds the stiffness of its joints' forces, h·Σ [`stiffness::of_impulse`], to the inertia that answers to impulses; returns
    /// the angular velocity taken through the same, (I + G) ω' = I ω, whose kinetic energy is no greater.
    pub(crate) fn respond(&mut self, stance: &Stance, stiffness: DMat3, rate: &Rate) -> DVec3 {
        if !self.is_dynamic() {
            return rate.angular;
        }
        self.inertia = self.inertia_at(stance);
        let inertia = self.inertia;
        let free = self.top.free;
        if free != DVec3::ONE || stiffness == DMat3::ZERO {
            self.inverse_inertia = masked(inertia.inverse(), free);
            return rate.angular;
        }
        self.inverse_inertia = (inertia + stiffness::without_negative(stiffness)).inverse();
        self.inverse_inertia * (inertia * rate.angular)
    }

    /// How readily a force across `lever` turns the body, over the lever's length: |r| tr(I⁻¹ across r) (1/(kg·m)), with I round.
    pub(crate) fn turning_ease(&self, lever: DVec3) -> f64 {
        if self.is_dynamic() { 2.0 * lever.length() / self.top.inertia.max_element() } else { 0.0 }
    }

    /// Adds a substep's forces.
    pub(crate) fn apply_forces(&self, stance: &Stance, rate: &mut Rate, h: f64) {
        if !self.is_dynamic() {
            return;
        }
        if self.torque != DVec3::ZERO {
            rate.angular += masked(self.inertia_at(stance).inverse(), self.top.free) * self.torque * h;
        }
        rate.angular /= 1.0 + h * self.angular_damping;
        self.apply_linear_forces(rate, h);
    }

    fn apply_linear_forces(&self, rate: &mut Rate, h: f64) {
        let free = self.inverse_mass.cmpgt(DVec3::ZERO);
        rate.linear += DVec3::select(free, self.acceleration * h, DVec3::ZERO);
        rate.linear /= 1.0 + h * self.linear_damping;
        self.limit_speed(rate, h);
    }

    /// State at the end of a second-order substep without joints, from its extrapolated start, with the Euler part `h` long (s).
    pub(crate) fn predict_second_order(&self, start: &Stance, mut rate: Rate, momentum: DVec3, h: f64) -> (Stance, Rate) {
        let momentum = momentum + self.torque * h;
        let mut rotation = start.1;
        for _ in 0..MOMENTUM_PASSES {
            let before = rate.angular;
            rotation = self.turned(start.1, before, h);
            rate.angular = self.spin_of(rotation, momentum) / (1.0 + h * self.angular_damping);
            if (rate.angular - before).length_squared() * h * h < NEGLIGIBLE_TURN * NEGLIGIBLE_TURN {
                break;
            }
        }
        self.apply_linear_forces(&mut rate, h);
        ((start.0 + rate.linear * h, rotation), rate)
    }

    /// Moves from the extrapolated start of a second-order substep to its end, at a rate found with the inertia of where it responds.
    pub(crate) fn advance_second_order(&self, stance: &mut Stance, rate: &mut Rate, h: f64) {
        self.limit_speed(rate, h);
        stance.0 += rate.linear * h;
        stance.1 = self.turned(stance.1, rate.angular, h);
        if !self.is_dynamic() || self.top.round {
            return;
        }
        // The momentum is what the joints left; on a thin rod it can be a far higher speed in another pose, which is refused.
        let momentum = self.inertia * rate.angular;
        let angular = self.spin_of(stance.1, momentum);
        if momentum.dot(angular) <= momentum.dot(rate.angular) * (1.0 + MOST_GAIN) {
            rate.angular = angular;
        }
    }

    fn turned(&self, rotation: DQuat, angular: DVec3, h: f64) -> DQuat {
        rotation::rotated(rotation, (angular * h).clamp_length_max(f64::from(rotation::MAX_TURN)))
    }

    /// Angular velocity of an angular momentum in this rotation.
    fn spin_of(&self, rotation: DQuat, momentum: DVec3) -> DVec3 {
        if self.top.round {
            return momentum / self.top.inertia * self.top.free;
        }
        let axes = rotation * self.top.frame;
        axes * ((axes.conjugate() * momentum) / self.top.inertia) * self.top.free
    }

    /// No speed is beyond what the world allows.
    pub(crate) fn limit_speed(&self, rate: &mut Rate, h: f64) {
        let most_turn = f64::from(crate::body::MAX_ANGULAR_SPEED).min(f64::from(rotation::MAX_TURN) / h);
        rate.linear = rate.linear.clamp_length_max(f64::from(crate::body::MAX_LINEAR_SPEED));
        rate.angular = rate.angular.clamp_length_max(most_turn);
    }

    /// Rotation through a substep at this rate.
    pub(crate) fn turn(&self, stance: &Stance, rate: &Rate, h: f64) -> Turn {
        if self.is_dynamic() {
            return rotation::turn(stance.1, rate.angular, &self.top, h);
        }
        Turn { rotation: rotation::rotated(stance.1, rate.angular * h), mean: rate.angular, angular: rate.angular }
    }

    /// Moves by a displacement (m) and a rotation vector (rad) that leave no velocity behind.
    pub(crate) fn displace(&self, stance: &mut Stance, change: &Rate, factor: f64) {
        if !self.is_dynamic() {
            return;
        }
        stance.0 += change.linear * factor;
        stance.1 = rotation::rotated(stance.1, (change.angular * factor).clamp_length_max(MAX_PROJECTED_TURN));
    }

    /// Kinetic energy less the work of the forces on the way from `start` (J); zero where it does not move freely.
    pub(crate) fn energy(&self, stance: &Stance, rate: &Rate, start: &Stance) -> f64 {
        let Some(mass) = self.free_mass() else { return 0.0 };
        let local = if self.top.round { rate.angular } else { (stance.1 * self.top.frame).conjugate() * rate.angular };
        let kinetic = 0.5 * (mass * rate.linear.length_squared() + local.dot(self.top.inertia * local));
        let turned = stance.1 * start.1.conjugate();
        let turn = 2.0 * turned.w.signum() * DVec3::new(turned.x, turned.y, turned.z);
        kinetic - mass * self.acceleration.dot(stance.0 - start.0) - self.torque.dot(turn)
    }

    /// Mass of a body that moves freely (kg).
    pub(crate) fn free_mass(&self) -> Option<f64> {
        let free = self.is_dynamic() && self.top.free == DVec3::ONE && self.inverse_mass.min_element() > 0.0;
        free.then(|| 1.0 / self.inverse_mass.x)
    }

    /// Angular momentum about the centre of mass at this rate (N·m·s).
    pub(crate) fn spin(&self, stance: &Stance, rate: &Rate) -> DVec3 {
        if self.top.round {
            return rate.angular * self.top.inertia;
        }
        let axes = stance.1 * self.top.frame;
        axes * ((axes.conjugate() * rate.angular) * self.top.inertia)
    }
}

/// The matrix without the rows and columns of locked axes.
fn masked(m: DMat3, free: DVec3) -> DMat3 {
    DMat3::from_cols(m.x_axis * free * free.x, m.y_axis * free * free.y, m.z_axis * free * free.z)
}
