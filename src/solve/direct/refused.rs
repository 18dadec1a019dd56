//! What was too much work for the direct solve in the last step is so in this one, while it is the same.

use crate::solve::joint::JointLink;
use crate::solve::role::Role;

/// What the structure of a matrix follows from, joint by joint: its bodies, its rows, and which of the bodies move.
type Signature = (u32, u32, u8, [bool; 2]);

fn signature(link: &JointLink, roles: &[Role]) -> Signature {
    let moves = [link.a, link.b].map(|slot| roles[slot as usize].moves());
    (link.a, link.b, link.traits.most_rows, moves)
}

/// The last articulation without contacts that was left to sweeps. Large sheets are laid out slower than they are swept.
#[derive(Debug, Default)]
pub(super) struct Refused {
    joints: Vec<Signature>,
    was_asked_for: bool,
}

impl Refused {
    /// Whether these joints would be laid out as those were.
    pub(super) fn is_of(&self, links: &[JointLink], roles: &[Role], asked: bool) -> bool {
        asked == self.was_asked_for
            && links.len() == self.joints.len()
            && links.iter().zip(&self.joints).all(|(link, &joint)| signature(link, roles) == joint)
    }

    pub(super) fn note(&mut self, links: &[JointLink], roles: &[Role], asked: bool) {
        self.joints.clear();
        self.joints.extend(links.iter().map(|link| signature(link, roles)));
        self.was_asked_for = asked;
    }
}
