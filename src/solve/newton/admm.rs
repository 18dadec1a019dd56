//! Alternating directions (Stellato et al. 2020): from a cold start, and where the budget ends.
//!
//! One factor serves all iterations: bodies and joints answer to targets z that terms have for their speeds, then each term takes what
//! it may do. It is slow to be exact and quick to be about right, and no iteration makes anything worse by much.

use super::problem::{Problem, push_term, speed};
use super::term::Law;

/// Compliance over J M⁻¹ Jᵀ, and by how much each iteration overshoots.
const COMPLIANCE: f64 = 1.0e-2;
const RELAXATION: f64 = 1.6;

impl Problem {
    /// Takes so many iterations from the velocity and the expected impulses. Leaves y, λ and the compliance in the terms.
    pub(super) fn admm(&mut self, iterations: usize) {
        for term in &mut self.terms {
            if term.give == 0.0 {
                term.compliance = COMPLIANCE * term.ease;
            }
            let has_law = !matches!(term.law, Law::Leaning { share, .. } if share <= 0.0);
            term.gain = if has_law { [1.0, if term.rows == 2 { 1.0 } else { 0.0 }] } else { [0.0; 2] };
            (term.slide, term.impulse) = ([1.0, 0.0], if has_law { term.expected } else { [0.0; 2] });
        }
        self.factorize();
        self.find_speeds();
        let mut targets = std::mem::take(&mut self.room.targets);
        targets.clear();
        targets.extend(self.terms.iter().map(|term| term.speed));
        for _ in 0..iterations {
            self.answer(&targets);
            self.take_what_they_may(&mut targets);
        }
        self.room.targets = targets;
    }

    /// Solves for the velocity with the terms' targets.
    fn answer(&mut self, targets: &[[f64; 2]]) {
        let Self { unknowns, links, terms, drive, .. } = self;
        unknowns.clear();
        unknowns.extend_from_slice(drive);
        for (term, target) in terms.iter().zip(targets) {
            let push = [0, 1]
                .map(|i| if term.gain[i] == 0.0 { 0.0 } else { term.impulse[i] + (target[i] - term.bias[i]) / term.compliance });
            push_term(term, push, unknowns);
        }
        Self::ask_links(links, None, unknowns);
        self.factor.solve(&self.structure, &mut self.unknowns);
        self.keep_links();
        let bodies = self.masses.len();
        self.velocity.clear();
        self.velocity.extend_from_slice(&self.unknowns[..bodies]);
    }

    fn take_what_they_may(&mut self, targets: &mut [[f64; 2]]) {
        for number in 0..self.terms.len() {
            if let Law::Leaning { first, count, share } = self.terms[number].law {
                // Those it leans on come before it.
                self.terms[number].radius =
                    share * self.normals(first, count).map(|term| term.hit + term.impulse[0]).sum::<f64>();
            }
            let (term, target) = (&mut self.terms[number], &mut targets[number]);
            let found = super::passes::with_bias(term, speed(term, &self.velocity));
            term.speed = found;
            if term.gain[0] == 0.0 {
                term.argument = [0.0; 2];
                continue;
            }
            let beyond = [0, 1].map(|i| RELAXATION * found[i] + (1.0 - RELAXATION) * target[i]);
            term.argument = [0, 1].map(|i| term.impulse[i] - beyond[i] / term.compliance);
            let taken = term.project(term.argument);
            *target = [0, 1].map(|i| beyond[i] + term.compliance * (taken[i] - term.impulse[i]));
            term.impulse = taken;
        }
    }
}
