//! One substep of an articulation: forces, rows, the solve, and new poses.

use glam::{DMat3, DVec3, Vec3};

use super::articulation::Articulation;
use super::articulation_state::Mode;
use super::body::DirectBody;
use super::distance_stiffness::DistanceLine;
use super::multistep::{LocalError, SecondOrder};
use super::row::Origin;
use super::stiffness::{self, IMPLICIT_RANGE};
use super::system::{CONTACT_PASSES, PASSES};
use super::wide_integrator::{self, Start};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::linalg::narrowing;
use crate::solve::joint::rows::{Phase, Rate};
use crate::solve::momentum::{Inertia, Whole};
use crate::solve::rotation;
use crate::tuning::prediction::MAX_KICK;

/// Passes of the active set in a substep that the step's budget does not count: nearly all take no more.
const FREE_PASSES: usize = 4;

impl Articulation {
    /// Moves the bodies; returns the angular momentum that they should have, where joints alone act on them.
    pub(super) fn substep(&mut self, joints: &Pool<Joint, JointId>, full: f64, mode: Mode) -> Option<DVec3> {
        self.h = full;
        self.bend_paths(full);
        let momentum = self.expected_momentum(full);
        if self.is_points {
            self.find_spots();
        }
        let h = full * self.order.euler_share;
        self.weigh(h);
        self.predict(full, h, mode);
        let has_rotors = !self.rotors.is_empty();
        if has_rotors {
            self.place_rotors(full, h, mode);
        }
        if self.is_points {
            self.find_ends(mode != Mode::Safe);
        }
        self.find_stiffness(h, mode, h / full);
        let turns = self.turning.iter().any(|turning| *turning != DVec3::ZERO);
        let before = if turns { self.kinetic_energy() } else { 0.0 };
        let holds_axes = has_rotors && mode == Mode::SecondOrder;
        if holds_axes {
            self.swap_held_rotors();
        }
        let local_poses = if mode == Mode::SecondOrder { &self.predicted } else { &self.local_poses };
        wide_integrator::respond(&self.bodies4, h, local_poses, &self.stiffness, &mut self.bodies);
        if holds_axes {
            self.swap_held_rotors();
        }
        if mode == Mode::Safe {
            for (i, body) in self.bodies.iter().enumerate() {
                self.rates[i].angular = body.damped(&self.stiffness[i], &self.rates[i], h);
            }
        }
        self.ask(joints, if mode == Mode::Safe { Phase::Tangent { h } } else { Phase::Velocity { h } });
        if mode == Mode::Safe {
            self.list_approaches(h);
        }
        if turns {
            self.changes.clone_from(&self.rates);
            self.turn_along();
        }
        if has_rotors && !turns {
            self.solve_with_rotors(h, mode);
        } else {
            self.solve_rates();
        }
        if turns && self.kinetic_energy() > before {
            self.rates.clone_from(&self.changes);
            self.solve_rates();
        }
        self.keep_impulses(full / h);
        self.note_rotors();
        if mode == Mode::SecondOrder {
            wide_integrator::advance(&self.bodies4, h, &self.bodies, &mut self.local_poses, &mut self.rates);
        }
        for (i, body) in self.bodies.iter().enumerate().filter(|(_, body)| mode != Mode::SecondOrder || !body.is_dynamic()) {
            let (stance, rate) = (&mut self.local_poses[i], &mut self.rates[i]);
            body.limit_speed(rate);
            let turn = body.turn(stance, rate, h);
            stance.0 += rate.linear * h;
            stance.1 = turn.rotation;
            rate.angular = turn.angular;
        }
        self.left -= full;
        self.advance_rotors(h);
        momentum
    }

    /// Makes the bodies answer along their axes with the damping of a substep of length `h` (s).
    pub(super) fn weigh(&mut self, h: f64) {
        if self.is_damped {
            self.bodies.iter_mut().for_each(|body| body.weigh(h));
        }
    }

    /// Solves all rows for the velocities, within the step's budget of passes.
    pub(super) fn solve_rates(&mut self) {
        if self.is_points {
            self.points.solve(&self.topology, &self.bodies, &mut self.rates);
            return;
        }
        self.system.settled = true;
        let most_passes = if self.touches.is_empty() { PASSES } else { CONTACT_PASSES };
        let most_passes = most_passes.min(FREE_PASSES + self.passes_left);
        let passes = self.system.solve(&self.topology, &self.bodies, &mut self.rates, most_passes);
        self.passes_left -= passes.saturating_sub(FREE_PASSES).min(self.passes_left);
    }

    /// Kinetic energy of all bodies (J).
    pub(super) fn kinetic_energy(&self) -> f64 {
        let bodies = self.bodies.iter().zip(&self.local_poses).zip(&self.rates);
        bodies.map(|((body, stance), rate)| body.energy(stance, rate, stance)).sum()
    }

    /// Lets bodies turn with the forces that go around what they slide on: M̃⁻¹ G ω̂.
    fn turn_along(&mut self) {
        for (i, body) in self.bodies.iter().enumerate().filter(|(_, body)| body.is_dynamic()) {
            self.rates[i].angular += body.inverse_inertia * (self.stiffness[i] * self.turning[i]);
        }
    }

    fn apply_forces(&mut self, h: f64) {
        for ((body, stance), rate) in self.bodies.iter().zip(&self.local_poses).zip(&mut self.rates) {
            body.apply_forces(stance, rate, h);
        }
    }

    /// Coefficients of a second-order substep of this length, where all bodies came here by one substep.
    pub(super) fn second_order(&self, h: f64) -> Option<SecondOrder> {
        let mut moving = self.bodies.iter().zip(&self.histories).zip(&self.rates).filter(|((body, _), _)| body.is_dynamic());
        let before = self.histories.iter().map(|history| history.h).fold(0.0, f32::max);
        let together = moving.all(|((_, history), rate)| history.h == before && history.leads_to(rate));
        if together { SecondOrder::new(h, f64::from(before)) } else { None }
    }

    /// Change of velocity beyond a steady one in this substep, averaged over a step.
    pub(super) fn surprise(&mut self) -> LocalError {
        let (mut sum, mut total, mut worst) = (0.0, 0.0, 0.0_f64);
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(mass) = body.mass() {
                let (now, next) = (self.began.rates[i].linear, self.rates[i].linear);
                let mut jerk = self.histories[i].note_jerk(now, next, &self.order, self.h, self.dt).length();
                if self.has_springs {
                    jerk = jerk.max(self.angular_jerk(i));
                }
                sum += mass * jerk;
                total += mass;
                worst = worst.max(jerk);
            }
        }
        let square = self.h * self.h;
        LocalError { mean: if total > 0.0 { square * sum / total } else { 0.0 }, worst: square * worst }
    }

    /// Angular momentum at the end of a substep of an articulation that hangs on nothing, each body weighed with its damping: what
    /// joints give one body they take from another, M (1 + h c) v together.
    fn expected_momentum(&mut self, h: f64) -> Option<DVec3> {
        if self.hangs {
            return None;
        }
        self.apply_forces(h);
        let momentum = self.whole().map(|whole| whole.spin());
        self.rates.clone_from(&self.began.rates);
        momentum
    }

    /// Gives back what the substep took of the angular momentum.
    pub(super) fn keep_momentum(&mut self, expected: Option<DVec3>) {
        let (Some(expected), Some(now)) = (expected, self.whole()) else { return };
        let center = now.center() + self.origins[1];
        let Self { bodies, origins, local_poses, rates, h, .. } = self;
        let mut inertia = Inertia::ZERO;
        for i in 1..bodies.len() {
            let Some(mass) = bodies[i].free_mass() else { return };
            let [along, about] = bodies[i].weights(*h);
            inertia.add(mass * along, origins[i] + local_poses[i].0 - center, bodies[i].inertia_at(&local_poses[i]) * about);
        }
        let turn = inertia.rate_of(expected - now.spin());
        for i in 1..bodies.len() {
            rates[i].linear += turn.cross(origins[i] + local_poses[i].0 - center);
            rates[i].angular += turn;
        }
    }

    /// Sums over an articulation that hangs on nothing, positions from the first body's origin.
    fn whole(&self) -> Option<Whole> {
        if self.hangs {
            return None;
        }
        let mut whole = Whole::default();
        for i in 1..self.bodies.len() {
            let (body, stance, rate) = (&self.bodies[i], &self.local_poses[i], &self.rates[i]);
            let [along, about] = body.weights(self.h);
            let place = self.origins[i] - self.origins[1] + stance.0;
            whole.add(body.free_mass()? * along, place, rate.linear, body.spin(stance, rate) * about);
        }
        Some(whole)
    }

    /// Adds the forces, and finds where the bodies would be at the end of the substep without any joint.
    fn predict(&mut self, full: f64, h: f64, mode: Mode) {
        self.predicted.clear();
        if mode == Mode::SecondOrder {
            self.predict_second_order(full, h);
            return;
        }
        self.apply_forces(h);
        if mode != Mode::Smooth {
            return self.predicted.extend_from_slice(&self.local_poses);
        }
        let Self { bodies, rates, local_poses, began, predicted, .. } = self;
        for (i, body) in bodies.iter().enumerate() {
            let (stance, rate) = (&local_poses[i], &rates[i]);
            let before = began.rates[i].angular;
            let kick = (rate.angular - before) * h;
            let angular = match kick.length_squared() > MAX_KICK * MAX_KICK {
                true => before + kick.clamp_length_max(MAX_KICK) / h,
                false => rate.angular,
            };
            let turning = Rate { linear: rate.linear, angular };
            predicted.push((stance.0 + rate.linear * h, body.turn(stance, &turning, h).rotation));
        }
    }

    /// Puts bodies where their second-order substep starts, `full` long with an Euler part of `h`, and finds where that ends.
    fn predict_second_order(&mut self, full: f64, h: f64) {
        let Self { bodies, bodies4, order, histories, local_poses, rates, predicted, .. } = self;
        predicted.extend_from_slice(local_poses);
        wide_integrator::predict(bodies4, order, h, histories, &mut Start { local_poses, rates, predicted });
        // A body that is moved by others arrives where a whole substep takes it.
        for i in (0..bodies.len()).filter(|&i| !bodies[i].is_dynamic()) {
            let (stance, rate) = (&mut local_poses[i], &rates[i]);
            let rest = full - h;
            stance.0 += rate.linear * rest;
            stance.1 = rotation::rotated(stance.1, rate.angular * rest);
            predicted[i] = (stance.0 + rate.linear * h, rotation::rotated(stance.1, rate.angular * h));
        }
    }

    /// Stiffness of each body from the carried impulses, and with it where each joint takes its Jacobian.
    ///
    /// `share` is what a substep of this length has of the impulses of a whole one.
    pub(super) fn find_stiffness(&mut self, h: f64, mode: Mode, share: f64) {
        self.stiffness.clear();
        self.stiffness.resize(self.bodies.len(), DMat3::ZERO);
        self.find_slender();
        self.turning.clear();
        self.turning.resize(self.bodies.len(), DVec3::ZERO);
        self.implicit.clear();
        self.tensions.clear();
        for touch in self.touches.iter().filter(|_| mode == Mode::Safe) {
            if let Some((stiffness, turning)) = touch.stiffness(&self.local_poses, &self.step_start, &self.rates) {
                self.stiffness[touch.body as usize] += stiffness * (h * share);
                self.turning[touch.body as usize] = turning;
            }
        }
        for (number, (link, entry)) in self.links.iter().zip(&self.entries).enumerate() {
            let line = if entry.is_distance { self.line_of(number) } else { None };
            let pull = line.as_ref().map_or(DVec3::ZERO, |line| line.direction * -line.pull);
            let impulse = (entry.impulses.point.as_dvec3() + pull) * share;
            let ease = self.eases[number]
                + line.as_ref().map_or(0.0, |line| line.ease(link.bodies.map(|body| &self.bodies[body as usize])));
            let levers = if self.is_points {
                self.points.ends[number].levers
            } else {
                [0, 1].map(|side| self.local_poses[link.bodies[side] as usize].1 * entry.local_lever[side])
            };
            let implicit = if mode == Mode::Safe {
                1.0
            } else {
                ((h * impulse.length() * ease - IMPLICIT_RANGE.0) / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0)).clamp(0.0, 1.0)
            };
            self.implicit.push(if mode == Mode::SecondOrder { 1.0 } else { implicit });
            self.tensions.push(line.map_or(0.0, |line| line.pull * share * h * implicit));
            if impulse == DVec3::ZERO || implicit == 0.0 {
                continue;
            }
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let body = link.bodies[side] as usize;
                let (impulse, lever) = (impulse * sign, levers[side]);
                let mut stiffness = stiffness::of_impulse(impulse, lever);
                let slender = self.slender[body];
                if slender != DVec3::ZERO {
                    let ahead = self.is_points && mode != Mode::Safe;
                    let pose = if ahead { &self.predicted[body] } else { &self.local_poses[body] };
                    stiffness += stiffness::about_axis(impulse, lever, pose.1 * slender);
                }
                self.stiffness[body] += stiffness * (h * implicit);
            }
        }
    }

    /// Finds the slender bodies that forces at points alone act on. Where a joint bears moments, or a contact pushes, what the forces of joints
    /// turn a body by is no torque that is left over.
    fn find_slender(&mut self) {
        let Self { slender, bodies, links, touches, .. } = self;
        slender.clear();
        slender.extend(bodies.iter().map(DirectBody::length));
        let moments = links.iter().filter(|link| !link.is_plain).flat_map(|link| link.bodies);
        let contacts = touches.iter().flat_map(|touch| [touch.body, touch.other]);
        moments.chain(contacts).for_each(|body| slender[body as usize] = DVec3::ZERO);
    }

    /// Line of a distance joint that pulls, at the poses of now.
    fn line_of(&self, number: usize) -> Option<DistanceLine> {
        let (link, entry) = (&self.links[number], &self.entries[number]);
        let [a, b] = link.bodies.map(|body| &self.local_poses[body as usize]);
        DistanceLine::of(entry, entry.points(a, b).gap)
    }

    /// Hands the multipliers back to the joints and adds them to their loads.
    ///
    /// `scale` is the length of the whole substep over that of the one they were found for. In one of second order the last
    /// substep's impulse and forces act too, as what they changed is extrapolated: loads count what changes momentum, and a blow
    /// counts once.
    pub(super) fn keep_impulses(&mut self, scale: f64) {
        if self.is_points {
            return self.keep_point_impulses(scale);
        }
        let (carried, steady) = (self.order.extrapolation, self.order.steady_share);
        let Self { entries, system, links, local_poses, touches, .. } = self;
        system.drop_senseless();
        for ((entry, node), link) in entries.iter_mut().zip(&system.nodes).zip(&*links) {
            let (mut point, mut angular) = (DVec3::ZERO, DVec3::ZERO);
            let (mut linear_load, mut angular_load) = (DVec3::ZERO, DVec3::ZERO);
            let mut last = [entry.impulses.point.as_dvec3(), entry.impulses.angular.as_dvec3()];
            let lever = local_poses[link.bodies[1] as usize].1 * entry.local_lever[1];
            for row in &system.rows[node.first as usize..node.last as usize] {
                let impulse = row.impulse * scale;
                match row.origin {
                    Origin::Point => point += row.linear[1] * impulse,
                    Origin::Direction => angular += row.angular[1] * impulse,
                    Origin::Scalar(id) => {
                        let before = std::mem::replace(&mut entry.impulses.scalar[id as usize], impulse as f32);
                        if let Some(axis) = entry.motors.rows.axis(id) {
                            entry.motors.sums[axis] += impulse as f32;
                        }
                        let moment = row.angular[1] - lever.cross(row.linear[1]);
                        linear_load += row.linear[1] * impulse;
                        angular_load += moment * impulse;
                        last[0] += row.linear[1] * f64::from(before);
                        last[1] += moment * f64::from(before);
                    }
                    Origin::Across | Origin::Contact => {}
                }
            }
            entry.impulses.point = narrowing::impulse(point);
            entry.impulses.angular = narrowing::impulse(angular);
            let acted = |found: DVec3, last: DVec3, acted: Vec3| {
                narrowing::impulse(found / scale + last * steady + acted.as_dvec3() * carried)
            };
            entry.pressed |= entry.impulses.pressing();
            entry.acted =
                [acted(point + linear_load, last[0], entry.acted[0]), acted(angular + angular_load, last[1], entry.acted[1])];
            entry.linear_sum += entry.acted[0];
            entry.angular_sum += entry.acted[1];
        }
        for (index, touch) in touches.iter_mut().enumerate() {
            touch.keep_impulses(system, index);
        }
    }
}
