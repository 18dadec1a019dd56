//! What the body of each slot is to its contacts, in a byte: colours ask it of both bodies of every manifold, whose other records are
//! hundreds of bytes each.

use super::state::BodyMotion;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Role(u8);

impl Role {
    const MOVES: u8 = 1;
    const JOINTED: u8 = 2;
    const TOUCHED: u8 = 4;

    pub(crate) fn of(motion: &BodyMotion) -> Self {
        let moves = if motion.is_dynamic() { Self::MOVES } else { 0 };
        Self(moves | if motion.jointed { Self::JOINTED } else { 0 })
    }

    /// Whether rows may move it.
    pub(crate) fn moves(self) -> bool {
        self.0 & Self::MOVES != 0
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
}
