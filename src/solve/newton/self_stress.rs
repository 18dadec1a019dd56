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
//! is how much of what presses would be there again at once if a share x of it went. What bears a load is, what only presses back is not.
//! Bodies yield by d meanwhile, and what M d asks for in turn is found in the same way: a heavy load is told exactly then.
//!
//! Contacts alone: the tension of ropes and struts that hold one another is what a tower of them stands by. What of it comes from rows that
//! contradict each other by nanometres is no tension.

use super::factor::Vector;
use super::problem::{JointBlock, Problem, push_term, speed};
use super::term::{Law, Term};
use crate::tuning::stress::{LEAST_PART, TIME_CONSTANT, TOLERATED};

/// Solves for what a change asks for in turn. A contact under load yields by up to 1e-3 m/s, a tenth of what gravity adds in a substep of 1 ms:
/// after three a thousandth of a change is left.
const ROUNDS: usize = 3;

/// ε times a multiplier: by how much rows contradict each other if it does nothing else (m/s, rad/s).
fn weighted(link: &JointBlock, multiplier: Vector) -> Vector {
    std::array::from_fn(|row| if row < link.rows { link.proximity[row] * multiplier[row] } else { 0.0 })
}

/// Times that what no body feels is filtered out of multipliers: a taut line has an eigenvalue of A of 0.2 ε and more, of which half and less is
/// left then.
const FILTERS: usize = 4;

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
        let room = &mut self.room;
        let (mut changes, mut pulls) = (std::mem::take(&mut room.targets), std::mem::take(&mut room.residual));
        if self.find_what_goes(share, contacts, LEAST_PART * share * most, (&mut changes, &mut pulls)) {
            for (term, change) in self.terms.iter_mut().zip(&changes).filter(|(term, _)| term.give == 0.0) {
                term.impulse = [term.impulse[0] + change[0], term.impulse[1] + change[1]];
                if matches!(term.law, Law::Between(0.0, _)) {
                    term.impulse[0] = term.impulse[0].max(0.0);
                }
            }
            for (link, pull) in self.links.iter_mut().zip(&pulls) {
                link.impulse.iter_mut().zip(pull).for_each(|(impulse, more)| *impulse += more);
            }
        }
        (self.room.targets, self.room.residual) = (changes, pulls);
    }

    /// Notes what joints bear before a solve.
    pub(crate) fn note_carried(&mut self) {
        Self::save_impulses(&self.links, &mut self.room.carried);
    }

    /// Takes out of what the joints of a loop have come to bear in a solve what no body feels, where they contradict each other by next to
    /// nothing: rows that repeat others fight over nanometres, by ever more from one substep to the next. It is less than a hundredth of the
    /// greatest load where a taut line comes to bear. Of λ − λ̄ it is
    /// ((A + ε)⁻¹ ε)⁴ (λ − λ̄), A = J M̂⁻¹ Jᵀ.
    pub(crate) fn drop_contradictions(&mut self) {
        if self.is_stale {
            self.factorize();
        }
        let bodies = self.masses.len();
        let Self { unknowns, links, structure, factor, room, .. } = self;
        unknowns.clear();
        unknowns.resize(bodies, [0.0; 6]);
        unknowns.extend(
            links
                .iter()
                .zip(&room.carried)
                .map(|(link, carried)| weighted(link, std::array::from_fn(|row| link.impulse[row] - carried[row]))),
        );
        for round in 1..=FILTERS {
            factor.solve(structure, unknowns);
            // The matrix has −ε where A + ε is meant, and gives −δλ.
            unknowns[bodies..].iter_mut().flatten().for_each(|found| *found = -*found);
            if round < FILTERS {
                unknowns[..bodies].fill([0.0; 6]);
                links.iter().zip(&mut unknowns[bodies..]).for_each(|(link, found)| *found = weighted(link, *found));
            }
        }
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |most: f64, value| most.max(value.abs()));
        let strain = most(&mut links.iter().zip(&unknowns[bodies..]).flat_map(|(link, found)| weighted(link, *found)));
        let excess = most(&mut unknowns[bodies..].iter().flatten().copied());
        let load = most(
            &mut links
                .iter()
                .zip(&unknowns[bodies..])
                .flat_map(|(link, found)| (0..link.rows).map(|row| link.impulse[row] - found[row])),
        );
        if strain > TOLERATED || excess <= LEAST_PART * load {
            return;
        }
        for (link, found) in links.iter_mut().zip(&unknowns[bodies..]) {
            link.impulse.iter_mut().zip(found).for_each(|(impulse, excess)| *impulse -= excess);
        }
    }

    /// Finds by how much the impulses of terms and of joints change as a share of what presses goes; whether a contact loses more than
    /// `least` of it.
    fn find_what_goes(
        &mut self,
        share: f64,
        contacts: usize,
        least: f64,
        (changes, pulls): (&mut Vec<[f64; 2]>, &mut Vec<Vector>),
    ) -> bool {
        let bodies = self.masses.len();
        let mut product = std::mem::take(&mut self.room.product);
        product.clear();
        product.resize(bodies, [0.0; 6]);
        changes.clear();
        for (number, term) in self.terms.iter().enumerate() {
            let goes = number >= contacts && term.presses();
            changes.push(if goes { term.gained([-share * term.impulse[0], 0.0]) } else { [0.0; 2] });
            push_term(term, changes[number], &mut product);
        }
        pulls.clear();
        pulls.resize(self.links.len(), [0.0; 6]);
        let mut lets_go = true;
        for _ in 0..ROUNDS {
            self.unknowns.clear();
            self.unknowns.extend_from_slice(&product);
            self.unknowns.resize(bodies + self.links.len(), [0.0; 6]);
            let Self { unknowns, structure, factor, terms, .. } = self;
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
            for (pull, found) in pulls.iter_mut().zip(&unknowns[bodies..]) {
                pull.iter_mut().zip(found).for_each(|(pull, more)| *pull -= more);
            }
            // What is no number compares as nothing to let go.
            lets_go = greatest > least;
            if !lets_go {
                break;
            }
            self.times(&self.unknowns[..bodies], &mut product);
        }
        self.room.product = product;
        lets_go
    }
}
