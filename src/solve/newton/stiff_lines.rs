//! Lines of distance joints that are taut: what of their stiffness a substep does not resolve.
//!
//! A line of length l under the tension T holds its ends with k = T/l against going across. As the stiffness of joints against rotation
//! ([`unresolved`](super::stiffness::unresolved)) it is implicit only as far as a substep of length h is too long for it. Implicit stiffness damps:
//! with all of it a bob on a rod loses half its energy in 10 s at 30 steps a second.
//!
//! A body of mass m on which lines pull with Σ k oscillates with h² Σ k/m = s, and in a net one node against the next with s_a + s_b = x, of which
//! leapfrog bears four. The share x²/(1 + x²) of each line is implicit, as of what turns. What is left of the lines of a node is at most
//! h² Σ k/(m (1 + s²)) ≤ ½, of both ends of a line at most one.

use super::problem::{Inverses, Problem};
use super::term::FIXED;

impl Problem {
    /// Leaves of each line, which has two rows across each other, the share of its stiffness that a substep does not resolve.
    pub(super) fn leave_resolved_lines(&mut self) {
        let Self { stiff, masses, inverses, room, .. } = self;
        let inverses = Inverses { masses, angular: inverses };
        let sums = &mut room.sums;
        sums.clear();
        sums.resize(masses.len(), 0.0);
        for line in stiff.chunks_exact(2) {
            for side in (0..2).filter(|&side| line[0].bodies[side] != FIXED) {
                let body = line[0].bodies[side];
                let ease = [0, 1].map(|row: usize| inverses.ease(body, &line[row].jacobian[side]));
                sums[body as usize] += line[0].gain * ease[0].max(ease[1]);
            }
        }
        for line in stiff.chunks_exact_mut(2) {
            let own = |body: u32| if body == FIXED { 0.0 } else { sums[body as usize] };
            let x = own(line[0].bodies[0]) + own(line[0].bodies[1]);
            line.iter_mut().for_each(|row| row.gain *= x * x / (1.0 + x * x));
        }
    }
}
