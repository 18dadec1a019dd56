//! Moving bodies through a substep: forces into velocities, velocities into poses.

use glam::{Mat3, Quat, Vec3};

use super::rotation::{self, MAX_TURN};
use super::state::{BodyMotion, BodyVelocity, Constraints, MotionKind, Symmetric};
use crate::linalg::held_axes::held32;
use crate::linalg::rotation32::{NEGLIGIBLE_SPEED, quaternion_of, rotated, settled};
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED, is_at_limit, is_beyond_limit};
use crate::tuning::needles::NEEDLE;

/// Rotation since the last refresh, times the ratio of greatest to least inertia, after which the world inertia of an unjointed
/// body is formed anew (rad). A needle's response along its axis leaks across it as it turns; left alone it gains energy.
const INERTIA_REFRESH: f32 = 1.0e-2;

/// Rotation of one substep below which the gyroscopic term is left out (rad): it would change ω by less than rounding.
pub(crate) const NEGLIGIBLE_TUMBLE: f32 = 1.0e-7;

/// Rotation of one substep above which a prediction takes two halves, and above which a body that tumbles is left to [`rotation`] (rad).
/// One half is off by the cube of it over 24: here by 5e-6 rad.
pub(crate) const SPLIT_TUMBLE: f32 = 5.0e-2;
pub(crate) const SAFE_TUMBLE: f32 = 1.0e-1;

/// Adds a substep's forces to a body's velocity; what is in lanes gets them there.
pub(crate) fn apply_forces(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    if !motion.is_dynamic() || motion.direct || motion.in_lanes {
        return;
    }
    motion.world_inertia.refreshed = false;
    if motion.kind == MotionKind::Tumbling {
        let turned = motion.turn - motion.turn_at_refresh;
        let noticeable = INERTIA_REFRESH * motion.inertia.min_element() / motion.inertia.max_element();
        if turned.length_squared() > noticeable * noticeable || (motion.jointed && velocity.angular != Vec3::ZERO) {
            refresh_inertia(velocity, motion, h);
            motion.world_inertia.refreshed = true;
        }
    }
    let free = velocity.inverse_mass.cmpgt(Vec3::ZERO);
    velocity.linear += Vec3::select(free, motion.acceleration * h, Vec3::ZERO);
    if motion.torque != Vec3::ZERO {
        velocity.angular += velocity.inverse_inertia.mul(motion.torque) * h;
    }
    if motion.linear_damping != 0.0 {
        velocity.linear /= 1.0 + h * motion.linear_damping;
    }
    if motion.angular_damping != 0.0 {
        velocity.angular /= 1.0 + h * motion.angular_damping;
    }
}

/// Moves a body through a substep at its velocity.
pub(crate) fn advance(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    if motion.kind == MotionKind::Fixed || motion.direct {
        return;
    }
    // Rows on bodies of tiny inertia can ask for any speed.
    limit_speeds(velocity, motion);
    motion.displacement += velocity.linear * h;
    if motion.is_dynamic() && motion.constraints != Constraints::Holding {
        // The velocity has gained the whole substep's acceleration; a free path is a parabola.
        let acceleration = Vec3::select(velocity.inverse_mass.cmpgt(Vec3::ZERO), motion.acceleration, Vec3::ZERO);
        let share = share_gained(velocity.linear, acceleration, motion.linear_damping, h);
        motion.displacement -= acceleration * (0.5 * share * h * h);
    }
    let turned = turn(velocity, motion, h);
    motion.turn += turned.mean * h;
    motion.rotation = turned.rotation;
    velocity.angular = turned.angular;
}

/// Share of its acceleration `a` (m/s²) that a body of velocity `v` gains in speed, as damping `c` (1/s) takes the rest: none of it at
/// a/c, the speed at which it goes on falling. What only slows down has all of it, as without damping: the sum of h v over its substeps
/// is v/c then, which is how far it comes.
///
/// None of it at the greatest speed either, where the rest of it is cut off; nor where the substep of length `h` (s) would have to have begun
/// beyond that speed. So the mean of its velocity in the substep, v − ½ h a share, is no faster than the greatest speed.
pub(crate) fn share_gained(v: Vec3, a: Vec3, c: f32, h: f32) -> f32 {
    let squared = a.length_squared();
    if squared == 0.0 {
        return 1.0;
    }
    let share = if c == 0.0 { 1.0 } else { (1.0 - c * (v.dot(a) / squared)).clamp(0.0, 1.0) };
    if is_at_limit(v) || is_beyond_limit(v - a * (h * share)) {
        return 0.0;
    }
    share
}

/// Where a body would be at the end of the substep at its present velocity.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct PredictedPose {
    /// What turns it from how it stands now; x, y and z are right to rounding of themselves, however small they are.
    pub turn: Quat,
    unused: [f32; 4],
    pub rotation: Quat,
    pub displacement: Vec3,
    unused_too: f32,
}

const _: () = assert!(size_of::<PredictedPose>() == 16 * size_of::<f32>());

impl PredictedPose {
    /// Of a body that stays as it is.
    pub(crate) fn still(motion: &BodyMotion) -> Self {
        Self::new(Quat::IDENTITY, motion.displacement, motion.rotation)
    }

    pub(crate) fn of(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> Self {
        if motion.kind == MotionKind::Fixed {
            return Self::still(motion);
        }
        let turn = predicted_turn(velocity.angular, motion, h);
        let displacement = motion.displacement + velocity.linear * h;
        Self::new(turn, displacement, (turn * motion.rotation).normalize())
    }

    fn new(turn: Quat, displacement: Vec3, rotation: Quat) -> Self {
        Self { turn, unused: [0.0; 4], rotation, displacement, unused_too: 0.0 }
    }

    /// The same, to be written: the turn and the place of rotation and displacement.
    #[inline(always)]
    pub(crate) fn halves_mut(&mut self) -> [&mut [f32; 8]; 2] {
        // SAFETY: as in `halves`; any numbers may be written.
        let [first, second] = unsafe { &mut *std::ptr::from_mut(self).cast::<[[f32; 8]; 2]>() };
        [first, second]
    }

    /// Its sixteen numbers as two registers: the turn and four that are unused; rotation, displacement, and one that is unused.
    #[inline(always)]
    pub(crate) fn halves(&self) -> [&[f32; 8]; 2] {
        // SAFETY: the struct is `repr(C)` and made of 16 `f32` without padding, as its size says.
        let halves = unsafe { &*std::ptr::from_ref(self).cast::<[[f32; 8]; 2]>() };
        [&halves[0], &halves[1]]
    }
}

/// As [`turn`], in `f32`: rows that a prediction goes into are no more exact.
fn predicted_turn(angular: Vec3, motion: &BodyMotion, h: f32) -> Quat {
    if angular == Vec3::ZERO {
        return Quat::IDENTITY;
    }
    let squared = angular.length_squared();
    if motion.kind != MotionKind::Tumbling || squared <= NEGLIGIBLE_TUMBLE * NEGLIGIBLE_TUMBLE / (h * h) {
        return match squared * h * h > MAX_TURN * MAX_TURN {
            true => rotation::quaternion_of(angular.as_dvec3() * f64::from(h)).as_quat(),
            false => quaternion_of(angular * h),
        };
    }
    let frame = motion.rotation * motion.inertia_frame;
    let start = frame.conjugate() * angular;
    let momentum = motion.inertia * start;
    let ease = motion.inertia.recip();
    let pieces = if squared * h * h > SPLIT_TUMBLE * SPLIT_TUMBLE { 2 } else { 1 };
    let piece = h / pieces as f32;
    // All in the principal axes of now.
    let (mut turned, mut end) = (Quat::IDENTITY, start);
    let velocity_in = |turned: Quat| turned * ((turned.conjugate() * momentum) * ease);
    for _ in 0..pieces {
        let middle = velocity_in(quaternion_of(end * (0.5 * piece)) * turned);
        turned = quaternion_of(middle * piece) * turned;
        end = velocity_in(turned);
    }
    let gains = momentum.dot(end) > momentum.dot(start) * (1.0 + rotation::MAX_ENERGY_GAIN as f32);
    let way = Vec3::new(turned.x, turned.y, turned.z);
    if gains || squared * h * h > SAFE_TUMBLE * SAFE_TUMBLE || !motion.is_free_to_turn() {
        let rotation = motion.rotation.as_dquat().normalize();
        let exact = rotation::tumble(rotation, angular.as_dvec3(), &motion.top(), f64::from(h)).rotation;
        return (exact * rotation.conjugate()).as_quat();
    }
    let way = frame * way;
    Quat::from_xyzw(way.x, way.y, way.z, turned.w)
}

/// As [`rotation::SubstepRotation32`], in the precision of the sweeps.
struct SubstepRotation32 {
    rotation: Quat,
    mean: Vec3,
    angular: Vec3,
}

fn turn(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> SubstepRotation32 {
    let angular = velocity.angular;
    if angular == Vec3::ZERO {
        return SubstepRotation32 { rotation: motion.rotation, mean: angular, angular };
    }
    if motion.kind == MotionKind::Tumbling && angular.length_squared() > NEGLIGIBLE_TUMBLE * NEGLIGIBLE_TUMBLE / (h * h) {
        let turn = rotation::tumble(motion.rotation.as_dquat().normalize(), angular.as_dvec3(), &motion.top(), f64::from(h));
        return SubstepRotation32 {
            rotation: turn.rotation.as_quat(),
            mean: turn.mean.as_vec3(),
            angular: turn.angular.as_vec3(),
        };
    }
    if angular.length_squared() > MAX_TURN * MAX_TURN / (h * h) {
        let turned = rotation::rotated(motion.rotation.as_dquat().normalize(), angular.as_dvec3() * f64::from(h));
        return SubstepRotation32 { rotation: turned.as_quat(), mean: angular, angular };
    }
    SubstepRotation32 { rotation: rotated(motion.rotation, angular * h), mean: angular, angular }
}

pub(crate) fn skew(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// Forms the world inertia that rows respond with.
///
/// An axis that turns by θ in a substep is smeared by θ²: the response about it where it is light, I⁻¹, would act across it as θ² I⁻¹
/// and the rows would overshoot. So no axis answers as if lighter than θ² of the heaviest. Spin about an axis does not turn it: what rolls
/// answers to friction with all of its moment.
fn refresh_inertia(velocity: &mut BodyVelocity, motion: &mut BodyMotion, h: f32) {
    let axes = motion.rotation * motion.inertia_frame;
    let inertia = smeared_inertia(velocity, motion, h);
    let tensor = crate::shape::inertia_tensor(1.0 / inertia, axes);
    velocity.inverse_inertia = Symmetric::from_mat3(held32(tensor, motion.free_rotation()));
    motion.turn_at_refresh = motion.turn;
    motion.world_inertia.smeared = inertia != motion.inertia;
}

/// Principal moments of inertia that rows answer with in a substep of length `h` (kg·m²).
fn smeared_inertia(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> Vec3 {
    let turn = (motion.rotation * motion.inertia_frame).conjugate() * (velocity.angular * h);
    let squares = turn * turn;
    let of_axes = Vec3::new(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y);
    motion.inertia.max(motion.inertia.max_element() * of_axes.min(Vec3::ONE))
}

/// Whether a body that goes on as it does has axes that a substep smears.
pub(crate) fn is_smeared(velocity: &BodyVelocity, motion: &BodyMotion, h: f32) -> bool {
    let way = velocity.angular.length_squared() * (h * h);
    let may_be = motion.kind == MotionKind::Tumbling && motion.inertia.max_element() * way > motion.inertia.min_element();
    may_be && smeared_inertia(velocity, motion, h) != motion.inertia
}

/// Keeps speeds within what the world allows.
pub(crate) fn limit_speeds(velocity: &mut BodyVelocity, motion: &BodyMotion) {
    if !motion.is_dynamic() || motion.direct {
        return;
    }
    velocity.linear = settle(velocity.linear, MAX_LINEAR_SPEED);
    velocity.angular = settle(velocity.angular, MAX_ANGULAR_SPEED);
}

/// Greatest turn of a needle about its axis in a substep (rad).
const TURN_OF_NEEDLE: f32 = 2.0 * MAX_TURN;

/// Spins a needle that contacts push about its axis no faster than by so much in a substep of length `h` (s). One that flies or is held by
/// joints alone keeps its spin.
pub(crate) fn limit_spin_of_needle(velocity: &mut BodyVelocity, h: f32) {
    if velocity.angular.length_squared() * (h * h) <= TURN_OF_NEEDLE * TURN_OF_NEEDLE {
        return;
    }
    let [xx, yy, zz, xy, xz, yz] = *velocity.inverse_inertia.entries();
    let (trace, squares) = (xx + yy + zz, xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz));
    // The sum of the squares of the principal values is the square of the greatest where the others are nothing beside it.
    if squares < trace * trace * (1.0 - 4.0 * NEEDLE) {
        return;
    }
    let axis = velocity.inverse_inertia.mul(velocity.angular).normalize_or_zero();
    let spin = velocity.angular.dot(axis);
    velocity.angular -= axis * (spin - spin.min(TURN_OF_NEEDLE / h));
}

fn settle(velocity: Vec3, limit: f32) -> Vec3 {
    let squared = velocity.length_squared();
    if squared > limit * limit {
        return velocity * (limit / squared.sqrt());
    }
    settled(velocity, NEGLIGIBLE_SPEED)
}
