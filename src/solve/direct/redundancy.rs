//! Redundant rows, and how the factorisation is regularised against them.
//!
//! A direction y in multipliers with Jᵀ y = 0 has no multiplier of its own: p = −y·(J v₀ + b)/ε, with ε what is added to the diagonal.
//! Joints gape by 1e-6 of a lever, so that Jᵀ y is of that order where rows should repeat each other exactly: with ε no greater than
//! its square they hold bodies that should move, and push against each other with a thousand times the weight of these. Yet a straight
//! line of joints between two ends is such a direction too, and all that carries what lies on it; what ε lets through opens them.
//!
//! Which rows may repeat others follows from the loops that joints close: see [`super::loops`]. What remains in a multiplier of what rows
//! contradict each other by is taken out once it is solved for ([`super::refine`]).

/// Joints that hold points, in loops, from which on less is added to their diagonal, by the square of how many times as many they are: the
/// share of a residual that a solve leaves to refinement goes with the square of the joints in a row. And the least that is, short of rounding.
const MANY: f64 = 2000.0;
const LEAST_ADDED: f64 = 1.0e-14;

/// What a row may repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Redundancy {
    /// Where joints close a loop, any other.
    Often,
    /// Those along a straight line of hinges: a row across the axis of one, where joints close one loop and are planar or lie in a line.
    InLine,
    /// Those of a straight line of joints, or between the same two bodies: a row of a joint that holds points and nothing else.
    Points,
    /// A stop that presses, or a motor: friction of a joint.
    Idly,
}

/// Shares of a row's diagonal: what is added to it, and the pivot up to which the row is left without a multiplier.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Regularization {
    pub added: f64,
    pub noise: f64,
}

impl Regularization {
    /// Where joints close no loop, no row repeats another, and as much as rounding is enough.
    const TREE: Self = Self { added: 1.0e-13, noise: 1.0e-14 };

    /// Rows that repeat each other (a closed planar loop has three, a door's second hinge five) share their multiplier.
    const OFTEN: Self = Self { added: 1.0e-7, noise: 1.0e-14 };

    const IN_LINE: Self = Self { added: 1.0e-12, noise: 1.0e-14 };

    /// Points held between the same two bodies (a door on two of them) leave pivots of 1e-12. Those of taut bridges are 1e-8 and more.
    const POINTS: Self = Self { added: 1.0e-12, noise: 1.0e-10 };

    /// In several loops, which repeat each other as four ropes of one platform do, and where their loads say what else
    /// counts as nothing ([`super::ball_joint_system`]). One loop repeats nothing but its own line where that is straight.
    const PARALLEL_POINTS: Self = Self { added: 1.0e-13, noise: 1.0e-10 };

    /// Friction leaves to others what they hold as well: in a tree what it takes of that is a hundred-thousandth.
    const IDLY: Self = Self { added: 1.0e-8, noise: 1.0e-14 };

    /// By [`Redundancy`], where so many joints close so many loops.
    pub(super) fn all(joints: usize, loops: usize) -> [Self; 4] {
        let many = (joints as f64 / MANY).max(1.0);
        let points = if loops > 1 { Self::PARALLEL_POINTS } else { Self::POINTS };
        let points = Self { added: (points.added / (many * many)).max(LEAST_ADDED), ..points };
        let [often, in_line, points] = if loops == 0 { [Self::TREE; 3] } else { [Self::OFTEN, Self::IN_LINE, points] };
        [often, in_line, points, Self::IDLY]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_is_added_the_more_points_are_held() {
        let added = |joints, loops| Regularization::all(joints, loops)[Redundancy::Points as usize].added;
        assert_eq!([added(3, 1), added(2_000, 1)], [1.0e-12; 2], "of few joints");
        assert!((added(4_000, 1) - 0.25e-12).abs() < 1.0e-18, "of twice as many {:e}", added(4_000, 1));
        assert!((added(200_000, 1) - 1.0e-14).abs() < 1.0e-20, "of ever more {:e}", added(200_000, 1));
        assert!((added(200_000, 3) - 1.0e-14).abs() < 1.0e-20, "in several loops {:e}", added(200_000, 3));
        assert_eq!(added(3, 3), 1.0e-13, "of few in several loops");
        assert_eq!(added(200_000, 0), Regularization::TREE.added, "where no loop is closed");
    }
}
