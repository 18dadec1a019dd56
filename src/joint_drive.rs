//! Velocity of stops and joint frames that the host moves.
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
//! **Fewer edits than steps.** A host that edits once in several steps, as where physics goes at a rate of its own, moves at the way of
//! an edit over the time since the last one, if that is not long ago (`MAX_PAUSE`). Stop and frame go on at that speed until as much
//! time has passed again, when the next edit is due: they arrive that much later (`behind`), and never jump.

use glam::{DVec3, Vec3};

use crate::joint::{JointDef, JointKind, Limits, SphericalMotor};
use crate::pose::Pose;

/// Numbers of the rows of stops; the lower one of a coordinate, the upper one after it.
pub(crate) const STOP_ROWS: usize = 18;

/// Change of a rate below which it makes no difference (m/s, rad/s): a second-order substep may be off by as much anyhow, and it is
/// well above what rounding of a frame's rotation (1e-7 rad) comes to at 240 steps a second.
const NOTICEABLE: f32 = 1.0e-4;

/// Share of the greater of two rates by which they must differ for the change to be a blow and no smooth motion.
const SUDDEN: f32 = 0.5;

/// Time between two edits up to which they belong to one motion (s). Why: hosts edit at 30 times a second or more, and some skip a few;
/// what is put elsewhere twice in so short a time looks like a motion too. Test: tests/stops.rs.
const MAX_PAUSE: f32 = 0.1;

/// Share of a step that counts as a whole one: times are sums of `f32`.
const ALMOST: f32 = 0.999;

/// How fast stops and frames of a joint move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveRates {
    /// Of stops, by the number of their row (m/s, rad/s).
    pub stops: [f32; STOP_ROWS],
    /// Velocity of each joint point and angular velocity of each frame, in the axes of its body, or of the world (m/s, rad/s).
    pub frames: [[Vec3; 2]; 2],
    /// How long after the end of the step they arrive where the host has put them (s).
    pub behind: f32,
}

impl DriveRates {
    pub(crate) const NONE: Self = Self { stops: [0.0; STOP_ROWS], frames: [[Vec3::ZERO; 2]; 2], behind: 0.0 };

    pub(crate) fn is_finite(&self) -> bool {
        self.stops.iter().all(|rate| rate.is_finite())
            && self.frames.iter().flatten().all(|rate| rate.is_finite())
            && (0.0..=MAX_PAUSE).contains(&self.behind)
    }

    /// The same motion that arrives so much after the end of the step, at another share of its speed.
    fn at(&self, share: f32, behind: f32) -> Self {
        Self {
            stops: self.stops.map(|rate| rate * share),
            frames: self.frames.map(|frame| frame.map(|rate| rate * share)),
            behind,
        }
    }
}

/// What is known of a joint whose stops or frames have been moved of late.
#[derive(Debug, Clone)]
pub(crate) struct JointDrive {
    /// Where they were at the end of the last step.
    pub(crate) stops: [f32; STOP_ROWS],
    pub(crate) frames: [Pose; 2],
    /// How fast the last edit moved them, and how long ago the step was that it came before (s).
    pub(crate) found: DriveRates,
    pub(crate) since: f32,
    /// How fast they move in this one, as far as it is carried.
    pub(crate) carried: DriveRates,
    /// The same with frames in the axes of what the solver moves: unions in place of members, the world in place of static bodies.
    pub(crate) solved: DriveRates,
}

/// What the motion of a joint's stops and frames means for the step to come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DriveChange {
    /// It has stopped, for longer than a motion pauses.
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
            frames: [def.frame_a, def.frame_b],
            found: DriveRates::NONE,
            since: 0.0,
            carried: DriveRates::NONE,
            solved: DriveRates::NONE,
        }
    }

    /// Whether an edit from `before` to `after` moves a stop or a frame.
    pub(crate) fn is_moved(before: &JointDef, after: &JointDef) -> bool {
        before.frame_a != after.frame_a || before.frame_b != after.frame_b || stops_of(&before.kind) != stops_of(&after.kind)
    }

    /// Whether an edit from `before` to `after` has a motor ask for another speed at once, or any where there was none.
    pub(crate) fn is_motor_jolted(before: &JointDef, after: &JointDef) -> bool {
        let [before, after] = [before, after].map(|def| motor_speeds(&def.kind));
        before.into_iter().zip(after).any(|speeds| match speeds {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(before), Some(after)) => is_sudden(after - before, after, before),
        })
    }

    /// Whether a snapshot can have it.
    pub(crate) fn is_finite(&self) -> bool {
        let rates = [&self.found, &self.carried, &self.solved];
        let stops_are_numbers = self.stops.iter().all(|stop| !stop.is_nan());
        let frames = |pose: &Pose| pose.checked("frame", "frame").is_ok();
        let is_time = self.since >= 0.0 && self.since.is_finite();
        stops_are_numbers && is_time && self.frames.iter().all(frames) && rates.iter().all(|rates| rates.is_finite())
    }

    /// Begins a step of length `dt` (s), at whose end stops and frames are as `def` has them.
    pub(crate) fn begin_step(&mut self, def: &JointDef, dt: f32) -> DriveChange {
        let (stops, frames) = (stops_of(&def.kind), [def.frame_a, def.frame_b]);
        let is_edited = stops != self.stops || frames != self.frames;
        if !is_edited && self.carried.behind > 0.0 {
            return self.go_on(dt);
        }
        // Between edits of one motion it goes on for as long as there was between the last two.
        let goes_on = self.since == 0.0 || self.since + dt <= MAX_PAUSE;
        let (found, pause) = if goes_on { (self.found, self.since + dt) } else { (DriveRates::NONE, dt) };
        let mut now = DriveRates::NONE;
        for ((rate, &after), &before) in now.stops.iter_mut().zip(&stops).zip(&self.stops) {
            *rate = if after.is_finite() && before.is_finite() { (after - before) / pause } else { 0.0 };
        }
        now.frames = [0, 1].map(|side| rate_of(&self.frames[side], &frames[side], pause));
        let before = self.carried;
        let behind = if is_edited { (pause - dt).max(0.0) } else { 0.0 };
        let carried = DriveRates { behind, ..sustained(&now, &found) };
        let mut change = DriveChange { is_over: !is_edited && found == DriveRates::NONE, is_sudden: false, is_put: false };
        let parts = |rates: &DriveRates| {
            let [[a, b], [c, d]] = rates.frames;
            [a, b, c, d]
        };
        for ((now, carried), before) in parts(&now).into_iter().zip(parts(&carried)).zip(parts(&before)) {
            change.is_put |= (now - carried).length() > (SUDDEN * now.length()).max(NOTICEABLE);
            change.is_sudden |= is_sudden(carried - before, carried, before);
        }
        for (&carried, &before) in carried.stops.iter().zip(&before.stops) {
            change.is_sudden |= is_sudden(Vec3::X * (carried - before), Vec3::X * carried, Vec3::X * before);
        }
        let (found, since) = if is_edited { (now, 0.0) } else { (found, self.since + dt) };
        *self = Self { stops, frames, found, since, carried, solved: carried };
        change
    }

    /// Goes on for a step in which the host says nothing.
    fn go_on(&mut self, dt: f32) -> DriveChange {
        let left = self.carried.behind;
        // A step that is longer than what is left ends where the host has put it.
        self.carried =
            if left < dt * ALMOST { self.carried.at(left / dt, 0.0) } else { self.carried.at(1.0, (left - dt).max(0.0)) };
        if self.carried.behind < dt * (1.0 - ALMOST) {
            self.carried.behind = 0.0;
        }
        self.solved = self.carried;
        self.since += dt;
        DriveChange { is_over: false, is_sudden: false, is_put: false }
    }
}

fn is_sudden(change: Vec3, carried: Vec3, before: Vec3) -> bool {
    change.length() > (SUDDEN * carried.length().max(before.length())).max(NOTICEABLE)
}

/// Speeds that the motors of a joint ask for (m/s, rad/s), as far as they are on: that about a point as one, or those of each axis.
fn motor_speeds(kind: &JointKind) -> [Option<Vec3>; 6] {
    if let JointKind::Spherical { motor: SphericalMotor::Velocity { target, .. }, .. } = kind {
        return [Some(*target), None, None, None, None, None];
    }
    kind.drives().map(|driven| driven.map(|(drive, _)| Vec3::X * drive.velocity))
}

/// The share of `now` that was there before.
fn sustained(now: &DriveRates, before: &DriveRates) -> DriveRates {
    let mut carried = DriveRates::NONE;
    for ((carried, &now), &before) in carried.stops.iter_mut().zip(&now.stops).zip(&before.stops) {
        *carried = if now == 0.0 { 0.0 } else { now * (before / now).clamp(0.0, 1.0) };
    }
    carried.frames = [0, 1].map(|side| {
        [0, 1].map(|part| {
            let (now, before) = (now.frames[side][part], before.frames[side][part]);
            let square = now.length_squared();
            if square == 0.0 { Vec3::ZERO } else { now * (now.dot(before) / square).clamp(0.0, 1.0) }
        })
    });
    carried
}

/// Velocity and angular velocity of a frame that goes from one pose to another in `dt` (s).
fn rate_of(before: &Pose, after: &Pose, dt: f32) -> [Vec3; 2] {
    let turn = after.rotation.as_dquat() * before.rotation.as_dquat().conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let axis = DVec3::new(turn.x, turn.y, turn.z);
    let sine = axis.length();
    let angle_over_sine = if sine < 1.0e-9 { 2.0 } else { 2.0 * libm::atan2(sine, turn.w) / sine };
    let turn = if before.rotation == after.rotation { DVec3::ZERO } else { axis * angle_over_sine };
    let dt = f64::from(dt);
    [((after.position - before.position) / dt).as_vec3(), (turn / dt).as_vec3()]
}

/// Where the stops of a joint are, by the number of their row; infinite where it has none.
fn stops_of(kind: &JointKind) -> [f32; STOP_ROWS] {
    let mut stops = [f32::INFINITY; STOP_ROWS];
    let mut put = |row: usize, limits: &Limits| (stops[row], stops[row + 1]) = (limits.min, limits.max);
    match kind {
        JointKind::Fixed => {}
        JointKind::Hinge { limits, .. } | JointKind::Prismatic { limits, .. } | JointKind::Distance { limits, .. } => {
            put(0, limits);
        }
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            put(1, twist_limits);
            stops[0] = *swing_limit;
        }
        JointKind::Generic { linear, angular } => {
            linear.iter().chain(angular).enumerate().for_each(|(axis, def)| put(3 * axis, &def.limits));
        }
    }
    stops
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
        let steps = (0..20).take_while(|_| !drive.begin_step(&rope(4.0), dt).is_over).count();
        assert!((5..=6).contains(&steps), "over after {steps} steps at rest");
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

    #[test]
    fn a_motion_by_edits_once_in_several_steps_goes_on_between_them() {
        let dt = 1.0 / 240.0;
        let mut drive = JointDrive::from(&rope(5.0));
        let mut place = 5.0_f32;
        for step in 0..60 {
            // 1.2 m/s in edits of 60 a second.
            let length = 5.0 - 0.02 * (step / 4 + 1) as f32;
            drive.begin_step(&rope(length), dt);
            let end = length - drive.carried.stops[1] * drive.carried.behind;
            if step >= 4 {
                assert!((end - place + 1.2 * dt).abs() < 1.0e-4, "step {step}: from {place} m to {end} m");
            }
            place = end;
        }
    }
}
