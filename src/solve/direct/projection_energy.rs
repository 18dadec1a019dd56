//! Takes the potential energy that position correction adds out of the velocities.
//!
//! Velocities of a safe substep gain no energy. Positions are mended after it, and a heavy body that is put back to where its
//! joints and contacts hold it is lifted as often as it is lowered. Where links spin through radians in a substep, or are jammed
//! between a weight and what they lie on, they are mended one way only: the weight rises by centimetres in every step, and falls
//! with more each time. So where an articulation on which nothing does work has gained energy in a step, what it has gained
//! beyond a harmless share, that of all its bodies at [`HARMLESS_SPEED`], is taken from the velocities: v ← √(1 − ΔE/T) v.
//!
//! Smooth substeps hold rows at their end, where forces of joints do work to second order in its length. Where rows repeat others and
//! contradict them there, that is not bounded by the error of the path, and one that gains more than [`MAX_GAIN`] is taken back.

use glam::DVec3;

use super::articulation::Articulation;

/// Speed whose kinetic energy an articulation may gain in a step (m/s): that of a rise by 5 mm; who walks over planks steps up them.
const HARMLESS_SPEED: f64 = 0.3;

/// Share of its kinetic energy that a smooth substep may gain where rows may contradict one another. Errors of a whip, which take back what
/// they give, are up to 1 %; taken back from a thousandth on, they brake what whips.
const MAX_GAIN: f64 = 3.0e-3;

impl Articulation {
    /// Kinetic energy less the work of forces (J), if a smooth substep that raises it is to be taken back.
    pub(super) fn energy_to_keep(&self) -> Option<f64> {
        let may_drive = self.system.moderates && !self.is_points && self.does_no_work();
        may_drive.then(|| self.energy())
    }

    /// Whether the bodies have gained more since they had `before` than a smooth substep may.
    pub(super) fn has_gained(&self, before: f64) -> bool {
        self.energy() - before > MAX_GAIN * self.kinetic_energy()
    }

    /// Takes what the bodies have gained in a step, `gained` (J), out of their velocities, where it is no harmless share; says whether
    /// it has.
    pub(super) fn take_lift(&mut self, gained: f64) -> bool {
        let harmless = || 0.5 * HARMLESS_SPEED * HARMLESS_SPEED * self.bodies.iter().filter_map(|body| body.mass()).sum::<f64>();
        if gained <= 0.0 || self.outcome.safe == 0 || gained <= harmless() || !self.is_left_alone() {
            return false;
        }
        let excess = gained - harmless();
        let kinetic = self.kinetic_energy();
        let kept = (1.0 - excess / kinetic).max(0.0).sqrt();
        for (_, rate) in self.bodies.iter().zip(&mut self.rates).filter(|(body, _)| body.is_dynamic()) {
            rate.linear *= kept;
            rate.angular *= kept;
        }
        true
    }

    /// Whether nothing but forces does work on it, and what it hangs on or touches stands still.
    fn is_left_alone(&self) -> bool {
        (self.hangs || !self.touches.is_empty()) && self.does_no_work()
    }

    /// Whether nothing but forces does work on it: no motor, no spring, nothing that is moved.
    fn does_no_work(&self) -> bool {
        let is_still = self
            .bodies
            .iter()
            .zip(&self.rates)
            .all(|(body, rate)| body.is_dynamic() || (rate.linear, rate.angular) == (DVec3::ZERO, DVec3::ZERO));
        is_still && self.entries.iter().all(|entry| entry.traits.gives_by_motors_alone && !entry.traits.has_motor)
    }
}
