//! The start of a substep: separations of now, and the carried multipliers.

use glam::Vec3;

use super::super::body_gather::WideVelocities;
use super::super::contact::{LANES, Lane3, tangents, tangents_in_lanes};
use super::super::contact_block::MaterialRows;
use super::super::contact_partition::BlockPart;
use super::super::disjoint::{DisjointMut, Slots};
use super::super::state::{BodyMotion, BodyVelocity};
use super::rows::{BlockManifolds, Faced, Single, of_block, separations};
use crate::lanes::wide::{Plain, Wide, Wide3};

#[inline(always)]
pub(super) fn all<W: Wide>(
    part: &mut BlockPart<'_>,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
    middle: f32,
) {
    for number in 0..part.blocks.len() {
        part.ask_for_next(number, false);
        let BlockPart { blocks, faces, extras, before, .. } = part;
        let block = &mut blocks[number];
        let extra = extras.get_mut(block.extra.wrapping_sub(before[1]) as usize);
        of_block!(start::<W>(block, (faces, before[0]), extra, velocities, motions, h, middle));
    }
}

#[inline(always)]
fn start<W: Wide, M: BlockManifolds>(
    of: &mut M,
    mut extra: Option<&mut MaterialRows>,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
    middle: f32,
) {
    close_in::<W, M>(of, motions, h);
    if let Some(extra) = extra.as_deref_mut() {
        lean(of, extra, velocities, middle);
    }
    if let Some(extra) = extra.as_deref_mut()
        && extra.has_restitution
    {
        note_impacts(of, extra, velocities, motions, h);
    }
    let block = of.block();
    let (mut side_a, mut side_b) =
        (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::gather(&block.b, velocities));
    let n = Wide3::load(&block.normal);
    let [t1, t2] = tangents_in_lanes(n);
    let friction = t1 * W::load(&block.tangent_lambda[0]) + t2 * W::load(&block.tangent_lambda[1]);
    let mut moment = Wide3::zero();
    if let Some(twist) = of.twist(extra.as_deref_mut()) {
        moment = n * W::load(&twist.lambda);
    }
    if let Some(extra) = extra
        && extra.has_rolling
    {
        moment = moment + t1 * W::load(&extra.rolling_lambda[0]) + t2 * W::load(&extra.rolling_lambda[1]);
    }
    let mut sum = W::zero();
    let (mut arm_a, mut arm_b) = (Wide3::zero(), Wide3::zero());
    for i in 0..M::COUNT {
        let rows = of.rows(i);
        let lambda = W::load(&rows.lambda);
        sum = sum + lambda;
        arm_a = arm_a + Wide3::load(&rows.lever_a) * lambda;
        arm_b = arm_b + Wide3::load(&rows.lever_b) * lambda;
    }
    let impulse = n * sum + friction;
    let (center_a, center_b) = of.centers::<W>();
    let torque_a = arm_a.cross(n) + center_a.cross(friction) + moment;
    let torque_b = arm_b.cross(n) + center_b.cross(friction) + moment;
    side_a.apply(-impulse, -torque_a);
    side_b.apply(impulse, torque_b);
    side_a.scatter(&of.block().a, velocities);
    side_b.scatter(&of.block().b, velocities);
}

/// Forms max(s, 0)/h from the separations of now, but nothing for points under load.
///
/// A loaded point gapes by rounding, or by a sweep that is not done. With g the error that the sweeps of a substep leave of a mode of the
/// stack, u its velocity and S its gap divided by h, a share k of the gap closed in a substep makes of the carried multipliers
///
/// ```text
/// u' = g (2 u − u₋) − (1 − g) k S,    S' = S + u',
/// ```
///
/// which grows by k/2 − (1 − g) a substep: any k lets the slow waves of a large stack grow until it falls. So the gap stays until the
/// load is off the point.
///
/// Where a point is further off than what touches, it may only have inherited its load: a manifold has turned with its body, or is that of a pose
/// to come, or a hit has taken the rebound of what was stopped above the ground. There a gap counts as closed up to λ/m h, the way by which the
/// multiplier λ alone parts the bodies within a substep, which what a sweep leaves is a share of. Beyond, the point bears nothing: taken for loaded, it
/// would hold the body up in the air for ever. In stacks of
/// thousands (`many_contacts`) gaps that touch may be greater than that, so it is not asked of these.
#[inline(always)]
pub(super) fn close_in<W: Wide, M: BlockManifolds>(of: &mut M, motions: &[BodyMotion], h: f32) {
    let separation = separations::<W, M>(of, motions);
    let inverse_h = W::splat(1.0 / h);
    let hangs = W::load(&of.block().hangs).above(W::zero());
    for (i, separation) in separation.into_iter().enumerate().take(M::COUNT) {
        let rows = of.rows_mut(i);
        let gap = separation.max(W::zero());
        let borne = W::select(hangs, gap * W::load(&rows.inverse_diagonal), W::zero());
        let is_loaded = (W::load(&rows.lambda) * W::splat(h)).above(borne);
        W::select(is_loaded, W::zero(), gap * inverse_h).store(&mut rows.closing_speed);
    }
}

/// Forms what levers on sides that turn at a given rate add to the slip in the middle of this substep, `middle` (s) after the time that
/// levers are of.
///
/// Levers are those of one moment. A turning support carries what stands on it round meanwhile: the velocity at its lever r changes by
/// ω × (v − v_A) t, with v that of the contact and v_A that of its own centre. Left out, what rests on a turntable is carried off along
/// the tangent in each step, outwards by ½ ω² dt of its radius a second. On what other bodies move the term would be a force that answers
/// to its own result.
fn lean<M: BlockManifolds>(of: &M, extra: &mut MaterialRows, velocities: &DisjointMut<'_, BodyVelocity>, middle: f32) {
    let block = of.block();
    extra.has_lean = false;
    for l in 0..LANES {
        let (a, b) = (velocities.get(block.a[l]), velocities.get(block.b[l]));
        let turns = [a, b].map(BodyVelocity::turns_as_told);
        if turns == [false; 2] {
            extra.lean.iter_mut().for_each(|lane| lane[l] = 0.0);
            continue;
        }
        let (center_a, center_b) = of.centers::<Plain>();
        let (lever_a, lever_b) = (lane_of(&center_a, l), lane_of(&center_b, l));
        let (at_a, at_b) = (a.linear + a.angular.cross(lever_a), b.linear + b.angular.cross(lever_b));
        let n = at(&block.normal, l);
        // Of the slip alone: along the normal the forces of the substep are in it that the contact will take.
        let slip = (at_b - at_a).reject_from_normalized(n);
        // The contact goes with a face of what is moved, or, where it touches at a point, as if that did not roll: a ball as its centre, the
        // corner of a box that stands on another piece too as that corner.
        let own = |side: &BodyVelocity, lever: Vec3| match M::COUNT > 1 {
            true => Vec3::ZERO,
            false => side.angular.reject_from_normalized(n).cross(lever),
        };
        // What goes with a support turns with it about the normal, and its lever too. Told by its own rate that would answer to its own result: a link
        // that a driven box winds up is thrown about by it.
        let turned = |support: &BodyVelocity, lever: Vec3| {
            let turn = n * support.angular.dot(n);
            turn.cross(turn.cross(lever))
        };
        let change_a = match turns {
            [true, _] => a.angular.cross(at_a + slip - own(b, lever_b).reject_from_normalized(n) - a.linear),
            _ => turned(b, lever_a),
        };
        let change_b = match turns {
            [_, true] => b.angular.cross(at_b - slip - own(a, lever_a).reject_from_normalized(n) - b.linear),
            _ => turned(a, lever_b),
        };
        let change = (change_b - change_a) * middle;
        let (t1, t2) = tangents(n);
        (extra.lean[0][l], extra.lean[1][l]) = (change.dot(t1), change.dot(t2));
        extra.has_lean = true;
    }
}

/// Keeps the normal velocity that a point has at the moment it touches.
///
/// A point that closes its gap within the substep touches after t = s/|v| of it; gravity has acted for t only, so the speed of
/// impact is v − g (h − t). Without this a rebound loses up to a substep's worth of gravity.
fn note_impacts<M: BlockManifolds>(
    of: &M,
    extra: &mut MaterialRows,
    velocities: &DisjointMut<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
) {
    let block = of.block();
    for l in (0..LANES).filter(|&l| extra.restitution[l] > 0.0) {
        let (a, b) = (block.a[l] as usize, block.b[l] as usize);
        let gravity = at(&block.normal, l).dot(motions[b].acceleration - motions[a].acceleration);
        for i in 0..M::COUNT {
            extra.impact_speed[i][l] = 0.0;
            let rows = of.rows(i);
            let speed = normal_speed(of, velocities, i, l);
            if rows.lambda[l] <= 0.0 && speed < 0.0 && speed + rows.closing_speed[l] < 0.0 {
                let fraction = (rows.closing_speed[l] / -speed).min(1.0);
                extra.impact_speed[i][l] = speed - gravity * h * (1.0 - fraction);
            }
        }
    }
}

/// Speed at which point `i` of lane `l` opens (m/s).
fn normal_speed<M: BlockManifolds>(of: &M, velocities: &DisjointMut<'_, BodyVelocity>, i: usize, l: usize) -> f32 {
    let (block, rows) = (of.block(), of.rows(i));
    let (a, b) = (velocities.get(block.a[l]), velocities.get(block.b[l]));
    let at_b = b.linear + b.angular.cross(at(&rows.lever_b, l));
    let at_a = a.linear + a.angular.cross(at(&rows.lever_a, l));
    at(&block.normal, l).dot(at_b - at_a)
}

/// Lane `l` of a vector.
fn at(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}

/// Lane `l` of a vector of registers.
fn lane_of<W: Wide>(lanes: &Wide3<W>, l: usize) -> Vec3 {
    let mut stored = [[0.0; LANES]; 3];
    lanes.store(&mut stored);
    at(&stored, l)
}
