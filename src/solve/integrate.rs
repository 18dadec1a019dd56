//! Moving bodies through a substep: forces into velocities, velocities into poses.
//!
//! Rotation is torque-free between the constraint impulses, so the angular momentum L = R I Rᵀ ω stays constant while the body
//! turns. The midpoint rule on L (Müller et al. 2020 use the explicit gyroscopic term, which loses 1–2 % of L) is
//!
//! ```text
//! ω½ = R½ I⁻¹ R½ᵀ L,   R½ = exp(h ω / 2) R,      R' = exp(h ω½) R,      ω' = R' I⁻¹ R'ᵀ L
//! ```
//!
//! L is exact and the energy error is of second order. On thin rods a small tilt of L becomes a large spin and the rule can
//! create energy; it is accepted only if it does not (see [`MAX_ENERGY_GAIN`]), else one implicit step of Euler's equations in
//! the body frame (Catto 2015) is taken, which only loses energy.

use glam::{DQuat, DVec3, Mat3, Quat, Vec3};

use super::state::{BodyMotion, BodyVelocity, MotionKind, Symmetric};
use crate::body::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

/// Relative gain of rotational energy in one substep beyond which the midpoint rule is refused.
const MAX_ENERGY_GAIN: f64 = 1.0e-3;

/// Rotation since the last refresh, times the ratio of greatest to least inertia, after which the world inertia of an unjointed
/// body is formed anew (rad). A needle's response along its axis leaks across it as it turns; left alone it gains energy.
const INERTIA_REFRESH: f32 = 1.0e-2;

/// Rotation of one substep below which the gyroscopic term is left out (rad): it would change ω by less than its square.
const NEGLIGIBLE_TUMBLE: f32 = 1.0e-4;

/// Rotation of one substep above which the midpoint rule takes two halves (rad).
const SPLIT_TUMBLE: f64 = 1.0e-2;

/// Largest rotation of one substep (rad); beyond it the direction of a lever has no meaning.
const MAX_TURN: f32 = 1.5;

/// Speeds below this are taken as zero (m/s, rad/s), so that neither they nor their squares
/// become denormal numbers, which cost ten times as much.
const NEGLIGIBLE_SPEED: f32 = 1.0e-9;

/// Adds a substep's forces to a body's velocity.
pub(crate) fn apply_forces(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    if !motion.is_dynamic() {
        return;
    }
    motion.refreshed = false;
    if motion.kind == MotionKind::Tumbling {
        let turned = motion.turn - motion.turn_at_refresh;
        let noticeable = INERTIA_REFRESH * motion.inertia.min_element() / motion.inertia.max_element();
        if turned.length_squared() > noticeable * noticeable || (motion.jointed && velocity.angular != Vec3::ZERO) {
            refresh_inertia(velocity, motion, h);
            motion.refreshed = true;
        }
    }
    let free = velocity.inverse_mass.cmpgt(Vec3::ZERO);
    velocity.linear += Vec3::select(free, motion.acceleration * h, Vec3::ZERO);
    velocity.angular += velocity.inverse_inertia.mul(motion.torque) * h;
    velocity.linear /= 1.0 + h * motion.linear_damping;
    velocity.angular /= 1.0 + h * motion.angular_damping;
    limit_speeds(velocity, h);
}

/// Moves a body through a substep at its velocity.
pub(crate) fn advance(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    if motion.kind == MotionKind::Fixed {
        return;
    }
    if motion.is_dynamic() {
        // Rows on bodies of tiny inertia can ask for any speed.
        limit_speeds(velocity, h);
    }
    motion.displacement += velocity.linear * h;
    if motion.is_dynamic() && !motion.constrained {
        // The velocity has gained the whole substep's acceleration; a free path is a parabola.
        motion.displacement -=
            Vec3::select(velocity.inverse_mass.cmpgt(Vec3::ZERO), motion.acceleration * (0.5 * h * h), Vec3::ZERO);
    }
    let turned = turn(velocity, motion, h);
    motion.turn += turned.mean * h;
    motion.rotation = turned.rotation;
    velocity.angular = turned.angular;
}

/// Displacement and rotation that a body would have at the end of the substep at its present velocity.
pub(crate) fn predict(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> (Vec3, Quat) {
    if motion.kind == MotionKind::Fixed {
        return (motion.displacement, motion.rotation);
    }
    (motion.displacement + velocity.linear * h, turn(velocity, motion, h).rotation)
}

struct Turn {
    rotation: Quat,
    /// Mean angular velocity of the substep.
    mean: Vec3,
    /// Angular velocity at its end.
    angular: Vec3,
}

fn turn(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> Turn {
    let angular = velocity.angular;
    if angular == Vec3::ZERO {
        return Turn { rotation: motion.rotation, mean: angular, angular };
    }
    if motion.kind == MotionKind::Tumbling && angular.length_squared() > NEGLIGIBLE_TUMBLE * NEGLIGIBLE_TUMBLE / (h * h) {
        return tumble(angular, motion, h);
    }
    Turn { rotation: rotated(motion.rotation, (angular * h).clamp_length_max(MAX_TURN)), mean: angular, angular }
}

/// In `f64`: in `f32` the rounding of L is biased and costs 0.07 % of it in ten seconds.
fn tumble(angular: Vec3, motion: &BodyMotion, h: f32) -> Turn {
    let step = f64::from(h);
    let rotation = motion.rotation.as_dquat().normalize();
    let inertia_frame = motion.inertia_frame.as_dquat().normalize();
    let frame = rotation * inertia_frame;
    let inertia = motion.inertia.as_dvec3();
    let free = motion.free_rotation.as_dvec3();
    let local = frame.conjugate() * angular.as_dvec3();
    let momentum = frame * (inertia * local);
    let velocity_in = |frame: DQuat| frame * ((frame.conjugate() * momentum) / inertia) * free;

    let pieces = if angular.length() * h > SPLIT_TUMBLE as f32 { 2 } else { 1 };
    let piece = step / f64::from(pieces);
    let (mut turned, mut end, mut mean) = (rotation, angular.as_dvec3(), DVec3::ZERO);
    for _ in 0..pieces {
        let middle = velocity_in(rotated_f64(turned * inertia_frame, end * (0.5 * piece)));
        turned = rotated_f64(turned, middle * piece);
        end = velocity_in(turned * inertia_frame);
        mean += middle / f64::from(pieces);
    }
    let energy = local.dot(inertia * local);
    let gains = momentum.dot(end) > energy * (1.0 + MAX_ENERGY_GAIN);
    if !gains && (mean * step).length_squared() < f64::from(MAX_TURN * MAX_TURN) {
        return Turn { rotation: turned.as_quat(), mean: mean.as_vec3(), angular: end.as_vec3() };
    }
    let local = local.as_vec3();
    let implicit = frame.as_quat() * implicit_gyroscopic(local, motion.inertia, h) * motion.free_rotation;
    let scale = (local.length() / implicit.length().max(f32::MIN_POSITIVE)).min(1.0);
    let angular = implicit * scale;
    Turn { rotation: rotated(motion.rotation, angular * h), mean: angular, angular }
}

/// One Newton step of I (ω' − ω) + h ω' × I ω' = 0 in principal axes.
fn implicit_gyroscopic(local: Vec3, inertia: Vec3, h: f32) -> Vec3 {
    let momentum = inertia * local;
    let residual = h * local.cross(momentum);
    let jacobian = Mat3::from_diagonal(inertia) + h * (skew(local) * Mat3::from_diagonal(inertia) - skew(momentum));
    local - jacobian.inverse() * residual
}

pub(crate) fn skew(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// `rotation` turned by a rotation vector in world axes (rad).
///
/// Sine and cosine of the half angle are power series: exact to rounding below the largest turn of a substep, and the same
/// bits on every platform.
pub(crate) fn rotated(rotation: Quat, vector: Vec3) -> Quat {
    let half = vector * 0.5;
    let x = half.length_squared();
    let sine_over_angle = 1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0)));
    let cosine = 1.0 - x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0))));
    let axis = half * sine_over_angle;
    (Quat::from_xyzw(axis.x, axis.y, axis.z, cosine) * rotation).normalize()
}

/// As [`rotated`], with as many more terms as `f64` can tell.
fn rotated_f64(rotation: DQuat, vector: DVec3) -> DQuat {
    let half = vector * 0.5;
    let x = half.length_squared();
    let (mut sine_over_angle, mut cosine) = (1.0, 1.0);
    for k in (1..=8).rev() {
        let n = f64::from(2 * k);
        sine_over_angle = 1.0 - x / (n * (n + 1.0)) * sine_over_angle;
        cosine = 1.0 - x / (n * (n - 1.0)) * cosine;
    }
    let axis = half * sine_over_angle;
    (DQuat::from_xyzw(axis.x, axis.y, axis.z, cosine) * rotation).normalize()
}

/// Forms the world inertia that rows respond with.
///
/// A body that turns by θ in a substep smears its axes by θ²: the response about a light axis, I⁻¹, would act across it as θ² I⁻¹
/// and the rows would overshoot. So no axis answers as if lighter than θ² of the heaviest.
fn refresh_inertia(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    let turn = velocity.angular.length() * h;
    let inertia = motion.inertia.max(Vec3::splat(motion.inertia.max_element() * (turn * turn).min(1.0)));
    let tensor = crate::shape::inertia_tensor(1.0 / inertia, motion.rotation * motion.inertia_frame);
    let free = motion.free_rotation;
    let masked = Mat3::from_cols(tensor.x_axis * free * free.x, tensor.y_axis * free * free.y, tensor.z_axis * free * free.z);
    velocity.inverse_inertia = Symmetric::from_mat3(masked);
    motion.turn_at_refresh = motion.turn;
}

fn limit_speeds(velocity: &mut BodyVelocity, h: f32) {
    velocity.linear = settle(velocity.linear, MAX_LINEAR_SPEED);
    velocity.angular = settle(velocity.angular, MAX_ANGULAR_SPEED.min(MAX_TURN / h));
}

fn settle(velocity: Vec3, limit: f32) -> Vec3 {
    let squared = velocity.length_squared();
    if squared > limit * limit {
        return velocity * (limit / squared.sqrt());
    }
    Vec3::select(velocity.abs().cmpgt(Vec3::splat(NEGLIGIBLE_SPEED)), velocity, Vec3::ZERO)
}
