//! The rotors of an articulation through its substeps. See [`super::rotor`].

use glam::{DQuat, DVec3};

use super::articulation::Articulation;
use super::articulation_state::Mode;
use super::body::{is_slender, thinnest};
use super::multistep::rotation_vector;
use super::rotor::Rotor;
use super::stiffness::IMPLICIT_RANGE;
use super::wide_integrator;
use crate::linalg::narrowing;
use crate::solve::rotation;

/// Share by which the error of passes must fall in each: substeps get so short. Where it does not, what is not symmetric keeps the velocity that
/// it has before joints act. Above one the error grows: at 1000 rad/s a gyroscope on an arm of 0.5 m fell by 1 cm at once in a substep of 1/30 s.
pub(super) const MUST_FALL: f64 = 0.5;

/// Most by which a rotor that is not symmetric may turn in a substep (rad): passes that find where it ends go on falling up to twice that.
const MAX_TURN: f64 = 0.4;

/// Error of the axis at the end of a substep that passes leave (rad): ten seconds of a thousand substeps each add up to 1e-3.
const AXIS_ERROR: f64 = 1.0e-7;

/// Gain of kinetic energy in a safe substep that is rounding.
const ROUNDING: f64 = 1.0e-6;

/// Angular momentum of a spin, over that with which the forces of joints swing its axis, up to which these hold the axis where they turn it
/// faster than a substep resolves: the rods of a falling tree under boxes of ten tonnes are at 0.01, gyroscopes above one. Test: tests/rotors.rs.
const MIN_MOMENT: f64 = 0.1;

/// Passes that a substep may take for its rotors.
const MAX_PASSES: usize = 6;

impl Articulation {
    /// Finds the rotors among the bodies for a step; what spins so fast that joints feel the mean of its moments gets that.
    pub(super) fn find_rotors(&mut self) {
        self.rotors.clear();
        for number in 0..self.bodies.len() {
            let state = (&self.local_poses[number], &self.rates[number]);
            let known = self.histories[number].spin_turn != 0.0;
            self.rotors.extend(Rotor::of(number, &self.bodies[number], state, known, self.world_substep));
        }
        if !self.rotors.is_empty() {
            self.leave_held_rotors();
        }
        if !self.rotors.is_empty() {
            self.find_shafts();
        }
        for rotor in self.rotors.iter().filter(|rotor| rotor.is_blurred) {
            let top = &mut self.bodies[rotor.body].top;
            let is_axis = (top.frame.conjugate() * rotor.axis).abs().cmpgt(DVec3::splat(0.5));
            top.inertia = DVec3::select(is_axis, top.inertia, DVec3::splat(rotor.across));
        }
        for (number, history) in self.histories.iter_mut().enumerate().filter(|(_, history)| history.spin_turn != 0.0) {
            let found = self.rotors.binary_search_by_key(&number, |rotor| rotor.body);
            if !found.is_ok_and(|at| self.rotors[at].by_axis) {
                // It spins no faster than others: both ways in one vector again.
                let (top, rotation) = (&self.bodies[number].top, self.local_poses[number].1);
                let spun = f64::from(history.spin_turn);
                let spun = if is_slender(&top.inertia) {
                    rotation * top.frame * DVec3::AXES[thinnest(&top.inertia)] * spun
                } else {
                    self.rates[number].angular.normalize_or_zero() * spun.abs()
                };
                history.turn = narrowing::way(history.turn.as_dvec3() + spun);
                history.spin_turn = 0.0;
            }
        }
        if self.rotors.iter().any(|rotor| rotor.is_blurred) {
            wide_integrator::gather(&mut self.bodies4, &self.bodies);
        }
    }

    /// Leaves out rotors whose axes the forces of joints turn faster than a substep resolves, and by far more than spin does: the light rods of
    /// a tree under tonnes. With f the forces at levers r, (A f r)^½ is the moment of momentum with which the axis swings in them.
    fn leave_held_rotors(&mut self) {
        let Self { rotors, links, entries, rates, local_poses, rotor_loads, world_substep, .. } = self;
        rotor_loads.clear();
        rotor_loads.resize(rates.len(), 0.0);
        for (link, entry) in links.iter().zip(&*entries) {
            let force = f64::from(entry.impulses.point.length()) / *world_substep;
            for side in 0..2 {
                rotor_loads[link.bodies[side] as usize] += force * entry.local_lever[side].length();
            }
        }
        rotors.retain(|rotor| {
            let load = rotor_loads[rotor.body];
            let spin = rates[rotor.body].angular.dot(local_poses[rotor.body].1 * rotor.axis);
            let is_held = load * *world_substep * *world_substep > IMPLICIT_RANGE.1 * rotor.across;
            !is_held || (rotor.along * spin).powi(2) > MIN_MOMENT * MIN_MOMENT * rotor.across * load
        });
    }

    /// Takes slender bodies in joints with rotors along with these, all in the order of their bodies.
    fn find_shafts(&mut self) {
        let Self { rotors, links, bodies, rates, local_poses, world_substep, .. } = self;
        let spinning = rotors.len();
        for link in &*links {
            let ends = link.bodies.map(|body| body as usize);
            let spins = ends.map(|body| rotors[..spinning].binary_search_by_key(&body, |rotor| rotor.body).is_ok());
            let number = match spins {
                [true, false] => ends[1],
                [false, true] => ends[0],
                _ => continue,
            };
            if rotors[spinning..].iter().all(|shaft| shaft.body != number) {
                let state = (&local_poses[number], &rates[number]);
                rotors.extend(Rotor::of_shaft(number, &bodies[number], state, *world_substep));
            }
        }
        rotors.sort_unstable_by_key(|rotor| rotor.body);
    }

    /// Puts rotors where the Euler part, `h` long, of a substep starts, and finds where it leads to without joints.
    pub(super) fn place_rotors(&mut self, full: f64, h: f64, mode: Mode) {
        let Self { rotors, bodies, began, histories, order, local_poses, rates, predicted, .. } = self;
        for rotor in rotors {
            let number = rotor.body;
            let (body, history) = (&bodies[number], &histories[number]);
            let (from, before) = (&began.local_poses[number], &began.rates[number]);
            (rotor.held, rotor.pose, rotor.kick, rotor.is_left) = (from.1 * rotor.axis, from.1, DVec3::ZERO, false);
            let (spin, rest) = rotor.split(before.angular);
            (rotor.start, rotor.first, rotor.spun_before, rotor.carried) = (from.1, rotor.held, 0.0, 0.0);
            if mode == Mode::SecondOrder {
                let (share, steady) = (order.extrapolation, order.steady_share * full);
                let about = rotor.along * spin;
                let axis_before = rotation::quaternion_of(-history.turn.as_dvec3()) * rotor.held;
                let torque = history.torque.as_dvec3().dot(rotor.held);
                rotor.carried = (about - history.momentum_before.as_dvec3().dot(axis_before)) * share + torque * steady;
                let about = about + rotor.carried;
                if rotor.by_axis {
                    let (way, spun) = rotor.ways(history);
                    rotor.spun_before = spun * share + spin * steady;
                    let spun = rotation::quaternion_of(rotor.axis * rotor.spun_before);
                    rotor.start = (rotation::rotated(from.1, way * share + rest * steady) * spun).normalize();
                    rotor.pose = rotor.turned(before.angular, h);
                } else {
                    rotor.start = rotation::rotated(from.1, history.turn.as_dvec3() * share + before.angular * steady);
                    rotor.pose = rotation::rotated(rotor.start, before.angular * h);
                }
                rotor.first = rotor.start * rotor.axis;
                rotor.held = rotor.pose * rotor.axis;
                let momentum = body.spin(from, before);
                let momentum = momentum
                    + (momentum - history.momentum_before.as_dvec3()) * share
                    + history.torque.as_dvec3() * steady
                    + body.torque * h;
                let angular = if rotor.by_axis {
                    rotor.angular_of(momentum, about + body.torque.dot(rotor.held) * h)
                } else {
                    rotor.angular_at(rotor.pose, momentum)
                };
                rates[number].angular = angular / body.weights(h)[1];
                local_poses[number].1 = rotor.start;
            } else {
                rotor.kick = rotor.kick_of(before.angular, h);
            }
            if mode != Mode::Safe {
                predicted[number].1 = rotor.turned(rates[number].angular, h);
            }
        }
    }

    /// Lets rotors answer with the axis that is held for them where the bodies of a second-order substep are predicted to be; called
    /// once more, puts them back.
    pub(super) fn swap_held_rotors(&mut self) {
        for rotor in &mut self.rotors {
            std::mem::swap(&mut self.predicted[rotor.body].1, &mut rotor.pose);
        }
    }

    /// Solves all rows for the velocities, with what the axes of rotors carry along; in a safe substep only where that gains no energy.
    pub(super) fn solve_with_rotors(&mut self, h: f64, mode: Mode) {
        let mut base = std::mem::take(&mut self.rotor_base);
        base.clone_from(&self.rates);
        let most = if mode == Mode::Safe { self.kinetic_energy() * (1.0 + ROUNDING) } else { f64::INFINITY };
        let mut before = f64::INFINITY;
        for pass in 1..=MAX_PASSES {
            for rotor in &self.rotors {
                let body = &self.bodies[rotor.body];
                // As all that changes velocities in a safe substep.
                let kick = if mode == Mode::Safe { body.inverse_inertia * (body.inertia * rotor.kick) } else { rotor.kick };
                self.rates[rotor.body].angular += kick;
            }
            self.solve_rates();
            let worst = self.worst_kick(h);
            let share = worst / before;
            self.rotor_share = self.rotor_share.max(share);
            self.rotors_diverge = worst > AXIS_ERROR && share > 1.0;
            if worst <= AXIS_ERROR || pass == MAX_PASSES {
                break;
            }
            self.rates.clone_from(&base);
            if share > MUST_FALL {
                self.rotors.iter_mut().filter(|rotor| !rotor.by_axis).for_each(|rotor| rotor.kick = DVec3::ZERO);
            }
            before = worst;
        }
        if most < f64::INFINITY && self.kinetic_energy() > most {
            self.rates.clone_from(&base);
            self.rotors.iter_mut().for_each(|rotor| (rotor.kick, rotor.is_left) = (DVec3::ZERO, true));
            self.solve_rates();
        }
        self.rotor_base = base;
    }

    /// Finds what the axes of rotors carry along at the velocities of now, and returns by how much the axis of one was off at most (rad).
    fn worst_kick(&mut self, h: f64) -> f64 {
        let mut worst = 0.0_f64;
        let Self { rotors, rates, .. } = self;
        for rotor in rotors {
            let angular = rates[rotor.body].angular;
            let kick = rotor.kick_of(angular, h);
            let carried = rotor.along * angular.length();
            worst = worst.max((kick - rotor.kick).length() * rotor.across / carried.max(f64::MIN_POSITIVE));
            rotor.kick = kick;
        }
        worst
    }

    /// Notes what joints have left rotors of angular velocity, before all bodies are moved.
    pub(super) fn note_rotors(&mut self) {
        for rotor in &mut self.rotors {
            rotor.found = self.rates[rotor.body].angular;
        }
    }

    /// Moves rotors to the end of a substep whose Euler part is `h` long.
    pub(super) fn advance_rotors(&mut self, h: f64) {
        for rotor in &mut self.rotors {
            let angular = rotor.found;
            if rotor.is_left {
                rotor.spun = rotor.split(angular).0 * h;
                continue;
            }
            if !rotor.by_axis {
                (self.local_poses[rotor.body].1, self.rates[rotor.body].angular) = (rotor.turned(angular, h), angular);
                continue;
            }
            let (spin, rest) = rotor.split(angular);
            let turned = rotor.turned(angular, h);
            let axis = turned * rotor.axis;
            rotor.spun = rotor.spun_before + spin * h;
            self.local_poses[rotor.body].1 = turned;
            self.rates[rotor.body].angular = rest - axis * rest.dot(axis) + axis * spin;
        }
    }

    /// Notes the two ways of rotors in the substep.
    pub(super) fn note_ways_of_rotors(&mut self) {
        let Self { rotors, local_poses, rates, reached, began, histories, order, h, .. } = self;
        let ended = if reached.is_empty() { local_poses } else { reached };
        for rotor in rotors.iter().filter(|rotor| rotor.by_axis) {
            let without = ended[rotor.body].1 * rotation::quaternion_of(rotor.axis * -rotor.spun);
            let way = rotation_vector(without * began.local_poses[rotor.body].1.conjugate());
            let history = &mut histories[rotor.body];
            (history.turn, history.spin_turn) = (narrowing::way(way), rotor.spun as f32);
            let (axis, from) = (ended[rotor.body].1 * rotor.axis, began.local_poses[rotor.body].1 * rotor.axis);
            let gained = rotor.along * (rates[rotor.body].angular.dot(axis) - began.rates[rotor.body].angular.dot(from));
            let torque = history.torque.as_dvec3();
            let about = (gained - rotor.carried) / (order.euler_share * *h);
            history.torque = narrowing::impulse(torque + axis * (about - torque.dot(axis)));
        }
    }

    /// How a body would be turned where it had not spun about its axis in its last substep, if it is a rotor that ended that substep so: its way
    /// is in two parts, the turn of its axis and the spin about it.
    pub(super) fn unspun(&self, body: usize, ended: DQuat) -> DQuat {
        let spun = f64::from(self.histories[body].spin_turn);
        if spun == 0.0 {
            return ended;
        }
        let found = self.rotors.binary_search_by_key(&body, |rotor| rotor.body);
        found.map_or(ended, |at| ended * rotation::quaternion_of(self.rotors[at].axis * -spun))
    }

    /// Substeps of a step in which no rotor that is not symmetric turns too far.
    pub(super) fn substeps_of_rotors(&self) -> u32 {
        let turning = |rotor: &Rotor| {
            let (angular, axis) = (self.rates[rotor.body].angular, self.local_poses[rotor.body].1 * rotor.axis);
            if rotor.by_axis { (angular - axis * angular.dot(axis)).length() } else { angular.length() }
        };
        let uneven = self.rotors.iter().filter(|rotor| rotor.is_uneven());
        let fastest = uneven.map(turning).fold(0.0, f64::max);
        (fastest * self.dt / MAX_TURN).ceil() as u32
    }
}
