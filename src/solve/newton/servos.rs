//! What a servo moves, for its braking: by the factor of an island's rows.
//!
//! A servo brakes by what it has set going, which is far more than the bodies of its own joint where these hang on others, or close a loop.
//! Before the rows of a substep are built for good they are factorised on trial, with what joints hold and all servos, which others hold too.
//! With A the matrix, g = 1/R the stiffness of a servo's own row and J its coordinate,
//!
//! ```text
//! u' = A⁻¹ Jᵀ,     w' = J u',     u = u'/(1 − g w'),     w = J u,
//! ```
//!
//! u is what a unit of impulse along J changes of the velocities once its own row is taken out (Sherman and Morrison 1950), w its inverse
//! effective mass, and u·f what forces f accelerate it by. Stops, contacts and friction do not hold: what presses on them may leave them. One
//! factor answers for all servos of an island, and only where one is on its way.

use std::cell::RefCell;

use super::elimination::Elimination;
use super::factor::{Factor, Vector, dot};
use super::problem::{Inverses, Problem, push_along};
use super::term::FIXED;

/// R of a servo that holds, over J M⁻¹ Jᵀ of its own bodies.
/// Why: below it two servos on one freedom are told from a load of a tonne on rods of ten grams; what a solve leaves, 1e-8, is divided by it.
/// Scenes: cylinders of 3 kg under booms of 20, arms of two servos. Test: tests/cranes.rs
const HOLD: f64 = 1.0e-6;

/// Of R, what a coordinate yields by at least that has any freedom beside the other servos: two that drive one freedom each bear it alone.
const FREE: f64 = 10.0;

/// The factor of all that holds, to be asked.
pub(super) struct ServoTrial<'a> {
    pub factor: &'a Factor,
    pub structure: &'a Elimination,
    pub inverses: Inverses<'a>,
    /// Forces on each body (N, N·m), and the number of joints.
    pub forces: &'a [Vector],
    pub joints: usize,
    pub room: RefCell<&'a mut Vec<Vector>>,
}

impl ServoTrial<'_> {
    /// What a unit of impulse along these rows of two bodies changes of its rate (1/kg, 1/(kg·m²)), and what forces accelerate it by (m/s²,
    /// rad/s²), if other servos leave it any freedom; `holds` says whether its own row does.
    pub(super) fn answer(&self, bodies: [u32; 2], rows: &[Vector; 2], holds: bool) -> Option<[f64; 2]> {
        let mut found = self.room.borrow_mut();
        found.clear();
        found.resize(self.forces.len() + self.joints, [0.0; 6]);
        push_along(bodies, [&rows[0], &rows[1]], 1.0, &mut found);
        self.factor.solve(self.structure, &mut found);
        let own: f64 = (0..2).map(|side| self.inverses.ease(bodies[side], &rows[side])).sum();
        let yields: f64 =
            (0..2).filter(|&side| bodies[side] != FIXED).map(|side| dot(&rows[side], &found[bodies[side] as usize])).sum();
        let power: f64 = self.forces.iter().zip(found.iter()).map(|(force, found)| dot(force, found)).sum();
        let share = if holds { 1.0 - yields / (HOLD * own) } else { 1.0 };
        let ease = yields / share;
        (ease > FREE * HOLD * own && ease.is_finite()).then_some([ease, power / share])
    }
}

impl Problem {
    /// Factorises the rows of joints with their servos, the terms of these numbers, which have just been built for a substep of length `h` (s), and
    /// finds the forces on all bodies.
    pub(super) fn try_servos(&mut self, servos: impl Iterator<Item = usize>, h: f64) {
        self.invert_masses();
        self.begin();
        self.terms.iter_mut().for_each(|term| (term.gain, term.compliance) = ([0.0; 2], 1.0));
        for number in servos {
            let term = &mut self.terms[number];
            if term.give == 0.0 {
                (term.gain[0], term.compliance) = (1.0, HOLD * term.ease);
            }
        }
        self.factorize();
        let Self { forces, masses, free, before, .. } = self;
        forces.clear();
        forces.extend(masses.iter().zip(free.iter().zip(&*before)).map(|(mass, (free, before))| {
            let gained: Vector = std::array::from_fn(|i| (free[i] - before[i]) / h);
            mass.times(&gained, 0.0)
        }));
    }
}
