//! Stops, frames and motor targets of a joint that the host moves: how fast, as the solver sees it.
//!
//! A host that lowers a rope's limit by 1 cm in every step reels it in at 0.6 m/s, and what hangs on it has to be drawn in at that speed:
//! a limit that only changed its place would shorten the rope and do no work. So the difference between two steps over the step's
//! length is a speed, which the rows of the joint carry as they carry that of a kinematic body.
//!
//! **Moved or put?** One edit may also put a limit somewhere else, and then nothing should be flung. The two are told apart by what
//! lasts: only the share of a rate that was there in the step before is carried,
//!
//! ```text
//! carried = now · min(1, max(0, now·before/|now|²)).
//! ```
//!
//! A single edit, however far, carries nothing: its error is taken out of positions, and leaves no velocity. A motion that goes on is
//! carried from its second step on, at any speed, scale and rate of steps, without a threshold. A motion that grows faster is carried
//! as it was a step ago, and what is missing is taken out of positions.
//!
//! **Targets of motors** are carried alike, as the speed of the motor's reference, where the host does not tell that itself: damping acts
//! on the difference to it, and a servo follows without a lag. A motor's bounded force makes no blow of a sudden change.

use glam::{DVec3, Quat, Vec3};

use crate::joint::{Joint, JointDef, JointKind, Limits, Motor, SphericalMotor};
use crate::pose::Pose;

/// Numbers of the rows of stops and motors: the lower stop of a coordinate, the upper one after it, then the motor.
pub(crate) const STOP_ROWS: usize = 18;

/// Change of a rate below which it makes no difference (m/s, rad/s): a second-order substep may be off by as much anyhow, and it is
/// well above what rounding of a frame's rotation (1e-7 rad) comes to at 240 steps a second.
const NOTICEABLE: f32 = 1.0e-4;

/// Share of the greater of two rates by which they must differ for the change to be a blow and no smooth motion.
const SUDDEN: f32 = 0.5;

/// How fast stops, motor targets and frames of a joint move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveRates {
    /// Of stops and motor targets, by the number of their row (m/s, rad/s).
    pub stops: [f32; STOP_ROWS],
    /// Of the rotation that a spherical joint's motor aims at, in A's joint frame (rad/s).
    pub aim: Vec3,
    /// Velocity of each joint point and angular velocity of each frame, in the axes of its body, or of the world (m/s, rad/s).
    pub frames: [[Vec3; 2]; 2],
}

impl DriveRates {
    pub(crate) const NONE: Self = Self { stops: [0.0; STOP_ROWS], aim: Vec3::ZERO, frames: [[Vec3::ZERO; 2]; 2] };

    pub(crate) fn is_finite(&self) -> bool {
        let frames_are = self.frames.iter().flatten().all(|rate| rate.is_finite());
        frames_are && self.aim.is_finite() && self.stops.iter().all(|rate| rate.is_finite())
    }
}

/// What is known of a joint whose stops or frames have been moved of late.
#[derive(Debug, Clone)]
pub(crate) struct JointDrive {
    /// Where they were at the end of the last step.
    pub(crate) stops: [f32; STOP_ROWS],
    pub(crate) aim: Option<Quat>,
    pub(crate) frames: [Pose; 2],
    /// How fast they moved in it.
    pub(crate) found: DriveRates,
    /// How fast they move in this one, as far as it is carried.
    pub(crate) carried: DriveRates,
    /// The same with frames in the axes of what the solver moves: unions in place of members, the world in place of static bodies.
    pub(crate) solved: DriveRates,
}

/// What the motion of a joint's stops and frames means for the step to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DriveChange {
    /// It has stopped, in the step before this one already.
    pub is_over: bool,
    /// Its rate has changed suddenly: what bodies did before says nothing of what they do now.
    pub is_sudden: bool,
    /// A frame has been put somewhere else.
    pub is_put: bool,
}

impl JointDrive {
    /// Of a joint whose stops and frames have not moved before an edit.
    pub(crate) fn from(def: &JointDef) -> Self {
        Self {
            stops: stops_of(&def.kind),
            aim: aim_of(&def.kind),
            frames: [def.frame_a, def.frame_b],
            found: DriveRates::NONE,
            carried: DriveRates::NONE,
            solved: DriveRates::NONE,
        }
    }

    /// Whether an edit from `before` to `after` moves a stop, a motor's target or a frame.
    pub(crate) fn is_moved(before: &JointDef, after: &JointDef) -> bool {
        let frames_are = before.frame_a != after.frame_a || before.frame_b != after.frame_b;
        frames_are || stops_of(&before.kind) != stops_of(&after.kind) || aim_of(&before.kind) != aim_of(&after.kind)
    }

    /// Whether a snapshot can have it.
    pub(crate) fn is_finite(&self) -> bool {
        let rates = [&self.found, &self.carried, &self.solved];
        let stops_are_numbers = self.stops.iter().all(|stop| !stop.is_nan());
        let frames = |pose: &Pose| pose.checked("frame", "frame").is_ok();
        let aims = self.aim.is_none_or(|aim| aim.is_finite());
        stops_are_numbers && aims && self.frames.iter().all(frames) && rates.iter().all(|rates| rates.is_finite())
    }

    /// Begins a step of length `dt` (s), at whose end stops and frames are as `def` has them.
    pub(crate) fn begin_step(&mut self, def: &JointDef, dt: f32) -> DriveChange {
        let (stops, aim, frames) = (stops_of(&def.kind), aim_of(&def.kind), [def.frame_a, def.frame_b]);
        let mut now = DriveRates::NONE;
        for ((rate, &after), &before) in now.stops.iter_mut().zip(&stops).zip(&self.stops) {
            *rate = if after.is_finite() && before.is_finite() { (after - before) / dt } else { 0.0 };
        }
        if let (Some(before), Some(after)) = (self.aim, aim) {
            now.aim = turning(before, after, dt);
        }
        now.frames = [0, 1].map(|side| rate_of(&self.frames[side], &frames[side], dt));
        let (found, before) = (self.found, self.carried);
        let carried = sustained(&now, &found);
        let mut change = DriveChange { is_over: now == DriveRates::NONE && found == now, is_sudden: false, is_put: false };
        let parts = |rates: &DriveRates| {
            let [[a, b], [c, d]] = rates.frames;
            [a, b, c, d]
        };
        for ((now, carried), before) in parts(&now).into_iter().zip(parts(&carried)).zip(parts(&before)) {
            change.is_put |= (now - carried).length() > (SUDDEN * now.length()).max(NOTICEABLE);
            change.is_sudden |= is_sudden(carried - before, carried, before);
        }
        for (row, (&carried, &before)) in carried.stops.iter().zip(&before.stops).enumerate() {
            if is_motor(&def.kind, row) {
                continue;
            }
            change.is_sudden |= is_sudden(Vec3::X * (carried - before), Vec3::X * carried, Vec3::X * before);
        }
        *self = Self { stops, aim, frames, found: now, carried, solved: carried };
        change
    }
}

impl Joint {
    /// How fast its stops, motor targets and frames move in this step, if at all.
    pub(crate) fn drive(&self) -> Option<&DriveRates> {
        self.drive.as_ref().map(|drive| &drive.solved)
    }
}

fn is_sudden(change: Vec3, carried: Vec3, before: Vec3) -> bool {
    change.length() > (SUDDEN * carried.length().max(before.length())).max(NOTICEABLE)
}

/// The share of `now` that was there before.
fn sustained(now: &DriveRates, before: &DriveRates) -> DriveRates {
    let mut carried = DriveRates::NONE;
    for ((carried, &now), &before) in carried.stops.iter_mut().zip(&now.stops).zip(&before.stops) {
        *carried = if now == 0.0 { 0.0 } else { now * (before / now).clamp(0.0, 1.0) };
    }
    let lasting = |now: Vec3, before: Vec3| {
        let square = now.length_squared();
        if square == 0.0 { Vec3::ZERO } else { now * (now.dot(before) / square).clamp(0.0, 1.0) }
    };
    carried.aim = lasting(now.aim, before.aim);
    carried.frames = [0, 1].map(|side| [0, 1].map(|part| lasting(now.frames[side][part], before.frames[side][part])));
    carried
}

/// Velocity and angular velocity of a frame that goes from one pose to another in `dt` (s).
fn rate_of(before: &Pose, after: &Pose, dt: f32) -> [Vec3; 2] {
    let moved = (after.position - before.position) / f64::from(dt);
    [moved.as_vec3(), turning(before.rotation, after.rotation, dt)]
}

/// Angular velocity of what turns from one rotation to another in `dt` (s), the shorter way.
fn turning(before: Quat, after: Quat, dt: f32) -> Vec3 {
    if before == after {
        return Vec3::ZERO;
    }
    let turn = after.as_dquat() * before.as_dquat().conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let axis = DVec3::new(turn.x, turn.y, turn.z);
    let sine = axis.length();
    let angle_over_sine = if sine < 1.0e-9 { 2.0 } else { 2.0 * libm::atan2(sine, turn.w) / sine };
    (axis * (angle_over_sine / f64::from(dt))).as_vec3()
}

/// Where the stops and motor targets of a joint are, by the number of their row; infinite where it has none.
fn stops_of(kind: &JointKind) -> [f32; STOP_ROWS] {
    let mut stops = [f32::INFINITY; STOP_ROWS];
    let mut put = |row: usize, limits: &Limits, motor: &Motor| {
        (stops[row], stops[row + 1], stops[row + 2]) = (limits.min, limits.max, target_of(motor));
    };
    match kind {
        JointKind::Fixed => {}
        JointKind::Hinge { limits, motor } | JointKind::Prismatic { limits, motor } => put(0, limits, motor),
        JointKind::Distance { limits, spring_length, motor } => {
            put(0, limits, motor);
            stops[3] = spring_length.unwrap_or(f32::INFINITY);
        }
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            put(1, twist_limits, &Motor::Off);
            stops[0] = *swing_limit;
        }
        JointKind::Generic { linear, angular } => {
            linear.iter().chain(angular).enumerate().for_each(|(axis, def)| put(3 * axis, &def.limits, &def.motor));
        }
    }
    stops
}

/// Whether this row is that of a motor.
fn is_motor(kind: &JointKind, row: usize) -> bool {
    match kind {
        JointKind::Fixed | JointKind::Spherical { .. } => false,
        JointKind::Hinge { .. } | JointKind::Prismatic { .. } | JointKind::Distance { .. } => row == 2,
        JointKind::Generic { .. } => row % 3 == 2,
    }
}

/// Where a motor goes to; infinite where it goes nowhere, or where the host tells the speed of its target.
fn target_of(motor: &Motor) -> f32 {
    let drive = motor.drive().filter(|drive| drive.velocity == 0.0);
    drive.and_then(|drive| drive.target).unwrap_or(f32::INFINITY)
}

/// The rotation that a spherical joint's motor aims at.
fn aim_of(kind: &JointKind) -> Option<Quat> {
    match *kind {
        JointKind::Spherical { motor: SphericalMotor::Position { target, .. }, .. } => Some(target),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::BodyId;

    fn rope(max: f32) -> JointDef {
        let limits = Limits::new(0.0, max);
        let kind = JointKind::Distance { limits, spring_length: None, motor: crate::joint::Motor::Off };
        JointDef::new(kind, BodyId::NULL, BodyId::NULL)
    }

    #[test]
    fn a_single_edit_carries_nothing_and_a_motion_that_lasts_is_carried() {
        let dt = 1.0 / 60.0;
        let mut drive = JointDrive::from(&rope(5.0));
        let first = drive.begin_step(&rope(4.0), dt);
        assert_eq!((drive.carried, first.is_sudden, first.is_over), (DriveRates::NONE, false, false), "put from 5 m to 4 m");
        drive.begin_step(&rope(4.0), dt);
        assert!(drive.begin_step(&rope(4.0), dt).is_over, "at rest for two steps");
        let mut length = 4.0;
        for step in 0..4 {
            length -= 0.02;
            let change = drive.begin_step(&rope(length), dt);
            assert_eq!(change.is_sudden, step == 1, "reeled in at 1.2 m/s for {step} steps");
        }
        assert!((drive.carried.stops[1] + 1.2).abs() < 1.0e-4, "carried {} of -1.2 m/s", drive.carried.stops[1]);
        assert!(drive.begin_step(&rope(length), dt).is_sudden, "held again");
        assert_eq!(drive.carried, DriveRates::NONE);
    }
}
