//! Stages after the solve: write results into the world's records, stop fast bodies, list events.

use glam::Vec3;

use super::pairs::contact_pair;
use super::support::PairView;
use super::{Collision, Islands, World};
use crate::body::{Body, BodyKind};
use crate::collide::collider::Collider;
use crate::collide::pairs::Pair;
use crate::id::{BodyId, Pool, ShapeId};
use crate::linalg::rotation32;
use crate::report::{Events, IslandReport};

pub(super) mod bodies;
pub(super) mod contacts;
pub(super) mod joints;
mod moved;
pub(super) mod runs;

/// Pairs that are reported before those of them that touch are judged: few enough to be still in the cache, and enough for reads of
/// pairs to overlap, which they do not from one judgement to the next.
const REPORTED_AT_ONCE: usize = 64;

impl World {
    /// Writes poses, velocities and multipliers back.
    pub(super) fn store_results(&mut self, dt: f32) {
        let substep = dt / self.def.substeps as f32;
        self.scale_held(self.impulse_scale(substep));
        (self.last.substep, self.last.dt) = (substep, dt);
        self.note_starts();
        self.scratch.changed.clear();
        self.last.has_smooth_bodies = false;
        if !self.scratch.runs.is_empty() {
            self.store_bodies_of_runs(dt);
            self.store_contacts_of_runs(dt);
            self.store_joints_of_runs();
        }
        for number in 0..self.batches.count {
            self.store_bodies(number, dt);
            self.store_contacts(number, dt);
            self.store_joints(number);
            let batch = &self.batches.list[number];
            let (report, residuals) = (&mut self.report.counts, &mut self.report.residuals);
            report.colors = report.colors.max(batch.layout.color_count);
            report.planes_corrected += batch.planes.corrected;
            residuals.joint_gap = residuals.joint_gap.max(batch.residuals.joint_gap);
            residuals.penetration = residuals.penetration.max(batch.residuals.penetration);
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
        for index in std::mem::take(&mut self.last.broken) {
            self.quarantine(index);
        }
        self.finish_kinematic_bodies(dt);
        self.carry_anchored();
        self.report.counts.bodies_asleep = self.islands.sleeping.body_count() as u32;
        self.report.residuals.joint_gap = self.report.residuals.joint_gap.max(self.islands.sleeping.worst_gap());
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
        self.movers.are_sorted = false;
    }

    /// Kinematic bodies end where they were told to be.
    fn finish_kinematic_bodies(&mut self, dt: f32) {
        if !self.movers.some_are_driven {
            return;
        }
        for &index in &self.movers.slots {
            let body = &mut self.bodies[index];
            if body.kind != BodyKind::Kinematic {
                continue;
            }
            if let Some(target) = body.take_target() {
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
        self.collision.pairs.settle();
        match self.support.is_some() {
            true => self.report_contacts_with_support(),
            false => self.report_touches(),
        }
    }

    fn report_contacts_with_support(&mut self) {
        let Self {
            collision: Collision { pairs, .. }, colliders, bodies, events, support, islands: Islands { hold, .. }, ..
        } = self;
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
                } else if pair.pressed && support.rest.rests && !support.rest.has_landed {
                    let site = PairView::new(pair, slot, colliders, bodies);
                    support.rest.has_landed = site.is_on_base(support.frame.as_ref(), support.by_thrust);
                }
                report_contact(pair, colliders, bodies, events);
            }
            support.look_at_near(pairs, colliders, bodies);
        }
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
