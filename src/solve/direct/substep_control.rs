//! Chooses how many substeps an articulation takes in a step.
//!
//! Where it moves smoothly, as many as keep the local error of each below its bound ([`history`](super::history)); where it moves safely,
//! so many that joints and contacts change little along one. Both are found by one step for the next, and within a step where one
//! substep shows that those to come are too long.
//!
//! With an error target it is the body furthest off that is to keep it, and where nothing is known yet, as many substeps are taken as
//! are allowed: the first of them is of first order, and what a blow has stirred up is gone or known after them.

use glam::DVec3;

use super::articulation::Articulation;
use super::articulation_state::Mode;
use super::multistep::{LocalError, RATIOS};
use super::rotors;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::StepSettings;
use crate::tuning::soft_stops::PART_PHASE;

/// Change of velocity beyond a steady one that a second-order substep of the default effort may have in an articulation of one
/// metre (m/s); at another effort it goes with the square of the substep.
///
/// With the extent L it goes as L^1.75, below a metre as L: errors are judged against L, and what is long swings and whips slowly, so
/// that they grow less (see [`ERROR_PER_SURPRISE`]).
const MAX_SURPRISE: f64 = 1.6e-4;

/// Error of the path (m) after about a second for the same change of velocity (m/s) in every substep (s): 3.5 on a swing of
/// 10 links, 2 m long, 0.6 of 30, 0.4 of 100.
const ERROR_PER_SURPRISE: f64 = 1.5;

/// Substeps of the default effort.
const NOMINAL_SUBSTEPS: f64 = 4.0;

/// Turn about a joint beside the centre of mass in the first substep of what is new, from which on it is taken in finer ones, and the turn in
/// those (rad).
/// Why: its rows hold at its end to the square of that; beyond some 0.3 rad they do not, and safe substeps take a third of the speed.
/// Scenes: flywheels out of balance at 20 to 200 rad/s. Test: tests/rotors.rs
const LONG_TURN: f64 = 0.25;
const FIRST_TURN: f64 = 0.1;

/// Distance of a centre of mass from the axis, over the radius of gyration, up to which a body turns in place.
const BALANCED: f64 = 0.01;

/// Greatest path in a safe substep, over the size by which errors are judged: joints and contacts change little along it.
const MAX_STRIDE: f64 = 0.03;

impl Articulation {
    /// Takes the substeps that the last step found to be enough, and more from where one shows that they are not.
    pub(super) fn take_substeps(&mut self, joints: &Pool<Joint, JointId>, settings: &StepSettings) {
        let (substeps, dt) = (settings.substeps, f64::from(settings.dt));
        let has_target = settings.articulations.error_target > 0.0;
        let (most, bound) = (settings.articulations.ceiling() * substeps, self.most_surprise(settings));
        self.finest = dt / f64::from(most);
        let over = |surprise: LocalError| (if has_target { surprise.worst } else { surprise.mean } / bound).sqrt();
        // Carried multipliers are those of the world's substep.
        let unknown = if has_target { most } else { substeps };
        let (mut rest, mut left, mut needed) = (self.wanted_substeps([unknown, most], dt), dt, 0.0_f64);
        if !self.rotors.is_empty() {
            let least = self.substeps_of_rotors().min(most);
            (rest, needed) = (rest.max(least), f64::from(least));
        }
        let mut h = dt / f64::from(rest);
        // Where soft stops are met substeps grow to this length.
        let mut growth = None;
        if self.has_soft_stops {
            let whole = dt / f64::from(self.noted_substeps().clamp(1, most));
            if let Some(next) = self.grows_from(whole) {
                (rest, growth) = ((dt / next).ceil() as u32, Some(whole));
                h = dt / f64::from(rest);
            }
        }
        self.scale_impulses((h / self.world_substep) as f32);
        let mut error = None;
        loop {
            (self.surprise, self.rotor_share) = (LocalError::default(), 0.0);
            (self.met_in_parts, self.spring_phase) = (None, 0.0);
            let smooth = self.mode != Mode::Safe;
            error = Some(self.advance(joints, h, 0, error));
            (rest, left) = (rest - 1, left - h);
            let over = over(self.surprise).max(self.rotor_share / rotors::MUST_FALL).max(self.spring_phase / PART_PHASE);
            if let Some([part, whole]) = self.met_in_parts {
                self.scale_impulses((part / h) as f32);
                (h, growth) = (part, Some(whole));
            }
            needed = needed.max(dt / h * over);
            // What is unsettled is taken back, and its contacts are swept.
            if rest == 0 || self.outcome.unsettled {
                break;
            }
            if let Some(whole) = growth.filter(|_| self.mode != Mode::Safe) {
                rest = (left / self.next_length(h, over, whole)).ceil().max(1.0) as u32;
                let before = std::mem::replace(&mut h, left / f64::from(rest));
                self.scale_impulses((h / before) as f32);
                continue;
            }
            let finer = if smooth && self.mode == Mode::Safe {
                // What it has met has had no say in how long its smooth substeps were.
                (left / self.world_substep).round() as u32
            } else {
                let (wanted, finest) = (left / h * over, left / dt * f64::from(most));
                (wanted.ceil().min(finest.round()) as u32).min(2 * rest)
            };
            if finer > rest {
                rest = finer;
                let before = std::mem::replace(&mut h, left / f64::from(rest));
                self.scale_impulses((h / before) as f32);
            }
        }
        self.scale_impulses((self.world_substep / h) as f32);
        self.note_wanted_substeps(settings, h, needed);
    }

    /// Greatest change of velocity beyond a steady one that a second-order substep may have (m/s).
    fn most_surprise(&self, settings: &StepSettings) -> f64 {
        let target = f64::from(settings.articulations.error_target);
        if target > 0.0 {
            return target / ERROR_PER_SURPRISE;
        }
        let extent = self.extent();
        let root = extent.max(1.0).sqrt();
        MAX_SURPRISE * extent * root * root.sqrt() * (NOMINAL_SUBSTEPS / f64::from(settings.substeps)).powi(2)
    }

    /// Substeps that the last step found to be enough, or where there is none to go by `unknown`, and up to `most` for what turns fast.
    fn wanted_substeps(&self, [unknown, most]: [u32; 2], dt: f64) -> u32 {
        let wanted = self.noted_substeps();
        // Where steps get longer, so many more that the first can still be of second order.
        let last = self.histories.iter().map(|history| history.h).fold(0.0, f32::max);
        let reachable = (dt / (RATIOS.end() * f64::from(last))).ceil();
        let wanted = if wanted > 0 && last > 0.0 && reachable <= f64::from(most) { wanted.max(reachable as u32) } else { wanted };
        match self.mode {
            Mode::Safe if wanted > 0 => wanted.min(unknown),
            Mode::Smooth | Mode::SecondOrder if wanted > 0 && self.second_order(dt / f64::from(wanted)).is_some() => wanted,
            // What is new begins well; what whips about stays at the effort that the host asks for.
            _ if wanted == 0 => {
                let turn = self.greatest_turn(dt);
                if turn > LONG_TURN * f64::from(unknown) {
                    ((turn / FIRST_TURN).ceil() as u32).min(most).max(unknown)
                } else {
                    unknown
                }
            }
            _ => unknown,
        }
    }

    /// Substeps that the last step found to be enough; none where nothing is known.
    fn noted_substeps(&self) -> u32 {
        self.histories.iter().map(|history| history.substeps).max().unwrap_or(0)
    }

    /// Greatest turn within a time (s) of a body whose centre of mass goes round a joint, at the speed that it has and what forces add to that in
    /// this time if it hangs on the joint alone (rad).
    fn greatest_turn(&self, time: f64) -> f64 {
        let mut greatest = 0.0_f64;
        for (link, entry) in self.links.iter().zip(&self.entries) {
            for (side, &body) in link.bodies.iter().enumerate() {
                let (own, angular) = (&self.bodies[body as usize], self.rates[body as usize].angular);
                let Some(mass) = own.mass() else { continue };
                let lever = self.local_poses[body as usize].1 * entry.local_lever[side];
                let square = own.top.inertia.max_element() / mass;
                let in_place = BALANCED * BALANCED * square * angular.length_squared();
                let speed = if angular.cross(lever).length_squared() > in_place { angular.length() } else { 0.0 };
                let gained = (lever.cross(own.acceleration) * own.top.free).length() / (square + lever.length_squared()) * time;
                greatest = greatest.max((speed + gained) * time);
            }
        }
        greatest
    }

    /// Diagonal of the box around the bodies' centres at the start of the step, and at least the size by which errors are judged (m).
    fn extent(&self) -> f64 {
        let centers = || self.origins.iter().skip(1);
        let low = centers().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = centers().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        (high - low).length().max(self.size)
    }

    /// Notes for the next step, whose first substep follows one of length `h` (s), how many substeps would have kept the local error
    /// below its bound, `needed`, or where it moved safely, their paths short.
    fn note_wanted_substeps(&mut self, settings: &StepSettings, h: f64, needed: f64) {
        let (substeps, dt) = (settings.substeps, f64::from(settings.dt));
        let outcome = &self.outcome;
        let wanted = if outcome.second_order > 0 && outcome.safe + outcome.halvings == 0 {
            // Twice as long as the last, or half as long, a substep can still be of second order. Where the host has lowered the
            // effort since, twice as long may still be more substeps than are allowed.
            let (last, most) = (dt / h, settings.articulations.ceiling() * substeps);
            needed.ceil().max((0.5 * last).ceil()).min((2.0 * last).floor().min(f64::from(most)))
        } else if outcome.first_order + outcome.halvings == 0 && !outcome.unsettled {
            (self.greatest_speed() * dt / (MAX_STRIDE * self.size)).ceil().min(f64::from(substeps))
        } else {
            f64::from(substeps)
        };
        let wanted = wanted.max(1.0) as u32;
        self.histories.iter_mut().for_each(|history| history.substeps = wanted);
    }

    /// Greatest speed of any joint point (m/s).
    fn greatest_speed(&self) -> f64 {
        let mut greatest = 0.0_f64;
        for (link, entry) in self.links.iter().zip(&self.entries) {
            for side in 0..2 {
                let body = link.bodies[side] as usize;
                let (rate, lever) = (&self.rates[body], self.local_poses[body].1 * entry.local_lever[side]);
                greatest = greatest.max((rate.linear + rate.angular.cross(lever)).length());
            }
        }
        greatest
    }
}
