//! Motors without a greatest force that meet what has none either: they give way.

use super::passes::{Effort, copy};
use super::problem::{JointBlock, PROXIMITY, Problem, rate, speed};
use super::term::{Law, Term};
use crate::solve::joint::rows::MAX_RECOVERY_SPEED;
use crate::tuning::overruled::{FLUNG, GIVE, OVERRULED_COMPLIANCE, STRAINED};

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
    pub(super) fn solve_or_yield(&mut self, h: f64, budget: u32) -> Effort {
        let Some(asked) = self.asked_without_bound() else { return self.solve(budget) };
        copy(&self.terms, &mut self.room.first_terms);
        Self::save_impulses(&self.links, &mut self.room.first_impulses);
        let mut effort = self.solve(budget);
        let is_flung = self.flings(h);
        if !is_flung && self.missed() <= MISSED[0] * asked.min(MAX_RECOVERY_SPEED) + MISSED[1] {
            return effort;
        }
        let give = if is_flung { OVERRULED_COMPLIANCE } else { GIVE };
        copy(&self.room.first_terms, &mut self.terms);
        Self::restore_impulses(&mut self.links, &self.room.first_impulses);
        self.is_base_stale = true;
        let Self { links, terms, before, .. } = self;
        for link in links {
            for row in (0..link.rows).filter(|row| link.boundless & 1 << row != 0) {
                let has = rate(link.bodies, [&link.jacobian[0][row], &link.jacobian[1][row]], before);
                if !is_flung {
                    link.bias[row] = modest(link.bias[row], has);
                }
                link.give[row] = give / PROXIMITY * link.proximity[row];
            }
        }
        for term in terms.iter_mut().filter(|term| term.is_boundless()) {
            if !is_flung {
                term.bias[0] = modest(term.bias[0], speed(term, before)[0]);
            }
            term.give = give * term.ease;
        }
        effort.is_capped = false;
        effort.add(self.solve(budget));
        effort
    }

    /// Whether a body turns by more in a substep of length `h` (s) than that resolves, as motors near a dead centre would have it: such as
    /// would miss what they ask for if they yielded.
    fn flings(&self, h: f64) -> bool {
        let turns =
            self.velocity.iter().zip(&self.free).map(|(now, free)| (3..6).map(|i| (now[i] - free[i]).powi(2)).sum::<f64>());
        if turns.fold(0.0, f64::max) * h * h <= FLUNG * FLUNG {
            return false;
        }
        // What holds something where it is flings nothing.
        let strains = |impulse: f64, ease: f64, asked: f64| {
            asked.abs() > MISSED[1] && OVERRULED_COMPLIANCE * ease * impulse.abs() > STRAINED * asked.abs()
        };
        let is_strained = |link: &JointBlock| {
            let mut rows = (0..link.rows).filter(|row| link.boundless & 1 << row != 0);
            rows.any(|row| strains(link.impulse[row], link.proximity[row] / PROXIMITY, link.bias[row]))
        };
        let mut terms = self.terms.iter().filter(|term| term.is_boundless());
        self.links.iter().any(is_strained) || terms.any(|term| strains(term.impulse[0], term.ease, term.bias[0]))
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
