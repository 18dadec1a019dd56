//! Gathers the contacts of a batch that take part in an impact, and writes them back.

use std::ops::Range;

use glam::{DMat3, DVec2, DVec3, Quat, Vec3};

use super::super::batch::Batch;
use super::super::contact::{LANES, POINTS, tangents};
use super::super::contact_block::ContactBlocks;
use super::super::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};
use super::{Impact, ImpactBody, ImpactManifold, ImpactPoint};
use crate::linalg::held_axes::held;
use crate::tight_vec::resize;

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
    /// What is added to velocities once poses have moved.
    changes: Vec<BodyChange>,
    /// Block, lane and multipliers that are carried on, of manifolds that were pressed with more in the impact.
    carried: Vec<(u32, u32, [f32; POINTS], f32)>,
}

impl Impacts {
    /// Begins a step.
    pub(crate) fn prepare(&mut self, contacts: &ContactBlocks) {
        self.may_happen = contacts.extras.iter().any(|extra| extra.has_restitution);
        self.struck.clear();
        self.changes.clear();
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
    fn take(&mut self, (contacts, motions): (&ContactBlocks, &[BodyMotion]), block: usize, lane: usize) {
        let from = &contacts.blocks[block];
        let (a, b) = (self.body(from.a[lane], motions), self.body(from.b[lane], motions));
        let extra = contacts.extras.get(from.extra as usize);
        let first = self.impact.points.len();
        for i in 0..usize::from(from.count[lane]) {
            let rows = contacts.rows(block, i);
            let (lever_a, lever_b) = rows.levers_of(lane);
            // What neither presses nor touches keeps its place and takes no part.
            let takes_part = rows.inverse_diagonal[lane] > 0.0 && (rows.lambda[lane] > 0.0 || rows.closing_speed[lane] <= 0.0);
            self.impact.points.push(ImpactPoint {
                lever_a: lever_a.as_dvec3(),
                lever_b: lever_b.as_dvec3(),
                impact_speed: extra.map_or(0.0, |extra| f64::from(extra.impact_speed[i][lane])),
                lambda: f64::from(rows.lambda[lane]),
                takes_part,
                ..ImpactPoint::default()
            });
        }
        let normal = from.normal_of(lane);
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
    fn give_back(&mut self, batch: &mut Batch, members: Range<usize>) {
        let Batch { contacts, velocities, motions, .. } = batch;
        for (&slot, body) in self.slots.iter().zip(&self.impact.bodies) {
            self.number[slot as usize] = NOBODY;
            let now = &velocities[slot as usize];
            let motion = &motions[slot as usize];
            self.changes.push(BodyChange {
                slot,
                linear: (body.linear - now.linear.as_dvec3()).as_vec3(),
                angular: (body.angular - now.angular.as_dvec3()).as_vec3(),
                rotation: motion.rotation,
                spin_energy: spin_energy(motion, body.angular),
            });
        }
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

    /// Finds what impacts of this substep make of velocities. Poses move by those of now: what has hit is then where it hit.
    pub(crate) fn find(&mut self, batch: &mut Batch, threshold: f32) {
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
                self.take((&batch.contacts, &batch.motions), block as usize, lane as usize);
            }
            self.impact.solve(f64::from(threshold));
            self.give_back(batch, first..first + count);
            first += count;
        }
    }

    /// Gives bodies what impacts have made of their velocities.
    ///
    /// What is free keeps the angular momentum that it has then. Its bodies have moved on since the levers were formed, so a blow along one line
    /// is along two; were that made up for by a rotation of all, balls without friction would spin, and elastic ones gain energy.
    pub(crate) fn apply(&mut self, batch: &mut Batch) {
        for change in self.changes.drain(..) {
            let slot = change.slot as usize;
            change.apply(&mut batch.velocities[slot], &batch.motions[slot]);
        }
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

/// What an impact changes of a body's velocity.
#[derive(Debug, Clone, Copy)]
struct BodyChange {
    slot: u32,
    linear: Vec3,
    angular: Vec3,
    /// How the body was turned when it was hit, and its energy of spin right after (J).
    rotation: Quat,
    spin_energy: f64,
}

impl BodyChange {
    /// Changes the velocity of a body that has moved on since.
    ///
    /// Meanwhile it has turned. A change of spin about the axis of a needle is then also one across it, where the needle is up to a million times
    /// heavier, and a heap of them gains energy without end. Where as it stands the change would make energy, it turns with the body.
    fn apply(&self, velocity: &mut BodyVelocity, motion: &BodyMotion) {
        velocity.linear += self.linear;
        let before = velocity.angular;
        velocity.angular += self.angular;
        if motion.kind != MotionKind::Tumbling {
            return;
        }
        let most = self.spin_energy * (1.0 + ROUNDING);
        if spin_energy(motion, velocity.angular.as_dvec3()) <= most {
            return;
        }
        velocity.angular = before + motion.rotation * (self.rotation.conjugate() * self.angular);
        let energy = spin_energy(motion, velocity.angular.as_dvec3());
        if energy > most {
            velocity.angular *= (most / energy).sqrt() as f32;
        }
    }
}

/// Energy of a body's spin (J); none of what has no inertia.
fn spin_energy(motion: &BodyMotion, angular: DVec3) -> f64 {
    if motion.kind != MotionKind::Tumbling {
        return 0.0;
    }
    let spin = (motion.rotation * motion.inertia_frame).as_dquat().normalize().conjugate() * angular;
    0.5 * (spin * spin).dot(motion.inertia.as_dvec3())
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
