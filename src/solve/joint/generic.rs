//! Generic six-axis joint: each translation and rotation along A's axes free, locked, limited or driven.
//!
//! Translations are the gap's components in A's frame. Rotations are the angles of R_aᵀ R_b = R_x(φ) R_y(θ) R_z(ψ), read and driven
//! as [`super::angles`] says: one free axis is a hinge, whichever it is, x and y or y and z free are a universal joint. Axes that leave
//! no angle, or one, have rows on directions, with the give `angular`; an axis that is locked beside two free ones has one on its angle.

use super::angles::Turning;
use super::geometry::Placement;
use super::row_sink::{JointCoordinate, RowSink};
use super::rows::{Demand, Error1, HeldDirections};
use crate::joint::{Axis, Limits};

/// Multiplier of the first row of an axis; those of the others follow, three each.
const fn first_row(axis: usize) -> u8 {
    3 * axis as u8
}

/// Whether a joint with these axes holds its two points together, in all directions.
pub(super) fn holds_points(linear: &[Axis; 3]) -> bool {
    linear.iter().all(|axis| axis.limits == Limits::new(0.0, 0.0))
}

pub(crate) fn rows(sink: &mut RowSink, linear: &[Axis; 3], angular: &[Axis; 3]) {
    let is_held = holds_points(linear);
    if is_held {
        sink.hold_points(HeldDirections::All);
    }
    let angles = turns(sink, angular);
    // What is locked comes first: motors have to know of it.
    for holds in [true, false] {
        if let Some(angles) = &angles {
            for (i, axis) in angular.iter().enumerate().filter(|(_, axis)| is_locked(axis) == holds) {
                if let Some(angle) = &angles[i] {
                    add_angle(sink, angle, axis, i);
                }
            }
        }
        if !is_held {
            for (i, axis) in linear.iter().enumerate().filter(|(_, axis)| is_locked(axis) == holds) {
                add_slide(sink, axis, i);
            }
        }
    }
}

fn is_locked(axis: &Axis) -> bool {
    axis.limits.min == axis.limits.max
}

fn add_slide(sink: &mut RowSink, axis: &Axis, i: usize) {
    let jacobian = sink.along(sink.geometry.gradient.axes_a().col(i));
    if sink.has_rows(axis.limits, axis.motor) {
        let slide = sink.length(jacobian, |p: &Placement| p.local_gap()[i]);
        sink.limit_and_drive(&slide, axis.limits, axis.motor, first_row(i));
    }
    sink.rub(jacobian, sink.def.axis_friction[i], axis.limits, i as u8);
}

fn add_angle(sink: &mut RowSink, angle: &JointCoordinate, axis: &Axis, i: usize) {
    let id = first_row(3 + i);
    if is_locked(axis) {
        let ([first, last], rate) = sink.stop_at(f64::from(axis.limits.min), id);
        let factor = angle.factor;
        let error = Error1 { start: (angle.start - first) * factor, predicted: (angle.predicted - last) * factor };
        let give = sink.spring(sink.def.angular, &[angle.jacobian]);
        return sink.driven_scalar(angle.jacobian, -rate * factor, Demand::Equal(error), give, id);
    }
    if sink.has_rows(axis.limits, axis.motor) {
        sink.limit_and_drive(angle, axis.limits, axis.motor, id);
    }
    sink.rub(angle.jacobian, sink.def.axis_friction[3 + i], axis.limits, 3 + i as u8);
}

/// Holds directions where no angle is left, or one; returns the angles that have rows of their own: not those whose directions are held.
fn turns(sink: &mut RowSink, angular: &[Axis; 3]) -> Option<[Option<JointCoordinate>; 3]> {
    let turning = Turning::of(angular);
    let gradient = turning.turned(sink.geometry.gradient);
    match turning {
        Turning::None(_) => {
            sink.hold_directions(HeldDirections::All, gradient.a.frame, |p| turning.turned(p).rotation_vector());
            return None;
        }
        Turning::About(..) => {
            let axis = gradient.axes_a().x_axis;
            sink.hold_directions(HeldDirections::Across(axis), gradient.a.frame, |p| turning.turned(p).axis_error());
        }
        Turning::AcrossX(_) | Turning::AcrossZ(_) | Turning::Euler => {}
    }
    let is_held = |i: usize| matches!(turning, Turning::About(axis, _) if axis != i);
    let rubs = |i: usize| sink.def.axis_friction[3 + i] > 0.0;
    if !(0..3).any(|i| !is_held(i) && (sink.has_rows(angular[i].limits, angular[i].motor) || rubs(i))) {
        return None;
    }
    let start = turning.read(sink.geometry.start, sink.angles, angular);
    let gradients = turning.gradients(sink.geometry.gradient, turning.read(sink.geometry.gradient, start, angular));
    let predicted = if sink.geometry.is_still {
        start
    } else {
        let near = std::array::from_fn(|i| start[i] + gradients[i].0.rate(&sink.rates.bodies) * sink.phase.h());
        turning.read(sink.geometry.predicted, near, angular)
    };
    Some(std::array::from_fn(|i| {
        let (jacobian, factor) = gradients[i];
        (!is_held(i)).then_some(JointCoordinate { jacobian, start: start[i], predicted: predicted[i], factor })
    }))
}
