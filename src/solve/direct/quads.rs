//! What a substep does to each body by itself, to four of them at a time.

use glam::{DMat3, DVec3, Vec3};

use super::articulation::Began;
use super::body::DirectBody;
use super::fours::{Four, Four3, FourSymmetric, FourTurns, Mask, any, both};
use super::history::{History, SecondOrder, rotation_vector};
use super::stiffness;
use crate::solve::dispatch::dispatched;
use crate::solve::joint::Stance;
use crate::solve::joint::rows::Rate;
use crate::solve::rotation::MAX_TURN;

/// Passes in which the angular velocity at the end of a substep is found from an angular momentum.
const MOMENTUM_PASSES: usize = 2;

/// Rotation that makes no difference to the inertia of a body that has turned by it (rad).
const NEGLIGIBLE_TURN: f64 = 1.0e-9;

/// Relative gain of rotational energy beyond which a body's angular momentum is not carried into its new pose.
const MOST_GAIN: f64 = 1.0e-6;

const MOST_SPEED: f64 = crate::body::MAX_LINEAR_SPEED as f64;
const MOST_SPIN: f64 = crate::body::MAX_ANGULAR_SPEED as f64;
const MOST_TURN: f64 = MAX_TURN as f64;

/// Four bodies that move, and what stays as it is for a step; where there are fewer, the first takes the places of the others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quad {
    numbers: [u32; 4],
    count: usize,
    /// Principal moments of inertia (kg·m²) and rotation of the principal axes in the body.
    inertia: Four3,
    frame: FourTurns,
    /// Whether the principal axes are those of the body, of all four.
    is_aligned: bool,
    is_tumbling: Mask,
    /// 1 about free world axes, 0 about locked ones; and along them.
    free: Four3,
    free_along: Four3,
    is_free: Mask,
    acceleration: Four3,
    torque: Four3,
    linear_damping: Four,
    angular_damping: Four,
}

/// The bodies that move, four by four.
pub(super) fn gather(quads: &mut Vec<Quad>, bodies: &[DirectBody]) {
    quads.clear();
    let mut moving = bodies.iter().enumerate().filter(|(_, body)| body.is_dynamic()).map(|(number, _)| number as u32);
    while let Some(first) = moving.next() {
        let (mut numbers, mut count) = ([first; 4], 1);
        for (place, number) in numbers[1..].iter_mut().zip(&mut moving) {
            *place = number;
            count += 1;
        }
        quads.push(Quad::of(numbers, count, bodies));
    }
}

impl Quad {
    fn of(numbers: [u32; 4], count: usize, bodies: &[DirectBody]) -> Self {
        let bodies = numbers.map(|number| &bodies[number as usize]);
        let along = |body: &DirectBody| DVec3::select(body.inverse_mass.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        Self {
            numbers,
            count,
            inertia: Four3::of(bodies.map(|body| body.top.inertia)),
            frame: FourTurns::of(bodies.map(|body| body.top.frame)),
            is_aligned: bodies.iter().all(|body| body.top.frame == glam::DQuat::IDENTITY),
            is_tumbling: bodies.map(|body| !body.top.round),
            free: Four3::of(bodies.map(|body| body.top.free)),
            free_along: Four3::of(bodies.map(along)),
            is_free: bodies.map(|body| body.top.free == DVec3::ONE),
            acceleration: Four3::of(bodies.map(|body| body.acceleration)),
            torque: Four3::of(bodies.map(|body| body.torque)),
            linear_damping: Four(bodies.map(|body| body.linear_damping)),
            angular_damping: Four(bodies.map(|body| body.angular_damping)),
        }
    }

    #[inline(always)]
    fn at(&self, j: usize) -> usize {
        self.numbers[j] as usize
    }

    #[inline(always)]
    fn places(&self, stances: &[Stance]) -> (Four3, FourTurns) {
        let [a, b, c, d] = [&stances[self.at(0)], &stances[self.at(1)], &stances[self.at(2)], &stances[self.at(3)]];
        (Four3::of([a.0, b.0, c.0, d.0]), FourTurns::of([a.1, b.1, c.1, d.1]))
    }

    #[inline(always)]
    fn velocities(&self, rates: &[Rate]) -> (Four3, Four3) {
        let [a, b, c, d] = [&rates[self.at(0)], &rates[self.at(1)], &rates[self.at(2)], &rates[self.at(3)]];
        (Four3::of([a.linear, b.linear, c.linear, d.linear]), Four3::of([a.angular, b.angular, c.angular, d.angular]))
    }

    /// Principal axes of bodies that are turned so.
    #[inline(always)]
    fn axes(&self, rotation: FourTurns) -> FourTurns {
        if self.is_aligned { rotation } else { rotation * self.frame }
    }

    /// Angular momentum about the centre of mass (N·m·s).
    #[inline(always)]
    fn spin(&self, rotation: FourTurns, angular: Four3) -> Four3 {
        let axes = self.axes(rotation);
        axes.rotate(axes.conjugate().rotate(angular) * self.inertia)
    }

    /// Angular velocity of an angular momentum about these principal axes.
    #[inline(always)]
    fn spin_of(&self, axes: FourTurns, momentum: Four3) -> Four3 {
        axes.rotate(axes.conjugate().rotate(momentum) / self.inertia) * self.free
    }
}

/// State of an articulation's bodies at a second-order substep's start, and where it ends without joints.
pub(super) struct Start<'a> {
    pub stances: &'a mut [Stance],
    pub rates: &'a mut [Rate],
    pub predicted: &'a mut [Stance],
}

dispatched!(
    /// Puts bodies where their second-order substep starts, whose Euler part is `h` long (s), and finds where that ends without
    /// joints.
    predict, predict_body, (quads: &[Quad], order: &SecondOrder, h: f64, histories: &[History], start: &mut Start)
);

dispatched!(
    /// Moves bodies from the extrapolated start of a second-order substep to its end, at rates found with the inertia of where they
    /// respond.
    advance, advance_body, (quads: &[Quad], h: f64, bodies: &[DirectBody], stances: &mut [Stance], rates: &mut [Rate])
);

dispatched!(
    /// Adds the stiffness of forces, h·Σ [`stiffness::of_impulse`], to the inertia that answers to impulses at these poses.
    respond, respond_body, (quads: &[Quad], stances: &[Stance], stiffness: &[DMat3], bodies: &mut [DirectBody])
);

dispatched!(
    /// Notes a substep of length `h` (s) that ends in these stances and rates, for the next one.
    note, note_body,
    (quads: &[Quad], h: f64, order: &SecondOrder, began: &Began, ended: (&[Stance], &[Rate]), histories: &mut [History])
);

#[inline(always)]
fn predict_body(quads: &[Quad], order: &SecondOrder, h: f64, histories: &[History], start: &mut Start) {
    let Start { stances, rates, predicted } = start;
    let (share, length, one) = (Four::splat(order.extrapolation), Four::splat(h), Four::splat(1.0));
    let steady = Four::splat(order.steady_share * h / order.euler_share);
    for quad in quads {
        let last = [&histories[quad.at(0)], &histories[quad.at(1)], &histories[quad.at(2)], &histories[quad.at(3)]];
        let (place, rotation) = quad.places(stances);
        let (linear, angular) = quad.velocities(rates);
        let spin = quad.spin(rotation, angular);
        let of_last = |of: fn(&History) -> Vec3| Four3::of(last.map(|last| of(last).as_dvec3()));
        let (momentum_before, linear_before) = (of_last(|last| last.momentum_before), of_last(|last| last.linear_before));
        let (displacement, turn) = (of_last(|last| last.displacement), of_last(|last| last.turn));
        let (acceleration, torque) = (of_last(|last| last.acceleration), of_last(|last| last.torque));
        let start = (place + displacement * share + linear * steady, rotation.turned(turn * share + angular * steady));
        let momentum = spin + (spin - momentum_before) * share + torque * steady + quad.torque * length;
        let slowed = one + length * quad.angular_damping;
        let (mut end, mut angular) = (start.1, angular);
        for _ in 0..MOMENTUM_PASSES {
            let guess = angular;
            end = start.1.turned((guess * length).clamp_length(MOST_TURN));
            angular = quad.spin_of(quad.axes(end), momentum) * (one / slowed);
            let change = (angular - guess) * length;
            if !any(Four::splat(NEGLIGIBLE_TURN * NEGLIGIBLE_TURN).below(change.dot(change))) {
                break;
            }
        }
        let linear =
            linear + (linear - linear_before) * share + acceleration * steady + quad.acceleration * quad.free_along * length;
        let linear = (linear * (one / (one + length * quad.linear_damping))).clamp_length(MOST_SPEED);
        let angular = angular.clamp_length(MOST_SPIN.min(MOST_TURN / h));
        let reached = start.0 + linear * length;
        for j in 0..quad.count {
            let i = quad.at(j);
            stances[i] = (start.0.get(j), start.1.get(j));
            rates[i] = Rate { linear: linear.get(j), angular: angular.get(j) };
            predicted[i] = (reached.get(j), end.get(j));
        }
    }
}

#[inline(always)]
fn advance_body(quads: &[Quad], h: f64, bodies: &[DirectBody], stances: &mut [Stance], rates: &mut [Rate]) {
    let length = Four::splat(h);
    for quad in quads {
        let (place, rotation) = quad.places(stances);
        let (linear, angular) = quad.velocities(rates);
        let (linear, angular) = (linear.clamp_length(MOST_SPEED), angular.clamp_length(MOST_SPIN.min(MOST_TURN / h)));
        let place = place + linear * length;
        let rotation = rotation.turned((angular * length).clamp_length(MOST_TURN));
        let inertia =
            [&bodies[quad.at(0)].inertia, &bodies[quad.at(1)].inertia, &bodies[quad.at(2)].inertia, &bodies[quad.at(3)].inertia];
        // The momentum is what the joints left; on a thin rod it can be a far higher speed in another pose, which is refused.
        let momentum = FourSymmetric::of(inertia).times(angular);
        let carried = quad.spin_of(quad.axes(rotation), momentum);
        let carries = momentum.dot(carried).at_most(momentum.dot(angular) * Four::splat(1.0 + MOST_GAIN));
        let angular = Four3::select(both(carries, quad.is_tumbling), carried, angular);
        for j in 0..quad.count {
            let i = quad.at(j);
            stances[i] = (place.get(j), rotation.get(j));
            rates[i] = Rate { linear: linear.get(j), angular: angular.get(j) };
        }
    }
}

#[inline(always)]
fn respond_body(quads: &[Quad], stances: &[Stance], stiffness: &[DMat3], bodies: &mut [DirectBody]) {
    for quad in quads {
        let (_, rotation) = quad.places(stances);
        let inertia = quad.axes(rotation).turn_diagonal(quad.inertia);
        let forces = [&stiffness[quad.at(0)], &stiffness[quad.at(1)], &stiffness[quad.at(2)], &stiffness[quad.at(3)]];
        let forces = stiffness::without_negative(FourSymmetric::of(forces));
        // Bodies with locked axes answer without stiffness.
        let share = Four::select(quad.is_free, Four::splat(1.0), Four::splat(0.0));
        let inverse = inertia.plus(forces, share).inverse().scaled(quad.free);
        for j in 0..quad.count {
            let body = &mut bodies[quad.at(j)];
            body.inertia = inertia.get(j);
            body.inverse_inertia = inverse.get(j);
        }
    }
}

#[inline(always)]
fn note_body(
    quads: &[Quad],
    h: f64,
    order: &SecondOrder,
    began: &Began,
    (stances, rates): (&[Stance], &[Rate]),
    histories: &mut [History],
) {
    let share = Four::splat(order.extrapolation);
    let steady = Four::splat(order.steady_share * h);
    let inverse = Four::splat(1.0 / (order.euler_share * h));
    for quad in quads {
        let (from, before) = quad.places(&began.stances);
        let (to, after) = quad.places(stances);
        let (linear_before, angular_before) = quad.velocities(&began.rates);
        let (linear, angular) = quad.velocities(rates);
        let momentum = quad.spin(before, angular_before);
        let last = [&histories[quad.at(0)], &histories[quad.at(1)], &histories[quad.at(2)], &histories[quad.at(3)]];
        let of_last = |of: fn(&History) -> Vec3| Four3::of(last.map(|last| of(last).as_dvec3()));
        let (linear_last, momentum_last) = (of_last(|last| last.linear_before), of_last(|last| last.momentum_before));
        let extrapolated = (linear_before - linear_last) * share + of_last(|last| last.acceleration) * steady;
        let acceleration = (linear - linear_before - extrapolated) * inverse;
        let extrapolated = (momentum - momentum_last) * share + of_last(|last| last.torque) * steady;
        let torque = (quad.spin(after, angular) - momentum - extrapolated) * inverse;
        let displacement = to - from;
        let change = after * before.conjugate();
        let (turn, is_small) = change.small_vector();
        for j in 0..quad.count {
            let turn = if is_small[j] { turn.get(j) } else { rotation_vector(change.get(j)) };
            histories[quad.at(j)] = History {
                h: h as f32,
                substeps: 0,
                swept_steps: 0,
                displacement: displacement.get(j).as_vec3(),
                turn: turn.as_vec3(),
                linear_before: linear_before.get(j).as_vec3(),
                momentum_before: momentum.get(j).as_vec3(),
                acceleration: acceleration.get(j).as_vec3(),
                torque: torque.get(j).as_vec3(),
                jerk: if order.ratio > 0.0 { histories[quad.at(j)].jerk } else { Vec3::ZERO },
                linear: linear.get(j).as_vec3(),
                angular: angular.get(j).as_vec3(),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, Quat};

    use super::*;
    use crate::solve::rotation::rotated;
    use crate::solve::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};

    /// Five bodies, two of them round or with a locked axis, so that the last of two fours is alone.
    struct Five {
        bodies: Vec<DirectBody>,
        quads: Vec<Quad>,
        stances: Vec<Stance>,
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
        let stances = (0..5).map(|_| (draw(), rotated(DQuat::IDENTITY, draw()))).collect();
        let rates = (0..5).map(|_| Rate { linear: draw(), angular: draw() }).collect();
        let stiffness = (0..5).map(|_| stiffness::of_impulse(draw(), draw())).collect();
        let histories = (0..5).map(|_| History { h: 0.01, turn: draw().as_vec3() * 0.02, ..History::NONE }).collect();
        let (bodies, mut quads): (Vec<_>, _) = ((0..5).map(body).collect(), Vec::new());
        gather(&mut quads, &bodies);
        Five { bodies, quads, stances, rates, stiffness, histories }
    }

    #[test]
    fn bodies_answer_with_the_inverse_of_inertia_and_stiffness() {
        let Five { mut bodies, quads, stances, stiffness, .. } = five();
        respond(&quads, &stances, &stiffness, &mut bodies);
        for (i, body) in bodies.iter().enumerate() {
            assert!((body.inertia - body.inertia_at(&stances[i])).abs_diff_eq(DMat3::ZERO, 1e-14), "inertia of body {i}");
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
        let Five { quads, stances, rates, .. } = five();
        for quad in &quads {
            let (_, rotation) = quad.places(&stances);
            let (_, angular) = quad.velocities(&rates);
            for size in [1.0, 1e-3] {
                let turned = rotation.turned(angular * Four::splat(size));
                let (vector, is_small) = (turned * rotation.conjugate()).small_vector();
                for (j, is_small) in is_small.into_iter().enumerate().take(quad.count) {
                    let i = quad.at(j);
                    let alone = rotated(stances[i].1, rates[i].angular * size);
                    assert!(turned.get(j).abs_diff_eq(alone, 1e-15), "{} instead of {alone}", turned.get(j));
                    assert_eq!(is_small, size < 1.0);
                    let off = (vector.get(j) - rates[i].angular * size).length();
                    assert!(!is_small || off < 1e-14, "a rotation vector is off by {off:e}");
                }
            }
        }
    }

    #[test]
    fn wide_registers_give_the_same_bits() {
        let run = |is_wide: bool| {
            let Five { mut bodies, quads, mut stances, mut rates, stiffness, mut histories } = five();
            let mut began = Began::default();
            (began.rates, began.stances) = (rates.clone(), stances.clone());
            let mut predicted = stances.clone();
            let order = SecondOrder::new(0.01, 0.01).expect("the ratio is one");
            let mut start = Start { stances: &mut stances, rates: &mut rates, predicted: &mut predicted };
            if is_wide {
                predict(&quads, &order, 0.007, &histories, &mut start);
                respond(&quads, &predicted, &stiffness, &mut bodies);
                advance(&quads, 0.007, &bodies, &mut stances, &mut rates);
                note(&quads, 0.01, &order, &began, (&stances, &rates), &mut histories);
            } else {
                predict_body(&quads, &order, 0.007, &histories, &mut start);
                respond_body(&quads, &predicted, &stiffness, &mut bodies);
                advance_body(&quads, 0.007, &bodies, &mut stances, &mut rates);
                note_body(&quads, 0.01, &order, &began, (&stances, &rates), &mut histories);
            }
            (stances, histories)
        };
        assert_eq!(run(true), run(false));
    }
}
