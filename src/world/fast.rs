//! Stage that stops bodies flagged fast at what they would have passed through.
//!
//! What joints connect stops as one: where a member of an articulation is stopped, all of it goes back along its path by the same
//! share, so that no part is torn from the rest. Members do not stop one another.

use parry3d::bounding_volume::{Aabb, BoundingVolume};

use super::World;
use crate::collide::broad::{FEW_SHAPES, LARGE_GROUP};
use crate::collide::sweep::{self, PathStart};
use crate::span::union::UnionMotion;

/// Path of a body through the step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    /// Batch, and articulation in it; a body without joints is one by itself.
    pub group: (u32, u32),
    pub body: u32,
    pub start: PathStart,
}

/// Whether a body is of a group, which is sorted by body.
fn is_member(group: &[Path], body: u32) -> bool {
    group.binary_search_by_key(&body, |member| member.body).is_ok()
}

impl World {
    /// Sweeps bodies flagged fast along the path of the step.
    pub(super) fn stop_fast_bodies(&mut self) {
        if !self.census.some_are_fast() {
            return;
        }
        let mut paths = std::mem::take(&mut self.scratch.paths);
        paths.sort_unstable_by_key(|path| (path.group, path.body));
        for group in paths.chunk_by(|a, b| a.group == b.group) {
            let mut near = std::mem::take(&mut self.scratch.slots);
            let few = self.find_near(group, &mut near).then_some(&near[..]);
            let touch = |path: &Path| if self.bodies[path.body].fast { self.first_touch(path, group, few) } else { None };
            let fraction = group.iter().filter_map(touch).min_by(f32::total_cmp);
            self.scratch.slots = near;
            let Some(fraction) = fraction else { continue };
            for path in group {
                if let Some(union) = self.unions.moving(path.body) {
                    if let Some(before) = union.before.filter(|_| union.lead == path.body) {
                        let center = before.center.lerp(union.motion.center, f64::from(fraction));
                        let rotation = before.rotation.lerp(union.motion.rotation, fraction);
                        self.place_members(path.body, UnionMotion { center, rotation, ..before });
                    }
                    continue;
                }
                let body = &mut self.bodies[path.body];
                body.center = path.start.center.lerp(body.center, f64::from(fraction));
                if group.len() > 1 {
                    body.rotation = path.start.rotation.lerp(body.rotation, fraction);
                }
                self.shapes_follow(path.body);
            }
        }
        self.scratch.paths = paths;
    }

    /// Finds the shapes that may be in the way of a group; false if the group is small or there are many.
    fn find_near(&self, group: &[Path], near: &mut Vec<u32>) -> bool {
        near.clear();
        if group.len() < LARGE_GROUP {
            return false;
        }
        let mut whole: Option<Aabb> = None;
        for path in group.iter().filter(|path| self.bodies[path.body].fast) {
            let body = &self.bodies[path.body];
            for shape in body.shapes.iter().filter_map(|&id| self.colliders.find(id).ok()) {
                let swept = sweep::path_box(&self.colliders[shape], body, &path.start);
                whole = Some(whole.map_or(swept, |whole| whole.merged(&swept)));
            }
        }
        let is_other = |&shape: &u32| !is_member(group, self.colliders[shape].body);
        if let Some(whole) = whole {
            near.extend(self.broad.overlapping(&whole).filter(is_other).take(FEW_SHAPES + 1));
        }
        near.len() <= FEW_SHAPES
    }

    /// Share of the path after which the body touches something that is not of its group; `near` is all that could be, if known.
    fn first_touch(&self, path: &Path, group: &[Path], near: Option<&[u32]>) -> Option<f32> {
        let body = &self.bodies[path.body];
        let mut first: Option<f32> = None;
        for &id in &body.shapes {
            let collider = &self.colliders[self.colliders.find(id).ok()?];
            if !sweep::is_long(collider, body, &path.start) {
                continue;
            }
            if near.is_some_and(<[u32]>::is_empty) {
                return None;
            }
            let swept = sweep::path_box(collider, body, &path.start);
            let mut try_touch = |other: u32| {
                let other_shape = &self.colliders[other];
                if !is_member(group, other_shape.body)
                    && self.may_meet(collider, other_shape)
                    && let Some(fraction) = sweep::first_touch(collider, body, &path.start, other_shape)
                {
                    first = Some(first.map_or(fraction, |least| least.min(fraction)));
                }
            };
            match near {
                Some(near) => {
                    let meets = |other: u32| self.colliders[other].fat_box.is_some_and(|kept| kept.intersects(&swept));
                    near.iter().copied().filter(|&other| meets(other)).for_each(&mut try_touch);
                }
                None => self.broad.overlapping(&swept).for_each(&mut try_touch),
            }
        }
        first
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
