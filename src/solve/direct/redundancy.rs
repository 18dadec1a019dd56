//! Redundant rows, and how the factorisation is regularised against them.
//!
//! A direction y in multipliers with Jᵀ y = 0 has no multiplier of its own: p = −y·(J v₀ + b)/ε, with ε what is added to the diagonal.
//! Joints gape by 1e-6 of a lever, so that Jᵀ y is of that order where rows should repeat each other exactly: with ε no greater than
//! its square they hold bodies that should move, and push against each other with a thousand times the weight of these. Yet a straight
//! line of joints between two ends is such a direction too, and all that carries what lies on it; what ε lets through opens them.
//!
//! They are told apart by the rows that take part. In a planar loop of hinges what repeats is along their axes and about the others,
//! never across the axes, unless these lie in one plane: that is the line. With more than one loop it may be (six bars of a platform), and
//! where the axes of a loop meet in a point, or are askew, it may be anywhere. So rows across the axes are taken to carry what lies on them
//! in one loop whose axes are parallel, or whose joints lie in a line, if these are so many that they move whatever their axes are: a few
//! that are askew repeat each other wherever they move at all (Bennett's linkage, folded). What remains in a multiplier of what rows contradict each other by is
//! taken out once it is solved for ([`super::refine`]).

use glam::DVec3;

use super::articulation::Articulation;

/// Greatest distance of joints from the line through the two that are furthest apart, over the distance of these, at which they are in line.
/// Pivots of a line go with the square of its slope: a sag of this share leaves them a thousand times what is added elsewhere.
const IN_LINE: f64 = 0.05;

/// Most joints of a loop that moves only if its hinges are special: in general six have no freedom left. And the greatest sine between two
/// axes that count as parallel.
const FEW: usize = 6;
const PARALLEL: f64 = 0.05;

/// Joints that hold points, in loops, from which on less is added to their diagonal, by the square of how many times as many they are: the
/// share of a residual that a solve leaves to refinement goes with the square of the joints in a row. And where that ends, short of rounding.
const MANY: f64 = 2000.0;
const MAX_OVER_MANY: f64 = 10.0;

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

    /// Friction leaves to others what they hold as well: in a tree what it takes of that is a hundred-thousandth.
    const IDLY: Self = Self { added: 1.0e-8, noise: 1.0e-14 };

    /// By [`Redundancy`], where so many joints close so many loops.
    pub(super) fn all(joints: usize, loops: usize) -> [Self; 4] {
        let many = (joints as f64 / MANY).clamp(1.0, MAX_OVER_MANY);
        let points = Self { added: Self::POINTS.added / (many * many), ..Self::POINTS };
        let [often, in_line, points] = if loops == 0 { [Self::TREE; 3] } else { [Self::OFTEN, Self::IN_LINE, points] };
        [often, in_line, points, Self::IDLY]
    }
}

impl Articulation {
    /// Finds, at the poses of now, whether rows across the axes of its hinges carry what lies on them, and whether what rows contradict
    /// each other by is to be taken out of their multipliers. In one planar loop it is not: there it drives nothing, and moderation is a
    /// tenth of its steps.
    pub(super) fn find_loops(&mut self) {
        (self.carries_across, self.system.moderates) = (false, self.topology.loops > 1);
        if self.topology.loops == 1 && !self.is_points {
            let is_planar = self.is_planar();
            self.carries_across = is_planar || (self.entries.len() > FEW && self.is_line());
            self.system.moderates = !is_planar;
        }
    }

    /// Whether its joints lie in a line.
    fn is_line(&mut self) -> bool {
        let Self { entries, links, origins, local_poses, places, .. } = self;
        places.clear();
        places.extend(entries.iter().zip(&*links).map(|(entry, link)| {
            // What does not move may be the joint's own point, of which no origin is told.
            let side = usize::from(link.moves[1]);
            let body = link.bodies[side] as usize;
            origins[body] + local_poses[body].0 + local_poses[body].1 * entry.local_lever[side]
        }));
        let furthest_from = |from: DVec3| {
            let further = |furthest: DVec3, place: &DVec3| {
                let way = *place - from;
                if way.length_squared() > furthest.length_squared() { way } else { furthest }
            };
            places.iter().fold(DVec3::ZERO, further)
        };
        let start = places[0] + furthest_from(places[0]);
        let line = furthest_from(start);
        let most = IN_LINE * line.length_squared();
        places.iter().all(|place| (*place - start).cross(line).length_squared() <= most * most)
    }

    /// Whether the axes of all its hinges are parallel.
    fn is_planar(&self) -> bool {
        let hinges = self.entries.iter().zip(&self.links).filter(|(entry, _)| entry.is_hinge);
        let mut axes =
            hinges.map(|(entry, link)| self.local_poses[link.bodies[0] as usize].1 * (entry.local_frame[0] * DVec3::X));
        let first = axes.next().unwrap_or(DVec3::X);
        axes.all(|axis| axis.cross(first).length_squared() <= PARALLEL * PARALLEL)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_is_added_the_more_points_are_held() {
        let added = |joints| Regularization::all(joints, 3)[Redundancy::Points as usize].added;
        assert_eq!([added(3), added(2_000)], [1.0e-12; 2], "of few joints");
        assert!((added(4_000) - 0.25e-12).abs() < 1.0e-18, "of twice as many {:e}", added(4_000));
        assert!((added(200_000) - 1.0e-14).abs() < 1.0e-20, "of ever more {:e}", added(200_000));
        assert_eq!(
            Regularization::all(200_000, 0)[Redundancy::Points as usize].added,
            Regularization::TREE.added,
            "where no loop is closed"
        );
    }
}
