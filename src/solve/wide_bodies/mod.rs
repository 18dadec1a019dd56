//! Integrates and predicts bodies eight at a time.
//!
//! The rules are those of [`integrate`](super::integrate) and [`rotation`](super::rotation). Those of a body on its own are in `f64`,
//! since in `f32` the rounding of L = I ω is biased. Here L is never formed and taken apart again: all that a substep changes is a
//! *difference*. In the principal axes of the substep's start, with q what has turned the body since then and E = I⁻¹,
//!
//! ```text
//! L in the axes of now = L + d,    d = (q⁻¹ − 1) L,    ω = ω₀ + e + (q − 1)(ω₀ + e),    e = E d,
//! ```
//!
//! and (q − 1) u = 2 v × (w u + v × u) is right to rounding of the way itself. So what is rounded is the change of ω, of the order of
//! what the body turns by, and then one sum: half a unit in the last place of ω, as likely up as down.
//!
//! What the rule refuses (it gains energy, or turns by more than a lever allows) is left to the rules of one body.

use std::sync::{Mutex, PoisonError};

use glam::{DMat3, Vec3};

use super::body_flags::BodyFlags;
use super::contact::{LANES, Lane, Lane3};
use super::disjoint::{DisjointMut, Shared};
use super::integrate::{self, PredictedPose};
use super::state::{BodyMotion, BodyVelocity, Constraints, MotionKind, Symmetric};
use crate::platform::in_lanes;
use crate::tight_vec::{make_room_behind, resize};
use crate::workers::Workers;

mod kernels;
pub(crate) mod search_direction;
#[cfg(test)]
mod tests;
mod turn;

pub(super) use kernels::TURNING_LET_BE;

/// Blocks of bodies from which on several threads move them, and those that are worth another thread's while: some 3 µs.
const SHARED_BLOCKS: usize = 64;
const MIN_BLOCKS: usize = 16;

/// Bodies from which on several threads lay them out, and those that are worth another thread's while: some 2 µs.
const SHARED_BODIES: usize = 1024;
const MIN_BODIES: usize = 256;

/// Bodies from which on several threads move those that are in no block, and those that are worth another thread's while.
const SHARED_SINGLES: usize = 512;
const MIN_SINGLES: usize = 128;

/// What does not change within the step of eight bodies; unused lanes are the world, which nothing moves.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct PoseBlock {
    slots: [u32; LANES],
    count: u32,
    /// Principal moments of inertia (kg·m²), and the rotation of their axes in the body.
    inertia: Lane3,
    frame: [Lane; 4],
    /// What gravity and the host's forces add to the velocity in a substep (m/s), and the host's angular impulse (N·m·s).
    gain: Lane3,
    torque: Lane3,
    /// What damping leaves of linear and angular velocity in a substep.
    left: [Lane; 2],
    /// 1 where principal moments differ.
    tumbles: Lane,
}

impl PoseBlock {
    const EMPTY: Self = Self {
        slots: [0; LANES],
        count: 0,
        inertia: [[1.0; LANES]; 3],
        frame: [[0.0; LANES], [0.0; LANES], [0.0; LANES], [1.0; LANES]],
        gain: [[0.0; LANES]; 3],
        torque: [[0.0; LANES]; 3],
        left: [[1.0; LANES]; 2],
        tumbles: [0.0; LANES],
    };

    /// Takes a body, which is described later.
    fn name(&mut self, slot: u32) -> usize {
        let l = self.count as usize;
        self.count += 1;
        self.slots[l] = slot;
        l
    }

    /// Describes all its bodies.
    fn describe(&mut self, motions: &[BodyMotion], h: f32) {
        for l in 0..self.count as usize {
            self.describe_lane(l, &motions[self.slots[l] as usize], h);
        }
    }

    fn describe_lane(&mut self, l: usize, motion: &BodyMotion, h: f32) {
        put(&mut self.inertia, l, motion.inertia);
        for (lanes, number) in self.frame.iter_mut().zip(motion.inertia_frame.normalize().to_array()) {
            lanes[l] = number;
        }
        put(&mut self.gain, l, motion.acceleration * h);
        put(&mut self.torque, l, motion.torque * h);
        self.left[0][l] = 1.0 / (1.0 + h * motion.linear_damping);
        self.left[1][l] = 1.0 / (1.0 + h * motion.angular_damping);
        self.tumbles[l] = f32::from(u8::from(motion.kind == MotionKind::Tumbling));
    }
}

fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    [lanes[0][l], lanes[1][l], lanes[2][l]] = v.to_array();
}

/// The bodies of a batch that are in joints, and where they will be; and those in contacts alone, which are only moved here.
#[derive(Debug, Default)]
pub(crate) struct WideBodies {
    blocks: Vec<PoseBlock>,
    pushed: Vec<PoseBlock>,
    /// Slots that are not moved in lanes, or only moved there; and of those, the ones that are not moved there.
    pub singles: Vec<u32>,
    pub alone: Vec<u32>,
    /// Slots in joints that are predicted one by one: kinematic bodies, and those with locked axes.
    others: Vec<u32>,
    /// Where each jointed body will be at the end of the substep, as predicted when rows were last built.
    pub predicted_poses: Vec<PredictedPose>,
    /// Bodies of a block that the rule refused.
    refused: Vec<u32>,
    /// Inertia in world axes of bodies in lanes, by slot: xx, yy, zz, xy, xz, yz (kg·m²), and two numbers without meaning.
    inertia: Vec<[f32; LANES]>,
    /// Kinetic energy of bodies in lanes, by slot (J), as found last: when forces were added, or since.
    pub energies: Vec<f32>,
    /// How each body that is watched stood before position rows turned it, by slot: x, y, z, w, and four numbers without meaning.
    noted: Vec<[f32; LANES]>,
    /// Greatest slot of a body in lanes.
    last: usize,
    /// Whether each slot is only moved in lanes, where that is found on all threads.
    are_pushed: Vec<bool>,
}

/// Whether a body is moved in lanes. What that depends on must not be what else is in its batch.
fn suits(velocity: &BodyVelocity, motion: &BodyMotion) -> bool {
    motion.jointed && is_free(velocity, motion)
}

/// Whether a body is moved in lanes, but nothing else of it done there: its inertia, and with it the masses of contacts, is formed
/// anew only after it has turned. What falls does so along a parabola, and is moved by itself.
fn is_pushed(velocity: &BodyVelocity, motion: &BodyMotion) -> bool {
    !motion.jointed && motion.constraints == Constraints::Holding && is_free(velocity, motion)
}

/// Takes note of contacts that hold a body.
fn note_contacts(motion: &mut BodyMotion, flags: Option<&BodyFlags>) {
    if motion.constraints == Constraints::None && flags.is_some_and(|flags| flags.is_touched()) {
        motion.constraints = Constraints::Holding;
    }
}

fn is_free(velocity: &BodyVelocity, motion: &BodyMotion) -> bool {
    let is_unlocked = velocity.inverse_mass.min_element() > 0.0 && motion.is_free_to_turn();
    !motion.direct && motion.is_dynamic() && is_unlocked
}

/// Gives a body the next lane.
fn name(blocks: &mut Vec<PoseBlock>, slot: u32) -> Option<(&mut PoseBlock, usize)> {
    if blocks.last().is_none_or(|block| block.count as usize == LANES) {
        make_room_behind(blocks, 1);
        blocks.push(PoseBlock::EMPTY);
    }
    blocks.last_mut().map(|block| {
        let lane = block.name(slot);
        (block, lane)
    })
}

fn add(blocks: &mut Vec<PoseBlock>, slot: u32, motion: &BodyMotion, h: f32) {
    if let Some((block, lane)) = name(blocks, slot) {
        block.describe_lane(lane, motion, h);
    }
}

/// The bodies of a batch, by slot.
type Bodies<'a> = (&'a mut [BodyVelocity], &'a mut [BodyMotion]);

/// Does the same to each body of a list.
fn each_listed(
    mut rest: &[u32],
    threads: &Workers,
    (velocities, motions): Bodies<'_>,
    work: impl Fn(&mut BodyVelocity, &mut BodyMotion) + Sync,
) {
    if rest.len() < SHARED_SINGLES || !threads.has_team() {
        rest.iter().for_each(|&slot| work(&mut velocities[slot as usize], &mut motions[slot as usize]));
        return;
    }
    let piece = threads.piece(motions.len(), MIN_SINGLES);
    let pieces = velocities.chunks_mut(piece).zip(motions.chunks_mut(piece)).zip((0..).step_by(piece));
    let pieces = pieces.map(|(bodies, first)| {
        let own;
        (own, rest) = rest.split_at(rest.partition_point(|&slot| (slot as usize) < first + piece));
        (bodies, own, first)
    });
    threads.share(pieces, |((velocities, motions), own, first)| {
        own.iter().map(|&slot| slot as usize - first).for_each(|place| work(&mut velocities[place], &mut motions[place]));
    });
}

impl WideBodies {
    /// Does the same to each body that is not moved in lanes, or only moved there.
    pub(super) fn each_single(
        &self,
        threads: &Workers,
        bodies: Bodies<'_>,
        work: impl Fn(&mut BodyVelocity, &mut BodyMotion) + Sync,
    ) {
        each_listed(&self.singles, threads, bodies, work);
    }

    /// Does the same to each body that is not moved in lanes.
    pub(super) fn each_alone(
        &self,
        threads: &Workers,
        bodies: Bodies<'_>,
        work: impl Fn(&mut BodyVelocity, &mut BodyMotion) + Sync,
    ) {
        each_listed(&self.alone, threads, bodies, work);
    }

    /// Lays out lanes for substeps of length `h`.
    pub(crate) fn lay_out(
        &mut self,
        threads: &Workers,
        (velocities, motions): (&[BodyVelocity], &mut [BodyMotion]),
        body_flags: &[BodyFlags],
        h: f32,
    ) {
        // Of what is not in lanes too, which nothing writes: an island's range of slots may end with bodies that the host moves.
        self.energies.clear();
        self.energies.resize(motions.len(), 0.0);
        self.blocks.clear();
        self.pushed.clear();
        self.singles.clear();
        self.alone.clear();
        self.others.clear();
        self.last = 0;
        let is_shared = threads.has_team() && motions.len() >= SHARED_BODIES;
        if is_shared && !body_flags.iter().any(|role| role.is_jointed()) {
            self.lay_out_loose(threads, (velocities, motions), body_flags, h);
        } else {
            self.lay_out_all((velocities, motions), body_flags, h);
        }
        let Self { blocks, pushed, singles, others, predicted_poses, refused, inertia, noted, .. } = self;
        if !blocks.is_empty() {
            inertia.resize(motions.len(), [0.0; LANES]);
            noted.clear();
            noted.resize(motions.len(), [0.0; LANES]);
        }
        if !(blocks.is_empty() && others.is_empty()) {
            // Of what is in lanes they are found before anybody asks.
            resize(predicted_poses, motions.len(), PredictedPose::still(&motions[0]));
            singles.iter().for_each(|&slot| predicted_poses[slot as usize] = PredictedPose::still(&motions[slot as usize]));
        }
        refused.reserve((blocks.len() + pushed.len()) * LANES);
    }

    /// Bounds the spin of needles that come to contacts before these push them: one that flew has kept all of its own.
    pub(crate) fn limit_spins_of_needles(&self, velocities: &mut [BodyVelocity], h: f32) {
        let slots = self.pushed.iter().flat_map(|block| &block.slots[..block.count as usize]);
        slots.for_each(|&slot| integrate::limit_spin_of_needle(&mut velocities[slot as usize], h));
    }

    fn lay_out_all(&mut self, (velocities, motions): (&[BodyVelocity], &mut [BodyMotion]), body_flags: &[BodyFlags], h: f32) {
        let Self { blocks, pushed, singles, alone, others, last, .. } = self;
        for (slot, (velocity, motion)) in velocities.iter().zip(motions.iter_mut()).enumerate() {
            note_contacts(motion, body_flags.get(slot));
            motion.in_lanes = suits(velocity, motion);
            if motion.in_lanes {
                motion.world_inertia.refreshed = motion.kind == MotionKind::Tumbling;
                add(blocks, slot as u32, motion, h);
                *last = slot;
                continue;
            }
            singles.push(slot as u32);
            if is_pushed(velocity, motion) {
                add(pushed, slot as u32, motion, h);
                continue;
            }
            alone.push(slot as u32);
            if motion.jointed {
                others.push(slot as u32);
            }
        }
    }

    /// The same of many bodies none of which is in a joint.
    fn lay_out_loose(
        &mut self,
        threads: &Workers,
        (velocities, motions): (&[BodyVelocity], &mut [BodyMotion]),
        body_flags: &[BodyFlags],
        h: f32,
    ) {
        let Self { pushed, singles, alone, are_pushed, .. } = self;
        are_pushed.resize(motions.len(), false);
        let piece = threads.piece(motions.len(), MIN_BODIES);
        let bodies = velocities.chunks(piece).zip(motions.chunks_mut(piece)).zip(are_pushed.chunks_mut(piece));
        threads.share(bodies.zip((0..).step_by(piece)), |(((velocities, motions), are_pushed), first)| {
            for (((velocity, motion), own), slot) in velocities.iter().zip(motions).zip(are_pushed).zip(first..) {
                debug_assert!(!motion.jointed, "it is in a joint");
                note_contacts(motion, body_flags.get(slot));
                motion.in_lanes = false;
                *own = is_pushed(velocity, motion);
            }
        });
        singles.extend(0..motions.len() as u32);
        alone.extend((0..).zip(&*are_pushed).filter(|&(_, &own)| !own).map(|(slot, _)| slot));
        for (slot, _) in (0..).zip(&*are_pushed).filter(|&(_, &own)| own) {
            name(pushed, slot);
        }
        let (piece, motions) = (threads.piece(pushed.len(), MIN_BLOCKS), &*motions);
        threads.share(pushed.chunks_mut(piece), |blocks| blocks.iter_mut().for_each(|block| block.describe(motions, h)));
    }

    /// Adds a substep's forces to velocities, and forms the world inertia that rows respond with.
    pub(crate) fn apply_forces(&mut self, threads: &Workers, velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
        let Self { blocks, energies, last, .. } = self;
        let (velocities, energies) = (Shared::new(velocities, *last), Shared::new(energies, *last));
        each_piece(blocks, threads, |blocks| {
            // SAFETY: each slot is in one block, which one thread goes through.
            let (mut velocities, mut energies) = unsafe { (velocities.hand(), energies.hand()) };
            apply_forces_all(blocks, &mut velocities, motions, &mut energies, h);
        });
    }

    /// As [`integrate::limit_speeds`].
    pub(crate) fn limit_speeds(&mut self, threads: &Workers, velocities: &mut [BodyVelocity]) {
        let velocities = Shared::new(velocities, self.last);
        each_piece(&self.blocks, threads, |blocks| {
            // SAFETY: each slot is in one block, which one thread goes through.
            limit_all(blocks, &mut unsafe { velocities.hand() });
        });
    }

    /// Finds the inertia of bodies in lanes as they stand now.
    pub(crate) fn find_inertia(&mut self, motions: &[BodyMotion]) {
        find_inertia_all(&self.blocks, motions, &mut self.inertia);
    }

    /// Finds the kinetic energies of bodies in lanes at these velocities.
    pub(crate) fn find_energies(&mut self, threads: &Workers, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        let energies = Shared::new(&mut self.energies, self.last);
        each_piece(&self.blocks, threads, |blocks| {
            // SAFETY: each slot is in one block, which one thread goes through.
            find_energies_all(blocks, velocities, motions, &mut unsafe { energies.hand() });
        });
    }

    /// Notes how bodies with these slots stand, before position rows turn them.
    pub(crate) fn note_rotations(&mut self, slots: impl Iterator<Item = usize>, motions: &[BodyMotion]) {
        slots.filter(|&slot| motions[slot].in_lanes).for_each(|slot| self.noted[slot] = *motions[slot].halves()[1]);
    }

    /// Keeps position rows from giving bodies that were noted energy. Where they turn a rod that spins about its length and its angular velocity
    /// stays as it is, that is a spin across its length in part, with a thousand times the inertia: so it goes with the rod.
    pub(crate) fn keep_turning(&self, threads: &Workers, velocities: &mut [BodyVelocity], motions: &[BodyMotion]) {
        let velocities = Shared::new(velocities, self.last);
        each_piece(&self.blocks, threads, |blocks| {
            // SAFETY: each slot is in one block, which one thread goes through.
            keep_turning_all(blocks, &mut unsafe { velocities.hand() }, motions, &self.noted);
        });
    }

    /// The same of a body that has been turned since, if it is in lanes.
    pub(crate) fn refresh_inertia_of(&mut self, slot: u32, motion: &BodyMotion) {
        if !motion.in_lanes {
            return;
        }
        let tensor = crate::shape::inertia_tensor(motion.inertia, motion.rotation * motion.inertia_frame);
        self.inertia[slot as usize][..6].copy_from_slice(Symmetric::from_mat3(tensor).entries());
    }

    /// Inertia of a body in world axes, as found last if it is in lanes: xx, yy, zz, xy, xz, yz (kg·m²).
    #[inline]
    pub(crate) fn inertia_of(&self, slot: u32, motion: &BodyMotion) -> [f64; 6] {
        if motion.in_lanes {
            let [xx, yy, zz, xy, xz, yz, ..] = self.inertia[slot as usize];
            return [xx, yy, zz, xy, xz, yz].map(f64::from);
        }
        let axes = DMat3::from_quat((motion.rotation.as_dquat() * motion.inertia_frame.as_dquat()).normalize());
        let m = axes * DMat3::from_diagonal(motion.inertia.as_dvec3()) * axes.transpose();
        [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.x_axis.y, m.x_axis.z, m.y_axis.z]
    }

    /// Finds where bodies in joints will be at the end of the substep at their present velocities.
    pub(crate) fn predict(&mut self, threads: &Workers, velocities: &[BodyVelocity], motions: &[BodyMotion], h: f32) {
        let Self { blocks, others, predicted_poses, refused, last, .. } = self;
        refused.clear();
        if !blocks.is_empty() {
            let (shared, refused) = (Shared::new(predicted_poses, *last), Mutex::new(&mut *refused));
            each_piece(blocks, threads, |blocks| {
                listing(&refused, |refused| {
                    // SAFETY: each slot is in one block, which one thread goes through.
                    predict_all(blocks, velocities, motions, &mut unsafe { shared.hand() }, refused, h);
                });
            });
        }
        for &slot in others.iter().chain(&*refused) {
            let slot = slot as usize;
            predicted_poses[slot] = PredictedPose::of(&velocities[slot], &motions[slot], h);
        }
    }

    /// Moves bodies through a substep at their velocities.
    pub(crate) fn advance(
        &mut self,
        threads: &Workers,
        (velocities, motions, moving): (&mut [BodyVelocity], &mut [BodyMotion], usize),
        h: f32,
    ) {
        let Self { blocks, pushed, refused, .. } = self;
        refused.clear();
        let mut unpushed = 0;
        for blocks in [&*blocks, &*pushed] {
            unpushed = refused.len();
            let (velocities, motions) = (Shared::new(velocities, moving), Shared::new(motions, moving));
            let refused = Mutex::new(&mut *refused);
            each_piece(blocks, threads, |blocks| {
                // SAFETY: each slot is in one block, which one thread goes through.
                let (mut velocities, mut motions) = unsafe { (velocities.hand(), motions.hand()) };
                listing(&refused, |refused| advance_all(blocks, &mut velocities, &mut motions, refused, h));
            });
        }
        refused[unpushed..].iter().for_each(|&slot| integrate::limit_spin_of_needle(&mut velocities[slot as usize], h));
        for &slot in &*refused {
            integrate::advance(&mut velocities[slot as usize], &mut motions[slot as usize], h);
        }
    }
}

/// Works on all blocks: many on all threads, few at once.
fn each_piece(blocks: &[PoseBlock], threads: &Workers, work: impl Fn(&[PoseBlock]) + Sync) {
    if blocks.len() < SHARED_BLOCKS || !threads.has_team() {
        work(blocks);
    } else {
        threads.share(blocks.chunks(threads.piece(blocks.len(), MIN_BLOCKS)), work);
    }
}

/// Has one of several threads add to a list, in whose memory one alone does.
fn listing(list: &Mutex<&mut Vec<u32>>, work: impl FnOnce(&mut Vec<u32>)) {
    let lock = || list.lock().unwrap_or_else(PoisonError::into_inner);
    let mut own = std::mem::take(&mut **lock());
    work(&mut own);
    let mut all = lock();
    if all.is_empty() {
        std::mem::swap(&mut **all, &mut own);
    }
    all.append(&mut own);
}

in_lanes!(
    apply_forces_all, kernels::apply_forces,
    (
        blocks: &[PoseBlock], velocities: &mut DisjointMut<'_, BodyVelocity>, motions: &[BodyMotion], energies: &mut DisjointMut<'_, f32>, h: f32
    )
);
in_lanes!(find_inertia_all, kernels::find_inertia, (blocks: &[PoseBlock], motions: &[BodyMotion], inertia: &mut [Lane]));
in_lanes!(
    find_energies_all, kernels::find_energies,
    (blocks: &[PoseBlock], velocities: &[BodyVelocity], motions: &[BodyMotion], energies: &mut DisjointMut<'_, f32>)
);
in_lanes!(
    keep_turning_all, kernels::keep_turning,
    (blocks: &[PoseBlock], velocities: &mut DisjointMut<'_, BodyVelocity>, motions: &[BodyMotion], noted: &[[f32; LANES]])
);
in_lanes!(limit_all, kernels::limit, (blocks: &[PoseBlock], velocities: &mut DisjointMut<'_, BodyVelocity>));
in_lanes!(
    predict_all, kernels::predict,
    (
        blocks: &[PoseBlock], velocities: &[BodyVelocity], motions: &[BodyMotion], predicted_poses: &mut DisjointMut<'_, PredictedPose>,
        refused: &mut Vec<u32>, h: f32
    )
);
in_lanes!(
    advance_all, kernels::advance,
    (
        blocks: &[PoseBlock], velocities: &mut DisjointMut<'_, BodyVelocity>, motions: &mut DisjointMut<'_, BodyMotion>, refused: &mut Vec<u32>, h: f32
    )
);
