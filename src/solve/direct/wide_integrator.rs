//! Integrates the bodies of an articulation, four at a time.

use glam::{DMat3, DVec3, Vec3};

use super::body::DirectBody;
use super::fours::{Quatx4, Sym3x4, Vec3x4};
use super::multistep::{SecondOrder, rotation_vector_near};
use super::stiffness;
use crate::lanes::four::{Four, Plain};
use crate::linalg::narrowing;
use crate::platform::in_fours;
use crate::solve::joint::LocalPose;
use crate::solve::joint::rows::Rate;
use crate::step_history::History;
use crate::tuning::prediction::MAX_KICK;

/// Passes in which the angular velocity at the end of a substep is found from an angular momentum.
const MOMENTUM_PASSES: usize = 2;

/// Rotation that makes no difference to the inertia of a body that has turned by it (rad).
const NEGLIGIBLE_TURN: f64 = 1.0e-9;

/// Relative gain of rotational energy beyond which a body's angular momentum is not carried into its new pose.
const MAX_GAIN: f64 = 1.0e-6;

const MAX_SPEED: f64 = crate::speed_limits::MAX_LINEAR_SPEED as f64;
const MAX_SPIN: f64 = crate::speed_limits::MAX_ANGULAR_SPEED as f64;

/// Four bodies that move, and what stays as it is for a step; where there are fewer, the first takes the places of the others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bodies4 {
    numbers: [u32; 4],
    count: usize,
    /// Principal moments of inertia (kg·m²) and rotation of the principal axes in the body.
    inertia: Vec3x4<Plain>,
    frame: Quatx4<Plain>,
    /// Whether the principal axes are those of the body, of all four.
    is_aligned: bool,
    /// 1 where a body tumbles, 0 where it is round.
    tumbling: Plain,
    /// 1 about free world axes, 0 about locked ones; and along them.
    free: Vec3x4<Plain>,
    free_along: Vec3x4<Plain>,
    /// Whether none of the four is kept from turning about an axis.
    is_unlocked: bool,
    acceleration: Vec3x4<Plain>,
    torque: Vec3x4<Plain>,
    linear_damping: Plain,
    angular_damping: Plain,
}

/// The bodies that move, four by four.
pub(super) fn gather(bodies4: &mut Vec<Bodies4>, bodies: &[DirectBody]) {
    bodies4.clear();
    let mut moving = bodies.iter().enumerate().filter(|(_, body)| body.is_dynamic()).map(|(number, _)| number as u32);
    while let Some(first) = moving.next() {
        let (mut numbers, mut count) = ([first; 4], 1);
        for (place, number) in numbers[1..].iter_mut().zip(&mut moving) {
            *place = number;
            count += 1;
        }
        bodies4.push(Bodies4::of(numbers, count, bodies));
    }
}

impl Bodies4 {
    fn of(numbers: [u32; 4], count: usize, bodies: &[DirectBody]) -> Self {
        let bodies = numbers.map(|number| &bodies[number as usize]);
        let along = |body: &DirectBody| DVec3::select(body.inverse_mass.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        Self {
            numbers,
            count,
            inertia: Vec3x4::of(bodies.map(|body| body.top.inertia)),
            frame: Quatx4::of(bodies.map(|body| body.top.frame)),
            is_aligned: bodies.iter().all(|body| body.top.frame == glam::DQuat::IDENTITY),
            tumbling: Plain(bodies.map(|body| if body.top.round { 0.0 } else { 1.0 })),
            free: Vec3x4::of(bodies.map(|body| body.top.free)),
            free_along: Vec3x4::of(bodies.map(along)),
            is_unlocked: bodies.iter().all(|body| body.top.free == DVec3::ONE),
            acceleration: Vec3x4::of(bodies.map(|body| body.acceleration)),
            torque: Vec3x4::of(bodies.map(|body| body.torque)),
            linear_damping: Plain(bodies.map(|body| body.linear_damping)),
            angular_damping: Plain(bodies.map(|body| body.angular_damping)),
        }
    }

    #[inline(always)]
    fn at(&self, j: usize) -> usize {
        self.numbers[j] as usize
    }

    #[inline(always)]
    fn places<F: Four>(&self, local_poses: &[LocalPose]) -> (Vec3x4<F>, Quatx4<F>) {
        let [a, b, c, d] =
            [&local_poses[self.at(0)], &local_poses[self.at(1)], &local_poses[self.at(2)], &local_poses[self.at(3)]];
        (Vec3x4::of([a.0, b.0, c.0, d.0]), Quatx4::of([a.1, b.1, c.1, d.1]))
    }

    #[inline(always)]
    fn velocities<F: Four>(&self, rates: &[Rate]) -> (Vec3x4<F>, Vec3x4<F>) {
        let [a, b, c, d] = [&rates[self.at(0)], &rates[self.at(1)], &rates[self.at(2)], &rates[self.at(3)]];
        (Vec3x4::of([a.linear, b.linear, c.linear, d.linear]), Vec3x4::of([a.angular, b.angular, c.angular, d.angular]))
    }

    /// Principal axes of bodies that are turned so.
    #[inline(always)]
    fn axes<F: Four>(&self, rotation: Quatx4<F>) -> Quatx4<F> {
        if self.is_aligned { rotation } else { rotation * Quatx4::load(&self.frame) }
    }

    /// Angular momentum about the centre of mass (N·m·s).
    #[inline(always)]
    fn spin<F: Four>(&self, rotation: Quatx4<F>, angular: Vec3x4<F>) -> Vec3x4<F> {
        let axes = self.axes(rotation);
        axes.rotate(axes.conjugate().rotate(angular) * Vec3x4::load(&self.inertia))
    }

    /// Angular velocity of an angular momentum about these principal axes.
    #[inline(always)]
    fn spin_of<F: Four>(&self, axes: Quatx4<F>, momentum: Vec3x4<F>) -> Vec3x4<F> {
        if self.is_unlocked {
            return axes.rotate(axes.conjugate().rotate(momentum) / Vec3x4::load(&self.inertia));
        }
        let free = Vec3x4::load(&self.free);
        axes.turn_diagonal(Vec3x4::load(&self.inertia)).held(free).times(momentum)
    }
}

/// State of an articulation's bodies at a second-order substep's start, and where it ends without joints.
pub(super) struct Start<'a> {
    pub local_poses: &'a mut [LocalPose],
    pub rates: &'a mut [Rate],
    pub predicted: &'a mut [LocalPose],
}

in_fours!(
    /// Puts bodies where their second-order substep starts, whose Euler part is `h` long (s), and finds where that ends without
    /// joints.
    pub(super) predict, self::predict_body,
    (bodies4: &[Bodies4], order: &SecondOrder, h: f64, histories: &[History], start: &mut Start)
);

in_fours!(
    /// Moves bodies from the extrapolated start of a second-order substep to its end, at rates found with the inertia of where they
    /// respond.
    pub(super) advance, self::advance_body,
    (bodies4: &[Bodies4], h: f64, bodies: &[DirectBody], local_poses: &mut [LocalPose], rates: &mut [Rate])
);

in_fours!(
    /// Adds the stiffness of forces, h·Σ [`stiffness::of_impulse`], and the damping of a substep of length `h` (s) to the inertia that
    /// answers to impulses at these poses.
    pub(super) respond, self::respond_body,
    (bodies4: &[Bodies4], h: f64, local_poses: &[LocalPose], stiffness: &[DMat3], bodies: &mut [DirectBody])
);

in_fours!(
    /// Notes a substep of length `h` (s) that ends in these stances and rates, for the next one.
    pub(super) note, self::note_body,
    (bodies4: &[Bodies4], h: f64, order: &SecondOrder, began: (&[LocalPose], &[Rate]), ended: (&[LocalPose], &[Rate]), histories: &mut [History])
);

#[inline(always)]
fn predict_body<F: Four>(bodies4: &[Bodies4], order: &SecondOrder, h: f64, histories: &[History], start: &mut Start) {
    let Start { local_poses, rates, predicted } = start;
    let (share, length, one) = (F::splat(order.extrapolation), F::splat(h), F::splat(1.0));
    let steady = F::splat(order.steady_share * h / order.euler_share);
    for quad in bodies4 {
        let last = [&histories[quad.at(0)], &histories[quad.at(1)], &histories[quad.at(2)], &histories[quad.at(3)]];
        let (place, rotation) = quad.places::<F>(local_poses);
        let (linear, angular) = quad.velocities::<F>(rates);
        let spin = quad.spin(rotation, angular);
        let (momentum_before, linear_before) =
            (of_last(last, |last| last.momentum_before), of_last(last, |last| last.linear_before));
        let (displacement, turn) = (of_last(last, |last| last.displacement), of_last(last, |last| last.turn));
        let (acceleration, torque) = (of_last(last, |last| last.acceleration), of_last(last, |last| last.torque));
        let start = (place + displacement * share + linear * steady, rotation.turned(turn * share + angular * steady));
        let momentum = spin + (spin - momentum_before) * share + torque * steady + Vec3x4::load(&quad.torque) * length;
        let slowed = one + length * F::load(&quad.angular_damping.0);
        let (mut end, mut angular) = (start.1, angular);
        for _ in 0..MOMENTUM_PASSES {
            let guess = angular;
            end = start.1.turned(guess * length);
            angular = quad.spin_of(quad.axes(end), momentum) * (one / slowed);
            let change = (angular - guess) * length;
            if !F::any(F::splat(NEGLIGIBLE_TURN * NEGLIGIBLE_TURN).below(change.dot(change))) {
                break;
            }
        }
        let linear = linear
            + (linear - linear_before) * share
            + acceleration * steady
            + Vec3x4::load(&quad.acceleration) * Vec3x4::load(&quad.free_along) * length;
        let linear = (linear * (one / (one + length * F::load(&quad.linear_damping.0)))).clamp_length(MAX_SPEED);
        let angular = angular.clamp_length(MAX_SPIN);
        let reached = start.0 + linear * length;
        let torque = Vec3x4::load(&quad.torque);
        if F::any(F::splat(0.0).below(torque.dot(torque))) {
            let before = quad.velocities::<F>(rates).1;
            let kick = ((angular - before) * length).clamp_length(MAX_KICK);
            end = start.1.turned(before * length + kick);
        }
        let (place, rotation, linear, angular) = (start.0.each(), start.1.each(), linear.each(), angular.each());
        let (reached, end) = (reached.each(), end.each());
        for j in 0..quad.count {
            let i = quad.at(j);
            local_poses[i] = (place[j], rotation[j]);
            rates[i] = Rate { linear: linear[j], angular: angular[j] };
            predicted[i] = (reached[j], end[j]);
        }
    }
}

#[inline(always)]
fn advance_body<F: Four>(bodies4: &[Bodies4], h: f64, bodies: &[DirectBody], local_poses: &mut [LocalPose], rates: &mut [Rate]) {
    let length = F::splat(h);
    for quad in bodies4 {
        let (place, rotation) = quad.places::<F>(local_poses);
        let (linear, angular) = quad.velocities::<F>(rates);
        let (linear, angular) = (linear.clamp_length(MAX_SPEED), angular.clamp_length(MAX_SPIN));
        let place = place + linear * length;
        let rotation = rotation.turned(angular * length);
        let inertia =
            [&bodies[quad.at(0)].inertia, &bodies[quad.at(1)].inertia, &bodies[quad.at(2)].inertia, &bodies[quad.at(3)].inertia];
        // The momentum is what the joints left; on a thin rod it can be a far higher speed in another pose, which is refused.
        let momentum = Sym3x4::of(inertia).times(angular);
        let carried = quad.spin_of(quad.axes(rotation), momentum);
        let is_tumbling = F::splat(0.0).below(F::load(&quad.tumbling.0));
        let carries = momentum.dot(carried).at_most(momentum.dot(angular) * F::splat(1.0 + MAX_GAIN));
        let angular = Vec3x4::select(F::both(carries, is_tumbling), carried, angular);
        let (place, rotation, linear, angular) = (place.each(), rotation.each(), linear.each(), angular.each());
        for j in 0..quad.count {
            let i = quad.at(j);
            local_poses[i] = (place[j], rotation[j]);
            rates[i] = Rate { linear: linear[j], angular: angular[j] };
        }
    }
}

#[inline(always)]
fn respond_body<F: Four>(bodies4: &[Bodies4], h: f64, local_poses: &[LocalPose], stiffness: &[DMat3], bodies: &mut [DirectBody]) {
    for quad in bodies4 {
        let (_, rotation) = quad.places::<F>(local_poses);
        let inertia = quad.axes(rotation).turn_diagonal(Vec3x4::load(&quad.inertia));
        let forces = [&stiffness[quad.at(0)], &stiffness[quad.at(1)], &stiffness[quad.at(2)], &stiffness[quad.at(3)]];
        let forces = stiffness::without_negative(Sym3x4::of(forces));
        let damped = inertia.plus(inertia, F::splat(h) * F::load(&quad.angular_damping.0));
        let whole = damped.plus(forces, F::splat(1.0));
        let inverse = if quad.is_unlocked { whole.inverse() } else { whole.held(Vec3x4::load(&quad.free)) };
        let (inertia, inverse) = (inertia.each(), inverse.each());
        for j in 0..quad.count {
            let body = &mut bodies[quad.at(j)];
            body.inertia = inertia[j];
            body.inverse_inertia = inverse[j];
        }
    }
}

#[inline(always)]
fn note_body<F: Four>(
    bodies4: &[Bodies4],
    h: f64,
    order: &SecondOrder,
    (start, start_rates): (&[LocalPose], &[Rate]),
    (local_poses, rates): (&[LocalPose], &[Rate]),
    histories: &mut [History],
) {
    let share = F::splat(order.extrapolation);
    let steady = F::splat(order.steady_share * h);
    let inverse = F::splat(1.0 / (order.euler_share * h));
    for quad in bodies4 {
        let (from, before) = quad.places::<F>(start);
        let (to, after) = quad.places::<F>(local_poses);
        let (linear_before, angular_before) = quad.velocities::<F>(start_rates);
        let (linear, angular) = quad.velocities::<F>(rates);
        let momentum = quad.spin(before, angular_before);
        let last = [&histories[quad.at(0)], &histories[quad.at(1)], &histories[quad.at(2)], &histories[quad.at(3)]];
        let (linear_last, momentum_last) = (of_last(last, |last| last.linear_before), of_last(last, |last| last.momentum_before));
        let extrapolated = (linear_before - linear_last) * share + of_last(last, |last| last.acceleration) * steady;
        let acceleration = (linear - linear_before - extrapolated) * inverse;
        let extrapolated = (momentum - momentum_last) * share + of_last(last, |last| last.torque) * steady;
        let torque = (quad.spin(after, angular) - momentum - extrapolated) * inverse;
        let displacement = to - from;
        let change = after * before.conjugate();
        let (turn, is_small) = change.small_vector();
        let (is_small, turn, change) = (F::truths(is_small), turn.each(), change.each());
        let (displacement, momentum) = (displacement.each(), momentum.each());
        let (acceleration, torque) = (acceleration.each(), torque.each());
        let (linear_before, linear, angular) = (linear_before.each(), linear.each(), angular.each());
        for j in 0..quad.count {
            let turn = if is_small[j] { turn[j] } else { rotation_vector_near(change[j], angular[j] * h) };
            histories[quad.at(j)] = History {
                h: h as f32,
                substeps: 0,
                swept_for: 0.0,
                displacement: narrowing::way(displacement[j]),
                turn: narrowing::way(turn),
                spin_turn: 0.0,
                linear_before: narrowing::speed(linear_before[j]),
                momentum_before: narrowing::impulse(momentum[j]),
                acceleration: narrowing::impulse(acceleration[j]),
                torque: narrowing::impulse(torque[j]),
                pushed: histories[quad.at(j)].pushed,
                jerk: if order.ratio > 0.0 { histories[quad.at(j)].jerk } else { Vec3::ZERO },
                linear: narrowing::speed(linear[j]),
                angular: narrowing::speed(angular[j]),
            };
        }
    }
}

/// What each of four bodies was told of its last substep.
#[inline(always)]
fn of_last<F: Four>(last: [&History; 4], of: fn(&History) -> Vec3) -> Vec3x4<F> {
    Vec3x4::widened(last.map(of))
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, Quat};

    use super::*;
    use crate::platform::with_baseline;
    use crate::solve::rotation::rotated;
    use crate::solve::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};

    /// Five bodies, two of them round or with a locked axis, so that the last of two fours is alone.
    struct Five {
        bodies: Vec<DirectBody>,
        bodies4: Vec<Bodies4>,
        local_poses: Vec<LocalPose>,
        rates: Vec<Rate>,
        stiffness: Vec<DMat3>,
        histories: Vec<History>,
    }

    fn five() -> Five {
        let mut state = 5_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut draw = || DVec3::new(next(), next(), next());
        let body = |i: u32| {
            let velocity = BodyVelocity::new(Vec3::splat(0.5), Symmetric::from_mat3(glam::Mat3::IDENTITY));
            let motion = BodyMotion {
                kind: if i == 2 { MotionKind::Round } else { MotionKind::Tumbling },
                inertia: if i == 2 { Vec3::ONE } else { Vec3::new(1.0, 2.0, 2.5) },
                inertia_frame: Quat::from_rotation_y(0.1 * i as f32),
                acceleration: Vec3::new(0.0, -9.0, 0.0),
                angular_damping: 0.1,
                ..BodyMotion::FIXED
            };
            let mut body = DirectBody::new(i, &velocity, &motion);
            if i == 3 {
                body.top.free = DVec3::new(1.0, 0.0, 1.0);
            }
            body
        };
        let local_poses = (0..5).map(|_| (draw(), rotated(DQuat::IDENTITY, draw()))).collect();
        let rates = (0..5).map(|_| Rate { linear: draw(), angular: draw() }).collect();
        let stiffness = (0..5).map(|_| stiffness::of_impulse(draw(), draw())).collect();
        let histories = (0..5).map(|_| History { h: 0.01, turn: draw().as_vec3() * 0.02, ..History::NONE }).collect();
        let (bodies, mut bodies4): (Vec<_>, _) = ((0..5).map(body).collect(), Vec::new());
        gather(&mut bodies4, &bodies);
        Five { bodies, bodies4, local_poses, rates, stiffness, histories }
    }

    #[test]
    fn bodies_answer_with_the_inverse_of_inertia_and_stiffness() {
        let Five { mut bodies, bodies4, local_poses, stiffness, .. } = five();
        respond(&bodies4, 0.0, &local_poses, &stiffness, &mut bodies);
        for (i, body) in bodies.iter().enumerate() {
            assert!((body.inertia - body.inertia_at(&local_poses[i])).abs_diff_eq(DMat3::ZERO, 1e-14), "inertia of body {i}");
            let answer = body.inverse_inertia.inverse() - body.inertia;
            let added = answer - stiffness[i];
            let shift = added.x_axis.x;
            if i == 3 {
                assert_eq!(body.inverse_inertia.y_axis, DVec3::ZERO, "a locked axis answers");
            } else {
                assert!(
                    shift > -1e-12 && added.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(shift)), 1e-12),
                    "body {i}: {added}"
                );
            }
        }
    }

    #[test]
    fn four_bodies_turn_as_one_does() {
        let Five { bodies4, local_poses, rates, .. } = five();
        for quad in &bodies4 {
            let (_, rotation) = quad.places::<Plain>(&local_poses);
            let (_, angular) = quad.velocities::<Plain>(&rates);
            for size in [1.0, 1e-3] {
                let turned = rotation.turned(angular * Plain::splat(size));
                let (vector, is_small) = (turned * rotation.conjugate()).small_vector();
                let (turned, vector) = (turned.each(), vector.each());
                for (j, is_small) in is_small.into_iter().enumerate().take(quad.count) {
                    let i = quad.at(j);
                    let alone = rotated(local_poses[i].1, rates[i].angular * size);
                    assert!(turned[j].abs_diff_eq(alone, 1e-15), "{} instead of {alone}", turned[j]);
                    assert_eq!(is_small, size < 1.0);
                    let off = (vector[j] - rates[i].angular * size).length();
                    assert!(!is_small || off < 1e-14, "a rotation vector is off by {off:e}");
                }
            }
        }
    }

    #[test]
    fn wide_registers_give_the_same_bits() {
        let run = || {
            let Five { mut bodies, bodies4, mut local_poses, mut rates, stiffness, mut histories } = five();
            let (start, start_rates) = (local_poses.clone(), rates.clone());
            let mut predicted = local_poses.clone();
            let order = SecondOrder::new(0.01, 0.01).expect("the ratio is one");
            let mut moved = Start { local_poses: &mut local_poses, rates: &mut rates, predicted: &mut predicted };
            predict(&bodies4, &order, 0.007, &histories, &mut moved);
            respond(&bodies4, 0.007, &predicted, &stiffness, &mut bodies);
            advance(&bodies4, 0.007, &bodies, &mut local_poses, &mut rates);
            note(&bodies4, 0.01, &order, (&start, &start_rates), (&local_poses, &rates), &mut histories);
            (local_poses, histories)
        };
        assert_eq!(run(), with_baseline(run));
    }
}
