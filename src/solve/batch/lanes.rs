//! Assigns the manifolds of a batch to blocks and lanes.
//!
//! Within a colour, manifolds of one point have blocks of their own, which cost a fraction of those of four; and in a large batch both are in
//! the order of their bodies, so that threads which divide them by bodies find theirs in their caches. Which lane a manifold has makes no
//! difference to its multipliers.
//!
//! Each colour has manifolds of most bodies. Where these are more than a cache holds, they are swept in rounds: all colours of the manifolds
//! of the first [`ROUND`] bodies, then all of the next.

use super::{Batch, BatchManifolds, ContactEnds, HELD};
use crate::prefetch::AHEAD;
use crate::solve::buckets::Buckets;
use crate::solve::color::{Coloring, MAX_COLORS};
use crate::solve::contact::{ContactInput, LANES};
use crate::solve::contact_partition::CUTS;
use crate::solve::{contact_kernels, parallel_contacts};
use crate::tight_vec::make_room;
use crate::workers::Workers;

/// Groups of manifolds: two for each colour, two for what found none; and the first of those. There are as many for each round, and once more
/// for manifolds of bodies that joints hold, with each other and with what is fixed.
const GROUPS: usize = 2 * MAX_COLORS + 2;
const ALONE: usize = 2 * MAX_COLORS;

/// Bodies of a round: 256 kB of velocities, which a second-level cache holds beside what streams through it.
const ROUND: usize = 4096;

/// Whether manifolds of this group share no moving body.
fn is_colored(group: usize) -> bool {
    group % GROUPS < ALONE
}

/// Whether manifolds of this group have more than one point.
fn has_faces(group: usize) -> bool {
    group.is_multiple_of(2)
}

/// Manifolds from which on those of a colour are in the order of their bodies.
const ORDERED_FROM: usize = 512;

/// Where the manifolds of a batch are in its blocks, and buffers to find that.
#[derive(Debug, Default)]
pub(crate) struct LaneLayout {
    /// Block and lane of each manifold.
    pub(super) lanes: Vec<(u32, u32)>,
    /// Which thread's each block is, where several work on them.
    places: Vec<u8>,
    pub coloring: Coloring,
    /// Colour of each manifold, twice, plus one if it has a single point; and [`GROUPS`] more for each round before its own.
    groups: Vec<u32>,
    /// Manifolds of each group, then the next lane of each.
    group_lanes: Vec<u32>,
    /// Manifolds by the first of their bodies, where there are many.
    by_body: Buckets,
    /// Number of colours that the contacts took.
    pub color_count: u32,
}

/// What groups the manifolds of a batch have.
struct ColorGroups {
    rounds: usize,
    colors: u32,
    /// Whether none of them has more than contacts of most materials.
    are_plain: bool,
}

impl ColorGroups {
    /// Those that may have any manifold: most are of colours that none has.
    fn iter(&self) -> impl Iterator<Item = usize> {
        let used = 2 * self.colors as usize;
        (0..=self.rounds).flat_map(move |round| round * GROUPS..round * GROUPS + used)
    }

    /// The first of those of bodies that joints hold.
    fn first_jointed(&self) -> usize {
        self.rounds * GROUPS
    }
}

/// Blocks of a group: what found no colour is solved one manifold a block.
fn blocks_of(group: usize, count: u32) -> usize {
    if is_colored(group) { count.div_ceil(LANES as u32) as usize } else { count as usize }
}

impl ContactEnds {
    /// Slot, less one, of the first of its bodies that moves: that of the world comes before all, those of what is driven after all.
    fn first_moving(&self) -> u32 {
        self.a.wrapping_sub(1).min(self.b.wrapping_sub(1))
    }
}

impl Batch {
    /// Lays out a block and a lane for every manifold that no articulation holds.
    pub(crate) fn color_contacts(&mut self) {
        self.contacts.first_jointed = 0;
        if self.manifolds.ends.is_empty() {
            return self.contacts.begin(0, 0);
        }
        let groups = self.group_contacts();
        // Colours are taken from the lowest on.
        self.layout.color_count = groups.colors;
        self.lay_out_blocks(&groups);
        self.give_lanes(&groups);
        if groups.are_plain {
            return;
        }
        let Self { layout: LaneLayout { lanes, .. }, manifolds: BatchManifolds { ends, .. }, contacts, .. } = self;
        let needs = |number: &usize| lanes[*number].0 != HELD && !ends[*number].is_plain;
        contacts.add_extras((0..lanes.len()).filter(needs).map(|number| lanes[number].0 as usize));
    }

    /// Finds the group of each manifold.
    fn group_contacts(&mut self) -> ColorGroups {
        let (moving, rounds) = (self.moving().max(1), self.moving().div_ceil(ROUND).max(1));
        let Self { layout, body_flags, manifolds: BatchManifolds { ends, .. }, direct, newton, .. } = self;
        let LaneLayout { coloring, groups: group_of, group_lanes: counts, .. } = layout;
        counts.clear();
        counts.resize((rounds + 1) * GROUPS, 0);
        coloring.reset(body_flags.len());
        group_of.clear();
        make_room(group_of, ends.len());
        let mut groups = ColorGroups { rounds, colors: 0, are_plain: true };
        for (number, own) in ends.iter().enumerate() {
            let &ContactEnds { a, b, points, is_plain, .. } = own;
            if direct.holds(number) || newton.holds(number) {
                group_of.push(HELD);
                continue;
            }
            let [role_a, role_b] = [a, b].map(|slot| body_flags[slot as usize]);
            let color = coloring.assign((a, role_a.moves()), (b, role_b.moves())).unwrap_or(MAX_COLORS as u32);
            let held_by_joints = (role_a.moves() || role_b.moves()) && !role_a.is_loose() && !role_b.is_loose();
            let round = if held_by_joints { rounds } else { (own.first_moving() as usize * rounds / moving).min(rounds - 1) };
            let group = 2 * color as usize + usize::from(points == 1) + round * GROUPS;
            counts[group] += 1;
            groups.colors = groups.colors.max(color + 1);
            groups.are_plain &= is_plain;
            group_of.push(group as u32);
        }
        body_flags.iter_mut().zip(coloring.have_any()).filter(|&(_, has_any)| has_any).for_each(|(role, _)| role.touch());
        groups
    }

    /// Lays out the blocks of all groups, and puts the first lane of each group where its count was.
    fn lay_out_blocks(&mut self, groups: &ColorGroups) {
        let Self { contacts, layout: LaneLayout { group_lanes, .. }, .. } = self;
        let blocks = |group: usize| blocks_of(group, group_lanes[group]);
        let faces = groups.iter().filter(|&group| has_faces(group)).map(blocks).sum();
        contacts.begin(groups.iter().map(blocks).sum(), faces);
        let (mut first, mut first_face) = (0, 0);
        for group in groups.iter() {
            if group == groups.first_jointed() {
                contacts.first_jointed = first;
            }
            let count = std::mem::replace(&mut group_lanes[group], (first * LANES) as u32);
            let range = first..first + blocks_of(group, count);
            first = range.end;
            let full = if is_colored(group) { count as usize / LANES } else { 0 };
            contacts.lay_out(range.clone(), full, has_faces(group), first_face);
            first_face += if has_faces(group) { range.len() } else { 0 };
            contacts.add_color(range, group / GROUPS, is_colored(group), has_faces(group));
        }
    }

    /// Gives each manifold a lane of its group.
    fn give_lanes(&mut self, all: &ColorGroups) {
        let moving = self.moving().max(1);
        let Self { layout, manifolds: BatchManifolds { ends, .. }, contacts, velocities, .. } = self;
        let LaneLayout { groups, group_lanes: next, lanes, by_body, .. } = layout;
        make_room(lanes, groups.len());
        lanes.resize(groups.len(), (HELD, 0));
        let mut give = |number: usize| {
            let group = groups[number];
            if group != HELD {
                let place = &mut next[group as usize];
                lanes[number] = (*place / LANES as u32, *place % LANES as u32);
                *place += if is_colored(group as usize) { 1 } else { LANES as u32 };
            }
        };
        if ends.len() < ORDERED_FROM {
            return (0..ends.len()).for_each(give);
        }
        by_body.sort(velocities.len(), ends.iter().enumerate().map(|(number, ends)| (ends.first_moving(), number as u32)));
        let order = by_body.all();
        order.iter().for_each(|&number| give(number as usize));
        let first_of = |number: u32| ends[number as usize].first_moving();
        contacts.firsts.resize(contacts.len(), 0);
        for &number in order {
            let (block, lane) = lanes[number as usize];
            if block != HELD && lane == 0 {
                contacts.firsts[block as usize] = first_of(number);
            }
        }
        // Of each round, and of all, which those of bodies in joints are cut by.
        let round_of = |number: u32| first_of(number) as usize * all.rounds / moving;
        let mut rest = order;
        for round in 0..=all.rounds {
            let own;
            (own, rest) = rest.split_at(rest.partition_point(|&number| round_of(number) <= round));
            let cut = if round == all.rounds { order } else { own };
            contacts.cuts.extend((0..CUTS).map(|part| cut.get(part * cut.len() / CUTS).map_or(0, |&number| first_of(number))));
        }
    }

    /// Prepares the rows of all manifolds that have a lane, which `form` brings into world axes: the first of those that it is given, the
    /// others of which come next; points closer than `reach` (m) count as touching.
    pub(crate) fn set_contacts(
        &mut self,
        threads: &Workers,
        reach: f32,
        form: impl Fn(&[(u32, u32)], ContactEnds) -> ContactInput + Sync,
    ) {
        let Self { layout: LaneLayout { lanes, places, .. }, manifolds, contacts, velocities, .. } = self;
        let BatchManifolds { list, ends, inputs, .. } = &*manifolds;
        let input = |number: usize| {
            let formed = inputs.get(number).copied();
            formed.unwrap_or_else(|| form(&list[number..], ends[number]))
        };
        // In the order in which pairs lie in memory, which blocks do not follow.
        if threads.is_alone() || contacts.cuts.is_empty() {
            for (number, &(block, lane)) in lanes.iter().enumerate().filter(|(_, (block, _))| *block != HELD) {
                if let Some(&(block, 0)) = lanes.get(number + AHEAD)
                    && block != HELD
                {
                    contacts.ask_for(block as usize);
                }
                contacts.whole(block as usize).set_lane(lane as usize, &input(number), reach);
            }
            return contacts.all().each(|mut block| contact_kernels::set_masses(&mut block, velocities));
        }
        parallel_contacts::each_manifold(contacts, threads, lanes, places, |block, lane, number| {
            block.set_lane(lane, &input(number), reach)
        });
        parallel_contacts::side_by_side(contacts, threads, |mut run| {
            run.part.each(|mut block| contact_kernels::set_masses(&mut block, velocities));
        });
    }
}
