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
//! |v| in M is never above |v*|, as G has no negative eigenvalue: kinetic energy cannot grow. The projection must weigh bodies by
//! M̃ too: by M, light links would straighten to spare the heavy body and the gap would grow.
//!
//! A substep that ends with an error beyond the tolerance, and not well below what it began with, is undone and taken as two halves.

use glam::{DMat3, DVec3};

use super::body::DirectBody;
use super::factor::Plan;
use super::history::{EULER_SHARE, History};
use super::momentum::Momentum;
use super::stiffness;
use super::system::{Coupling, Origin, System, Topology};
use crate::id::{JointId, Pool};
use crate::joint::{Joint, JointImpulses};
use crate::solve::joint::geometry::JointGeometry;
use crate::solve::joint::kinds::{self, RowSink};
use crate::solve::joint::rows::{self, Phase, Rate};
use crate::solve::joint::{JointEntry, Stance};
use crate::solve::rotation;
use crate::solve::state::{BodyMotion, BodyVelocity, WORLD_SLOT};

/// Transverse stiffness κ of a joint below which a smooth substep takes its Jacobian at the start, and above which at the predicted
/// pose, with the geometric stiffness of its force.
const IMPLICIT_RANGE: (f64, f64) = (0.5, 2.0);

/// Error that a substep may leave, over the mean distance of joint points from centres of mass.
const TOLERANCE: f64 = 2.0e-3;

/// Share of the tolerance below which positions are left as they are.
const GOOD_ENOUGH: f64 = 0.25;

/// Most projections of a substep.
const PROJECTIONS: usize = 3;

/// Shares of a projection's step that are tried, one after the other.
const BACKTRACKING: [f64; 3] = [1.0, 0.3, 0.09];

/// How often a substep may be halved.
const MOST_HALVINGS: u32 = 4;

/// A halved substep must end with this share of the error that it began with, where that is beyond the tolerance.
const MUST_FALL: f64 = 0.5;

/// Multiplications of a factorisation above which sweeps are the better choice, for each row of the articulation.
const MOST_WORK_PER_ROW: u64 = 4000;

/// What a joint holds on to: two local bodies, and how many rows it may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Link {
    bodies: [u32; 2],
    moves: [bool; 2],
    capacity: u32,
}

/// How a substep treats the path of its bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Mode {
    /// Rows hold at the end of the substep to second order.
    #[default]
    Smooth,
    /// Rows hold to first order: kinetic energy cannot grow.
    Safe,
}

/// Where joints take their Jacobians.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Taken {
    /// At the start of the substep, with all the stiffness there is.
    AtStart,
    /// At the start or at the predicted end, as the tension of each joint asks.
    Between,
    /// At the predicted end.
    AtEnd,
}

impl Taken {
    fn of(mode: Mode) -> Self {
        if mode == Mode::Safe { Self::AtStart } else { Self::Between }
    }
}

/// Bodies and joints that are solved together.
#[derive(Debug, Default)]
pub(crate) struct Articulation {
    pub entries: Vec<JointEntry>,
    pub(super) bodies: Vec<DirectBody>,
    /// Where the bodies stood at the start of the step (m).
    origins: Vec<DVec3>,
    pub(super) rates: Vec<Rate>,
    pub(super) stances: Vec<Stance>,
    links: Vec<Link>,
    pub(super) topology: Topology,
    pub(super) system: System,
    asked: Vec<rows::ScalarRow>,
    pub(super) stiffness: Vec<DMat3>,
    /// State at the start of the substep.
    began: Vec<(Stance, Rate)>,
    pub(super) histories: Vec<History>,
    predicted: Vec<Stance>,
    implicit: Vec<f64>,
    changes: Vec<Rate>,
    tried: Vec<Stance>,
    saved: Vec<Saved>,
    /// Whether a joint ties it to something that it does not move.
    hangs: bool,
    /// Length by which errors are judged (m).
    size: f64,
    mode: Mode,
    /// Whether it touches what moves, so that its joints are swept with the contacts.
    pub coupled: bool,
    /// Halvings that this step may still spend.
    budget: u32,
    pub outcome: Outcome,
}

/// How a step of an articulation went.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Outcome {
    /// Substeps taken as two halves.
    pub halvings: u32,
    /// Worst error left (m).
    pub worst_error: f64,
}

/// State before a substep.
#[derive(Debug, Clone, Default)]
struct Saved {
    rates: Vec<Rate>,
    stances: Vec<Stance>,
    entries: Vec<JointEntry>,
}

impl Articulation {
    /// Empties it but keeps its memory, and the structure of its matrix in case it stays the same.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.bodies.clear();
        self.origins.clear();
        self.histories.clear();
        self.outcome = Outcome::default();
    }

    /// Takes in a body, whose number is returned; the first must be the world.
    pub(crate) fn enlist(
        &mut self,
        slot: u32,
        origin: DVec3,
        history: History,
        velocity: &BodyVelocity,
        motion: &BodyMotion,
    ) -> u32 {
        self.origins.push(origin);
        self.histories.push(history);
        self.bodies.push(DirectBody::new(slot, velocity, motion));
        self.bodies.len() as u32 - 1
    }

    /// Prepares the structure of the matrix; false where sweeps are the better choice.
    pub(crate) fn lay_out(&mut self, joints: &Pool<Joint, JointId>, local: &[(u32, u32)]) -> bool {
        let Self { entries, bodies, .. } = self;
        let link = |entry: &JointEntry| {
            let ends = [entry.a, entry.b].map(|slot| if slot == WORLD_SLOT { 0 } else { local[slot as usize].1 });
            let moves = ends.map(|body| bodies[body as usize].is_dynamic());
            Link { bodies: ends, moves, capacity: kinds::most_rows(&joints[entry.joint].def.kind) }
        };
        let unchanged =
            self.links.len() == entries.len() && self.links.iter().zip(&*entries).all(|(old, entry)| *old == link(entry));
        if !unchanged {
            self.links.clear();
            self.links.extend(entries.iter().map(link));
            self.hangs = self.links.iter().any(|link| link.moves != [true; 2]);
            self.topology = derive_topology(&self.links, bodies.len()).unwrap_or_default();
        }
        let levers = entries.iter().flat_map(|entry| entry.local_lever).map(DVec3::length).filter(|&length| length > 0.0);
        let (sum, count) = levers.fold((0.0, 0.0), |(sum, count), length| (sum + length, count + 1.0));
        self.size = if count > 0.0 { sum / count } else { 1.0 };
        self.topology.plan.work > 0
    }

    /// The last substep of each body that it moves, by slot.
    pub(crate) fn histories(&self) -> impl Iterator<Item = (u32, &History)> {
        self.bodies.iter().zip(&self.histories).filter(|(body, _)| body.is_dynamic()).map(|(body, history)| (body.slot, history))
    }

    /// Slots of the bodies that it moves.
    pub(crate) fn moved_slots(&self) -> impl Iterator<Item = u32> + '_ {
        self.bodies.iter().filter(|body| body.is_dynamic()).map(|body| body.slot)
    }

    /// Moves the bodies through a step by `substeps` substeps of length `h` (s), and writes their state back.
    pub(crate) fn step(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        substeps: u32,
        h: f64,
        budget: u32,
    ) {
        self.load(velocities, motions);
        self.budget = budget;
        self.mode = Mode::Smooth;
        let mut error = self.find_errors(joints);
        for _ in 0..substeps {
            error = self.advance(joints, h, 0, error);
        }
        self.outcome.worst_error = error;
        self.store(velocities, motions);
    }

    pub(super) fn load(&mut self, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        let slots = || self.bodies.iter().map(|body| body.slot as usize);
        self.rates.clear();
        self.rates.extend(slots().map(|slot| Rate::of(&velocities[slot])));
        self.stances.clear();
        self.stances.extend(slots().map(|slot| motions[slot].stance()));
    }

    fn store(&self, velocities: &mut [BodyVelocity], motions: &mut [BodyMotion]) {
        for ((body, rate), stance) in self.bodies.iter().zip(&self.rates).zip(&self.stances) {
            if body.is_dynamic() {
                let (velocity, motion) = (&mut velocities[body.slot as usize], &mut motions[body.slot as usize]);
                velocity.linear = rate.linear.as_vec3();
                velocity.angular = rate.angular.as_vec3();
                motion.displacement = stance.0.as_vec3();
                motion.rotation = stance.1.as_quat();
            }
        }
    }

    /// One substep, in halves where it must be; takes and returns the worst error (m).
    fn advance(&mut self, joints: &Pool<Joint, JointId>, h: f64, depth: u32, before: f64) -> f64 {
        self.save(depth);
        if self.mode == Mode::Smooth {
            let momentum = self.substep(joints, h, Mode::Smooth);
            let drift = self.find_errors(joints);
            if drift <= (TOLERANCE * self.size).max(before) {
                let error = self.project(joints, drift);
                self.keep_momentum(momentum);
                self.note_history(h);
                return error;
            }
            self.mode = Mode::Safe;
            self.forget_history();
            self.restore(depth);
        }
        let momentum = self.substep(joints, h, Mode::Safe);
        let drift = self.find_errors(joints);
        let error = self.project(joints, drift);
        self.keep_momentum(momentum);
        let good = error <= (TOLERANCE * self.size).max(MUST_FALL * before);
        if good || depth >= MOST_HALVINGS || self.budget == 0 {
            if !error.is_finite() {
                self.restore(depth);
                return before;
            }
            return error;
        }
        self.budget -= 1;
        self.outcome.halvings += 1;
        self.restore(depth);
        self.scale_impulses(0.5);
        let middle = self.advance(joints, 0.5 * h, depth + 1, before);
        let error = self.advance(joints, 0.5 * h, depth + 1, middle);
        self.scale_impulses(2.0);
        error
    }

    fn save(&mut self, depth: u32) {
        if self.saved.len() <= depth as usize {
            self.saved.push(Saved::default());
        }
        let saved = &mut self.saved[depth as usize];
        saved.rates.clone_from(&self.rates);
        saved.stances.clone_from(&self.stances);
        saved.entries.clone_from(&self.entries);
    }

    fn restore(&mut self, depth: u32) {
        let saved = &self.saved[depth as usize];
        self.rates.clone_from(&saved.rates);
        self.stances.clone_from(&saved.stances);
        self.entries.clone_from(&saved.entries);
    }

    fn scale_impulses(&mut self, factor: f32) {
        for entry in &mut self.entries {
            let JointImpulses { point, angular, scalar } = &mut entry.impulses;
            *point *= factor;
            *angular *= factor;
            scalar.iter_mut().for_each(|impulse| *impulse *= factor);
        }
    }

    /// Moves the bodies; returns the angular momentum that they should have, where joints alone act on them.
    fn substep(&mut self, joints: &Pool<Joint, JointId>, full: f64, mode: Mode) -> Option<DVec3> {
        self.began.clear();
        self.began.extend(self.stances.iter().copied().zip(self.rates.iter().copied()));
        let second_order = mode == Mode::Smooth && self.has_history(full);
        let momentum = self.expected_momentum(full);
        let h = if second_order { self.extrapolate(full) } else { full };
        self.apply_forces(h);
        self.predict(h, mode);
        self.find_stiffness(h, if second_order { Taken::AtEnd } else { Taken::of(mode) }, h / full);
        for (i, body) in self.bodies.iter_mut().enumerate() {
            let damped = body.respond(&self.stances[i], self.stiffness[i], &self.rates[i]);
            if mode == Mode::Safe {
                self.rates[i].angular = damped;
            }
        }
        let phase = if mode == Mode::Smooth { Phase::Velocity { h } } else { Phase::Tangent { h } };
        self.build_rows(joints, phase);
        self.system.begin(&self.bodies);
        self.system.solve(&self.topology, &self.bodies, &mut self.rates);
        self.keep_impulses(full / h);
        for ((body, stance), rate) in self.bodies.iter().zip(&mut self.stances).zip(&mut self.rates) {
            body.limit_speed(rate, h);
            let turn = body.turn(stance, rate, h);
            stance.0 += rate.linear * h;
            stance.1 = turn.rotation;
            rate.angular = turn.angular;
        }
        momentum
    }

    fn apply_forces(&mut self, h: f64) {
        for ((body, stance), rate) in self.bodies.iter().zip(&self.stances).zip(&mut self.rates) {
            body.apply_forces(stance, rate, h);
        }
    }

    /// Whether all bodies came here by a substep of this length.
    fn has_history(&self, h: f64) -> bool {
        let mut bodies = self.bodies.iter().zip(&self.histories).zip(&self.rates);
        bodies.all(|((body, history), rate)| !body.is_dynamic() || history.leads_to(rate, h))
    }

    /// Puts all bodies where a second-order substep starts; returns the length of its Euler part.
    fn extrapolate(&mut self, h: f64) -> f64 {
        for (i, body) in self.bodies.iter().enumerate() {
            if body.is_dynamic() {
                (self.stances[i], self.rates[i]) = self.histories[i].extrapolate(&self.stances[i], &self.rates[i]);
            } else {
                // A body that is moved by others arrives where a whole substep takes it.
                self.stances[i].0 += self.rates[i].linear * (h * (1.0 - EULER_SHARE));
                let turn = self.rates[i].angular * (h * (1.0 - EULER_SHARE));
                self.stances[i].1 = rotation::rotated(self.stances[i].1, turn);
            }
        }
        h * EULER_SHARE
    }

    /// Angular momentum at the end of a substep of an articulation that hangs on nothing.
    fn expected_momentum(&mut self, h: f64) -> Option<DVec3> {
        if self.hangs {
            return None;
        }
        self.apply_forces(h);
        let momentum = self.momentum().map(|momentum| momentum.angular);
        for (rate, (_, began)) in self.rates.iter_mut().zip(&self.began) {
            *rate = *began;
        }
        momentum
    }

    /// Notes the substep that ends here for the next one.
    fn note_history(&mut self, h: f64) {
        for (i, (stance, rate)) in self.began.iter().enumerate() {
            self.histories[i] = History::of(h, (stance, rate), (&self.stances[i], &self.rates[i]));
        }
    }

    fn forget_history(&mut self) {
        self.histories.fill(History::NONE);
    }

    fn keep_momentum(&mut self, expected: Option<DVec3>) {
        if let (Some(expected), Some(now)) = (expected, self.momentum()) {
            now.give_back(expected - now.angular, &self.bodies, &self.origins, &self.stances, &mut self.rates);
        }
    }

    /// Momentum of an articulation that hangs on nothing.
    fn momentum(&self) -> Option<Momentum> {
        let Self { bodies, origins, stances, rates, .. } = self;
        if self.hangs { None } else { Momentum::of(bodies, origins, stances, rates) }
    }

    /// Where the bodies would be at the end of the substep without any joint.
    fn predict(&mut self, h: f64, mode: Mode) {
        self.predicted.clear();
        if mode == Mode::Smooth {
            let bodies = self.bodies.iter().zip(&self.rates).zip(&self.stances);
            self.predicted
                .extend(bodies.map(|((body, rate), stance)| (stance.0 + rate.linear * h, body.turn(stance, rate, h).rotation)));
        } else {
            self.predicted.extend_from_slice(&self.stances);
        }
    }

    /// Stiffness of each body from the carried impulses, and with it where each joint takes its Jacobian.
    ///
    /// `share` is what a substep of this length has of the impulses of a whole one.
    pub(super) fn find_stiffness(&mut self, h: f64, taken: Taken, share: f64) {
        self.stiffness.clear();
        self.stiffness.resize(self.bodies.len(), DMat3::ZERO);
        self.implicit.clear();
        for (link, entry) in self.links.iter().zip(&self.entries) {
            let impulse = entry.impulses.point.as_dvec3() * share;
            let levers = [0, 1].map(|side| self.stances[link.bodies[side] as usize].1 * entry.local_lever[side]);
            let implicit = if taken == Taken::AtStart {
                1.0
            } else {
                let ease: f64 =
                    [0, 1].map(|side| self.bodies[link.bodies[side] as usize].turning_ease(levers[side])).iter().sum();
                ((h * impulse.length() * ease - IMPLICIT_RANGE.0) / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0)).clamp(0.0, 1.0)
            };
            self.implicit.push(if taken == Taken::AtEnd { 1.0 } else { implicit });
            if impulse == DVec3::ZERO || implicit == 0.0 {
                continue;
            }
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                self.stiffness[link.bodies[side] as usize] +=
                    stiffness::of_impulse(impulse * sign, levers[side]) * (h * implicit);
            }
        }
    }

    pub(super) fn build_rows(&mut self, joints: &Pool<Joint, JointId>, phase: Phase) {
        let Self { entries, links, rates, stances, began, predicted, implicit, system, asked, .. } = self;
        let in_place = matches!(phase, Phase::Position { .. });
        system.clear();
        for (number, (link, entry)) in links.iter().zip(&*entries).enumerate() {
            let [a, b] = link.bodies.map(|body| body as usize);
            let geometry = if matches!(phase, Phase::Velocity { .. }) {
                let (stances, start) = (|body: usize| began[body].0, entry.placement(began[a].0, began[b].0));
                let end = entry.placement(predicted[a], predicted[b]);
                let between = |body: usize| {
                    let (from, to) = (stances(body), predicted[body]);
                    (from.0.lerp(to.0, implicit[number]), from.1.lerp(to.1, implicit[number]))
                };
                let gradient = match implicit[number] {
                    0.0 => start,
                    1.0 => end,
                    _ => entry.placement(between(a), between(b)),
                };
                JointGeometry { start, predicted: end, gradient }
            } else {
                JointGeometry::at(entry.placement(stances[a], stances[b]))
            };
            asked.clear();
            let mut sink = RowSink {
                rates: [rates[a], rates[b]],
                geometry: &geometry,
                def: &joints[entry.joint].def,
                impulses: if in_place { &JointImpulses::ZERO } else { &entry.impulses },
                phase,
                point: None,
                direction: None,
                scalars: asked,
            };
            kinds::add_rows(&mut sink);
            let (point, direction) = (sink.point, sink.direction);
            system.add(link.bodies, point.as_ref(), direction.as_ref(), asked);
        }
    }

    /// Hands the multipliers back to the joints and adds them to their loads.
    ///
    /// `scale` is the length of the whole substep over that of the one they were found for.
    pub(super) fn keep_impulses(&mut self, scale: f64) {
        let Self { entries, system, links, stances, .. } = self;
        for ((entry, node), link) in entries.iter_mut().zip(&system.nodes).zip(&*links) {
            let (mut point, mut angular) = (DVec3::ZERO, DVec3::ZERO);
            let (mut linear_load, mut angular_load) = (DVec3::ZERO, DVec3::ZERO);
            let lever = stances[link.bodies[1] as usize].1 * entry.local_lever[1];
            for row in &system.rows[node.first as usize..node.last as usize] {
                let impulse = row.impulse * scale;
                match row.origin {
                    Origin::Point(axis) => point += axis * impulse,
                    Origin::Direction(axis) => angular += axis * impulse,
                    Origin::Scalar(id) => {
                        entry.impulses.scalar[id as usize] = impulse as f32;
                        linear_load += row.jacobian.linear * impulse;
                        angular_load += (row.jacobian.angular_b - lever.cross(row.jacobian.linear)) * impulse;
                    }
                }
            }
            entry.impulses.point = point.as_vec3();
            entry.impulses.angular = angular.as_vec3();
            entry.linear_sum += (point + linear_load).as_vec3();
            entry.angular_sum += (angular + angular_load).as_vec3();
        }
    }

    /// Worst error at the present poses, whose position rows are left in the system.
    pub(super) fn find_errors(&mut self, joints: &Pool<Joint, JointId>) -> f64 {
        self.build_rows(joints, Phase::Position { most: f64::INFINITY });
        self.system.worst_error(self.size)
    }

    /// Takes errors out of the positions, whose rows are in the system; returns the worst that is left.
    pub(super) fn project(&mut self, joints: &Pool<Joint, JointId>, mut error: f64) -> f64 {
        for _ in 0..PROJECTIONS {
            if error <= GOOD_ENOUGH * TOLERANCE * self.size || !error.is_finite() {
                break;
            }
            self.changes.clear();
            self.changes.resize(self.bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
            self.system.begin(&self.bodies);
            self.system.solve(&self.topology, &self.bodies, &mut self.changes);
            self.tried.clone_from(&self.stances);
            let mut accepted = false;
            for factor in BACKTRACKING {
                for ((body, stance), change) in self.bodies.iter().zip(&mut self.stances).zip(&self.changes) {
                    body.displace(stance, change, factor);
                }
                let left = self.find_errors(joints);
                if left < error {
                    error = left;
                    accepted = true;
                    break;
                }
                self.stances.clone_from(&self.tried);
            }
            if !accepted {
                break;
            }
        }
        error
    }
}

/// Couples all joints that share a moving body.
fn derive_topology(links: &[Link], bodies: usize) -> Option<Topology> {
    let mut at_body: Vec<Vec<(u32, u8)>> = vec![Vec::new(); bodies];
    for (node, link) in links.iter().enumerate() {
        for side in [0, 1] {
            if link.moves[side] {
                at_body[link.bodies[side] as usize].push((node as u32, side as u8));
            }
        }
    }
    let rows: u64 = links.iter().map(|link| u64::from(link.capacity)).sum();
    let mut couplings = Vec::new();
    for (body, joints) in at_body.iter().enumerate() {
        for (i, &(a, side_a)) in joints.iter().enumerate() {
            for &(b, side_b) in &joints[i + 1..] {
                couplings.push(Coupling { nodes: [a, b], sides: [side_a, side_b], body: body as u32 });
            }
        }
        // Each pair costs more than the rows of its joints do.
        if couplings.len() as u64 > MOST_WORK_PER_ROW * rows {
            return None;
        }
    }
    let mut pairs: Vec<(u32, u32)> = couplings.iter().map(|coupling| coupling.nodes.into()).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let capacity: Vec<u32> = links.iter().map(|link| link.capacity).collect();
    Some(Topology { plan: Plan::new(&capacity, &pairs, MOST_WORK_PER_ROW * rows)?, couplings })
}
