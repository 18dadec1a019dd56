//! How heavy bodies are to turn, as far as joints hold them, and what of their stiffness a substep does not resolve for that.
//!
//! A body that turns about a joint, and not about its centre of mass, has to move that too. With a mass m at the lever r from a point that
//! gives way with the response w, it turns as if it had μ (r² 1 − r rᵀ) more, 1/μ = 1/m + w. What moves has its kinetic energy once: of a body with
//! d joints each of them has a d-th of m, and of what the other body has, of d' joints, one share of d' + 1, as its own turning needs one. A bob on a
//! block that stands turns about its hinge; the links of a chain, which lean against what is no heavier, turn about themselves as before.
//!
//! Not so in loops: whether a net of light rods holds what falls into it at 30 steps a second hangs on all the damping that it has.

use glam::{DMat3, DVec3};

use super::joints::JointAssembly;
use super::problem::{Inverses, Problem};
use super::stiffness::{positive_part, unresolved};
use super::term::FIXED;

impl Problem {
    /// Finds what joints that hold points add to the inertia of each body, into `room.pivots`; nothing in a loop.
    pub(super) fn find_pivots(&mut self, rows: &[JointAssembly], is_looped: bool) {
        let Self { links, masses, inverses, room, .. } = self;
        let inverses = Inverses { masses, angular: inverses };
        room.sums.clear();
        room.sums.resize(masses.len(), 0.0);
        let holding = || links.iter().zip(rows).filter(|(_, rows)| rows.holds_points && !is_looped);
        for body in holding().flat_map(|(link, _)| link.bodies).filter(|&body| body != FIXED) {
            room.sums[body as usize] += 1.0;
        }
        room.pivots.clear();
        room.pivots.resize(masses.len(), DMat3::ZERO);
        for (link, rows) in holding() {
            for side in (0..2).filter(|&side| link.bodies[side] != FIXED) {
                let [own, other] = [link.bodies[side], link.bodies[1 - side]];
                let joints = |body: u32| if body == FIXED { 0.0 } else { room.sums[body as usize] };
                let [lever, far] = [rows.levers[side], rows.levers[1 - side]];
                let ease = joints(own) / inverses.mass(own) + (joints(other) + 1.0) * inverses.most_ease(other, far);
                let outer = DMat3::from_cols(lever * lever.x, lever * lever.y, lever * lever.z);
                room.pivots[own as usize] += (DMat3::from_diagonal(DVec3::splat(lever.length_squared())) - outer) * ease.recip();
            }
        }
    }

    /// Leaves each body the part of its stiffness against rotation that is positive and that a substep does not resolve.
    pub(super) fn leave_unresolved(&mut self, torques: &[DMat3]) {
        for ((mass, torque), pivot) in self.masses.iter_mut().zip(torques).zip(&self.room.pivots) {
            mass.stiffness = if *torque == DMat3::ZERO {
                [[0.0; 3]; 3]
            } else {
                unresolved(positive_part(*torque), DMat3::from_cols_array_2d(&mass.angular) + *pivot).to_cols_array_2d()
            };
        }
    }
}

impl Inverses<'_> {
    /// Mass of a body, along the axis along which it is lightest (kg).
    fn mass(&self, body: u32) -> f64 {
        let [x, y, z] = self.masses[body as usize].linear;
        x.min(y).min(z)
    }

    /// Greatest response of a body to a push at this lever, at most (1/kg); none of what rows do not move.
    fn most_ease(&self, body: u32, lever: DVec3) -> f64 {
        if body == FIXED {
            return 0.0;
        }
        let answer = self.angular[body as usize];
        let trace = answer.x_axis.x + answer.y_axis.y + answer.z_axis.z;
        self.mass(body).recip() + trace * lever.length_squared()
    }
}
