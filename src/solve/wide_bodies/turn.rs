//! Torque-free rotation of eight bodies through a substep.

use super::PoseBlock;
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::integrate::NEGLIGIBLE_TUMBLE;
use crate::solve::rotation::MAX_ENERGY_GAIN;
use crate::solve::wide_matrix::WideQuat;

/// What a substep does to the rotation of eight bodies, in world axes.
pub(super) struct WideRotation<W> {
    /// What turns the body.
    pub turn: WideQuat<W>,
    /// What the mean and the last angular velocity differ from the first one by (rad/s).
    pub mean_change: Wide3<W>,
    pub change: Wide3<W>,
    /// 1 where the rule gains energy.
    pub gains: W,
}

/// A body seen from its principal axes at the substep's start.
struct Spin<W> {
    velocity: Wide3<W>,
    momentum: Wide3<W>,
    inertia: Wide3<W>,
}

impl<W: Wide> Spin<W> {
    /// What angular velocity differs by from the first one where the body has been turned by `turned`.
    #[inline(always)]
    fn change_at(&self, turned: &WideQuat<W>) -> Wide3<W> {
        let d = turned.conjugate().way_of(self.momentum);
        let e = Wide3::new(d.x / self.inertia.x, d.y / self.inertia.y, d.z / self.inertia.z);
        e + turned.way_of(self.velocity + e)
    }
}

/// The midpoint rule in one piece, or in two where a substep turns a body by more than `split` (rad).
#[inline(always)]
pub(super) fn turn<W: Wide>(block: &PoseBlock, rotation: &WideQuat<W>, angular: Wide3<W>, h: f32, split: f32) -> WideRotation<W> {
    let (zero, one) = (W::zero(), W::splat(1.0));
    let way = angular.length() * W::splat(h);
    let plain = turned_by(angular * W::splat(h));
    let tumbles = W::select(way.above(W::splat(NEGLIGIBLE_TUMBLE)), W::load(&block.tumbles), zero);
    if !W::any(tumbles.above(zero)) {
        return WideRotation { turn: plain, mean_change: Wide3::zero(), change: Wide3::zero(), gains: zero };
    }
    let frame = rotation.after(&WideQuat::load(&block.frame));
    // What does not tumble rests here: powers of its velocity would be subnormal.
    let does = tumbles.above(zero);
    let velocity = frame.conjugate().rotate(angular.only(does));
    let inertia = Wide3::load(&block.inertia);
    let spin = Spin { velocity, momentum: inertia.scale(velocity), inertia };
    let is_long = way.above(W::splat(split));
    let piece = W::select(is_long, W::splat(0.5 * h), W::splat(h));
    let half = piece * W::splat(0.5);

    let mut mean = spin.change_at(&turned_by(velocity * half));
    let mut turned = turned_by((velocity + mean) * piece);
    let mut change = spin.change_at(&turned);
    if W::any(is_long) {
        let middle = spin.change_at(&turned_by((velocity + change) * half).after(&turned));
        let second = turned_by((velocity + middle) * piece).after(&turned);
        let end = spin.change_at(&second);
        mean = choose(is_long, (mean + middle) * W::splat(0.5), mean);
        change = choose(is_long, end, change);
        turned = WideQuat { v: choose(is_long, second.v, turned.v), w: W::select(is_long, second.w, turned.w) };
    }
    let gain = spin.momentum.dot(change);
    let most = W::splat(MAX_ENERGY_GAIN as f32) * spin.momentum.dot(velocity);
    WideRotation {
        turn: WideQuat { v: choose(does, frame.rotate(turned.v), plain.v), w: W::select(does, turned.w, plain.w) },
        mean_change: frame.rotate(mean).only(does),
        change: frame.rotate(change).only(does),
        gains: W::select(does, W::select(gain.above(most), one, zero), zero),
    }
}

#[inline(always)]
fn choose<W: Wide>(mask: W::Mask, then: Wide3<W>, other: Wide3<W>) -> Wide3<W> {
    Wide3::new(W::select(mask, then.x, other.x), W::select(mask, then.y, other.y), W::select(mask, then.z, other.z))
}

/// The rotation by a rotation vector of at most [`MAX_TURN`](crate::solve::rotation::MAX_TURN), by power series.
#[inline(always)]
fn turned_by<W: Wide>(vector: Wide3<W>) -> WideQuat<W> {
    let one = W::splat(1.0);
    let half = vector * W::splat(0.5);
    let x = half.dot(half);
    let sine = one - x * W::splat(1.0 / 42.0) * (one - x * W::splat(1.0 / 72.0));
    let sine = one - x * W::splat(1.0 / 6.0) * (one - x * W::splat(1.0 / 20.0) * sine);
    let cosine = one - x * W::splat(1.0 / 30.0) * (one - x * W::splat(1.0 / 56.0) * (one - x * W::splat(1.0 / 90.0)));
    let cosine = one - x * W::splat(0.5) * (one - x * W::splat(1.0 / 12.0) * cosine);
    WideQuat { v: half * sine, w: cosine }
}
