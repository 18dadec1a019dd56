//! The structure of an articulation's matrix: its nodes, which of them share a body, and the order in which they are eliminated.
//!
//! It stays the same while joints, their bodies and the room for rows of contacts do.

use super::factor::BlockLayout;
use super::redundancy::Regularization;
use super::root;

/// Multiplications of a factorisation for each row of the articulation above which sweeps are the better choice, and above which
/// the direct solve is no choice at all.
///
/// A step of sheets of n × n balls, n = 10 to 70, takes 0.75 µs for each row and 0.19 µs more for each thousand multiplications of
/// a row; sweeps take 0.35 µs at any n. The direct solve leaves gaps a million times smaller and is worth several times the time:
/// up to seven times, which is where n is 45. Chains and bridges have work of less than 500, so that the first term is all.
const MAX_WORK_PER_ROW: u64 = 10_000;
const MAX_WORK_PER_ROW_IF_ASKED: u64 = 100_000;

/// Rows of a face with friction.
const CONTACT_WEIGHT: u32 = 7;

/// What a joint, or a contact with a body that is carried, holds on to: two local bodies, and how many rows the joint may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NodeBodies {
    pub bodies: [u32; 2],
    pub moves: [bool; 2],
    pub capacity: u32,
    /// Whether it holds points rigidly together and does nothing else.
    pub is_plain: bool,
    pub is_contact: bool,
}

impl NodeBodies {
    /// Node of a contact between these bodies, with room for rows alone.
    pub(super) fn of_contact(bodies: [u32; 2], moves: [bool; 2]) -> Self {
        Self { bodies, moves, capacity: 0, is_plain: false, is_contact: true }
    }

    /// Rows for which its node counts when an order is chosen.
    fn weight(&self) -> u32 {
        if self.is_contact { CONTACT_WEIGHT } else { self.capacity }
    }
}

/// The rows and bodies of a joint, or of an articulation and what it carries.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SystemNode {
    pub bodies: [u32; 2],
    pub first: u32,
    pub last: u32,
}

/// Two joints on one moving body, and the block that they share: its rows are those of the joint eliminated later.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coupling {
    pub late: u32,
    pub early: u32,
    /// Side of each joint that is the body.
    pub late_side: u8,
    pub early_side: u8,
    pub body: u32,
    pub start: u32,
}

/// What does not change while the joints and their bodies stay the same.
#[derive(Debug, Clone, Default)]
pub(crate) struct Topology {
    pub plan: BlockLayout,
    pub couplings: Vec<Coupling>,
    /// By [`Redundancy`](super::redundancy::Redundancy).
    pub(super) regularizations: [Regularization; 4],
    /// Loops that joints close, where all that does not move is one body.
    pub loops: usize,
    /// Whether two joints that do more than hold points hold the same two bodies: a door on its hinges.
    pub doubled: bool,
}

impl Topology {
    /// Couples all joints that share a moving body, and chooses the order of elimination. `None` where a factorisation would take too
    /// much work: more is allowed if the user has `asked` for the direct solver. `room` is the number of contact rows that each node has
    /// room for.
    pub(super) fn derive(links: &[NodeBodies], room: &[u32], bodies: usize, asked: bool) -> Option<Self> {
        let mut at_body: Vec<Vec<(u32, u8)>> = vec![Vec::new(); bodies];
        for (node, link) in links.iter().enumerate() {
            for side in [0, 1] {
                if link.moves[side] {
                    at_body[link.bodies[side] as usize].push((node as u32, side as u8));
                }
            }
        }
        let weights: Vec<u32> = links.iter().map(NodeBodies::weight).collect();
        let capacity: Vec<u32> = links.iter().zip(room).map(|(link, room)| link.capacity + room).collect();
        let per_row = if asked { MAX_WORK_PER_ROW_IF_ASKED } else { MAX_WORK_PER_ROW };
        let most_work = per_row * weights.iter().map(|&rows| u64::from(rows)).sum::<u64>();
        let mut shared = Vec::new();
        for (body, joints) in at_body.iter().enumerate() {
            for (i, &a) in joints.iter().enumerate() {
                shared.extend(joints[i + 1..].iter().map(|&b| (a, b, body as u32)));
            }
            // Each pair costs more than the rows of its joints do.
            if shared.len() as u64 > most_work {
                return None;
            }
        }
        let mut pairs: Vec<(u32, u32)> = shared.iter().map(|((a, _), (b, _), _)| (*a, *b)).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let plan = BlockLayout::new(&weights, &capacity, &pairs, most_work)?;
        let coupling = |&((a, side_a), (b, side_b), body): &((u32, u8), (u32, u8), u32)| {
            let (start, b_is_late) = plan.block(a, b)?;
            let ((late, late_side), (early, early_side)) =
                if b_is_late { ((b, side_b), (a, side_a)) } else { ((a, side_a), (b, side_b)) };
            Some(Coupling { late, early, late_side, early_side, body, start })
        };
        let couplings = shared.iter().map(coupling).collect::<Option<Vec<_>>>()?;
        let loops = count_loops(links, bodies);
        let doubled = loops > 0 && has_doubles(links);
        Some(Self { plan, couplings, regularizations: Regularization::all(capacity.len(), loops), loops, doubled })
    }
}

/// Whether two joints that do more than hold points hold the same two bodies, where all that does not move is one.
fn has_doubles(links: &[NodeBodies]) -> bool {
    let ends = |link: &NodeBodies| {
        let [a, b] = [0, 1].map(|side| if link.moves[side] { link.bodies[side] } else { 0 });
        [a.min(b), a.max(b)]
    };
    let mut pairs: Vec<[u32; 2]> = links.iter().filter(|link| !link.is_plain && !link.is_contact).map(ends).collect();
    pairs.sort_unstable();
    pairs.windows(2).any(|pair| pair[0] == pair[1])
}

/// Loops that joints close, where all that does not move is one.
fn count_loops(links: &[NodeBodies], bodies: usize) -> usize {
    let mut group: Vec<u32> = (0..bodies as u32).collect();
    let closes = |link: &&NodeBodies| {
        let [a, b] = [0, 1].map(|side| if link.moves[side] { root(&mut group, link.bodies[side]) } else { 0 });
        group[a.max(b) as usize] = a.min(b);
        a == b
    };
    links.iter().filter(|link| !link.is_contact).filter(closes).count()
}
