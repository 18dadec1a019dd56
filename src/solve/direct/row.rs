//! One row of an articulation's system.

use glam::DVec3;

use super::body::DirectBody;
use super::redundancy::Redundancy;
use crate::solve::joint::rows::{self, Rate};

/// Greatest multiplier that bodies can ask for: the greatest mass at the greatest speed (N·s). Rows that nothing can fulfil, as those
/// of a body that is moved away from one with locked axes, have some that rise without end.
pub(super) const MAX_IMPULSE: f64 = 1.0e16;

/// Share of a bound from which on a multiplier is at it.
const NEAR: f64 = 0.999;

/// Whether a row with bounds is part of the system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RowState {
    Free,
    Low,
    High,
    /// Takes no part in this phase.
    Absent,
}

/// Where the multiplier of a row comes from and goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// Along a direction of the block of points: its linear part on B.
    Point,
    /// Along a direction of the block of directions: its angular part on B.
    Direction,
    /// A scalar row, by number.
    Scalar(u8),
    /// Across the line of a distance joint that pulls.
    Across,
    /// A row of a contact.
    Contact,
}

/// One row: J v = Σ linear·v + angular·ω over the two bodies of its node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub origin: Origin,
    pub linear: [DVec3; 2],
    pub angular: [DVec3; 2],
    pub bias: f64,
    /// As [`rows::ScalarRow::driven`].
    pub(super) driven: f64,
    pub(super) gamma: f64,
    pub(super) min: f64,
    pub(super) max: f64,
    pub impulse: f64,
    pub(super) state: RowState,
    pub(super) repeats: Redundancy,
    /// Whether it is that of a motor or of friction, which give way to what has no bound; and γ with which one without a bound does.
    pub(super) drives: bool,
    pub(super) give: f64,
}

impl Row {
    pub(super) fn of(jacobian: &rows::Jacobian, origin: Origin) -> Self {
        Self {
            origin,
            linear: [-jacobian.linear, jacobian.linear],
            angular: [-jacobian.angular_a, jacobian.angular_b],
            ..Self::EMPTY
        }
    }

    pub(super) const EMPTY: Self = Self {
        origin: Origin::Contact,
        linear: [DVec3::ZERO; 2],
        angular: [DVec3::ZERO; 2],
        bias: 0.0,
        driven: 0.0,
        gamma: 0.0,
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        impulse: 0.0,
        state: RowState::Free,
        repeats: Redundancy::Often,
        drives: false,
        give: 0.0,
    };

    pub(super) fn rate(&self, [a, b]: &[Rate; 2]) -> f64 {
        self.linear[0].dot(a.linear)
            + self.angular[0].dot(a.angular)
            + self.linear[1].dot(b.linear)
            + self.angular[1].dot(b.angular)
    }

    /// Whether its multiplier is bounded on either side.
    pub(super) fn has_bounds(&self) -> bool {
        self.min > f64::NEG_INFINITY || self.max < f64::INFINITY
    }

    /// What a multiplier of one changes its own rate by, J M̃⁻¹ Jᵀ.
    pub(super) fn response(&self, bodies: [&DirectBody; 2]) -> f64 {
        let own = |side: usize| {
            (bodies[side].inverse_mass * self.linear[side]).dot(self.linear[side])
                + (bodies[side].inverse_inertia * self.angular[side]).dot(self.angular[side])
        };
        own(0) + own(1)
    }

    /// The same without the stiffness of what its bodies hang on, which grows with the force: a motor that pushed by it would push ever harder.
    pub(super) fn own_response(&self, bodies: [&DirectBody; 2]) -> f64 {
        (0..2).map(|side| bodies[side].own_response(self.linear[side], self.angular[side])).sum()
    }

    /// Whether the row is a stop's, which pushes and does not pull.
    pub(super) fn is_stop(&self) -> bool {
        self.min == 0.0 && self.max == f64::INFINITY && !self.drives
    }

    /// Whether the row is that of a motor that pushes one way alone.
    pub(super) fn drives_one_way(&self) -> bool {
        self.drives && (self.min == 0.0) != (self.max == 0.0)
    }

    /// Whether a multiplier is the greatest that it may have, either way, but for the rounding of those that are carried.
    pub(super) fn is_at_bound(&self, impulse: f64) -> bool {
        (self.max > 0.0 && impulse >= NEAR * self.max) || (self.min < 0.0 && impulse <= NEAR * self.min)
    }

    pub(super) fn fix(&mut self, impulse: f64) {
        self.impulse = impulse;
        self.state = RowState::High;
    }
}

/// Rows of friction of a manifold.
pub(crate) const FRICTION_ROWS: u32 = 3;

/// Rows of one manifold, by number: normals, then two of friction and one about the normal where there is friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactRows {
    pub node: u32,
    pub first: u32,
    pub normals: u32,
    pub has_friction: bool,
    /// Coefficient of friction, and torque limit per normal force (m).
    pub friction: f64,
    pub twist_arm: f64,
}

impl ContactRows {
    pub(super) fn count(&self) -> u32 {
        self.normals + if self.has_friction { FRICTION_ROWS } else { 0 }
    }
}
