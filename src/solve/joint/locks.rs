//! Rows that locked axes leave nothing to.
//!
//! A row moves its two bodies by M⁻¹ Jᵀ. Where both have locked axes, as all that is kept in a plane has, that may be zero: two rows of a hinge
//! between such bodies turn them about axes about which neither turns. The locks hold these rows, whatever force they have; so they have none.
//!
//! They are never zero to the last bit, as frames are rounded: an axis that is off by ε turns a body by ε, and J M⁻¹ Jᵀ is of the order ε². A
//! solver would ask of that turn what the row lacks, over ε. What a row is worth is therefore told by angles, not by masses: by the sine of the
//! angle between its direction and what is locked, on either body.

use glam::{DMat3, DVec3};

use super::row_sink::RowSink;
use super::rows::{BlockRow, HeldDirections, ScalarRow};
use crate::linalg::eigen::symmetric_eigen;

/// Sine of the angle between a row and what locks leave of it up to which they hold it.
///
/// What a row has in rounding moves bodies by that over the sine: frames and levers are single precision, some 1e-7 of a radian or a lever, of
/// which this makes 1e-4. Axes are told apart by more: what a host means to be parallel is so to 1e-4 where it writes angles in degrees with two
/// digits. With 1e-7 and less, what rounding leaves of a locked row throws bodies about. Tried on joints of all kinds and masks of locks, whose
/// frames are off by 0 to 0.1, at 30 to 240 steps a second.
const HELD: f64 = 1.0e-3;

/// Density by which the size of a body is told whose mass does nothing, as it is locked along all axes (kg/m³).
const DENSITY: f64 = 1000.0;

/// Along and about which world axes a body moves: 1 where it does, 0 where it is locked. And its size, a radius of gyration (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Freedom {
    along: DVec3,
    about: DVec3,
    size: f64,
}

impl Freedom {
    /// Of what rows do not move.
    pub(crate) const NONE: Self = Self { along: DVec3::ZERO, about: DVec3::ZERO, size: 0.0 };

    /// Of a body with these inverse masses along the axes, 1 about free axes and 0 about locked ones, and these moments of inertia.
    pub(crate) fn new(inverse_mass: DVec3, about: DVec3, inertia: DVec3) -> Self {
        let along = DVec3::select(inverse_mass.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        if along + about == DVec3::splat(2.0) {
            return Self { along, about, size: 0.0 };
        }
        let (ease, moment) = (inverse_mass.max_element(), inertia.max_element());
        let size = if ease > 0.0 { (moment * ease).sqrt() } else { fifth_root(moment / DENSITY) };
        Self { along, about, size }
    }

    /// Both, where each has locked axes or is not moved; none where rows move either of them in any direction.
    pub(crate) fn of_both(a: Self, b: Self) -> Option<[Self; 2]> {
        let is_whole = |body: &Self| body.along + body.about == DVec3::splat(2.0);
        (!is_whole(&a) && !is_whole(&b)).then_some([a, b])
    }

    /// Square of the share that is left of a row that pushes and turns it so.
    fn share(&self, linear: DVec3, angular: DVec3) -> f64 {
        let over = |part: DVec3, whole: f64| if whole > 0.0 { part.length_squared() / whole } else { 0.0 };
        let push = linear.length_squared();
        let turn = angular.length_squared().max(push * self.size * self.size);
        over(self.along * linear, push).max(over(self.about * angular, turn))
    }

    /// The same of rows that push it at this lever, as a form in their directions.
    fn at(&self, lever: DVec3) -> DMat3 {
        let length = lever.length().max(self.size);
        let turn = |axis: DVec3| {
            let across = if length > 0.0 { axis.cross(lever) / length } else { DVec3::ZERO };
            outer(across) * self.about.dot(axis)
        };
        DMat3::from_diagonal(self.along) + turn(DVec3::X) + turn(DVec3::Y) + turn(DVec3::Z)
    }
}

/// Takes out of the rows of a joint what the locks of its bodies hold. What gives is left as it is: its force is that of a spring.
pub(crate) fn take_out(sink: &mut RowSink, locks: Option<[Freedom; 2]>) {
    let Some([a, b]) = locks else { return };
    if let Some(block) = &mut sink.point {
        let [lever_a, lever_b] = block.levers;
        reduce(block, a.at(lever_a) + b.at(lever_b));
    }
    if let Some(block) = &mut sink.direction {
        reduce(block, DMat3::from_diagonal(a.about + b.about));
    }
    for row in sink.scalars.iter_mut().filter(|row| hold([a, b], row)) {
        (row.acts, row.impulse) = (false, 0.0);
    }
}

/// Whether locks hold a row that does not give.
pub(crate) fn hold([a, b]: [Freedom; 2], row: &ScalarRow) -> bool {
    let at = &row.jacobian;
    row.gamma == 0.0 && a.share(at.linear, at.angular_a).max(b.share(at.linear, at.angular_b)) <= HELD * HELD
}

/// Leaves a block the directions in which its rows move anything.
fn reduce(block: &mut BlockRow, moved: DMat3) {
    if block.gamma > 0.0 {
        return;
    }
    let (axes, count) = block.held.axes();
    let held = axes[..count].iter().fold(DMat3::ZERO, |held, &axis| held + outer(axis));
    let (shares, directions) = symmetric_eigen(held * moved * held);
    let is_moved = shares.cmpgt(DVec3::splat(HELD * HELD));
    let kept = is_moved.bitmask().count_ones() as usize;
    if kept >= count {
        return;
    }
    let the = |wanted: bool| (0..3).find(|&i| is_moved.test(i) == wanted).map_or(DVec3::ZERO, |i| directions.col(i));
    block.held = match kept {
        2 => HeldDirections::Across(the(false)),
        1 => HeldDirections::Along(the(true)),
        _ => HeldDirections::Nothing,
    };
    block.bias = block.held.project(block.bias);
    block.impulse = block.held.project(block.impulse.as_dvec3()).as_vec3();
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// By Newton's method from above, in sums and products alone: the same bits everywhere.
fn fifth_root(x: f64) -> f64 {
    if !(x > 0.0 && x < f64::INFINITY) {
        return 0.0;
    }
    let mut root = x.max(1.0);
    loop {
        let next = root - (root - x / (root * root * root * root)) / 5.0;
        if next >= root {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_body_that_is_locked_along_all_axes_is_that_of_its_moments() {
        for size in [1.0e-3_f64, 0.1, 1.0, 30.0, 1.0e3] {
            let moment = DVec3::splat(DENSITY * size.powi(5));
            let found = Freedom::new(DVec3::ZERO, DVec3::X, moment).size;
            assert!((found / size - 1.0).abs() < 1.0e-12, "{found} of {size}");
        }
    }
}
