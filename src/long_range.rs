//! Long-range constraints as a user sees them: what a world derives, and what can be read of it.

use glam::{DVec3, Vec3};

use crate::error::{Error, ErrorKind, Result};
use crate::id::{BodyId, JointId};
use crate::motor::Softness;

/// Why a bound is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum BoundKind {
    /// From a static or kinematic attachment to what hangs on it.
    Attachment,
    /// Between two bodies that are free.
    Hierarchy,
    /// Asked for by the host between two joints, with give.
    Soft,
}

/// Most levels of the hierarchy of bounds.
pub const MAX_LEVELS: u32 = 16;

/// Whether a kind of bound is derived, and its give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundKindDef {
    /// Whether such bounds are derived.
    pub enabled: bool,
    /// Give where the distance would exceed the upper bound.
    pub upper: Softness,
    /// Give where the distance would fall below the lower bound.
    pub lower: Softness,
}

impl BoundKindDef {
    /// Derived, without give.
    pub const RIGID: Self = Self { enabled: true, upper: Softness::RIGID, lower: Softness::RIGID };
}

/// What a world derives from its joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongRangeDef {
    /// Whether anything is derived at all.
    pub enabled: bool,
    /// Bounds from static and kinematic attachments to what hangs on them.
    pub attachment: BoundKindDef,
    /// Bounds between bodies that are free, over ever longer stretches.
    pub hierarchy: BoundKindDef,
    /// Whether bounds that were asked for between two joints act.
    pub soft: bool,
    /// Whether bodies that rigid fixed joints connect move as one; otherwise such joints are solved one by one.
    pub union: bool,
    /// Whether chains of parallel hinges are kept in one plane.
    pub plane_position: bool,
    /// Whether the axes of such chains are kept parallel.
    pub plane_axis: bool,
    /// Levels of the hierarchy, 1 to 16; `None` for as many as the graph of joints asks for.
    pub levels: Option<u32>,
}

impl Default for LongRangeDef {
    fn default() -> Self {
        Self {
            enabled: true,
            attachment: BoundKindDef::RIGID,
            hierarchy: BoundKindDef::RIGID,
            soft: true,
            union: true,
            plane_position: true,
            plane_axis: true,
            levels: None,
        }
    }
}

impl LongRangeDef {
    pub(crate) fn check(&self) -> Result<()> {
        for kind in [&self.attachment, &self.hierarchy] {
            kind.upper.check("long_range.upper.compliance", "long_range.upper.damping")?;
            kind.lower.check("long_range.lower.compliance", "long_range.lower.damping")?;
        }
        match self.levels {
            Some(levels) if !(1..=MAX_LEVELS).contains(&levels) => {
                Err(Error::new(ErrorKind::OutOfRange, "long_range.levels", "must be 1 to 16"))
            }
            _ => Ok(()),
        }
    }
}

/// The greatest distance that a chain of joints leaves its two ends, taken as a soft lower bound: a spring that stretches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftBound {
    /// Share of the greatest distance at which the spring is at rest, above 0 and up to 1.
    pub share: f32,
    /// Spring and damper; its compliance must not be zero.
    pub softness: Softness,
}

impl SoftBound {
    pub(crate) fn check(&self) -> Result<()> {
        self.softness.check("bound.softness.compliance", "bound.softness.damping")?;
        crate::check::positive("bound.softness.compliance", self.softness.compliance)?;
        if crate::check::positive("bound.share", self.share)? > 1.0 {
            return Err(Error::new(ErrorKind::OutOfRange, "bound.share", "must be above 0 and at most 1"));
        }
        Ok(())
    }
}

/// A chain of joints as the last step left it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainState {
    /// Its links, from the first joint to the second.
    pub links: Vec<ChainLink>,
    /// Length at rest: the sum of its links (m).
    pub rest_length: f32,
    /// Length now: with what each joint is apart, those at both ends among them (m).
    pub length: f32,
    /// By what share of its length at rest it is longer than that.
    pub stretch: f32,
}

impl ChainState {
    /// Greatest tension of a link (N); the least push where all are pushed together.
    pub fn greatest_tension(&self) -> f32 {
        self.links.iter().map(|link| link.tension).fold(f32::NEG_INFINITY, f32::max)
    }
}

/// A link of a chain: a body between two joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainLink {
    /// The body; of a union, the member at the first joint.
    pub body: BodyId,
    /// The joints at its two ends.
    pub joints: [JointId; 2],
    /// Distance of the two joints on it (m).
    pub length: f32,
    /// Force that the two pull it apart with, mean over the last step (N); negative where they push.
    pub tension: f32,
}

/// A bound as the last step left it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundState {
    /// Why it is there.
    pub kind: BoundKind,
    /// Level in the hierarchy; 0 for other kinds.
    pub level: u32,
    /// Joint at its near end: that of the attachment, where it has one.
    pub near: JointId,
    /// Joint at its far end.
    pub far: JointId,
    /// The two points it holds (m).
    pub points: [DVec3; 2],
    /// Distance of the two points (m).
    pub distance: f32,
    /// Greatest distance (m).
    pub upper: f32,
    /// Least distance (m), 0 for none.
    pub lower: f32,
    /// Tension, mean over the last step (N); negative where the lower bound pushes. Of a bound that is wrapped around something, what
    /// its pull on the far body has along the straight line.
    pub tension: f32,
    /// Whether it had anything to do in the last step.
    pub active: bool,
}

/// The common plane of a chain of hinges, as the last step left it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneState {
    /// The chain's joint of the lowest slot: it names the chain while both last.
    pub joint: JointId,
    /// Number of its members: bodies, and rigid unions that count as one.
    pub members: u32,
    /// The plane's point nearest to the middle of the members (m).
    pub point: DVec3,
    /// Unit normal, along the axes of the hinges.
    pub normal: Vec3,
    /// Distance from `point` of the member whose centre of mass is farthest from it (m).
    pub radius: f32,
    /// Root of the mean square of the distances by which members are off the plane (m).
    pub deviation: f32,
    /// Whether a hinge to something fixed gives the plane.
    pub anchored: bool,
}

impl BoundState {
    /// What is left until the nearer of the two bounds is reached (m); negative when it is passed.
    pub fn slack(&self) -> f32 {
        let above = self.upper - self.distance;
        if self.lower > 0.0 { above.min(self.distance - self.lower) } else { above }
    }
}
