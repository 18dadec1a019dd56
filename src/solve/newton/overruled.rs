//! Motors without a greatest force that meet what has none either: they give way.

use super::passes::{Effort, copy};
use super::problem::{PROXIMITY, Problem, rate, speed};
use super::term::{Law, Term};
use crate::solve::joint::rows::MAX_RECOVERY_SPEED;
use crate::tuning::overruled::GIVE;

/// Share of what they ask for, and speed beside it (m/s, rad/s), by which rows that hold may miss: of contradictions they miss as much as is
/// asked for, of what a solve leaves else a thousandth (`SETTLED`).
const MISSED: [f64; 2] = [0.02, 5.0e-3];

/// What a motor that yields asks for, where it has this speed: a servo is a substep away from its target, at hundreds of metres a second, and pushes
/// against what it meets with as much more than tells rows apart. One that follows reaches any speed in a few substeps.
fn modest(asked: f64, has: f64) -> f64 {
    let most = MAX_RECOVERY_SPEED + 2.0 * has.abs();
    asked.clamp(-most, most)
}

impl Problem {
    /// Solves as [`solve`](Self::solve); where that leaves rows which contradict motors without a bound, once more with those yielding.
    pub(super) fn solve_or_yield(&mut self, budget: u32) -> Effort {
        let Some(asked) = self.asked_without_bound() else { return self.solve(budget) };
        copy(&self.terms, &mut self.room.first_terms);
        Self::save_impulses(&self.links, &mut self.room.first_impulses);
        let mut effort = self.solve(budget);
        if self.missed() <= MISSED[0] * asked.min(MAX_RECOVERY_SPEED) + MISSED[1] {
            return effort;
        }
        copy(&self.room.first_terms, &mut self.terms);
        Self::restore_impulses(&mut self.links, &self.room.first_impulses);
        let Self { links, terms, before, .. } = self;
        for link in links {
            for row in (0..link.rows).filter(|row| link.boundless & 1 << row != 0) {
                let has = rate(link.bodies, [&link.jacobian[0][row], &link.jacobian[1][row]], before);
                link.bias[row] = modest(link.bias[row], has);
                link.give[row] = GIVE / PROXIMITY * link.proximity[row];
            }
        }
        for term in terms.iter_mut().filter(|term| term.is_boundless()) {
            term.bias[0] = modest(term.bias[0], speed(term, before)[0]);
            term.give = GIVE * term.ease;
        }
        effort.is_capped = false;
        effort.add(self.solve(budget));
        effort
    }

    /// Whether any motor has no bound.
    pub(super) fn has_boundless(&self) -> bool {
        self.asked_without_bound().is_some()
    }

    /// The greatest speed that a motor without a bound asks for (m/s, rad/s); none where there are no such motors.
    fn asked_without_bound(&self) -> Option<f64> {
        let of_links = self
            .links
            .iter()
            .flat_map(|link| (0..link.rows).filter(|row| link.boundless & 1 << row != 0).map(|row| link.bias[row].abs()));
        let of_terms = self.terms.iter().filter(|term| term.is_boundless()).map(|term| term.bias[0].abs());
        of_links.chain(of_terms).reduce(f64::max)
    }

    /// The greatest speed by which rows that hold have been missed (m/s, rad/s); motors are among them.
    fn missed(&self) -> f64 {
        let closing = |term: &Term| {
            let holds = term.give == 0.0 && term.law == Law::Between(0.0, f64::INFINITY);
            if holds { -(speed(term, &self.velocity)[0] + term.bias[0]) } else { 0.0 }
        };
        self.terms.iter().map(closing).fold(self.strain(), f64::max)
    }
}
