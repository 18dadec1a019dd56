//! Gathers the contacts of a batch that take part in an impact, and writes them back.

use std::ops::Range;

use glam::{DMat3, DQuat, DVec2, DVec3, Quat, Vec3};

use super::super::batch::Batch;
use super::super::contact::{LANES, POINTS, tangents};
use super::super::contact_block::ContactBlocks;
use super::super::integrate::limit_speeds;
use super::super::smeared_spins::SmearedSpins;
use super::super::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};
use super::{Impact, ImpactBody, ImpactManifold, ImpactPoint};
use crate::linalg::held_axes::held;
use crate::tight_vec::resize;
use crate::tuning::needles::FAR_SHARE;

/// Share of a spin's energy that is rounding.
const ROUNDING: f64 = 1.0e-5;

/// What is no body of the impact at hand.
const NOBODY: u32 = u32::MAX;

/// Impacts of the islands of a batch, and buffers.
#[derive(Debug, Default)]
pub(crate) struct Impacts {
    /// Whether any contact of the step can rebound.
    may_happen: bool,
    /// Velocities from before anything acted on them in the substep but forces.
    before: Vec<BodyVelocity>,
    /// Multipliers along normals that the substep began with, of each block.
    warm: Vec<[[f32; LANES]; POINTS]>,
    /// Islands in which something has hit.
    struck: Vec<u32>,
    /// Manifolds of those: island, number, and place.
    members: Vec<(u32, u32, u32, u32)>,
    impact: Impact,
    /// Body of each slot, and slot of each body.
    number: Vec<u32>,
    slots: Vec<u32>,
    /// Bodies that get other velocities once poses have moved, and the islands that they are of.
    struck_bodies: Vec<StruckBody>,
    after: Vec<AfterImpact>,
    /// Block, lane and multipliers that are carried on, of manifolds that were pressed with more in the impact.
    carried: Vec<(u32, u32, [f32; POINTS], f32)>,
}

impl Impacts {
    /// Begins a step.
    pub(crate) fn prepare(&mut self, contacts: &ContactBlocks) {
        self.may_happen = contacts.extras.iter().any(|extra| extra.has_restitution);
        self.struck.clear();
        self.struck_bodies.clear();
        self.after.clear();
        self.carried.clear();
    }

    /// Whether something has hit in this substep in the island of a slot; `islands` are the first slots of all.
    pub(crate) fn has_struck(&self, islands: &[u32], slot: u32) -> bool {
        !self.struck.is_empty()
            && islands
                .partition_point(|&first| first <= slot)
                .checked_sub(1)
                .is_some_and(|island| self.struck.binary_search(&(island as u32)).is_ok())
    }

    /// Keeps the velocities that contacts hit with in this substep, and the multipliers that they begin it with.
    pub(crate) fn note(&mut self, velocities: &[BodyVelocity], contacts: &ContactBlocks) {
        if self.may_happen {
            self.before.clear();
            self.before.extend_from_slice(velocities);
            self.warm.clear();
            self.warm.extend((0..contacts.blocks.len()).map(|block| {
                let room = contacts.room_of(block);
                std::array::from_fn(|i| if i < room { contacts.rows(block, i).lambda } else { [0.0; LANES] })
            }));
        }
    }

    /// Number of the body of a slot in the impact at hand.
    fn body(&mut self, slot: u32, motions: &[BodyMotion]) -> u32 {
        let number = &mut self.number[slot as usize];
        if *number == NOBODY {
            *number = self.slots.len() as u32;
            self.slots.push(slot);
            self.impact.bodies.push(ImpactBody::of(&self.before[slot as usize], &motions[slot as usize]));
        }
        *number
    }

    /// Takes a manifold into the impact at hand: those of its points that press or touch.
    fn take(&mut self, (contacts, motions): (&ContactBlocks, &[BodyMotion]), smeared: &SmearedSpins, block: usize, lane: usize) {
        let from = &contacts.blocks[block];
        let (a, b) = (self.body(from.a[lane], motions), self.body(from.b[lane], motions));
        let extra = contacts.extras.get(from.extra as usize);
        let first = self.impact.points.len();
        let normal = from.normal_of(lane);
        let hidden = [from.a[lane], from.b[lane]].map(|slot| smeared.hidden(slot));
        for i in 0..usize::from(from.count[lane]) {
            let rows = contacts.rows(block, i);
            let (lever_a, lever_b) = rows.levers_of(lane);
            // What neither presses nor touches keeps its place and takes no part.
            let takes_part = rows.inverse_diagonal[lane] > 0.0 && (rows.lambda[lane] > 0.0 || rows.closing_speed[lane] <= 0.0);
            let (lever_a, lever_b) = (lever_a.as_dvec3(), lever_b.as_dvec3());
            let speed = extra.map_or(0.0, |extra| f64::from(extra.impact_speed[i][lane]));
            let unseen = normal.as_dvec3().dot(hidden[1].cross(lever_b) - hidden[0].cross(lever_a));
            self.impact.points.push(ImpactPoint {
                lever_a,
                lever_b,
                impact_speed: if speed < 0.0 { speed + unseen } else { speed },
                lambda: f64::from(rows.lambda[lane]),
                takes_part,
                ..ImpactPoint::default()
            });
        }
        let (t1, t2) = tangents(normal);
        let (center_a, center_b) = contacts.centers_of(block, lane);
        let twist = contacts.twist_of(block);
        self.impact.manifolds.push(ImpactManifold {
            a,
            b,
            normal: normal.as_dvec3(),
            tangents: [t1.as_dvec3(), t2.as_dvec3()],
            center_a: center_a.as_dvec3(),
            center_b: center_b.as_dvec3(),
            points: first..self.impact.points.len(),
            restitution: extra.map_or(0.0, |extra| f64::from(extra.restitution[lane])),
            friction: f64::from(from.friction[lane]),
            twist_arm: twist.map_or(0.0, |twist| f64::from(twist.arm[lane])),
            rolling_arm: extra.map_or(0.0, |extra| f64::from(extra.rolling_arm[lane])),
            slide: DVec2::new(f64::from(from.tangent_lambda[0][lane]), f64::from(from.tangent_lambda[1][lane])),
            twist: twist.map_or(0.0, |twist| f64::from(twist.lambda[lane])),
            roll: extra.map_or(DVec2::ZERO, |extra| {
                DVec2::new(f64::from(extra.rolling_lambda[0][lane]), f64::from(extra.rolling_lambda[1][lane]))
            }),
            ..ImpactManifold::default()
        });
    }

    /// Gives velocities and multipliers back.
    fn give_back(&mut self, batch: &mut Batch, members: Range<usize>, h: f32) {
        let Batch { contacts, velocities, motions, .. } = batch;
        let (mut energy, mut most, mut is_driven) = (0.0, 0.0, false);
        for (&slot, body) in self.slots.iter().zip(&self.impact.bodies) {
            self.number[slot as usize] = NOBODY;
            let (now, motion) = (&velocities[slot as usize], &motions[slot as usize]);
            if !motion.is_dynamic() {
                is_driven |= now.linear != Vec3::ZERO || now.angular != Vec3::ZERO;
                continue;
            }
            energy += kinetic_energy(body.inverse_mass, motion, body.linear, body.angular);
            most += energy_with_forces(&self.before[slot as usize], now, motion, h);
            let added = [body.linear - now.linear.as_dvec3(), body.angular - now.angular.as_dvec3()];
            let spin = kinetic_energy(DVec3::ZERO, motion, DVec3::ZERO, body.angular);
            self.struck_bodies.push(StruckBody { slot, added, rotation: motion.rotation, spin });
        }
        self.after.push(AfterImpact { end: self.struck_bodies.len(), energy: (!is_driven).then_some(f64::min(energy, most)) });
        for (manifold, &(.., block, lane)) in self.impact.manifolds.iter().zip(&self.members[members]) {
            let (number, l) = (block as usize, lane as usize);
            let points = &self.impact.points[manifold.points.clone()];
            let [load, blow] =
                [0, 1].map(|part| -> f64 { points.iter().map(|point| if part == 0 { point.lambda } else { point.blow }).sum() });
            let mut carried = [0.0; POINTS];
            for (i, point) in points.iter().enumerate() {
                contacts.rows_mut(number, i).lambda[l] = (point.lambda + point.blow) as f32;
                // What stops the rest of a blow is no load.
                carried[i] = (point.lambda as f32).min(self.warm[number][i][l]);
            }
            let block_of = &mut contacts.blocks[number];
            block_of.tangent_lambda[0][l] = manifold.slide.x as f32;
            block_of.tangent_lambda[1][l] = manifold.slide.y as f32;
            let extra = block_of.extra as usize;
            if let Some(twist) = contacts.twist_mut(number) {
                twist.lambda[l] = manifold.twist as f32;
            }
            if let Some(extra) = contacts.extras.get_mut(extra) {
                extra.rolling_lambda[0][l] = manifold.roll.x as f32;
                extra.rolling_lambda[1][l] = manifold.roll.y as f32;
                // It is over for the substep: nothing is left to rebound by itself.
                extra.impact_speed.iter_mut().for_each(|lanes| lanes[l] = 0.0);
                if manifold.was_hit && extra.restitution[l] > 0.0 {
                    extra.rebounds[l] = true;
                    extra.blow[l] = (load + blow) as f32;
                }
            }
            if blow > 0.0 {
                let share = f64::from(carried.iter().sum::<f32>()) / (load + blow);
                self.carried.push((block, lane, carried, share as f32));
            }
        }
    }

    /// Finds what impacts of this substep of length `h` (s) make of velocities. Poses move by those of now: what has hit is then where it hit.
    pub(crate) fn find(&mut self, batch: &mut Batch, smeared: &SmearedSpins, threshold: f32, h: f32) {
        if !self.may_happen {
            return;
        }
        self.list_struck(batch, threshold);
        if self.struck.is_empty() {
            return;
        }
        resize(&mut self.number, batch.velocities.len(), NOBODY);
        self.list_members(batch);
        let mut first = 0;
        while first < self.members.len() {
            let island = self.members[first].0;
            let count = self.members[first..].iter().take_while(|member| member.0 == island).count();
            self.impact.clear();
            self.slots.clear();
            for place in first..first + count {
                let (.., block, lane) = self.members[place];
                self.take((&batch.contacts, &batch.motions), smeared, block as usize, lane as usize);
            }
            self.impact.solve(f64::from(threshold));
            self.give_back(batch, first..first + count, h);
            first += count;
        }
    }

    /// Gives bodies what impacts have made of their velocities.
    ///
    /// What is free keeps the angular momentum that it has then. Its bodies have moved on since the levers were formed, so a blow along one line
    /// is along two; were that made up for by a rotation of all, balls without friction would spin, and elastic ones gain energy.
    pub(crate) fn apply(&mut self, batch: &mut Batch) {
        let mut first = 0;
        for after in self.after.drain(..) {
            after.apply(&self.struck_bodies[first..after.end], &mut batch.velocities, &batch.motions);
            first = after.end;
        }
        self.struck_bodies.clear();
        if !self.struck.is_empty() && !batch.free.is_empty() {
            let Batch { free, velocities, motions, poses, islands, .. } = batch;
            free.note(velocities, motions, poses, |slot| self.has_struck(islands, slot));
        }
    }

    /// Ends the substep of impacts: multipliers of blows are nothing to carry on.
    pub(crate) fn forget(&mut self, contacts: &mut ContactBlocks) {
        for (block, lane, normals, share) in self.carried.drain(..) {
            let (number, l) = (block as usize, lane as usize);
            let mut whole = contacts.whole(number);
            whole.multipliers().for_each(|lambda| lambda[l] *= share);
            for (i, normal) in normals.into_iter().enumerate().take(contacts.room_of(number)) {
                contacts.rows_mut(number, i).lambda[l] = normal;
            }
        }
    }

    fn list_struck(&mut self, batch: &Batch, threshold: f32) {
        let Batch { contacts, .. } = batch;
        self.struck.clear();
        for number in 0..batch.manifolds.ends.len() {
            let Some((block, lane)) = batch.place_of(number) else { continue };
            let (block, lane) = (block as usize, lane as usize);
            let Some(extra) = contacts.extras.get(contacts.blocks[block].extra as usize) else { continue };
            let hits = |i: usize| extra.impact_speed[i][lane] < -threshold && contacts.rows(block, i).lambda[lane] > 0.0;
            if extra.has_restitution && (0..contacts.room_of(block)).any(hits) {
                self.struck.extend(island_of(batch, number));
            }
        }
        self.struck.sort_unstable();
        self.struck.dedup();
        let next = |island: u32| batch.islands.get(island as usize + 1).map_or(batch.moving() + 1, |&next| next as usize);
        let is_free = |island: &u32| {
            let slots = batch.islands[*island as usize] as usize..next(*island);
            batch.motions[slots].iter().all(|motion| !motion.jointed && !motion.direct)
        };
        self.struck.retain(is_free);
    }

    fn list_members(&mut self, batch: &Batch) {
        self.members.clear();
        for number in 0..batch.manifolds.ends.len() {
            let Some((block, lane)) = batch.place_of(number) else { continue };
            if let Some(island) = island_of(batch, number).filter(|island| self.struck.binary_search(island).is_ok()) {
                self.members.push((island, number as u32, block, lane));
            }
        }
        self.members.sort_unstable();
    }
}

/// Island of a manifold; none where joints hold anything in it, whose rows the law does not have.
fn island_of(batch: &Batch, number: usize) -> Option<u32> {
    let ends = &batch.manifolds.ends[number];
    let slot = [ends.a, ends.b].into_iter().find(|&slot| batch.body_flags[slot as usize].moves())?;
    batch.islands.partition_point(|&first| first <= slot).checked_sub(1).map(|island| island as u32)
}

/// What an impact adds to a body's velocity.
#[derive(Debug, Clone, Copy)]
struct StruckBody {
    slot: u32,
    /// Linear and angular.
    added: [DVec3; 2],
    /// How it was turned when it was hit, and its energy of spin right after (J).
    rotation: Quat,
    spin: f64,
}

impl StruckBody {
    /// What is added, once the body has moved on: as it was found, or gone along with the body's lightest axis the shortest way (`swung`), without what
    /// it has turned about that. What spins a needle about its length stays such a spin then, and what turns it over turns it over where the body
    /// would have gone on to turn: without a torque the spin across a needle keeps its direction in the world, and the one along it goes with it.
    fn added_to(&self, motion: &BodyMotion, swung: bool) -> [DVec3; 2] {
        let [linear, angular] = self.added;
        if !swung {
            return self.added;
        }
        let lightest = motion.inertia.as_dvec3().to_array().into_iter().zip(DVec3::AXES).min_by(|a, b| a.0.total_cmp(&b.0));
        let axis = motion.inertia_frame.as_dquat().normalize() * lightest.map_or(DVec3::Y, |(_, axis)| axis);
        let [before, now] = [self.rotation, motion.rotation].map(|rotation| rotation.as_dquat().normalize() * axis);
        [linear, DQuat::from_rotation_arc(before.normalize(), now.normalize()) * angular]
    }

    /// The angular velocity with what was added, for a body that turns fast.
    ///
    /// A change of spin about the axis of a needle is after a turn also one across it, where the needle is up to a million times heavier, and a
    /// heap of them gains energy without end. Where as it stands the change would make energy, it turns with the body.
    fn without_gain(&self, before: DVec3, motion: &BodyMotion) -> DVec3 {
        let added = self.added[1];
        let energy = |angular: DVec3| kinetic_energy(DVec3::ZERO, motion, DVec3::ZERO, angular);
        let most = self.spin * (1.0 + ROUNDING);
        if motion.kind != MotionKind::Tumbling || energy(before + added) <= most {
            return before + added;
        }
        let turned = before + (motion.rotation * self.rotation.conjugate()).as_dquat().normalize() * added;
        turned * (most / energy(turned).max(most)).sqrt()
    }
}

/// What an impact has left of an island.
#[derive(Debug, Clone, Copy)]
struct AfterImpact {
    /// One past its last body.
    end: usize,
    /// Its kinetic energy (J); none where the host moves what was hit, whose work is in it.
    energy: Option<f64>,
}

impl AfterImpact {
    /// Gives bodies that have moved on since the velocities that an impact has left them with.
    ///
    /// Meanwhile they have turned, and where moments of inertia differ, what is added makes another energy of what they are now. So all of it is
    /// taken to the share at which the energy is what the impact has left: what pushes two bodies still pushes both alike. Where that is far from
    /// all of it, a body turns too fast for that, and loses what it may.
    fn apply(&self, bodies: &[StruckBody], velocities: &mut [BodyVelocity], motions: &[BodyMotion]) {
        let found = [false, true].into_iter().find_map(|swung| Some((swung, self.share(bodies, velocities, motions, swung)?)));
        for body in bodies {
            let (velocity, motion) = (&mut velocities[body.slot as usize], &motions[body.slot as usize]);
            let (swung, share) = found.unwrap_or((false, 1.0));
            let [linear, angular] = body.added_to(motion, swung).map(|added| added * share);
            let before = velocity.angular.as_dvec3();
            velocity.linear = (velocity.linear.as_dvec3() + linear).as_vec3();
            velocity.angular = match found {
                Some(_) => before + angular,
                None => body.without_gain(before, motion),
            }
            .as_vec3();
            limit_speeds(velocity, motion);
        }
    }

    /// The share s at which E₀ + s E₁ + s² E₂ is the energy that was left, of two that nearer to 1; none if there is none, a far one, or
    /// the host has a part in that energy.
    fn share(&self, bodies: &[StruckBody], velocities: &[BodyVelocity], motions: &[BodyMotion], swung: bool) -> Option<f64> {
        let left = self.energy?;
        let mut powers = [0.0; 3];
        for body in bodies {
            let (velocity, motion) = (&velocities[body.slot as usize], &motions[body.slot as usize]);
            let of = |linear: DVec3, angular: DVec3| kinetic_energy(velocity.inverse_mass.as_dvec3(), motion, linear, angular);
            let (linear, angular) = (velocity.linear.as_dvec3(), velocity.angular.as_dvec3());
            let [along, about] = body.added_to(motion, swung);
            let (before, own) = (of(linear, angular), of(along, about));
            powers[0] += before;
            powers[1] += of(linear + along, angular + about) - before - own;
            powers[2] += own;
        }
        let [before, slope, curvature] = powers;
        if curvature <= 0.0 {
            return Some(1.0);
        }
        let (middle, square) = (-0.5 * slope / curvature, (left - before) / curvature);
        let half = (middle * middle + square).sqrt();
        let share = if middle < 1.0 { middle + half } else { middle - half };
        (FAR_SHARE..1.0 / FAR_SHARE).contains(&share).then_some(share)
    }
}

/// Most kinetic energy that a hit may leave a body which has come to a substep with the forces of all of it in its velocity `before`, and goes through it at
/// `now`: what it had before those forces, and their work on the way that it goes (J).
///
/// What is stopped on its way does not fall as far as gravity has been added for. The speeds that points hit at know of that, but not where a body
/// turns on after them: a stick of 1:80 went up again with 5 % more energy than it had come down with.
fn energy_with_forces(before: &BodyVelocity, now: &BodyVelocity, motion: &BodyMotion, h: f32) -> f64 {
    let (inverse_mass, gained) = (before.inverse_mass.as_dvec3(), (motion.acceleration * h).as_dvec3());
    let linear = before.linear.as_dvec3();
    let work = gained * (now.linear.as_dvec3() - linear + 0.5 * gained);
    let moved = DVec3::select(inverse_mass.cmpgt(DVec3::ZERO), work / inverse_mass, DVec3::ZERO);
    kinetic_energy(inverse_mass, motion, linear, before.angular.as_dvec3()) + moved.element_sum()
}

/// Kinetic energy of a body at a velocity (J).
fn kinetic_energy(inverse_mass: DVec3, motion: &BodyMotion, linear: DVec3, angular: DVec3) -> f64 {
    let moved = DVec3::select(inverse_mass.cmpgt(DVec3::ZERO), linear * linear / inverse_mass, DVec3::ZERO);
    let spin = (motion.rotation * motion.inertia_frame).as_dquat().normalize().conjugate() * angular;
    0.5 * (moved.element_sum() + (spin * spin).dot(motion.inertia.as_dvec3()))
}

impl ImpactBody {
    /// A blow lasts no time: a body answers to it with the inertia that it has at that moment, not with what its axes are smeared to by the turn
    /// of a substep, with which sweeps work. By any other the law would keep the energy of another body.
    fn of(velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        let inverse_inertia = match motion.kind {
            MotionKind::Tumbling => {
                let axes = DMat3::from_quat((motion.rotation * motion.inertia_frame).as_dquat().normalize());
                let answer = axes * DMat3::from_diagonal(motion.inertia.as_dvec3().recip()) * axes.transpose();
                held(answer, motion.free_rotation().as_dvec3())
            }
            _ => Symmetric::to_mat3(velocity.inverse_inertia).as_dmat3(),
        };
        Self {
            linear: velocity.linear.as_dvec3(),
            angular: velocity.angular.as_dvec3(),
            inverse_mass: velocity.inverse_mass.as_dvec3(),
            inverse_inertia,
        }
    }
}
