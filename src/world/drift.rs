//! Decides whether a quiet island is still going somewhere, however slowly.
//!
//! Speed alone does not tell: a motor may turn by a milliradian a second, an embedded body is pushed out without any velocity, and a spring
//! that turns back stands still for a moment. So poses tell. While a body is quiet its *drift* follows the rate at which its pose changes,
//! averaged over some [`DRIFT_TIME`], so that what trembles in place has none. An island sleeps once none of its bodies drifts by more than
//! a share of the speeds at which bodies are quiet, nor ever faster, and none of its joints is at work. A long body goes where its far end
//! goes: as fast as it turns times its reach.
//!
//! What is out of balance is slow at first: a plank whose centre is a little beyond an edge. What rolls up a slope is slow where it turns
//! back. But the drift of both changes: at the rate a, from rest, either would not be quiet any more within [`GROWTH_AHEAD`], and is kept
//! awake. The sign of its speed says nothing: it passes zero at a turning point, and a does not. Two changes must agree on a, as far as they
//! go in one direction: that of the drift over [`GROWTH_TIME`], and that of the velocity over [`DRIFT_TIME`], which is over as soon as a body
//! has come to rest. What sways changes its velocity too, but no longer where it is fastest, and sleeps there.
//!
//! A joint is at work so:
//!
//! * A motor that holds a speed, or is on its way at the greatest it may have, is at work while its joint follows it at
//!   [`FOLLOWED_SHARE`] of that or more. One that is stalled is not, unless it pushes harder in each step: sweeps bring a load on a light body to
//!   bear over many steps. At the rate at which its force grows it would be [`FOLLOWED_SHARE`] greater within [`GROWTH_AHEAD`].
//! * A spring of stiffness k with a damper c that creeps at the rate r has r c/k left to where it balances whatever else bears on it, for the
//!   damper carries what the spring is out of balance by. It is at work while that is more than [`ARRIVED`].
//! * A spring that swings at the angular frequency ω passes its balance at the rate of ω times its amplitude, and is slow where it turns back.
//!   It must have been slower than ω times [`ARRIVED`] for a quarter of its period, which takes it from there to where it is fastest.
//!
//! A joint that bears more than the load from which on it is reported is at work, too: the host is told of that load in each step.
//!
//! Where a joint is at work, the island is watched from half the time on again.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Quat, Vec3};

use super::World;
use crate::body::{Body, Drift, SleepState};
use crate::joint::{Axis, JointKind, Motor, Softness, SphericalMotor};
use crate::joint_record::Joint;
use crate::settings::SleepSettings;
use crate::solve::joint::{axis_of, gap_of, placement_of};
pub(super) use crate::tuning::drift::WATCHED_AGAIN;
use crate::tuning::drift::{
    ARRIVED, CREEP_SHARE, DRIFT_TIME, FOLLOWED_SHARE, GROWTH_AHEAD, GROWTH_TIME, MAX_TIME, MAX_WATCHED, RIGID_TIME,
    TOUCHING_CREEP_SHARE,
};

impl Drift {
    /// Follows a body that moves from one pose to another in a step of `dt` (s); from nothing, if it has just become quiet.
    pub(crate) fn follow(&mut self, (from, to): ((DVec3, Quat), (DVec3, Quat)), dt: f32, is_new: bool) {
        let turn = to.1 * from.1.conjugate();
        let sine = 2.0 / dt * if turn.w < 0.0 { -turn.xyz() } else { turn.xyz() };
        let rate = [(to.0 - from.0).as_vec3() / dt, sine];
        let [share, share_before] = [DRIFT_TIME, GROWTH_TIME].map(|time| if is_new { 1.0 } else { dt / (dt + time) });
        self.linear += (rate[0] - self.linear) * share;
        self.angular += (rate[1] - self.angular) * share;
        self.linear_before += (self.linear - self.linear_before) * share_before;
        self.angular_before += (self.angular - self.angular_before) * share_before;
    }

    /// Whether it is below these speeds (m/s, rad/s).
    fn is_below(&self, [linear, angular]: [f32; 2]) -> bool {
        self.linear.length() <= linear && self.angular.length() <= angular
    }

    /// Whether it changes at such a rate that a body with these velocities (m/s, rad/s) will be above these speeds within [`GROWTH_AHEAD`],
    /// from now on or from rest: a mean over the time T lags by a T behind what grows at the rate a.
    fn leads_past(&self, limits: [f32; 2], [linear, angular]: [Vec3; 2]) -> bool {
        let leads = |drift: Vec3, before: Vec3, velocity: Vec3, limit: f32| {
            let [change, latest] = [(drift - before) / GROWTH_TIME, (velocity - drift) / DRIFT_TIME];
            let agreed = (latest.dot(change) / change.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            let gained = change * (agreed * GROWTH_AHEAD);
            gained.length().max((drift + gained).length()) > limit
        };
        leads(self.linear, self.linear_before, linear, limits[0]) || leads(self.angular, self.angular_before, angular, limits[1])
    }
}

/// Whether a body with these velocities is slow enough to be quiet.
pub(super) fn is_slow(limits: &SleepSettings, linear: Vec3, angular: Vec3) -> bool {
    linear.length() <= limits.linear_speed && angular.length() <= limits.angular_speed
}

/// How long a body has been quiet (s), and its drift, a step of `dt` later.
pub(super) fn quiet_after(body: &Body, touches: bool, limits: &SleepSettings, dt: f32) -> (f32, Drift) {
    let SleepState::Awake { quiet_for, drift } = body.sleep else { return (0.0, Drift::default()) };
    // What is held keeps its pose.
    let drift = if body.held { Drift::default() } else { drift };
    let speeds = [limits.linear_speed, limits.angular_speed];
    if !body.settings.can_sleep || !is_slow(limits, body.linear_velocity, body.angular_velocity) || !drift.is_below(speeds) {
        return (0.0, drift);
    }
    let creeps = !drift.is_below(creep_speeds(limits, touches));
    // Where a pendulum turns back it creeps for a moment only. What is counted has an end, for each count changes the record.
    let most = if creeps { WATCHED_AGAIN * limits.time } else { limits.time + MAX_WATCHED };
    ((quiet_for + dt).min(most), drift)
}

/// Drift of a body that goes somewhere (m/s, rad/s).
fn creep_speeds(limits: &SleepSettings, touches: bool) -> [f32; 2] {
    let share = if touches { TOUCHING_CREEP_SHARE } else { CREEP_SHARE };
    [limits.linear_speed, limits.angular_speed].map(|speed| speed * share)
}

/// One side of a joint: how its body drifts, and how far its joint point is from its centre of mass (m).
struct JointEnd<'a> {
    body: Option<&'a Body>,
    drift: Drift,
    lever: Vec3,
}

impl JointEnd<'_> {
    fn point_rate(&self) -> Vec3 {
        self.drift.linear + self.drift.angular.cross(self.lever)
    }

    /// Inverse inertia about an axis through the joint point (1/(kg·m²)).
    fn inverse_inertia(&self, axis: Vec3) -> f32 {
        let Some(body) = self.body.filter(|body| body.is_free()) else { return 0.0 };
        let (free, mass) = (axis.dot(body.world_inverse_inertia() * axis), body.mass.as_ref().map_or(0.0, |mass| mass.mass));
        free / (1.0 + free * mass * self.lever.cross(axis).length_squared())
    }

    fn inverse_mass(&self) -> f32 {
        self.body.map_or(0.0, Body::inverse_mass)
    }
}

/// Axes whose motor pushes harder, at these forces before and after a step of `dt` (N, N·m; s), as bits.
pub(super) fn straining(before: &[f32; 6], after: &[f32; 6], dt: f32) -> u8 {
    let grows = |axis: usize| {
        let (before, after) = (before[axis].abs(), after[axis].abs());
        (after - before) * GROWTH_AHEAD > FOLLOWED_SHARE * after * dt
    };
    (0..6).fold(0, |bits, axis| bits | u8::from(grows(axis)) << axis)
}

/// Whether a joint moves towards something, given what it does along or about one of its axes.
struct DriftCoordinate {
    /// Its rate (m/s or rad/s).
    rate: f32,
    /// Inverse mass or inertia that it moves (1/kg or 1/(kg·m²)).
    inverse_mass: f32,
    is_angle: bool,
}

impl DriftCoordinate {
    fn motor_works(&self, motor: &Motor, quiet_for: f32) -> bool {
        let Some(drive) = motor.drive().filter(|drive| drive.max_force > 0.0) else { return false };
        let follows = |speed: f32| speed != 0.0 && self.rate * speed >= FOLLOWED_SHARE * speed * speed;
        // On the way to a target at the greatest speed that is allowed, however slow that is.
        let is_on_its_way = drive.max_speed.is_finite() && (follows(drive.max_speed) || follows(-drive.max_speed));
        follows(drive.velocity) || drive.target.is_some() && (is_on_its_way || self.spring_works(&drive.softness, quiet_for))
    }

    fn spring_works(&self, softness: &Softness, quiet_for: f32) -> bool {
        let Softness { compliance, damping } = *softness;
        // Time in which an undamped one turns by a radian of its period.
        let swing = (compliance / self.inverse_mass).sqrt();
        let time = if compliance > 0.0 { swing.max(damping * compliance) } else { RIGID_TIME };
        let left = self.rate.abs() * time.min(MAX_TIME);
        left > ARRIVED[usize::from(self.is_angle)] || quiet_for < (FRAC_PI_2 * swing).min(MAX_WATCHED)
    }
}

impl World {
    /// Whether anything in an island that has been quiet for so long (s) is still going somewhere.
    pub(super) fn goes_somewhere(&self, members: &[u32], quiet_for: f32) -> bool {
        members.iter().any(|&index| {
            let joints = self.bodies[index].joints.iter().filter_map(|&id| self.joints.find(id).ok());
            self.creeps(index) || joints.into_iter().any(|slot| self.joint_works(slot, quiet_for))
        })
    }

    /// Whether a body goes somewhere, if slowly: on the whole, or with the end that is farthest from its centre of mass.
    pub(super) fn creeps(&self, index: u32) -> bool {
        let touches = self.collision.index.contact_force(index) != Vec3::ZERO;
        !self.drift_of(index).is_below(creep_speeds(&self.quiet_limits(index), touches))
    }

    /// Whether a body is slow, but its velocity changes in such a way that it will not be for long.
    pub(super) fn gathers_speed(&self, index: u32) -> bool {
        let SleepSettings { linear_speed, angular_speed, .. } = self.quiet_limits(index);
        let body = &self.bodies[index];
        self.drift_of(index).leads_past([linear_speed, angular_speed], [body.linear_velocity, body.angular_velocity])
    }

    /// Speeds at which a body is quiet, and its far end as well.
    fn quiet_limits(&self, index: u32) -> SleepSettings {
        let limits = &self.def.sleep;
        let far_end = limits.linear_speed / self.reach_of(&self.bodies[index]);
        SleepSettings { angular_speed: limits.angular_speed.min(far_end), ..*limits }
    }

    fn drift_of(&self, index: u32) -> Drift {
        match self.bodies[index].sleep {
            SleepState::Awake { drift, .. } if self.bodies[index].is_free() => drift,
            _ => Drift::default(),
        }
    }

    /// Whether a rigid motor of a joint pushes harder and harder short of where it is to go.
    fn motor_strains(&self, joint: &Joint) -> bool {
        if joint.straining == 0 {
            return false;
        }
        let placement = self.placement(joint);
        joint.def.kind.drives().iter().enumerate().any(|(axis, driven)| {
            let Some((drive, limits)) = driven.filter(|_| joint.straining >> axis & 1 == 1) else { return false };
            // The axes of a spherical joint's motor have no place, and no limits.
            let reading = axis_of(&joint.def.kind, &placement, joint.angles, axis);
            let (at, turns) = reading.map_or((0.0, true), |reading| (reading.position as f32, reading.turns));
            let left = match drive.target {
                Some(target) => (target.clamp(limits.min, limits.max) - at).abs(),
                None if drive.velocity > 0.0 => limits.max - at,
                None if drive.velocity < 0.0 => at - limits.min,
                None => 0.0,
            };
            drive.softness.compliance == 0.0 && left > ARRIVED[usize::from(turns)]
        })
    }

    /// Whether a joint moves its bodies towards something, or bears more than its limit.
    fn joint_works(&self, slot: u32, quiet_for: f32) -> bool {
        let joint = &self.joints[slot];
        if joint.is_overloaded() || self.motor_strains(joint) {
            return true;
        }
        let ends = [self.end(joint, 0), self.end(joint, 1)];
        let [a, b] = [0, 1].map(|side| JointEnd {
            body: joint.bodies[side].map(|index| &self.bodies[index]),
            drift: joint.bodies[side].map_or_else(Drift::default, |index| self.drift_of(index)),
            lever: ends[side].lever,
        });
        let (point_rate, turning) = (b.point_rate() - a.point_rate(), b.drift.angular - a.drift.angular);
        let along = |axis: Vec3| {
            let inverse_mass = a.inverse_mass() + b.inverse_mass();
            DriftCoordinate { rate: point_rate.dot(axis), inverse_mass, is_angle: false }
        };
        let about = |axis: Vec3| {
            let inverse_mass = a.inverse_inertia(axis) + b.inverse_inertia(axis);
            DriftCoordinate { rate: turning.dot(axis), inverse_mass, is_angle: true }
        };
        let frames = [ends[0].frame, ends[1].frame];
        let spring = |softness: &Softness, coordinate: DriftCoordinate| {
            softness.compliance > 0.0 && coordinate.spring_works(softness, quiet_for)
        };
        let direction = |rate: Vec3| rate.try_normalize().unwrap_or(frames[0] * Vec3::X);
        let gives =
            spring(&joint.def.linear, along(direction(point_rate))) || spring(&joint.def.angular, about(direction(turning)));
        gives
            || match &joint.def.kind {
                JointKind::Fixed => false,
                JointKind::Hinge { motor, .. } => about(frames[0] * Vec3::X).motor_works(motor, quiet_for),
                JointKind::Prismatic { motor, .. } => along(frames[0] * Vec3::X).motor_works(motor, quiet_for),
                JointKind::Distance { motor, .. } => {
                    let apart = (ends[1].origin - ends[0].origin).as_vec3() + b.lever - a.lever;
                    along(direction(apart)).motor_works(motor, quiet_for)
                }
                JointKind::Spherical { motor, .. } => match *motor {
                    SphericalMotor::Off => false,
                    SphericalMotor::Velocity { target, max_torque } => {
                        let (axis, target) = (frames[0] * target.normalize_or_zero(), target.length());
                        about(axis).motor_works(&Motor::Velocity { target, max_force: max_torque }, quiet_for)
                    }
                    SphericalMotor::Position { softness, max_torque, .. } => {
                        max_torque > 0.0 && about(direction(turning)).spring_works(&softness, quiet_for)
                    }
                },
                JointKind::Generic { linear, angular } => {
                    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| frames[0] * axis);
                    let works = |coordinate: DriftCoordinate, axis: &Axis| coordinate.motor_works(&axis.motor, quiet_for);
                    let slides = [x, y, z].into_iter().zip(linear).any(|(axis, def)| works(along(axis), def));
                    slides || turning_axes(frames).into_iter().zip(angular).any(|(axis, def)| works(about(axis), def))
                }
            }
    }

    /// Worst distance between joint points of an island beyond what their joints allow (m).
    pub(super) fn gap_of_island(&self, members: &[u32]) -> f32 {
        let joints = members.iter().flat_map(|&index| &self.bodies[index].joints).filter_map(|&id| self.joints.find(id).ok());
        joints.map(|slot| self.joint_gap(&self.joints[slot])).fold(0.0, f32::max)
    }

    fn joint_gap(&self, joint: &Joint) -> f32 {
        let [a, b] = [self.end(joint, 0), self.end(joint, 1)];
        let frames = [a.frame, b.frame].map(|frame| frame.as_dquat().normalize());
        let placement = placement_of(b.origin - a.origin, [a.lever.as_dvec3(), b.lever.as_dvec3()], frames);
        gap_of(&joint.def.kind, &placement) as f32
    }
}

/// Axes that x·y·z Euler angles between two frames turn about: x of the first, z of the second, and the one across both.
fn turning_axes(frames: [Quat; 2]) -> [Vec3; 3] {
    let (x, z) = (frames[0] * Vec3::X, frames[1] * Vec3::Z);
    [x, z.cross(x).normalize_or(frames[0] * Vec3::Y), z]
}
