//! Quantised poses: the pose for which a pair's manifolds were made. A step of the quantisation is an eighth to a fourth of the
//! tolerance, so that a pair at rest takes a few bits of a snapshot.

use glam::{Quat, Vec3};
use parry3d::math::Pose3;

/// Steps of a pose, in shares of the smaller shape's extent and in radians.
const SHIFT_STEP: f32 = 1.0 / 8192.0;
pub(crate) const TURN_STEP: f32 = 1.0 / 16384.0;

/// Step of the translation that a pair remembers whose shapes have this lesser least extent (m), a power of two; the rotation's is
/// [`TURN_STEP`].
pub(crate) fn pose_unit(extent: f32) -> f32 {
    const EXPONENT: u32 = 0x7f80_0000;
    f32::from_bits(extent.to_bits() & EXPONENT) * SHIFT_STEP
}

/// A pose in steps, as a pair remembers it: its rotation in numbers of [`TURN_STEP`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct QuantizedPose {
    turn: [i16; 4],
    translation: [f32; 3],
}

impl QuantizedPose {
    pub(super) const IDENTITY: Self = Self { turn: [0, 0, 0, (1.0 / TURN_STEP) as i16], translation: [0.0; 3] };

    pub(super) fn of(pose: &Pose3) -> Self {
        let turn = pose.rotation.to_array().map(|x| (x / TURN_STEP) as i16);
        Self { turn, translation: pose.translation.to_array() }
    }

    pub(super) fn exact(&self) -> Pose3 {
        let [x, y, z, w] = self.turn.map(|steps| f32::from(steps) * TURN_STEP);
        Pose3::from_parts(self.translation.into(), Quat::from_xyzw(x, y, z, w))
    }
}

/// A pose in steps of `unit` and [`TURN_STEP`].
pub(crate) fn coarse(pose: &Pose3, unit: f32) -> Pose3 {
    let (p, q) = (pose.translation, pose.rotation);
    let turn = |x: f32| in_steps(x, TURN_STEP);
    Pose3::from_parts(
        Vec3::from_array(p.to_array().map(|x| in_steps(x, unit))),
        Quat::from_xyzw(turn(q.x), turn(q.y), turn(q.z), turn(q.w)),
    )
}

fn in_steps(x: f32, unit: f32) -> f32 {
    // Added to a number whose last bit is one, a float is rounded to whole numbers.
    const ONES: f32 = 12_582_912.0;
    let steps = x / unit;
    if steps.abs() < 4.0e6 { ((steps + ONES) - ONES) * unit } else { x }
}
