//! Bodies and contacts of the graph.

use glam::Vec2;

use super::hull;
use crate::tuning::support::EDGE_SHARE;

/// Points of a link.
pub(crate) const POINTS: usize = 4;

/// What a body is to the graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum NodeKind {
    /// Nothing.
    #[default]
    Absent,
    /// Carries any load, anywhere.
    Ground,
    /// Moves, but only as the host says; carries nothing while it does.
    Moving,
    /// Must be held up.
    Body,
}

/// A body, by its slot in the world.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct SupportNode {
    pub kind: NodeKind,
    /// Lowest body of those that joints tie together.
    pub unit: u32,
    /// Of the lowest body: all bodies of its unit, if there are others.
    pub(super) members: Vec<u32>,
    /// Of the lowest body: whether a joint holds the unit to the ground.
    pub(super) anchored: bool,
    /// Of the lowest body.
    pub(super) level: u32,
    /// Whether its inputs have changed, and, of the lowest body, whether the unit waits to be evaluated.
    pub(super) is_dirty: bool,
    pub(super) waits: bool,
    /// Links under the body and on it.
    pub below: Vec<u32>,
    pub above: Vec<u32>,
    /// Where it can carry, about its centre of mass (m).
    pub(super) hull: Vec<Vec2>,
    /// How far its centre of mass lies inside (m).
    pub margin: f32,
    pub held_by_joints: bool,
}

impl SupportNode {
    pub(crate) fn is_supported(&self) -> bool {
        self.stands() || self.held_by_joints
    }

    /// Whether it needs no support, or has it by what hulls and joints tell.
    pub(crate) fn is_known(&self) -> bool {
        self.kind != NodeKind::Body || self.is_supported()
    }

    /// Whether contacts alone support it.
    pub(crate) fn stands(&self) -> bool {
        self.kind == NodeKind::Body && self.margin > EDGE_SHARE * hull::reach(&self.hull)
    }

    /// Corners of the region that supports it, about its centre of mass (m).
    pub(crate) fn hull(&self) -> &[Vec2] {
        &self.hull
    }
}

/// A contact through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SupportLink {
    pub lower: u32,
    pub upper: u32,
    /// Points about the lower body's centre of mass (m).
    pub points: [Vec2; POINTS],
    pub count: u8,
    /// From the upper body's centre of mass to the lower one's (m).
    pub offset: Vec2,
    /// By how much its points may move before it is another link (m).
    pub slack: f32,
    /// Whether it does not slide.
    pub holds: bool,
    /// Name of the contact in the world.
    pub pair: u32,
}

impl SupportLink {
    /// Whether it is the other one, give or take its slack.
    pub(super) fn is_near(&self, other: &Self) -> bool {
        let Self { lower, upper, count, holds, pair, .. } = *self;
        if (lower, upper, count, holds, pair) != (other.lower, other.upper, other.count, other.holds, other.pair) {
            return false;
        }
        let (points, others) = (&self.points[..count as usize], &other.points[..count as usize]);
        let near = |a: Vec2, b: Vec2| (a - b).length_squared() <= self.slack * self.slack;
        near(self.offset, other.offset) && points.iter().zip(others).all(|(&a, &b)| near(a, b))
    }
}
