//! Position rows of a block at the present poses.

use super::begin::{JointLevers, Tilt};
use super::{DirectionBlock, Holds, JointLanes};
use crate::lanes::wide::{Wide, Wide3};
use crate::solve::body_gather::{WidePoses, WideVelocities};
use crate::solve::joint::MOMENTUM_RETURN_LIMIT;
use crate::solve::state::{BodyMotion, BodyVelocity, MAX_PUSH_TURN};

#[inline(always)]
pub(super) fn project<W: Wide>(
    lanes: &JointLanes,
    start: usize,
    end: usize,
    velocities: &mut [BodyVelocity],
    motions: &mut [BodyMotion],
    most: f32,
) {
    for block in &lanes.points[start..end] {
        let (mut stand_a, mut stand_b) = (WidePoses::<W>::gather(&block.a, motions), WidePoses::<W>::gather(&block.b, motions));
        let (mut a, mut b) =
            (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::<W>::gather(&block.b, velocities));
        let (mut push_a, mut push_b) = (a.at_rest(), b.at_rest());
        if let Some(number) = block.directions {
            let block = &lanes.directions[number as usize];
            let torque = turn_back(block, (&stand_a, &stand_b), (&a, &b), most);
            push_a.turn(-torque);
            push_b.turn(torque);
        }
        let points = JointLevers::of(block, &stand_a, &stand_b);
        let half_gap = points.gap * W::splat(0.5);
        let (arm_a, arm_b) = (points.levers.0 + half_gap, points.levers.1 - half_gap);
        let moved = push_b.angular.cross(arm_b) - push_a.angular.cross(arm_a);
        let mass = (a.response_at(arm_a) + b.response_at(arm_b)).inverse_where_it_moves();
        let impulse = mass.mul(moved + points.gap.clamped(most)) * -W::load(&block.give.rigid);
        push_a.apply(-impulse, -arm_a.cross(impulse));
        push_b.apply(impulse, arm_b.cross(impulse));

        keep_angular_momentum((&mut a, &mut b), impulse, (push_a.angular, push_b.angular));
        stand_a.displace(push_a.linear, push_a.angular, MAX_PUSH_TURN);
        stand_b.displace(push_b.linear, push_b.angular, MAX_PUSH_TURN);
        stand_a.scatter(&block.a, motions);
        stand_b.scatter(&block.b, motions);
        a.scatter(&block.a, velocities);
        b.scatter(&block.b, velocities);
    }
}

/// The angular impulse on B that takes the error of its directions out.
#[inline(always)]
fn turn_back<W: Wide>(
    block: &DirectionBlock,
    stands: (&WidePoses<W>, &WidePoses<W>),
    (a, b): (&WideVelocities<W>, &WideVelocities<W>),
    most: f32,
) -> Wide3<W> {
    let tilt = Tilt::of(block, &stands.0.rotation, &stands.1.rotation);
    let k = a.inverse_inertia + b.inverse_inertia;
    let mass = match block.holds {
        Holds::Frame => k.inverse_where_it_moves(),
        Holds::Axis | Holds::Points => k.inverse_across(tilt.axes.0),
    };
    mass.mul(tilt.error.clamped(most)) * -W::load(&block.give.rigid)
}

/// As `keep_angular_momentum` of one pair: what moving bodies moves changes their angular momentum by is taken back.
#[inline(always)]
fn keep_angular_momentum<W: Wide>(
    (a, b): (&mut WideVelocities<W>, &mut WideVelocities<W>),
    impulse: Wide3<W>,
    (turn_a, turn_b): (Wide3<W>, Wide3<W>),
) {
    let (own_a, own_b) = (a.inverse_inertia.inverse(), b.inverse_inertia.inverse());
    // A displacement δ of a mass m at v loses m δ × v; m δ is the impulse.
    let mut lost = impulse.cross(b.linear - a.linear);
    lost = lost + turn_a.cross(own_a.mul(a.angular)) - own_a.mul(turn_a.cross(a.angular));
    lost = lost + turn_b.cross(own_b.mul(b.angular)) - own_b.mul(turn_b.cross(b.angular));
    let change = (own_a + own_b).inverse().mul(lost);
    let spin = a.angular.dot(a.angular).sqrt() + b.angular.dot(b.angular).sqrt();
    let limit = W::splat(MOMENTUM_RETURN_LIMIT) * spin;
    let (free_a, free_b) = (a.inverse_mass(), b.inverse_mass());
    let moves = free_a.x.min(free_a.y).min(free_a.z).min(free_b.x).min(free_b.y).min(free_b.z);
    let turns = own_a.trace().min(own_b.trace());
    let small = W::select(limit.above(change.length()), moves.min(turns), W::zero());
    let change = change.only(small.above(W::zero()));
    a.angular = a.angular - change;
    b.angular = b.angular - change;
}
