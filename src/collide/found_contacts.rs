//! Manifolds that the narrow phase finds for one pair.

use glam::Vec3;
use parry3d::math::Pose3;

use super::narrow::{self, Manifold, NarrowScratch};
use crate::shape::Shape;

/// Buffers and results of the narrow phase.
pub(super) struct FoundContacts<'a> {
    pub scratch: &'a mut NarrowScratch,
    pub manifolds: &'a mut Vec<Manifold>,
    /// Room for others.
    pub spare: &'a mut Vec<Manifold>,
}

impl FoundContacts<'_> {
    pub(super) fn collide(&mut self, [shape_a, shape_b]: [&Shape; 2], pose: Pose3, margin: f32) {
        narrow::collide(shape_a, shape_b, pose, margin, self.scratch, self.manifolds);
    }

    /// Normal of the nearest point, in A's frame.
    pub(super) fn nearest_normal(&self) -> Option<Vec3> {
        let points = self
            .manifolds
            .iter()
            .flat_map(|manifold| manifold.contacts().iter().map(|point| (point.separation, manifold.normal)));
        points.reduce(|least, more| if more.0 < least.0 { more } else { least }).map(|(_, normal)| normal)
    }

    /// Which of the first manifolds are apart by more than this (m), as bits.
    pub(super) fn apart_by(&self, least: f32) -> u128 {
        let apart = self.manifolds.iter().take(u128::BITS as usize).map(|manifold| u128::from(nearest_of(manifold) > least));
        apart.enumerate().fold(0, |all, (number, is_apart)| all | is_apart << number)
    }

    pub(super) fn nearest(&self) -> f32 {
        self.manifolds.iter().map(nearest_of).fold(f32::INFINITY, f32::min)
    }
}

/// Least separation of a manifold's points (m).
pub(super) fn nearest_of(manifold: &Manifold) -> f32 {
    manifold.contacts().iter().fold(f32::INFINITY, |least, point| least.min(point.separation))
}
