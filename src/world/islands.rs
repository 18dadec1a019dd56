//! Stages that sort bodies, contacts and joints into islands, and islands into batches.

use super::unions::Anchor;
use super::{Batches, Collision, Islands, Movers, World};
use crate::id::{JointId, Pool};
use crate::island::UnionFind;
use crate::joint_record::Joint;
use crate::solve::batch::Batch;
use crate::solve::joint::JointTraits;

/// Bodies after which a batch takes no further island. It must not depend on the number of threads.
const BATCH_BODIES: u32 = 64;

/// Bodies of an island that has a batch to itself: it may be a sheet, which is solved as a whole.
const LARGE_ISLAND: u32 = crate::joint_graph::mesh::MIN_BODIES as u32;

/// Bodies for which batches that are not used may keep room.
const MIN_DROPPED: usize = 2048;

/// Where each body is in the batches of this step.
#[derive(Debug, Default)]
pub(super) struct IslandGroups {
    /// Batch and slot of each mover, by body slot.
    pub place: Vec<(u32, u32)>,
    /// Island of each mover, by body slot.
    pub island: Vec<u32>,
    sizes: Vec<u32>,
    /// Slots that each island takes in its batch: one for a body, one for a union.
    slots: Vec<u32>,
    /// Substeps of the world that each island takes at once; empty where all take them one by one.
    pub strides: Vec<u32>,
    /// First member of each island in `members`.
    starts: Vec<u32>,
    /// Movers that are dynamic, in their order, and those of them that joints hold.
    pub dynamic: Vec<u32>,
    pub bound: Vec<u32>,
    /// Movers that are dynamic, sorted by island.
    pub members: Vec<u32>,
    /// Bodies of each batch, and the substeps that its islands take at once.
    batch_sizes: Vec<u32>,
    batch_strides: Vec<u32>,
    /// Place of each joint among those of its batch, by slot; of joints at rest, those of some step before.
    pub joint_places: Vec<u32>,
    /// Bodies and traits of each joint, by slot, and the version of the joints that this was found of: the joints themselves are far from one
    /// another in memory, and each body asks for those of all its joints twice a step.
    pub joint_heads: Vec<JointHead>,
    pub joint_version: Option<u64>,
    /// Joints of what moves in order, each once, and what they were listed for.
    pub sorted_joints: Vec<u32>,
    pub listed: Listed,
    /// Whether those are the ones of this step too, and islands those of the last step, which consisted of what joints connect.
    pub joints_stay: bool,
    islands_stay: bool,
    are_of_joints: bool,
}

/// What joints were listed for: movers that are dynamic, those of them that joints hold, and the version of the joints.
#[derive(Debug, Default)]
pub(super) struct Listed {
    pub dynamic: Vec<u32>,
    pub bound: Vec<u32>,
    pub joint_version: Option<u64>,
}

/// Body of a joint's side that is the world.
pub(super) const NO_BODY: u32 = u32::MAX;

/// What is asked of a joint where islands are formed and batches filled.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointHead {
    pub bodies: [u32; 2],
    pub traits: JointTraits,
}

impl JointHead {
    /// Of a slot without a joint.
    const NONE: Self = Self { bodies: [NO_BODY; 2], traits: JointTraits::NONE };

    fn of(joint: &Joint) -> Self {
        Self { bodies: joint.bodies.map(|body| body.unwrap_or(NO_BODY)), traits: JointTraits::of(joint) }
    }
}

impl IslandGroups {
    /// Members of each island, by number.
    pub(super) fn islands(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|range| &self.members[range[0] as usize..range[1] as usize])
    }

    /// Members of the island of this number.
    pub(super) fn members_of(&self, island: u32) -> Option<&[u32]> {
        let range = self.starts.get(island as usize..island as usize + 2)?;
        Some(&self.members[range[0] as usize..range[1] as usize])
    }
}

impl IslandGroups {
    /// Forgets what a step has found, of a world that is no more.
    pub(super) fn forget(&mut self) {
        self.starts.clear();
        self.members.clear();
        self.place.clear();
        self.joint_version = None;
        self.listed.joint_version = None;
    }

    /// The batch with the most bodies of those that are solved, if there is any.
    pub(super) fn largest_batch(&self) -> Option<u32> {
        (0..self.batch_sizes.len() as u32).max_by_key(|&batch| self.batch_sizes[batch as usize])
    }

    /// Brings what is known of the joints up to date.
    fn list_joint_heads(&mut self, joints: &Pool<Joint, JointId>) {
        if self.joint_version == Some(joints.version()) {
            return;
        }
        self.joint_version = Some(joints.version());
        self.joint_heads.clear();
        self.joint_heads.resize(joints.slot_count(), JointHead::NONE);
        for (slot, joint) in joints.iter() {
            self.joint_heads[slot as usize] = JointHead::of(joint);
        }
    }

    /// Leaves a body of an island out of its batch. What islands take in batches is no longer what they consist of, so they are formed
    /// anew in the next step.
    pub(super) fn leave_out(&mut self, body: u32) {
        self.slots[self.island[body as usize] as usize] -= 1;
        self.are_of_joints = false;
    }

    /// Takes note of another definition of a joint.
    pub(super) fn joint_changed(&mut self, slot: u32, joint: &Joint) {
        if let Some(head) = self.joint_heads.get_mut(slot as usize) {
            *head = JointHead::of(joint);
        }
    }
}

impl World {
    /// Batch and slot of a body that is solved in this step: of others, places are those of some step before.
    pub(super) fn solved_at(&self, body: u32) -> Option<(&Batch, usize)> {
        self.bodies.get(body).filter(|record| record.is_solved())?;
        let &(batch, slot) = self.islands.groups.place.get(body as usize)?;
        let batch = self.batches.list[..self.batches.count].get(batch as usize)?;
        (batch.bodies.get(slot as usize) == Some(&body)).then_some((batch, slot as usize))
    }

    /// Sorts everything awake into islands and batches.
    pub(super) fn group_islands(&mut self) {
        self.collision.pairs.settle();
        self.take_census();
        if self.islands.summaries.some_drive() {
            self.release_what_is_driven();
            self.take_census();
        }
        self.list_touches();
        self.join_islands();
        self.number_islands();
        self.hold_islands();
        self.choose_strides();
        self.make_batches();
        self.hand_out_contacts();
        self.hand_out_joints();
    }

    /// Finds the islands of now for an edit between two steps. None begins to be held: whether something comes near is only looked for in the next
    /// step, which finds its own islands.
    pub(super) fn find_islands(&mut self) {
        self.collision.pairs.settle();
        self.take_census();
        self.list_touches();
        self.join_islands();
        self.number_islands();
        self.islands.groups.listed.joint_version = None;
    }

    fn join_islands(&mut self) {
        let Self {
            scratch,
            bodies,
            joints,
            movers: Movers { slots: movers, .. },
            unions,
            islands: Islands { groups, summaries, .. },
            collision: Collision { touches, index, .. },
            ..
        } = self;
        groups.list_joint_heads(joints);
        index.free.begin(bodies.slot_count());
        groups.dynamic.clear();
        groups.bound.clear();
        let mut are_held = false;
        for &body in movers.iter() {
            let known = summaries.of(body);
            if known.is_free() {
                groups.dynamic.push(body);
                index.free.set(body);
                if known.is_jointed() {
                    groups.bound.push(body);
                    are_held |= known.is_held();
                }
            }
        }
        let has_unions = unions.iter().next().is_some();
        groups.joints_stay = groups.listed.joint_version == groups.joint_version
            && !are_held
            && !has_unions
            && groups.listed.bound == groups.bound
            && groups.listed.dynamic == groups.dynamic;
        let joins = |body: u32| index.free.has(body);
        let mut connecting = touches.touching().map(|touch| touch.bodies).filter(|&[a, b]| joins(a) && joins(b)).peekable();
        let are_of_joints = connecting.peek().is_none() && !has_unions;
        groups.islands_stay = groups.joints_stay && are_of_joints && groups.are_of_joints;
        groups.are_of_joints = are_of_joints;
        if groups.islands_stay {
            return;
        }
        scratch.islands.reset(bodies.slot_count(), movers);
        let islands = &mut scratch.islands;
        connecting.for_each(|[a, b]| islands.union(a, b));
        let join_ends = |slot: u32, islands: &mut UnionFind| {
            let [a, b] = groups.joint_heads[slot as usize].bodies;
            if a != NO_BODY && b != NO_BODY && joins(a) && joins(b) {
                islands.union(a, b);
            }
        };
        if groups.joints_stay {
            return groups.sorted_joints.iter().for_each(|&slot| join_ends(slot, islands));
        }
        for &body in &groups.bound {
            match unions.moving(body) {
                None => {
                    for &id in &bodies[body].joints {
                        let slot = joints.slot_of(id);
                        let first = groups.joint_heads[slot as usize].bodies[0];
                        // Once, from its first body, unless that is moved as another.
                        if first == body || unions.moving(first).is_some() {
                            join_ends(slot, islands);
                        }
                    }
                }
                Some(union) if union.lead == body => {
                    union.members.iter().for_each(|&member| islands.union(body, member));
                    union.outer.iter().for_each(|&slot| join_ends(slot, islands));
                }
                Some(_) => {}
            }
        }
    }

    /// Numbers the islands by their lowest body and lists their members.
    fn number_islands(&mut self) {
        let Self { scratch, bodies, islands: Islands { groups, .. }, unions, report, .. } = self;
        (report.counts.unions, report.counts.union_members) = (0, 0);
        groups.island.resize(bodies.slot_count(), 0);
        groups.place.resize(bodies.slot_count(), (0, 0));
        if groups.islands_stay {
            (report.counts.islands, report.counts.bodies_awake) = (groups.sizes.len() as u32, groups.members.len() as u32);
            return;
        }
        groups.sizes.clear();
        groups.slots.clear();
        for union in unions.iter().filter(|union| union.anchor == Anchor::Free && bodies[union.lead].is_mover()) {
            report.counts.unions += 1;
            report.counts.union_members += union.members.len() as u32;
        }
        for &body in &groups.dynamic {
            let root = scratch.islands.find(body);
            if root == body {
                groups.island[body as usize] = groups.sizes.len() as u32;
                groups.sizes.push(0);
                groups.slots.push(0);
            }
            // The root is the lowest member, so it has its number already.
            let island = groups.island[root as usize];
            groups.island[body as usize] = island;
            groups.sizes[island as usize] += 1;
            groups.slots[island as usize] += u32::from(unions.moving(body).is_none_or(|union| union.lead == body));
        }
        groups.starts.clear();
        groups.starts.push(0);
        let mut total = 0;
        for &size in &groups.sizes {
            total += size;
            groups.starts.push(total);
        }
        groups.members.clear();
        groups.members.resize(total as usize, 0);
        let mut next = std::mem::take(&mut scratch.slots);
        next.clear();
        next.extend_from_slice(&groups.starts);
        for &body in &groups.dynamic {
            let place = &mut next[groups.island[body as usize] as usize];
            groups.members[*place as usize] = body;
            *place += 1;
        }
        scratch.slots = next;
        report.counts.islands = groups.sizes.len() as u32;
        report.counts.bodies_awake = total;
    }

    fn make_batches(&mut self) {
        self.size_batches();
        self.give_room_to_batches();
        self.drop_idle_batches();
        let Self {
            islands: Islands { groups, hold, .. },
            batches: Batches { list: batches, count: batch_count, .. },
            unions,
            ..
        } = self;
        batches[..*batch_count].iter_mut().for_each(Batch::clear);
        let mut batch = 0;
        for island in (0..groups.sizes.len()).filter(|&island| !hold.islands[island]) {
            if batches[batch].body_count() >= groups.batch_sizes[batch] {
                batch += 1;
            }
            batches[batch].stride = groups.batch_strides[batch] as f32;
            batches[batch].begin_island();
            for member in groups.starts[island]..groups.starts[island + 1] {
                let body = groups.members[member as usize];
                if hold.units.members.has(body) {
                    continue;
                }
                // Members are sorted, so the lead has its slot already.
                groups.place[body as usize] = match unions.moving(body).filter(|union| union.lead != body) {
                    Some(union) => groups.place[union.lead as usize],
                    None => (batch as u32, batches[batch].enlist(body)),
                };
            }
        }
    }

    /// Counts the bodies of each batch.
    fn size_batches(&mut self) {
        let Self {
            islands: Islands { groups, hold, .. },
            batches: Batches { list: batches, stages, count: batch_count, .. },
            report,
            ..
        } = self;
        groups.batch_sizes.clear();
        groups.batch_strides.clear();
        let islands = groups.slots.iter().zip(&hold.islands).enumerate();
        for (island, (&size, _)) in islands.filter(|&(_, (_, &held))| !held) {
            let stride = groups.strides.get(island).copied().unwrap_or(1);
            let fits = groups.batch_strides.last() == Some(&stride) && size < LARGE_ISLAND;
            match groups.batch_sizes.last_mut().filter(|filled| fits && **filled < BATCH_BODIES) {
                Some(filled) => *filled += size,
                None => {
                    groups.batch_sizes.push(size);
                    groups.batch_strides.push(stride);
                }
            }
        }
        *batch_count = groups.batch_sizes.len();
        if batches.len() < *batch_count {
            batches.resize_with(*batch_count, Default::default);
            stages.resize_with(*batch_count, Default::default);
        }
        report.counts.batches = *batch_count as u32;
    }

    /// Lets a batch that needs more room than it has change places with the one that has the most: an island's number changes from
    /// step to step, and without this every batch would keep the memory of the largest island that it ever was.
    fn give_room_to_batches(&mut self) {
        let Self { islands: Islands { groups, .. }, batches: Batches { list: batches, stages, .. }, .. } = self;
        let need = |batch: usize| groups.batch_sizes.get(batch).map_or(0, |&size| size as usize);
        for batch in 0..groups.batch_sizes.len() {
            if batches[batch].room() < need(batch)
                && let Some(roomiest) = (0..batches.len()).max_by_key(|&other| batches[other].room())
                && batches[roomiest].room() > batches[batch].room()
                && need(roomiest) < need(batch)
            {
                batches.swap(batch, roomiest);
                stages.swap(batch, roomiest);
            }
        }
    }

    /// Gives back the memory of batches that are not used, where they have more room than those that are: bodies that fall one by one
    /// are in many batches, and when they lie in a pile in one.
    fn drop_idle_batches(&mut self) {
        let Self { islands: Islands { groups, .. }, batches: Batches { list: batches, stages, count: batch_count, .. }, .. } =
            self;
        let needed: usize = groups.batch_sizes.iter().map(|&size| size as usize).sum();
        let idle: usize = batches[*batch_count..].iter().map(Batch::room).sum();
        if idle > needed.max(MIN_DROPPED) {
            batches.truncate(*batch_count);
            batches.shrink_to_fit();
            stages.truncate(*batch_count);
            stages.shrink_to_fit();
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::solve::joint::JointTraits;
    use crate::{BodyDef, JointDef, JointId, JointKind, Limits, Motor, Pose, Shape, ShapeDef, Softness, Solver, World, WorldDef};

    const DRIVEN: JointKind =
        JointKind::Hinge { limits: Limits { min: -1.0, max: 1.0 }, motor: Motor::Velocity { target: 1.0, max_force: 5.0 } };
    const SOFT: Softness = Softness { compliance: 1.0e-3, damping: 0.1 };

    type Edit = fn(&mut World, JointId);

    #[test]
    fn what_is_known_of_a_joint_follows_each_change_of_its_definition() {
        let mut world = World::new(&WorldDef::default()).unwrap();
        let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap());
        let [a, b] =
            [0.0, 2.0].map(|x| world.create_body(&BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_shape(cube.clone())).unwrap());
        let hinge = world.create_joint(&JointDef::new(JointKind::HINGE, a, b).at(Vec3::X, Vec3::NEG_X)).unwrap();
        let edits: [Edit; 5] = [
            |world, joint| world.set_joint_kind(joint, DRIVEN).unwrap(),
            |world, joint| world.set_joint_friction(joint, 0.5).unwrap(),
            |world, joint| world.set_joint_softness(joint, SOFT, SOFT, SOFT).unwrap(),
            |world, joint| world.set_joint_solver(joint, Solver::GaussSeidel).unwrap(),
            |world, joint| world.set_joint_axis_friction(joint, [0.1; 6]).unwrap(),
        ];
        world.step(1.0 / 60.0).unwrap();
        let slot = world.joints.find(hinge).unwrap();
        let known = |world: &World| world.islands.groups.joint_heads[slot as usize].traits;
        let mut before;
        for (number, edit) in edits.iter().enumerate() {
            // What moved with the last edit stands still again.
            world.step(1.0 / 60.0).unwrap();
            before = known(&world);
            edit(&mut world, hinge);
            let now = JointTraits::of(&world.joints[slot]);
            assert_eq!(known(&world), now, "edit {number}");
            assert!(number > 3 || now != before, "edit {number} is seen");
        }
    }

    #[test]
    fn islands_that_stay_follow_every_edit() {
        let mut world = World::new(&WorldDef { gravity: Vec3::ZERO, ..WorldDef::default() }).unwrap();
        let cube = ShapeDef::new(Shape::cuboid(Vec3::splat(0.5)).unwrap());
        let at = |x: f64| BodyDef::dynamic(Pose::at_xyz(x, 0.0, 0.0)).with_shape(cube.clone());
        let [a, b, c] = [0.0, 2.0, 4.0].map(|x| world.create_body(&at(x)).unwrap());
        let spherical = |one, other| JointDef::new(JointKind::SPHERICAL, one, other).at(Vec3::X, Vec3::NEG_X);
        world.create_joint(&spherical(a, b)).unwrap();
        let islands = |world: &mut World| {
            let counts = [0, 1, 2].map(|_| world.step(1.0 / 60.0).unwrap().counts);
            assert!(counts.iter().all(|of| (of.islands, of.joints) == (counts[0].islands, counts[0].joints)), "{counts:?}");
            (counts[0].islands, counts[0].joints, counts[0].bodies_awake)
        };
        assert_eq!(islands(&mut world), (2, 1, 3));
        assert!(world.islands.groups.islands_stay);
        let second = world.create_joint(&spherical(b, c)).unwrap();
        assert_eq!(islands(&mut world), (1, 2, 3));
        world.destroy_joint(second).unwrap();
        assert_eq!(islands(&mut world), (2, 1, 3));
        world.set_pose(c, Pose::at_xyz(3.0, 0.0, 0.0)).unwrap();
        assert_eq!(islands(&mut world), (1, 1, 3), "they touch");
        assert!(!world.islands.groups.islands_stay);
        world.set_pose(c, Pose::at_xyz(6.0, 0.0, 0.0)).unwrap();
        assert_eq!(islands(&mut world), (2, 1, 3));
        world.destroy_body(c).unwrap();
        assert_eq!(islands(&mut world), (1, 1, 2));
        world.create_body(&at(6.0)).unwrap();
        assert_eq!(islands(&mut world), (2, 1, 3));
        world.put_to_sleep(a).unwrap();
        assert_eq!(islands(&mut world), (1, 0, 1));
    }
}
