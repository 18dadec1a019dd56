//! Rows that repeat others, and how a factorisation is guarded against them.
//!
//! A direction y in multipliers with Jᵀ y = 0 has no multiplier of its own: p = −y·(J v₀ + b)/ε, with ε what is added to the diagonal.
//! Joints gape by 1e-6 of a lever, so that Jᵀ y is of that order where rows should repeat each other exactly: with ε no greater than
//! its square they hold bodies that should move, and push against each other with a thousand times the weight of these. Yet a straight
//! line of joints between two ends is such a direction too, and all that carries what lies on it; what ε lets through opens them.
//!
//! They are told apart by the rows that take part. In a planar loop of hinges what repeats is along their axes and about the others,
//! never across the axes, unless these lie in one plane: that is the line. With more than one loop it may be (six bars of a platform).

/// What a row may repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Repeats {
    /// Where joints close a loop, any other.
    Often,
    /// Those along a straight line of hinges: a row across the axis of one, where joints close one loop.
    InLine,
    /// Those of a straight line of joints, or between the same two bodies: a row of a joint that holds points and nothing else.
    Points,
}

/// Shares of a row's diagonal: what is added to it, and the pivot up to which the row is left without a multiplier.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Guard {
    pub added: f64,
    pub noise: f64,
}

impl Guard {
    /// Where joints close no loop, no row repeats another, and as much as rounding is enough.
    const TREE: Self = Self { added: 1.0e-13, noise: 1.0e-14 };

    /// Rows that repeat each other (a closed planar loop has three, a door's second hinge five) share their multiplier.
    const OFTEN: Self = Self { added: 1.0e-7, noise: 1.0e-14 };

    const IN_LINE: Self = Self { added: 1.0e-12, noise: 1.0e-14 };

    /// Points held between the same two bodies (a door on two of them) leave pivots of 1e-12. Those of taut bridges are 1e-8 and more.
    const POINTS: Self = Self { added: 1.0e-12, noise: 1.0e-10 };

    /// By [`Repeats`], where joints close so many loops.
    pub(super) fn all(loops: usize) -> [Self; 3] {
        if loops == 0 { [Self::TREE; 3] } else { [Self::OFTEN, Self::IN_LINE, Self::POINTS] }
    }
}
