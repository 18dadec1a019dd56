//! What rounding leaves of a linear solve, taken out with the same factor (iterative refinement).
//!
//! Rows of a loop that repeat one another, and light arms that bear a heavy load by a long lever, make the matrix ill-conditioned: its
//! solution is off by far more than rounding, and by more for one row than for another. The residual is not: one more solve for it leaves
//! the square of that error.

use super::problem::{Problem, push_along, push_term, rate, speed};

/// Speed by which rows that always hold may miss what they are asked for before a solve is refined (m/s, rad/s). A rope under ten tonnes
/// meets them to 1e-7; the arms of a scissor lift missed them by 1e-5 to 3e-3, and told forces that were off by a percent.
const MISSED: f64 = 1.0e-7;

/// Refinements of a solve at most: two are enough where the matrix has an inverse at all.
const MAX_REFINEMENTS: usize = 2;

impl Problem {
    /// Solves for the unknowns in place, with the terms' G.
    pub(super) fn solve_unknowns(&mut self) {
        let mut asked = std::mem::take(&mut self.room.asked);
        let mut residual = std::mem::take(&mut self.room.residual);
        super::passes::copy(&self.unknowns, &mut asked);
        self.factor.solve(&self.structure, &mut self.unknowns);
        for _ in 0..MAX_REFINEMENTS {
            if self.most_missed(&asked) <= MISSED {
                break;
            }
            self.find_residual(&asked, &mut residual);
            self.factor.solve(&self.structure, &mut residual);
            // What is no number would spoil a solution that is one.
            if !residual.iter().flatten().all(|value| value.is_finite()) {
                break;
            }
            for (unknowns, more) in self.unknowns.iter_mut().zip(&residual) {
                unknowns.iter_mut().zip(more).for_each(|(value, more)| *value += more);
            }
        }
        (self.room.asked, self.room.residual) = (asked, residual);
    }

    /// What is left of a link's row: asked − J x + ε x.
    fn left_of(&self, number: usize, row: usize, asked: &[[f64; 6]]) -> f64 {
        let (link, node) = (&self.links[number], self.masses.len() + number);
        let jacobian = [&link.jacobian[0][row], &link.jacobian[1][row]];
        let give = link.give[row] + link.proximity[row];
        asked[node][row] - rate(link.bodies, jacobian, &self.unknowns) + give * self.unknowns[node][row]
    }

    fn most_missed(&self, asked: &[[f64; 6]]) -> f64 {
        let rows = self.links.iter().enumerate().flat_map(|(number, link)| (0..link.rows).map(move |row| (number, row)));
        rows.map(|(number, row)| self.left_of(number, row, asked).abs()).fold(0.0, f64::max)
    }

    fn find_residual(&self, asked: &[[f64; 6]], residual: &mut Vec<[f64; 6]>) {
        let bodies = self.masses.len();
        self.times(&self.unknowns[..bodies], residual);
        for (left, asked) in residual.iter_mut().zip(asked) {
            left.iter_mut().zip(asked).for_each(|(left, asked)| *left = asked - *left);
        }
        for term in &self.terms {
            let pushed = term.gained(speed(term, &self.unknowns));
            push_term(term, pushed.map(|value| -value / term.compliance), residual);
        }
        for (number, link) in self.links.iter().enumerate() {
            for row in 0..link.rows {
                let jacobian = [&link.jacobian[0][row], &link.jacobian[1][row]];
                push_along(link.bodies, jacobian, -self.unknowns[bodies + number][row], residual);
            }
        }
        for (number, link) in self.links.iter().enumerate() {
            let mut left = [0.0; 6];
            for (row, left) in left[..link.rows].iter_mut().enumerate() {
                *left = self.left_of(number, row, asked);
            }
            residual.push(left);
        }
    }
}
