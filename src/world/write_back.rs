//! Stages after the solve: write results into the world's records, stop fast bodies, list events.

use std::ops::Range;

use glam::Vec3;

use super::World;
use super::body_shape_table::BodyShapeTable;
use super::pairs::contact_pair;
use super::support::PairView;
use crate::body::{Body, BodyKind};
use crate::collide::collider::Collider;
use crate::collide::pairs::Pair;
use crate::id::{BodyId, Pool, ShapeId};
use crate::linalg::rotation32;
use crate::prefetch::{AHEAD, prefetch};
use crate::report::{Events, IslandReport};
use crate::solve::contact::TOUCHED;
use crate::solve::disjoint::{DisjointSlices, Slots};

pub(super) mod bodies;
pub(super) mod joints;
mod moved;

/// Pairs that are reported before those of them that touch are judged: few enough to be still in the cache, and enough for reads of
/// pairs to overlap, which they do not from one judgement to the next.
const REPORTED_AT_ONCE: usize = 64;

/// Manifolds of a batch from which on their multipliers are written back by all threads, and those that are worth another thread's while.
const SHARED_MANIFOLDS: usize = 1024;
const MIN_MANIFOLDS: usize = 128;

/// Force of a manifold on the second of two bodies (N), and whether its pair presses that did not, or no longer does.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pull {
    bodies: [u32; 2],
    force: Vec3,
    has_changed: bool,
}

impl World {
    /// Writes poses, velocities and multipliers back.
    pub(super) fn store_results(&mut self, dt: f32) {
        let substep = dt / self.def.substeps as f32;
        self.scale_held(self.impulse_scale(substep));
        (self.last_substep, self.last_dt) = (substep, dt);
        self.note_starts();
        self.scratch.changed.clear();
        self.has_smooth_bodies = false;
        for number in 0..self.batch_count {
            self.store_bodies(number, dt);
            self.store_contacts(number, dt);
            self.store_joints(number);
            let batch = &self.batches[number];
            let (report, residuals) = (&mut self.report.counts, &mut self.report.residuals);
            report.colors = report.colors.max(batch.color_count);
            report.planes_corrected += batch.planes.corrected;
            residuals.joint_gap = residuals.joint_gap.max(batch.joint_gap);
            residuals.penetration = residuals.penetration.max(batch.penetration);
            for articulation in batch.direct.articulations() {
                let Some(slot) = articulation.moved_slots().next() else { continue };
                let report = articulation.report(self.bodies.handle_of(batch.bodies[slot as usize]));
                residuals.joint_angle = residuals.joint_angle.max(report.angle);
                self.events.articulations.push(report);
            }
            for (slot, bodies, joints, plan, given_up) in batch.newton.plans() {
                let body = self.bodies.handle_of(batch.bodies[slot as usize]);
                self.events.islands.push(IslandReport { body, bodies, joints, plan, given_up });
            }
            for island in batch.newton.islands() {
                let body = self.bodies.handle_of(batch.bodies[island.slots.start as usize]);
                self.events.articulations.push(island.report(body, &self.joints));
            }
        }
        self.keep_contact_forces();
        self.report_union_overloads();
        self.store_bounds(dt);
        for index in std::mem::take(&mut self.broken) {
            self.quarantine(index);
        }
        self.finish_kinematic_bodies(dt);
        self.carry_anchored();
        self.report.counts.bodies_asleep = self.sleeping.body_count() as u32;
        self.report.residuals.joint_gap = self.report.residuals.joint_gap.max(self.sleeping.worst_gap());
    }

    fn store_contacts(&mut self, number: usize, dt: f32) {
        self.store_blows(number);
        let substep = dt / self.def.substeps as f32;
        let Self { batches, pairs, index, support, scratch, threads, .. } = self;
        let is_judged = support.as_ref().is_some_and(|support| support.is_awake());
        let batch = &batches[number];
        let share = 1.0 / batch.stride;
        // Keeps the multipliers of a manifold, and returns its force on the second shape.
        let store = |i: usize, pair: &mut Pair, index: &BodyShapeTable| {
            let mut impulses = batch.contact_impulses(i).scaled(share);
            let manifold = batch.manifolds[i].1 as usize;
            let pressed = impulses.normal.iter().sum::<f32>();
            let rebound = if pressed > 0.0 { 0.0 } else { batch.contact_rebound(i) };
            if rebound > 0.0 {
                impulses.normal[0] = TOUCHED;
            }
            if !impulses.normal.iter().sum::<f32>().is_finite() || !impulses.friction.is_finite() {
                pair.forget_impulses();
                return Vec3::ZERO;
            }
            if is_judged {
                let key = pair.key;
                pair.store_told(manifold, impulses, batch.contact_told(i), || index.least_extent(key));
            } else {
                pair.store(manifold, impulses);
            }
            (batch.contact_normal(i) * (pressed + rebound) + impulses.friction) / substep
        };
        let pull = |i: usize, pair: &mut Pair, index: &BodyShapeTable| Pull {
            bodies: <[u32; 2]>::from(pair.key.shapes()).map(|shape| index.body_of(shape)),
            force: store(i, pair, index),
            has_changed: pair.pressed != pair.in_contact,
        };
        let changed = &mut scratch.changed;
        let mut note = |index: &mut BodyShapeTable, slot: u32, pull: &Pull| {
            index.add_contact(pull.bodies, pull.force);
            if pull.has_changed {
                changed.push(slot);
            }
        };
        if batch.manifolds.len() < SHARED_MANIFOLDS || !threads.has_team() {
            for (i, &(slot, _)) in batch.manifolds.iter().enumerate() {
                ask_for_next(&batch.manifolds[i..], &*pairs.slots_mut());
                batch.ask_for_contact(i + AHEAD);
                let pull = pull(i, pairs.get_mut(slot), index);
                note(index, slot, &pull);
            }
            return;
        }
        scratch.pulls.clear();
        scratch.pulls.resize(batch.manifolds.len(), Pull::default());
        let slots = DisjointSlices::new(pairs.slots_mut());
        let pieces = pieces_by_pair(&batch.manifolds, threads.piece(batch.manifolds.len(), MIN_MANIFOLDS));
        let mut rest = &mut scratch.pulls[..];
        let pieces = pieces.map(|range| (rest.split_off_mut(..range.len()).unwrap_or_default(), range));
        threads.share(pieces, |(pulls, range)| {
            // SAFETY: all manifolds of a pair are in one piece.
            let mut pairs = unsafe { slots.part() };
            for (place, i) in pulls.iter_mut().zip(range.clone()) {
                ask_for_next(&batch.manifolds[i..range.end], &pairs);
                batch.ask_for_contact(i + AHEAD);
                *place = pull(i, pairs.get_mut(batch.manifolds[i].0), index);
            }
        });
        scratch.pulls.iter().zip(&batch.manifolds).for_each(|(pull, &(slot, _))| note(index, slot, pull));
    }

    /// Adds what contacts have given to the hits under way.
    fn store_blows(&mut self, number: usize) {
        let Self { batches, pairs, .. } = self;
        if pairs.blows.is_empty() {
            return;
        }
        let batch = &batches[number];
        for (i, &(slot, _)) in batch.manifolds.iter().enumerate() {
            if let Some(blow) = pairs.blows.get_mut(slot) {
                let impulse = batch.contact_blow(i);
                blow.impulse += if impulse.is_finite() { impulse } else { 0.0 };
            }
        }
    }

    /// Takes a body out of the simulation where it last was, at rest, and says so.
    fn quarantine(&mut self, index: u32) {
        let body = &mut self.bodies[index];
        body.linear_velocity = Vec3::ZERO;
        body.angular_velocity = Vec3::ZERO;
        body.history.forget_lead();
        body.quarantined = true;
        self.topology_changed();
        self.long_range.graph_changed();
        self.welds_changed(index);
        self.events.quarantined.push(self.bodies.handle_of(index));
        self.forget_contacts_of(index);
        self.events.take_edits();
        self.movers_sorted = false;
    }

    /// Kinematic bodies end where they were told to be.
    fn finish_kinematic_bodies(&mut self, dt: f32) {
        if !self.some_are_driven {
            return;
        }
        for &index in &self.movers {
            let body = &mut self.bodies[index];
            if body.kind != BodyKind::Kinematic {
                continue;
            }
            if let Some(target) = body.target.take() {
                body.set_pose(target);
            } else {
                body.center += body.linear_velocity.as_dvec3() * f64::from(dt);
                let turn = body.angular_velocity * dt;
                body.rotation = rotation32::rotated_far(body.rotation, turn);
            }
            // It stops at the edge of the space that positions may be in.
            let edge = glam::DVec3::splat(crate::check::MAX_COORDINATE);
            let inside = body.center.clamp(-edge, edge);
            if inside != body.center {
                body.center = inside;
                body.linear_velocity = Vec3::ZERO;
            }
            for &id in &body.shapes {
                if let Ok(shape) = self.colliders.find(id) {
                    self.colliders[shape].follow(body);
                }
            }
        }
    }

    /// Lists pairs whose contact began or ended.
    pub(super) fn report_contacts(&mut self) {
        // What was quarantined has no pairs any more.
        self.pairs.settle();
        match self.support.is_some() {
            true => self.report_contacts_with_support(),
            false => self.report_touches(),
        }
    }

    fn report_contacts_with_support(&mut self) {
        let Self { pairs, colliders, bodies, events, support, hold, .. } = self;
        let Some(support) = support.as_deref_mut() else { return };
        let count = pairs.active().len();
        for first in (0..count).step_by(REPORTED_AT_ONCE) {
            for number in first..count.min(first + REPORTED_AT_ONCE) {
                let (key, slot) = pairs.active()[number];
                let pair = pairs.get_mut(slot);
                // Multipliers are those of a step ago.
                if pair.still && !hold.let_go {
                    continue;
                }
                if support.is_awake() {
                    support.note_touching((key, slot), pair, colliders);
                } else if pair.pressed && support.rests && !support.has_landed {
                    let site = PairView::new(pair, slot, colliders, bodies);
                    support.has_landed = site.is_on_base(support.frame.as_ref(), support.by_thrust);
                }
                report_contact(pair, colliders, bodies, events);
            }
            support.look_at_near(pairs, colliders, bodies);
        }
    }
}

/// Asks for the memory of the pairs of manifolds that come next, and of their multipliers.
#[inline(always)]
fn ask_for_next(coming: &[(u32, u32)], pairs: &(impl Slots<Pair> + ?Sized)) {
    if let Some(&(slot, _)) = coming.get(2 * AHEAD) {
        prefetch(pairs.get(slot));
    }
    if let Some(&(slot, _)) = coming.get(AHEAD) {
        pairs.get(slot).manifolds.prefetch_impulses();
    }
}

/// Says that the contact of a pair began or ended, if it has.
fn report_contact(pair: &mut Pair, colliders: &Pool<Collider, ShapeId>, bodies: &Pool<Body, BodyId>, events: &mut Events) {
    if pair.pressed != pair.in_contact {
        pair.in_contact = pair.pressed;
        let list = if pair.in_contact { &mut events.contact_began } else { &mut events.contact_ended };
        list.push(contact_pair(colliders, bodies, pair.key));
    }
}

/// Ranges of so many manifolds, and a few more where others of the same pair follow.
fn pieces_by_pair(manifolds: &[(u32, u32)], length: usize) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut next = 0;
    std::iter::from_fn(move || {
        let first = next;
        next = manifolds.len().min(first + length);
        while next < manifolds.len() && manifolds[next].0 == manifolds[next - 1].0 {
            next += 1;
        }
        (first < next).then_some(first..next)
    })
}
