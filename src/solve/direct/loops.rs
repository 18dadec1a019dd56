//! Loops of joints: which rows of an articulation may repeat each other.
//!
//! Rows that repeat each other and rows of a line that carries what lies on it are told apart by the rows that take part. In a planar loop of hinges what repeats is along their axes and about the others,
//! never across the axes, unless these lie in one plane: that is the line. With more than one loop it may be (six bars of a platform), and
//! where the axes of a loop meet in a point, or are askew, it may be anywhere. So rows across the axes are taken to carry what lies on them
//! in one loop whose axes are parallel, or whose joints lie in a line, if these are so many that they move whatever their axes are: a few
//! that are askew repeat each other wherever they move at all (Bennett's linkage, folded).

use glam::DVec3;

use super::articulation::Articulation;

/// Greatest distance of joints from the line through the two that are furthest apart, over the distance of these, at which they are in line.
/// Pivots of a line go with the square of its slope: a sag of this share leaves them a thousand times what is added elsewhere.
const IN_LINE: f64 = 0.05;

/// Most joints of a loop that moves only if its hinges are special: in general six have no freedom left. And the greatest sine between two
/// axes that count as parallel.
const FEW: usize = 6;
const PARALLEL: f64 = 0.05;

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
