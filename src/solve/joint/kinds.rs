//! Which rows each kind of joint has; one function a kind, in its own file.

use glam::DVec3;

use super::distance::ties_points;
use super::friction;
use super::geometry::Placement;
use super::row_sink::RowSink;
use super::rows::HeldDirections;
use super::spherical::locks_swing;
use crate::joint::{JointDef, JointKind, Limits, Motor, Softness, SphericalMotor};

/// Adds the rows of the joint's kind.
pub(crate) fn add_rows(sink: &mut RowSink) {
    match sink.def.kind {
        JointKind::Fixed => super::fixed::rows(sink),
        JointKind::Hinge { limits, motor } => super::hinge::rows(sink, limits, motor),
        JointKind::Spherical { swing_limit, twist_limits, motor } => {
            super::spherical::rows(sink, swing_limit, twist_limits, motor)
        }
        JointKind::Distance { limits, spring_length, motor } => super::distance::rows(sink, limits, spring_length, motor),
        JointKind::Prismatic { limits, motor } => super::prismatic::rows(sink, limits, motor),
        JointKind::Generic { linear, angular } => super::generic::rows(sink, &linear, &angular),
    }
}

/// Errors of the points and directions that a rigid hinge, ball or fixed joint holds, placed so (m, rad): those of its rows in a projection
/// where it has no stops, or none that is asked for. None of other joints.
pub(crate) fn held_errors(def: &JointDef, placement: &Placement, asks_for_stops: bool) -> Option<[DVec3; 2]> {
    let has_stops = match def.kind {
        JointKind::Fixed => false,
        JointKind::Hinge { limits, .. } => limits != Limits::NONE,
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            swing_limit < std::f32::consts::PI || twist_limits != Limits::NONE
        }
        JointKind::Distance { .. } | JointKind::Prismatic { .. } | JointKind::Generic { .. } => return None,
    };
    if (has_stops && asks_for_stops) || def.linear.compliance > 0.0 || def.angular.compliance > 0.0 {
        return None;
    }
    let direction = match def.kind {
        JointKind::Fixed => placement.a.frame * placement.rotation_vector(),
        JointKind::Hinge { .. } => {
            let held = HeldDirections::Across(placement.axes_a().x_axis);
            held.project(placement.a.frame * placement.axis_error())
        }
        _ => DVec3::ZERO,
    };
    Some([placement.gap, direction])
}

/// Most rows that a joint with this definition can have at once.
pub(crate) fn most_rows(def: &JointDef) -> u32 {
    let stops = |limits: &Limits| {
        if limits.min == limits.max { 1 } else { u32::from(limits.min.is_finite()) + u32::from(limits.max.is_finite()) }
    };
    let driven = |motor: &Motor| u32::from(*motor != Motor::Off);
    let without_friction: u32 = match &def.kind {
        JointKind::Fixed => 6,
        JointKind::Hinge { limits, motor } | JointKind::Prismatic { limits, motor } => 5 + stops(limits) + driven(motor),
        JointKind::Spherical { swing_limit, twist_limits, motor } => {
            let drive = if *motor == SphericalMotor::Off { 0 } else { 3 };
            let swing = if locks_swing(*swing_limit) { 2 } else { u32::from(*swing_limit < std::f32::consts::PI) };
            3 + swing + stops(twist_limits) + drive
        }
        JointKind::Distance { .. } if ties_points(def) => 3,
        JointKind::Distance { limits, spring_length, motor } => {
            stops(limits) + u32::from(spring_length.is_some()) + driven(motor)
        }
        JointKind::Generic { linear, angular } => {
            linear.iter().chain(angular).map(|axis| stops(&axis.limits) + driven(&axis.motor)).sum()
        }
    };
    without_friction + friction::rows_of(def)
}

/// Most rows of a joint that hold whatever force that takes, and whether it may have others, which act within bounds or along a line.
pub(crate) fn held_rows(def: &JointDef) -> (u32, bool) {
    let of_axis = |limits: &Limits, motor: &Motor| {
        let drives = motor.drive().is_some_and(|drive| drive.is_unbounded());
        u32::from(limits.min == limits.max) + u32::from(drives)
    };
    let held = match &def.kind {
        JointKind::Fixed => 6,
        JointKind::Hinge { limits, motor } | JointKind::Prismatic { limits, motor } => 5 + of_axis(limits, motor),
        JointKind::Spherical { swing_limit, twist_limits, motor } => {
            let swing = if locks_swing(*swing_limit) { 2 } else { 0 };
            let max_torque = match *motor {
                SphericalMotor::Off => 0.0,
                SphericalMotor::Velocity { max_torque, .. } | SphericalMotor::Position { max_torque, .. } => max_torque,
            };
            3 + swing + of_axis(twist_limits, &Motor::Off) + if max_torque == f32::INFINITY { 3 } else { 0 }
        }
        JointKind::Distance { .. } if ties_points(def) => 3,
        JointKind::Distance { limits, spring_length, motor } => of_axis(limits, motor) + u32::from(spring_length.is_some()),
        JointKind::Generic { linear, angular } => {
            linear.iter().chain(angular).map(|axis| of_axis(&axis.limits, &axis.motor)).sum()
        }
    };
    let may_be_slowed = |motor: &Motor| motor.drive().is_some_and(|drive| drive.may_be_slowed());
    let is_slowed = match &def.kind {
        JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } => may_be_slowed(motor),
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| may_be_slowed(&axis.motor)),
        JointKind::Fixed | JointKind::Spherical { .. } | JointKind::Distance { .. } => false,
    };
    let most = held.min(6);
    (most, is_distance(def) || is_slowed || most_rows(def) > most)
}

/// Whether a joint gives energy by its motors alone, if by anything: no spring, no give.
pub(crate) fn gives_by_motors_alone(def: &JointDef) -> bool {
    let is_rigid = def.linear.compliance == 0.0 && def.angular.compliance == 0.0 && def.limit.compliance == 0.0;
    is_rigid && !matches!(def.kind, JointKind::Distance { spring_length: Some(_), .. })
}

/// Whether a joint of this kind has a motor.
pub(crate) fn has_motor(kind: &JointKind) -> bool {
    match kind {
        JointKind::Fixed => false,
        JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } => {
            *motor != Motor::Off
        }
        JointKind::Spherical { motor, .. } => *motor != SphericalMotor::Off,
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| axis.motor != Motor::Off),
    }
}

/// Whether a joint of this kind has a motor that holds a place: one with a target, or where stops on angles let it run on nowhere, any.
pub(crate) fn holds_by_motor(kind: &JointKind) -> bool {
    let holds = |motor: &Motor| motor.drive().is_some_and(|drive| drive.target.is_some());
    let has_target = match kind {
        JointKind::Fixed => false,
        JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } => holds(motor),
        JointKind::Spherical { motor, .. } => matches!(motor, SphericalMotor::Position { .. }),
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| holds(&axis.motor)),
    };
    has_target || has_motor(kind) && limits_angles(kind)
}

/// Whether a joint of this kind has a motor that does not give as a spring does.
pub(crate) fn has_rigid_motor(kind: &JointKind) -> bool {
    let is_rigid = |motor: &Motor| motor.drive().is_some_and(|drive| drive.softness.compliance == 0.0);
    match kind {
        JointKind::Fixed => false,
        JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } => {
            is_rigid(motor)
        }
        JointKind::Spherical { motor, .. } => match motor {
            SphericalMotor::Off => false,
            SphericalMotor::Velocity { .. } => true,
            SphericalMotor::Position { softness, .. } => softness.compliance == 0.0,
        },
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| is_rigid(&axis.motor)),
    }
}

/// Whether a joint has stops that give.
pub(crate) fn has_soft_stops(def: &JointDef) -> bool {
    let stops = |limits: &Limits| limits.min < limits.max && *limits != Limits::NONE;
    def.limit.compliance > 0.0
        && match &def.kind {
            JointKind::Fixed => false,
            JointKind::Hinge { limits, .. } | JointKind::Prismatic { limits, .. } | JointKind::Distance { limits, .. } => {
                stops(limits)
            }
            JointKind::Spherical { .. } => limits_angles(&def.kind),
            JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| stops(&axis.limits)),
        }
}

/// Whether anything of a joint gives as a spring does: what it holds, its stops or its motors.
pub(crate) fn has_springs(def: &JointDef) -> bool {
    let gives = |softness: &Softness| softness.compliance > 0.0;
    let drives = |motor: &Motor| motor.drive().is_some_and(|drive| drive.target.is_some() && gives(&drive.softness));
    gives(&def.linear)
        || gives(&def.angular)
        || has_soft_stops(def)
        || match &def.kind {
            JointKind::Fixed => false,
            JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } => {
                drives(motor)
            }
            JointKind::Spherical { motor, .. } => {
                matches!(motor, SphericalMotor::Position { softness, .. } if gives(softness))
            }
            JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| drives(&axis.motor)),
        }
}

/// Whether all that a joint does gives as a spring does: as a hand does that drags a body about.
pub(crate) fn gives(def: &JointDef) -> bool {
    let gives = |softness: &Softness| softness.compliance > 0.0;
    let of_axis = |limits: &Limits, held: &Softness| match limits {
        limits if *limits == Limits::NONE => true,
        limits => limits.min == limits.max && gives(held),
    };
    !has_rigid_motor(&def.kind)
        && match &def.kind {
            JointKind::Fixed => gives(&def.linear) && gives(&def.angular),
            JointKind::Hinge { limits, .. } => gives(&def.linear) && gives(&def.angular) && *limits == Limits::NONE,
            JointKind::Prismatic { limits, .. } => gives(&def.linear) && gives(&def.angular) && *limits == Limits::NONE,
            JointKind::Spherical { .. } => gives(&def.linear) && !limits_angles(&def.kind),
            JointKind::Distance { limits, spring_length, .. } => {
                of_axis(limits, &def.linear) && (spring_length.is_none() || gives(&def.linear))
            }
            JointKind::Generic { linear, angular } => {
                let along = linear.iter().all(|axis| of_axis(&axis.limits, &def.linear));
                along && angular.iter().all(|axis| of_axis(&axis.limits, &def.angular))
            }
        }
}

/// Whether a joint of this kind has a rigid position motor of bounded force.
pub(crate) fn has_servo(kind: &JointKind) -> bool {
    let is_servo = |motor: &Motor| {
        motor
            .drive()
            .is_some_and(|drive| drive.target.is_some() && drive.softness.compliance == 0.0 && drive.max_force < f32::INFINITY)
    };
    match kind {
        JointKind::Fixed => false,
        JointKind::Hinge { motor, .. } | JointKind::Prismatic { motor, .. } | JointKind::Distance { motor, .. } => {
            is_servo(motor)
        }
        JointKind::Spherical { motor, .. } => matches!(motor, SphericalMotor::Position { .. }),
        JointKind::Generic { linear, angular } => linear.iter().chain(angular).any(|axis| is_servo(&axis.motor)),
    }
}

/// Which multipliers of a joint are those of motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MotorRows {
    None,
    /// That of its only coordinate.
    One,
    /// Those of a spherical joint, about A's axes.
    Three,
    /// Those of a six-axis joint.
    Six,
}

impl MotorRows {
    pub(crate) fn of(kind: &JointKind) -> Self {
        match kind {
            JointKind::Fixed => Self::None,
            JointKind::Hinge { .. } | JointKind::Prismatic { .. } | JointKind::Distance { .. } => Self::One,
            JointKind::Spherical { .. } => Self::Three,
            JointKind::Generic { .. } => Self::Six,
        }
    }

    /// Whether the multiplier `id` is that of a motor which has a coordinate of its own.
    pub(crate) fn is_of_one_axis(self, id: u8) -> bool {
        self != Self::Three && self.axis(id).is_some()
    }

    /// The axis whose motor has the multiplier `id`.
    pub(crate) fn axis(self, id: u8) -> Option<usize> {
        let (is_one, axis) = match self {
            Self::None => (false, 0),
            Self::One => (id == 2, 0),
            Self::Three => ((4..7).contains(&id), id.wrapping_sub(4)),
            Self::Six => (id < friction::OF_AXES && id % 3 == 2, id / 3),
        };
        is_one.then_some(axis as usize)
    }
}

/// Whether a joint of this kind, that has so many rows at most, holds its points together and does nothing else.
pub(crate) fn is_plain(kind: &JointKind, most_rows: u32) -> bool {
    matches!(kind, JointKind::Spherical { .. }) && most_rows == 3
}

/// Whether a joint of this kind has stops on angles, as limbs have.
pub(crate) fn limits_angles(kind: &JointKind) -> bool {
    let stops = |limits: &Limits| limits.min < limits.max && *limits != Limits::NONE;
    match kind {
        JointKind::Fixed | JointKind::Prismatic { .. } | JointKind::Distance { .. } => false,
        JointKind::Hinge { limits, .. } => stops(limits),
        JointKind::Spherical { swing_limit, twist_limits, .. } => *swing_limit < std::f32::consts::PI || stops(twist_limits),
        JointKind::Generic { angular, .. } => angular.iter().any(|axis| stops(&axis.limits)),
    }
}

/// Whether a joint of this kind is a hinge.
pub(crate) fn is_hinge(kind: &JointKind) -> bool {
    matches!(kind, JointKind::Hinge { .. })
}

/// Whether a joint of this kind holds its two points together, in all directions.
pub(crate) fn holds_points(kind: &JointKind) -> bool {
    match kind {
        JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => true,
        JointKind::Prismatic { .. } | JointKind::Distance { .. } => false,
        JointKind::Generic { linear, .. } => super::generic::holds_points(linear),
    }
}

/// Whether a joint has rows along the line between its points.
pub(crate) fn is_distance(def: &JointDef) -> bool {
    matches!(def.kind, JointKind::Distance { .. }) && !ties_points(def)
}
