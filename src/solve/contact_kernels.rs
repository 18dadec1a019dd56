//! The loops over contact blocks: warm start, sweep, restitution, position recovery.
//!
//! Every kernel gathers the bodies of eight manifolds into lanes, computes one manifold a lane in a plain loop, and scatters the
//! result. The loops are compiled twice, for AVX2 and for the baseline; both do the same operations in the same order and give
//! the same bits.

#![expect(clippy::needless_range_loop, reason = "the same index runs through many arrays: one lane, one manifold")]

use glam::Vec3;

use super::contact::{ContactBlock, LANES, Lane, Lane3, NEGLIGIBLE_FRICTION, POINTS};
use super::dispatch::dispatched;
use super::state::{BodyMotion, BodyVelocity};

/// Sweeps over the 4×4 matrix of a manifold within one visit.
const INNER_SWEEPS: usize = 4;

/// Share of an overlap that is taken out in one step.
const RECOVERY_SHARE: f32 = 0.2;

/// Share of a gap that a point under load may close in one substep.
///
/// A loaded point gapes by rounding or by an unfinished sweep. If it may close whole in one substep, the impulse that stops it is
/// carried on, opens the next gap, and waves of load grow in a tower until it falls.
const PRESSED_GAP_SHARE: f32 = 0.01;

/// Greatest speed at which an overlap is taken out (m/s).
const MAX_RECOVERY_SPEED: f32 = 0.9;

/// Sweeps of position recovery in a step.
pub(crate) const RECOVERY_SWEEPS: usize = 2;

dispatched!(
    /// Applies the carried multipliers and forms the closing speeds of this substep.
    ///
    /// The velocities have the substep's forces in them already.
    warm_start, warm_start_body,
    (blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32)
);
dispatched!(
    /// One sweep: friction, then the normal rows of each manifold as a block.
    sweep, sweep_body, (blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], backwards: bool)
);

dispatched!(
    /// One sweep of position recovery: overlapping points are pushed apart by displacements that leave no velocity behind.
    ///
    /// `pushes` holds a displacement and rotation for each slot in the form of a velocity times the step. Rows are
    /// J δ ≥ −β s where s < 0 (never faster than [`MAX_RECOVERY_SPEED`]) and J δ ≥ −s elsewhere, so that one overlap is not
    /// cured by making another.
    recover, recover_body,
    (blocks: &[ContactBlock], lambdas: &mut [[Lane; POINTS]], pushes: &mut [BodyVelocity], motions: &[BodyMotion], dt: f32)
);
dispatched!(
    /// Raises `worst` to the greatest overlap of any point (m).
    find_worst_overlap, find_worst_overlap_body,
    (blocks: &[ContactBlock], motions: &[BodyMotion], worst: &mut f32)
);

/// Velocities and inverse masses of one side of a block.
struct Side {
    linear: Lane3,
    angular: Lane3,
    inverse_mass: Lane3,
    inverse_inertia: [Lane; 6],
}

#[inline(always)]
fn gather(slots: &[u32; LANES], velocities: &[BodyVelocity]) -> Side {
    let mut side = Side {
        linear: [[0.0; LANES]; 3],
        angular: [[0.0; LANES]; 3],
        inverse_mass: [[0.0; LANES]; 3],
        inverse_inertia: [[0.0; LANES]; 6],
    };
    for l in 0..LANES {
        let body = &velocities[slots[l] as usize];
        for k in 0..3 {
            side.linear[k][l] = body.linear[k];
            side.angular[k][l] = body.angular[k];
            side.inverse_mass[k][l] = body.inverse_mass[k];
        }
        for k in 0..6 {
            side.inverse_inertia[k][l] = body.inverse_inertia.entries()[k];
        }
    }
    side
}

#[inline(always)]
fn scatter(slots: &[u32; LANES], side: &Side, velocities: &mut [BodyVelocity]) {
    for l in 0..LANES {
        let body = &mut velocities[slots[l] as usize];
        body.linear = Vec3::new(side.linear[0][l], side.linear[1][l], side.linear[2][l]);
        body.angular = Vec3::new(side.angular[0][l], side.angular[1][l], side.angular[2][l]);
    }
}

/// Lane `l` of a vector.
#[inline(always)]
fn at(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}

#[inline(always)]
fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    lanes[0][l] = v.x;
    lanes[1][l] = v.y;
    lanes[2][l] = v.z;
}

impl Side {
    /// Applies an impulse and an angular impulse to lane `l`.
    #[inline(always)]
    fn apply(&mut self, l: usize, impulse: Vec3, torque: Vec3) {
        let [xx, yy, zz, xy, xz, yz] = &self.inverse_inertia;
        self.linear[0][l] += self.inverse_mass[0][l] * impulse.x;
        self.linear[1][l] += self.inverse_mass[1][l] * impulse.y;
        self.linear[2][l] += self.inverse_mass[2][l] * impulse.z;
        self.angular[0][l] += xx[l] * torque.x + xy[l] * torque.y + xz[l] * torque.z;
        self.angular[1][l] += xy[l] * torque.x + yy[l] * torque.y + yz[l] * torque.z;
        self.angular[2][l] += xz[l] * torque.x + yz[l] * torque.y + zz[l] * torque.z;
    }
}

#[inline(always)]
fn warm_start_body(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
    for block in blocks {
        close_in(block, velocities, motions, h);
        let (mut side_a, mut side_b) = (gather(&block.a, velocities), gather(&block.b, velocities));
        for l in 0..LANES {
            let n = at(&block.normal, l);
            let t1 = at(&block.tangent, l);
            let t2 = n.cross(t1);
            let friction = t1 * block.tangent_lambda[0][l] + t2 * block.tangent_lambda[1][l];
            let moment = n * block.twist_lambda[l] + t1 * block.rolling_lambda[0][l] + t2 * block.rolling_lambda[1][l];
            let mut sum = 0.0;
            let (mut arm_a, mut arm_b) = (Vec3::ZERO, Vec3::ZERO);
            for i in 0..POINTS {
                let lambda = block.lambda[i][l];
                sum += lambda;
                arm_a += at(&block.lever_a[i], l) * lambda;
                arm_b += at(&block.lever_b[i], l) * lambda;
            }
            let impulse = n * sum + friction;
            let torque_a = arm_a.cross(n) + at(&block.center_a, l).cross(friction) + moment;
            let torque_b = arm_b.cross(n) + at(&block.center_b, l).cross(friction) + moment;
            side_a.apply(l, -impulse, -torque_a);
            side_b.apply(l, impulse, torque_b);
        }
        scatter(&block.a, &side_a, velocities);
        scatter(&block.b, &side_b, velocities);
    }
}

/// Forms max(s, 0)/h from the separations of now, and notes impact speeds where there is restitution.
#[inline(always)]
fn close_in(block: &mut ContactBlock, velocities: &[BodyVelocity], motions: &[BodyMotion], h: f32) {
    let separation = separations::<POINTS>(block, motions);
    let inverse_h = 1.0 / h;
    for i in 0..POINTS {
        for l in 0..LANES {
            let share = if block.lambda[i][l] > 0.0 { PRESSED_GAP_SHARE } else { 1.0 };
            block.closing_speed[i][l] = separation[i][l].max(0.0) * (share * inverse_h);
        }
    }
    if block.has_restitution {
        note_impacts(block, velocities, motions, h);
    }
}

/// Separation of every point with the bodies displaced as `motions` say (m).
#[inline(always)]
fn separations<const N: usize>(block: &ContactBlock, motions: &[BodyMotion]) -> [Lane; POINTS] {
    let mut moved_a: [Lane3; 2] = [[[0.0; LANES]; 3]; 2];
    let mut moved_b: [Lane3; 2] = [[[0.0; LANES]; 3]; 2];
    for l in 0..LANES {
        let (a, b) = (&motions[block.a[l] as usize], &motions[block.b[l] as usize]);
        for k in 0..3 {
            moved_a[0][k][l] = a.displacement[k];
            moved_a[1][k][l] = a.turn[k];
            moved_b[0][k][l] = b.displacement[k];
            moved_b[1][k][l] = b.turn[k];
        }
    }
    let mut separation = block.separation;
    for l in 0..LANES {
        let n = at(&block.normal, l);
        let shift = n.dot(at(&moved_b[0], l) - at(&moved_a[0], l));
        let (axis_a, axis_b) = (n.cross(at(&moved_a[1], l)), n.cross(at(&moved_b[1], l)));
        for i in 0..N {
            // n·(θ×r) = r·(n×θ)
            separation[i][l] += shift + (at(&block.lever_b[i], l).dot(axis_b) - at(&block.lever_a[i], l).dot(axis_a));
        }
    }
    separation
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

#[inline(always)]
fn sweep_body(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], backwards: bool) {
    let last = blocks.len().wrapping_sub(1);
    for number in 0..blocks.len() {
        let block = &mut blocks[if backwards { last - number } else { number }];
        let (mut side_a, mut side_b) = (gather(&block.a, velocities), gather(&block.b, velocities));
        if block.has_rolling {
            roll(block, &mut side_a, &mut side_b);
        }
        if block.has_faces {
            rub::<POINTS>(block, &mut side_a, &mut side_b);
            press::<POINTS>(block, &mut side_a, &mut side_b);
        } else {
            rub::<1>(block, &mut side_a, &mut side_b);
            press::<1>(block, &mut side_a, &mut side_b);
        }
        scatter(&block.a, &side_a, velocities);
        scatter(&block.b, &side_b, velocities);
    }
}

/// Zero for a friction impulse that is nothing beside its limit, and whose square would be a denormal number.
#[inline(always)]
fn flushed(impulse: f32, limit: f32) -> f32 {
    if impulse.abs() > NEGLIGIBLE_FRICTION * limit { impulse } else { 0.0 }
}

/// Tangential and twist rows of every lane.
#[inline(always)]
fn rub<const N: usize>(block: &mut ContactBlock, side_a: &mut Side, side_b: &mut Side) {
    for l in 0..LANES {
        let n = at(&block.normal, l);
        let t1 = at(&block.tangent, l);
        let t2 = n.cross(t1);
        let (center_a, center_b) = (at(&block.center_a, l), at(&block.center_b, l));
        let mut load = 0.0;
        for i in 0..N {
            load += block.lambda[i][l];
        }

        let (spin_a, spin_b) = (at(&side_a.angular, l), at(&side_b.angular, l));
        let slip = at(&side_b.linear, l) + spin_b.cross(center_b) - at(&side_a.linear, l) - spin_a.cross(center_a);
        let (slip1, slip2) = (slip.dot(t1), slip.dot(t2));
        let [m11, m12, m22] = &block.tangent_mass;
        let old1 = block.tangent_lambda[0][l];
        let old2 = block.tangent_lambda[1][l];
        let free1 = old1 - (m11[l] * slip1 + m12[l] * slip2);
        let free2 = old2 - (m12[l] * slip1 + m22[l] * slip2);
        let limit = block.friction[l] * load;
        let (free1, free2) = (flushed(free1, limit), flushed(free2, limit));
        let size = (free1 * free1 + free2 * free2).sqrt();
        let scale = if size > limit { limit / size } else { 1.0 };
        let (new1, new2) = (free1 * scale, free2 * scale);
        block.tangent_lambda[0][l] = new1;
        block.tangent_lambda[1][l] = new2;
        let impulse = t1 * (new1 - old1) + t2 * (new2 - old2);

        // The twist sees the velocities before the tangential impulse: the two hardly couple at the centre.
        let twist_limit = block.twist_arm[l] * load;
        let old = block.twist_lambda[l];
        let free = old - block.twist_mass[l] * n.dot(spin_b - spin_a);
        let new = free.max(-twist_limit).min(twist_limit);
        block.twist_lambda[l] = new;
        let moment = n * (new - old);

        side_a.apply(l, -impulse, -(center_a.cross(impulse) + moment));
        side_b.apply(l, impulse, center_b.cross(impulse) + moment);
    }
}

/// Rolling rows of every lane.
#[inline(always)]
fn roll(block: &mut ContactBlock, side_a: &mut Side, side_b: &mut Side) {
    for l in 0..LANES {
        let n = at(&block.normal, l);
        let t1 = at(&block.tangent, l);
        let t2 = n.cross(t1);
        let load = block.lambda[0][l] + block.lambda[1][l] + block.lambda[2][l] + block.lambda[3][l];
        let rolling = at(&side_b.angular, l) - at(&side_a.angular, l);
        let (roll1, roll2) = (rolling.dot(t1), rolling.dot(t2));
        let [m11, m12, m22] = &block.rolling_mass;
        let old1 = block.rolling_lambda[0][l];
        let old2 = block.rolling_lambda[1][l];
        let free1 = old1 - (m11[l] * roll1 + m12[l] * roll2);
        let free2 = old2 - (m12[l] * roll1 + m22[l] * roll2);
        let limit = block.rolling_arm[l] * load;
        let (free1, free2) = (flushed(free1, limit), flushed(free2, limit));
        let size = (free1 * free1 + free2 * free2).sqrt();
        let scale = if size > limit { limit / size } else { 1.0 };
        let (new1, new2) = (free1 * scale, free2 * scale);
        block.rolling_lambda[0][l] = new1;
        block.rolling_lambda[1][l] = new2;
        let moment = t1 * (new1 - old1) + t2 * (new2 - old2);
        side_a.apply(l, Vec3::ZERO, -moment);
        side_b.apply(l, Vec3::ZERO, moment);
    }
}

/// Normal rows of every lane, each manifold as one block.
#[inline(always)]
fn press<const N: usize>(block: &mut ContactBlock, side_a: &mut Side, side_b: &mut Side) {
    let mut residual = normal_rates::<N>(block, side_a, side_b);
    for i in 0..N {
        for l in 0..LANES {
            residual[i][l] += block.closing_speed[i][l];
        }
    }
    let new = solve_manifolds::<N>(block, residual, &block.lambda);
    push_apart::<N>(block, &new, &block.lambda, side_a, side_b);
    for i in 0..N {
        for l in 0..LANES {
            block.peak_lambda[i][l] = block.peak_lambda[i][l].max(new[i][l]);
        }
    }
    block.lambda[..N].copy_from_slice(&new[..N]);
}

/// J v of every normal row.
#[inline(always)]
fn normal_rates<const N: usize>(block: &ContactBlock, side_a: &Side, side_b: &Side) -> [Lane; POINTS] {
    let mut approach = [0.0; LANES];
    let (mut axis_a, mut axis_b) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    for l in 0..LANES {
        let n = at(&block.normal, l);
        approach[l] = n.dot(at(&side_b.linear, l) - at(&side_a.linear, l));
        // n·(ω×r) = r·(n×ω)
        put(&mut axis_a, l, n.cross(at(&side_a.angular, l)));
        put(&mut axis_b, l, n.cross(at(&side_b.angular, l)));
    }
    let mut rates = [[0.0; LANES]; POINTS];
    for i in 0..N {
        for l in 0..LANES {
            let turning = at(&block.lever_b[i], l).dot(at(&axis_b, l)) - at(&block.lever_a[i], l).dot(at(&axis_a, l));
            rates[i][l] = approach[l] + turning;
        }
    }
    rates
}

/// Multipliers λ ≥ 0 of every manifold, from `residual` = J v + b at the multipliers `old`.
///
/// Where all points press, the regularised inverse gives them at once. Elsewhere, and for what it leaves, projected
/// Gauss–Seidel on the manifold's own matrix. Without the inverse, the few inner sweeps leave a face's load uneven and tall
/// columns buckle.
#[inline(always)]
fn solve_manifolds<const N: usize>(block: &ContactBlock, mut residual: [Lane; POINTS], old: &[Lane; POINTS]) -> [Lane; POINTS] {
    if N == 1 {
        let mut lambda = *old;
        for l in 0..LANES {
            lambda[0][l] = (lambda[0][l] - residual[0][l] * block.inverse_diagonal[0][l]).max(0.0);
        }
        return lambda;
    }
    let b = &block.inverse;
    let inverse: [[&Lane; POINTS]; POINTS] =
        [[&b[0], &b[4], &b[5], &b[6]], [&b[4], &b[1], &b[7], &b[8]], [&b[5], &b[7], &b[2], &b[9]], [&b[6], &b[8], &b[9], &b[3]]];
    let (c, d) = (&block.coupling, &block.diagonal);
    let matrix: [[&Lane; POINTS]; POINTS] =
        [[&d[0], &c[0], &c[1], &c[2]], [&c[0], &d[1], &c[3], &c[4]], [&c[1], &c[3], &d[2], &c[5]], [&c[2], &c[4], &c[5], &d[3]]];

    let mut lambda = *old;
    let mut step = [[0.0; LANES]; POINTS];
    let mut least = [0.0_f32; LANES];
    for i in 0..POINTS {
        for l in 0..LANES {
            let mut sum = 0.0;
            for j in 0..POINTS {
                sum += inverse[i][j][l] * residual[j][l];
            }
            step[i][l] = -sum;
            least[l] = least[l].min(lambda[i][l] - sum);
        }
    }
    for i in 0..POINTS {
        for l in 0..LANES {
            step[i][l] = if least[l] >= 0.0 { step[i][l] } else { 0.0 };
            lambda[i][l] += step[i][l];
        }
    }
    for i in 0..POINTS {
        for l in 0..LANES {
            let mut sum = 0.0;
            for j in 0..POINTS {
                sum += matrix[i][j][l] * step[j][l];
            }
            residual[i][l] += sum;
        }
    }
    for _ in 0..INNER_SWEEPS {
        for i in 0..POINTS {
            let mut change = [0.0; LANES];
            for l in 0..LANES {
                let new = (lambda[i][l] - residual[i][l] * block.inverse_diagonal[i][l]).max(0.0);
                change[l] = new - lambda[i][l];
                lambda[i][l] = new;
            }
            for j in 0..POINTS {
                for l in 0..LANES {
                    residual[j][l] += matrix[j][i][l] * change[l];
                }
            }
        }
    }
    lambda
}

/// Applies the difference of two sets of normal multipliers.
#[inline(always)]
fn push_apart<const N: usize>(
    block: &ContactBlock,
    new: &[Lane; POINTS],
    old: &[Lane; POINTS],
    side_a: &mut Side,
    side_b: &mut Side,
) {
    for l in 0..LANES {
        let n = at(&block.normal, l);
        let mut sum = 0.0;
        let (mut arm_a, mut arm_b) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..N {
            let change = new[i][l] - old[i][l];
            sum += change;
            arm_a += at(&block.lever_a[i], l) * change;
            arm_b += at(&block.lever_b[i], l) * change;
        }
        side_a.apply(l, n * -sum, -arm_a.cross(n));
        side_b.apply(l, n * sum, arm_b.cross(n));
    }
}

/// After the substeps: points that hit something at more than `threshold` (m/s) leave at the rebound speed.
pub(crate) fn restitute(blocks: &mut [ContactBlock], velocities: &mut [BodyVelocity], threshold: f32) {
    for block in blocks.iter_mut().filter(|block| block.has_restitution) {
        let (mut side_a, mut side_b) = (gather(&block.a, velocities), gather(&block.b, velocities));
        let mut residual = normal_rates::<POINTS>(block, &side_a, &side_b);
        let mut any = [false; LANES];
        for l in 0..LANES {
            for i in 0..POINTS {
                if block.impact_speed[i][l] < -threshold && block.peak_lambda[i][l] > 0.0 {
                    residual[i][l] += block.restitution[l] * block.impact_speed[i][l];
                    any[l] = true;
                }
            }
        }
        let mut new = solve_manifolds::<POINTS>(block, residual, &block.lambda);
        for l in 0..LANES {
            for i in 0..POINTS {
                new[i][l] = if any[l] { new[i][l] } else { block.lambda[i][l] };
            }
        }
        push_apart::<POINTS>(block, &new, &block.lambda, &mut side_a, &mut side_b);
        scatter(&block.a, &side_a, velocities);
        scatter(&block.b, &side_b, velocities);
        block.lambda = new;
    }
}

#[inline(always)]
fn find_worst_overlap_body(blocks: &[ContactBlock], motions: &[BodyMotion], worst: &mut f32) {
    let mut deepest = [0.0_f32; LANES];
    for block in blocks {
        let separation = separations::<POINTS>(block, motions);
        for i in 0..POINTS {
            for l in 0..LANES {
                let overlap = if block.inverse_diagonal[i][l] > 0.0 { -separation[i][l] } else { 0.0 };
                deepest[l] = deepest[l].max(overlap);
            }
        }
    }
    *worst = deepest.iter().fold(*worst, |worst, &overlap| worst.max(overlap));
}

#[inline(always)]
fn recover_body(
    blocks: &[ContactBlock],
    lambdas: &mut [[Lane; POINTS]],
    pushes: &mut [BodyVelocity],
    motions: &[BodyMotion],
    dt: f32,
) {
    for (block, lambda) in blocks.iter().zip(lambdas) {
        if block.has_faces {
            part_overlaps::<POINTS>(block, lambda, pushes, motions, dt);
        } else {
            part_overlaps::<1>(block, lambda, pushes, motions, dt);
        }
    }
}

#[inline(always)]
fn part_overlaps<const N: usize>(
    block: &ContactBlock,
    lambda: &mut [Lane; POINTS],
    pushes: &mut [BodyVelocity],
    motions: &[BodyMotion],
    dt: f32,
) {
    let (mut side_a, mut side_b) = (gather(&block.a, pushes), gather(&block.b, pushes));
    let mut residual = normal_rates::<N>(block, &side_a, &side_b);
    let separation = separations::<N>(block, motions);
    for i in 0..N {
        for l in 0..LANES {
            let s = separation[i][l];
            residual[i][l] += if s < 0.0 { (RECOVERY_SHARE * s).max(-MAX_RECOVERY_SPEED * dt) } else { s };
        }
    }
    let new = solve_manifolds::<N>(block, residual, lambda);
    push_apart::<N>(block, &new, lambda, &mut side_a, &mut side_b);
    scatter(&block.a, &side_a, pushes);
    scatter(&block.b, &side_b, pushes);
    *lambda = new;
}
