//! Position correction with the last factor: displacements that leave no velocity behind.

use super::factor::Vector;
use super::problem::{Problem, push_term};

/// Share of its depth that an overlap gives up in a substep. Joints give up all of their error, which is what a rotation leaves that was
/// taken as a straight way: at a share of 0.3 those of several substeps add up to rejected steps (winches at one substep of 1/30 s).
const SHARE: f64 = 0.3;

impl Problem {
    /// The displacements that have been found; empty where there are no errors.
    pub(crate) fn displacements(&self) -> &[Vector] {
        &self.unknowns[..self.masses.len().min(self.unknowns.len())]
    }

    /// Greatest overlap that a displacement takes out (m).
    pub(crate) fn deepest_push(&self) -> f64 {
        self.terms.iter().map(|term| SHARE * term.push * term.gain[0]).fold(0.0, f64::max)
    }

    /// Leaves overlaps as they are, and takes a new factor for the rows as they are now.
    pub(crate) fn forget_overlaps(&mut self) {
        self.terms.iter_mut().for_each(|term| term.push = 0.0);
        self.is_stale = true;
    }

    /// Finds the displacements that take errors of joints and overlaps out of positions.
    pub(crate) fn find_displacements(&mut self) {
        let bodies = self.masses.len();
        let has_errors = self.links.iter().any(|link| link.error != [0.0; 6]) || self.terms.iter().any(|term| term.push > 0.0);
        if !has_errors {
            self.unknowns.clear();
            return;
        }
        if self.is_stale {
            self.factorize();
        }
        let Self { unknowns, links, terms, factor, structure, .. } = self;
        unknowns.clear();
        unknowns.resize(bodies, [0.0; 6]);
        for term in terms.iter().filter(|term| term.push > 0.0) {
            let push = SHARE * term.push / term.compliance;
            push_term(term, term.gained([push, 0.0]), unknowns);
        }
        unknowns.extend(links.iter().map(|link| link.error.map(|error| -error)));
        factor.solve(structure, unknowns);
    }
}
