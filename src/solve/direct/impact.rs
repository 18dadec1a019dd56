//! The impact when a stop is met: the end of a slider or of a hinge's range, a rope that goes taut.
//!
//! The substep in which a stop closes ends with the bodies at the stop, C = 0, and still approaching it by what was left of the way,
//! −J v = C₀/h. How much that is says only when in the substep the stop was met. So an impact follows, over no time: no force acts but
//! those of rigid rows,
//!
//! ```text
//! v⁺ = v + M⁻¹ Jᵀ p,     J v⁺ = 0 of what joints hold,     J v⁺ ≥ 0,  p ≥ 0 of the stops that press,
//! ```
//!
//! with the bodies' own masses M: nothing has turned in no time, so that no geometric stiffness takes part. The impulse is the one that the
//! effective mass of the whole articulation gives; momentum is kept, and kinetic energy can only fall (v⁺ is the projection of v on what
//! is allowed, in the metric of M).
//!
//! **Restitution.** Stops that give back e of the speed v⁻ at which they were met ([`rebound`](crate::solve::joint::rebound)) are then asked for
//! J v ≥ e v⁻, once more with all else that holds or presses. For one e that is Poisson's rule: what stopped the bodies acts once more by the
//! share e, so that no energy comes of it, as seen from what the host moves. Where several stops with different e are met at once it may: then as much of it acts as
//! energy allows.

use glam::{DMat3, DVec3};

use super::articulation::Articulation;
use super::body::DirectBody;
use super::row::{Origin, RowState};
use super::system::PASSES;
use super::wide_integrator;
use crate::id::{JointId, Pool};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::Joint;
use crate::linalg::narrowing;
use crate::solve::joint::body_response::MotorAnswers;
use crate::solve::joint::driven::{self, DrivenParts};
use crate::solve::joint::geometry::JointGeometry;
use crate::solve::joint::kinds;
use crate::solve::joint::locks::{self, Freedom};
use crate::solve::joint::row_sink::RowSink;
use crate::solve::joint::rows::{Phase, Rate, RowRates, ScalarRow};
use crate::solve::joint::{LocalPose, rebound};
use crate::solve::rotation;

/// Length of a substep (s) over which what is left of a gap asks for no speed. What the host moves of a joint asks for its own.
pub(super) const LONG: f64 = 1.0e9;

/// Gain of kinetic energy by an impact that is rounding.
const ROUNDING: f64 = 1.0e-6;

/// Greatest share of what stops give back with which bodies have no more than `most` of the energy (J) that they have with none of it, half and
/// all: energy is of second degree in velocities.
fn share_within(most: f64, [none, half, all]: [f64; 3]) -> f64 {
    let square = 2.0 * (none + all - 2.0 * half);
    let slope = all - none - square;
    let root = (slope * slope + 4.0 * square * (most - none)).max(0.0).sqrt();
    // Twice the product of both roots over the other one: no difference of what is nearly alike.
    let share = if slope > 0.0 { 2.0 * (most - none) / (slope + root) } else { (root - slope) / (2.0 * square) };
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
}

/// A stop as a substep begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopState {
    /// Number of its row.
    pub id: u8,
    /// How far it is (m, rad), and how that changes.
    pub distance: f64,
    pub rate: f64,
    /// What a unit of its impulse changes of the rate, with the rest of the joint held (1/kg, 1/(kg·m²)).
    pub ease: f64,
}

impl StopState {
    /// C̈ of it, where the stops were so a substep of length `h` (s) before: C then was C − Ċ h + ½ C̈ h² to second order.
    pub(super) fn acceleration(&self, before: &[Self], h: f64) -> f64 {
        let last = before.iter().find(|last| last.id == self.id).map_or(self.distance - self.rate * h, |last| last.distance);
        if h > 0.0 { 2.0 * (last - self.distance + self.rate * h) / (h * h) } else { 0.0 }
    }
}

impl Articulation {
    /// Rigid stops of a joint that press and did not before this substep, as bits of their rows.
    fn met_by(&self, number: usize, joints: &Pool<Joint, JointId>) -> u32 {
        if self.entries[number].traits.has_soft_stops { 0 } else { self.newly_pressing(number, joints) }
    }

    /// Stops of a joint that press and did not before this substep, as bits of their rows.
    pub(super) fn newly_pressing(&self, number: usize, joints: &Pool<Joint, JointId>) -> u32 {
        let (entry, before) = (&self.entries[number], &self.began.joints[number]);
        let met = entry.impulses.pressing() & !before.pressing;
        if met != 0 && joints[entry.joint].stops_of(met) != 0 { met } else { 0 }
    }

    /// Whether a stop presses that did not before this substep.
    pub(super) fn meets_stop(&self, joints: &Pool<Joint, JointId>) -> bool {
        !self.is_points && (0..self.entries.len()).any(|number| self.met_by(number, joints) != 0)
    }

    /// Whether a motor lets go in this substep: one that pushes one way alone, or one that has done all it can and is where it was to be. A substep
    /// of second order goes on with a share of what it did in the last, which one that pushes one way can't take back, nor any from what hangs
    /// on a rope: from rest a joint would come to 1.5 times its target, and what it draws up fly on. That is a jolt to the substeps that follow.
    pub(super) fn lets_go_of_motor(&mut self) -> bool {
        let of_whole = 1.0 / self.order.euler_share;
        let lets_go = self.system.bounded.iter().any(|&(row, node)| {
            let (row, node) = (&self.system.rows[row as usize], node as usize);
            let (Origin::Scalar(id), Some(before)) = (row.origin, self.began.joints.get(node)) else { return false };
            let before = f64::from(before.impulses.scalar[id as usize]);
            if row.drives_one_way() {
                return row.impulse == 0.0 && before != 0.0;
            }
            let is_motor = row.drives && self.entries[node].motors.rows.axis(id).is_some();
            is_motor && row.is_at_bound(before / of_whole) && !row.is_at_bound(row.impulse)
        });
        self.is_jolted |= lets_go;
        lets_go
    }

    /// Ends a substep in which a stop was met by the impact that follows: what presses approaches no more, and stops with restitution are left
    /// at the speeds of `leaving`, by joint and row. Joints go on with the multipliers of the substep.
    pub(super) fn resolve_impact(&mut self, joints: &Pool<Joint, JointId>, leaving: &[(usize, u8, f64)]) {
        self.end_approach(joints);
        if !leaving.is_empty() {
            self.leave_stops(joints, leaving);
        }
        self.go_on_without_blow(leaving);
    }

    /// The first part of an impact: what presses approaches no more.
    pub(super) fn end_approach(&mut self, joints: &Pool<Joint, JointId>) {
        self.stiffness.fill(DMat3::ZERO);
        wide_integrator::respond(&self.bodies4, 0.0, &self.local_poses, &self.stiffness, &mut self.bodies);
        self.predicted.clone_from(&self.local_poses);
        self.tensions.fill(0.0);
        self.ask(joints, Phase::Tangent { h: LONG });
        for (number, node) in self.system.nodes.iter().enumerate().take(self.entries.len()) {
            let pressing = self.entries[number].impulses.pressing();
            for row in &mut self.system.rows[node.first as usize..node.last as usize] {
                let acts = match row.origin {
                    Origin::Contact => false,
                    Origin::Scalar(id) if row.is_stop() => row.gamma == 0.0 && pressing >> id & 1 == 1,
                    Origin::Scalar(id) if self.entries[number].motors.rows.axis(id).is_some() => false,
                    _ => row.gamma == 0.0 && !row.has_bounds(),
                };
                row.state = if acts { RowState::Free } else { RowState::Absent };
            }
        }
        // Nor do contacts that stand in nodes of their own: none of them presses, and without a substep's length any gap would be closed.
        let contacts = self.system.nodes.get(self.entries.len()).map_or(self.system.rows.len(), |node| node.first as usize);
        self.system.rows[contacts..].iter_mut().for_each(|row| row.state = RowState::Absent);
        self.blow(1.0);
    }

    /// Solves the rows of an impact, and adds this share of the multipliers to the loads of the joints.
    fn blow(&mut self, share: f64) {
        self.system.rows.iter_mut().for_each(|row| row.impulse = 0.0);
        self.system.begin(&self.bodies);
        self.system.solve(&self.topology, &self.bodies, &mut self.rates, PASSES);
        let Self { entries, system, links, local_poses, .. } = self;
        for ((entry, node), link) in entries.iter_mut().zip(&system.nodes).zip(&*links) {
            let lever = local_poses[link.bodies[1] as usize].1 * entry.local_lever[1];
            let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            for row in system.rows[node.first as usize..node.last as usize].iter().filter(|row| row.state != RowState::Absent) {
                let about = match row.origin {
                    Origin::Point => DVec3::ZERO,
                    Origin::Direction => row.angular[1],
                    _ => row.angular[1] - lever.cross(row.linear[1]),
                };
                force += row.linear[1] * row.impulse;
                moment += about * row.impulse;
            }
            entry.linear_sum += narrowing::impulse(force * share);
            entry.angular_sum += narrowing::impulse(moment * share);
        }
    }

    /// Lets stops be left, at no more energy than the bodies had when the substep began.
    fn leave_stops(&mut self, joints: &Pool<Joint, JointId>, leaving: &[(usize, u8, f64)]) {
        for &(number, id, _) in leaving {
            let node = &self.system.nodes[number];
            let mut rows = self.system.rows[node.first as usize..node.last as usize].iter_mut();
            if let Some(row) = rows.find(|row| row.origin == Origin::Scalar(id)) {
                row.state = RowState::Free;
            }
        }
        let carried = self.carried_along(joints);
        for &(number, id, speed) in leaving {
            let node = &self.system.nodes[number];
            let mut rows = self.system.rows[node.first as usize..node.last as usize].iter_mut();
            if let Some(row) = rows.find(|row| row.origin == Origin::Scalar(id)) {
                row.bias -= speed;
            }
        }
        let stopped = self.rates.clone();
        self.blow(1.0);
        let most = self.energy_at_start(&carried);
        let left = self.rates.clone();
        let mut at = |share: f64| {
            for ((rate, stopped), left) in self.rates.iter_mut().zip(&stopped).zip(&left) {
                rate.linear = stopped.linear.lerp(left.linear, share);
                rate.angular = stopped.angular.lerp(left.angular, share);
            }
            self.energy_beside(&carried, &self.local_poses, &self.rates, self.left)
        };
        let all = at(1.0);
        if all > most {
            let energies = [at(0.0), at(0.5), all];
            at(share_within(most, energies));
        }
    }

    /// What the bodies would do by what the host moves alone, as the rows of an impact hold and press; empty where it moves nothing.
    ///
    /// What the host moves does work, and how much depends on who looks. Seen from what moves along, none of the rows does any.
    fn carried_along(&mut self, joints: &Pool<Joint, JointId>) -> Vec<Rate> {
        let moves = |(body, rate): (&DirectBody, &Rate)| !body.is_dynamic() && *rate != Rate::ZERO;
        let is_driven = self.entries.iter().any(|entry| joints[entry.joint].drive().is_some());
        if !is_driven && !self.bodies.iter().zip(&self.rates).any(moves) {
            return Vec::new();
        }
        let mut carried = self.rates.clone();
        carried.iter_mut().zip(&self.bodies).filter(|(_, body)| body.is_dynamic()).for_each(|(rate, _)| *rate = Rate::ZERO);
        self.system.begin(&self.bodies);
        self.system.solve_active(&self.topology, &self.bodies, &mut carried);
        carried
    }

    /// Kinetic energy less the work of forces since the start of the step, as seen from what moves at the rates `carried` (J); the poses are those
    /// of so long before its end (s).
    fn energy_beside(&self, carried: &[Rate], poses: &[LocalPose], rates: &[Rate], left: f64) -> f64 {
        let bodies = self.bodies.iter().zip(rates).zip(poses.iter().zip(&self.step_start));
        if carried.is_empty() {
            return bodies.map(|((body, rate), (stance, start))| body.energy(stance, rate, start)).sum();
        }
        let energies = bodies.zip(carried).map(|(((body, rate), (stance, start)), along)| {
            let seen = Rate { linear: rate.linear - along.linear, angular: rate.angular - along.angular };
            body.energy(stance, &seen, start) + body.power(along) * (self.dt - left)
        });
        energies.sum()
    }

    /// The same when the substep began, and a little for rounding.
    fn energy_at_start(&self, carried: &[Rate]) -> f64 {
        let energy = self.energy_beside(carried, &self.began.local_poses, &self.began.rates, self.began.left);
        energy + ROUNDING * self.kinetic_energy()
    }

    /// Stops with restitution that this substep has met, by joint and row, and the speeds at which they are to be left.
    pub(super) fn approaches_at_start(&mut self, joints: &Pool<Joint, JointId>, knows_past: bool) -> Vec<(usize, u8, f64)> {
        let mut leaving = Vec::new();
        for number in 0..self.entries.len() {
            let restitution = f64::from(self.entries[number].restitution);
            let met = if restitution > 0.0 { self.met_by(number, joints) } else { 0 };
            if met == 0 {
                continue;
            }
            let bodies = self.links[number].bodies.map(|body| body as usize);
            let (local_poses, rates) =
                (bodies.map(|body| self.began.local_poses[body]), bodies.map(|body| self.began.rates[body]));
            let (h, past) = (
                f64::from(self.histories[bodies[0]].h.max(self.histories[bodies[1]].h)),
                bodies.map(|body| self.stance_before(body)),
            );
            let left = self.began.left;
            let starts = self.stops_at(number, joints, local_poses, rates, left);
            let before = if knows_past { self.stops_at(number, joints, past, rates, left + h) } else { Vec::new() };
            for stop in starts.iter().filter(|stop| met >> stop.id & 1 == 1) {
                let acceleration = stop.acceleration(&before, h);
                leaving.push((number, stop.id, restitution * rebound::speed_of_impact(stop.distance, stop.rate, acceleration)));
            }
        }
        leaving
    }

    /// Where a body stood at the start of the last substep before this one.
    pub(super) fn stance_before(&self, body: usize) -> LocalPose {
        let (history, (place, rotation)) = (&self.histories[body], self.began.local_poses[body]);
        if !self.bodies[body].is_dynamic() {
            let (rate, h) = (&self.began.rates[body], self.histories.iter().map(|history| history.h).fold(0.0, f32::max));
            return (place - rate.linear * f64::from(h), rotation::rotated(rotation, -rate.angular * f64::from(h)));
        }
        if history.h <= 0.0 {
            return (place, rotation);
        }
        let before = rotation::rotated(self.unspun(body, rotation), -history.turn.as_dvec3());
        (place - history.displacement.as_dvec3(), before)
    }

    /// Stops of a joint between bodies that stand and move so, so long before the end of the step (s).
    pub(super) fn stops_at(
        &mut self,
        number: usize,
        joints: &Pool<Joint, JointId>,
        local_poses: [LocalPose; 2],
        rates: [Rate; 2],
        left: f64,
    ) -> Vec<StopState> {
        let (entry, bodies) = (&self.entries[number], self.links[number].bodies.map(|body| &self.bodies[body as usize]));
        let drive = joints[entry.joint].drive();
        let [a, b] = [&local_poses[0], &local_poses[1]];
        let placement = driven::before(entry.placement(*a, *b), drive, [a, b], left);
        let driven = drive.map(|drive| DrivenParts::new(drive, [a, b], &placement, [left; 2]));
        let rates = RowRates { bodies: rates, frames: driven.map(|driven| driven.rates) };
        let all = (Phase::Position { most: f64::INFINITY }, rates);
        let geometry = JointGeometry::at(&placement);
        let answer = |side: usize| bodies[side].answer_at(&local_poses[side]);
        let answers = MotorAnswers { bodies: &answer, in_loop: None };
        // Of the substep's start: at its end what spins may be half a turn away from where it was before.
        let angles = self.began.joints[number].angles;
        let mut sink =
            RowSink { driven, answers, ..RowSink::new(geometry, &joints[entry.joint].def, all, angles, &mut self.asked) };
        kinds::add_rows(&mut sink);
        let locks = Freedom::of_both(bodies[0].freedom(), bodies[1].freedom());
        let stops = sink.scalars.iter().filter(|row| row.is_stop() && !locks.is_some_and(|locks| locks::hold(locks, row)));
        let state = |row: &ScalarRow| StopState {
            id: row.id,
            distance: row.bias,
            rate: row.jacobian.rate(&rates.bodies) + row.driven,
            ease: sink.ease_along(&row.jacobian),
        };
        stops.map(state).collect()
    }

    /// Lists the stops with restitution that may be met in a substep of first order, of length `h` (s), whose rows have just been built.
    pub(super) fn list_approaches(&mut self, h: f64) {
        self.approaches.clear();
        if !self.rebounds || self.is_points {
            return;
        }
        for (entry, node) in self.entries.iter().zip(&self.system.nodes).filter(|(entry, _)| entry.restitution > 0.0) {
            let rates = node.bodies.map(|body| self.rates[body as usize]);
            let forces = node.bodies.map(|body| Rate { linear: self.bodies[body as usize].acceleration, angular: DVec3::ZERO });
            for number in node.first..node.last {
                let row = &self.system.rows[number as usize];
                let Origin::Scalar(id) = row.origin else { continue };
                if row.is_stop() && entry.impulses.scalar[id as usize] <= 0.0 {
                    let distance = (row.bias - row.driven).max(0.0) * h;
                    let rate = row.rate(&rates) + row.driven;
                    let speed = rebound::speed_after(entry.restitution, distance, rate, row.rate(&forces), h);
                    self.approaches.push((number, speed));
                }
            }
        }
    }

    /// Notes which of the stops that might be met have been, and are to be left in the next substep.
    pub(super) fn note_rebounds(&mut self) {
        if !self.rebounds {
            return;
        }
        let Self { entries, system, approaches, .. } = self;
        for (entry, node) in entries.iter_mut().zip(&system.nodes) {
            entry.rebounds = Rebounds::NONE;
            for &(number, speed) in approaches.iter().filter(|(number, _)| (node.first..node.last).contains(number)) {
                let row = &system.rows[number as usize];
                if let (Origin::Scalar(id), true) = (row.origin, row.impulse > 0.0) {
                    entry.rebounds.add(id, speed as f32);
                }
            }
        }
    }

    /// Has joints go on with the multipliers of the substep; stops that are left press no more.
    fn go_on_without_blow(&mut self, leaving: &[(usize, u8, f64)]) {
        self.entries.iter_mut().for_each(|entry| entry.rebounds = Rebounds::NONE);
        for &(number, row, _) in leaving.iter().filter(|(_, _, speed)| *speed > 0.0) {
            self.entries[number].impulses.scalar[row as usize] = 0.0;
        }
    }
}
