//! Decides from the solver's result whether a contact sticks or slides: friction multiplier, friction limit, slip.
//!
//! The paper asks for |f_t| < μ f_n. A multiplier at its limit is not enough to tell: internal stress saturates contacts that do
//! not move at all. So a contact slides if its friction is at the limit *and* it slips; it holds again when the slip is gone.

use glam::Vec3;

use crate::contact::status::{ContactStatus, StatusThresholds};
use crate::tuning::support::{HOLDING_SPEED, LEAVING_SPEED, RESTING_SPEED, SLIDING_SPEED};

/// The solver's word on a manifold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slip {
    /// Speed of the surfaces across each other at the manifold's centre (m/s).
    pub slip: f32,
    /// Speed along the normal (m/s), of either sign.
    pub approach: f32,
    /// Whether friction is below its limit.
    pub has_reserve: bool,
}

impl Slip {
    /// Whether the manifold holds, given whether it held before.
    pub(crate) fn holds(&self, held: bool) -> bool {
        let speed = self.slip.max(self.approach.abs());
        if held {
            speed <= LEAVING_SPEED && (self.slip <= SLIDING_SPEED || self.has_reserve)
        } else {
            self.slip <= HOLDING_SPEED && speed <= RESTING_SPEED
        }
    }

    /// What the solver is to tell manifolds by.
    pub(crate) fn limits(up: Vec3, rise: f32, reserve: f32) -> StatusThresholds {
        let (slips, speeds) = ([HOLDING_SPEED, SLIDING_SPEED], [RESTING_SPEED, LEAVING_SPEED]);
        StatusThresholds { up, rise, slips, speeds, reserve }
    }

    /// As [`holds`](Self::holds), by what the solver has told by [`limits`](Self::limits).
    pub(crate) fn told_to_hold(told: ContactStatus, held: bool) -> bool {
        if held {
            told.is_slower(1) && (told.slips_less(1) || told.has_reserve())
        } else {
            told.slips_less(0) && told.is_slower(0)
        }
    }

    /// Whether a manifold holds, where that needs no more than bounds of the speed of its surfaces; `has_reserve` says
    /// whether friction is below its limit.
    pub(crate) fn at_speeds(slowest: f32, fastest: f32, held: bool, has_reserve: impl FnOnce() -> bool) -> Option<bool> {
        if fastest <= Self::ALWAYS_HOLDS {
            Some(true)
        } else if slowest > std::f32::consts::SQRT_2 * if held { LEAVING_SPEED } else { RESTING_SPEED } {
            // Along the normal or across it, it is faster than the limit then.
            Some(false)
        } else if held && fastest <= LEAVING_SPEED && (fastest <= SLIDING_SPEED || has_reserve()) {
            Some(true)
        } else {
            None
        }
    }

    /// Speed up to which a manifold that held before holds, whatever its friction is (m/s).
    pub(crate) const STILL_HOLDS: f32 = SLIDING_SPEED;

    /// Speed up to which a manifold that held before and has friction in reserve holds (m/s).
    pub(crate) const LEAVES: f32 = LEAVING_SPEED;

    /// Speed up to which a manifold is found to hold whatever it did before and whatever its friction is (m/s).
    pub(crate) const ALWAYS_HOLDS: f32 = HOLDING_SPEED;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sliding_has_hysteresis() {
        let at = |slip: f32, friction: f32| Slip { slip, approach: 0.0, has_reserve: friction < 1.0 };
        assert!(at(1e-2, 0.5).holds(true), "friction below its limit holds, whatever the solver left of slip");
        assert!(at(1e-5, 1.0).holds(true), "at its limit without slip");
        assert!(!at(1e-3, 1.0).holds(true));
        assert!(!at(3e-4, 1.0).holds(false) && at(3e-4, 1.0).holds(true), "between the two speeds the last word stays");
        assert!(at(5e-5, 1.0).holds(false));
        assert!(!Slip { approach: -1.0, ..at(0.0, 0.0) }.holds(true), "an impact is not a rest");
    }
}
