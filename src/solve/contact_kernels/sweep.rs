//! One sweep over the contact rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::contact::{ContactBlock, NEGLIGIBLE_FRICTION, POINTS};
use super::super::side::Side;
use super::super::state::BodyVelocity;
use super::super::wide::{Wide, Wide3};
use super::rows::{load_all, load_points, normal_rates, push_apart, solve_manifolds, store_points};

#[inline(always)]
pub(super) fn all<W: Wide>(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], backwards: bool) {
    if backwards {
        for block in blocks.iter_mut().rev() {
            visit::<W>(block, velocities);
        }
    } else {
        for block in blocks {
            visit::<W>(block, velocities);
        }
    }
}

#[inline(always)]
fn visit<W: Wide>(block: &mut ContactBlock, velocities: &mut [BodyVelocity]) {
    let (mut side_a, mut side_b) = (Side::<W>::gather(&block.a, velocities), Side::gather(&block.b, velocities));
    if block.has_rolling {
        roll(block, &mut side_a, &mut side_b);
    }
    if block.has_faces {
        rub::<W, POINTS>(block, &mut side_a, &mut side_b);
        press::<W, POINTS>(block, &mut side_a, &mut side_b);
    } else {
        rub::<W, 1>(block, &mut side_a, &mut side_b);
        press::<W, 1>(block, &mut side_a, &mut side_b);
    }
    side_a.scatter(&block.a, velocities);
    side_b.scatter(&block.b, velocities);
}

/// Two multipliers across the normal, from their old values and the slips, inside the disc of radius `limit`.
///
/// A multiplier that is nothing beside its limit, and whose square would be a denormal number, is zero.
#[inline(always)]
fn in_disc<W: Wide>(mass: [W; 3], old: [W; 2], slip: [W; 2], limit: W) -> [W; 2] {
    let [m11, m12, m22] = mass;
    let (free1, free2) = (old[0] - (m11 * slip[0] + m12 * slip[1]), old[1] - (m12 * slip[0] + m22 * slip[1]));
    let (negligible, zero) = (W::splat(NEGLIGIBLE_FRICTION) * limit, W::zero());
    let free1 = W::select(free1.abs().above(negligible), free1, zero);
    let free2 = W::select(free2.abs().above(negligible), free2, zero);
    let size = (free1 * free1 + free2 * free2).sqrt();
    let scale = W::select(size.above(limit), limit / size, W::splat(1.0));
    [free1 * scale, free2 * scale]
}

/// Tangential and twist rows of every lane.
#[inline(always)]
fn rub<W: Wide, const N: usize>(block: &mut ContactBlock, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let n = Wide3::<W>::load(&block.normal);
    let t1 = Wide3::load(&block.tangent);
    let t2 = n.cross(t1);
    let (center_a, center_b) = (Wide3::load(&block.center_a), Wide3::load(&block.center_b));
    let mut load = W::zero();
    for i in 0..N {
        load = load + W::load(&block.lambda[i]);
    }

    let slip = side_b.linear + side_b.angular.cross(center_b) - side_a.linear - side_a.angular.cross(center_a);
    let old = [W::load(&block.tangent_lambda[0]), W::load(&block.tangent_lambda[1])];
    let mass = load_all(&block.tangent_mass);
    let new = in_disc(mass, old, [slip.dot(t1), slip.dot(t2)], W::load(&block.friction) * load);
    new[0].store(&mut block.tangent_lambda[0]);
    new[1].store(&mut block.tangent_lambda[1]);
    let impulse = t1 * (new[0] - old[0]) + t2 * (new[1] - old[1]);

    // The twist sees the velocities before the tangential impulse: the two hardly couple at the centre.
    let twist_limit = W::load(&block.twist_arm) * load;
    let old_twist = W::load(&block.twist_lambda);
    let free = old_twist - W::load(&block.twist_mass) * n.dot(side_b.angular - side_a.angular);
    let new_twist = free.max(-twist_limit).min(twist_limit);
    new_twist.store(&mut block.twist_lambda);
    let moment = n * (new_twist - old_twist);

    side_a.apply(-impulse, -(center_a.cross(impulse) + moment));
    side_b.apply(impulse, center_b.cross(impulse) + moment);
}

/// Rolling rows of every lane.
#[inline(always)]
fn roll<W: Wide>(block: &mut ContactBlock, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let n = Wide3::<W>::load(&block.normal);
    let t1 = Wide3::load(&block.tangent);
    let t2 = n.cross(t1);
    let [p0, p1, p2, p3] = load_points::<W>(&block.lambda);
    let load = p0 + p1 + p2 + p3;
    let rolling = side_b.angular - side_a.angular;
    let old = [W::load(&block.rolling_lambda[0]), W::load(&block.rolling_lambda[1])];
    let mass = load_all(&block.rolling_mass);
    let new = in_disc(mass, old, [rolling.dot(t1), rolling.dot(t2)], W::load(&block.rolling_arm) * load);
    new[0].store(&mut block.rolling_lambda[0]);
    new[1].store(&mut block.rolling_lambda[1]);
    let moment = t1 * (new[0] - old[0]) + t2 * (new[1] - old[1]);
    side_a.turn(-moment);
    side_b.turn(moment);
}

/// Normal rows of every lane, each manifold as one block.
#[inline(always)]
fn press<W: Wide, const N: usize>(block: &mut ContactBlock, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let mut residual = normal_rates::<W, N>(block, side_a, side_b);
    for i in 0..N {
        residual[i] = residual[i] + W::load(&block.closing_speed[i]);
    }
    let old = load_points::<W>(&block.lambda);
    let new = solve_manifolds::<W, N>(block, residual, &old);
    push_apart::<W, N>(block, &new, &old, side_a, side_b);
    store_points::<W, N>(&new, &mut block.lambda);
    if block.has_restitution {
        let mut peak = load_points::<W>(&block.peak_lambda);
        for i in 0..N {
            peak[i] = peak[i].max(new[i]);
        }
        store_points::<W, N>(&peak, &mut block.peak_lambda);
    }
}
