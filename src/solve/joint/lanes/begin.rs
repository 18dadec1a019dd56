//! Present state of the joints of a block: levers, gaps, and errors of directions.

use super::{DirectionBlock, Holds, JointLanes, PointBlock};
use crate::lanes::wide::{Plain, Wide, Wide3};
use crate::solve::body_gather::WidePoses;
use crate::solve::contact::{LANES, Lane};
use crate::solve::state::BodyMotion;
use crate::solve::wide_matrix::{WideQuat, arc_over_sine};

/// Sine below which two opposite axes have no common normal.
const MIN_SINE: f32 = 1.0e-6;

#[inline(always)]
pub(super) fn all<W: Wide>(lanes: &mut JointLanes, motions: &[BodyMotion]) {
    let JointLanes { points, directions, .. } = lanes;
    for block in points {
        let (a, b) = (WidePoses::<W>::gather(&block.a, motions), WidePoses::<W>::gather(&block.b, motions));
        let placed = JointLevers::of(block, &a, &b);
        placed.levers.0.store(&mut block.lever[0]);
        placed.levers.1.store(&mut block.lever[1]);
        placed.gap.store(&mut block.gap);
        if let Some(number) = block.directions {
            let block = &mut directions[number as usize];
            let tilt = Tilt::<W>::of(block, &a.rotation, &b.rotation);
            tilt.axes.0.store(&mut block.axis[0]);
            tilt.axes.1.store(&mut block.axis[1]);
            store_quat(&tilt.relative, &mut block.relative);
            tilt.error.store(&mut block.error);
            tilt.arc.store(&mut block.arc);
        }
    }
}

#[inline(always)]
pub(super) fn worst_gap<W: Wide>(lanes: &JointLanes, motions: &[BodyMotion], worst: &mut f32) {
    let mut widest = W::zero();
    for block in &lanes.points {
        let (a, b) = (WidePoses::<W>::gather(&block.a, motions), WidePoses::<W>::gather(&block.b, motions));
        let gap = JointLevers::of(block, &a, &b).gap;
        widest = widest.max(gap.dot(gap));
    }
    let mut lanes = [0.0; LANES];
    widest.sqrt().store(&mut lanes);
    *worst = lanes.iter().fold(*worst, |worst, &gap| worst.max(gap));
}

#[inline(always)]
pub(super) fn opening<W: Wide>(lanes: &JointLanes, motions: &[BodyMotion], widest: &mut f32) {
    let mut shares = W::zero();
    for block in &lanes.points {
        let (a, b) = (WidePoses::<W>::gather(&block.a, motions), WidePoses::<W>::gather(&block.b, motions));
        let gap = JointLevers::of(block, &a, &b).gap * W::load(&block.shortness);
        shares = shares.max(gap.dot(gap));
    }
    let mut lanes = [0.0; LANES];
    shares.sqrt().store(&mut lanes);
    *widest = lanes.iter().fold(*widest, |widest, &share| widest.max(share));
}

pub(super) fn each_opening(lanes: &JointLanes, motions: &[BodyMotion], tell: &mut impl FnMut([u32; 2], f32)) {
    for block in &lanes.points {
        let (a, b) = (WidePoses::<Plain>::gather(&block.a, motions), WidePoses::<Plain>::gather(&block.b, motions));
        let gap = JointLevers::of(block, &a, &b).gap * Plain::load(&block.shortness);
        let mut shares = [0.0; LANES];
        gap.dot(gap).sqrt().store(&mut shares);
        for (l, &share) in shares.iter().enumerate().take(block.count as usize) {
            tell([block.a[l], block.b[l]], share);
        }
    }
}

/// Levers of the joint points, and the gap between them (m).
pub(super) struct JointLevers<W> {
    pub levers: (Wide3<W>, Wide3<W>),
    pub gap: Wide3<W>,
}

impl<W: Wide> JointLevers<W> {
    #[inline(always)]
    pub fn of(block: &PointBlock, a: &WidePoses<W>, b: &WidePoses<W>) -> Self {
        let lever_a = a.rotation.rotate(Wide3::load(&block.local[0]));
        let lever_b = b.rotation.rotate(Wide3::load(&block.local[1]));
        let gap = Wide3::load(&block.offset) + (b.displacement - a.displacement) + (lever_b - lever_a);
        Self { levers: (lever_a, lever_b), gap }
    }
}

/// How far B's directions are from A's.
pub(super) struct Tilt<W> {
    /// The joint axes, in world axes; of joints that hold an axis.
    pub axes: (Wide3<W>, Wide3<W>),
    /// From A's frame to B's, in world axes, the shorter way round; of joints that hold a frame.
    pub relative: WideQuat<W>,
    /// Angle times axis (rad), and the angle over the sine in it.
    pub error: Wide3<W>,
    pub arc: W,
}

impl<W: Wide> Tilt<W> {
    #[inline(always)]
    pub fn of(block: &DirectionBlock, a: &WideQuat<W>, b: &WideQuat<W>) -> Self {
        let identity = WideQuat { v: Wide3::zero(), w: W::splat(1.0) };
        match block.holds {
            Holds::Axis | Holds::Points => {
                let axis_a = a.rotate(Wide3::load(&block.local_axis[0]));
                let axis_b = b.rotate(Wide3::load(&block.local_axis[1]));
                let across = axis_a.cross(axis_b);
                let arc = arc_between(across, axis_a.dot(axis_b));
                Self { axes: (axis_a, axis_b), relative: identity, error: across * arc, arc }
            }
            Holds::Frame => {
                let relative = b.after(&WideQuat::load(&block.rest)).after(&a.conjugate());
                let sign = W::select(W::zero().above(relative.w), W::splat(-1.0), W::splat(1.0));
                let relative = WideQuat { v: relative.v * sign, w: relative.w * sign };
                let arc = full_arc(relative.v);
                Self { axes: (Wide3::zero(), Wide3::zero()), relative, error: relative.v * arc, arc }
            }
        }
    }
}

/// Angle over sine of two unit vectors with this cross and this dot product.
#[inline(always)]
pub(super) fn arc_between<W: Wide>(cross: Wide3<W>, cosine: W) -> W {
    let sine = cross.dot(cross).sqrt();
    let acute = arc_over_sine(sine);
    let obtuse = W::splat(std::f32::consts::PI) / sine.max(W::splat(MIN_SINE)) - acute;
    W::select(W::zero().above(cosine), obtuse, acute)
}

/// Angle over the length of the vector part of a quaternion.
#[inline(always)]
pub(super) fn full_arc<W: Wide>(v: Wide3<W>) -> W {
    W::splat(2.0) * arc_over_sine(v.dot(v).sqrt())
}

#[inline(always)]
fn store_quat<W: Wide>(q: &WideQuat<W>, lanes: &mut [Lane; 4]) {
    q.v.x.store(&mut lanes[0]);
    q.v.y.store(&mut lanes[1]);
    q.v.z.store(&mut lanes[2]);
    q.w.store(&mut lanes[3]);
}
