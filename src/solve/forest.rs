//! Which slots joints connect, as a forest over them.

/// Root of a slot's tree; ways there are shortened.
fn root(forest: &mut [u32], mut slot: u32) -> u32 {
    while forest[slot as usize] != slot {
        forest[slot as usize] = forest[forest[slot as usize] as usize];
        slot = forest[slot as usize];
    }
    slot
}

/// Joins the trees of two slots; whether they were two.
pub(super) fn join(forest: &mut [u32], slots: [u32; 2]) -> bool {
    let [a, b] = slots.map(|slot| root(forest, slot));
    forest[a.max(b) as usize] = a.min(b);
    a != b
}

/// Trees of two slots and more among these.
pub(super) fn count_groups(forest: &mut [u32], slots: std::ops::Range<u32>, sizes: &mut Vec<u32>) -> u32 {
    sizes.clear();
    sizes.resize(slots.len(), 0);
    let first = slots.start;
    let mut groups = 0;
    for slot in slots {
        let size = &mut sizes[(root(forest, slot) - first) as usize];
        *size += 1;
        groups += u32::from(*size == 2);
    }
    groups
}
