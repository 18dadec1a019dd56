//! Direct solve of articulations: all joints of connected bodies at once, by one sparse factorisation in `f64` on `f32` state.
//!
//! A sweep passes a force on by one joint at a time and forgets most of it where a light body meets a heavy one; the factor knows
//! the whole articulation. A chain of n joints costs n, a bridge little more, at any ratio of masses.
//!
//! | file | what |
//! |---|---|
//! | `build`, `rejection_cache` | which joints become articulations; which articulations were too much work |
//! | `articulation`, `articulation_state`, `substep_control`, `advance`, `substep` | a step of one articulation, its number of substeps, and each of them |
//! | `build_rows`, `topology`, `layout`, `system`, `row`, `active_set`, `packed_rows`, `refine` | the rows, their matrix, which of them act, the solve |
//! | `ball_joint_system`, `ball_joints` | the same for articulations of ball joints alone |
//! | `redundancy`, `loops` | rows that repeat others |
//! | `body`, `stiffness`, `distance_stiffness`, `composite`, `servo_loops` | inertia, geometric stiffness, what a motor moves |
//! | `multistep`, `rotor`, `rotors` | second order in time; bodies that spin fast |
//! | `project`, `projection_energy`, `buckle` | position correction, and the energy that it may not add |
//! | `impact`, `soft_stops`, `struck` | stops that are met; velocities that the host has set |
//! | `contacts`, `contact_rows`, `tracked_points`, `curved_contacts`, `speculative_contacts`, `carried_bodies` | contacts |
//! | `block_constraint`, `block_constraints`, `factor_reuse` | articulations that touch moving bodies, swept with contacts |
//! | `articulation_batch`, `interleaved_system` | four of those at a time |
//! | `wide_integrator`, `fours` | bodies, four at a time |

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DMat3, DVec3};

use super::StepSettings;
use super::body_flags::BodyFlags;
use super::buckets::Buckets;
use super::contact::{ContactImpulses, ContactInput};
use super::joint::{JointEntry, JointLink, worst_gap};
use super::state::{BodyMotion, BodyVelocity};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
#[cfg(test)]
use crate::linalg::noise;
use crate::linalg::{block, factor};
use crate::settings::Solver;
use crate::workers::Workers;

mod active_set;
mod advance;
mod articulation;
mod articulation_batch;
mod articulation_state;
mod ball_joint_system;
mod ball_joints;
mod beside;
mod block_constraint;
mod block_constraints;
pub(crate) mod body;
mod buckle;
mod build;
mod build_rows;
mod carried_bodies;
mod composite;
mod contact_rows;
mod contacts;
pub(crate) mod curved_contacts;
mod distance_stiffness;
mod factor_reuse;
mod fours;
mod free_rows;
mod friction_cone;
mod impact;
mod interleaved_system;
mod layout;
mod loops;
mod multistep;
mod packed_rows;
mod project;
mod projection_energy;
mod redundancy;
mod refine;
mod rejection_cache;
mod rotor;
mod rotors;
pub(crate) mod round_on_block;
mod row;
mod self_stress;
mod servo_loops;
mod soft_stops;
mod speculative_contacts;
pub(crate) mod stiffness;
mod struck;
mod substep;
mod substep_control;
mod system;
mod topology;
pub(crate) mod tracked_points;
mod wide_integrator;

use crate::step_history::History;
use articulation::Articulation;
use articulation_batch::ArticulationBatches;
pub(crate) use block_constraints::SolveContext;
use build::ArticulationCandidate;
use carried_bodies::CarriedBodies;
pub(crate) use carried_bodies::{MAX_MANIFOLDS, MAX_RIDERS};
pub(crate) use layout::are_few;
use rejection_cache::RejectionCache;
pub(crate) use row::FRICTION_ROWS;

/// Group of a joint that moves nothing.
const NO_GROUP: u32 = u32::MAX;

/// Articulations at whose gaps to look is worth another thread's while.
const MIN_LOOKS: usize = 16;

/// The articulations of a batch that are solved directly.
#[derive(Debug, Default)]
pub(crate) struct Direct {
    articulations: Vec<Articulation>,
    count: usize,
    /// What the world says of joints that ask for nothing else.
    pub solver: Solver,
    /// Articulation that has each slot of the batch, and its local number there.
    local: Vec<(u32, u32)>,
    /// Articulation of each slot, as a union–find forest, then as a number.
    group: Vec<u32>,
    /// What the body of each slot is, where there are joints.
    body_flags: Vec<BodyFlags>,
    /// Whether joints connect each slot to another that moves.
    jointed: Vec<bool>,
    /// Unjointed bodies that are solved with what carries them.
    riders: CarriedBodies,
    /// Group and number of each contact of a jointed body or a rider, and the numbers by group.
    touches: Vec<(u32, u32)>,
    touching: Buckets,
    candidates: Vec<ArticulationCandidate>,
    left: Vec<JointLink>,
    refused: RejectionCache,
    locksteps: ArticulationBatches,
    /// Group of each joint, and room to sort joints by it.
    order: Vec<u32>,
    keys: Vec<(u32, u32)>,
    by_group: Buckets,
    sorted: Vec<JointLink>,
    /// Contacts that need no other rows, by number, and the multipliers of those that press.
    held: Vec<bool>,
    impulses: Vec<(u32, [ContactImpulses; 2])>,
}

/// What the world knows of a batch beyond the batch's own arrays.
pub(crate) trait BatchRecords {
    /// A joint as it is solved.
    fn joint(&self, link: &JointLink) -> JointEntry;
    /// Where a slot's body stands (m), and its last substep.
    fn body(&self, slot: u32) -> (DVec3, (History, bool));
    /// Shape operators of both surfaces of the contact of this number in world axes (1/m), where both are smooth, and how far its
    /// body B, or else A, reaches from its centre of mass (m).
    fn curvature(&self, contact: u32, of_b: bool) -> Option<([DMat3; 2], f64)>;
    /// How far the first point of a contact on B is from that on A (m, world axes).
    fn offset(&self, contact: u32) -> DVec3;
}

impl Direct {
    /// Forgets the articulations of the last step but for what they may use again, and every list that numbers them or their contacts.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.held.clear();
        self.impulses.clear();
        self.locksteps.clear();
    }

    /// Articulations solved directly in this step.
    pub(crate) fn articulations(&self) -> &[Articulation] {
        &self.articulations[..self.count]
    }

    /// Joints solved directly, as their batch holds them.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &JointEntry> {
        self.articulations().iter().flat_map(|articulation| &articulation.entries)
    }

    /// The last substep of each body that an articulation moves by itself, by slot.
    pub(crate) fn histories(&self) -> impl Iterator<Item = (u32, &History)> {
        self.articulations().iter().filter(|articulation| !articulation.coupled).flat_map(Articulation::histories)
    }

    /// Bodies whose contacts are swept in the next steps too although they might be rows, by slot, and for how long once a step of `dt` (s) is over (s).
    pub(crate) fn swept_for(&self, dt: f32) -> impl Iterator<Item = (u32, f32)> {
        let swept = self.articulations().iter().filter(|articulation| articulation.coupled && articulation.swept_for > 0.0);
        swept.flat_map(move |articulation| {
            let left = articulation.swept_for - dt;
            // To the nearest step, whatever rounding leaves.
            let left = if left < 0.5 * dt { 0.0 } else { left };
            articulation.moved_slots().map(move |slot| (slot, left))
        })
    }

    /// Whether the contact of this number needs no rows of its own.
    pub(crate) fn holds(&self, number: usize) -> bool {
        self.held.get(number).copied().unwrap_or(false)
    }

    /// Multipliers of a contact that it holds.
    pub(crate) fn impulses_of(&self, number: usize) -> ContactImpulses {
        self.found_of(number)[0]
    }

    /// Sum of the multipliers of a contact that it holds, over the step.
    pub(crate) fn sum_of(&self, number: usize) -> ContactImpulses {
        self.found_of(number)[1]
    }

    fn found_of(&self, number: usize) -> [ContactImpulses; 2] {
        let found = self.impulses.binary_search_by_key(&(number as u32), |&(number, _)| number);
        found.map_or([ContactImpulses::default(); 2], |found| self.impulses[found].1)
    }

    /// Worst overlap of the contacts that it holds (m).
    pub(crate) fn penetration(&self) -> f64 {
        self.articulations().iter().map(|articulation| articulation.outcome.penetration).fold(0.0, f64::max)
    }

    /// Greatest distance between joint points beyond what their joints allow (m).
    pub(crate) fn joint_gap(&self, joints: &Pool<Joint, JointId>, motions: &[BodyMotion], threads: &Workers) -> f32 {
        let articulations = self.articulations();
        // None is negative, and those of floats that are not are in the order of their bits.
        let worst = AtomicU32::new(0);
        threads.share(articulations.chunks(threads.piece(articulations.len(), MIN_LOOKS)), |articulations| {
            let entries = articulations.iter().flat_map(|articulation| &articulation.entries);
            worst.fetch_max(worst_gap(entries, joints, motions).to_bits(), Ordering::Relaxed);
        });
        f32::from_bits(worst.into_inner())
    }

    /// Whether any articulation is swept as a block.
    pub(crate) fn sweeps_blocks(&self) -> bool {
        self.articulations().iter().any(|articulation| articulation.coupled)
    }

    /// Slots of the bodies that articulations move by themselves.
    pub(crate) fn slots_moved_alone(&self) -> impl Iterator<Item = u32> {
        self.articulations().iter().filter(|articulation| !articulation.coupled).flat_map(Articulation::moved_slots)
    }

    /// Joints of the articulations that touch what moves.
    pub(crate) fn coupled_entries(&self) -> impl Iterator<Item = &JointEntry> {
        self.articulations().iter().filter(|articulation| articulation.coupled).flat_map(|articulation| &articulation.entries)
    }

    /// Moves the articulations through the step that touch nothing which moves; one that comes to touch is left for the sweeps.
    pub(crate) fn step(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        contacts: &[ContactInput],
        settings: &StepSettings,
        threads: &Workers,
    ) {
        let (starts, bodies) = (&*velocities, &*motions);
        let articulations = &mut self.articulations[..self.count];
        let piece = threads.piece(articulations.len(), 1);
        threads.share_among_all(articulations.chunks_mut(piece), |articulations| {
            for articulation in articulations.iter_mut().filter(|articulation| !articulation.coupled) {
                articulation.step(joints, starts, bodies, settings);
            }
        });
        while let Some(number) = self.first_to_meet(velocities, motions, contacts, settings.dt) {
            self.articulations[number].give_up();
        }
        for articulation in self.articulations[..self.count].iter_mut().filter(|articulation| !articulation.coupled) {
            articulation.store(velocities, motions);
            for slot in articulation.moved_slots() {
                motions[slot as usize].direct = true;
            }
            for &number in &articulation.watched {
                self.held[number as usize] = true;
            }
            for touch in &articulation.touches {
                self.held[touch.number as usize] = true;
                self.impulses.push((touch.number, [touch.impulses(), touch.sum]));
            }
        }
        self.impulses.sort_unstable_by_key(|&(number, _)| number);
    }

    /// An articulation that has taken its step by itself although it comes to touch what moves, or found no end to it.
    ///
    /// Where one gives up, it no longer stands where it has gone, so the others are judged anew.
    fn first_to_meet(
        &self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        contacts: &[ContactInput],
        dt: f32,
    ) -> Option<usize> {
        let paths = |slot: u32| {
            let (number, local) = self.local[slot as usize];
            let own = self.articulations.get(number as usize).filter(|own| (number as usize) < self.count && !own.coupled);
            match own.and_then(|own| own.path_of(slot, local)) {
                Some(path) => [path; 2],
                None => speculative_contacts::free_paths(&velocities[slot as usize], &motions[slot as usize], dt),
            }
        };
        self.articulations().iter().position(|articulation| {
            let mut watched = articulation.watched.iter().map(|&number| &contacts[number as usize]);
            !articulation.coupled
                && (articulation.outcome.unsettled
                    || watched.any(|contact| speculative_contacts::meets(contact, paths(contact.a), paths(contact.b))))
        })
    }
}

/// Lowest member of a group that is joined to this one; ways there are shortened.
fn root(group: &mut [u32], mut member: u32) -> u32 {
    while group[member as usize] != member {
        group[member as usize] = group[group[member as usize] as usize];
        member = group[member as usize];
    }
    member
}
