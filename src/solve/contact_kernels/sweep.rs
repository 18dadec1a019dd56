//! One sweep over the contact rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::contact::{NEGLIGIBLE_FRICTION, tangents_in_lanes};
use super::super::contact_block::Extra;
use super::super::contact_pieces::BlockPart;
use super::super::shared::Hand;
use super::super::side::Side;
use super::super::state::{BodyMotion, BodyVelocity};
use super::super::wide::{Wide, Wide3};
use super::rows::{Faced, Manifolds, Single, lambdas, load_all, normal_rates, of_block, push_apart, store_lambdas};
use super::warm_start::close_in;

#[inline(always)]
pub(super) fn all<W: Wide>(part: &mut BlockPart<'_>, velocities: &mut Hand<'_, BodyVelocity>, backwards: bool) {
    let last = part.blocks.len().wrapping_sub(1);
    for place in 0..part.blocks.len() {
        let number = if backwards { last - place } else { place };
        part.ask_for_next(number, backwards);
        let BlockPart { blocks, faces, extras, before, .. } = part;
        let block = &mut blocks[number];
        let extra = extras.get_mut(block.extra.wrapping_sub(before[1]) as usize);
        of_block!(visit::<W>(block, (faces, before[0]), extra, velocities));
    }
}

#[inline(always)]
pub(super) fn anew<W: Wide>(part: &mut BlockPart<'_>, velocities: &mut Hand<'_, BodyVelocity>, motions: &[BodyMotion], h: f32) {
    for number in 0..part.blocks.len() {
        part.ask_for_next(number, false);
        let BlockPart { blocks, faces, before, .. } = part;
        let block = &mut blocks[number];
        of_block!(close_in_and_visit::<W>(block, (faces, before[0]), velocities, motions, h));
    }
}

#[inline(always)]
fn close_in_and_visit<W: Wide, M: Manifolds>(
    of: &mut M,
    velocities: &mut Hand<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
) {
    close_in::<W, M>(of, motions, h);
    visit::<W, M>(of, None, velocities);
}

#[inline(always)]
fn visit<W: Wide, M: Manifolds>(of: &mut M, mut extra: Option<&mut Extra>, velocities: &mut Hand<'_, BodyVelocity>) {
    let (a, b) = (&of.block().a, &of.block().b);
    let (mut side_a, mut side_b) = (Side::<W>::gather(a, velocities), Side::gather(b, velocities));
    if let Some(extra) = extra.as_deref_mut()
        && extra.has_rolling
    {
        roll(of, extra, &mut side_a, &mut side_b);
    }
    rub(of, extra, &mut side_a, &mut side_b);
    press(of, &mut side_a, &mut side_b);
    side_a.scatter(&of.block().a, velocities);
    side_b.scatter(&of.block().b, velocities);
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
fn rub<W: Wide, M: Manifolds>(of: &mut M, extra: Option<&mut Extra>, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let (center_a, center_b) = of.centers::<W>();
    let mut load = W::zero();
    for i in 0..M::COUNT {
        load = load + W::load(&of.rows(i).lambda);
    }
    let block = of.block_mut();
    let n = Wide3::<W>::load(&block.normal);
    let [t1, t2] = tangents_in_lanes(n);

    let slip = side_b.linear + side_b.angular.cross(center_b) - side_a.linear - side_a.angular.cross(center_a);
    let old = [W::load(&block.tangent_lambda[0]), W::load(&block.tangent_lambda[1])];
    let mass = load_all(&block.tangent_mass);
    let new = in_disc(mass, old, [slip.dot(t1), slip.dot(t2)], W::load(&block.friction) * load);
    new[0].store(&mut block.tangent_lambda[0]);
    new[1].store(&mut block.tangent_lambda[1]);
    let impulse = t1 * (new[0] - old[0]) + t2 * (new[1] - old[1]);

    let (mut torque_a, mut torque_b) = (center_a.cross(impulse), center_b.cross(impulse));

    // The twist sees the velocities before the tangential impulse: the two hardly couple at the centre.
    if let Some(twist) = of.twist(extra) {
        let limit = W::load(&twist.arm) * load;
        let old = W::load(&twist.lambda);
        let free = old - W::load(&twist.mass) * n.dot(side_b.angular - side_a.angular);
        let new = free.max(-limit).min(limit);
        new.store(&mut twist.lambda);
        let moment = n * (new - old);
        (torque_a, torque_b) = (torque_a + moment, torque_b + moment);
    }
    side_a.apply(-impulse, -torque_a);
    side_b.apply(impulse, torque_b);
}

/// Rolling rows of every lane.
#[inline(always)]
fn roll<W: Wide, M: Manifolds>(of: &M, extra: &mut Extra, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let [t1, t2] = tangents_in_lanes(Wide3::<W>::load(&of.block().normal));
    let [p0, p1, p2, p3] = lambdas::<W, M>(of);
    let load = p0 + p1 + p2 + p3;
    let rolling = side_b.angular - side_a.angular;
    let old = [W::load(&extra.rolling_lambda[0]), W::load(&extra.rolling_lambda[1])];
    let mass = load_all(&extra.rolling_mass);
    let new = in_disc(mass, old, [rolling.dot(t1), rolling.dot(t2)], W::load(&extra.rolling_arm) * load);
    new[0].store(&mut extra.rolling_lambda[0]);
    new[1].store(&mut extra.rolling_lambda[1]);
    let moment = t1 * (new[0] - old[0]) + t2 * (new[1] - old[1]);
    side_a.turn(-moment);
    side_b.turn(moment);
}

/// Normal rows of every lane, each manifold as one block.
#[inline(always)]
fn press<W: Wide, M: Manifolds>(of: &mut M, side_a: &mut Side<W>, side_b: &mut Side<W>) {
    let mut residual = normal_rates::<W, M>(of, side_a, side_b);
    for i in 0..M::COUNT {
        residual[i] = residual[i] + W::load(&of.rows(i).closing_speed);
    }
    let old = lambdas::<W, M>(of);
    let new = of.solve(residual, &old);
    push_apart::<W, M>(of, &new, &old, side_a, side_b);
    store_lambdas::<W, M>(&new, of);
}
