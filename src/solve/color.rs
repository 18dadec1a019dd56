//! Graph colouring: constraints of one colour share no moving body, so they can be solved side by side.
//!
//! Greedy, in the order the constraints come: each takes the lowest colour that neither of its bodies has yet. The colours of
//! an island do not depend on anything outside it.

use std::ops::Range;

/// Number of colours; what finds none free is solved alone, after the rest.
pub(crate) const MAX_COLORS: usize = 64;

/// Colours taken so far by each slot of a batch.
#[derive(Debug, Default)]
pub(crate) struct Coloring {
    taken: Vec<u64>,
}

impl Coloring {
    pub(crate) fn reset(&mut self, slots: usize) {
        self.taken.clear();
        self.taken.resize(slots, 0);
    }

    /// Colour of a constraint between two slots, `None` where both are full; a slot that cannot move takes no colour.
    pub(crate) fn assign(&mut self, a: (u32, bool), b: (u32, bool)) -> Option<u32> {
        let taken = |(slot, moves): (u32, bool)| if moves { self.taken[slot as usize] } else { 0 };
        let color = (!(taken(a) | taken(b))).trailing_zeros();
        if color as usize >= MAX_COLORS {
            return None;
        }
        for (slot, moves) in [a, b] {
            if moves {
                self.taken[slot as usize] |= 1 << color;
            }
        }
        Some(color)
    }

    /// Whether each slot has taken a colour.
    pub(crate) fn have_any(&self) -> impl Iterator<Item = bool> + '_ {
        self.taken.iter().map(|&taken| taken != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constraints_of_one_color_share_no_moving_body() {
        let mut coloring = Coloring::default();
        coloring.reset(50);
        let mut used = Vec::new();
        for step in 1..7u32 {
            for a in 1..50 - step {
                let b = a + step;
                let color = coloring.assign((a, true), (b, true)).expect("each body has twelve constraints");
                assert!(!used.contains(&(color, a)) && !used.contains(&(color, b)), "colour {color} is used twice by {a} or {b}");
                used.push((color, a));
                used.push((color, b));
            }
        }
    }

    #[test]
    fn a_body_with_too_many_constraints_overflows() {
        let mut coloring = Coloring::default();
        coloring.reset(100);
        let colored = (2..100).filter(|&b| coloring.assign((1, true), (b, true)).is_some()).count();
        assert_eq!(colored, MAX_COLORS);
    }
}

/// Blocks that follow one another and share no moving body; or, where they may, are gone through one by one.
#[derive(Debug, Clone)]
pub(crate) struct ColorRange {
    pub blocks: Range<usize>,
    /// The first of those with manifolds of one point. Up to it, and from it on, blocks are in the order of their bodies, where there are
    /// cuts.
    pub points: usize,
    /// Which of the cuts are for it.
    pub round: usize,
    pub is_one: bool,
}
