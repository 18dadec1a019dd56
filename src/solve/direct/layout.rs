//! Lays out the matrix of an articulation: which nodes it has, and where rows of contacts go.

use glam::DVec3;

use super::articulation::Articulation;
use super::block::MAX_ROWS;
use super::body::DirectBody;
use super::topology::{NodeBodies, Topology};
use super::wide_integrator;
use crate::solve::joint::JointEntry;
use crate::solve::joint::locks::Freedom;

/// Least size of an articulation without levers (m).
const MIN_SIZE: f64 = 1.0e-3;

/// Cube of the rows of a dense matrix over the multiplications that its factor takes.
const WORK_OF_DENSE: u64 = 6;

/// Passes over the rows of contacts beside the joints' factor, as many as an active set takes, that are to be no more work than that factor:
/// else there is little to gain. Chains that are wound up tight, with as many contacts as joints, jam less with rows in the factor.
const PASSES_FOR_A_FACTOR: u64 = 12;

/// Whether rows of contacts are so few that they are better beside a factor of joints that takes so many multiplications.
pub(crate) fn are_few(rows: u64, joint_work: u64) -> bool {
    rows.pow(3) * PASSES_FOR_A_FACTOR <= WORK_OF_DENSE * joint_work
}

/// Node of a joint between these bodies.
fn link_of(entry: &JointEntry, ends: [u32; 2], bodies: &[DirectBody]) -> NodeBodies {
    let capacity = u32::from(entry.traits.most_rows) + if entry.is_distance { 2 } else { 0 };
    let moves = ends.map(|body| bodies[body as usize].is_dynamic());
    // What locks hold of its points is no row.
    let [a, b] = ends.map(|body| bodies[body as usize].freedom());
    let is_plain = entry.traits.is_plain && Freedom::of_both(a, b).is_none();
    NodeBodies { bodies: ends, moves, capacity, is_plain, is_contact: false }
}

/// A body has more contacts than the nodes of its joints hold.
struct NoRoom;

impl Articulation {
    /// Prepares the structure of the matrix; false where sweeps are the better choice, or where they must be if it is `asked` for.
    pub(super) fn lay_out(&mut self, asked: bool) -> bool {
        self.stale |= std::mem::replace(&mut self.is_asked_for, asked) != asked;
        self.links.truncate(self.planned);
        self.compare_joints();
        // How much work the factor of the joints is says whether contacts are beside it, and is not known until it has been laid out.
        self.system.beside.is_on = self.may_stand_beside();
        if !self.plan_factor(asked) {
            return false;
        }
        if self.system.beside.is_on && !self.may_stand_beside() {
            self.system.beside.is_on = false;
            if !self.plan_factor(asked) {
                return false;
            }
        }
        if self.system.beside.is_on {
            self.place_beside();
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

    /// Forgets how much work the joints are where they are no longer the same.
    fn compare_joints(&mut self) {
        let Self { entries, ends, bodies, links, .. } = self;
        let joints = entries.iter().zip(&*ends).map(|(entry, &ends)| link_of(entry, ends, bodies));
        if !links.iter().take_while(|link| !link.is_contact).copied().eq(joints) {
            (self.joint_work, self.stale) = (0, true);
        }
    }

    /// Whether its contacts are beside the factor of its joints: passes over their matrix take no more work than that, as far as that is known.
    fn may_stand_beside(&self) -> bool {
        let rows: u64 = self.touches.iter().map(|touch| u64::from(touch.rows())).sum();
        rows > 0 && (self.joint_work == 0 || are_few(rows, self.joint_work))
    }

    /// Lays out the factor, with rows of contacts in it unless these are beside it.
    fn plan_factor(&mut self, asked: bool) -> bool {
        let beside = self.system.beside.is_on;
        self.carried.clear();
        self.carried
            .extend(self.touches.iter().filter(|touch| !beside && touch.other_moves).map(|touch| [touch.body, touch.other]));
        self.carried.sort_unstable();
        self.carried.dedup();
        let Self { entries, ends, bodies, carried, links, room, .. } = self;
        let are_carried = links.iter().skip(entries.len()).map(|link| link.bodies).eq(carried.iter().copied());
        if self.stale || !are_carried {
            links.clear();
            links.extend(entries.iter().zip(&*ends).map(|(entry, &ends)| link_of(entry, ends, bodies)));
            links.extend(carried.iter().map(|&bodies| NodeBodies::of_contact(bodies, [true; 2])));
            room.clear();
            room.resize(links.len(), 0);
            self.stale = true;
        }
        self.planned = self.links.len();
        self.hangs = self.touches.iter().any(|touch| !touch.other_moves) || self.links.iter().any(|link| link.moves != [true; 2]);
        self.is_points = self.touches.is_empty() && self.links.iter().all(|link| link.is_plain);
        if !beside {
            match self.place_touches() {
                Ok(grew) => self.stale |= grew,
                Err(NoRoom) => return false,
            }
        }
        if std::mem::take(&mut self.stale) {
            self.topology = Topology::derive(&self.links, &self.room, self.bodies.len(), asked).unwrap_or_default();
        }
        // Of the joints as they were first laid out: room that contacts have taken since then is no joint's.
        if self.joint_work == 0 {
            self.joint_work = self.topology.plan.work;
        }
        self.topology.plan.work > 0
    }

    /// Gives every contact a node of its own after those of the factor.
    fn place_beside(&mut self) {
        let Self { touches, links, bodies, .. } = self;
        touches.sort_unstable_by_key(|touch| touch.number);
        for touch in touches {
            (touch.node, touch.side) = (links.len() as u32, 0);
            let ends = [touch.body, touch.other];
            links.push(NodeBodies::of_contact(ends, ends.map(|body| bodies[body as usize].is_dynamic())));
        }
    }

    /// Whether joints leave no freedom: contacts then contradict one another, and no active set of theirs comes to an end. Stops that are not met,
    /// motors and friction within bounds leave it: they give way to what a contact holds.
    pub(super) fn is_rigid(&self) -> bool {
        let rows: u32 = self.entries.iter().map(|entry| u32::from(entry.traits.held_rows)).sum();
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
