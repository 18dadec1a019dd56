//! One joint of a batch: where it is, what it has carried, and which rows it may have.

use glam::{DQuat, DVec3, Vec3};

use super::geometry::{Placement, WorldFrame};
use super::{IMPLICIT_RANGE, JointTraits, LocalPose, angles, driven, kinds, stance};
use crate::id::{JointId, Pool};
use crate::joint::JointKind;
use crate::joint_drive::DriveRates;
use crate::joint_rebounds::Rebounds;
use crate::joint_record::{Joint, JointImpulses};
use crate::solve::integrate::PredictedPose;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Way of an angle in a step from which on it is read off the rotation again (rad).
const MAX_SUMMED: f64 = 0.5;

/// The motors of a joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointMotors {
    /// Sums of their multipliers over the substeps, by axis (N·s, N·m·s).
    pub sums: [f32; 6],
    pub rows: kinds::MotorRows,
    /// Whether one of its bodies has other joints too.
    pub are_chained: bool,
}

impl JointMotors {
    /// Those of a joint without any.
    pub(crate) const NONE: Self = Self { sums: [0.0; 6], rows: kinds::MotorRows::None, are_chained: false };
}

/// One joint as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointEntry {
    /// Slot in the world's pool.
    pub joint: u32,
    pub a: u32,
    pub b: u32,
    /// From A's origin to B's at the start of the step (m); the origin is the centre of mass, or the joint point of a fixed side.
    pub offset: DVec3,
    /// Joint point from the origin, in the body's frame (m).
    pub local_lever: [DVec3; 2],
    /// Joint frame in the body's frame.
    pub local_frame: [DQuat; 2],
    pub impulses: JointImpulses,
    /// Its angles near those of now, turns counted (rad).
    pub angles: [f64; 3],
    /// Sums over the substeps of the impulses on B (N·s, N·m·s).
    pub linear_sum: Vec3,
    pub angular_sum: Vec3,
    /// Of the last substep, if a direct solve took it; what its multipliers moved by last, if a sheet did.
    pub acted: [Vec3; 2],
    /// Restitution of its stops, and those that are to be left at a speed.
    pub restitution: f32,
    pub rebounds: Rebounds,
    /// Scalar rows that ended a substep with a positive multiplier, as bits.
    pub pressed: u32,
    pub motors: JointMotors,
    pub traits: JointTraits,
    /// Whether it is a hinge, and whether it holds a distance.
    pub is_hinge: bool,
    pub is_distance: bool,
    /// Whether it has angles that count turns.
    pub counts_turns: bool,
    /// Whether there is a force or torque above which it is overloaded.
    pub can_be_overloaded: bool,
}

impl JointEntry {
    /// The same with multipliers of substeps that are so many times as long.
    pub(crate) fn scaled(self, factor: f32) -> Self {
        Self { impulses: self.impulses.scaled(factor), acted: self.acted.map(|acted| acted * factor), ..self }
    }

    /// Distance of its points, as a share of its levers, if it holds them together without give; else zero.
    pub(super) fn opening(&self, joints: &Pool<Joint, JointId>, motions: &[BodyMotion]) -> f64 {
        let def = &joints[self.joint].def;
        let holds_points = matches!(def.kind, JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. });
        if !holds_points || def.linear.compliance > 0.0 {
            return 0.0;
        }
        let levers = self.local_lever[0].length() + self.local_lever[1].length();
        let points = self.points(&motions[self.a as usize].stance(), &motions[self.b as usize].stance());
        points.gap.length() / levers.max(f64::MIN_POSITIVE)
    }

    /// What of the motion of its two sides its rows leave against each other: of the speeds of its points in directions that it holds, over
    /// the greater of the two, and of spins likewise, the greater share.
    pub(crate) fn missed(&self, kind: &JointKind, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> f32 {
        let placement = self.placement(motions[self.a as usize].stance(), motions[self.b as usize].stance());
        let half_gap = placement.gap * 0.5;
        let arms = [placement.a.lever + half_gap, placement.b.lever - half_gap].map(|arm| arm.as_vec3());
        let [a, b] = [self.a, self.b].map(|slot| &velocities[slot as usize]);
        let points = [a.linear + a.angular.cross(arms[0]), b.linear + b.angular.cross(arms[1])];
        let axis = (placement.a.frame * DVec3::X).as_vec3();
        let (rate, turn) = (points[1] - points[0], b.angular - a.angular);
        let across = |v: Vec3| v - axis * axis.dot(v);
        let (open, askew) = match kind {
            JointKind::Fixed => (rate, turn),
            JointKind::Hinge { .. } => (rate, across(turn)),
            JointKind::Spherical { .. } => (rate, Vec3::ZERO),
            JointKind::Prismatic { .. } => (across(rate), turn),
            JointKind::Distance { .. } | JointKind::Generic { .. } => (Vec3::ZERO, Vec3::ZERO),
        };
        let share = |missed: Vec3, [a, b]: [Vec3; 2]| missed.length() / a.length().max(b.length()).max(f32::MIN_POSITIVE);
        share(open, points).max(share(askew, [a.angular, b.angular]))
    }

    pub(crate) fn placement(&self, a: LocalPose, b: LocalPose) -> Placement {
        let side = |rotation: DQuat, i: usize| WorldFrame {
            lever: rotation * self.local_lever[i],
            frame: rotation * self.local_frame[i],
        };
        let (side_a, side_b) = (side(a.1, 0), side(b.1, 1));
        Placement { a: side_a, b: side_b, gap: self.offset + (b.0 - a.0) + (side_b.lever - side_a.lever) }
    }

    /// Brings its angles up to where it is placed now: neither body has turned by half a turn against the other since.
    pub(crate) fn follow(&mut self, kind: &JointKind, placement: &Placement) {
        self.angles = angles::read(kind, placement, self.angles);
    }

    /// Brings the angle of a joint in lanes from the start of the step up to now.
    ///
    /// The turns of the bodies in the step say which turn it is in. What they add up to is off by little, and whoever asks for the
    /// angle takes the nearest that the rotation allows; so that is looked for once in about a radian alone.
    pub(super) fn follow_step(&mut self, kind: &JointKind, motions: &[BodyMotion]) {
        let (a, b) = (&motions[self.a as usize], &motions[self.b as usize]);
        let turned = b.turn - a.turn;
        if turned == Vec3::ZERO {
            return;
        }
        let before = self.angles[0];
        let way = if matches!(kind, JointKind::Hinge { .. }) {
            f64::from((a.rotation * (self.local_frame[0] * DVec3::X).as_vec3()).dot(turned))
        } else {
            let placement = self.placement(a.stance(), b.stance());
            angles::rates(kind, &placement, self.angles, turned.as_dvec3())[0]
        };
        self.angles[0] += way;
        if way.abs() > MAX_SUMMED || before.floor() != self.angles[0].floor() {
            self.follow(kind, &self.placement(a.stance(), b.stance()));
        }
    }

    /// The joint points alone; frames are left out.
    pub(crate) fn points(&self, a: &LocalPose, b: &LocalPose) -> Placement {
        let side = |rotation: DQuat, i: usize| WorldFrame { lever: rotation * self.local_lever[i], frame: DQuat::IDENTITY };
        let (side_a, side_b) = (side(a.1, 0), side(b.1, 1));
        Placement { a: side_a, b: side_b, gap: self.offset + (b.0 - a.0) + (side_b.lever - side_a.lever) }
    }

    /// Where the joint is at the start of a substep of length `h`, where at its end, and where its rows are taken.
    ///
    /// `drive` is how its stops and frames move, and `left` how far start and end are from the end of the step (s).
    pub(super) fn search(
        &self,
        (velocities, motions, predicted_poses): (&[BodyVelocity], &[BodyMotion], &[PredictedPose]),
        h: f32,
        drive: Option<&DriveRates>,
        left: [f64; 2],
    ) -> [Placement; 3] {
        let (a, b) = (self.a as usize, self.b as usize);
        let now = |slot: usize| motions[slot].stance();
        let then = |slot: usize| stance((predicted_poses[slot].displacement, predicted_poses[slot].rotation));
        let placed = |a: LocalPose, b: LocalPose, left: f64| driven::before(self.placement(a, b), drive, [&a, &b], left);
        let start = placed(now(a), now(b), left[0]);
        let end = placed(then(a), then(b), left[1]);
        let stiffness = h
            * self.impulses.point.length()
            * (turning_ease(&velocities[a], start.a.lever.as_vec3()) + turning_ease(&velocities[b], start.b.lever.as_vec3()));
        let implicit = ((stiffness - IMPLICIT_RANGE.0) / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0)).clamp(0.0, 1.0);
        let gradient = if implicit == 0.0 {
            start
        } else if implicit == 1.0 {
            end
        } else {
            let blend = |slot: usize| {
                let (from, to) = (now(slot), then(slot));
                (from.0.lerp(to.0, f64::from(implicit)), from.1.lerp(to.1, f64::from(implicit)))
            };
            placed(blend(a), blend(b), left[0] + (left[1] - left[0]) * f64::from(implicit))
        };
        [start, end, gradient]
    }
}

/// How readily a transverse force at `lever` turns a body, over the lever's length: |r| tr(I⁻¹ across r) (1/(kg·m)).
fn turning_ease(body: &BodyVelocity, lever: Vec3) -> f32 {
    let length = lever.length();
    if length == 0.0 {
        return 0.0;
    }
    let axis = lever / length;
    let [xx, yy, zz, ..] = *body.inverse_inertia.entries();
    length * (xx + yy + zz - axis.dot(body.inverse_inertia.mul(axis)))
}

#[cfg(test)]
impl JointEntry {
    /// A joint that holds nothing and has carried nothing.
    pub(crate) const NONE: Self = Self {
        joint: 0,
        a: 0,
        b: 0,
        offset: DVec3::ZERO,
        local_lever: [DVec3::ZERO; 2],
        local_frame: [DQuat::IDENTITY; 2],
        impulses: JointImpulses::ZERO,
        angles: [0.0; 3],
        linear_sum: Vec3::ZERO,
        angular_sum: Vec3::ZERO,
        acted: [Vec3::ZERO; 2],
        restitution: 0.0,
        rebounds: Rebounds::NONE,
        pressed: 0,
        motors: JointMotors::NONE,
        traits: JointTraits { gives_by_motors_alone: true, ..JointTraits::NONE },
        is_hinge: false,
        is_distance: false,
        counts_turns: false,
        can_be_overloaded: false,
    };
}
