//! Decides which bounds of a block are taut, and builds their rows.

use super::{BoundBlock, Rows};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::{WideMotion, WideVelocities};
use crate::solve::contact::Lane;
use crate::solve::integrate::PredictedPose;
use crate::solve::joint::{implicit_share, turning_ease_in_lanes};
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Levers of the two points in world axes, and the gap from near to far (m).
pub(super) struct BoundLevers<W> {
    pub levers: (Wide3<W>, Wide3<W>),
    pub gap: Wide3<W>,
}

impl<W: Wide> BoundLevers<W> {
    #[inline(always)]
    pub fn of(block: &BoundBlock, near: &WideMotion<W>, far: &WideMotion<W>) -> Self {
        let near_lever = near.rotation.rotate(Wide3::load(&block.local[0]));
        let far_lever = far.rotation.rotate(Wide3::load(&block.local[1]));
        let gap = Wide3::load(&block.offset) + (far.displacement - near.displacement) + (far_lever - near_lever);
        Self { levers: (near_lever, far_lever), gap }
    }

    /// Gradient of the distance; both levers may reach anywhere along the line: the two impulses are on it.
    #[inline(always)]
    pub fn gradient(&self) -> Gradient<W> {
        let length = self.gap.length();
        let some = length.above(W::zero());
        let along = (self.gap * (W::splat(1.0) / length)).only(some);
        // Two points in one place may part in any direction.
        let along = Wide3::new(W::select(some, along.x, W::splat(1.0)), along.y, along.z);
        Gradient { along, arms: (self.levers.0.cross(along), self.levers.1.cross(along)) }
    }
}

/// Gradient of a distance: [−along, −near arm, along, far arm].
pub(super) struct Gradient<W> {
    pub along: Wide3<W>,
    pub arms: (Wide3<W>, Wide3<W>),
}

impl<W: Wide> Gradient<W> {
    #[inline(always)]
    pub fn rate(&self, near: &WideVelocities<W>, far: &WideVelocities<W>) -> W {
        self.along.dot(far.linear - near.linear) + self.arms.1.dot(far.angular) - self.arms.0.dot(near.angular)
    }

    /// Applies an impulse along it.
    #[inline(always)]
    pub fn push(&self, impulse: W, near: &mut WideVelocities<W>, far: &mut WideVelocities<W>) {
        near.apply(self.along * -impulse, self.arms.0 * -impulse);
        far.apply(self.along * impulse, self.arms.1 * impulse);
    }

    /// J M⁻¹ Jᵀ.
    #[inline(always)]
    pub fn inverse_effective_mass(&self, near: &WideVelocities<W>, far: &WideVelocities<W>) -> W {
        self.along.dot((near.inverse_mass() + far.inverse_mass()).scale(self.along))
            + self.arms.0.dot(near.response(self.arms.0))
            + self.arms.1.dot(far.response(self.arms.1))
    }
}

#[inline(always)]
pub(super) fn prepare<W: Wide>(
    blocks: &mut [BoundBlock],
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
    predicted_poses: &[PredictedPose],
    h: f32,
    applied: bool,
) {
    for block in blocks {
        let (near, far) =
            (WideMotion::<W>::then(&block.near, predicted_poses), WideMotion::<W>::then(&block.far, predicted_poses));
        let end = BoundLevers::of(block, &near, &far);
        let squared = end.gap.dot(end.gap);
        find_taut(&mut block.upper_rows, squared, W::load(&block.ready), applied);
        if block.lower_rows.used {
            find_taut(&mut block.lower_rows, W::load(&block.near_lower), squared, applied);
        }
        if block.is_taut() {
            build(block, &end, velocities, motions, h);
        }
    }
}

/// Finds the rows that are there: those whose `greater` is not below `lesser`. A multiplier that has been applied keeps its row,
/// where it can be taken back.
#[inline(always)]
fn find_taut<W: Wide>(rows: &mut Rows, greater: W, lesser: W, applied: bool) {
    let (one, zero) = (W::splat(1.0), W::zero());
    let impulse = W::load(&rows.impulse);
    let slack = W::select(lesser.above(greater), one, zero);
    let held = if applied { W::select(impulse.above(zero), one, zero) } else { zero };
    let present = (one - slack).max(held);
    let is_present = present.above(zero);
    present.store(&mut rows.present);
    W::select(is_present, impulse, zero).store(&mut rows.impulse);
    rows.any = W::any(is_present);
}

#[inline(always)]
fn build<W: Wide>(block: &mut BoundBlock, end: &BoundLevers<W>, velocities: &[BodyVelocity], motions: &[BodyMotion], h: f32) {
    let (near, far) = (WideMotion::<W>::now(&block.near, motions), WideMotion::<W>::now(&block.far, motions));
    let start = BoundLevers::of(block, &near, &far);
    let (near, far) = (WideVelocities::<W>::gather(&block.near, velocities), WideVelocities::<W>::gather(&block.far, velocities));
    // Taken between start and predicted end by how stiff the tension makes the turning of the bodies, as joints do.
    let tension = W::load(&block.upper_rows.impulse).max(W::load(&block.lower_rows.impulse));
    let ease = turning_ease_in_lanes(&near, start.levers.0) + turning_ease_in_lanes(&far, start.levers.1);
    let implicit = implicit_share(W::splat(h) * tension * ease);
    let middle = BoundLevers {
        levers: (
            start.levers.0 + (end.levers.0 - start.levers.0) * implicit,
            start.levers.1 + (end.levers.1 - start.levers.1) * implicit,
        ),
        gap: start.gap + (end.gap - start.gap) * implicit,
    };
    let gradient = middle.gradient();
    let w = gradient.inverse_effective_mass(&near, &far);
    let rate = gradient.rate(&near, &far);
    let (from, to) = (start.gap.length(), end.gap.length());
    let upper = W::load(&block.upper);
    set_rows(&mut block.upper_rows, w, (upper - from, upper - to), -rate, h);
    let mut acted = W::load(&block.acted).max(W::load(&block.upper_rows.present));
    if block.lower_rows.any {
        let lower = W::load(&block.lower);
        set_rows(&mut block.lower_rows, w, (from - lower, to - lower), rate, h);
        acted = acted.max(W::load(&block.lower_rows.present));
    }
    acted.store(&mut block.acted);
    gradient.along.store(&mut block.along);
    gradient.arms.0.store(&mut block.arm[0]);
    gradient.arms.1.store(&mut block.arm[1]);
}

/// Rows over a substep of length `h`, in which C goes from `start` to `predicted` at the rate `rate`.
#[inline(always)]
fn set_rows<W: Wide>(rows: &mut Rows, w: W, (start, predicted): (W, W), rate: W, h: f32) {
    let (zero, inverse_h) = (W::zero(), W::splat(1.0 / h));
    let mass = W::select(w.above(zero), W::splat(1.0) / (w + W::load(&rows.gamma)), zero);
    keep_present::<W>(mass, &rows.present).store(&mut rows.mass);
    let rigid = (start.max(zero) + predicted - start) * inverse_h - rate;
    let soft = (predicted * inverse_h - rate) * W::load(&rows.damped);
    let bias = W::select(W::load(&rows.rigid).above(zero), rigid, soft);
    keep_present::<W>(bias, &rows.present).store(&mut rows.bias);
}

#[inline(always)]
fn keep_present<W: Wide>(number: W, present: &Lane) -> W {
    W::select(W::load(present).above(W::zero()), number, W::zero())
}
