//! Stage that stops bodies flagged fast at what they would have passed through.
//!
//! What joints connect stops as one: where a member of an articulation is stopped, all of it goes back along its path by the same
//! share, so that no part is torn from the rest. Members do not stop one another.

use super::World;
use crate::collide::sweep::{self, PathStart};

/// Path of a body through the step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    /// Batch, and articulation in it; a body without joints is one by itself.
    pub group: (u32, u32),
    pub body: u32,
    pub start: PathStart,
}

impl World {
    /// Sweeps bodies flagged fast along the path of the step.
    pub(super) fn stop_fast_bodies(&mut self) {
        if !self.scratch.paths.iter().any(|path| self.bodies[path.body].fast) {
            return;
        }
        let mut paths = std::mem::take(&mut self.scratch.paths);
        paths.sort_unstable_by_key(|path| (path.group, path.body));
        for group in paths.chunk_by(|a, b| a.group == b.group) {
            let touch = |path: &Path| if self.bodies[path.body].fast { self.first_touch(path, group) } else { None };
            let Some(fraction) = group.iter().filter_map(touch).min_by(f32::total_cmp) else { continue };
            for path in group {
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

    /// Share of the path after which the body touches something that is not of its group.
    fn first_touch(&self, path: &Path, group: &[Path]) -> Option<f32> {
        let body = &self.bodies[path.body];
        let mut first: Option<f32> = None;
        for &id in &body.shapes {
            let collider = &self.colliders[self.colliders.find(id).ok()?];
            if !sweep::is_long(collider, body, &path.start) {
                continue;
            }
            for other in self.broad.overlapping(&sweep::path_box(collider, body, &path.start)) {
                let other_shape = &self.colliders[other];
                if group.binary_search_by_key(&other_shape.body, |member| member.body).is_err()
                    && self.may_meet(collider, other_shape)
                    && let Some(fraction) = sweep::first_touch(collider, body, &path.start, other_shape)
                {
                    first = Some(first.map_or(fraction, |least| least.min(fraction)));
                }
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
