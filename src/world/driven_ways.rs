//! Stage that looks where motors have taken what they drive, and solves the step again where something is in the way.
//!
//! Contacts are looked for as far as bodies may go at the velocities that a step begins with. A motor that is strong enough takes what it drives
//! further: one without a bound to its target at once, through any wall. What has gone further than contacts were looked for is swept along its
//! way, and where it would have met something, the step is solved again from its start with contacts as far as the way goes. What is met may
//! be driven on in turn, a few times.

use parry3d::bounding_volume::BoundingVolume;

use super::body_shape_table::Marks;
use super::islands::NO_BODY;
use super::{Collision, World};
use crate::body::BodyKind;
use crate::collide::collider::own_margin;
use crate::collide::pairs::PairKey;
use crate::collide::sweep::{self, BodyPath, BodyPose, ImpactBuffer, Way};
use crate::joint_graph::union::UnionMotion;

/// Times that a step is solved again for what is driven, at most: a lift under its load under another, which meets a ceiling.
const MAX_ROUNDS: u32 = 3;

/// Buffers of the stage, and what it has found in this step.
#[derive(Debug, Default)]
pub(super) struct DrivenWays {
    /// Islands in which a motor acts.
    islands: Marks,
    /// Bodies that go further than by their velocities, and by how much (m).
    further: Vec<(u32, f32)>,
    parts: ImpactBuffer,
}

impl DrivenWays {
    /// Whether a motor drives this body further than by its velocity.
    pub(super) fn drives(&self, body: u32) -> bool {
        self.further.iter().any(|&(driven, _)| driven == body)
    }
}

impl World {
    /// Solves the step again as long as motors drive bodies into what no contacts were looked for with.
    pub(super) fn meet_what_is_driven_into(&mut self, dt: f32) {
        self.report.counts.solves = 1;
        for _ in 0..MAX_ROUNDS {
            if !self.find_driven(dt) {
                return;
            }
            self.solve_from_start(dt);
        }
    }

    /// Forgets what was found in the last step.
    pub(super) fn forget_driven(&mut self) {
        self.scratch.driven.further.clear();
    }

    /// The stages up to the solve once more, from the state that the step began with.
    pub(super) fn solve_from_start(&mut self, dt: f32) {
        let counts = &mut self.report.counts;
        *counts =
            crate::report::StepCounts { joints_broken: counts.joints_broken, solves: counts.solves + 1, ..Default::default() };
        self.find_pairs(dt);
        self.look_further(dt);
        self.update_contacts(dt);
        self.wake_what_is_touched();
        self.group_islands();
        self.derive_long_range();
        self.hand_out_bounds();
        self.solve_batches(dt);
        self.read_joint_loads(dt);
    }

    /// Lists bodies that motors drive into something beyond what contacts were looked for; whether there are more than before.
    fn find_driven(&mut self, dt: f32) -> bool {
        let mut driven = std::mem::take(&mut self.scratch.driven);
        let mut any = false;
        if self.mark_driven_islands(&mut driven.islands) {
            for &body in &self.movers.slots {
                if self.collision.index.free.has(body) && driven.islands.has(self.islands.groups.island[body as usize]) {
                    let known = driven.further.iter().position(|&(other, _)| other == body);
                    let seen = known.map_or(0.0, |place| driven.further[place].1);
                    let Some(further) = self.driven_further(body, seen, dt, &mut driven.parts) else { continue };
                    match known {
                        Some(place) => driven.further[place].1 = further,
                        None => driven.further.push((body, further)),
                    }
                    any = true;
                }
            }
        }
        self.scratch.driven = driven;
        any
    }

    /// Marks the islands in which a motor acts; whether there are any.
    fn mark_driven_islands(&self, islands: &mut Marks) -> bool {
        let mut any = false;
        islands.begin(0);
        for batch in &self.batches.list[..self.batches.count] {
            for head in batch.joints.slots.iter().map(|&slot| &self.islands.groups.joint_heads[slot as usize]) {
                let moves = |&body: &u32| body != NO_BODY && self.collision.index.free.has(body);
                if let Some(body) = head.bodies.into_iter().find(moves).filter(|_| head.traits.has_motor) {
                    islands.set(self.islands.groups.island[body as usize]);
                    any = true;
                }
            }
        }
        any
    }

    /// How much further a body has been driven than by its velocity (m), if that is further than contacts were looked for, `seen` (m) beyond its
    /// velocity, and something is in the way.
    fn driven_further(&self, index: u32, seen: f32, dt: f32, parts: &mut ImpactBuffer) -> Option<f32> {
        let (body, gravity) = (&self.bodies[index], self.def.gravity.length());
        let path = self.solved_path(index, dt)?;
        let shift = (path.end.center - path.start.center).length() as f32;
        let mut furthest: Option<f32> = None;
        for shape in body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok()) {
            let collider = &self.colliders[shape];
            let moving = sweep::moving(collider, body, path);
            let further = shift + moving.turning() * collider.reach - collider.motion_bound(body, gravity, dt);
            // Written so that what is no number is not driven.
            if !(further > seen + own_margin(collider) && further.is_finite()) {
                continue;
            }
            let bounds = sweep::path_box(collider, body, &path);
            let meets = |other: u32| {
                // What has contact points has been a matter of the solve.
                let is_known = self
                    .collision
                    .pairs
                    .find(PairKey::new(shape, other))
                    .is_some_and(|slot| self.collision.pairs.get(slot).has_points());
                let other = &self.colliders[other];
                if is_known || !self.may_meet(collider, other) {
                    return false;
                }
                let Some(way) = self.solved_path(other.body, dt) else { return false };
                let at = sweep::moving(other, &self.bodies[other.body], way);
                sweep::first_touch(&moving, &at, (collider.least_extent, Way::Sent), parts).is_some()
            };
            if self.collision.broad.overlapping(&bounds).any(meets) {
                furthest = Some(furthest.map_or(further, |furthest| furthest.max(further)));
            }
        }
        furthest
    }

    /// Way of a body through the step as it has been solved; none where that is no number, as it is taken out after the step.
    fn solved_path(&self, index: u32, dt: f32) -> Option<BodyPath> {
        let body = &self.bodies[index];
        let start = BodyPose { center: body.center, rotation: body.rotation };
        let union = self.unions.moving(index);
        let end = match self.solved_at(union.map_or(index, |union| union.lead)) {
            Some((batch, slot)) => {
                let motion = &batch.motions[slot];
                let way = motion.displacement.as_dvec3();
                match union {
                    Some(union) => {
                        let moved = UnionMotion { center: union.motion.center + way, rotation: motion.rotation, ..union.motion };
                        let own = self.unions.motion_of(index, &moved);
                        BodyPose { center: own.center, rotation: own.rotation }
                    }
                    None => BodyPose { center: start.center + way, rotation: motion.rotation },
                }
            }
            None if body.acts_as() == BodyKind::Kinematic => {
                BodyPose { center: start.center + body.linear_velocity.as_dvec3() * f64::from(dt), ..start }
            }
            // What is held, asleep or static stands.
            None => start,
        };
        (end.center.is_finite() && end.rotation.is_finite()).then_some(BodyPath { start, end })
    }

    /// Enlarges the boxes of what is driven further than by its velocity, and has contacts looked for as far.
    fn look_further(&mut self, dt: f32) {
        if self.scratch.driven.further.is_empty() {
            return;
        }
        let gravity = self.def.gravity.length();
        let Self { scratch, bodies, colliders, collision: Collision { index, broad, .. }, .. } = self;
        for &(body, further) in &scratch.driven.further {
            let body = &bodies[body];
            for &id in &body.shapes {
                let Ok(shape) = colliders.find(id) else { continue };
                let collider = &mut colliders[shape];
                let tight = collider.world_box(collider.motion_bound(body, gravity, dt) + further + own_margin(collider));
                collider.tight_box = tight;
                if collider.fat_box.is_none_or(|kept| !kept.contains(&tight)) {
                    collider.fat_box = Some(tight.loosened(collider.fat_margin()));
                    index.reboxed.set(shape);
                    broad.revisit(shape);
                }
            }
        }
        self.add_new_pairs();
        self.tidy_pairs();
        let Self { scratch, bodies, colliders, collision: Collision { index, pairs, .. }, .. } = self;
        index.add_stances(pairs.active(), colliders, bodies);
        for &(body, further) in &scratch.driven.further {
            for shape in bodies[body].shapes.iter().filter_map(|&id| colliders.find(id).ok()) {
                index.drive_further(shape, colliders[shape].tight_box, further / dt);
            }
        }
    }
}
