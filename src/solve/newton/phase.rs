//! Velocities at the ends of a step.
//!
//! A substep kicks velocities by the whole of what forces do in it and then moves bodies by them: what joints lead goes as by the leapfrog,
//! whose velocities are those of half a substep before. That holds their energy, but other solvers take velocities for those of now: what swings
//! up is told ½ h v·a too much, and where it leaves for them it keeps that. So where nothing presses and joints are rigid, the first substep kicks
//! by half, and the step ends with the other half and a projection on the joints as they are then: of ropes and stops on those that have borne
//! something, on no contact. While a contact presses the velocities stay those of half a substep before: its impulses have no halves.
//!
//! Whether one does is asked of the same impulses at the end of a step and at the start of the next, as the world carries them: what is told as of the
//! end and taken as of half a substep before has half a kick less.

use super::fall::IslandBodies;
use super::held::rate_of;
use super::island::CoupledIsland;
use super::passes::MAX_FACTORS;
use super::patch::Patch;
use super::problem::Problem;
use super::term::{FIXED, Law, Term};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;

/// Share of a substep's forces that the first substep takes for what joints lead, and the end of the step: of an island that falls as one, whose way
/// is a parabola, as that of what no joint leads, the first takes all.
const SHARES: [f64; 2] = [0.5, 0.5];
const FALLING_SHARES: [f64; 2] = [1.0, 0.0];

impl CoupledIsland {
    /// Whether joints lead bodies by surfaces of which none presses, as the step begins or ends. Where there are none the island goes on being solved so.
    pub(super) fn is_unpressed(&self) -> bool {
        !self.held.entries.is_empty() && !self.patches.is_empty() && !self.patches.iter().any(Patch::goes_on_pressing)
    }

    /// Takes the forces' share of the step's first substep.
    pub(super) fn begin_in_phase(&mut self) {
        if self.problem.is_passive(self.held.sources.len()) {
            let share = self.shares()[0];
            self.kick_by([share, 1.0]);
        }
    }

    /// How much more energy bodies have than half a substep of length `h` (s) before, by what forces have done since (J).
    pub(super) fn lead(&self, h: f64) -> f64 {
        let moving = self.bodies.iter().zip(&self.rates);
        moving.map(|(body, rate)| 0.5 * h * body.mass().unwrap_or(0.0) * body.acceleration.dot(rate.linear)).sum()
    }

    /// Ends a step of substeps of length `h` (s), which has begun with velocities of its start and this lead, or with those of half a substep before.
    /// Returns the energy as of the time that it began with: half a kick is neither gain nor loss.
    pub(super) fn end_step(&mut self, joints: &Pool<Joint, JointId>, h: f64, lead: Option<f64>) -> f64 {
        let middle = self.energy();
        let ends_in_phase = self.is_unpressed();
        if ends_in_phase {
            self.end_in_phase(joints, h, 0.0);
        }
        match lead {
            Some(_) if ends_in_phase => self.energy(),
            Some(lead) => middle + lead,
            None => middle,
        }
    }

    /// Brings velocities from the middle of the last substep, of length `h` (s), to its end.
    fn end_in_phase(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: f64) {
        self.build(joints, h, [left, left]);
        if !self.problem.is_passive(self.held.sources.len()) {
            return;
        }
        let share = self.shares()[1];
        self.kick_by([share, 0.0]);
        self.problem.leave_out_what_is_open(self.held.sources.len());
        self.problem.solve(MAX_FACTORS);
        let Self { problem, bodies, rates, held, .. } = self;
        if !problem.velocity.iter().flatten().all(|value| value.is_finite()) {
            return;
        }
        let moving = bodies.iter().zip(rates).filter(|(body, _)| body.is_dynamic());
        for ((body, rate), velocity) in moving.zip(&problem.velocity) {
            *rate = rate_of(velocity);
            body.limit_speed(rate);
        }
        problem.room.blows.clear();
        problem.room.blows.extend(problem.links.iter().map(|link| link.impulse));
        held.add_blow(problem);
    }

    fn shares(&self) -> [f64; 2] {
        let Self { bodies, moved, held, .. } = self;
        if (IslandBodies { bodies, moved, joint_ends: &held.ends }).fall_as_one() { FALLING_SHARES } else { SHARES }
    }

    /// Scales what forces do to bodies that joints lead, and to others.
    fn kick_by(&mut self, shares: [f64; 2]) {
        let Self { problem, held, moved, pressed: led, .. } = self;
        led.clear();
        led.resize(problem.masses.len(), false);
        for number in held.ends.iter().flatten().map(|&body| moved[body]).filter(|&number| number != FIXED) {
            led[number as usize] = true;
        }
        let Problem { free, before, .. } = problem;
        for ((free, before), is_led) in free.iter_mut().zip(&*before).zip(&*led) {
            let share = shares[usize::from(!is_led)];
            free.iter_mut().zip(before).for_each(|(free, before)| *free = before + share * (*free - before));
        }
        problem.find_drive();
    }
}

impl Problem {
    /// Whether joints do nothing but hold: nothing of them gives, moves or rubs. The terms of contacts begin at `first`.
    fn is_passive(&self, first: usize) -> bool {
        let holds = self.links.iter().all(|link| link.boundless == 0 && link.give == [0.0; 6] && link.bias == [0.0; 6]);
        holds && self.terms[..first].iter().all(Term::is_one_sided)
    }

    /// Leaves out contacts, whose terms begin at `first`, and the ropes and stops that have borne nothing.
    fn leave_out_what_is_open(&mut self, first: usize) {
        let (joints, contacts) = self.terms.split_at_mut(first);
        let open = joints.iter_mut().filter(|term| term.expected[0] <= 0.0);
        open.chain(contacts).for_each(|term| (term.law, term.is_known, term.argument) = (Law::Between(0.0, 0.0), true, [0.0; 2]));
    }
}
