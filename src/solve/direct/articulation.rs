//! One articulation: bodies connected by joints, moved through a step by direct solves.
//!
//! A substep of length h:
//!
//! ```text
//! v* = v + h g                                    forces; the bodies stay where they are
//! M̃ = M + G(p of the last substep)                geometric stiffness
//! v  = M̃⁻¹ M v* + M̃⁻¹ Jᵀ p,   J v = 0             all rows at once; stops: J v ≥ −max(C, 0)/h
//! x ← x + h v                                     rotation by the momentum midpoint
//! while the worst error is noticeable:            displacements alone, velocities stay
//!     (J M̃⁻¹ Jᵀ) μ = −C,   δ = M̃⁻¹ Jᵀ μ,   accepted only if the worst error falls
//! ```
//!
//! |v| in M is never above |v*|, as G has no negative eigenvalue: kinetic energy cannot grow. Where bodies slide around a curved surface
//! their forces turn with it, at ω̂, and the first M v* is M v* + G ω̂; if energy grows by that, the substep is solved without it. The projection must weigh bodies by
//! M̃ too: by M, light links would straighten to spare the heavy body and the gap would grow.
//!
//! A substep that ends with an error beyond the tolerance, and not well below what it began with, is undone and taken as two halves.

use glam::{DMat3, DVec3, Vec3};

use super::articulation_state::{Began, Mode, ReusedFactor, ServoParts, StepOutcome};
use super::ball_joint_system::BallJointSystem;
use super::body::DirectBody;
use super::contacts::ArticulationContact;
use super::multistep::{LocalError, SecondOrder};
use super::rotor::Rotor;
use super::system::System;
use super::topology::{NodeBodies, Topology};
use super::wide_integrator::{self, Bodies4};
use crate::id::{BodyId, JointId, Pool};
use crate::joint_record::Joint;
use crate::report::ArticulationReport;
use crate::solve::StepSettings;
use crate::solve::disjoint::Slots;
use crate::solve::joint::reach::FarStops;
use crate::solve::joint::rows::{self, Rate};
use crate::solve::joint::{JointEntry, LocalPose};
use crate::solve::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::step_history::History;

/// Error that a substep may leave, over the mean distance of joint points from centres of mass.
pub(super) const TOLERANCE: f64 = 2.0e-3;

/// The least and the greatest number of halvings that a step's budget of multiplications allows, and how many further solves one costs.
const MIN_HALVINGS: f64 = 4.0;
const MAX_HALVINGS_OF_STEP: f64 = 60.0;
pub(super) const SOLVES_PER_HALVING: u32 = 4;

/// The least and the greatest number of further passes of active sets that a step's budget of multiplications allows.
const MIN_PASSES: f64 = 8.0;
const MAX_PASSES: f64 = 400.0;

/// Time for which contacts are swept once they have not settled as rows (s): what lands or tumbles soon does not settle again.
const SWEPT_TIME: f32 = 1.0;

/// Greatest mass over the least up to which sweeps carry an articulation on its contacts nearly as well as rows do, for a while.
const EVEN_MASSES: f64 = 100.0;

/// Most manifolds with what does not move that are rows where sweeps would do for good: the six wheels of a lorry, but not the limbs of
/// who lies on the ground, which are more than hold it. Rows of those took twice the time of sweeps, and left five times the overlap.
const MAX_MANIFOLDS: usize = 6;

/// Greatest mass over the least up to which they would: cables sink into their drums within ten seconds at 90, not at 50.
const ALIKE_MASSES: f64 = 20.0;

/// What became of the forces on its bodies.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ForceChange {
    /// Whether those on any body are others than in its last substep.
    is_anew: bool,
    /// Whether its bodies have got an impulse as one at the start of the step.
    pub is_kicked: bool,
}

/// Bodies and joints that are solved together.
#[derive(Debug, Default)]
pub(crate) struct Articulation {
    pub entries: Vec<JointEntry>,
    /// Numbers of the two bodies of each joint.
    pub(super) ends: Vec<[u32; 2]>,
    /// Bodies other than the world that it does not move, by slot and number, in the order of their slots.
    anchors: Vec<(u32, u32)>,
    pub(super) bodies: Vec<DirectBody>,
    pub(super) bodies4: Vec<Bodies4>,
    /// Those of them whose velocity changes within the step, by number, and their mean one.
    bent: Vec<(u32, Rate)>,
    /// Where the bodies stood at the start of the step (m).
    pub(super) origins: Vec<DVec3>,
    pub(super) rates: Vec<Rate>,
    pub(super) local_poses: Vec<LocalPose>,
    pub(super) links: Vec<NodeBodies>,
    /// Those of them that the matrix has nodes for, and the work of its factor without contacts, 0 where that is not known.
    pub(super) planned: usize,
    pub(super) joint_work: u64,
    /// Room for rows of contacts in the node of each joint; it never shrinks while the joints stay the same.
    pub(super) room: Vec<u32>,
    pub(super) needed: Vec<u32>,
    /// Bodies between which contacts of carried bodies are.
    pub(super) carried: Vec<[u32; 2]>,
    /// Whether the topology is that of other joints or less room.
    pub(super) stale: bool,
    /// Whether the host has asked for the direct solve.
    pub(super) is_asked_for: bool,
    /// Contacts with what it does not move and with what it carries, sorted by node.
    pub touches: Vec<ArticulationContact>,
    /// Contacts with what else moves, by number, that have not pressed yet.
    pub watched: Vec<u32>,
    /// Where the bodies were at the start of the step.
    pub(super) step_start: Vec<LocalPose>,
    pub(super) topology: Topology,
    pub(super) system: System,
    /// Whether all its joints hold points and it touches nothing, so that `points` takes the place of `system`.
    pub(super) is_points: bool,
    pub(super) points: BallJointSystem,
    pub(super) asked: Vec<rows::ScalarRow>,
    /// Bodies that spin fast, and room for velocities before joints act.
    pub(super) rotors: Vec<Rotor>,
    pub(super) rotor_base: Vec<Rate>,
    /// Moment of the forces of joints on each body, as if all pulled along their levers (N·m).
    pub(super) rotor_loads: Vec<f64>,
    /// Of each joint, where it is swept: whether its stops are out of reach.
    pub(super) stops: Vec<FarStops>,
    pub(super) stiffness: Vec<DMat3>,
    /// Axis of each body's length in its frame, zero where it is not slender.
    pub(super) slender: Vec<DVec3>,
    /// Rate at which the forces on each body turn with what it slides around (rad/s).
    pub(super) turning: Vec<DVec3>,
    /// State at the start of the substep.
    pub(super) began: Began,
    pub(super) histories: Vec<History>,
    pub(super) predicted: Vec<LocalPose>,
    /// How readily the bodies of each joint turn under its force (1/(kg·m)).
    pub(super) eases: Vec<f64>,
    /// Of each joint, with what its line pulls in a substep, times its length: h² T (kg·m).
    pub(super) tensions: Vec<f64>,
    pub(super) implicit: Vec<f64>,
    pub(super) changes: Vec<Rate>,
    pub(super) tried: Vec<LocalPose>,
    /// Stops that may be met in the substep, by row, and the speeds at which they are to be left then.
    pub(super) approaches: Vec<(u32, f64)>,
    /// Where the bodies were before their positions were mended; empty where they have been left as they were.
    pub(super) reached: Vec<LocalPose>,
    /// Joints at the start of the step.
    untouched: Vec<JointEntry>,
    /// Whether rows across the axes of its hinges carry what lies on them, and room for where its joints are (m).
    pub(super) carries_across: bool,
    pub(super) places: Vec<DVec3>,
    /// Whether any of its stops gives back of the speed at which it is met.
    pub(super) rebounds: bool,
    /// Whether any of its stops, or anything else of its joints gives.
    pub(super) has_soft_stops: bool,
    pub(super) has_springs: bool,
    /// Whether a substep is taken in parts because a soft stop is met in it; and of the last one that was, how long its last part was, and how long
    /// substeps may become from there on (s).
    pub(super) is_meeting: bool,
    pub(super) met_in_parts: Option<[f64; 2]>,
    /// Greatest phase of what swings on soft stops in a substep (rad).
    pub(super) spring_phase: f64,
    /// Length of the shortest substep that it may choose (s).
    pub(super) finest: f64,
    /// Whether any of its bodies is damped.
    pub(super) is_damped: bool,
    /// Whether a joint ties it to something that it does not move.
    pub(super) hangs: bool,
    pub(super) order: SecondOrder,
    /// Length of the last substep, if it was one of this step that the histories hold (s).
    pub(super) continues: Option<f64>,
    /// Whether the last substep of this step was of first order.
    after_first_order: bool,
    /// Of the last substep, where that was of second order.
    pub(super) surprise: LocalError,
    /// Greatest share of their error that a pass for rotors has left in this substep, and whether the last one has made it grow.
    pub(super) rotor_share: f64,
    pub(super) rotors_diverge: bool,
    /// Lengths of the step, of the world's substep and of its own (s).
    pub(super) dt: f64,
    pub(super) world_substep: f64,
    pub(super) h: f64,
    /// From where the bodies stand to the end of the step (s).
    pub(super) left: f64,
    /// From the start of the substep for which rows are built to the end of the step, where it is swept (s).
    pub(super) rest: f64,
    /// Whether what holds it changes its velocity at once as the next substep begins.
    pub(super) is_jolted: bool,
    pub(super) forces: ForceChange,
    /// Whether a rigid position motor was on its way in the last substep.
    pub(super) is_under_way: bool,
    /// What its servos move.
    pub(super) parts: ServoParts,
    /// Length by which errors are judged (m).
    pub(super) size: f64,
    pub(super) mode: Mode,
    /// Whether the rows of the last substep are good for the next, where it is swept, and how the bodies had turned when they were
    /// built (rad).
    pub(super) lasting: ReusedFactor,
    pub(super) built: Vec<Vec3>,
    /// Sum of the squares of the turns of substeps since its positions were mended (rad²), where it is swept.
    pub(super) turned: f64,
    /// Way and turn of each body in the step as its rows were last looked at (m, rad).
    pub(super) followed: Vec<[Vec3; 2]>,
    /// Whether the inertia with which its bodies answer is that of the next substep already, where it is swept.
    pub(super) has_answer: bool,
    /// Whether carried multipliers have taken the place of the next solve, where it is swept.
    pub(super) is_warm: bool,
    /// Whether it is swept side by side with others.
    pub(super) in_lockstep: bool,
    /// Whether it touches what moves and is not carried, or its contacts have not settled as rows, so that its joints are swept with the
    /// contacts.
    pub coupled: bool,
    /// Further time for which its contacts are swept although they might be rows (s).
    pub swept_for: f32,
    /// Solves that this step may still spend on halvings and long projections.
    solves_left: u32,
    /// Passes of active sets that this step may still spend beyond those that each substep has free.
    pub(super) passes_left: usize,
    pub outcome: StepOutcome,
}

impl Articulation {
    /// Empties it but keeps its memory, and the structure of its matrix in case it stays the same.
    pub(crate) fn clear(&mut self) {
        self.swept_for = 0.0;
        self.entries.clear();
        self.ends.clear();
        self.anchors.clear();
        self.touches.clear();
        self.watched.clear();
        self.coupled = false;
        self.order = SecondOrder::EULER;
        self.lasting = ReusedFactor::No;
        self.has_answer = false;
        self.is_warm = false;
        self.in_lockstep = false;
        self.is_damped = false;
        self.is_under_way = false;
        self.rebounds = false;
        self.has_soft_stops = false;
        self.has_springs = false;
        self.solves_left = 0;
        self.bodies.clear();
        self.origins.clear();
        self.histories.clear();
        self.forces = ForceChange::default();
        self.outcome = StepOutcome::default();
    }

    /// Takes in a body, whose number is returned; the first must be the world. What has got an impulse with its island has the
    /// velocity after it, and the history before it.
    pub(crate) fn enlist(
        &mut self,
        slot: u32,
        origin: DVec3,
        (history, is_kicked): (History, bool),
        velocity: &BodyVelocity,
        motion: &BodyMotion,
    ) -> u32 {
        self.swept_for = self.swept_for.max(history.swept_for);
        self.origins.push(origin);
        let body = DirectBody::new(slot, velocity, motion);
        let mut history = history;
        self.forces.is_anew |= body.push_before(&mut history, [motion.acceleration, motion.torque]);
        self.forces.is_kicked |= is_kicked;
        self.histories.push(history);
        self.is_damped |= body.is_damped();
        let number = self.bodies.len() as u32;
        if !body.is_dynamic() && slot != WORLD_SLOT {
            self.anchors.insert(self.anchors.partition_point(|&(other, _)| other < slot), (slot, number));
        }
        self.bodies.push(body);
        number
    }

    /// Forgets the last substep.
    pub(super) fn forget_histories(&mut self) {
        self.histories.iter_mut().for_each(|history| *history = History { pushed: history.pushed, ..History::NONE });
    }

    /// Takes in a joint between bodies of these numbers.
    pub(super) fn add_joint(&mut self, entry: JointEntry, ends: [u32; 2]) {
        self.rebounds |= entry.restitution > 0.0;
        self.has_soft_stops |= entry.traits.has_soft_stops;
        self.has_springs |= entry.traits.has_springs;
        self.entries.push(entry);
        self.ends.push(ends);
    }

    /// Bodies other than the world that it does not move, by slot and number.
    pub(super) fn anchors(&self) -> &[(u32, u32)] {
        &self.anchors
    }

    /// Number of the body with this slot, if that does not move and has been taken in.
    pub(super) fn anchor(&self, slot: u32) -> Option<u32> {
        let found = self.anchors.binary_search_by_key(&slot, |&(slot, _)| slot);
        found.ok().map(|place| self.anchors[place].1)
    }

    /// Whether it has contacts as rows that sweeps solve nearly as well: nothing heavy rests on it, nor hangs on what is light.
    fn may_sweep_contacts(&self) -> bool {
        !self.touches.is_empty() && !self.touches.iter().any(|touch| touch.other_moves) && self.mass_ratio() <= EVEN_MASSES
    }

    /// Greatest over least mass of the bodies that it moves.
    fn mass_ratio(&self) -> f64 {
        let masses = || self.bodies.iter().filter_map(DirectBody::free_mass);
        masses().fold(0.0, f64::max) / masses().fold(f64::INFINITY, f64::min)
    }

    /// Whether its contacts are swept from the first, so many manifolds with what does not move: where they are too many for an active
    /// set, or have not settled as rows a short while ago, or where limbs land: these change stops and contacts at once, so that rows do not
    /// settle either, after five times the work of sweeps.
    pub(crate) fn sweeps_contacts(&mut self, manifolds: usize, lands: bool) -> bool {
        if lands && self.mass_ratio() <= ALIKE_MASSES {
            self.swept_for = SWEPT_TIME;
        }
        let has_failed = self.swept_for > 0.0;
        let most_ratio = match manifolds {
            0 => return false,
            _ if has_failed => EVEN_MASSES,
            1..=MAX_MANIFOLDS => return false,
            _ => ALIKE_MASSES,
        };
        self.mass_ratio() <= most_ratio
    }

    /// The last substep of each body that it moves, by slot.
    pub(crate) fn histories(&self) -> impl Iterator<Item = (u32, &History)> {
        self.bodies.iter().zip(&self.histories).filter(|(body, _)| body.is_dynamic()).map(|(body, history)| (body.slot, history))
    }

    /// Slots of the bodies that it moves.
    pub(crate) fn moved_slots(&self) -> impl Iterator<Item = u32> + '_ {
        self.bodies.iter().filter(|body| body.is_dynamic()).map(|body| body.slot)
    }

    /// Moves the bodies through a step: in the world's substeps, or in as many as it needs.
    pub(crate) fn step(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        settings: &StepSettings,
    ) {
        self.load(velocities, motions);
        let Self { bent, anchors, bodies, rates, .. } = self;
        let own = anchors.iter().map(|&(_, number)| number as usize).filter(|&number| bodies[number].is_bent());
        bent.clear();
        bent.extend(own.map(|number| (number as u32, rates[number])));
        self.dt = f64::from(settings.dt);
        self.left = self.dt;
        self.world_substep = self.dt / f64::from(settings.substeps);
        self.step_start.clone_from(&self.local_poses);
        self.find_rotors();
        if !self.watched.is_empty() || !self.touches.is_empty() {
            self.untouched.clone_from(&self.entries);
        }
        let budget = f64::from(settings.articulations.halving_budget) * 1.0e6 / self.topology.plan.work as f64;
        let most_passes = if self.may_sweep_contacts() { MIN_PASSES } else { MAX_PASSES };
        self.passes_left = budget.clamp(MIN_PASSES, most_passes) as usize;
        let halvings = if budget > 0.0 { budget.clamp(MIN_HALVINGS, MAX_HALVINGS_OF_STEP) as u32 } else { 0 };
        self.solves_left = halvings * SOLVES_PER_HALVING;
        self.mode = if self.touches.iter().any(ArticulationContact::presses) { Mode::Safe } else { Mode::Smooth };
        (self.continues, self.after_first_order) = (None, false);
        self.is_jolted = self.histories.iter().any(History::is_jolted);
        // A stop that pressed against a force would go on without it.
        let is_let_go = self.forces.is_anew && self.entries.iter().any(|entry| entry.impulses.pressing() != 0);
        if self.is_jolted || is_let_go {
            self.forget_histories();
        }
        self.kick_histories();
        self.stop_at_joints(joints);
        let energy = self.energy();
        self.take_substeps(joints, settings);
        let gained = self.energy() - energy;
        self.outcome.energy_change = if self.take_lift(gained) { self.energy() - energy } else { gained };
    }

    /// Kinetic energy less the work of forces since the start of the step (J), of all bodies that move freely.
    pub(super) fn energy(&self) -> f64 {
        let bodies = self.bodies.iter().zip(&self.rates).zip(self.local_poses.iter().zip(&self.step_start));
        bodies.map(|((body, rate), (stance, start))| body.energy(stance, rate, start)).sum()
    }

    /// What is told of it; `body` is one of its bodies.
    pub(crate) fn report(&self, body: BodyId) -> ArticulationReport {
        let outcome = &self.outcome;
        ArticulationReport {
            body,
            bodies: self.jointed_bodies() as u32,
            joints: self.entries.len() as u32,
            swept: self.coupled,
            second_order: outcome.second_order,
            first_order: outcome.first_order,
            safe: outcome.safe,
            halvings: outcome.halvings,
            gap: outcome.gap as f32,
            angle: outcome.angle as f32,
            penetration: outcome.penetration as f32,
            energy_change: outcome.energy_change as f32,
            factor_size: self.topology.plan.numbers() as u32,
        }
    }

    pub(super) fn load(&mut self, velocities: &(impl Slots<BodyVelocity> + ?Sized), motions: &(impl Slots<BodyMotion> + ?Sized)) {
        let slots = || self.bodies.iter().map(|body| body.slot);
        self.rates.clear();
        self.rates.extend(slots().map(|slot| Rate::of(velocities.get(slot))));
        self.local_poses.clear();
        self.local_poses.extend(slots().map(|slot| motions.get(slot).stance()));
        self.points.is_known = false;
        self.find_loops();
    }

    /// Gives what the host moves the mean velocity of a substep of length `h` (s) that begins now.
    pub(super) fn bend_paths(&mut self, h: f64) {
        let ahead = 0.5 * (self.dt + h) - self.left;
        for (number, mean) in &self.bent {
            self.rates[*number as usize] = self.bodies[*number as usize].bent(mean, ahead);
        }
    }

    /// How far the body with this slot and number has moved and turned in the step.
    pub(crate) fn path_of(&self, slot: u32, local: u32) -> Option<LocalPose> {
        let number = local as usize;
        self.bodies.get(number).filter(|body| body.slot == slot)?;
        let (now, start) = (&self.local_poses[number], &self.step_start[number]);
        Some((now.0 - start.0, now.1 * start.1.conjugate()))
    }

    /// Leaves the step to the sweeps, as if it had not been taken.
    pub(crate) fn give_up(&mut self) {
        if self.outcome.unsettled && self.may_sweep_contacts() {
            self.swept_for = SWEPT_TIME;
        }
        self.entries.clone_from(&self.untouched);
        self.touches.clear();
        self.system.beside.is_on = false;
        self.links.truncate(self.planned);
        self.weigh(0.0);
        self.coupled = true;
        self.lasting = ReusedFactor::Never;
        self.outcome = StepOutcome::default();
    }

    /// Writes the state of the bodies back.
    pub(crate) fn store(&self, velocities: &mut [BodyVelocity], motions: &mut [BodyMotion]) {
        for ((body, rate), stance) in self.bodies.iter().zip(&self.rates).zip(&self.local_poses) {
            if body.is_dynamic() {
                body.store(rate, stance, &mut velocities[body.slot as usize], &mut motions[body.slot as usize]);
            }
        }
    }

    /// Notes a smooth substep of length `h` (s) for those that follow it.
    pub(super) fn note_smooth(&mut self, h: f64, second_order: bool) {
        // What a substep of first order got wrong says nothing of the one after it.
        if second_order && !self.after_first_order {
            self.surprise = self.surprise();
        }
        self.after_first_order = !second_order;
        // A mended position is no way that the bodies have gone: extrapolated, it would have to be taken back by a blow.
        let reached = if self.reached.is_empty() { &self.local_poses } else { &self.reached };
        let began = (&*self.began.local_poses, &*self.began.rates);
        wide_integrator::note(&self.bodies4, h, &self.order, began, (reached, &self.rates), &mut self.histories);
        self.note_ways_of_rotors();
        // As the histories hold it.
        self.continues = Some(f64::from(h as f32));
        let order = if second_order { &mut self.outcome.second_order } else { &mut self.outcome.first_order };
        *order += 1;
    }

    /// Takes further solves out of the step's budget; false where there are not as many left.
    pub(super) fn pay(&mut self, solves: u32) -> bool {
        let left = self.solves_left.checked_sub(solves);
        self.solves_left = left.unwrap_or(self.solves_left);
        left.is_some()
    }

    pub(super) fn scale_impulses(&mut self, factor: f32) {
        for entry in &mut self.entries {
            entry.impulses = entry.impulses.scaled(factor);
        }
        self.touches.iter_mut().for_each(|touch| touch.scale_impulses(f64::from(factor)));
    }
}
