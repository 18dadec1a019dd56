//! Result of the support analysis for one body, as the host reads it.

use crate::id::BodyId;

/// Whether a body is held up, and by what; or why not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Its centre of mass lies over the hull of the supporting contacts below it.
    Supported,
    /// Joints hold it to the ground, or to a body that is supported.
    HeldByJoints,
    /// The pushes of contacts that hold balance its weight, though they are not all below it: a stone of an arch, a leaning card.
    Braced,
    /// Static, or kinematic and at rest: it needs no support.
    Ground,
    /// Nothing presses against it from below.
    NoContact,
    /// Every contact below it slides.
    Sliding,
    /// What it stands on carries no load where it stands: that is unsupported itself, moves, or ends before there.
    OnUnsupported,
    /// Its centre of mass lies outside the hull of its supporting contacts, or on its edge.
    OutsideHull,
    /// Joints tie it to other bodies, none of which is supported.
    HangingLoose,
    /// Kinematic and on the move.
    Moving,
    /// There is no gravity.
    NoGravity,
}

impl Verdict {
    /// Whether the body is held up.
    pub fn is_supported(self) -> bool {
        matches!(self, Self::Supported | Self::HeldByJoints | Self::Braced | Self::Ground)
    }
}

/// The verdict on a body at the end of the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodySupport {
    /// Whether it is held up, or why not.
    pub verdict: Verdict,
    /// How far its centre of mass lies inside the hull of its supporting contacts, seen along gravity (m): negative outside, and
    /// −∞ without supporting contacts.
    pub margin: f32,
}

/// A body that has gained or lost its support.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SupportChange {
    /// The body.
    pub body: BodyId,
    /// The host's word on it.
    pub user_word: u64,
    /// Whether it is supported now.
    pub supported: bool,
}
