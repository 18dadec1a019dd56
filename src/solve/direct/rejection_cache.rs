//! Remembers articulations that were too much work for the direct solve, so that unchanged ones are not laid out again.

use crate::solve::body_flags::BodyFlags;
use crate::solve::joint::JointLink;

/// What the structure of a matrix follows from, joint by joint: its bodies, its rows, and which of the bodies move.
type Signature = (u32, u32, u8, [bool; 2]);

fn signature(link: &JointLink, body_flags: &[BodyFlags]) -> Signature {
    let moves = [link.a, link.b].map(|slot| body_flags[slot as usize].moves());
    (link.a, link.b, link.traits.most_rows, moves)
}

/// The last articulation without contacts that was left to sweeps. Large sheets are laid out slower than they are swept.
#[derive(Debug, Default)]
pub(super) struct RejectionCache {
    joints: Vec<Signature>,
    was_asked_for: bool,
}

impl RejectionCache {
    /// Whether these joints would be laid out as those were.
    pub(super) fn is_of(&self, links: &[JointLink], body_flags: &[BodyFlags], asked: bool) -> bool {
        asked == self.was_asked_for
            && links.len() == self.joints.len()
            && links.iter().zip(&self.joints).all(|(link, &joint)| signature(link, body_flags) == joint)
    }

    pub(super) fn note(&mut self, links: &[JointLink], body_flags: &[BodyFlags], asked: bool) {
        self.joints.clear();
        self.joints.extend(links.iter().map(|link| signature(link, body_flags)));
        self.was_asked_for = asked;
    }
}
