//! Joint rows of a batch: built once a substep at predicted poses, swept with the contacts, read out at the end.
//!
//! **Where the Jacobian is taken.** At the pose of the substep's start, impulses act at one point of both bodies, so angular
//! momentum is kept to rounding and energy does not drift (this is SHAKE, Ryckaert et al. 1977). But tension then acts as an
//! explicit transverse spring and becomes unstable once κ = h² T r / I passes about one: a 1 kg link under 10 t has κ ≈ 50. At
//! the predicted pose the same spring is implicit: stable at any tension, at the price of some damping. Each joint blends
//! between the two by its own κ.

use std::ops::Range;

use glam::{DQuat, DVec3, Vec3};

pub(crate) mod angles;
pub(crate) mod body_response;
mod distance;
mod domains;
pub(crate) mod driven;
mod entry;
mod fixed;
pub(crate) mod friction;
mod generic;
pub(crate) mod geometry;
mod hinge;
pub(crate) mod kinds;
mod lanes;
mod layout;
mod link;
pub(crate) mod locks;
pub(crate) mod motor;
mod prismatic;
pub(crate) mod reach;
pub(crate) mod rebound;
pub(crate) mod row_sink;
pub(crate) mod rows;
mod search_direction;
mod singles;
mod spherical;
mod sweep;
pub(crate) mod swing;

use domains::Strips;
pub(crate) use domains::may_be_cut;
pub(crate) use entry::{JointEntry, JointMotors};
use geometry::{Placement, WorldFrame};
use lanes::JointLanes;
pub(crate) use lanes::rows::{implicit_share, turning_ease as turning_ease_in_lanes};
pub(crate) use link::{JointEnd, JointLink, JointTraits};
use singles::{KeptRows, Singles};

use super::contact::Lane3;
use super::disjoint::DisjointSlices;
use super::integrate::PredictedPose;
use super::state::{BodyMotion, BodyVelocity};
use crate::id::{JointId, Pool};
use crate::joint::{JointDef, JointKind, Limits};
use crate::joint_record::Joint;
use crate::workers::Workers;

/// Transverse stiffness κ below which the Jacobian is taken at the start, and above which it is taken at the predicted pose.
const IMPLICIT_RANGE: (f32, f32) = (0.5, 2.0);

/// Greatest change of angular velocity, over the sum of both bodies', by which angular momentum is given back.
const MOMENTUM_RETURN_LIMIT: f32 = 0.2;

/// Where a body is: its displacement since the start of the step (m) and its rotation.
pub(crate) type LocalPose = (DVec3, DQuat);

/// All joints of a batch, and what is swept of them, in the order of their colours.
#[derive(Debug, Default)]
pub(crate) struct BatchJoints {
    /// Slots in the world's pool; and both sides of each, where bounds ask for them.
    pub slots: Vec<u32>,
    pub ends: Vec<[JointEnd; 2]>,
    /// All of them, in the order of their articulations once they are sorted.
    pub links: Vec<JointLink>,
    /// From now to the end of the step (s).
    pub left: f32,
    /// Those that no direct solve takes.
    pub entries: Vec<JointEntry>,
    /// What is swept by itself; and the rest, of most batches all.
    domains: Strips,
    lanes: JointLanes,
    singles: Singles,
    visits: Vec<Visit>,
    /// Part of each joint: its colour, what it holds, and its strip; and the first place of each part in the order.
    parts: Vec<u32>,
    places: Vec<u32>,
    /// Joints of one colour that are in no strip, or left over there.
    left_over: Vec<u32>,
    /// Numbers of the joints in the order of their parts: the joints themselves stay where they are, as they are large.
    order: Vec<u32>,
}

/// Rows of a batch as they were.
#[derive(Debug, Default)]
pub(crate) struct KeptJoints {
    /// Multipliers of the points and directions of each block.
    lanes: Vec<[Lane3; 2]>,
    singles: KeptRows,
}

/// What is swept of one colour: blocks, then joints one by one.
#[derive(Debug, Clone)]
struct Visit {
    blocks: Range<usize>,
    singles: Range<usize>,
}

/// The bodies of a batch by slot: how fast they are, where they are, and where they are predicted to be at the end of the substep.
pub(crate) struct MovingBodies<'a> {
    pub velocities: &'a [BodyVelocity],
    pub motions: &'a [BodyMotion],
    pub predicted_poses: &'a [PredictedPose],
}

impl BatchJoints {
    /// Builds this substep's rows at the poses that `predicted_poses` predict from the velocities of now; multipliers go on from where they are.
    ///
    /// Done once more before the last sweep (`again`), so that the rows hold to second order at the poses that the substep ends in:
    /// what the position rows would have to mend costs angular momentum.
    pub(crate) fn prepare(
        &mut self,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        &MovingBodies { velocities, motions, predicted_poses }: &MovingBodies<'_>,
        h: f32,
        again: bool,
    ) {
        let prepare = |lanes: &mut JointLanes, slots: Range<usize>| {
            if !again {
                lanes.begin(&motions[slots.clone()]);
            }
            lanes.prepare(&velocities[slots.clone()], &predicted_poses[slots], h);
        };
        if again {
            self.singles.keep_impulses(&mut self.entries);
        } else {
            self.singles.follow(&mut self.entries, joints, motions, self.left);
        }
        self.domains.each(threads, |strip| prepare(&mut strip.lanes, strip.slots.clone()));
        prepare(&mut self.lanes, 0..motions.len());
        let moving = MovingBodies { velocities, motions, predicted_poses };
        self.singles.prepare(&self.entries, joints, &moving, (h, self.left), again);
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&mut self, threads: &Workers, velocities: &mut [BodyVelocity]) {
        self.domains.each_with(threads, velocities, |strip, own| strip.lanes.warm_start(own));
        self.lanes.warm_start(velocities);
        self.singles.warm_start(velocities);
    }

    /// One sweep over all joints: directions, coordinates, then points; backwards, all in the opposite order.
    ///
    /// Sweeps to and fro are symmetric, which carried multipliers need: with r the residual of a substep, μ = A λ what is carried
    /// and g an eigenvalue of the error that the sweeps leave, r' = g (r + μ), μ' = g μ − (1 − g) r grows by |z| a substep, z² −
    /// 2 g z + g = 0. For g in 0…1, as a symmetric sweep has it, |z| = √g < 1; sweeps in one direction have complex g, |z| may
    /// pass 1, and a tree of fixed joints tears itself apart.
    pub(crate) fn sweep(&mut self, threads: &Workers, velocities: &mut [BodyVelocity], backwards: bool) {
        let Self { domains, lanes, singles, visits, .. } = self;
        if !backwards {
            domains.each_with(threads, velocities, |strip, own| strip.sweep(own, false));
        }
        in_order(visits, backwards, |visit| {
            lanes.sweep(visit.blocks.clone(), velocities, backwards);
            singles.sweep(visit.singles.clone(), velocities, backwards);
        });
        if backwards {
            domains.each_with(threads, velocities, |strip, own| strip.sweep(own, true));
        }
    }

    /// Slots of the bodies of each joint with a motor.
    pub(crate) fn motor_slots(&self) -> impl Iterator<Item = [u32; 2]> {
        self.singles.motor_slots(&self.entries)
    }

    /// Has motors do for the rest of the substep what they do now.
    pub(crate) fn hold_motors(&mut self) {
        self.singles.hold_motors(&self.entries);
    }

    /// Keeps the rows of a batch of several islands as they are: none of its joints is in a strip, which a large island alone has.
    pub(crate) fn keep(&self, kept: &mut KeptJoints) {
        self.lanes.keep(&mut kept.lanes);
        self.singles.keep(&mut kept.singles);
    }

    /// Puts the rows of joints back that are on none of these slots.
    pub(crate) fn put_back(&mut self, kept: &KeptJoints, slots: &[bool]) {
        self.lanes.put_back(&kept.lanes, slots);
        self.singles.put_back(&kept.singles, slots);
    }

    /// Sets the multipliers of joints on these slots to nothing.
    pub(crate) fn give_up(&mut self, slots: &[bool]) {
        self.domains.all_mut().iter_mut().for_each(|strip| strip.lanes.give_up(&slots[strip.slots.clone()]));
        self.lanes.give_up(slots);
        self.singles.give_up(slots);
    }

    /// What the motors of each joint do on its bodies in this substep (J): handed over with the slots of the two.
    pub(crate) fn find_work(&self, velocities: &[BodyVelocity], hand_over: impl FnMut([u32; 2], f64)) {
        self.singles.find_work(&self.entries, velocities, hand_over);
    }

    /// Ends the velocity rows of a substep: multipliers are kept, and added to the joints' loads.
    pub(crate) fn end_substep(&mut self, threads: &Workers) {
        self.domains.each(threads, |strip| strip.lanes.add_loads());
        self.lanes.add_loads();
        self.singles.keep_impulses(&mut self.entries);
        self.singles.add_loads(&mut self.entries);
    }

    /// Hands multipliers and loads of joints in lanes back to their entries, and brings the angles of all up to the end of the step.
    pub(crate) fn store(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, motions: &[BodyMotion]) {
        let Self { entries, domains, lanes, singles, .. } = self;
        singles.follow(entries, joints, motions, 0.0);
        let follow = |entry: &mut JointEntry| entry.follow_step(&joints[entry.joint].def.kind, motions);
        let shared = DisjointSlices::new(entries);
        domains.each(threads, |strip| {
            // SAFETY: each joint has one lane, and each strip is one thread's.
            strip.lanes.store(&mut unsafe { shared.part() }, follow);
        });
        // SAFETY: no other part is in use.
        lanes.store(&mut unsafe { shared.part() }, follow);
    }

    /// One sweep of position rows, joint by joint at the poses of now: rigid errors are taken out, angular momentum is kept.
    pub(crate) fn project(
        &mut self,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        h: f32,
    ) {
        let Self { entries, domains, lanes, singles, visits, left, .. } = self;
        let most = rows::MAX_RECOVERY_SPEED as f32 * h;
        domains.each_moved(threads, velocities, motions, |strip, velocities, motions| {
            for blocks in &strip.visits {
                strip.lanes.project(blocks.clone(), velocities, motions, most);
            }
        });
        for visit in visits.iter() {
            lanes.project(visit.blocks.clone(), velocities, motions, most);
            singles.project(visit.singles.clone(), entries, joints, (velocities, motions), h, *left);
        }
    }

    /// Greatest distance of points that a joint holds together without give, as a share of its levers.
    pub(crate) fn opening(&self, joints: &Pool<Joint, JointId>, motions: &[BodyMotion]) -> f64 {
        let singles = self.singles.entries().map(|number| self.entries[number].opening(joints, motions)).fold(0.0, f64::max);
        let of_strips = self.domains.all().iter().map(|strip| strip.lanes.opening(&motions[strip.slots.clone()]));
        singles.max(f64::from(of_strips.fold(self.lanes.opening(motions), f32::max)))
    }

    /// Tells the same of each joint, with the slots of its bodies.
    pub(crate) fn each_opening(
        &self,
        joints: &Pool<Joint, JointId>,
        motions: &[BodyMotion],
        mut tell: impl FnMut([u32; 2], f64),
    ) {
        for entry in self.singles.entries().map(|number| &self.entries[number]) {
            tell([entry.a, entry.b], entry.opening(joints, motions));
        }
        for strip in self.domains.all() {
            let first = strip.slots.start as u32;
            strip.lanes.each_opening(&motions[strip.slots.clone()], &mut |slots, share| {
                tell(slots.map(|slot| first + slot), f64::from(share))
            });
        }
        self.lanes.each_opening(motions, &mut |slots, share| tell(slots, f64::from(share)));
    }

    /// Worst distance between joint points beyond what the joints allow (m).
    pub(crate) fn worst_gap(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, motions: &[BodyMotion]) -> f32 {
        self.domains.each(threads, |strip| strip.gap = strip.lanes.worst_gap(&motions[strip.slots.clone()]));
        let singles = self.singles.entries().map(|number| &self.entries[number]);
        let of_strips = self.domains.all().iter().map(|strip| strip.gap);
        of_strips.fold(self.lanes.worst_gap(motions), f32::max).max(worst_gap(singles, joints, motions))
    }
}

/// Visits all, in their order or backwards.
fn in_order<T>(visits: &[T], backwards: bool, visit: impl FnMut(&T)) {
    if backwards {
        visits.iter().rev().for_each(visit);
    } else {
        visits.iter().for_each(visit);
    }
}

/// A stance in the precision that joint rows are formed in.
fn stance((displacement, rotation): (Vec3, glam::Quat)) -> LocalPose {
    (displacement.as_dvec3(), rotation.as_dquat().normalize())
}

impl BodyMotion {
    /// Where the body is, for joint rows.
    pub(crate) fn stance(&self) -> LocalPose {
        stance((self.displacement, self.rotation))
    }
}

/// Worst distance between joint points beyond what the joints allow (m).
pub(crate) fn worst_gap<'a>(
    entries: impl Iterator<Item = &'a JointEntry>,
    joints: &Pool<Joint, JointId>,
    motions: &[BodyMotion],
) -> f32 {
    let gap = |entry: &JointEntry| {
        let (a, b) = (motions[entry.a as usize].stance(), motions[entry.b as usize].stance());
        let kind = &joints[entry.joint].def.kind;
        // Frames cost more than points, and few kinds allow a gap that is seen in them.
        let turns = matches!(kind, JointKind::Prismatic { .. } | JointKind::Generic { .. });
        gap_of(kind, &if turns { entry.placement(a, b) } else { entry.points(&a, &b) })
    };
    entries.map(gap).fold(0.0, f64::max) as f32
}

/// Distance between the joint points beyond what the kind of joint allows (m).
pub(crate) fn gap_of(kind: &JointKind, placement: &Placement) -> f64 {
    match kind {
        JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => placement.gap.length(),
        JointKind::Distance { limits, .. } => beyond(placement.gap.length(), limits),
        JointKind::Prismatic { limits, .. } => {
            let gap = placement.local_gap();
            DVec3::new(beyond(gap.x, limits), gap.y, gap.z).length()
        }
        JointKind::Generic { linear, .. } => {
            let gap = placement.local_gap();
            DVec3::from_array(std::array::from_fn(|i| beyond(gap[i], &linear[i].limits))).length()
        }
    }
}

/// How far a coordinate is beyond its limits.
fn beyond(value: f64, limits: &Limits) -> f64 {
    (f64::from(limits.min) - value).max(value - f64::from(limits.max)).max(0.0)
}

/// The same of what the joint holds rigidly: how far a spring is drawn, or a soft stop is pressed in, is no gap.
pub(crate) fn rigid_gap(def: &JointDef, placement: &Placement) -> f64 {
    let [points_give, limits_give] = [&def.linear, &def.limit].map(|softness| softness.compliance > 0.0);
    match &def.kind {
        kind if points_give && kinds::holds_points(kind) => 0.0,
        JointKind::Prismatic { limits, .. } if points_give => {
            if limits_give {
                0.0
            } else {
                beyond(placement.local_gap().x, limits)
            }
        }
        JointKind::Prismatic { .. } if limits_give => placement.local_gap().with_x(0.0).length(),
        JointKind::Distance { .. } if limits_give => 0.0,
        // Six axes that hold their points do so as a ball joint does, and not by limits.
        kind @ JointKind::Generic { .. } if limits_give && !kinds::holds_points(kind) => 0.0,
        kind => gap_of(kind, placement),
    }
}

/// Coordinate of the free axis of a joint (rad or m) and its gradient, for read-out; `angles` are those that it had last (rad).
pub(crate) fn coordinate(kind: &JointKind, placement: &Placement, angles: [f64; 3]) -> (f64, DVec3) {
    let axis = placement.a.frame * DVec3::X;
    match kind {
        JointKind::Hinge { .. } => (angles::nearest(placement.twist(), angles[0]), axis),
        JointKind::Prismatic { .. } => (placement.local_gap().x, axis),
        JointKind::Distance { .. } => (placement.gap.length(), placement.gap.normalize_or(axis)),
        _ => (0.0, DVec3::ZERO),
    }
}

/// One axis of a joint, for read-out.
pub(crate) struct AxisReading {
    /// Coordinate (rad or m).
    pub position: f64,
    /// Gradient of the coordinate, and the direction in which a force or torque acts along it; unit vectors but for angles whose axes
    /// are not at right angles.
    pub gradient: DVec3,
    pub direction: DVec3,
    pub turns: bool,
}

/// One axis of a joint of this kind that had these angles last (rad), if it has one of that number.
pub(crate) fn axis_of(kind: &JointKind, placement: &Placement, last: [f64; 3], axis: usize) -> Option<AxisReading> {
    let reading = |position: f64, along: DVec3, turns: bool| AxisReading { position, gradient: along, direction: along, turns };
    match (kind, axis) {
        (JointKind::Hinge { .. }, 0) => {
            let (angle, along) = coordinate(kind, placement, last);
            Some(reading(angle, along, true))
        }
        (JointKind::Prismatic { .. } | JointKind::Distance { .. }, 0) => {
            let (length, along) = coordinate(kind, placement, last);
            Some(reading(length, along, false))
        }
        (JointKind::Spherical { .. }, 0) => {
            let (a, b) = (placement.a.frame * DVec3::X, placement.b.frame * DVec3::X);
            let gradient = (a + b) / (1.0 + a.dot(b)).max(angles::MIN_COMMON);
            let angle = angles::nearest(placement.twist(), last[0]);
            Some(AxisReading { position: angle, gradient, direction: a, turns: true })
        }
        (JointKind::Spherical { .. }, 1) => {
            let across = (placement.a.frame * DVec3::X).cross(placement.b.frame * DVec3::X).normalize_or_zero();
            Some(reading(spherical::swing(placement), across, true))
        }
        (JointKind::Generic { .. }, 0..3) => Some(reading(placement.local_gap()[axis], placement.axes_a().col(axis), false)),
        (JointKind::Generic { angular, .. }, 3..6) => Some(angles::axis(angular, placement, last, axis - 3)),
        _ => None,
    }
}

/// Both joint frames of a joint outside a step.
pub(crate) fn placement_of(offset: DVec3, levers: [DVec3; 2], frames: [DQuat; 2]) -> Placement {
    let [a, b] = [0, 1].map(|i| WorldFrame { lever: levers[i], frame: frames[i] });
    Placement { a, b, gap: offset + (levers[1] - levers[0]) }
}
