//! The rows of an articulation's joints and contacts, as each phase of a substep asks for them.

use std::cell::RefCell;

use glam::DVec3;

use super::articulation::Articulation;
use super::articulation_state::ServoLoad;
use super::body::DirectBody;
use super::distance_stiffness;
use super::redundancy::Redundancy;
use crate::id::{JointId, Pool};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::{Joint, JointImpulses};
use crate::solve::joint::LocalPose;
use crate::solve::joint::body_response::{BodyResponse, MotorAnswers};
use crate::solve::joint::driven::{self, DrivenParts};
use crate::solve::joint::geometry::{JointGeometry, Placement};
use crate::solve::joint::kinds;
use crate::solve::joint::locks::{self, Freedom};
use crate::solve::joint::reach::FarStops;
use crate::solve::joint::row_sink::RowSink;
use crate::solve::joint::rows::{HeldDirections, Jacobian, Phase, Rate, RowRates};
use crate::tuning::overruled::FLUNG;

/// Where a joint is as its rows are built: at the start of the substep, as predicted for its end, and where gradients are taken if that
/// is at neither.
struct JointPlacements {
    start: Placement,
    predicted: Option<Placement>,
    between: Option<Placement>,
    /// Whether gradients are taken where the joint is predicted.
    is_implicit: bool,
}

impl JointPlacements {
    fn geometry(&self) -> JointGeometry<'_> {
        let Self { start, predicted, between, is_implicit } = self;
        match predicted {
            Some(predicted) => {
                let end = if *is_implicit { predicted } else { start };
                JointGeometry { start, predicted, gradient: between.as_ref().unwrap_or(end), is_still: false }
            }
            None => JointGeometry { gradient: between.as_ref().unwrap_or(start), ..JointGeometry::at(start) },
        }
    }
}

impl Articulation {
    /// What joints and contacts ask for in this phase, ready for the first solve.
    pub(super) fn ask(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        if self.is_points {
            self.ask_points(phase);
        } else {
            self.build_rows(joints, phase);
            self.system.begin(&self.bodies);
        }
    }

    /// Makes the rows of all joints and contacts; those of a velocity phase need the predicted poses.
    pub(super) fn build_rows(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        let in_place = matches!(phase, Phase::Position { .. });
        if !in_place {
            self.find_parts(joints);
        }
        if self.coupled && !in_place {
            let Self { stops, entries, .. } = self;
            stops.resize_with(entries.len(), FarStops::default);
            stops.iter_mut().zip(&*entries).for_each(|(stops, entry)| stops.know(&joints[entry.joint].def.kind));
        }
        if !in_place && self.parts.loads.contains(&ServoLoad::Loop) {
            self.add_rows(joints, phase);
            self.parts.trial.take(&self.system);
        }
        self.add_rows(joints, phase);
    }

    fn add_rows(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        self.is_under_way &= matches!(phase, Phase::Position { .. });
        self.system.clear();
        self.system.base.most_turn = if let Phase::Position { .. } = phase { f64::INFINITY } else { FLUNG / phase.h() };
        let mut next_touch = 0;
        for number in 0..self.links.len() {
            if number < self.entries.len() {
                self.build_joint_rows(number, joints, phase);
            } else {
                self.system.add(self.links[number].bodies, None, None, &[], Redundancy::Often);
            }
            self.build_contact_rows(number, &mut next_touch, phase);
        }
    }

    /// Makes the rows of the contacts of a node, of which the first is `next`.
    fn build_contact_rows(&mut self, node: usize, next: &mut usize, phase: Phase) {
        let Self { touches, local_poses, step_start, system, rates, h, .. } = self;
        while let Some(touch) = touches.get(*next).filter(|touch| touch.node as usize == node) {
            match phase {
                Phase::Velocity { h } | Phase::Tangent { h } | Phase::Leap { h } => {
                    touch.add_rows(system, (local_poses, step_start, rates), h);
                }
                Phase::Position { .. } => touch.add_position_rows(system, &touch.spots(local_poses, step_start), *h),
            }
            *next += 1;
        }
    }

    /// Where a joint is in this phase, which begins and ends so long before the end of the step (s).
    fn placements_of(&self, number: usize, joint: &Joint, phase: Phase, ends: [f64; 2]) -> JointPlacements {
        let Self { entries, links, local_poses, began, predicted, .. } = self;
        let (entry, link) = (&entries[number], &links[number]);
        let [a, b] = link.bodies.map(|body| body as usize);
        let placement = |a: &LocalPose, b: &LocalPose, left: f64| match link.is_plain {
            true => entry.points(a, b),
            false => driven::before(entry.placement(*a, *b), joint.drive(), [a, b], left),
        };
        if !matches!(phase, Phase::Velocity { .. }) {
            let looks_ahead = self.coupled && !matches!(phase, Phase::Position { .. }) && !predicted.is_empty();
            return JointPlacements {
                start: placement(&local_poses[a], &local_poses[b], ends[0]),
                predicted: None,
                between: looks_ahead.then(|| placement(&predicted[a], &predicted[b], ends[0])),
                is_implicit: false,
            };
        }
        let implicit = self.implicit[number];
        let on_the_way = |body: usize| {
            let (from, to) = (began.local_poses[body], predicted[body]);
            (from.0.lerp(to.0, implicit), from.1.lerp(to.1, implicit))
        };
        let is_between = implicit != 0.0 && implicit != 1.0;
        JointPlacements {
            start: placement(&began.local_poses[a], &began.local_poses[b], ends[0]),
            predicted: Some(placement(&predicted[a], &predicted[b], ends[1])),
            between: is_between.then(|| placement(&on_the_way(a), &on_the_way(b), ends[0] + (ends[1] - ends[0]) * implicit)),
            is_implicit: implicit == 1.0,
        }
    }

    /// Makes the rows of a joint.
    fn build_joint_rows(&mut self, number: usize, joints: &Pool<Joint, JointId>, phase: Phase) {
        let in_place = matches!(phase, Phase::Position { .. });
        let ends = if in_place { [self.left; 2] } else { [self.left, self.left - self.h] };
        let joint = &joints[self.entries[number].joint];
        let placements = self.placements_of(number, joint, phase, ends);
        let geometry = placements.geometry();
        let Self { entries, links, rates, local_poses, bodies, asked, stops, parts, topology, .. } = self;
        let (entry, link) = (&mut entries[number], &links[number]);
        let [a, b] = link.bodies.map(|body| body as usize);
        let driven =
            joint.drive().map(|drive| DrivenParts::new(drive, [&local_poses[a], &local_poses[b]], geometry.gradient, ends));
        if self.coupled && entry.counts_turns {
            entry.follow(&joint.def.kind, geometry.start);
        }
        let are_stops_far = |stops: &mut FarStops| {
            stops.are_out_of_reach((&entry.impulses, entry.angles[0]), geometry.start, [&rates[a], &rates[b]], self.rest)
        };
        let is_free = self.coupled && !in_place && are_stops_far(&mut stops[number]);
        let frames = driven.filter(|_| !in_place).map(|driven| driven.rates);
        let both = (phase, RowRates { bodies: [rates[a], rates[b]], frames });
        let load = parts.loads.get(number).copied().unwrap_or(ServoLoad::Own);
        let answer = |side: usize| match load {
            ServoLoad::Parts(parts) => parts[side],
            ServoLoad::Own | ServoLoad::Loop => answer_of(&bodies[link.bodies[side] as usize]),
        };
        let is_known = load == ServoLoad::Loop && parts.trial.is_ready;
        let trial = RefCell::new(&mut parts.trial);
        let in_loop = |way: &Jacobian| Some(trial.borrow_mut().ease_of(number, way, topology, bodies));
        let in_loop = Some(&in_loop as &dyn Fn(&Jacobian) -> Option<[f64; 2]>).filter(|_| is_known);
        let mut sink = RowSink {
            driven,
            impulses: if in_place { &JointImpulses::ZERO } else { &entry.impulses },
            rebounds: if in_place { Rebounds::NONE } else { entry.rebounds },
            share: phase.h() / self.h,
            has_stops: !is_free,
            answers: MotorAnswers { bodies: &answer, in_loop },
            left: ends[1],
            ..RowSink::new(geometry, &joint.def, both, entry.angles, asked)
        };
        if link.is_plain {
            sink.hold_points(HeldDirections::All);
        } else {
            kinds::add_rows(&mut sink);
        }
        locks::take_out(&mut sink, Freedom::of_both(bodies[a].freedom(), bodies[b].freedom()));
        self.is_under_way |= sink.is_under_way;
        let (point, direction, arrives) = (sink.point, sink.direction, sink.arrives);
        entry.pressed |= if in_place { 0 } else { arrives };
        let repeats = match self.carries_across {
            _ if link.is_plain => Redundancy::Points,
            true => Redundancy::InLine,
            false => Redundancy::Often,
        };
        self.system.add(link.bodies, point.as_ref(), direction.as_ref(), asked, repeats);
        let tension = self.tensions.get(number).copied().filter(|&tension| tension > 0.0);
        let rows = tension.and_then(|tension| {
            distance_stiffness::rows(geometry.gradient, tension, [&bodies[a], &bodies[b]], &[rates[a], rates[b]], phase)
        });
        rows.into_iter().flatten().for_each(|row| self.system.add_row(row));
    }
}

/// How a body answers to a motor.
fn answer_of(body: &DirectBody) -> BodyResponse {
    let acceleration = Rate { linear: body.acceleration, angular: body.inverse_inertia * body.torque };
    BodyResponse { inverse_mass: body.inverse_mass, inverse_inertia: body.inverse_inertia, acceleration, center: DVec3::ZERO }
}
