//! Whether welded pieces stay one rigid body.

use longspan::glam::{DMat3, DQuat, DVec3};

use super::{Errors, Metric, View, Worst};

/// `rigid_dev_max_m` and `rot_dev_deg`: how far the centre of any piece lies from where the best rigid fit of all puts it, and how
/// far it is turned against that fit, the worst of the run.
///
/// The fit of the start positions q to the present ones p, weighted by mass m, turns by the R that maximises
/// Σ m (p − p̄)·R (q − q̄). It is found by turning along ω = Σ (R aᵢ × bᵢ)/(|Σ R aᵢ·bᵢ| + ε) over the columns of the matrix
/// A = Σ m (p − p̄)(q − q̄)ᵀ (Müller et al. 2016), from the fit of the step before.
pub struct RigidDeviation {
    bodies: Vec<usize>,
    start: Vec<(DVec3, DQuat)>,
    turn: DQuat,
    distance: Worst,
    angle: Worst,
}

impl RigidDeviation {
    /// Of these pieces.
    pub fn new(bodies: Vec<usize>) -> Self {
        Self { bodies, start: Vec::new(), turn: DQuat::IDENTITY, distance: Worst::ZERO, angle: Worst::ZERO }
    }
}

impl Metric for RigidDeviation {
    fn observe(&mut self, view: &View) {
        let turn_of = |body: usize| view.engine.pose(body).rotation.as_dquat().normalize();
        let now: Vec<(DVec3, DQuat)> = self.bodies.iter().map(|&body| (view.center(body), turn_of(body))).collect();
        if view.step == 0 {
            self.start = now;
            return;
        }
        let masses: Vec<f64> = self.bodies.iter().map(|&body| view.mass(body).map_or(0.0, |mass| f64::from(mass.mass))).collect();
        let total: f64 = masses.iter().sum();
        let mean = |at: &[(DVec3, DQuat)]| at.iter().zip(&masses).map(|((p, _), m)| *p * *m).sum::<DVec3>() / total;
        let (mean_start, mean_now) = (mean(&self.start), mean(&now));
        let mut spread = DMat3::ZERO;
        for (((q, _), (p, _)), m) in self.start.iter().zip(&now).zip(&masses) {
            let (q, p) = (*q - mean_start, *m * (*p - mean_now));
            spread += DMat3::from_cols(p * q.x, p * q.y, p * q.z);
        }
        self.turn = nearest_rotation(spread, self.turn);
        for ((q, turn_q), (p, turn_p)) in self.start.iter().zip(&now) {
            self.distance.note((*p - mean_now - self.turn * (*q - mean_start)).length());
            let off = (self.turn * *turn_q).conjugate() * *turn_p;
            let off = 2.0 * DVec3::new(off.x, off.y, off.z).length().min(1.0).asin();
            self.angle.note(off.to_degrees());
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("rigid_dev_max_m", self.distance.value()), ("rot_dev_deg", self.angle.value())]);
    }
}

/// The rotation nearest to `matrix`, searched from `guess`.
fn nearest_rotation(matrix: DMat3, guess: DQuat) -> DQuat {
    let mut turn = guess;
    for _ in 0..200 {
        let axes = DMat3::from_quat(turn);
        let columns = (0..3).map(|index| (axes.col(index), matrix.col(index)));
        let (mut moment, mut along) = (DVec3::ZERO, 0.0);
        for (axis, column) in columns {
            moment += axis.cross(column);
            along += axis.dot(column);
        }
        let step = moment / (along.abs() + 1e-300);
        if !step.is_finite() || step.length() < 1e-15 {
            break;
        }
        turn = (DQuat::from_scaled_axis(step) * turn).normalize();
    }
    turn
}

#[cfg(test)]
mod tests {
    use longspan::glam::EulerRot;

    use super::*;

    #[test]
    fn the_fit_finds_the_rotation_of_turned_points() {
        let turn = DQuat::from_euler(EulerRot::XYZ, 1.0, -0.6, 2.0);
        let mut spread = DMat3::ZERO;
        for index in 0..20 {
            let angle = f64::from(index);
            let q = DVec3::new(angle.sin(), 0.5 * (2.0 * angle).cos(), 0.3 * (3.0 * angle).sin());
            let p = turn * q;
            spread += DMat3::from_cols(p * q.x, p * q.y, p * q.z);
        }
        let off = nearest_rotation(spread, DQuat::IDENTITY).angle_between(turn);
        assert!(off < 1e-7, "the fit is off by {off:e} rad, bound 1e-7");
    }
}
