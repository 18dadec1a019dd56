//! What the support links of a pair were computed from. A pair for which none of it has changed keeps its links.

use smallvec::SmallVec;

use crate::collide::pairs::{PairKey, Word};
use crate::joint_graph::support::SupportGraph;

/// A pair as the last update of its links found it.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub key: Option<PairKey>,
    pub version: u16,
    /// Nearly all pairs have one.
    pub manifolds: SmallVec<[Seen; 1]>,
    pub bodies: [u32; 2],
    pub has_links: bool,
}

/// A manifold as the last update found it.
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
    /// Summary of the pair that is kept with its contacts; `rise` is the slope that the solver reported, if it reported all its manifolds.
    pub fn word(&self, rise: Option<u8>) -> Word {
        let touches = self.manifolds.iter().any(|seen| seen.points != 0);
        match rise {
            _ if !touches && !self.has_links => Word::Nothing,
            _ if self.manifolds.iter().all(|seen| seen.holds) => Word::Holds,
            Some(rise) => Word::Slides(rise),
            None => Word::Unsettled,
        }
    }

    /// Forgets the pair, and takes its links out of the graph.
    pub fn clear(&mut self, graph: &mut SupportGraph) {
        self.key = None;
        self.manifolds.drain(..).filter_map(|seen| seen.link).for_each(|link| graph.remove(link));
        self.has_links = false;
    }
}
