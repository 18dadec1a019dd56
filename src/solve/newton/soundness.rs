//! Whether a step that an island has taken may stand.

use super::island::CoupledIsland;
use super::patch::Patch;
use crate::solve::direct::body::DirectBody;
use crate::solve::joint::rows::Rate;

/// Height by which a step may lift all that an island has, beyond what taking errors out of positions does (m): a straight line of planks that
/// snaps taut under tonnes is lifted by as much, ropes and lifts by 1e-7.
const LIFT: f64 = 1.0e-3;

/// Greatest speed at which rows that always hold may be left to part (m/s, rad/s). Where they can hold they do to 1e-7 under ten tonnes on
/// links of a kilogram; the joints of a straight line that is pressed together, which has to bend first, part at 0.03.
const MAX_STRAIN: f64 = 1.0e-3;

/// Levers over which it counts (m): of joints further from centres of mass, as much more.
const STRAINED_LEVERS: [f64; 2] = [1.0, 10.0];

/// Speed that rounding gives to what stands (m/s).
const STANDING: f64 = 1.0e-6;

/// Gap of a joint that a step may open, over the mean distance of joint points from centres of mass. A winch under load opens 0.0002; what
/// is flung about opens as much as it may, where direct solves halve their substeps and leave a fifth of this.
const MAX_GAP: f64 = 3.0e-3;

/// Share of the kinetic energy that is not worth a word.
const ROUNDING: f64 = 1.0e-3;

/// Least and greatest compliance of rows that give way, over their own response: a thousand times that of rows that hold, and what halves a blow.
const GIVES: [f64; 2] = [1.0e-6, 1.0];

impl CoupledIsland {
    /// Kinetic energy less the work of forces since the start of the step (J).
    pub(super) fn energy(&self) -> f64 {
        let bodies = self.bodies.iter().zip(&self.rates).zip(self.local_poses.iter().zip(&self.began));
        bodies.map(|((body, rate), (stance, start))| body.energy(stance, rate, start)).sum()
    }

    /// Whether the step has come to an end, without a gain of energy that nothing has given, and without rows that contradict one another.
    pub(super) fn is_sound(&self) -> bool {
        let moving = self.bodies.iter().filter_map(|body| Some((body.mass()?, body.pull())));
        let unseen: f64 = moving.map(|(mass, pull)| mass * (LIFT * pull + 0.5 * STANDING * STANDING)).sum();
        let lifted = self.outcome.lifted.max(0.0) + unseen;
        let allowed = self.outcome.driven + lifted + ROUNDING * self.outcome.kinetic;
        // Written so that what is no number is not.
        self.outcome.gain <= allowed && self.holds_together(self.outcome.gaps[1])
    }

    /// Whether rows that always hold have held so far, in a step that has left this gap (m) to now: where they have not, what is left of the step
    /// is for nothing.
    pub(super) fn holds_together(&self, gap: f64) -> bool {
        self.parts_slowly() && gap <= self.outcome.gaps[0].max(MAX_GAP * self.held.mean_lever(&self.bodies))
    }

    /// Whether rows that always hold have held.
    fn parts_slowly(&self) -> bool {
        self.outcome.strain <= MAX_STRAIN * self.held.mean_lever(&self.bodies).clamp(STRAINED_LEVERS[0], STRAINED_LEVERS[1])
    }

    /// Whether rows that always hold have not, though no motor without a bound pulls at them: they contradict one another, as those of a straight
    /// line of links do that is pressed together.
    pub(super) fn contradicts(&self) -> bool {
        !self.parts_slowly() && !self.problem.has_boundless()
    }

    /// Compliance, over their own response, with which rows that contradict one another give way in a substep of length `h` (s). A straight
    /// line of n links of length l that is pressed together at the speed u gets as short as it has to within the substep if its links go
    /// aside at √(2 u l/(n h)). At a small angle θ they do at θ u/(ε + n θ²), at most u/2√(n ε): as much with ε = u h/(8 l).
    pub(super) fn give(&self, h: f64) -> f64 {
        let speed = |(body, rate): (&DirectBody, &Rate)| rate.linear.length() + body.pull() * h;
        let fastest = self.bodies.iter().zip(&self.rates).map(speed).fold(0.0, f64::max);
        (fastest * h / (16.0 * self.held.mean_lever(&self.bodies))).clamp(GIVES[0], GIVES[1])
    }

    /// Whether a step that is not sound is to be taken again in halved substeps as it is. Rows that contradict one another do so in shorter ones
    /// too, unless they give way, and what nothing presses on others solve as well.
    pub(super) fn may_halve(&self) -> bool {
        self.parts_slowly() && self.patches.iter().any(Patch::presses)
    }
}
