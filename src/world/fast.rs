//! Stage that stops bodies at what they would have passed through.
//!
//! A step moves bodies from where they were to where the solver has put them. Those flagged fast are swept along that way, against all
//! that is near it and moves along its own way at the same time. So are those that a hit has sent off their way ([`astray`]), but only against
//! what stands still: what falls onto a floor stays on it. Touches are taken in the order in which they happen, and what has touched
//! another goes on with it to the end of the step ([`paths`]); on its new way it may meet others. All are found before anything is put
//! anywhere else.
//!
//! Velocities stay what they are; the contact of the next step answers to them.
//!
//! What joints connect stops as one: where a member of an articulation meets something, all of it goes that way, so that no part is torn
//! from the rest. Members do not stop one another.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{Quat, Vec3};
use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::{Islands, Movers, World};
use crate::body::Body;
use crate::collide::broad::{FEW_SHAPES, LARGE_GROUP};
use crate::collide::sweep::{self, BodyPath, BodyPose, ImpactBuffer, Way};
use crate::joint_graph::union::UnionMotion;
use crate::shape::Shape;
use crate::speed_limits::MAX_LINEAR_SPEED;

mod astray;
mod paths;

pub(super) use astray::Start;
use paths::{Hold, NONE, Paths};
pub(super) use paths::{Path, Swept};

/// A touch to come, in the order in which touches are taken: share of the step as the bits of a number that is not negative, swept shape,
/// the other, how often the ways of the two had changed when it was found, and the bits of the direction from the first to the other.
type TimeOfImpact = (u64, u32, u32, [u32; 2], [u32; 3]);

/// Buffers of the stage.
#[derive(Debug, Default)]
pub(super) struct Sweeps {
    pub paths: Vec<Path>,
    /// Where bodies were when the step began that are not flagged fast.
    pub starts: Vec<(u32, BodyPose)>,
    ways: Paths,
    /// Swept shapes, each with another that may be in its way.
    near: Vec<(u32, u32)>,
    /// Swept shapes that have left the box in which others look for them, with the box of their way.
    strays: Vec<(u32, Aabb)>,
    around: Vec<u32>,
    /// Swept shapes of a group, with the boxes of their ways.
    boxes: Vec<(u32, Aabb)>,
    touches: BinaryHeap<Reverse<TimeOfImpact>>,
    parts: ImpactBuffer,
}

fn mass_of(body: &Body) -> f64 {
    body.mass.map_or(1.0, |mass| f64::from(mass.mass))
}

/// Angular velocity of a body once it is turned like this (rad/s), as it has not been struck on the way that it goes back: that of its angular momentum, or
/// where that would be more energy, as a hit has changed how it turns since, the one that it has in its own axes.
fn spin_at(body: &Body, rotation: Quat) -> Vec3 {
    let Some(mass) = body.mass.filter(|_| body.settings.locked_axes.rotation == [false; 3]) else { return body.angular_velocity };
    let [now, then] = [body.rotation, rotation].map(|rotation| rotation * mass.inertia_frame);
    let own = now.conjugate() * body.angular_velocity;
    let momentum = now * (mass.principal_inertia * own);
    let with_momentum = (then.conjugate() * momentum) / mass.principal_inertia;
    let energy = |spin: Vec3| spin.dot(mass.principal_inertia * spin);
    then * if energy(with_momentum) <= energy(own) { with_momentum } else { own }
}

impl World {
    /// Takes note of where bodies are that the step has not moved yet, if any may have to be stopped.
    pub(super) fn note_starts(&mut self) {
        let Self { islands: Islands { summaries, .. }, movers: Movers { slots: movers, .. }, bodies, scratch, .. } = self;
        let sweeps = &mut scratch.sweeps;
        sweeps.paths.clear();
        sweeps.starts.clear();
        if !summaries.some_are_fast() {
            return;
        }
        for &index in &*movers {
            let body = &bodies[index];
            sweeps.starts.push((index, BodyPose { center: body.center, rotation: body.rotation }));
        }
    }

    /// Sweeps bodies that may have passed something along their ways through the step.
    pub(super) fn stop_fast_bodies(&mut self) {
        if self.scratch.sweeps.paths.is_empty() {
            return;
        }
        let mut sweeps = std::mem::take(&mut self.scratch.sweeps);
        sweeps.ways.begin(self.bodies.slot_count());
        sweeps.starts.iter().for_each(|&(body, start)| sweeps.ways.note_start(body, start));
        sweeps.paths.sort_unstable();
        sweeps.ways.lay_out(&sweeps.paths, |body| (mass_of(&self.bodies[body]), self.end_of(body)));
        sweeps.touches.clear();
        self.find_first_touches(&mut sweeps);
        while let Some(Reverse((time, swept, other, changes, normal))) = sweeps.touches.pop() {
            let bodies = [swept, other].map(|shape| self.colliders[shape].body);
            if bodies.map(|body| sweeps.ways.changes_of(body)) == changes {
                self.meet(&mut sweeps, f64::from_bits(time), bodies, Vec3::from(normal.map(f32::from_bits)));
            }
        }
        for group in 0..sweeps.ways.group_count() {
            self.put_where_they_stop(&sweeps.ways, group);
        }
        self.scratch.sweeps = sweeps;
    }

    /// Where the step has put a body.
    fn end_of(&self, index: u32) -> BodyPose {
        let body = &self.bodies[index];
        BodyPose { center: body.center, rotation: body.rotation }
    }

    /// Way of a body from a share of the step on, as far as it is known.
    fn path_after(&self, ways: &Paths, index: u32, time: f64) -> BodyPath {
        ways.path_after(index, time, self.end_of(index))
    }

    /// Finds the touches of all that is swept with what it meets as long as everything goes its own way.
    fn find_first_touches(&self, sweeps: &mut Sweeps) {
        let mut near = std::mem::take(&mut sweeps.near);
        near.clear();
        sweeps.strays.clear();
        for group in 0..sweeps.ways.group_count() {
            self.find_near(sweeps, group, 0.0, &mut near);
        }
        sweeps.strays.sort_unstable_by(|(a, bounds_a), (b, bounds_b)| bounds_a.mins.x.total_cmp(&bounds_b.mins.x).then(a.cmp(b)));
        for (place, (shape, bounds)) in sweeps.strays.iter().enumerate() {
            let behind = sweeps.strays[place + 1..].iter().take_while(|(_, other)| other.mins.x <= bounds.maxs.x);
            let met = behind.filter(|(_, other)| other.intersects(bounds));
            near.extend(met.filter_map(|&(other, _)| self.swept_pair(&sweeps.ways, *shape, other)));
        }
        near.sort_unstable();
        near.dedup();
        near.iter().for_each(|&pair| self.find_touch(sweeps, pair, 0.0));
        sweeps.near = near;
    }

    /// Whether what slides along a body can't come to another part of it, as in a room or a corner.
    fn is_one_convex_piece(&self, body: u32) -> bool {
        let is_convex = |shape: &Shape| shape.geometry().is_solid() && !shape.is_compound();
        let one = match *self.bodies[body].shapes {
            [one] => self.colliders.find(one).ok(),
            _ => None,
        };
        one.is_some_and(|slot| is_convex(&self.colliders[slot].shape)) && self.unions.number_of(body).is_none()
    }

    /// Has two bodies that touch go on together, and looks what they meet then; `normal` points from the first to the second.
    fn meet(&self, sweeps: &mut Sweeps, time: f64, bodies: [u32; 2], normal: Vec3) {
        let Sweeps { ways, .. } = sweeps;
        let is_swept = bodies.map(|body| ways.group_of(body) != NONE);
        for (i, other) in [(0, 1), (1, 0)] {
            if !is_swept[other] {
                let body = bodies[other];
                let record = &self.bodies[body];
                let is_loose = record.is_free() && record.joints.is_empty() && self.unions.moving(body).is_none();
                if is_loose && ways.take_along(time, bodies[i], body, (mass_of(record), self.end_of(body))) {
                    continue;
                }
                let hold = if self.bodies[body].is_free() { Hold::ByMover(body) } else { Hold::ByFixed(body) };
                let path = self.path_after(ways, body, time);
                let across = self.is_one_convex_piece(body).then_some(if i == 0 { normal } else { -normal });
                ways.meet_other(time, bodies[i], hold, path, across);
            }
        }
        if is_swept == [true; 2] {
            ways.meet(time, bodies);
        }
        let changed = std::mem::take(&mut ways.changed);
        let mut near = std::mem::take(&mut sweeps.near);
        near.clear();
        for &group in &changed {
            self.find_near(sweeps, group, time, &mut near);
            let Sweeps { ways, strays, boxes, .. } = &*sweeps;
            for &(shape, bounds) in boxes {
                let met = strays.iter().filter(|(_, other)| other.intersects(&bounds));
                near.extend(met.filter_map(|&(other, _)| self.swept_pair(ways, shape, other)));
            }
        }
        near.sort_unstable();
        near.dedup();
        near.iter().for_each(|&pair| self.find_touch(sweeps, pair, time));
        (sweeps.near, sweeps.ways.changed) = (near, changed);
    }

    /// Two shapes that may meet, the one that is swept first.
    fn swept_pair(&self, ways: &Paths, shape: u32, other: u32) -> Option<(u32, u32)> {
        let (a, b) = (&self.colliders[shape], &self.colliders[other]);
        let swept = [a, b].map(|collider| ways.swept(collider.body));
        let is_swept = swept.contains(&Swept::All) || self.stands_still(b.body);
        let may_meet = is_swept && ways.group_of(a.body) != ways.group_of(b.body) && self.may_meet(a, b);
        may_meet.then(|| if other < shape && swept[1] != Swept::Along { (other, shape) } else { (shape, other) })
    }

    /// Whether no row moves a body, and the host does not either.
    fn stands_still(&self, index: u32) -> bool {
        let body = &self.bodies[index];
        !body.is_free() && (body.linear_velocity, body.angular_velocity) == (Vec3::ZERO, Vec3::ZERO)
    }

    /// Lists the swept shapes of a group with what may be in their way after a share of the step, but for strays; adds their own.
    fn find_near(&self, sweeps: &mut Sweeps, group: u32, time: f64, near: &mut Vec<(u32, u32)>) {
        let Sweeps { ways, boxes, around, strays, .. } = sweeps;
        boxes.clear();
        self.list_swept_shapes(ways, group, time, boxes);
        let few = self.find_around(ways, group, boxes, around).then_some(&around[..]);
        for &(shape, bounds) in &*boxes {
            match few {
                Some(few) => {
                    let meets = |other: u32| self.colliders[other].fat_box.is_some_and(|kept| kept.intersects(&bounds));
                    near.extend(
                        few.iter().filter(|&&other| meets(other)).filter_map(|&other| self.swept_pair(ways, shape, other)),
                    );
                }
                None => {
                    near.extend(self.collision.broad.overlapping(&bounds).filter_map(|other| self.swept_pair(ways, shape, other)))
                }
            }
            if self.colliders[shape].fat_box.is_none_or(|kept| !kept.contains(&bounds)) {
                strays.push((shape, bounds));
            }
        }
    }

    /// Lists the shapes of a group that are swept, with the boxes of their ways.
    fn list_swept_shapes(&self, ways: &Paths, group: u32, time: f64, boxes: &mut Vec<(u32, Aabb)>) {
        for index in ways.members(group) {
            let body = &self.bodies[index];
            if ways.swept(index) != Swept::Along {
                let path = self.path_after(ways, index, time);
                let shapes = body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok());
                boxes.extend(shapes.map(|shape| (shape, sweep::path_box(&self.colliders[shape], body, &path))));
            }
        }
    }

    /// Finds the shapes that may be in the way of a large group; false if it is small, or there are many.
    fn find_around(&self, ways: &Paths, group: u32, boxes: &[(u32, Aabb)], around: &mut Vec<u32>) -> bool {
        around.clear();
        if ways.members(group).nth(LARGE_GROUP - 1).is_none() {
            return false;
        }
        if let Some(whole) = boxes.iter().map(|&(_, bounds)| bounds).reduce(|whole, more| whole.merged(&more)) {
            let is_other = |&shape: &u32| ways.group_of(self.colliders[shape].body) != group;
            around.extend(self.collision.broad.overlapping(&whole).filter(is_other).take(FEW_SHAPES + 1));
        }
        around.len() <= FEW_SHAPES
    }

    /// Finds the touch of two shapes that may be in each other's way from a share of the step on, as far as their ways are known.
    fn find_touch(&self, sweeps: &mut Sweeps, (swept, other): (u32, u32), time: f64) {
        let Sweeps { ways, parts, touches, .. } = sweeps;
        let colliders = [swept, other].map(|shape| &self.colliders[shape]);
        let bodies = colliders.map(|collider| collider.body);
        if ways.are_together(bodies) {
            return;
        }
        let mut paths = bodies.map(|body| self.path_after(ways, body, time));
        if ways.slides_on(bodies[0]) == Some(bodies[1]) {
            paths = paths::as_seen_from(paths);
        }
        let moving = |i: usize| sweep::moving(colliders[i], &self.bodies[bodies[i]], paths[i]);
        let (a, b) = (moving(0), moving(1));
        let is_swept = ways.swept(bodies[1]) != Swept::Along;
        let extent = if is_swept { colliders[0].least_extent.min(colliders[1].least_extent) } else { colliders[0].least_extent };
        let changes = bodies.map(|body| ways.changes_of(body));
        let way = match changes == [0; 2] {
            true if bodies.iter().any(|&body| ways.swept(body) == Swept::All) => Way::Own,
            true => Way::OwnUnseen,
            false => Way::Sent,
        };
        if let Some((share, normal)) = sweep::first_touch(&a, &b, (extent, way), parts) {
            let at = time + (1.0 - time) * share;
            touches.push(Reverse((at.to_bits(), swept, other, changes, normal.to_array().map(f32::to_bits))));
        }
    }

    /// Puts the members of a group where they stop, if they do.
    fn put_where_they_stop(&mut self, ways: &Paths, group: u32) {
        for index in ways.members(group) {
            let Some(stop) = ways.new_end(index) else { continue };
            if let Some(union) = self.unions.moving(index) {
                if union.lead == index {
                    // The union goes with its first member, as stiff as it is.
                    let end = self.end_of(index);
                    let turn = (stop.rotation * end.rotation.conjugate()).normalize();
                    let UnionMotion { center, rotation, .. } = union.motion;
                    let center = stop.center + turn.as_dquat() * (center - end.center);
                    self.place_members(index, UnionMotion { center, rotation: (turn * rotation).normalize(), ..union.motion });
                }
                continue;
            }
            let fall = self.def.gravity;
            let carrier = ways.held_by(index).map(|hold| {
                let by = &self.bodies[hold];
                by.linear_velocity + by.angular_velocity.cross((stop.center - by.center).as_vec3())
            });
            let body = &mut self.bodies[index];
            if let Some(carrier) = carrier.filter(|_| body.joints.is_empty()) {
                // Gravity has worked on the rest of the way, too, as what holds the body sees it. Of what is flagged it is taken from the whole velocity,
                // or discs that tip over would gain by it; of what a hit sends off its way from how fast it falls, since it slides as it did.
                let fall = fall * body.settings.gravity_scale;
                let work = (body.center - stop.center).dot(fall.as_dvec3());
                let seen = body.linear_velocity - carrier;
                let along = if body.settings.fast {
                    seen
                } else {
                    fall * (seen.dot(fall) / fall.length_squared().max(f32::MIN_POSITIVE))
                };
                let square = f64::from(along.length_squared());
                if work > 0.0 && square > 0.0 && (body.settings.fast || along.dot(fall) > 0.0) {
                    let kept = (1.0 - 2.0 * work / square).max(0.0).sqrt() as f32;
                    body.linear_velocity = (body.linear_velocity + along * (kept - 1.0)).clamp_length_max(MAX_LINEAR_SPEED);
                }
            }
            if body.is_free() && body.joints.is_empty() {
                body.angular_velocity = spin_at(body, stop.rotation);
            }
            (body.center, body.rotation) = (stop.center, stop.rotation);
            self.shapes_follow(index);
        }
    }

    fn shapes_follow(&mut self, index: u32) {
        let body = &self.bodies[index];
        for &id in &body.shapes {
            if let Ok(shape) = self.colliders.find(id) {
                self.colliders[shape].follow(body);
            }
        }
    }
}
