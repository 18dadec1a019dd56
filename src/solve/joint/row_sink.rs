//! Where the rows of a joint are gathered, and what every kind of joint asks for them with.

use glam::{DQuat, DVec3};

use super::angles::nearest;
use super::body_response::MotorAnswers;
use super::driven::DrivenParts;
use super::geometry::{JointGeometry, Placement};
use super::rows::{BlockRow, Demand, Error1, Error3, HeldDirections, Jacobian, Phase, RowRates, ScalarRow, SoftParams};
use crate::joint::{JointDef, Limits, Motor, Softness};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::JointImpulses;
use crate::tuning::springs::HARD_PHASE;

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
    /// Asked for where a motor has to know what it can do.
    pub answers: MotorAnswers<'a>,
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
            answers: MotorAnswers::NONE,
            left: 0.0,
            closing_share: 1.0,
            most_speed: f64::INFINITY,
            applied: 0.0,
            is_under_way: false,
            arrives: 0,
        }
    }
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
    /// Give of a spring along these coordinates: one that keeps its energy where substeps resolve it, as far as the joint's own bodies tell.
    pub(crate) fn spring(&self, softness: Softness, ways: &[Jacobian]) -> SoftParams {
        if softness.compliance > 0.0
            && let Phase::Leap { h } = self.phase
        {
            let ease = ways.iter().map(|way| self.ease_along(way)).fold(0.0, f64::max);
            if ease * h * h <= HARD_PHASE * HARD_PHASE * f64::from(softness.compliance) {
                return SoftParams::keeping(softness, self.phase);
            }
        }
        SoftParams::new(softness, self.phase)
    }

    /// Holds the joint points together in the directions `held`.
    pub(crate) fn hold_points(&mut self, held: HeldDirections) {
        let g = &self.geometry;
        // Both bodies are pushed at one point, so that a gap costs no angular momentum: halfway between the joint points, or where
        // B's point slides in A's frame, there.
        let (lever_a, lever_b) = match held {
            HeldDirections::All => (g.gradient.a.lever + 0.5 * g.gradient.gap, g.gradient.b.lever - 0.5 * g.gradient.gap),
            _ => (g.gradient.a.lever + g.gradient.gap, g.gradient.b.lever),
        };
        // Where B slides, the error is what A sees of it: in world axes A's turning would move a gap along the free direction.
        let seen = |placement: &Placement| match held {
            HeldDirections::All => placement.gap,
            _ => g.gradient.a.frame * placement.local_gap(),
        };
        let (start, predicted) = g.read(seen);
        let error = Error3 { start, predicted };
        let levers = [lever_a, lever_b];
        let (axes, count) = held.axes();
        let ways = axes.map(|axis| Jacobian { linear: axis, angular_a: lever_a.cross(axis), angular_b: lever_b.cross(axis) });
        let give = self.spring(self.def.linear, &ways[..count]);
        self.point = Some(BlockRow::point(&self.rates, levers, error, held, give, self.impulses.point));
    }

    /// Holds the joint frames together about the axes `held`; `error` reads the rotation vector in this frame of A.
    pub(crate) fn hold_directions(&mut self, held: HeldDirections, frame: DQuat, error: impl Fn(&Placement) -> DVec3) {
        let g = &self.geometry;
        let in_world = |placement: &Placement| frame * error(placement);
        let (start, predicted) = g.read(in_world);
        let error = Error3 { start, predicted };
        let (axes, count) = held.axes();
        let give = self.spring(self.def.angular, &axes.map(Jacobian::angular)[..count]);
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
