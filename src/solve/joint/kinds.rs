//! Which rows each kind of joint has; one function a kind, in its own file.

use glam::{DQuat, DVec3};

use super::angles::nearest;
use super::distance::ties_points;
use super::driven::DrivenParts;
use super::friction;
use super::geometry::{JointGeometry, Placement};
use super::motor::BodyResponse;
use super::rows::{BlockRow, Demand, Error1, Error3, HeldDirections, Jacobian, Phase, RowRates, ScalarRow, SoftParams};
use crate::joint::{JointDef, JointKind, Limits, Motor, SphericalMotor};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::JointImpulses;

/// Rows of one joint for one substep, as its kind asks for them.
pub(crate) struct RowSink<'a> {
    pub rates: RowRates,
    pub geometry: JointGeometry<'a>,
    pub def: &'a JointDef,
    /// What the host moves of its stops and frames.
    pub driven: Option<DrivenParts<'a>>,
    pub impulses: &'a JointImpulses,
    /// Stops that are to be left at a speed.
    pub rebounds: Rebounds,
    /// What the substep of this phase has of the carried impulses.
    pub share: f64,
    pub phase: Phase,
    /// Whether rows of stops are asked for: not of those that are out of reach.
    pub has_stops: bool,
    pub point: Option<BlockRow>,
    pub direction: Option<BlockRow>,
    pub scalars: &'a mut Vec<ScalarRow>,
    /// Angles near those of the substep's start, turns counted (rad).
    pub angles: [f64; 3],
    /// How each body answers: asked for where a motor has to know what it can do.
    pub answer: &'a dyn Fn(usize) -> BodyResponse,
    /// From the end of the substep to that of the step (s).
    pub left: f64,
    /// Share of what is left that a rigid position motor closes in a substep at most, and its greatest speed (m/s, rad/s).
    pub closing_share: f64,
    pub most_speed: f64,
    /// Share of the carried multipliers that is in the rates.
    pub applied: f64,
    /// Set where a rigid position motor is on its way.
    pub is_under_way: bool,
    /// Stops that a motor which holds a speed comes to in this substep, as bits of their rows: it stops short of pressing them.
    pub arrives: u32,
}

impl<'a> RowSink<'a> {
    /// A sink without rows yet, for a joint on which nothing is carried and nothing drives, whose motors have nothing to know.
    pub(crate) fn new(
        geometry: JointGeometry<'a>,
        def: &'a JointDef,
        (phase, rates): (Phase, RowRates),
        angles: [f64; 3],
        scalars: &'a mut Vec<ScalarRow>,
    ) -> Self {
        scalars.clear();
        Self {
            rates,
            geometry,
            def,
            driven: None,
            impulses: &JointImpulses::ZERO,
            rebounds: Rebounds::NONE,
            share: 1.0,
            phase,
            has_stops: true,
            point: None,
            direction: None,
            scalars,
            angles,
            answer: &|_| BodyResponse::NONE,
            left: 0.0,
            closing_share: 1.0,
            most_speed: f64::INFINITY,
            applied: 0.0,
            is_under_way: false,
            arrives: 0,
        }
    }
}

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
            3 + u32::from(*swing_limit < std::f32::consts::PI) + stops(twist_limits) + drive
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

/// Whether a joint has rows along the line between its points.
pub(crate) fn is_distance(def: &JointDef) -> bool {
    matches!(def.kind, JointKind::Distance { .. }) && !ties_points(def)
}

/// A coordinate of a joint: its gradient, what it is at the substep's start and what it is predicted to be at its end (m or rad).
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointCoordinate {
    pub jacobian: Jacobian,
    pub start: f64,
    pub predicted: f64,
    /// Factor of its rows: what is asked for along the coordinate is asked for times this along the gradient.
    pub factor: f64,
}

impl RowSink<'_> {
    /// Holds the joint points together in the directions `held`.
    pub(crate) fn hold_points(&mut self, held: HeldDirections) {
        let g = &self.geometry;
        // Both bodies are pushed at one point, so that a gap costs no angular momentum: halfway between the joint points, or where
        // B's point slides in A's frame, there.
        let (lever_a, lever_b) = match held {
            HeldDirections::All => (g.gradient.a.lever + 0.5 * g.gradient.gap, g.gradient.b.lever - 0.5 * g.gradient.gap),
            HeldDirections::Across(_) => (g.gradient.a.lever + g.gradient.gap, g.gradient.b.lever),
        };
        // Where B slides, the error is what A sees of it: in world axes A's turning would move a gap along the free direction.
        let seen = |placement: &Placement| match held {
            HeldDirections::All => placement.gap,
            HeldDirections::Across(_) => g.gradient.a.frame * placement.local_gap(),
        };
        let (start, predicted) = g.read(seen);
        let error = Error3 { start, predicted };
        let give = SoftParams::new(self.def.linear, self.phase);
        let levers = [lever_a, lever_b];
        self.point = Some(BlockRow::point(&self.rates, levers, error, held, give, self.impulses.point));
    }

    /// Holds the joint frames together about the axes `held`; `error` reads the rotation vector in this frame of A.
    pub(crate) fn hold_directions(&mut self, held: HeldDirections, frame: DQuat, error: impl Fn(&Placement) -> DVec3) {
        let g = &self.geometry;
        let in_world = |placement: &Placement| frame * error(placement);
        let (start, predicted) = g.read(in_world);
        let error = Error3 { start, predicted };
        let give = SoftParams::new(self.def.angular, self.phase);
        self.direction = Some(BlockRow::direction(&self.rates, error, held, give, self.impulses.angular));
    }

    /// Whether a coordinate with these limits and this motor has any rows.
    pub(crate) fn has_rows(&self, limits: Limits, motor: Motor) -> bool {
        let is_free = limits == Limits::NONE || !self.has_stops;
        !is_free || motor != Motor::Off
    }

    /// A coordinate that is a length (m).
    pub(crate) fn length(&self, jacobian: Jacobian, value: impl Fn(&Placement) -> f64) -> JointCoordinate {
        let (start, predicted) = self.geometry.read(value);
        JointCoordinate { jacobian, start, predicted, factor: 1.0 }
    }

    /// The first angle of the joint (rad); `value` reads it up to whole turns.
    pub(crate) fn angle(&self, jacobian: Jacobian, value: impl Fn(&Placement) -> f64) -> JointCoordinate {
        let start = nearest(value(self.geometry.start), self.angles[0]);
        let predicted = if self.geometry.is_still {
            start
        } else {
            nearest(value(self.geometry.predicted), start + jacobian.rate(&self.rates.bodies) * self.phase.h())
        };
        JointCoordinate { jacobian, start, predicted, factor: 1.0 }
    }

    /// Adds the stops and the motor of a coordinate; their multipliers are `id`, `id + 1` and `id + 2`.
    pub(crate) fn limit_and_drive(&mut self, coordinate: &JointCoordinate, limits: Limits, motor: Motor, id: u8) {
        let &JointCoordinate { jacobian, start, predicted, factor } = coordinate;
        let give = SoftParams::new(self.def.limit, self.phase);
        let (min, max) = (f64::from(limits.min), f64::from(limits.max));
        if self.has_stops && min.is_finite() {
            let ([first, last], rate) = self.stop_at(min, id);
            let error = Error1 { start: (start - first) * factor, predicted: (predicted - last) * factor };
            let demand = if min == max { Demand::Equal(error) } else { Demand::AtLeast(error) };
            self.driven_scalar(jacobian, -rate * factor, demand, give, id);
        }
        if self.has_stops && max.is_finite() && min != max {
            let ([first, last], rate) = self.stop_at(max, id + 1);
            let error = Error1 { start: (first - start) * factor, predicted: (last - predicted) * factor };
            self.driven_scalar(jacobian.reversed(), rate * factor, Demand::AtLeast(error), give, id + 1);
        }
        self.drive(coordinate, limits, &motor, id + 2);
    }

    /// Adds one scalar row whose multiplier is `id`.
    pub(crate) fn scalar(&mut self, jacobian: Jacobian, demand: Demand, give: SoftParams, id: u8) {
        self.driven_scalar(jacobian, 0.0, demand, give, id);
    }

    /// The same of a coordinate whose error grows at the rate `driven` by what the host moves of its stop.
    pub(crate) fn driven_scalar(&mut self, jacobian: Jacobian, driven: f64, demand: Demand, give: SoftParams, id: u8) {
        let impulse = self.impulses.scalar[id as usize] * self.share as f32;
        let mut row = ScalarRow::new(&self.rates, driven, jacobian, demand, give, id, impulse);
        if self.rebounds != Rebounds::NONE && matches!(demand, Demand::AtLeast(_)) {
            row.leave_at(f64::from(self.rebounds.of(id)));
        }
        self.scalars.push(row);
    }

    /// Where a stop is at the start and at the end of the substep, and its rate.
    pub(crate) fn stop_at(&self, value: f64, row: u8) -> ([f64; 2], f64) {
        self.driven.as_ref().map_or(([value; 2], 0.0), |driven| driven.stop(value, row))
    }

    /// Gradient of the component of the gap along `axis`, which is fixed in A's frame.
    pub(crate) fn along(&self, axis: DVec3) -> Jacobian {
        let g = &self.geometry.gradient;
        Jacobian { linear: axis, angular_a: (g.a.lever + g.gap).cross(axis), angular_b: g.b.lever.cross(axis) }
    }
}

impl Jacobian {
    /// The gradient of the negated coordinate.
    pub(crate) fn reversed(self) -> Self {
        Self { linear: -self.linear, angular_a: -self.angular_a, angular_b: -self.angular_b }
    }
}
