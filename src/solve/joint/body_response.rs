//! How a body answers to what a joint does to it.

use glam::{DMat3, DVec3};

use super::rows::{Jacobian, Rate};

/// What a unit of impulse along a coordinate changes of its rate (1/kg, 1/(kg·m²)), and what external forces accelerate it by (m/s², rad/s²).
/// None where nothing but its own bodies tells.
pub(crate) type CoordinateAnswer<'a> = &'a dyn Fn(&Jacobian) -> Option<[f64; 2]>;

/// How what a motor moves answers to it.
#[derive(Clone, Copy)]
pub(crate) struct MotorAnswers<'a> {
    /// Each of the joint's two bodies, or what stands for it.
    pub bodies: &'a dyn Fn(usize) -> BodyResponse,
    /// A coordinate with all other joints held, by a factor of them.
    pub in_loop: Option<CoordinateAnswer<'a>>,
}

impl MotorAnswers<'_> {
    /// Of what has no motors.
    pub(crate) const NONE: Self = Self { bodies: &|_| BodyResponse::NONE, in_loop: None };
}

/// How a body answers: what a unit of momentum moves it by, and what external forces accelerate it by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BodyResponse {
    /// (1/kg).
    pub inverse_mass: DVec3,
    /// (1/(kg·m²)).
    pub inverse_inertia: DMat3,
    /// Of its centre (m/s², rad/s²).
    pub acceleration: Rate,
    /// From the centre of mass that rows are about to its own (m): another one where it stands for several bodies.
    pub center: DVec3,
}

impl BodyResponse {
    /// Of what never moves.
    pub(crate) const NONE: Self = Self {
        inverse_mass: DVec3::ZERO,
        inverse_inertia: DMat3::ZERO,
        acceleration: Rate { linear: DVec3::ZERO, angular: DVec3::ZERO },
        center: DVec3::ZERO,
    };

    /// What a force, and a torque about the centre of mass that rows are about, change of the motion there.
    pub(super) fn response(&self, push: &Rate) -> Rate {
        let angular = self.inverse_inertia * (push.angular - self.center.cross(push.linear));
        Rate { linear: self.inverse_mass * push.linear - angular.cross(self.center), angular }
    }

    /// What external forces accelerate it by, there.
    pub(super) fn acceleration(&self) -> Rate {
        let Rate { linear, angular } = self.acceleration;
        Rate { linear: linear - angular.cross(self.center), angular }
    }
}
