//! The start of a substep: separations of now, and the carried multipliers.

use glam::Vec3;

use super::super::contact::{ContactBlock, LANES, Lane3, POINTS};
use super::super::side::Side;
use super::super::state::{BodyMotion, BodyVelocity};
use super::super::wide::{Wide, Wide3};
use super::rows::{load_points, separations, store_points};

/// Share of a gap that a point under load may close in one substep.
///
/// A loaded point gapes by rounding or by an unfinished sweep. If it may close whole in one substep, the impulse that stops it is
/// carried on, opens the next gap, and waves of load grow in a tower until it falls.
const PRESSED_GAP_SHARE: f32 = 0.01;

#[inline(always)]
pub(super) fn all<W: Wide>(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
    for block in blocks {
        if block.has_faces {
            start::<W, POINTS>(block, velocities, motions, h);
        } else {
            start::<W, 1>(block, velocities, motions, h);
        }
    }
}

#[inline(always)]
fn start<W: Wide, const N: usize>(block: &mut ContactBlock, velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
    close_in::<W, N>(block, motions, h);
    if block.has_restitution {
        note_impacts(block, velocities, motions, h);
    }
    let (mut side_a, mut side_b) = (Side::<W>::gather(&block.a, velocities), Side::gather(&block.b, velocities));
    let n = Wide3::load(&block.normal);
    let t1 = Wide3::load(&block.tangent);
    let t2 = n.cross(t1);
    let friction = t1 * W::load(&block.tangent_lambda[0]) + t2 * W::load(&block.tangent_lambda[1]);
    let mut moment = n * W::load(&block.twist_lambda);
    if block.has_rolling {
        moment = moment + t1 * W::load(&block.rolling_lambda[0]) + t2 * W::load(&block.rolling_lambda[1]);
    }
    let mut sum = W::zero();
    let (mut arm_a, mut arm_b) = (Wide3::zero(), Wide3::zero());
    for i in 0..N {
        let lambda = W::load(&block.lambda[i]);
        sum = sum + lambda;
        arm_a = arm_a + Wide3::load(&block.lever_a[i]) * lambda;
        arm_b = arm_b + Wide3::load(&block.lever_b[i]) * lambda;
    }
    let impulse = n * sum + friction;
    let torque_a = arm_a.cross(n) + Wide3::load(&block.center_a).cross(friction) + moment;
    let torque_b = arm_b.cross(n) + Wide3::load(&block.center_b).cross(friction) + moment;
    side_a.apply(-impulse, -torque_a);
    side_b.apply(impulse, torque_b);
    side_a.scatter(&block.a, velocities);
    side_b.scatter(&block.b, velocities);
}

/// Forms max(s, 0)/h from the separations of now.
#[inline(always)]
fn close_in<W: Wide, const N: usize>(block: &mut ContactBlock, motions: &[BodyMotion], h: f32) {
    let separation = separations::<W, N>(block, motions);
    let lambda = load_points::<W>(&block.lambda);
    let inverse_h = W::splat(1.0 / h);
    let mut closing = [W::zero(); POINTS];
    for i in 0..N {
        let share = W::select(lambda[i].above(W::zero()), W::splat(PRESSED_GAP_SHARE), W::splat(1.0));
        closing[i] = separation[i].max(W::zero()) * (share * inverse_h);
    }
    store_points::<W, N>(&closing, &mut block.closing_speed);
}

/// Keeps the normal velocity that a point has at the moment it touches.
///
/// A point that closes its gap within the substep touches after t = s/|v| of it; gravity has acted for t only, so the speed of
/// impact is v − g (h − t). Without this a rebound loses up to a substep's worth of gravity.
fn note_impacts(block: &mut ContactBlock, velocities: &[BodyVelocity], motions: &[BodyMotion], h: f32) {
    for l in 0..LANES {
        if block.restitution[l] <= 0.0 {
            continue;
        }
        let (a, b) = (block.a[l] as usize, block.b[l] as usize);
        let n = at(&block.normal, l);
        let gravity = n.dot(motions[b].acceleration - motions[a].acceleration);
        for i in 0..POINTS {
            if block.impact_speed[i][l] != 0.0 || block.lambda[i][l] > 0.0 {
                continue;
            }
            let at_b = velocities[b].linear + velocities[b].angular.cross(at(&block.lever_b[i], l));
            let at_a = velocities[a].linear + velocities[a].angular.cross(at(&block.lever_a[i], l));
            let speed = n.dot(at_b - at_a);
            if speed < 0.0 && speed + block.closing_speed[i][l] < 0.0 {
                let fraction = (block.closing_speed[i][l] / -speed).min(1.0);
                block.impact_speed[i][l] = speed - gravity * h * (1.0 - fraction);
            }
        }
    }
}

/// Lane `l` of a vector.
fn at(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}
