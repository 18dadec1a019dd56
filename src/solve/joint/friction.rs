//! Dry friction of what a joint leaves free: a bearing, a guide, a ball in its socket.
//!
//! With c the coordinate, ċ = J v its rate and F the greatest force or torque (N, N·m), the law of a dry bearing whose load is not
//! modelled is that of greatest dissipation,
//!
//! ```text
//! f = −F sgn ċ  where ċ ≠ 0,      |f| ≤ F  where ċ = 0.
//! ```
//!
//! Taken at the end of a substep of length h (Moreau 1988; MuJoCo's `frictionloss`, Todorov 2014) it is one row with bounds,
//!
//! ```text
//! J v = 0,   |p| ≤ h F:      p = max(−h F, min(h F, −J v₀/w)),   w = J M⁻¹ Jᵀ,
//! ```
//!
//! v₀ being the velocity that all else leaves. Either J v = 0, or p has its greatest size and opposes J v: p J v ≤ 0, so that no
//! energy is made, at any h. It has no error to take out of positions. The multiplier is carried, so that what sticks goes on to.
//!
//! **About a point** the torque is a vector, |f| ≤ F, and where it slides f = −F ω/|ω| with ω the spin of B against A. Rows have bounds
//! of their own, so the ball |p| ≤ h F is met by a frame d, e₁, e₂ that follows what is carried: while it sticks, d = p/|p| with the full
//! bound and √((h F)² − |p|²) across; while it slides, d = ω/|ω| and nothing across. What ω turns by in a substep is not felt
//! within it: of first order in h, and p J v ≤ 0 as before.

use glam::DVec3;

use super::row_sink::RowSink;
use super::rows::{Demand, Jacobian, Phase, ScalarRow, SoftParams};
use crate::joint::{JointDef, JointKind, Limits};
use crate::joint_record::MAX_SCALAR_ROWS;

/// Multiplier of the friction of axis 0; those of a six-axis joint follow.
pub(crate) const OF_AXES: u8 = 18;

/// Of friction about a point: its multipliers are one vector, that of directions, of which the joint has no others.
pub(crate) const ABOUT_POINT: u8 = MAX_SCALAR_ROWS as u8;

/// Share of its bound from which a carried multiplier is one that slides.
const SLIDES: f64 = 0.999;

/// Spin below which its direction is not that of anything that slides (rad/s).
const MIN_SPIN: f64 = 1.0e-4;

/// Rows of friction that a joint has.
pub(crate) fn rows_of(def: &JointDef) -> u32 {
    match &def.kind {
        JointKind::Hinge { limits, .. } | JointKind::Prismatic { limits, .. } => u32::from(acts(def.friction, limits)),
        JointKind::Spherical { .. } => {
            if def.friction > 0.0 {
                3
            } else {
                0
            }
        }
        JointKind::Generic { linear, angular } => {
            let axes = linear.iter().chain(angular).zip(def.axis_friction);
            axes.map(|(axis, friction)| u32::from(acts(friction, &axis.limits))).sum()
        }
        JointKind::Fixed | JointKind::Distance { .. } => 0,
    }
}

/// The multiplier of the motor on the coordinate whose friction has this one.
pub(super) fn motor_beside(id: u8) -> Option<u8> {
    (OF_AXES..ABOUT_POINT).contains(&id).then(|| 3 * (id - OF_AXES) + 2)
}

/// Bounds of what acts either way.
fn both_ways(most: f64) -> [f64; 2] {
    [-most, most]
}

/// Whether a coordinate with these limits is free to rub.
fn acts(friction: f32, limits: &Limits) -> bool {
    friction > 0.0 && limits.min < limits.max
}

impl RowSink<'_> {
    /// Adds the friction of a coordinate, the first of its joint or that of axis `axis`, after its motor.
    pub(super) fn rub(&mut self, jacobian: Jacobian, friction: f32, limits: Limits, axis: u8) {
        if acts(friction, &limits) && !self.is_in_place() {
            let demand = Demand::Speed { target: 0.0, bounds: both_ways(f64::from(friction) * self.phase.h()) };
            self.scalar(jacobian, demand, SoftParams::rigid(self.phase), OF_AXES + axis);
        }
    }

    /// Adds the friction of all rotation.
    pub(super) fn rub_about_point(&mut self, friction: f32) {
        if friction <= 0.0 || self.is_in_place() {
            return;
        }
        let most = f64::from(friction) * self.phase.h();
        let carried = self.impulses.angular.as_dvec3() * self.share;
        let size = carried.length();
        let spin = self.rates.bodies[1].angular - self.rates.bodies[0].angular;
        let speed = spin.length();
        let slides = speed > MIN_SPIN && (size >= SLIDES * most || size == 0.0);
        let along = if slides { spin / speed } else { carried.try_normalize().unwrap_or(self.geometry.gradient.axes_a().x_axis) };
        self.rub_about(along, most, carried);
        if !slides {
            let (u, v) = along.any_orthonormal_pair();
            let across = (most * most - size * size).max(0.0).sqrt();
            self.rub_about(u, across, carried);
            self.rub_about(v, across, carried);
        }
    }

    fn rub_about(&mut self, axis: DVec3, max_impulse: f64, carried: DVec3) {
        let demand = Demand::Speed { target: 0.0, bounds: both_ways(max_impulse) };
        let (jacobian, give, impulse) = (Jacobian::angular(axis), SoftParams::rigid(self.phase), carried.dot(axis) as f32);
        self.scalars.push(ScalarRow::new(&self.rates, 0.0, jacobian, demand, give, ABOUT_POINT, impulse));
    }

    /// Whether errors are to be taken out of positions.
    fn is_in_place(&self) -> bool {
        matches!(self.phase, Phase::Position { .. })
    }
}
