//! The structure of an articulation's matrix: which nodes it has, where rows of contacts go, and in what order they are eliminated.

use glam::DVec3;

use super::articulation::Articulation;
use super::block::MAX_ROWS;
use super::factor::BlockLayout;
use super::redundancy::Regularization;
use super::root;
use super::system::{Coupling, Topology};
use super::wide_integrator;
use crate::solve::joint::JointEntry;

/// Multiplications of a factorisation for each row of the articulation above which sweeps are the better choice, and above which
/// the direct solve is no choice at all.
///
/// A step of sheets of n × n balls, n = 10 to 70, takes 0.75 µs for each row and 0.19 µs more for each thousand multiplications of
/// a row; sweeps take 0.35 µs at any n. The direct solve leaves gaps a million times smaller and is worth several times the time:
/// up to seven times, which is where n is 45. Chains and bridges have work of less than 500, so that the first term is all.
const MAX_WORK_PER_ROW: u64 = 10_000;
const MAX_WORK_PER_ROW_IF_ASKED: u64 = 100_000;

/// Least size of an articulation without levers (m).
const MIN_SIZE: f64 = 1.0e-3;

/// Rows of a face with friction.
const CONTACT_WEIGHT: u32 = 7;

/// What a joint, or a contact with a body that is carried, holds on to: two local bodies, and how many rows the joint may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NodeBodies {
    pub bodies: [u32; 2],
    pub moves: [bool; 2],
    capacity: u32,
    /// Whether it holds points rigidly together and does nothing else.
    pub is_plain: bool,
    is_contact: bool,
}

impl NodeBodies {
    /// Rows for which its node counts when an order is chosen.
    fn weight(&self) -> u32 {
        if self.is_contact { CONTACT_WEIGHT } else { self.capacity }
    }
}

/// A body has more contacts than the nodes of its joints hold.
struct NoRoom;

impl Articulation {
    /// Prepares the structure of the matrix; false where sweeps are the better choice, or where they must be if it is `asked` for.
    pub(super) fn lay_out(&mut self, asked: bool) -> bool {
        self.stale |= std::mem::replace(&mut self.is_asked_for, asked) != asked;
        self.carried.clear();
        self.carried.extend(self.touches.iter().filter(|touch| touch.other_moves).map(|touch| [touch.body, touch.other]));
        self.carried.sort_unstable();
        self.carried.dedup();
        let Self { entries, ends, bodies, carried, .. } = self;
        let link = |(entry, &ends): (&JointEntry, &[u32; 2])| {
            let moves = ends.map(|body| bodies[body as usize].is_dynamic());
            let capacity = u32::from(entry.most_rows) + if entry.is_distance { 2 } else { 0 };
            NodeBodies { bodies: ends, moves, capacity, is_plain: entry.is_plain, is_contact: false }
        };
        let contact =
            |&bodies: &[u32; 2]| NodeBodies { bodies, moves: [true; 2], capacity: 0, is_plain: false, is_contact: true };
        let links = || entries.iter().zip(&*ends).map(link).chain(carried.iter().map(contact));
        let unchanged = self.links.len() == entries.len() + carried.len() && self.links.iter().copied().eq(links());
        if !unchanged {
            self.links.clear();
            self.links.extend(links());
            self.room.clear();
            self.room.resize(self.links.len(), 0);
            self.stale = true;
        }
        self.hangs = self.touches.iter().any(|touch| !touch.other_moves) || self.links.iter().any(|link| link.moves != [true; 2]);
        self.is_points = self.touches.is_empty() && self.links.iter().all(|link| link.is_plain);
        match self.place_touches() {
            Ok(grew) => self.stale |= grew,
            Err(NoRoom) => return false,
        }
        if std::mem::take(&mut self.stale) {
            self.topology = derive_topology(&self.links, &self.room, self.bodies.len(), asked).unwrap_or_default();
        }
        if self.topology.plan.work == 0 {
            return false;
        }
        wide_integrator::gather(&mut self.bodies4, &self.bodies);
        let Self { entries, links, bodies, eases, .. } = self;
        let ease = |(entry, link): (&JointEntry, &NodeBodies)| -> f64 {
            [0, 1].map(|side| bodies[link.bodies[side] as usize].turning_ease(entry.local_lever[side])).iter().sum()
        };
        eases.clear();
        eases.extend(entries.iter().zip(&*links).map(ease));
        let levers = entries.iter().flat_map(|entry| entry.local_lever).map(DVec3::length).filter(|&length| length > 0.0);
        let (sum, count) = levers.fold((0.0, 0.0), |(sum, count), length| (sum + length, count + 1.0));
        self.size = if count > 0.0 {
            sum / count
        } else {
            // Lines between the middles of bodies have no levers, and are as long as they are.
            let lines: f64 = entries.iter().map(|entry| entry.offset.length()).sum();
            (lines / entries.len() as f64).clamp(MIN_SIZE, 1.0)
        };
        true
    }

    /// Whether joints leave no freedom: contacts then contradict one another, and no active set of theirs comes to an end.
    pub(super) fn is_rigid(&self) -> bool {
        let rows: u32 = self.entries.iter().map(|entry| u32::from(entry.most_rows)).sum();
        rows as usize >= 6 * self.jointed_bodies()
    }

    /// Bodies that it moves and joints hold.
    pub(super) fn jointed_bodies(&self) -> usize {
        self.bodies.iter().filter(|body| body.is_dynamic() && !body.is_rider).count()
    }

    /// Gives every contact with what does not move a joint of its body whose node has its rows, and every other the node of its two
    /// bodies; says whether any node needs more room than it had.
    fn place_touches(&mut self) -> Result<bool, NoRoom> {
        let Self { touches, links, room, needed, .. } = self;
        if touches.is_empty() {
            return Ok(false);
        }
        needed.clear();
        needed.resize(links.len(), 0);
        for touch in touches.iter_mut() {
            let is_host = |link: &NodeBodies| match touch.other_moves {
                true => link.is_contact && link.bodies == [touch.body, touch.other],
                false => link.bodies.contains(&touch.body),
            };
            let hosts = links.iter().enumerate().filter(|(_, link)| is_host(link));
            let (node, link) =
                hosts.min_by_key(|&(node, link)| (link.is_contact, link.capacity + needed[node], node)).ok_or(NoRoom)?;
            touch.node = node as u32;
            touch.side = u8::from(link.bodies[1] == touch.body);
            needed[node] += touch.rows();
            if (link.capacity + needed[node]) as usize > MAX_ROWS {
                return Err(NoRoom);
            }
        }
        touches.sort_unstable_by_key(|touch| (touch.node, touch.number));
        let mut grew = false;
        for (room, &needed) in room.iter_mut().zip(&*needed) {
            grew |= needed > *room;
            *room = needed.max(*room);
        }
        Ok(grew)
    }
}

/// Couples all joints that share a moving body; `room` is that for rows of contacts.
fn derive_topology(links: &[NodeBodies], room: &[u32], bodies: usize, asked: bool) -> Option<Topology> {
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
    Some(Topology { plan, couplings, regularizations: Regularization::all(capacity.len(), loops), loops, doubled })
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
