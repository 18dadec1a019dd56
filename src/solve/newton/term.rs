//! What acts within bounds: normals, friction, stops, motors, dry friction of joints.
//!
//! A term has one row or two. With u = J v + b, λ̄ the impulse that it is expected to have, and a compliance R,
//!
//! ```text
//! y = λ̄ − u/R,      λ = P(y),      G = ∂P/∂y.
//! ```
//!
//! P is the projection on what the term may do: an interval, or a disc. It is the gradient of a convex function, so that all terms
//! together are a convex problem. At rest λ = λ̄, whatever R is: what stands does not creep. R is only the bristle by which λ finds its
//! way to λ̄ = λ.

use super::factor::Vector;

/// Number of a body that rows do not move.
pub(crate) const FIXED: u32 = u32::MAX;

/// What bounds a term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Law {
    /// Its impulse is between these (N·s or N·m·s).
    Between(f64, f64),
    /// It is no longer than this share (or length, m) of the sum of the impulses of `count` terms from `first` on.
    Leaning { first: u32, count: u32, share: f64 },
}

/// One term: see the [module](self).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Term {
    pub bodies: [u32; 2],
    /// Rows: one or two.
    pub rows: usize,
    pub law: Law,
    /// By side and row.
    pub jacobian: [[Vector; 2]; 2],
    pub bias: [f64; 2],
    /// Mean of J M⁻¹ Jᵀ (1/kg or 1/(kg·m²)).
    pub ease: f64,
    /// Compliance of its own, where it gives; it has no expected impulse then.
    pub give: f64,
    /// R.
    pub compliance: f64,
    pub expected: [f64; 2],
    /// y and λ.
    pub argument: [f64; 2],
    pub impulse: [f64; 2],
    /// u.
    pub speed: [f64; 2],
    /// G along `slide` and across it.
    pub gain: [f64; 2],
    pub slide: [f64; 2],
    /// Greatest length of a term that leans on others, as of the last outer pass.
    pub radius: f64,
    /// Of a contact's normal: what of its bias is the way to go before it touches (m/s), its restitution, and what it has been hit with in an
    /// impact (N·s).
    pub ahead: f64,
    pub restitution: f64,
    pub hit: f64,
    /// By how much positions are to be pushed along its first row (m).
    pub push: f64,
    /// Whether the argument is that of the last substep.
    pub is_known: bool,
}

impl Term {
    pub(crate) fn new(bodies: [u32; 2], rows: usize, law: Law) -> Self {
        Self {
            bodies,
            rows,
            law,
            jacobian: [[[0.0; 6]; 2]; 2],
            bias: [0.0; 2],
            ease: 0.0,
            give: 0.0,
            compliance: 0.0,
            expected: [0.0; 2],
            argument: [0.0; 2],
            impulse: [0.0; 2],
            speed: [0.0; 2],
            gain: [0.0; 2],
            slide: [1.0, 0.0],
            radius: 0.0,
            ahead: 0.0,
            restitution: 0.0,
            hit: 0.0,
            push: 0.0,
            is_known: false,
        }
    }

    /// Whether it is that of a motor whose force has no bound on one side: a stop has one that is infinite.
    pub(super) fn is_boundless(&self) -> bool {
        matches!(self.law, Law::Between(least, most) if least == f64::NEG_INFINITY || most == f64::MAX)
    }

    /// Interval of its impulse.
    fn bounds(&self) -> (f64, f64) {
        match self.law {
            Law::Between(least, most) => (least, most),
            Law::Leaning { .. } => (-self.radius, self.radius),
        }
    }

    /// P.
    pub(crate) fn project(&self, y: [f64; 2]) -> [f64; 2] {
        if self.rows == 1 {
            let (least, most) = self.bounds();
            return [y[0].max(least).min(most), 0.0];
        }
        let length = length(y);
        let share = if length <= self.radius { 1.0 } else { self.radius / length };
        [y[0] * share, y[1] * share]
    }

    /// Takes P and G at `y`.
    pub(crate) fn linearize(&mut self, y: [f64; 2]) {
        self.impulse = self.project(y);
        if self.rows == 1 {
            let (least, most) = self.bounds();
            self.gain = [if y[0] > least && y[0] < most { 1.0 } else { 0.0 }, 0.0];
            return;
        }
        let length = length(y);
        if length <= self.radius {
            self.gain = if self.radius > 0.0 { [1.0; 2] } else { [0.0; 2] };
            self.slide = [1.0, 0.0];
        } else {
            self.gain = [0.0, self.radius / length];
            self.slide = [y[0] / length, y[1] / length];
        }
    }

    /// G times a vector.
    pub(crate) fn gained(&self, v: [f64; 2]) -> [f64; 2] {
        if self.rows == 1 {
            return [self.gain[0] * v[0], 0.0];
        }
        let [c, s] = self.slide;
        let (along, across) = ((c * v[0] + s * v[1]) * self.gain[0], (c * v[1] - s * v[0]) * self.gain[1]);
        [c * along - s * across, s * along + c * across]
    }

    /// y at speed u.
    pub(crate) fn argument_at(&self, u: [f64; 2]) -> [f64; 2] {
        [self.expected[0] - u[0] / self.compliance, self.expected[1] - u[1] / self.compliance]
    }

    /// Whether it is at the end of what it may do.
    pub(crate) fn is_at_bound(&self) -> bool {
        if self.rows == 1 {
            let (least, most) = self.bounds();
            return self.expected[0] <= least * NEAR || self.expected[0] >= most * NEAR;
        }
        length(self.expected) >= self.radius * NEAR
    }

    /// Impulse along its first row as far as it is known.
    pub(crate) fn impulse_now(&self) -> f64 {
        if self.give > 0.0 { self.impulse[0] } else { self.expected[0] }
    }

    /// Length of its expected impulse.
    pub(crate) fn size(&self) -> f64 {
        self.expected[0].abs().max(self.expected[1].abs())
    }
}

/// Share of a bound from which on a multiplier, which is carried rounded, is at it.
const NEAR: f64 = 0.999;

pub(crate) fn length(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}
