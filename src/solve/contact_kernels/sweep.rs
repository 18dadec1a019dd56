//! One sweep over the contact rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::body_gather::WideVelocities;
use super::super::contact::{NEGLIGIBLE_FRICTION, tangents_in_lanes};
use super::super::contact_block::MaterialRows;
use super::super::contact_partition::BlockPart;
use super::super::disjoint::DisjointMut;
use super::super::state::{BodyMotion, BodyVelocity};
use super::rows::{
    BlockManifolds, Faced, PerPoint, Single, lambdas, load_all, normal_rates, of_block, push_apart, store_lambdas,
};
use super::warm_start::close_in;
use crate::lanes::wide::{Wide, Wide3};

#[inline(always)]
pub(super) fn all<W: Wide>(
    part: &mut BlockPart<'_>,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    backwards: bool,
    presses_last: bool,
) {
    let last = part.blocks.len().wrapping_sub(1);
    for place in 0..part.blocks.len() {
        let number = if backwards { last - place } else { place };
        part.ask_for_next(number, backwards);
        let BlockPart { blocks, faces, extras, before, .. } = part;
        let block = &mut blocks[number];
        let extra = extras.get_mut(block.extra.wrapping_sub(before[1]) as usize);
        of_block!(visit::<W>(block, (faces, before[0]), extra, velocities, presses_last));
    }
}

#[inline(always)]
pub(super) fn anew<W: Wide>(
    part: &mut BlockPart<'_>,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
    presses_last: bool,
) {
    for number in 0..part.blocks.len() {
        part.ask_for_next(number, false);
        let BlockPart { blocks, faces, before, .. } = part;
        let block = &mut blocks[number];
        of_block!(close_in_and_visit::<W>(block, (faces, before[0]), velocities, motions, h, presses_last));
    }
}

#[inline(always)]
fn close_in_and_visit<W: Wide, M: BlockManifolds>(
    of: &mut M,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    motions: &[BodyMotion],
    h: f32,
    presses_last: bool,
) {
    close_in::<W, M>(of, motions, h);
    visit::<W, M>(of, None, velocities, presses_last);
}

/// Solves the rows of each manifold of a block: rolling, friction, then the normal rows, or in the opposite order. What is solved last holds
/// best, and that should be that nothing overlaps. Where the normal rows of a face let go of load that friction counted on, friction is shortened
/// to what is left and they are solved once more: a body that slid from piece to piece of a floor was slowed by up to 12 % more than µ of its
/// weight. Of one point it is left: a marble that rolls over facets lost 5 % of its energy to it (`tests/bowls.rs`).
///
/// A sweep back is the exact reverse of a sweep forth only if it also goes through the rows of each manifold backwards. With the same
/// order on both ways the two are no symmetric operator, and carried multipliers let slow waves of load grow in large stacks.
#[inline(always)]
fn visit<W: Wide, M: BlockManifolds>(
    of: &mut M,
    mut extra: Option<&mut MaterialRows>,
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    presses_last: bool,
) {
    let (a, b) = (&of.block().a, &of.block().b);
    let (mut side_a, mut side_b) = (WideVelocities::<W>::gather(a, velocities), WideVelocities::gather(b, velocities));
    if !presses_last {
        press(of, &mut side_a, &mut side_b);
        rub(of, extra.as_deref_mut(), &mut side_a, &mut side_b);
    }
    if let Some(extra) = extra.as_deref_mut()
        && extra.has_rolling
    {
        roll(of, extra, &mut side_a, &mut side_b);
    }
    if presses_last {
        rub(of, extra, &mut side_a, &mut side_b);
        // A loop, not a second call, which would be half as much code again.
        let mut before = None;
        loop {
            press(of, &mut side_a, &mut side_b);
            if let Some(before) = before {
                keep_others(of, &before, &mut side_a, &mut side_b);
                break;
            }
            before = if M::COUNT > 1 { shorten(of, &mut side_a, &mut side_b) } else { None };
            if before.is_none() {
                break;
            }
        }
    }
    side_a.scatter(&of.block().a, velocities);
    side_b.scatter(&of.block().b, velocities);
}

/// Two multipliers across the normal, from their old values and the slips, inside the disc of radius `limit`.
///
/// What would stop the slip is taken if the disc holds it. Where it does not, the multipliers step against the slip by the lesser
/// eigenvalue of `mass` and are shortened to the disc: that lowers the energy of the two rows, and stays where it is only if the
/// multipliers point exactly against the slip. Were what would stop it shortened instead, they would point along `mass`·slip, and what
/// slides would be turned by its own shape. Where bodies are free along one line only, `mass` is of rank one and `mass`·slip lies along
/// that line: there it is shortened as it is, as the lesser eigenvalue would be zero.
///
/// A multiplier that is nothing beside its limit, and whose square would be a denormal number, is zero.
#[inline(always)]
fn in_disc<W: Wide>(mass: [W; 3], old: [W; 2], slip: [W; 2], limit: W) -> [W; 2] {
    let [m11, m12, m22] = mass;
    let (negligible, zero) = (W::splat(NEGLIGIBLE_FRICTION) * limit, W::zero());
    let mut new = [
        settled(old[0] - (m11 * slip[0] + m12 * slip[1]), negligible),
        settled(old[1] - (m12 * slip[0] + m22 * slip[1]), negligible),
    ];
    let slides = (new[0] * new[0] + new[1] * new[1]).sqrt().above(limit);
    if W::any(slides) {
        let (half, one) = (W::splat(0.5), W::splat(1.0));
        let (mean, apart) = ((m11 + m22) * half, (m11 - m22) * half);
        let greatest = mean + (apart * apart + m12 * m12).sqrt();
        let determinant = m11 * m22 - m12 * m12;
        // As a quotient: the difference of two numbers that are almost equal would be rounding.
        let least = W::select(greatest.above(zero), determinant.max(zero) / greatest, zero);
        // The entries are rounded, each by half an epsilon.
        let has_two_ways = determinant.above(W::splat(4.0 * f32::EPSILON) * m11 * m22);
        let stepped = [
            W::select(has_two_ways, settled(old[0] - least * slip[0], negligible), new[0]),
            W::select(has_two_ways, settled(old[1] - least * slip[1], negligible), new[1]),
        ];
        let size = (stepped[0] * stepped[0] + stepped[1] * stepped[1]).sqrt();
        let scale = W::select(size.above(limit), limit / size, one);
        // What sticks keeps its bits, whatever else is in the block.
        new = [W::select(slides, stepped[0] * scale, new[0]), W::select(slides, stepped[1] * scale, new[1])];
    }
    new
}

/// A multiplier, or zero where it is negligible. A function, as `map` over an array is not compiled for the processor that the kernel is for.
#[inline(always)]
fn settled<W: Wide>(multiplier: W, negligible: W) -> W {
    W::select(multiplier.abs().above(negligible), multiplier, W::zero())
}

/// Tangential and twist rows of every lane.
#[inline(always)]
fn rub<W: Wide, M: BlockManifolds>(
    of: &mut M,
    mut extra: Option<&mut MaterialRows>,
    side_a: &mut WideVelocities<W>,
    side_b: &mut WideVelocities<W>,
) {
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
    let mut slip = [slip.dot(t1), slip.dot(t2)];
    if let Some(extra) = extra.as_deref_mut()
        && extra.has_lean
    {
        slip = [slip[0] + W::load(&extra.lean[0]), slip[1] + W::load(&extra.lean[1])];
    }
    let new = in_disc(mass, old, slip, W::load(&block.friction) * load);
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

/// Share of the square of friction that it may be beyond its disc, half as much of itself. At zero rounding alone has rows solved again; 0.5 % of
/// friction is less than a stop may be off (`tests/flush_floors.rs`).
const LET_GO: f32 = 1.0e-2;

/// Lanes whose friction has been shortened, and what all were like before.
#[derive(Clone, Copy)]
struct Shortened<W: Wide> {
    lanes: W::Mask,
    lambdas: PerPoint<W>,
    /// Linear and angular velocities of both sides.
    velocities: [[Wide3<W>; 2]; 2],
}

/// Shortens the tangential multipliers to the disc of what presses by now: normal rows solved after them may have let go of load.
#[inline(always)]
fn shorten<W: Wide, M: BlockManifolds>(
    of: &mut M,
    side_a: &mut WideVelocities<W>,
    side_b: &mut WideVelocities<W>,
) -> Option<Shortened<W>> {
    let lambdas = lambdas::<W, M>(of);
    let mut load = W::zero();
    for i in 0..M::COUNT {
        load = load + lambdas[i];
    }
    let block = of.block_mut();
    let old = [W::load(&block.tangent_lambda[0]), W::load(&block.tangent_lambda[1])];
    let limit = W::load(&block.friction) * load;
    let squared = old[0] * old[0] + old[1] * old[1];
    let lanes = (squared * W::splat(1.0 - LET_GO)).above(limit * limit);
    if !W::any(lanes) {
        return None;
    }
    let before = Shortened { lanes, lambdas, velocities: [[side_a.linear, side_a.angular], [side_b.linear, side_b.angular]] };
    let scale = W::select(lanes, limit / squared.sqrt(), W::splat(1.0));
    let new = [old[0] * scale, old[1] * scale];
    new[0].store(&mut block.tangent_lambda[0]);
    new[1].store(&mut block.tangent_lambda[1]);
    let [t1, t2] = tangents_in_lanes(Wide3::<W>::load(&block.normal));
    let impulse = t1 * (new[0] - old[0]) + t2 * (new[1] - old[1]);
    let (center_a, center_b) = of.centers::<W>();
    side_a.apply(-impulse, -center_a.cross(impulse));
    side_b.apply(impulse, center_b.cross(impulse));
    Some(before)
}

/// Gives lanes whose friction has not been shortened back what they had: no manifold's bits depend on the others of its block.
#[inline(always)]
fn keep_others<W: Wide, M: BlockManifolds>(
    of: &mut M,
    before: &Shortened<W>,
    side_a: &mut WideVelocities<W>,
    side_b: &mut WideVelocities<W>,
) {
    let mut lambdas = lambdas::<W, M>(of);
    for i in 0..M::COUNT {
        lambdas[i] = W::select(before.lanes, lambdas[i], before.lambdas[i]);
    }
    store_lambdas::<W, M>(&lambdas, of);
    for (side, [linear, angular]) in [side_a, side_b].into_iter().zip(before.velocities) {
        side.linear = Wide3::select(before.lanes, side.linear, linear);
        side.angular = Wide3::select(before.lanes, side.angular, angular);
    }
}

/// Rolling rows of every lane.
#[inline(always)]
fn roll<W: Wide, M: BlockManifolds>(
    of: &M,
    extra: &mut MaterialRows,
    side_a: &mut WideVelocities<W>,
    side_b: &mut WideVelocities<W>,
) {
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
fn press<W: Wide, M: BlockManifolds>(of: &mut M, side_a: &mut WideVelocities<W>, side_b: &mut WideVelocities<W>) {
    let mut residual = normal_rates::<W, M>(of, side_a, side_b);
    for i in 0..M::COUNT {
        residual[i] = residual[i] + W::load(&of.rows(i).closing_speed);
    }
    let old = lambdas::<W, M>(of);
    let new = of.solve(residual, &old);
    push_apart::<W, M>(of, &new, &old, side_a, side_b);
    store_lambdas::<W, M>(&new, of);
}
