//! One island that is solved as a whole: bodies, joints and contacts, moved through all substeps of a step.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::fall::IslandBodies;
use super::held::{Ends, JointSet, rate_of, settle_term, vector};
use super::joints::MultiplierSlot;
use super::masses::mass_of;
use super::outline::{JointOutline, Outline};
use super::passes::{Effort, MAX_FACTORS};
use super::patch::Patch;
use super::problem::{BodyMass, Problem, Stiff};
use super::term::FIXED;
use crate::id::{BodyId, JointId, Pool};
use crate::joint_record::Joint;
use crate::report::ArticulationReport;
use crate::solve::StepSettings;
use crate::solve::direct::body::DirectBody;
use crate::solve::direct::stiffness;
use crate::solve::joint::rows::Rate;
use crate::solve::joint::{JointLink, LocalPose};
use crate::solve::plan::FREE_FACTORS;
use crate::solve::state::{BodyMotion, BodyVelocity, WORLD_SLOT};

/// Change of the inertia with which a body answers, over what it was, from which on the substep is solved once more.
const STIFFER: f64 = 0.5;

/// Length below which a line has no direction (m).
pub(super) const MIN_LENGTH: f64 = 1.0e-6;

/// How a step went.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CoupledOutcome {
    effort: Effort,
    substeps: u32,
    penetration: f64,
    /// What motors, springs and moved bodies may have done in the step, and what energy has grown by (J).
    pub(super) driven: f64,
    pub(super) gain: f64,
    /// What taking errors out of positions has lifted bodies by (J): rows that are straight ways where bodies turn let them fall by as much.
    pub(super) lifted: f64,
    /// Greatest gap of a joint at the start of the step and at its end (m).
    pub(super) gaps: [f64; 2],
    /// Kinetic energy at the start of the step (J).
    pub(super) kinetic: f64,
    /// Greatest speed at which rows that always hold have been left to part (m/s, rad/s).
    pub(super) strain: f64,
    /// Whether joints give way in it.
    gives: bool,
    /// Factorisations that it has taken in longer substeps, in vain.
    pub(super) spent: u32,
    /// Whether others are to take the step.
    is_rejected: bool,
    /// Whether it is to take the step, which it has not taken yet or is to take again.
    is_pending: bool,
}

/// An island: see the [module](self).
#[derive(Debug, Default)]
pub(crate) struct CoupledIsland {
    /// Slots of the bodies that it moves.
    pub slots: Range<u32>,
    /// Whether its joints close a loop.
    pub(super) is_looped: bool,
    pub(super) held: JointSet,
    pub(super) bodies: Vec<DirectBody>,
    /// Number of each in the problem.
    pub(super) moved: Vec<u32>,
    /// Slots of kinematic bodies, by local number from the first of them.
    anchors: Vec<u32>,
    pub(super) rates: Vec<Rate>,
    pub(super) local_poses: Vec<LocalPose>,
    pub(super) began: Vec<LocalPose>,
    /// Where bodies may be moved to as errors of positions are taken out.
    pub(super) moved_to: Vec<LocalPose>,
    pub patches: Vec<Patch>,
    outline: Outline,
    pub(super) problem: Problem,
    /// Whether anything presses on each body of the problem, or on one that it touches.
    pub(super) pressed: Vec<bool>,
    traces: Vec<f64>,
    torques: Vec<DMat3>,
    /// Sums of the rates at which bodies turn as they go round others, by the impulses that press them, and of those.
    steady: Vec<(DVec3, f64)>,
    pub(super) outcome: CoupledOutcome,
    /// Patches that have been handed out by number.
    handed_out: u32,
}

impl CoupledIsland {
    /// Begins to take in the bodies of these slots: numbers them, for an outline. A factorisation may take so many multiplications.
    pub(crate) fn begin(&mut self, slots: Range<u32>, (is_looped, most_work): (bool, u64), motions: &[BodyMotion]) {
        (self.slots, self.is_looped, self.outcome) = (slots.clone(), is_looped, CoupledOutcome::default());
        self.moved.clear();
        self.moved.push(FIXED);
        let mut next = 0;
        for slot in slots {
            let is_dynamic = motions[slot as usize].is_dynamic();
            self.moved.push(if is_dynamic { next } else { FIXED });
            next += u32::from(is_dynamic);
        }
        self.outline.begin(next as usize, most_work);
    }

    /// Notes which bodies a joint connects.
    pub(crate) fn outline_joint(&mut self, link: &JointLink) {
        let bodies = [link.a, link.b].map(|slot| self.number_of(slot));
        let (rows, acts_between) = (link.traits.held_rows, link.traits.acts_between);
        self.outline.add_joint(JointOutline { bodies, rows, acts_between });
    }

    /// Notes that bodies of these slots are near each other.
    pub(crate) fn outline_pair(&mut self, slots: [u32; 2]) {
        let bodies = slots.map(|slot| self.number_of(slot));
        self.outline.add_pair(bodies);
    }

    /// Number of a body in the problem.
    fn number_of(&self, slot: u32) -> u32 {
        if self.slots.contains(&slot) { self.moved[1 + (slot - self.slots.start) as usize] } else { FIXED }
    }

    /// Whether the structure of the factor is that of the last step.
    pub(crate) fn has_structure(&self) -> bool {
        self.outline.is_known()
    }

    pub(crate) fn find_structure(&mut self) {
        self.outline.find(&mut self.problem.structure);
    }

    /// Takes in all bodies, as they are.
    pub(crate) fn enlist_bodies(&mut self, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        self.held.clear();
        self.bodies.clear();
        self.anchors.clear();
        self.rates.clear();
        self.local_poses.clear();
        self.patches.clear();
        let CoupledOutcome { gives, spent, .. } = self.outcome;
        (self.outcome, self.handed_out) = (CoupledOutcome { is_pending: true, gives, spent, ..CoupledOutcome::default() }, 0);
        self.enlist(WORLD_SLOT, velocities, motions);
        for slot in self.slots.clone() {
            self.enlist(slot, velocities, motions);
        }
    }

    fn enlist(&mut self, slot: u32, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        let (velocity, motion) = (&velocities[slot as usize], &motions[slot as usize]);
        self.bodies.push(DirectBody::new(slot, velocity, motion));
        self.rates.push(Rate::of(velocity));
        self.local_poses.push(motion.stance());
    }

    /// Local number of what has this slot.
    pub(crate) fn local(&mut self, slot: u32, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> usize {
        if slot == WORLD_SLOT {
            return 0;
        }
        if self.slots.contains(&slot) {
            return 1 + (slot - self.slots.start) as usize;
        }
        let first = 1 + self.slots.len();
        if let Some(found) = self.anchors.iter().position(|&anchor| anchor == slot) {
            return first + found;
        }
        self.anchors.push(slot);
        self.moved.push(FIXED);
        self.enlist(slot, velocities, motions);
        first + self.anchors.len() - 1
    }

    /// Asks it to take the step.
    pub(crate) fn ask(&mut self) {
        self.outcome.is_pending = true;
    }

    pub(crate) fn is_pending(&self) -> bool {
        self.outcome.is_pending
    }

    /// Moves the bodies through the step, in substeps of the world that have been halved so often.
    pub(crate) fn step(&mut self, joints: &Pool<Joint, JointId>, settings: &StepSettings, halvings: u32) {
        let h = f64::from(settings.dt) / f64::from(settings.substeps);
        self.outcome.substeps = settings.substeps;
        self.began.clone_from(&self.local_poses);
        self.outcome.gaps[0] = self.joint_gap(joints);
        let (before, mut budget) = (self.energy(), None);
        let lead = self.is_unpressed().then(|| self.lead(h));
        for substep in 0..settings.substeps {
            let left = [0, 1].map(|end| h * f64::from(settings.substeps - substep - end));
            let ahead = if substep == 0 { 0.5 * (h - f64::from(settings.dt)) } else { h };
            let bent = self.bodies.iter().zip(&mut self.rates).filter(|(body, _)| body.is_bent());
            bent.for_each(|(body, rate)| *rate = body.bent(rate, ahead));
            self.build(joints, h, left);
            self.rebound(joints, settings, h, left);
            if substep == 0 && lead.is_some() {
                self.begin_in_phase();
            }
            let budget = budget.get_or_insert_with(|| self.budget(settings));
            let kept_back = FREE_FACTORS * (settings.substeps - 1 - substep);
            let most = budget.saturating_sub(kept_back).clamp(1, MAX_FACTORS);
            self.problem.note_carried();
            let effort = self.solve(h, most);
            if self.is_looped && !effort.is_capped {
                self.problem.drop_contradictions();
            }
            *budget = budget.saturating_sub(effort.factors);
            self.outcome.effort.add(effort);
            self.outcome.strain = self.outcome.strain.max(self.problem.strain());
            if !effort.is_capped {
                self.follow_bends(h);
            }
            self.outcome.driven += self.drive_work();
            let passed = if substep + 1 == settings.substeps { f64::from(settings.dt) } else { 0.0 };
            self.problem.relax(if effort.is_capped { f64::INFINITY } else { passed }, self.held.sources.len());
            self.held.keep_impulses(&self.problem);
            self.patches.iter_mut().for_each(|patch| patch.keep_impulses(&self.problem.terms));
            self.advance(h);
            let fallen = self.energy();
            let gap = self.close_gaps(joints, h, left[1]);
            self.outcome.lifted += self.energy() - fallen;
            self.held.follow_angles(joints, &self.local_poses, left[1]);
            if !self.holds_together(gap) {
                break;
            }
        }
        let after = self.end_step(joints, h, lead);
        let overlaps = self.patches.iter().map(|patch| patch.overlap(&self.local_poses, &self.began));
        self.outcome.penetration = overlaps.fold(0.0, f64::max);
        self.outcome.gaps[1] = self.joint_gap(joints);
        (self.outcome.gain, self.outcome.kinetic) = (after - before, before);
        self.outcome.is_rejected = !self.is_sound();
        let contradicts = self.contradicts();
        let may_again = self.may_halve() || contradicts && !self.outcome.gives;
        self.outcome.spent += self.outcome.effort.factors;
        self.outcome.is_pending = self.outcome.is_rejected && may_again && self.can_halve(settings);
        self.outcome.gives |= contradicts;
        let share = (1 << halvings) as f32;
        self.held.entries.iter_mut().for_each(|entry| *entry = entry.scaled(share));
        self.patches.iter_mut().for_each(|patch| patch.scale_impulses(f64::from(share)));
    }

    /// Most that motors, springs and bodies which rows do not move may have done in this substep (J), with what they do as bodies follow a bend.
    fn drive_work(&self) -> f64 {
        let Problem { links, terms, velocity, .. } = &self.problem;
        let is_moved = |ends: &[usize; 2]| {
            let still = |rate: &Rate| rate.linear == DVec3::ZERO && rate.angular == DVec3::ZERO;
            ends.iter().any(|&body| !self.bodies[body].is_dynamic() && !still(&self.rates[body]))
        };
        let mut work = 0.0;
        for ((link, rows), ends) in links.iter().zip(&self.held.rows).zip(&self.held.ends) {
            let moved = is_moved(ends);
            for row in (0..link.rows).filter(|&row| moved || link.give[row] > 0.0 || link.bias[row] != 0.0) {
                let jacobian = [&link.jacobian[0][row], &link.jacobian[1][row]];
                work += (link.impulse[row] * super::problem::rate(link.bodies, jacobian, velocity)).abs();
            }
            let terms = &terms[rows.terms.0 as usize..rows.terms.1 as usize];
            work += terms.iter().map(|term| (term.impulse[0] * super::problem::speed(term, velocity)[0]).abs()).sum::<f64>();
        }
        for patch in self.patches.iter().filter(|patch| is_moved(&patch.bodies)) {
            for term in patch.terms(terms) {
                let speed = super::problem::speed(term, velocity);
                work += (term.impulse[0] * speed[0]).abs() + (term.impulse[1] * speed[1]).abs();
            }
        }
        work
    }

    /// Whether a factorisation takes more work than it may: the step is not taken then.
    pub(crate) fn is_large(&self) -> bool {
        self.outline.is_large()
    }

    /// Whether it has taken the step; it is left to the other solvers else, as if nothing had been done.
    pub(crate) fn is_accepted(&self) -> bool {
        !self.is_large() && !self.outcome.is_rejected
    }

    /// Number of the next patch, in the order in which they were taken in.
    pub(crate) fn next_patch(&mut self) -> u32 {
        self.handed_out += 1;
        self.handed_out - 1
    }

    /// Forms the problem of a substep of length `h` (s), whose start and end are so far from the end of the step (s).
    pub(super) fn build(&mut self, joints: &Pool<Joint, JointId>, h: f64, left: [f64; 2]) {
        let Self { problem, bodies, rates, local_poses, .. } = self;
        problem.clear();
        for ((body, rate), stance) in bodies.iter_mut().zip(&*rates).zip(&*local_poses) {
            if !body.is_dynamic() {
                continue;
            }
            body.weigh(h);
            problem.masses.push(mass_of(body, stance, h));
            problem.before.push(vector(rate));
            let mut free = *rate;
            body.apply_forces(stance, &mut free, h);
            problem.free.push(vector(&free));
        }
        let Self { problem, held, bodies, moved, rates, local_poses, .. } = self;
        held.add_rows(joints, problem, Ends { bodies, moved, rates, local_poses }, h, left);
        let Self { problem, patches, moved, local_poses, began, rates, .. } = self;
        for patch in patches {
            patch.add_terms(patch.bodies.map(|body| moved[body]), (local_poses, began, rates), h, &mut problem.terms);
        }
        self.problem.invert_masses();
        self.mask();
        self.find_stiffness(h);
        self.problem.begin();
        if self.outcome.gives {
            let give = self.give(h);
            self.problem.give_way(give);
        }
    }

    /// Puts speeds of what is not moved by rows into their biases, and takes locked axes out of them.
    fn mask(&mut self) {
        let Self { problem, bodies, rates, held, patches, .. } = self;
        held.mask(problem, bodies, rates);
        let mut next = held.sources.len();
        for patch in patches {
            for _ in 0..patch.term_count() {
                settle_term(&mut problem.terms[next], patch.bodies, bodies, rates);
                next += 1;
            }
        }
    }

    /// Finds the geometric stiffness of all forces as they are expected now.
    fn find_stiffness(&mut self, h: f64) {
        let Self {
            problem,
            is_looped,
            held: JointSet { entries, ends, rows, sources, .. },
            moved,
            torques,
            steady,
            patches,
            local_poses,
            began,
            rates,
            bodies: own,
            ..
        } = self;
        torques.clear();
        torques.resize(problem.masses.len(), DMat3::ZERO);
        problem.stiff.clear();
        problem.is_base_stale = true;
        for ((number, rows), ends) in rows.iter().enumerate().zip(&*ends) {
            let link = &problem.links[number];
            let mut force = DVec3::ZERO;
            if rows.holds_points {
                let own = rows.sources.iter().zip(link.impulse).filter(|(source, _)| source.place == MultiplierSlot::Point);
                force = own.map(|(source, impulse)| source.linear * impulse).sum();
            }
            let length = rows.gap.length();
            let line = entries[number].is_distance && length > MIN_LENGTH;
            if line {
                let terms = rows.terms.0 as usize..rows.terms.1 as usize;
                let bounded = terms.map(|term| sources[term].linear * problem.terms[term].impulse_now());
                let held = rows.sources.iter().zip(link.impulse).map(|(source, impulse)| source.linear * impulse);
                force = bounded.chain(held).sum();
            }
            if force == DVec3::ZERO {
                continue;
            }
            let bodies = ends.map(|body| moved[body]);
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                if bodies[side] != FIXED {
                    let (force, lever) = (force * sign, rows.levers[side]);
                    let axis = local_poses[ends[side]].1 * own[ends[side]].length();
                    let own = stiffness::of_impulse(force, lever) + stiffness::about_axis(force, lever, axis);
                    torques[bodies[side] as usize] += own * h;
                }
            }
            let pull = if line { -force.dot(rows.gap) / length } else { 0.0 };
            if pull > 0.0 {
                let axis = (rows.gap / length).any_orthonormal_pair();
                for across in [axis.0, axis.1] {
                    let jacobian = [0, 1].map(|side| super::patch::row(side, across, rows.levers[side]));
                    let gain = h * pull / length;
                    problem.stiff.push(Stiff { bodies, jacobian, gain, steady: None });
                }
            }
        }
        problem.leave_resolved_lines();
        steady.clear();
        steady.resize(problem.masses.len(), (DVec3::ZERO, 0.0));
        for patch in &*patches {
            let bodies = patch.bodies.map(|body| moved[body]);
            let Problem { terms, stiff, .. } = problem;
            let pressing = |term: u32| terms[term as usize].impulse_now();
            let take = |jacobian, gain, steady| stiff.push(Stiff { bodies, jacobian, gain, steady: Some(steady) });
            patch.rolling((local_poses, began, rates), h, pressing, take, |side, turns, impulse| {
                if bodies[side] != FIXED {
                    let sums = &mut steady[bodies[side] as usize];
                    *sums = (sums.0 + turns * impulse, sums.1 + impulse);
                }
            });
        }
        for (mass, (turns, pressed)) in problem.masses.iter_mut().zip(&*steady) {
            mass.steady = if *pressed > 0.0 { (*turns / *pressed).to_array() } else { [0.0; 3] };
        }
        problem.hold_axes(own.iter().filter(|body| body.is_dynamic()).map(DirectBody::free_axes), torques);
        problem.find_pivots(rows, *is_looped);
        problem.leave_unresolved(torques);
    }

    /// Solves the substep; once more where what it has found makes bodies much stiffer or softer.
    fn solve(&mut self, h: f64, budget: u32) -> Effort {
        let mut effort = self.problem.solve_or_yield(h, budget);
        self.traces.clear();
        self.traces.extend(self.problem.masses.iter().map(BodyMass::trace));
        self.problem.note_impulses();
        self.find_stiffness(h);
        let changes = self.problem.masses.iter().zip(&self.traces).map(|(mass, before)| (mass.trace() - before).abs() / before);
        if changes.fold(0.0, f64::max) > STIFFER && budget > effort.factors {
            effort.add(self.problem.solve_again(budget - effort.factors));
        }
        effort
    }

    /// Moves the bodies by what has been found.
    fn advance(&mut self, h: f64) {
        let Self { problem, bodies, moved, rates, local_poses, patches, held: JointSet { ends, .. }, pressed, .. } = self;
        let island = IslandBodies { bodies, moved, joint_ends: ends };
        let fall = island.find_pressed(problem, patches, h, pressed);
        let is_finite = problem.velocity.iter().flatten().all(|value| value.is_finite());
        let mut next = 0;
        for (number, (body, rate)) in bodies.iter().zip(&mut *rates).enumerate() {
            let stance = &mut local_poses[number];
            if body.is_dynamic() {
                let before = *rate;
                if is_finite {
                    *rate = rate_of(&problem.velocity[next]);
                }
                body.limit_speed(rate);
                let mean = match fall {
                    Some(acceleration) => rate.linear - acceleration * (0.5 * h * body.share_gained(rate, h)),
                    None if pressed[next] => rate.linear,
                    // A free path is a parabola.
                    None => (rate.linear + before.linear) * 0.5,
                };
                next += 1;
                let turn = body.turn(stance, rate, h);
                *stance = (stance.0 + mean * h, turn.rotation);
                rate.angular = turn.angular;
            } else if body.slot != WORLD_SLOT {
                *stance = (stance.0 + rate.linear * h, body.turn(stance, rate, h).rotation);
            }
        }
    }

    /// Writes the state of the bodies back.
    pub(crate) fn store(&self, velocities: &mut [BodyVelocity], motions: &mut [BodyMotion]) {
        for ((body, rate), stance) in self.bodies.iter().zip(&self.rates).zip(&self.local_poses) {
            if body.is_dynamic() {
                let motion = &mut motions[body.slot as usize];
                body.store(rate, stance, &mut velocities[body.slot as usize], motion);
                motion.direct = true;
            }
        }
    }

    /// Worst overlap (m).
    pub(crate) fn penetration(&self) -> f64 {
        self.outcome.penetration
    }

    /// Greatest distance between joint points beyond what their joints allow (m).
    pub(crate) fn joint_gap(&self, joints: &Pool<Joint, JointId>) -> f64 {
        self.held.gaps(joints, &self.local_poses).greatest
    }

    /// What is told of it; `body` is one of its bodies.
    pub(crate) fn report(&self, body: BodyId, joints: &Pool<Joint, JointId>) -> ArticulationReport {
        ArticulationReport {
            body,
            bodies: self.slots.len() as u32,
            joints: self.held.entries.len() as u32,
            swept: false,
            second_order: 0,
            first_order: 0,
            safe: self.outcome.substeps,
            halvings: 0,
            gap: self.joint_gap(joints) as f32,
            angle: 0.0,
            penetration: self.outcome.penetration as f32,
            energy_change: self.outcome.gain as f32,
            factor_size: self.problem.structure.panels.length as u32,
        }
    }
}
