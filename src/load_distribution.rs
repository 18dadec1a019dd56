//! Distributes a load over points that can only push: of all λ ≥ 0 that balance a force and two moments, the one of least norm.
//!
//! Normal equations of the three balance rows in `f64`, with an active set: points that would pull are taken out, a few times.

use glam::{DMat3, DVec3, Vec3, Vec3Swizzles};

/// Passes in which points that would pull are taken out.
const ACTIVE_SET_PASSES: usize = 5;

/// Regularisation per point: of the force row, and of the moment rows relative to the squared levers.
const FORCE_REGULARISATION: f64 = 1.0e-9;
const MOMENT_REGULARISATION: f64 = 1.0e-6;

/// A point that takes part in a balance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LoadedPoint {
    /// Force and two moments per unit of λ.
    column: DVec3,
    /// λ.
    pub force: f64,
    active: bool,
}

impl LoadedPoint {
    pub(crate) fn new(column: DVec3) -> Self {
        Self { column, force: 0.0, active: true }
    }
}

/// Sets the points' forces so that their columns add up to `demand`, as nearly as pushing can, and to no more than its force.
///
/// The nearest balance of a moment that no pushing balances adds force: a load beside all its points would be carried many times.
pub(crate) fn balance(points: &mut [LoadedPoint], demand: DVec3) {
    distribute(points, demand);
    let pushed: f64 = points.iter().map(|point| point.column.x * point.force).sum();
    if pushed > demand.x {
        let share = demand.x.max(0.0) / pushed;
        points.iter_mut().for_each(|point| point.force *= share);
    }
}

/// The forces of least norm that are nearest to `demand`.
fn distribute(points: &mut [LoadedPoint], demand: DVec3) {
    for _ in 0..ACTIVE_SET_PASSES {
        let mut matrix = DMat3::ZERO;
        let (mut count, mut reach) = (0.0, 0.0);
        for point in points.iter().filter(|point| point.active) {
            let c = point.column;
            matrix += DMat3::from_cols(c * c.x, c * c.y, c * c.z);
            count += 1.0;
            reach += c.y * c.y + c.z * c.z;
        }
        if count == 0.0 {
            return;
        }
        let moment = MOMENT_REGULARISATION * reach.max(f64::MIN_POSITIVE);
        matrix += DMat3::from_diagonal(DVec3::new(FORCE_REGULARISATION * count, moment, moment));
        let multiplier = matrix.inverse() * demand;
        if !multiplier.is_finite() {
            points.iter_mut().for_each(|point| point.force = 0.0);
            return;
        }
        let mut pulls = false;
        for point in points.iter_mut() {
            let force = point.column.dot(multiplier);
            point.force = if point.active { force.max(0.0) } else { 0.0 };
            if point.active && force < 0.0 {
                point.active = false;
                pulls = true;
            }
        }
        if !pulls {
            return;
        }
    }
}

/// A point whose force may change, but not below a bound.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BoundedPoint {
    /// Force and two moments per unit of it.
    column: Vec3,
    /// Least change.
    least: f32,
    pub change: f32,
    is_free: bool,
}

impl BoundedPoint {
    pub(crate) fn new(column: Vec3) -> Self {
        Self { column, ..Self::default() }
    }

    /// Begins with no change, of which there may be no less than `least`; or none at all.
    pub(crate) fn begin(&mut self, least: f32, is_free: bool) {
        (self.least, self.change, self.is_free) = (least, 0.0, is_free);
    }

    /// What its change adds up to.
    pub(crate) fn effect(&self) -> DVec3 {
        self.column.as_dvec3() * f64::from(self.change)
    }
}

/// Sets the points' changes so that their columns add up to `demand`, as nearly as their bounds let them, of least norm.
pub(crate) fn adjust(points: &mut [BoundedPoint], demand: DVec3) {
    let mut left = demand;
    for _ in 0..ACTIVE_SET_PASSES {
        let (mut squares, mut products, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for point in points.iter().filter(|point| point.is_free) {
            let c = point.column.as_dvec3();
            squares += c * c;
            products += c * c.yzx();
            count += 1.0;
        }
        if count == 0.0 {
            return;
        }
        let moment = MOMENT_REGULARISATION * (squares.y + squares.z).max(f64::MIN_POSITIVE);
        let [xx, yy, zz] = (squares + DVec3::new(FORCE_REGULARISATION * count, moment, moment)).to_array();
        let [xy, yz, zx] = products.to_array();
        let matrix = DMat3::from_cols_array(&[xx, xy, zx, xy, yy, yz, zx, yz, zz]);
        let multiplier = matrix.inverse() * left;
        if !multiplier.is_finite() {
            points.iter_mut().for_each(|point| point.change = 0.0);
            return;
        }
        let mut is_bound = false;
        for point in points.iter_mut().filter(|point| point.is_free) {
            point.change = point.column.as_dvec3().dot(multiplier) as f32;
            if point.change < point.least {
                point.change = point.least;
                point.is_free = false;
                left -= point.effect();
                is_bound = true;
            }
        }
        if !is_bound {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];

    #[test]
    fn a_weight_off_centre_loads_the_near_corners_by_the_lever_rule() {
        let mut points = CORNERS.map(|(x, z)| LoadedPoint::new(DVec3::new(1.0, -z, x)));
        // 10 N at x = 0.5 m.
        balance(&mut points, DVec3::new(10.0, 0.0, 5.0));
        let forces = points.map(|point| point.force);
        for (force, expected) in forces.iter().zip([1.25, 3.75, 1.25, 3.75]) {
            assert!((force - expected).abs() < 1e-4, "{forces:?} N");
        }
    }

    #[test]
    fn a_load_beside_its_points_is_carried_once_at_most() {
        // A crate whose two points lie on one edge, 5 cm apart, and whose centre is 0.5 m beside them.
        let mut points = [-0.025, 0.025].map(|z| LoadedPoint::new(DVec3::new(1.0, -z, 0.001)));
        balance(&mut points, DVec3::new(10.0, 0.0, 5.0));
        let pushed: f64 = points.iter().map(|point| point.force).sum();
        assert!(pushed <= 10.0 + 1e-9 && pushed > 9.9, "{pushed} N for 10 N");
    }

    #[test]
    fn no_point_pulls_on_an_overhang() {
        let mut points = CORNERS.map(|(x, z)| LoadedPoint::new(DVec3::new(1.0, -z, x)));
        balance(&mut points, DVec3::new(10.0, 0.0, 20.0));
        assert!(points.iter().all(|point| point.force >= 0.0), "{:?} N", points.map(|point| point.force));
    }
}
