//! Motors without a greatest force that meet what has none either: they give way.

use super::passes::{Effort, copy};
use super::problem::{PROXIMITY, Problem, speed};
use super::term::{Law, Term};
use crate::tuning::overruled::GIVE;

/// Share of what they ask for, and speed beside it (m/s, rad/s), by which rows that hold may miss: of contradictions they miss as much as is
/// asked for, of what a solve leaves else a thousandth (`SETTLED`).
const MISSED: [f64; 2] = [0.02, 5.0e-3];

impl Problem {
    /// Solves as [`solve`](Self::solve); where that leaves rows which contradict motors without a bound, once more with those yielding.
    pub(super) fn solve_or_yield(&mut self, budget: u32) -> Effort {
        let Some(asked) = self.asked_without_bound() else { return self.solve(budget) };
        copy(&self.terms, &mut self.room.first_terms);
        copy(&self.links, &mut self.room.first_links);
        let mut effort = self.solve(budget);
        if self.missed() <= MISSED[0] * asked + MISSED[1] {
            return effort;
        }
        copy(&self.room.first_terms, &mut self.terms);
        copy(&self.room.first_links, &mut self.links);
        for link in &mut self.links {
            for row in (0..link.rows).filter(|row| link.boundless & 1 << row != 0) {
                link.give[row] = GIVE / PROXIMITY * link.proximity[row];
            }
        }
        for term in self.terms.iter_mut().filter(|term| term.is_boundless()) {
            term.give = GIVE * term.ease;
        }
        effort.is_capped = false;
        effort.add(self.solve(budget));
        effort
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
