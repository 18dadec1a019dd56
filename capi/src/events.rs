//! What a step tells: who moved, which contacts began and ended, which joints were overloaded; and contact points.
//!
//! Arrays of these structs are handed out by pointer, so their layout never changes.

use ls_core::{ArticulationReport, BodyId, Contact, ContactPair, Hit, IslandPlan, IslandReport, JointOverload, JointStop, Moved};

use crate::handle::{LsBody, LsJoint, LsShape};
use crate::math::LsPose;

/// A body that moved in a step, or fell asleep at its end. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsMoved {
    /// The body.
    pub body: LsBody,
    /// The word its host gave it.
    pub user_word: u64,
    /// Its frame in the world.
    pub pose: LsPose,
    /// Velocity of its centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// Angular velocity, world axes (rad/s).
    pub angular_velocity: [f32; 3],
    /// 1 if it fell asleep in this step, else 0.
    pub fell_asleep: u32,
    /// 1 if it woke in this step or since the one before it, else 0.
    pub woke: u32,
}

/// How an articulation was solved in a step: bodies that joints connect, solved at once. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsArticulation {
    /// One of its bodies.
    pub body: LsBody,
    /// Bodies that it moves.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// 1 if it touched what moves, or its contacts did not settle in one system with its joints, so that these were swept with the
    /// contacts, else 0.
    pub swept: u32,
    /// Substeps of second order.
    pub second_order: u32,
    /// Smooth substeps of first order.
    pub first_order: u32,
    /// Substeps in which kinetic energy cannot grow: safe ones, and all of those in which it was swept.
    pub safe: u32,
    /// Substeps that were undone and taken as two halves.
    pub halvings: u32,
    /// Numbers in its factor.
    pub factor_size: u32,
    /// Worst distance between joint points beyond what the joint allows (m).
    pub gap: f32,
    /// Worst angle by which a joint or a stop is off (rad).
    pub angle: f32,
    /// Worst overlap with what it does not move (m).
    pub penetration: f32,
    /// Change of kinetic energy that the work of gravity and applied forces does not explain (N m); 0 where it was swept.
    pub energy_change: f32,
}

/// Plan of an island: joints meet contacts, or close a loop and bear more than a substep resolves, or bodies without joints lean on one another
/// in a row, as stones of an arch, or at rest with few contacts, as cards of a house, or stand on each other on what moves or bear their
/// load aside: all of it is one problem.
pub const LS_PLAN_COUPLED: i32 = 0;
/// Plan of an island: no joint is in it: contacts are swept.
pub const LS_PLAN_LOOSE: i32 = 1;
/// Plan of an island: nothing that joints hold touches anything but a few free bodies on points of which there are many: articulations take the
/// step by themselves, with what they carry.
pub const LS_PLAN_APART: i32 = 2;
/// Plan of an island: the host asks for sweeps.
pub const LS_PLAN_SWEPT: i32 = 3;
/// Plan of an island: joints have stops on angles, as limbs do, no motor holds a place, and they form a tree that nothing fixed holds: sweeps and direct solves carry its loads for less.
pub const LS_PLAN_JOINTED: i32 = 4;
/// Plan of an island: joints do more than hold points together, no motor holds a place, and masses are alike, in a tree that nothing fixed holds or a loop that does not stand: sweeps and direct solves carry loads between such bodies as well, for less.
pub const LS_PLAN_ALIKE: i32 = 5;
/// Plan of an island: articulations touch one another that nothing fixed holds, or with more contacts than joints: a heap.
pub const LS_PLAN_HEAPED: i32 = 7;
/// Plan of an island: a factor of it takes more work than `halving_budget` allows.
pub const LS_PLAN_LARGE: i32 = 8;

// The numbers are those of the core.
const _: () = {
    assert!(LS_PLAN_COUPLED == IslandPlan::Coupled as i32);
    assert!(LS_PLAN_LOOSE == IslandPlan::Loose as i32);
    assert!(LS_PLAN_APART == IslandPlan::Apart as i32);
    assert!(LS_PLAN_SWEPT == IslandPlan::Swept as i32);
    assert!(LS_PLAN_JOINTED == IslandPlan::Jointed as i32);
    assert!(LS_PLAN_ALIKE == IslandPlan::Alike as i32);
    assert!(LS_PLAN_HEAPED == IslandPlan::Heaped as i32);
    assert!(LS_PLAN_LARGE == IslandPlan::Large as i32);
};

/// How an island was solved in a step: bodies that joints and contacts connect. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsIsland {
    /// One of its bodies.
    pub body: LsBody,
    /// Bodies that it moves.
    pub bodies: u32,
    /// Joints.
    pub joints: u32,
    /// How it was to be solved, and why: an LS_PLAN_ constant; later versions may have more.
    pub plan: i32,
    /// 1 if the coupled solve did not reach a result that it could vouch for, so that sweeps and direct solves took the step, else 0.
    pub given_up: u32,
}

/// Two shapes that touch, or touched, and their bodies. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsContactPair {
    /// First shape; its handle may be stale in an array of contacts that ended.
    pub shape_a: LsShape,
    /// Second shape.
    pub shape_b: LsShape,
    /// Body of the first shape.
    pub body_a: LsBody,
    /// Body of the second shape.
    pub body_b: LsBody,
}

/// A contact whose shapes met fast. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsHit {
    /// The shapes and their bodies.
    pub pair: LsContactPair,
    /// Where they touch, the middle of the pressed points (m).
    pub point: [f64; 3],
    /// Unit normal, from A to B.
    pub normal: [f32; 3],
    /// Greatest speed at which points approached each other at the start of a step (m/s).
    pub approach_speed: f32,
    /// Impulse along the normal over the steps of the hit, one or two, rebound included (N s).
    pub impulse: f32,
    /// Not used; 0.
    pub reserved: u32,
}

/// A joint that has come to one of its stops. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsJointStop {
    /// The joint.
    pub joint: LsJoint,
    /// The word its host gave it.
    pub user_word: u64,
    /// Which coordinate: 0 for the only one of a hinge, prismatic or distance joint and for the twist of a spherical one, 1 for its
    /// swing; 0 to 2 for the translations and 3 to 5 for the rotations of a generic joint.
    pub axis: u32,
    /// 1 if it is the upper stop, else 0.
    pub upper: u32,
}

/// A joint whose load passed its break_force or break_torque in a step. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsJointOverload {
    /// The joint.
    pub joint: LsJoint,
    /// The word its host gave it.
    pub user_word: u64,
    /// Force that it carried, mean over the step (N).
    pub force: f32,
    /// Torque that it carried, mean over the step (N m).
    pub torque: f32,
}

/// A point of a contact. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsContactPoint {
    /// Halfway between the two surfaces (m).
    pub position: [f64; 3],
    /// Distance of the surfaces along the normal (m), negative if they overlap.
    pub separation: f32,
    /// Force along the normal in the last substep (N), >= 0.
    pub normal_force: f32,
}

/// One contact between two shapes, as the last step left it. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsContact {
    /// The shapes and their bodies.
    pub pair: LsContactPair,
    /// Unit normal, from A to B.
    pub normal: [f32; 3],
    /// Friction on B, mean over the last substep (N).
    pub friction_force: [f32; 3],
    /// Number of points, 1 to 4.
    pub point_count: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// The points; those beyond point_count are zero.
    pub points: [LsContactPoint; 4],
}

impl From<&IslandReport> for LsIsland {
    fn from(report: &IslandReport) -> Self {
        Self {
            body: report.body.into(),
            bodies: report.bodies,
            joints: report.joints,
            plan: report.plan as i32,
            given_up: report.given_up.into(),
        }
    }
}

impl From<&ArticulationReport> for LsArticulation {
    fn from(report: &ArticulationReport) -> Self {
        Self {
            body: report.body.into(),
            bodies: report.bodies,
            joints: report.joints,
            swept: report.swept.into(),
            second_order: report.second_order,
            first_order: report.first_order,
            safe: report.safe,
            halvings: report.halvings,
            factor_size: report.factor_size,
            gap: report.gap,
            angle: report.angle,
            penetration: report.penetration,
            energy_change: report.energy_change,
        }
    }
}

impl From<&Moved> for LsMoved {
    fn from(moved: &Moved) -> Self {
        Self {
            body: moved.body.into(),
            user_word: moved.user_word,
            pose: moved.pose.into(),
            linear_velocity: moved.linear_velocity.to_array(),
            angular_velocity: moved.angular_velocity.to_array(),
            fell_asleep: moved.fell_asleep.into(),
            woke: moved.woke.into(),
        }
    }
}

impl From<&ContactPair> for LsContactPair {
    fn from(pair: &ContactPair) -> Self {
        Self {
            shape_a: pair.shape_a.into(),
            shape_b: pair.shape_b.into(),
            body_a: pair.body_a.into(),
            body_b: pair.body_b.into(),
        }
    }
}

impl From<&Hit> for LsHit {
    fn from(hit: &Hit) -> Self {
        Self {
            pair: (&hit.pair).into(),
            point: hit.point.to_array(),
            normal: hit.normal.to_array(),
            approach_speed: hit.approach_speed,
            impulse: hit.impulse,
            reserved: 0,
        }
    }
}

impl From<&JointStop> for LsJointStop {
    fn from(stop: &JointStop) -> Self {
        let JointStop { joint, user_word, axis, upper } = *stop;
        Self { joint: joint.into(), user_word, axis: axis.into(), upper: upper.into() }
    }
}

impl LsBody {
    pub(crate) fn of(body: &BodyId) -> Self {
        (*body).into()
    }
}

impl From<&JointOverload> for LsJointOverload {
    fn from(overload: &JointOverload) -> Self {
        Self { joint: overload.joint.into(), user_word: overload.user_word, force: overload.force, torque: overload.torque }
    }
}

impl From<Contact> for LsContact {
    fn from(contact: Contact) -> Self {
        let mut points = [LsContactPoint::default(); 4];
        for (c, point) in points.iter_mut().zip(contact.points()) {
            *c = LsContactPoint {
                position: point.position.to_array(),
                separation: point.separation,
                normal_force: point.normal_force,
            };
        }
        Self {
            pair: (&contact.pair).into(),
            normal: contact.normal.to_array(),
            friction_force: contact.friction_force.to_array(),
            point_count: contact.points().len() as u32,
            reserved: 0,
            points,
        }
    }
}
