//! Flags of a body in its batch, one byte each. Colouring reads them for both bodies of every manifold; the full records are
//! hundreds of bytes.

use super::state::{BodyMotion, BodyVelocity};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct BodyFlags(u8);

impl BodyFlags {
    const MOVES: u8 = 1;
    const JOINTED: u8 = 2;
    const TOUCHED: u8 = 4;
    const UNLOCKED: u8 = 8;
    const PUSHED: u8 = 16;
    const KICKED: u8 = 32;

    pub(crate) fn of(velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        let bit = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
        let is_unlocked = velocity.inverse_mass.min_element() > 0.0 && motion.is_free_to_turn();
        Self(bit(motion.is_dynamic(), Self::MOVES) | bit(motion.jointed, Self::JOINTED) | bit(is_unlocked, Self::UNLOCKED))
    }

    /// Whether rows may move it.
    pub(crate) fn moves(self) -> bool {
        self.0 & Self::MOVES != 0
    }

    /// Whether none of its axes is locked.
    pub(crate) fn is_unlocked(self) -> bool {
        self.0 & Self::UNLOCKED != 0
    }

    /// Whether a joint holds it.
    pub(crate) fn is_jointed(self) -> bool {
        self.0 & Self::JOINTED != 0
    }

    /// Whether it moves and no joint holds it.
    pub(crate) fn is_loose(self) -> bool {
        self.0 & (Self::MOVES | Self::JOINTED) == Self::MOVES
    }

    /// Whether it moves and a contact acts on it.
    pub(crate) fn is_touched(self) -> bool {
        self.0 & Self::TOUCHED != 0
    }

    pub(crate) fn touch(&mut self) {
        self.0 |= Self::TOUCHED;
    }

    /// The same of a body that the host pushes in this step, or not.
    pub(crate) fn pushed(self, is_pushed: bool) -> Self {
        Self(self.0 | if is_pushed { Self::PUSHED } else { 0 })
    }

    pub(crate) fn is_pushed(self) -> bool {
        self.0 & Self::PUSHED != 0
    }

    /// Whether it has got an impulse with its island at the start of the step.
    pub(crate) fn is_kicked(self) -> bool {
        self.0 & Self::KICKED != 0
    }

    pub(crate) fn kick(&mut self) {
        self.0 |= Self::KICKED;
    }
}
