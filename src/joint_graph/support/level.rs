//! Levels of units along lower → upper, by the longest path from below (Kahn 1962).
//!
//! What slides carries nothing, and counts for nothing. Levels depend on the graph alone, not on the order of its lists. Where units
//! stand on each other in a circle, the lowest of those that wait is taken first; what points down or sideways then is cut.
//!
//! Without circles any levels that go up along every link give the same verdicts. So a link that begins to hold only raises what is
//! above it, and one that ceases to leaves levels as they are.

use super::{NodeKind, PlacedLink, SupportNode};

/// Buffers of the numbering.
#[derive(Debug, Clone, Default)]
pub(super) struct LevelScratch {
    /// Links of each unit from units that have no level yet.
    waiting: Vec<u32>,
    done: Vec<bool>,
    ready: Vec<u32>,
    /// Bodies that links stand under which begin or cease to go up.
    pub turned: Vec<u32>,
}

/// Units that are raised before it is better to number all anew.
const MAX_RAISED: u32 = 256;

/// Raises a unit that has come to stand on another, and what is above it, until every link goes up again; `false` if that is not to be
/// done so. There are no circles yet.
pub(super) fn raise(
    nodes: &mut [SupportNode],
    links: &[Option<PlacedLink>],
    (lower, upper): (u32, u32),
    scratch: &mut LevelScratch,
) -> bool {
    let LevelScratch { ready, .. } = scratch;
    ready.clear();
    nodes[upper as usize].level = nodes[lower as usize].level + 1;
    ready.push(upper);
    let mut raised = 0;
    while let Some(unit) = ready.pop() {
        raised += 1;
        let level = nodes[unit as usize].level;
        // What ceases to hold lowers nothing; a chain of bodies is the longest path that there can be.
        if raised > MAX_RAISED || level as usize > nodes.len() {
            return false;
        }
        let count = nodes[unit as usize].members.len();
        for i in 0..count.max(1) {
            let body = if count == 0 { unit } else { nodes[unit as usize].members[i] };
            for number in 0..nodes[body as usize].above.len() {
                let Some(PlacedLink { link, .. }) = &links[nodes[body as usize].above[number] as usize] else { continue };
                let next = nodes[link.upper as usize].unit;
                if !link.holds || next == unit || nodes[next as usize].level > level {
                    continue;
                }
                if next == lower {
                    return false;
                }
                nodes[next as usize].level = level + 1;
                ready.push(next);
            }
        }
    }
    true
}

/// Numbers the levels anew; says whether there are circles.
pub(super) fn assign(nodes: &mut [SupportNode], links: &mut [Option<PlacedLink>], scratch: &mut LevelScratch) -> bool {
    let LevelScratch { waiting, done, ready, turned } = scratch;
    waiting.clear();
    waiting.resize(nodes.len(), 0);
    done.clear();
    done.resize(nodes.len(), false);
    ready.clear();
    let mut has_circles = false;
    let holding = |placed: &&mut PlacedLink| placed.link.holds;
    for PlacedLink { link, .. } in links.iter_mut().flatten().filter(holding) {
        let (lower, upper) = (nodes[link.lower as usize].unit, nodes[link.upper as usize].unit);
        // Within a unit nothing stands on anything.
        if nodes[link.lower as usize].kind == NodeKind::Body && lower != upper {
            waiting[upper as usize] += 1;
        }
    }
    let mut left = 0;
    for (body, node) in nodes.iter_mut().enumerate() {
        if node.kind == NodeKind::Body && node.unit == body as u32 {
            node.level = 1;
            left += 1;
            if waiting[body] == 0 {
                ready.push(body as u32);
            }
        }
    }
    let mut next_stuck = 0;
    while left > 0 {
        let unit = match ready.pop() {
            Some(unit) => unit,
            None => {
                has_circles = true;
                let is_stuck =
                    |body: &usize| nodes[*body].kind == NodeKind::Body && nodes[*body].unit == *body as u32 && !done[*body];
                let Some(stuck) = (next_stuck..nodes.len()).find(is_stuck) else { break };
                next_stuck = stuck;
                stuck as u32
            }
        };
        if std::mem::replace(&mut done[unit as usize], true) {
            continue;
        }
        left -= 1;
        let level = nodes[unit as usize].level;
        let count = nodes[unit as usize].members.len();
        for i in 0..count.max(1) {
            let body = if count == 0 { unit } else { nodes[unit as usize].members[i] };
            for number in 0..nodes[body as usize].above.len() {
                let Some(PlacedLink { link, .. }) = &links[nodes[body as usize].above[number] as usize] else { continue };
                let upper = nodes[link.upper as usize].unit;
                if !link.holds || upper == unit || done[upper as usize] {
                    continue;
                }
                nodes[upper as usize].level = nodes[upper as usize].level.max(level + 1);
                waiting[upper as usize] -= 1;
                if waiting[upper as usize] == 0 {
                    ready.push(upper);
                }
            }
        }
    }
    turned.clear();
    for PlacedLink { link, went_up, .. } in links.iter_mut().flatten().filter(holding) {
        let [lower, upper] = [link.lower, link.upper].map(|body| nodes[nodes[body as usize].unit as usize].level);
        if std::mem::replace(went_up, lower < upper) != (lower < upper) {
            turned.push(link.upper);
        }
    }
    has_circles
}
