//! Forces that hold one another: a joint that presses a body against what presses back, with nothing that asks for it.
//!
//! Any amount of them is in balance, so that a solve from carried impulses keeps what it finds, and one that did not come to an end may
//! leave much: a block that a slider draws out of a tower was pressed into it by 30 kN under a weight of 0.6 kN, by ever more, and in the
//! end the tower flew apart. So they are let go with a time constant, and at once after a solve that has not come to an end. With the matrix
//! of the last solve,
//!
//! ```text
//! A d = −x Jᵀ λ_n,        δλ = −G J d / R − x λ_n
//! ```
//!
//! is how much of what presses would be there again at once if a share x of it went, at the same velocity but for some R λ. What bears a
//! load is; what only presses back is not.
//!
//! Contacts alone: the tension of ropes and struts that hold one another is what a tower of them stands by.

use super::problem::{Problem, push_term, speed};
use super::term::{Law, Term};
use crate::tuning::stress::{LEAST_PART, TIME_CONSTANT};

impl Term {
    /// Whether it is the normal of a contact that presses.
    fn presses(&self) -> bool {
        matches!(self.law, Law::Between(0.0, _)) && self.impulse[0] > 0.0
    }
}

impl Problem {
    /// Lets forces go that hold one another by contacts, as much of them as go in this time (s). Terms from the first one of contacts on are
    /// theirs.
    pub(crate) fn relax(&mut self, time: f64, contacts: usize) {
        let pressing = self.terms[contacts..].iter().filter(|term| term.presses());
        let most = pressing.map(|term| term.impulse[0]).fold(0.0, f64::max);
        if self.links.is_empty() || most == 0.0 || time == 0.0 {
            return;
        }
        if self.is_stale {
            self.factorize();
        }
        let share = 1.0 / (1.0 + TIME_CONSTANT / time);
        let bodies = self.masses.len();
        let Self { terms, links, unknowns, structure, factor, room, .. } = self;
        unknowns.clear();
        unknowns.resize(bodies, [0.0; 6]);
        let changes = &mut room.targets;
        changes.clear();
        for (number, term) in terms.iter().enumerate() {
            let less = if number >= contacts && term.presses() { term.gained([-share * term.impulse[0], 0.0]) } else { [0.0; 2] };
            push_term(term, less, unknowns);
            changes.push(less);
        }
        unknowns.resize(bodies + links.len(), [0.0; 6]);
        factor.solve(structure, unknowns);
        let mut greatest = 0.0_f64;
        for (number, (term, change)) in terms.iter().zip(&mut *changes).enumerate() {
            let speed = speed(term, unknowns);
            let more = term.gained([-speed[0] / term.compliance, -speed[1] / term.compliance]);
            *change = [change[0] + more[0], change[1] + more[1]];
            if number >= contacts && term.presses() {
                greatest = greatest.max(change[0].abs());
            }
        }
        // What is no number compares as nothing to let go.
        let lets_go = greatest > LEAST_PART * share * most;
        if !lets_go {
            return;
        }
        for (term, change) in terms.iter_mut().zip(&*changes).filter(|(term, _)| term.give == 0.0) {
            term.impulse = [term.impulse[0] + change[0], term.impulse[1] + change[1]];
            if matches!(term.law, Law::Between(0.0, _)) {
                term.impulse[0] = term.impulse[0].max(0.0);
            }
        }
        for (link, found) in links.iter_mut().zip(&unknowns[bodies..]) {
            link.impulse.iter_mut().zip(found).for_each(|(impulse, more)| *impulse -= more);
        }
    }
}
