//! Rotors of an articulation in its substeps: which bodies are such, where they are put and where they end. See [`super::rotor`].

use glam::DVec3;

use super::articulation::{Articulation, Mode};
use super::history::rotation_vector;
use super::quads;
use super::rotor::Rotor;
use super::single;
use crate::solve::rotation;

/// Share by which the error of passes must fall in each; where it does not, velocities before joints act stay as they are.
const MUST_FALL: f64 = 0.5;

/// Most by which a rotor that is not symmetric may turn in a substep (rad): passes that find where it ends go on falling up to twice that.
const MOST_TURN: f64 = 0.4;

/// Error of the axis at the end of a substep that passes leave (rad): ten seconds of a thousand substeps each add up to 1e-3.
const AXIS_ERROR: f64 = 1.0e-7;

/// Gain of kinetic energy in a safe substep that is rounding.
const ROUNDING: f64 = 1.0e-6;

/// Passes that a substep may take for its rotors.
const MOST_PASSES: usize = 6;

impl Articulation {
    /// Finds the rotors among the bodies for a step; what spins so fast that joints feel the mean of its moments gets that.
    pub(super) fn find_rotors(&mut self) {
        self.rotors.clear();
        let mut is_blurred = false;
        for number in 0..self.bodies.len() {
            let state = (&self.stances[number], &self.rates[number]);
            let history = &mut self.histories[number];
            let known = history.spin_turn != 0.0;
            let found = Rotor::of(number, &self.bodies[number], state, known, self.dt, self.world_substep);
            if let Some(rotor) = found {
                let top = &mut self.bodies[number].top;
                if rotor.is_blurred {
                    let is_axis = (top.frame.conjugate() * rotor.axis).abs().cmpgt(DVec3::splat(0.5));
                    top.inertia = DVec3::select(is_axis, top.inertia, DVec3::splat(rotor.across));
                }
                is_blurred |= rotor.is_blurred;
                self.rotors.push(rotor);
            }
            if known && found.is_none_or(|rotor| !rotor.is_symmetric) {
                // It spins no faster than others: both ways in one vector again.
                let axis = state.1.angular.normalize_or_zero();
                history.turn = single::way(history.turn.as_dvec3() + axis * f64::from(history.spin_turn.abs()));
                history.spin_turn = 0.0;
            }
        }
        if is_blurred {
            quads::gather(&mut self.quads, &self.bodies);
        }
    }

    /// Puts rotors where the Euler part, `h` long, of a substep starts, and finds where it leads to without joints.
    pub(super) fn place_rotors(&mut self, full: f64, h: f64, mode: Mode) {
        let Self { rotors, bodies, began, histories, order, stances, rates, predicted, .. } = self;
        for rotor in rotors {
            let number = rotor.body;
            let (body, history) = (&bodies[number], &histories[number]);
            let (from, before) = (&began.stances[number], &began.rates[number]);
            (rotor.held, rotor.pose, rotor.kick, rotor.is_left) = (from.1 * rotor.axis, from.1, DVec3::ZERO, false);
            let (spin, rest) = rotor.split(before.angular);
            (rotor.start, rotor.first, rotor.spun_before) = (from.1, rotor.held, 0.0);
            if mode == Mode::SecondOrder {
                let (share, steady) = (order.extrapolation, order.steady_share * full);
                if rotor.is_symmetric {
                    let (way, spun) = rotor.ways(history);
                    rotor.spun_before = spun * share + spin * steady;
                    let spun = rotation::quaternion_of(rotor.axis * rotor.spun_before);
                    rotor.start = (rotation::rotated(from.1, way * share + rest * steady) * spun).normalize();
                    rotor.pose = rotation::rotated(rotor.start, rest * h);
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
                rates[number].angular = rotor.angular_of(momentum) / body.weights(h)[1];
                stances[number].1 = rotor.start;
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
        for pass in 1..=MOST_PASSES {
            for rotor in &self.rotors {
                let body = &self.bodies[rotor.body];
                // As all that changes velocities in a safe substep.
                let kick = if mode == Mode::Safe { body.inverse_inertia * (body.inertia * rotor.kick) } else { rotor.kick };
                self.rates[rotor.body].angular += kick;
            }
            self.solve_rates();
            let mut worst = 0.0_f64;
            let Self { rotors, rates, .. } = self;
            for rotor in rotors {
                let angular = rates[rotor.body].angular;
                let kick = rotor.kick_of(angular, h);
                let carried = rotor.along * angular.length();
                worst = worst.max((kick - rotor.kick).length() * rotor.across / carried.max(f64::MIN_POSITIVE));
                rotor.kick = kick;
            }
            if worst <= AXIS_ERROR || pass == MOST_PASSES {
                break;
            }
            self.rates.clone_from(&base);
            if worst > MUST_FALL * before {
                self.rotors.iter_mut().filter(|rotor| !rotor.is_symmetric).for_each(|rotor| rotor.kick = DVec3::ZERO);
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
            if !rotor.is_symmetric {
                (self.stances[rotor.body].1, self.rates[rotor.body].angular) = (rotor.turned(angular, h), angular);
                continue;
            }
            let (spin, rest) = rotor.split(angular);
            let turned = rotor.turned(angular, h);
            let axis = turned * rotor.axis;
            rotor.spun = rotor.spun_before + spin * h;
            self.stances[rotor.body].1 = turned;
            self.rates[rotor.body].angular = rest - axis * rest.dot(axis) + axis * spin;
        }
    }

    /// Notes the two ways of rotors in the substep.
    pub(super) fn note_ways_of_rotors(&mut self) {
        let Self { rotors, stances, reached, began, histories, .. } = self;
        let ended = if reached.is_empty() { stances } else { reached };
        for rotor in rotors.iter().filter(|rotor| rotor.is_symmetric) {
            let without = ended[rotor.body].1 * rotation::quaternion_of(rotor.axis * -rotor.spun);
            let way = rotation_vector(without * began.stances[rotor.body].1.conjugate());
            let history = &mut histories[rotor.body];
            (history.turn, history.spin_turn) = (single::way(way), rotor.spun as f32);
        }
    }

    /// Substeps of a step in which no rotor that is not symmetric turns too far.
    pub(super) fn substeps_of_rotors(&self) -> u32 {
        let uneven = self.rotors.iter().filter(|rotor| !rotor.is_symmetric);
        let fastest = uneven.map(|rotor| self.rates[rotor.body].angular.length()).fold(0.0, f64::max);
        (fastest * self.dt / MOST_TURN).ceil() as u32
    }
}
