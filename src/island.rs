//! Islands: bodies that touch or are jointed, found anew each step over what is awake, and kept as they are while asleep.

/// Union–find over body slots. Roots are the lowest slot of their set, so the result does not depend on the order of unions.
#[derive(Debug, Default)]
pub(crate) struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    /// Makes every one of `members` a set of its own.
    pub(crate) fn reset(&mut self, slots: usize, members: &[u32]) {
        self.parent.resize(slots, 0);
        for &member in members {
            self.parent[member as usize] = member;
        }
    }

    pub(crate) fn find(&mut self, mut body: u32) -> u32 {
        while self.parent[body as usize] != body {
            let grandparent = self.parent[self.parent[body as usize] as usize];
            self.parent[body as usize] = grandparent;
            body = grandparent;
        }
        body
    }

    pub(crate) fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

/// An island asleep: its bodies, and the pairs it took out of the active list.
#[derive(Debug, Clone, Default)]
pub(crate) struct SleepingIsland {
    pub bodies: Vec<u32>,
    pub pairs: Vec<u32>,
    /// Worst distance between joint points of its bodies beyond what the joints allow (m).
    pub gap: f32,
}

/// All sleeping islands, by number; numbers are used again.
#[derive(Debug, Default)]
pub(crate) struct SleepingIslands {
    islands: Vec<Option<SleepingIsland>>,
    free: Vec<u32>,
    bodies: usize,
    /// Worst gap of all islands (m), until one is taken out.
    worst_gap: Option<f32>,
}

impl SleepingIslands {
    /// These islands, of which these numbers are free; `None` if that cannot be.
    pub(crate) fn from_parts(islands: Vec<Option<SleepingIsland>>, free: Vec<u32>) -> Option<Self> {
        let mut sorted = free.clone();
        sorted.sort_unstable();
        sorted.dedup();
        let empty: Vec<u32> = (0..islands.len() as u32).filter(|&number| islands[number as usize].is_none()).collect();
        let bodies = islands.iter().flatten().map(|island| island.bodies.len()).sum();
        (sorted == empty && sorted.len() == free.len()).then_some(Self { islands, free, bodies, worst_gap: None })
    }

    /// Every island by number.
    pub(crate) fn islands(&self) -> &[Option<SleepingIsland>] {
        &self.islands
    }

    /// Numbers that are free; the last one is used next.
    pub(crate) fn free(&self) -> &[u32] {
        &self.free
    }

    pub(crate) fn body_count(&self) -> usize {
        self.bodies
    }

    pub(crate) fn insert(&mut self, island: SleepingIsland) -> u32 {
        self.bodies += island.bodies.len();
        self.worst_gap = self.worst_gap.map(|worst| worst.max(island.gap));
        match self.free.pop() {
            Some(number) => {
                self.islands[number as usize] = Some(island);
                number
            }
            None => {
                self.islands.push(Some(island));
                self.islands.len() as u32 - 1
            }
        }
    }

    /// Gives a sleeping island the pairs it keeps.
    pub(crate) fn set_pairs(&mut self, number: u32, pairs: Vec<u32>) {
        if let Some(island) = &mut self.islands[number as usize] {
            island.pairs = pairs;
        }
    }

    /// Follows pairs that have gone to other slots.
    pub(crate) fn move_pairs(&mut self, places: &[u32]) {
        for island in self.islands.iter_mut().flatten() {
            island.pairs.iter_mut().for_each(|slot| *slot = places[*slot as usize]);
        }
    }

    pub(crate) fn take(&mut self, number: u32) -> SleepingIsland {
        let island = self.islands[number as usize].take().unwrap_or_default();
        self.bodies -= island.bodies.len();
        self.worst_gap = None;
        self.free.push(number);
        island
    }

    /// Worst gap of a joint between bodies that sleep (m).
    pub(crate) fn worst_gap(&mut self) -> f32 {
        let Self { islands, worst_gap, .. } = self;
        *worst_gap.get_or_insert_with(|| islands.iter().flatten().map(|island| island.gap).fold(0.0, f32::max))
    }

    /// Notes the gaps of islands that were not known when they were put in.
    pub(crate) fn set_gaps(&mut self, gap_of: impl Fn(&[u32]) -> f32) {
        self.islands.iter_mut().flatten().for_each(|island| island.gap = gap_of(&island.bodies));
        self.worst_gap = None;
    }

    /// Every pair kept by a sleeping island.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = u32> + '_ {
        self.islands.iter().flatten().flat_map(|island| island.pairs.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_do_not_depend_on_the_order_of_unions() {
        let members: Vec<u32> = (0..20).collect();
        let unions = [(3, 7), (7, 12), (1, 12), (5, 6), (6, 19)];
        let roots = |order: &[usize]| {
            let mut sets = UnionFind::default();
            sets.reset(20, &members);
            order.iter().for_each(|&i| sets.union(unions[i].0, unions[i].1));
            members.iter().map(|&m| sets.find(m)).collect::<Vec<_>>()
        };
        assert_eq!(roots(&[0, 1, 2, 3, 4]), roots(&[4, 2, 0, 3, 1]));
        assert_eq!(roots(&[0, 1, 2, 3, 4])[12], 1);
    }
}
