//! A solve with a kept factor, refined with the same factor until what rows lack is rounding.

use super::block::{Lanes, ZERO};
use super::factor::{self, Factor, Plan};

/// Most times that a solution is refined, and the share of the first residual from which it is.
const REFINEMENTS: usize = 2;
const REFINE_ABOVE: f64 = 1.0e-7;

/// Share of the residual that a refinement must reach to be kept.
const IMPROVES: f64 = 0.5;

/// Linear equations whose matrix has been factorised, and their unknowns.
pub(super) trait Equations {
    /// Writes what the rows still lack, −(J v + b + γ p); returns the greatest.
    fn find_residuals(&self, factor: &Factor, residuals: &mut [Lanes]) -> f64;

    /// Adds a share of the increments to the multipliers, and their push to the rates.
    fn add_impulses(&mut self, factor: &Factor, increments: &[Lanes], share: f64);
}

/// Solves the equations; the two lists are room for it. `is_exact` becomes true where the first solution needed no refinement, and then
/// no residual is formed to see whether the next one does.
pub(super) fn refine(
    equations: &mut impl Equations,
    factor: &Factor,
    plan: &Plan,
    unknowns: &mut Vec<Lanes>,
    increments: &mut Vec<Lanes>,
    is_exact: &mut bool,
) {
    unknowns.resize(factor.len(), ZERO);
    increments.resize(factor.len(), ZERO);
    let first = equations.find_residuals(factor, unknowns);
    let mut before = first;
    for round in 0..=REFINEMENTS {
        factor::substitute(factor, plan, unknowns);
        std::mem::swap(unknowns, increments);
        equations.add_impulses(factor, increments, 1.0);
        if *is_exact {
            break;
        }
        let left = equations.find_residuals(factor, unknowns);
        let improves = left < IMPROVES * before;
        if round > 0 && !improves {
            // Rows that contradict each other: more of the same would only raise multipliers that cancel.
            equations.add_impulses(factor, increments, -1.0);
            break;
        }
        if left <= REFINE_ABOVE * first {
            *is_exact = round == 0 && first > 0.0;
            break;
        }
        before = left;
    }
}
