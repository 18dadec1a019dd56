//! Two convex parts in one frame, and what a direction proves of them.

use glam::Vec3;
use parry3d::math::Pose3;

use super::distance::ConvexGap;
use super::part::Part;

/// How far outside a face a vertex counts as over it, as a fraction of the smaller part.
const CLIP_SLOP: f32 = 1.0e-4;

/// Two parts, of which B is placed in A's frame.
pub(super) struct ConvexPair<'a> {
    pub a: &'a Part<'a>,
    pub b: &'a Part<'a>,
    pub relative: &'a Pose3,
    /// Rounding of both (m).
    pub radii: f32,
    /// Reach of the smaller (m).
    pub size: f32,
    /// How far outside a face a vertex counts as over it (m).
    pub slop: f32,
}

impl<'a> ConvexPair<'a> {
    /// Two parts, if they may be nearer to each other than `margin`.
    pub(super) fn near(a: &'a Part<'a>, b: &'a Part<'a>, relative: &'a Pose3, margin: f32) -> Option<Self> {
        let (reach_a, reach_b) = (a.reach(), b.reach());
        // Written so that a NaN is no contact.
        let near = relative.translation.length() <= reach_a + reach_b + margin;
        if !near || !relative.rotation.is_finite() {
            return None;
        }
        let size = reach_a.min(reach_b);
        Some(Self {
            a,
            b,
            relative,
            radii: a.rounding() + b.rounding(),
            size,
            slop: CLIP_SLOP * size + 4.0 * f32::EPSILON * reach_a.max(reach_b),
        })
    }

    /// The gap that a unit `normal` proves: between the parts' extreme points along it.
    pub(super) fn along(&self, normal: Vec3) -> ConvexGap {
        let on_b = *self.relative * self.b.core_support(self.relative.rotation.inverse() * -normal);
        ConvexGap { on_a: self.a.core_support(normal), on_b, normal }
    }
}
