//! Iterative refinement with a kept factor, until residuals are rounding. Where rows contradict one another, the part of the
//! multipliers that only the contradiction asks for is removed.
//!
//! With A the matrix, ε what is added to it and r what rows ask for, the factor gives p = (A + ε)⁻¹ r. Along an eigenvector of which A has λ
//! that is r/(λ + ε), and each refinement takes it nearer to r/λ. But where rows repeat others λ is nothing, and r what they contradict
//! each other by: r/ε is without sense, and as λ is the square of what joints are open by rather than nothing, it moves the bodies. So
//! multipliers that refinement does not improve are *moderated*,
//!
//! ```text
//! p ← p − (A + ε)⁻¹ ε p = (A + ε)⁻¹ A p,
//! ```
//!
//! which takes λ/(λ + ε) of each share (iterated Tikhonov regularisation the other way round): nothing of what contradicts, so that what is
//! left is of all multipliers that do the same the least, and all but ε/λ of what is needed. Rows that give have multipliers of their own,
//! and keep them.

use super::block::{Lanes, ZERO};
use super::factor::{self, BlockFactor, BlockLayout};

/// Most times that a solution is refined, and the share of the first residual from which it is.
const REFINEMENTS: usize = 2;
const REFINE_ABOVE: f64 = 1.0e-7;

/// Share of the residual that a refinement must reach to be kept.
const IMPROVES: f64 = 0.5;

/// How often multipliers are moderated where rows contradict one another: after one time a random linkage of six hinges whose axes meet in
/// a point still gains 5 % of what it swings with, after two none of it.
pub(super) const MODERATIONS: usize = 2;

/// Linear equations whose matrix has been factorised, and their unknowns.
pub(super) trait Equations {
    /// Writes what the rows still lack, −(J v + b + γ p); returns the greatest.
    fn find_residuals(&mut self, factor: &BlockFactor, residuals: &mut [Lanes]) -> f64;

    /// Writes what has been added to the diagonal of each row that does not give, times its multiplier.
    fn find_added(&mut self, factor: &BlockFactor, added: &mut [Lanes]);

    /// Solves the equations in place, by the factor and what else holds of the unknowns.
    fn solve(&mut self, factor: &BlockFactor, plan: &BlockLayout, unknowns: &mut [Lanes]) {
        factor::substitute(factor, plan, unknowns);
    }

    /// Adds a share of the increments to the multipliers, and their push to the rates.
    fn add_impulses(&mut self, factor: &BlockFactor, increments: &[Lanes], share: f64);
}

/// Solves the equations; the two lists are room for it. Multipliers are moderated `least` times, and `most` where rows contradict one
/// another. `is_exact` becomes true where the first solution needed no refinement, and then no residual is formed to see whether the
/// next one does.
pub(super) fn refine(
    equations: &mut impl Equations,
    factor: &BlockFactor,
    plan: &BlockLayout,
    [least, most]: [usize; 2],
    unknowns: &mut Vec<Lanes>,
    increments: &mut Vec<Lanes>,
    is_exact: &mut bool,
) {
    unknowns.resize(factor.len(), ZERO);
    increments.resize(factor.len(), ZERO);
    let first = equations.find_residuals(factor, unknowns);
    let (mut before, mut moderations) = (first, least);
    for round in 0..=REFINEMENTS {
        equations.solve(factor, plan, unknowns);
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
            moderations = most;
            break;
        }
        if left <= REFINE_ABOVE * first {
            *is_exact = round == 0 && first > 0.0;
            break;
        }
        before = left;
    }
    for _ in 0..moderations {
        equations.find_added(factor, unknowns);
        equations.solve(factor, plan, unknowns);
        equations.add_impulses(factor, unknowns, -1.0);
    }
}
