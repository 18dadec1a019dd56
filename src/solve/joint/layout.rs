//! Lays out the joints of a batch for sweeps: sorted by colour, by what they hold, and by domain; like ones in lanes.

use std::ops::Range;

use super::lanes::Holds;
use super::{BatchJoints, JointEntry, JointLink, Visit, reach, singles};
use crate::id::{JointId, Pool};
use crate::joint::Softness;
use crate::joint_record::Joint;
use crate::solve::body_flags::BodyFlags;
use crate::solve::color::{Coloring, MAX_COLORS};
use crate::solve::contact::LANES;
use crate::solve::state::{BodyMotion, BodyVelocity, WORLD_SLOT};
use crate::workers::Workers;

/// What joints of one colour may hold, none of it in lanes among that; and groups by colour and that, the last for no colour. Each has
/// a part for every strip, and one for what is in none.
const KINDS: usize = 1 + Holds::ALL.len();
const GROUPS: usize = KINDS * (MAX_COLORS + 1);

impl BatchJoints {
    /// Lays out rows of the joints in the order of their colours, for a step of `substeps` of length `h`; joints of one colour share no
    /// moving body. `left` are what the entries were made from, where those are not all.
    pub(crate) fn lay_out(
        &mut self,
        (joints, left): (&Pool<Joint, JointId>, Option<&[JointLink]>),
        threads: &Workers,
        coloring: &mut Coloring,
        bodies: (&[BodyVelocity], &[BodyMotion], &[BodyFlags]),
        h: f32,
        substeps: u32,
    ) {
        self.domains.cut(left.unwrap_or(&self.links), bodies.1.len());
        self.lanes.clear(WORLD_SLOT);
        self.singles.clear();
        self.visits.clear();
        self.parts.clear();
        if self.entries.is_empty() {
            return;
        }
        coloring.reset(bodies.1.len());
        self.find_parts((joints, left), coloring, bodies, h * substeps as f32);
        self.sort_by_part();
        self.lay_out_domains(joints, threads, h);
        self.lay_out_rest(joints, h);
    }

    /// Finds the part of each joint, for a step of `dt` (s), and how many joints each part has.
    fn find_parts(
        &mut self,
        (joints, left): (&Pool<Joint, JointId>, Option<&[JointLink]>),
        coloring: &mut Coloring,
        (velocities, motions, body_flags): (&[BodyVelocity], &[BodyMotion], &[BodyFlags]),
        dt: f32,
    ) {
        let Self { links, entries, domains, parts, places, .. } = self;
        let parts_each = domains.len() + 1;
        places.clear();
        places.resize(GROUPS * parts_each + 1, 0);
        for (number, link) in left.unwrap_or(links).iter().enumerate() {
            let end = |slot: u32| (slot, body_flags[slot as usize].moves());
            let color = coloring.assign(end(link.a), end(link.b));
            // What locks hold is told one by one.
            let is_locked = || singles::locks_of(&entries[number], velocities, motions).is_some();
            let holds = color.filter(|_| !link.traits.has_friction && !is_locked()).and_then(|_| {
                // Most joints of a net are plain: known without reading their records.
                if link.traits.is_plain {
                    return Some(Holds::Points);
                }
                if joints[link.joint].drive.is_some() {
                    return None;
                }
                let kind = &joints[link.joint].def.kind;
                let always = Holds::of(kind, u32::from(link.traits.most_rows), false);
                let is_free = || reach::stops_are_out_of_reach(&entries[number], kind, velocities, motions, dt);
                always.or_else(|| if is_free() { Holds::of(kind, u32::from(link.traits.most_rows), true) } else { None })
            });
            let group = color.unwrap_or(MAX_COLORS as u32) as usize * KINDS + holds.map_or(0, |holds| 1 + holds as usize);
            let domain = holds.and_then(|_| domains.strip_of(link)).unwrap_or(domains.len());
            let part = group * parts_each + domain;
            parts.push(part as u32);
            places[part + 1] += 1;
        }
    }

    /// Sorts the numbers of the joints by their parts (a counting sort); `places` then holds where each part ends.
    fn sort_by_part(&mut self) {
        let Self { entries, parts, places, order, .. } = self;
        for part in 1..places.len() {
            places[part] += places[part - 1];
        }
        order.resize(entries.len(), 0);
        for (number, &part) in parts.iter().enumerate() {
            let place = &mut places[part as usize];
            order[*place as usize] = number as u32;
            *place += 1;
        }
    }

    /// Lays out the full blocks of each domain.
    fn lay_out_domains(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32) {
        let Self { entries, domains, places, order, .. } = self;
        let parts_each = domains.len() + 1;
        threads.share(domains.all_mut().iter_mut().enumerate(), |(number, domain)| {
            for group in 0..GROUPS {
                let own = &order[range_of(places, group * parts_each + number)];
                let own = &own[..in_full_blocks(own, group)];
                if let Some(holds) = holds_of(group).filter(|_| !own.is_empty()) {
                    let first_block = domain.lanes.len();
                    domain.lanes.add(own.iter().map(|&number| with_softness(joints, entries, number)), holds, h);
                    domain.visits.push(first_block..domain.lanes.len());
                }
            }
        });
    }

    /// Lays out the joints between domains, and those that fill no block of their domain.
    fn lay_out_rest(&mut self, joints: &Pool<Joint, JointId>, h: f32) {
        let Self { entries, domains, lanes, singles, visits, places, left_over, order, .. } = self;
        let parts_each = domains.len() + 1;
        for group in 0..GROUPS {
            let parts = group * parts_each..(group + 1) * parts_each;
            if range_of(places, parts.start).start == range_of(places, parts.end - 1).end {
                continue;
            }
            left_over.clear();
            for own in parts.clone().take(domains.len()).map(|number| &order[range_of(places, number)]) {
                left_over.extend_from_slice(&own[in_full_blocks(own, group)..]);
            }
            let between = &order[range_of(places, parts.end - 1)];
            let rest = if left_over.is_empty() {
                between
            } else {
                left_over.extend_from_slice(between);
                &*left_over
            };
            let (blocks, first_single) = (lanes.len(), singles.len());
            match holds_of(group) {
                Some(holds) => lanes.add(rest.iter().map(|&number| with_softness(joints, entries, number)), holds, h),
                None => singles.add(rest),
            }
            visits.push(Visit { blocks: blocks..lanes.len(), singles: first_single..singles.len() });
        }
    }
}

/// Where a part is in the order, once joints are sorted: each part begins where the one before ends.
fn range_of(places: &[u32], part: usize) -> Range<usize> {
    let start = if part == 0 { 0 } else { places[part - 1] as usize };
    start..places[part] as usize
}

/// What the joints of a group hold; none where they are swept one by one.
fn holds_of(group: usize) -> Option<Holds> {
    (group % KINDS).checked_sub(1).map(|holds| Holds::ALL[holds])
}

/// How many of these fill whole blocks.
fn in_full_blocks(own: &[u32], group: usize) -> usize {
    if holds_of(group).is_some() { own.len() - own.len() % LANES } else { 0 }
}

/// A joint by its number, with the softness of its points and directions.
fn with_softness<'a>(
    joints: &Pool<Joint, JointId>,
    entries: &'a [JointEntry],
    number: u32,
) -> (u32, &'a JointEntry, [Softness; 2]) {
    let entry = &entries[number as usize];
    if entry.traits.is_plain {
        return (number, entry, [Softness::RIGID; 2]);
    }
    let def = &joints[entry.joint].def;
    (number, entry, [def.linear, def.angular])
}
