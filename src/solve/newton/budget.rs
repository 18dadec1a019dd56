//! How much work an island may take for a step, halvings included.
//!
//! The world's budget is one of multiplications. A step that has to be taken again, in substeps of half the length, has as many for each try, up to
//! [`SHARED_BUDGETS`] in all; once they are spent each substep takes no more than [`FREE_FACTORS`]. What a heavy load asks of few substeps may be three
//! budgets already: no step is begun again that would take more than [`MOST_BUDGETS`].

use super::island::CoupledIsland;
use super::passes::MAX_FACTORS;
use crate::solve::StepSettings;
use crate::solve::plan::FREE_FACTORS;
use crate::tuning::plan::{MOST_BUDGETS, SHARED_BUDGETS};

impl CoupledIsland {
    /// Factorisations for the substeps that it is about to take.
    pub(super) fn budget(&self, settings: &StepSettings) -> u32 {
        let (least, most) = (FREE_FACTORS * settings.substeps, MAX_FACTORS * settings.substeps);
        let allowed = self.allowed(settings);
        let left = allowed.min(SHARED_BUDGETS * allowed - f64::from(self.outcome.spent));
        (left.min(f64::from(most)) as u32).max(least)
    }

    /// Whether it may take the step again, in twice as many substeps.
    pub(super) fn can_halve(&self, settings: &StepSettings) -> bool {
        let least = 2 * FREE_FACTORS * settings.substeps;
        f64::from(self.outcome.spent + least) <= MOST_BUDGETS * self.allowed(settings)
    }

    /// Factorisations that the world's budget of multiplications comes to.
    fn allowed(&self, settings: &StepSettings) -> f64 {
        f64::from(settings.articulations.halving_budget) * 1.0e6 / self.problem.structure.work.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::ArticulationSettings;
    use crate::tuning::plan::MAX_HALVINGS;

    /// Each halving had a budget of its own, and at least three factors for each of its substeps: a truss that broke up took 210 million
    /// multiplications in a step for the 10 of its budget.
    #[test]
    fn a_step_that_is_taken_again_stays_within_six_budgets() {
        let articulations = ArticulationSettings::default();
        for work in [500, 20_000, 95_000, 240_000, 580_000, 830_000, 1_700_000, 2_200_000, 2_500_000] {
            let mut island = CoupledIsland::default();
            island.problem.structure.work = work;
            let mut halvings = 0;
            let spent = loop {
                let settings = StepSettings {
                    dt: 1.0 / 60.0,
                    gravity: glam::Vec3::NEG_Y,
                    substeps: 4 << halvings,
                    iterations: 1,
                    articulations,
                    restitution_threshold: 1.0,
                    limits: None,
                };
                island.outcome.spent += island.budget(&settings);
                if halvings == MAX_HALVINGS || !island.can_halve(&settings) {
                    break f64::from(island.outcome.spent) * work as f64;
                }
                halvings += 1;
            };
            let most = 1.0e6 * MOST_BUDGETS * f64::from(articulations.halving_budget);
            assert!(spent <= most, "{spent} multiplications of {most} at {work} a factor");
            assert!(halvings > 0 || work > 1_600_000, "a step of {work} a factor is not taken again");
        }
    }
}
