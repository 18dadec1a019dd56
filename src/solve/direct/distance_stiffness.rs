//! Geometric stiffness of distance joints: how their pull turns with the line between their points.
//!
//! A pull T along a line of length L, whose ends move apart across it by d, turns by d/L and has T d/L across: a spring of stiffness
//! T/L for both bodies. An implicit step of length h sees it as rows across the line,
//!
//! ```text
//! J v + γ p = 0,    γ = L/(h² T),
//! ```
//!
//! two for each joint. Without them light beads on a taut rope are unstable from κ = h² T (1/m_a + 1/m_b)/L ≈ 1 on: 0.1 kg each
//! under a tonne have κ = 7 at the default substep. What a pull does as its levers turn is that of any other joint
//! ([`super::stiffness`]); pushes buckle, and have none of it.

use glam::DVec3;

use super::body::DirectBody;
use super::row::{Origin, Row};
use crate::solve::joint::JointEntry;
use crate::solve::joint::geometry::Placement;
use crate::solve::joint::rows::{Jacobian, Phase, Rate};

/// Length below which a line has no direction (m).
const MIN_LENGTH: f64 = 1.0e-6;

/// Share of the lighter body's mass below which what a line holds across it is not worth a row.
const NEGLIGIBLE: f64 = 0.01;

/// Line of a distance joint that pulls: impulse of its pull in the last substep (N·s), direction from A to B, and length (m).
pub(super) struct DistanceLine {
    pub pull: f64,
    pub direction: DVec3,
    pub length: f64,
}

impl DistanceLine {
    /// That of a joint with this gap from A's point to B's, if it is a distance joint and pulls.
    pub(super) fn of(entry: &JointEntry, gap: DVec3) -> Option<Self> {
        let pull = pull(entry);
        let length = gap.length();
        (pull > 0.0 && length > MIN_LENGTH).then(|| Self { pull, direction: gap / length, length })
    }

    /// Stiffness across the line over that of the bodies' inertia at which a substep of length `h` is its inverse, per impulse:
    /// κ/(h p) (1/(kg·m)).
    pub(super) fn ease(&self, bodies: [&DirectBody; 2]) -> f64 {
        bodies.map(lightness).iter().sum::<f64>() / self.length
    }
}

/// Impulse with which a distance joint pulls its points together (N·s): upper stop less lower stop, motor and spring.
pub(super) fn pull(entry: &JointEntry) -> f64 {
    if !entry.is_distance {
        return 0.0;
    }
    let [lower, upper, motor, spring] = [0, 1, 2, 3].map(|id| f64::from(entry.impulses.scalar[id]));
    upper - lower - motor - spring
}

/// Inverse mass of a body (1/kg).
fn lightness(body: &DirectBody) -> f64 {
    body.inverse_mass.max_element()
}

/// The two rows across the line of a joint at `placement`, which pulls with `tension` (h² T, kg·m).
pub(super) fn rows(
    placement: &Placement,
    tension: f64,
    bodies: [&DirectBody; 2],
    rates: &[Rate; 2],
    phase: Phase,
) -> Option<[Row; 2]> {
    let length = placement.gap.length();
    if tension * bodies.map(lightness).iter().sum::<f64>() <= NEGLIGIBLE * length || length <= MIN_LENGTH {
        return None;
    }
    let (u, v) = crate::solve::joint::rows::across(placement.gap / length);
    Some([u, v].map(|axis| {
        let jacobian =
            Jacobian { linear: axis, angular_a: placement.a.lever.cross(axis), angular_b: placement.b.lever.cross(axis) };
        let mut row = Row::of(&jacobian, Origin::Across);
        // A line that is taken where it is predicted has turned already by what the bodies do without the joints.
        row.bias = if matches!(phase, Phase::Velocity { .. }) { -row.rate(rates) } else { 0.0 };
        row.gamma = length / tension;
        row
    }))
}
