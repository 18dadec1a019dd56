//! What the links of a pair were made from, and whether they still are those of the pair as it is.

use smallvec::SmallVec;

use super::site::has_reserve;
use crate::collide::pairs::{Pair, PairKey, TOO_MANY};
use crate::span::support::Graph;

/// Its links are to be made anew.
pub(super) const TURNED: u8 = 1;
/// So fast that its links may slide where friction is spent, and so fast that they may leave.
pub(super) const FAST: u8 = 2;
pub(super) const LEAVING: u8 = 4;
/// Judged when it came to rest.
pub(super) const HELD: u8 = 8;

/// A pair as it was looked at last.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub key: Option<PairKey>,
    pub version: u32,
    /// Nearly all pairs have one.
    pub manifolds: SmallVec<[Seen; 1]>,
    pub bodies: [u32; 2],
    /// The points of all manifolds, and whether all hold.
    pub touching: u32,
    pub all_hold: bool,
    pub has_links: bool,
}

/// What was seen of a manifold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Seen {
    /// Its points that are pressed or touch, as bits.
    pub points: u8,
    pub holds: bool,
    pub link: Option<u32>,
}

impl Seen {
    pub const NOTHING: Self = Self { points: 0, holds: true, link: None };
}

impl Record {
    /// Whether nothing that its links were made from can have changed.
    pub fn is_up_to_date(&self, pair: &Pair, signs: &[u8]) -> bool {
        if pair.touching == 0 {
            return !self.has_links;
        }
        if self.key != Some(pair.key) {
            return false;
        }
        let signs = self.bodies.iter().fold(0, |all, &body| all | signs[body as usize]);
        let may_have_changed = signs & (TURNED | LEAVING) != 0 || (signs & FAST != 0 && is_spent(pair));
        signs & HELD != 0 || (!may_have_changed && self.is_settled(pair))
    }

    /// Whether its links are those of the pair as it is, and stay so while the bodies stand still.
    pub fn is_settled(&self, pair: &Pair) -> bool {
        if pair.touching == 0 {
            return !self.has_links;
        }
        let is_same = self.version == pair.version && self.touching == pair.touching && pair.touching != TOO_MANY;
        self.key == Some(pair.key) && is_same && self.all_hold
    }

    /// Forgets the pair, and takes its links out of the graph.
    pub fn clear(&mut self, graph: &mut Graph) {
        self.key = None;
        self.manifolds.drain(..).filter_map(|seen| seen.link).for_each(|link| graph.remove(link));
        self.has_links = false;
    }
}

/// Whether friction of any manifold is at its limit.
fn is_spent(pair: &Pair) -> bool {
    pair.manifolds.iter().any(|manifold| !has_reserve(manifold, pair.material.friction))
}
