//! Energy check of joints and contacts that are swept together: a sweep may take energy, never add it.
//!
//! A substep minimises D(λ) = ½ λᵀ A λ + λᵀ J v, A = J M⁻¹ Jᵀ, over multipliers of joints, and of contacts that only press and
//! rub. It is what λ adds to the kinetic energy T of velocities v, and more where gaps are left to close in on. Every solve of an
//! articulation and every push at a contact lowers D, so from λ = 0 on T does not grow. Multipliers that are carried do not start
//! there. Where they are the forces of a substep unlike this one, as where links are jammed between a weight and what they are
//! wound around, they start far above, the few sweeps of a substep do not come down, and the next has more to carry.
//!
//! So of each island with joints that anything touches or moves T is noted when forces have been added, and looked at again after
//! the sweeps. Where it has grown to more than [`AFRESH`] of that, the substep is solved once more from no multipliers at all,
//! for that island alone. Not where T' is less than what forces give bodies in a substep from rest, Σ ½ m (a h)²: what rests has a T of no more than
//! that before the sweeps, and of what bears hundreds of times its own weight sweeps leave as much. Its multipliers are those of its load. Without
//! them it sinks as fast as a few sweeps from nothing let it: a tank on its tracks by 9 cm a second, for as long as it is parked. What it has grown by even then, by rounding and by friction, whose bounds follow other multipliers, is
//! taken from all its velocities, v ← √(T/T') v: what joints hold stays held, and what opens or rests does so at any scale. Where
//! joints are swept one by one there is no second solve; beyond [`TORN`] velocities are put back and multipliers given up.
//!
//! T is that of masses alone. Geometric stiffness G of articulations makes it no greater: a substep begins with (I + G) ω' = I ω,
//! for which ω'ᵀ (I + G) ω' ≤ ωᵀ I ω, and sweeps lower that sum.
//!
//! **What moves by itself** does work. Rows do not feel a rigid motion of all bodies that they act between. So where everything
//! that an island hangs on or touches is one kinematic body, T is that of velocities against its motion. Of several with motions
//! r₁, r₂, … none is such a frame. With each alone √T would grow by 2 √T(r) at most, so √T' ≤ √T + 2 Σ √T(rₖ) is let be.
//!
//! **Motors and springs** do work λ J v', as in [`joint_energy`](super::joint_energy), which is let be on top, and so do all rows of joints whose
//! stops or frames the host moves: what holds J v = −u gives −λ u. Springs of joints that are
//! swept one by one are not looked at: an island with any of those is left as it is.

mod find;
mod release;
mod resolve_cold;

use std::ops::Range;

use glam::DVec3;

use super::batch::Batch;
use super::contact::LANES;
use super::joint_energy::{JointEnergy, put_back_unmoved};
use super::smeared_spins::SmearedSpins;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::WideBodies;
use crate::tuning::energy::{AFRESH, TORN};
use crate::workers::Workers;
pub(crate) use release::LoadRelease;
use resolve_cold::ColdSolve;

/// Growth of kinetic energy by the sweeps of a substep that is let be, as a share of it: rounding of `f32`.
const LET_BE: f64 = 1.0e-4;

/// What is in no island that is watched.
const NOBODY: u32 = u32::MAX;

/// An island with an articulation that is swept with contacts: a range of slots.
#[derive(Debug, Clone, Copy)]
struct SweptIsland {
    first: u32,
    end: u32,
    /// Whether it hangs on or touches what stands still, and its carriers, as a range of those of the batch.
    touches_still: bool,
    carriers: (u32, u32),
    /// Whether it has joints that are swept one by one, and joints that may give energy.
    has_swept_joints: bool,
    has_drives: bool,
    /// Kinetic energy that it may have after the sweeps but for what drives it, that it has, and the work of motors and springs
    /// (J).
    allowed: f64,
    after: f64,
    work: f64,
    /// What forces give its bodies in a substep from rest (J).
    pulled: f64,
    /// Of the first, what bodies in lanes have, and what the others have at least (J).
    in_lanes: f64,
    others: f64,
    /// Whether the sweeps of this substep may have made it more.
    may_have_gained: bool,
}

/// What a quick look at a body's energy needs: mass (kg), and least and greatest moment of inertia (kg·m²); zero where it does
/// not move.
#[derive(Debug, Clone, Copy)]
struct InertiaBounds {
    mass: f32,
    least: f32,
    greatest: f32,
    in_lanes: bool,
}

impl InertiaBounds {
    fn of(velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        let ease = velocity.inverse_mass.max_element();
        if !motion.is_dynamic() || ease <= 0.0 {
            return Self { mass: 0.0, least: 0.0, greatest: 0.0, in_lanes: false };
        }
        let (least, greatest) = (motion.inertia.min_element(), motion.inertia.max_element());
        Self { mass: 1.0 / ease, least, greatest, in_lanes: motion.in_lanes }
    }

    /// Kinetic energy with this inertia about any axis (J).
    fn energy(&self, velocity: &BodyVelocity, inertia: f32) -> f64 {
        f64::from(0.5 * (self.mass * velocity.linear.length_squared() + inertia * velocity.angular.length_squared()))
    }
}

/// A kinematic body that moves, and that an island hangs on or touches.
#[derive(Debug, Clone, Copy)]
struct Carrier {
    /// Number of the island in the batch.
    island: u32,
    slot: u32,
    /// Where it was at the start of the step, from the first body of the island (m).
    place: DVec3,
}

/// A rigid motion: a point (m), its velocity (m/s), and the spin (rad/s).
#[derive(Debug, Clone, Copy)]
struct Screw {
    center: DVec3,
    linear: DVec3,
    angular: DVec3,
}

impl Screw {
    const NONE: Self = Self { center: DVec3::ZERO, linear: DVec3::ZERO, angular: DVec3::ZERO };

    /// Velocity at a place (m/s).
    fn at(&self, place: DVec3) -> DVec3 {
        self.linear + self.angular.cross(place - self.center)
    }
}

/// The islands of a batch whose energy is watched.
#[derive(Debug, Default)]
pub(crate) struct ContactEnergy {
    islands: Vec<SweptIsland>,
    carriers: Vec<Carrier>,
    /// Where each slot's body was at the start of the step, from the first of its island (m); for islands with carriers.
    places: Vec<DVec3>,
    /// Number of the island in the batch of each slot, and whether each of those is watched.
    owner: Vec<u32>,
    watched: Vec<bool>,
    /// By slot, of islands that are watched.
    weights: Vec<InertiaBounds>,
    /// Velocities of all slots before the sweeps.
    before: Vec<BodyVelocity>,
    cold_solve: ColdSolve,
}

/// What bodies of a batch are, to sum up over.
struct BodyView<'a> {
    velocities: &'a [BodyVelocity],
    motions: &'a [BodyMotion],
    places: &'a [DVec3],
}

impl BodyView<'_> {
    fn place(&self, slot: usize) -> DVec3 {
        self.places[slot] + self.motions[slot].displacement.as_dvec3()
    }

    fn of<'a>(&'a self, island: &SweptIsland) -> impl Iterator<Item = usize> + 'a {
        island.slots().filter(|&slot| self.motions[slot].is_dynamic())
    }

    /// Kinetic energy of a body at this velocity (J).
    fn energy_at(&self, slot: usize, linear: DVec3, angular: DVec3) -> f64 {
        let motion = &self.motions[slot];
        let inverse_mass = self.velocities[slot].inverse_mass.as_dvec3();
        let moved = DVec3::select(inverse_mass.cmpgt(DVec3::ZERO), linear * linear / inverse_mass, DVec3::ZERO);
        let spin = (motion.rotation * motion.inertia_frame).as_dquat().normalize().conjugate() * angular;
        0.5 * (moved.element_sum() + (spin * spin).dot(motion.inertia.as_dvec3()))
    }

    /// Kinetic energy of a body (J).
    fn energy_of(&self, slot: usize) -> f64 {
        let velocity = &self.velocities[slot];
        self.energy_at(slot, velocity.linear.as_dvec3(), velocity.angular.as_dvec3())
    }

    /// Kinetic energy of an island against a motion (J).
    fn energy_against(&self, island: &SweptIsland, frame: Screw) -> f64 {
        let of = |slot: usize| {
            let velocity = &self.velocities[slot];
            let linear = velocity.linear.as_dvec3() - frame.at(self.place(slot));
            self.energy_at(slot, linear, velocity.angular.as_dvec3() - frame.angular)
        };
        self.of(island).map(of).sum()
    }

    /// Kinetic energy that an island would have if it moved with this (J).
    fn energy_with(&self, island: &SweptIsland, with: Screw) -> f64 {
        self.of(island).map(|slot| self.energy_at(slot, with.at(self.place(slot)), with.angular)).sum()
    }

    /// Motion of a carrier.
    fn screw(&self, carrier: &Carrier) -> Screw {
        let (velocity, motion) = (&self.velocities[carrier.slot as usize], &self.motions[carrier.slot as usize]);
        let center = carrier.place + motion.displacement.as_dvec3();
        Screw { center, linear: velocity.linear.as_dvec3(), angular: velocity.angular.as_dvec3() }
    }

    /// The motion against which the energy of an island is what rows take from: that of its only carrier, or none at all.
    fn frame_of(&self, island: &SweptIsland, carriers: &[Carrier]) -> Option<Screw> {
        match &carriers[island.carriers.0 as usize..island.carriers.1 as usize] {
            [only] if !island.touches_still => Some(self.screw(only)),
            _ => None,
        }
    }
}

impl SweptIsland {
    fn new(first: u32, end: u32) -> Self {
        Self {
            first,
            end,
            touches_still: false,
            carriers: (0, 0),
            has_swept_joints: false,
            has_drives: false,
            allowed: 0.0,
            after: 0.0,
            work: 0.0,
            pulled: 0.0,
            in_lanes: 0.0,
            others: 0.0,
            may_have_gained: false,
        }
    }

    fn slots(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }

    /// Kinetic energy that it may have after the sweeps (J).
    fn most(&self) -> f64 {
        self.allowed + self.work.max(0.0)
    }

    fn is_to_be_solved_afresh(&self) -> bool {
        // What is no number is not.
        let is_pulled = self.after <= self.pulled;
        !self.has_swept_joints && self.exceeds(AFRESH) && !is_pulled
    }

    fn is_torn(&self) -> bool {
        self.exceeds(TORN)
    }

    /// Whether it has more than `times` that, or what is no number.
    fn exceeds(&self, times: f64) -> bool {
        self.may_have_gained && (self.after > times * self.most() || !(self.after + self.work).is_finite())
    }
}

impl ContactEnergy {
    /// Leaves out what is watched as passive, and gets ready for the substeps of the others.
    pub(crate) fn lay_out(&mut self, joint_energy: &JointEnergy, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        let Self { islands, weights, .. } = self;
        islands.retain(|island| !joint_energy.firsts().any(|first| first == island.first));
        if !islands.is_empty() {
            weights.clear();
            weights.extend(velocities.iter().zip(motions).map(|(velocity, motion)| InertiaBounds::of(velocity, motion)));
        }
    }

    /// Notes the energy that the islands have, or with carriers how much they may have but for what drives them: forces of a substep of length `h`
    /// (s) have been added.
    pub(crate) fn note_energy(&mut self, velocities: &[BodyVelocity], motions: &[BodyMotion], poses: &WideBodies, h: f32) {
        let Self { islands, carriers, places, weights, .. } = self;
        let bodies = BodyView { velocities, motions, places };
        for island in islands {
            let pulled = |slot: usize| f64::from(0.5 * weights[slot].mass * (motions[slot].acceleration * h).length_squared());
            island.pulled = island.slots().map(pulled).sum();
            let own = &carriers[island.carriers.0 as usize..island.carriers.1 as usize];
            if let Some(frame) = bodies.frame_of(island, carriers) {
                island.allowed = bodies.energy_against(island, frame);
                continue;
            }
            if !own.is_empty() {
                let carried = own.iter().map(|carrier| bodies.energy_with(island, bodies.screw(carrier)).sqrt()).sum::<f64>();
                island.allowed = (bodies.energy_against(island, Screw::NONE).sqrt() + 2.0 * carried).powi(2);
                continue;
            }
            (island.in_lanes, island.others) = (0.0, 0.0);
            for slot in island.slots() {
                let weight = &weights[slot];
                if weight.in_lanes {
                    island.in_lanes += f64::from(poses.energies[slot]);
                } else {
                    island.others += weight.energy(&velocities[slot], weight.least);
                }
            }
        }
    }

    /// Notes the velocities that the sweeps begin with.
    pub(crate) fn note_velocities(&mut self, velocities: &[BodyVelocity]) {
        if !self.islands.is_empty() {
            self.before.clear();
            self.before.extend_from_slice(velocities);
        }
    }

    /// Marks the islands that may have gained energy, by bounds that need no inertia tensor: greatest energy now against least before. Returns
    /// whether there are any; most islands have lost far more than the bounds are apart.
    fn look(&mut self, velocities: &[BodyVelocity]) -> bool {
        let mut any = false;
        for island in &mut self.islands {
            island.may_have_gained = island.carriers.0 < island.carriers.1 || {
                let most = |slot: usize| self.weights[slot].energy(&velocities[slot], self.weights[slot].greatest);
                let most = island.slots().map(most).sum::<f64>();
                most > island.in_lanes + island.others + island.work.max(0.0) || most.is_nan()
            };
            any |= island.may_have_gained;
        }
        any
    }

    /// Finds the energy of islands that may have gained some, and how much they may have.
    fn weigh(&mut self, threads: &Workers, velocities: &[BodyVelocity], motions: &[BodyMotion], poses: &mut WideBodies) {
        let Self { islands, carriers, places, before, .. } = self;
        poses.find_energies(threads, velocities, motions);
        let now = BodyView { velocities, motions, places };
        let then = BodyView { velocities: before, motions, places };
        for island in islands.iter_mut().filter(|island| island.may_have_gained) {
            if island.carriers.0 < island.carriers.1 {
                island.after = now.energy_against(island, now.frame_of(island, carriers).unwrap_or(Screw::NONE));
                continue;
            }
            let others = || now.of(island).filter(|&slot| !motions[slot].in_lanes);
            let in_lanes = now.of(island).filter(|&slot| motions[slot].in_lanes);
            let after = in_lanes.map(|slot| f64::from(poses.energies[slot])).sum::<f64>();
            let (before, after) = (
                others().map(|slot| then.energy_of(slot)).sum::<f64>(),
                after + others().map(|slot| now.energy_of(slot)).sum::<f64>(),
            );
            (island.allowed, island.after) = (island.in_lanes + before, after);
        }
    }

    /// Solves the substep once more for islands that the sweeps have given energy, without what was carried, and slows those that
    /// have been given some even then.
    pub(crate) fn dissipate(&mut self, batch: &mut Batch, threads: &Workers, iterations: u32, smeared: &SmearedSpins) {
        if self.islands.is_empty() {
            return;
        }
        self.find_work(batch);
        if !self.look(&batch.velocities) {
            return;
        }
        self.weigh(threads, &batch.velocities, &batch.motions, &mut batch.poses);
        if self.islands.iter().any(SweptIsland::is_to_be_solved_afresh) {
            self.solve_afresh(batch, iterations, smeared);
            self.find_work(batch);
            self.weigh(threads, &batch.velocities, &batch.motions, &mut batch.poses);
        }
        self.give_up_what_is_torn(batch);
        let Self { islands, carriers, places, before, .. } = self;
        let Batch { velocities, motions, poses, free, .. } = batch;
        if islands.iter().any(SweptIsland::is_torn) {
            put_back_unmoved(velocities, motions, before);
        }
        for island in islands.iter().filter(|island| island.exceeds(1.0 + LET_BE)) {
            if island.is_torn() {
                velocities[island.slots()].copy_from_slice(&before[island.slots()]);
                continue;
            }
            let kept = |from: f64, to: f64| (from / to).sqrt();
            if free.slow(island.first, (island.most(), island.after), kept, velocities, motions, poses) {
                continue;
            }
            let bodies = BodyView { velocities, motions, places };
            let frame = bodies.frame_of(island, carriers).unwrap_or(Screw::NONE);
            let kept = kept(island.most(), island.after);
            for slot in island.slots().filter(|&slot| motions[slot].is_dynamic()) {
                let with = frame.at(places.get(slot).copied().unwrap_or_default() + motions[slot].displacement.as_dvec3());
                let velocity = &mut velocities[slot];
                velocity.linear = with.lerp(velocity.linear.as_dvec3(), kept).as_vec3();
                velocity.angular = frame.angular.lerp(velocity.angular.as_dvec3(), kept).as_vec3();
            }
        }
    }

    /// Forgets all multipliers of islands that sweeps joint by joint have torn.
    fn give_up_what_is_torn(&mut self, batch: &mut Batch) {
        let Self { islands, cold_solve, .. } = self;
        let Batch { velocities, contacts, direct, .. } = batch;
        if !islands.iter().any(SweptIsland::is_torn) {
            return;
        }
        cold_solve.choose(islands.iter().filter(|island| island.is_torn()).map(SweptIsland::slots), velocities.len());
        let slots = cold_solve.slots();
        for number in 0..contacts.len() {
            let mut whole = contacts.whole(number);
            let torn = cold_solve.lanes(whole.block);
            whole.multipliers().for_each(|lambda| (0..LANES).filter(|&l| torn[l]).for_each(|l| lambda[l] = 0.0));
        }
        direct.drop_impulses(slots);
        batch.joints.give_up(slots);
        batch.long_range.bounds.give_up(slots);
        batch.long_range.taut.give_up(slots);
        batch.long_range.wraps.give_up(slots);
    }

    /// Finds what motors and springs have done in the substep.
    fn find_work(&mut self, batch: &Batch) {
        let Self { islands, .. } = self;
        if !islands.iter().any(|island| island.has_drives) {
            return;
        }
        islands.iter_mut().for_each(|island| island.work = 0.0);
        let mut hand_over = |slots: [u32; 2], work: f64| {
            let has = |island: &SweptIsland| slots.iter().any(|&slot| island.slots().contains(&(slot as usize)));
            if let Some(island) = islands.iter_mut().find(|island| has(island)) {
                island.work += work;
            }
        };
        batch.direct.find_work(&mut hand_over);
        batch.joints.find_work(&batch.velocities, hand_over);
    }
}
