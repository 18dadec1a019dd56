//! Long-range constraints of a world: derived when its joints have changed, handed to the batches, read by the host.

use glam::{DVec3, Vec3};

use super::wake::Edited;
use super::{Batches, Islands, Movers, World};
use crate::error::{Error, ErrorKind, Result};
use crate::id::{JointId, Pool};
use crate::joint::Softness;
use crate::joint_graph::graph::PointLink;
use crate::joint_graph::load::NodeId;
use crate::joint_graph::plane::{Chain, Hinge, find_chains};
use crate::joint_graph::soft::Request;
use crate::joint_graph::{Bound, BoundInput, Choice, Derived, JointSide, PartBounds};
use crate::joint_record::Joint;
use crate::long_range::{BoundKind, BoundState, LongRangeDef, SoftBound};
use crate::snapshot::carried::{AskedBound, CarriedBound};

mod links;

pub(super) use links::{ends_of, holds_points};
use links::{hinge_of, link_of};

/// Level of a record that another has taken over; there are no such bounds.
const TAKEN: u8 = u8::MAX;

/// A bound, and what steps leave in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundRecord {
    pub bound: Bound,
    /// Joint slot and side of its near and far end.
    pub ends: [(u32, u8); 2],
    /// Give of the lower row of a bound that the host asked for.
    pub softness: Softness,
    /// Multipliers of the upper and the lower row at the end of the last substep (N·s).
    pub impulses: [f32; 2],
    /// Force on the far body, mean over the last step (N).
    pub far_force: Vec3,
    pub active: bool,
}

impl BoundRecord {
    /// A record before its bound is derived anew.
    fn carried(carried: &CarriedBound) -> Self {
        let &CarriedBound { kind, level, upper, lower, ends, impulses, far_force, active } = carried;
        let [near, far] = [JointSide { link: 0, side: 0 }; 2];
        let bound = Bound { kind, level, near, far, upper, lower, path: NodeId::NONE, inner: (0, 0), request: None };
        Self { bound, ends, softness: Softness::RIGID, impulses, far_force, active }
    }

    fn key(&self) -> (BoundKind, [(u32, u8); 2]) {
        (self.bound.kind, self.ends)
    }

    fn take_over(&mut self, old: &mut Self) {
        (self.impulses, self.far_force, self.active) = (old.impulses, old.far_force, old.active);
        old.bound.level = TAKEN;
    }
}

/// Everything long-range of a world.
#[derive(Debug, Default)]
pub(super) struct LongRange {
    /// Whether joints, limits, joint frames or masses have changed since bounds were derived.
    stale: bool,
    pub derived: Derived,
    /// Hinge chains, by their lowest joint.
    pub chains: Vec<Chain>,
    pub records: Vec<BoundRecord>,
    previous: Vec<BoundRecord>,
    /// What the host asked for, by its joints.
    pub soft: Vec<AskedBound>,
    /// Which of those each request to the derivation stands for.
    asked: Vec<usize>,
    /// Bodies connected to a joint that the host asked for a bound between: their joints are left to sweeps, which know bounds.
    pub swept: Vec<bool>,
    /// Bounds by the slot of their far body, as ranges in `of_body`.
    starts: Vec<u32>,
    of_body: Vec<u32>,
    /// Far body of each record; none of those that end on what nothing moves.
    far_bodies: Vec<Option<u32>>,
}

impl LongRange {
    /// Says that joints, limits, joint frames or masses have changed.
    pub(super) fn graph_changed(&mut self) {
        self.stale = true;
    }

    /// Whether the host asked for a bound that ends at this joint.
    pub(super) fn is_asked_at(&self, joint: JointId) -> bool {
        self.soft.iter().any(|asked| asked.joints.contains(&joint))
    }

    fn bounds_of(&self, body: u32) -> &[u32] {
        match (self.starts.get(body as usize), self.starts.get(body as usize + 1)) {
            (Some(&first), Some(&end)) => &self.of_body[first as usize..end as usize],
            _ => &[],
        }
    }
}

impl World {
    /// Derives bounds anew if the graph of joints has changed.
    pub(super) fn derive_long_range(&mut self) {
        if !self.long_range.stale {
            return;
        }
        let Self { long_range, joints, bodies, unions, def, .. } = self;
        long_range.stale = false;
        let settings = &def.long_range;
        let mut input = BoundInput { masses: vec![f32::INFINITY; bodies.slot_count()], ..BoundInput::default() };
        long_range.chains.clear();
        if settings.enabled {
            for (slot, body) in bodies.iter().filter(|(_, body)| body.is_free() && !body.quarantined) {
                if let Some(mass) = &body.mass {
                    input.masses[slot as usize] = unions.moving(slot).map_or(mass.mass, |union| union.mass.mass);
                }
            }
            input.links.resize(joints.slot_count(), None);
            for (slot, joint) in joints.iter() {
                input.links[slot as usize] = link_of(joint, unions, bodies);
            }
            input.choice = Choice {
                attachment: settings.attachment.enabled,
                hierarchy: settings.hierarchy.enabled,
                levels: settings.levels,
            };
            if settings.plane_position || settings.plane_axis {
                let hinges: Vec<Hinge> =
                    joints.iter().filter_map(|(slot, joint)| hinge_of(slot, joint, unions, bodies)).collect();
                long_range.chains = find_chains(&hinges);
            }
        }
        input.requests = long_range.requests(joints, &input.links, settings);
        long_range.derived.update(input);
        long_range.mark_swept();
        long_range.take_over();
        let anew = self.long_range.derived.of_parts.iter().filter(|part| part.kept.is_none());
        self.report.counts.bounds_derived = anew.map(|part| part.count).sum();
    }

    /// Hands the bounds of everything awake to the batches of their far bodies.
    pub(super) fn hand_out_bounds(&mut self) {
        let Self {
            islands: Islands { groups, .. },
            batches: Batches { list: batches, .. },
            long_range,
            bodies,
            movers: Movers { slots: movers, .. },
            report,
            ..
        } = self;
        for (number, chain) in long_range.chains.iter().enumerate() {
            let are_solved = chain.members.iter().all(|member| !bodies[member.body].held);
            if let Some(first) = chain.members.first().filter(|first| are_solved && bodies[first.body].is_mover()) {
                batches[groups.place[first.body as usize].0 as usize].planes.chains.push(number as u32);
                report.counts.planes += 1;
            }
        }
        if long_range.records.is_empty() {
            return;
        }
        let awake = || movers.iter().copied().filter(|&body| bodies[body].is_free() && !bodies[body].held);
        let count: usize = awake().map(|body| long_range.bounds_of(body).len()).sum();
        report.counts.bounds += count as u32;
        if count == long_range.of_body.len() {
            // All are awake: in the order of the records, nothing is to be sorted.
            for (slot, body) in long_range.far_bodies.iter().enumerate() {
                if let Some(body) = *body {
                    batches[groups.place[body as usize].0 as usize].long_range.slots.push(slot as u32);
                }
            }
            return;
        }
        for body in awake() {
            let batch = &mut batches[groups.place[body as usize].0 as usize];
            batch.long_range.slots.extend_from_slice(long_range.bounds_of(body));
        }
        batches[..self.batches.count].iter_mut().for_each(|batch| batch.long_range.slots.sort_unstable());
    }

    /// Adds what bounds carry to the loads of the joints that they lead past.
    pub(super) fn add_bound_loads(&mut self, dt: f32) {
        let Self { batches: Batches { list: batches, count: batch_count, .. }, long_range, joints, .. } = self;
        if long_range.records.is_empty() {
            return;
        }
        let LongRange { derived, records, .. } = long_range;
        derived.paths.unload();
        for entry in batches[..*batch_count].iter().flat_map(|batch| &batch.long_range.bounds.entries) {
            let force = entry.far_sum / dt;
            if force.is_finite() && entry.impulses.iter().all(|impulse| impulse.is_finite()) {
                derived.paths.load(records[entry.bound as usize].bound.path, force);
            }
        }
        for batch in &batches[..*batch_count] {
            for entry in batch.long_range.wraps.entries.iter().filter(|entry| entry.sum.is_finite() && entry.far_sum.is_finite())
            {
                derived.paths.load(records[entry.bound as usize].bound.path, entry.far_sum / dt);
                for bend in &batch.long_range.wraps.bends[entry.bends.0 as usize..entry.bends.1 as usize] {
                    derived.paths.load(derived.inner[bend.inner as usize].path, bend.turn * (entry.sum / dt));
                }
            }
            for entry in batch.long_range.taut.entries.iter().filter(|entry| entry.own_sum != Vec3::ZERO) {
                let (own, far) = (entry.own_sum / dt, entry.far_sum / dt);
                if own.is_finite() && far.is_finite() {
                    let bound = batch.long_range.bounds.entries[entry.bound as usize].bound;
                    derived.paths.load(derived.inner[entry.inner as usize].path, own);
                    derived.paths.load(records[bound as usize].bound.path, far);
                }
            }
        }
        derived.paths.hand_down(|beyond, force| {
            let on_b = if beyond.side == 1 { force } else { -force };
            joints[beyond.link].force += on_b;
        });
    }

    /// Writes multipliers back.
    pub(super) fn store_bounds(&mut self, dt: f32) {
        let Self {
            batches: Batches { list: batches, count: batch_count, .. },
            long_range: LongRange { records, .. },
            report,
            ..
        } = self;
        // What is skipped is slack.
        for &slot in batches[..*batch_count].iter().flat_map(|batch| &batch.long_range.slots) {
            let record = &mut records[slot as usize];
            (record.impulses, record.far_force, record.active) = ([0.0; 2], Vec3::ZERO, false);
        }
        report.counts.bounds_skipped = batches[..*batch_count].iter().map(|batch| batch.long_range.bounds.skipped).sum();
        // Records have multipliers of the world's substep.
        let of_all = || batches[..*batch_count].iter().map(|batch| (batch, 1.0 / batch.stride));
        for (entry, share) in
            of_all().flat_map(|(batch, share)| batch.long_range.bounds.entries.iter().map(move |entry| (entry, share)))
        {
            let record = &mut records[entry.bound as usize];
            record.active = entry.acted;
            report.counts.bounds_active += u32::from(entry.acted);
            let force = entry.far_sum / dt;
            if force.is_finite() && entry.impulses.iter().all(|impulse| impulse.is_finite()) {
                (record.impulses, record.far_force) = (entry.impulses.map(|impulse| impulse * share), force);
            } else {
                (record.impulses, record.far_force) = ([0.0; 2], Vec3::ZERO);
            }
        }
        report.counts.bounds_wrapped =
            batches[..*batch_count].iter().map(|batch| batch.long_range.wraps.entries.len() as u32).sum();
        for (entry, share) in
            of_all().flat_map(|(batch, share)| batch.long_range.wraps.entries.iter().map(move |entry| (entry, share)))
        {
            let record = &mut records[entry.bound as usize];
            let far_force = entry.far_sum / dt;
            if far_force.is_finite() && entry.impulse.is_finite() {
                (record.impulses, record.far_force, record.active) = ([entry.impulse * share, 0.0], far_force, entry.sum > 0.0);
                report.counts.bounds_active += u32::from(record.active);
            }
        }
    }

    /// Changes what is derived, and wakes everything.
    ///
    /// # Errors
    /// Names the field of `def` that is out of range; nothing has changed then.
    pub fn set_long_range(&mut self, def: &LongRangeDef) -> Result<()> {
        def.check()?;
        let unite = |def: &LongRangeDef| def.enabled && def.union;
        if unite(&self.def.long_range) != unite(def) {
            self.all_welds_changed();
        }
        self.def.long_range = *def;
        self.long_range.graph_changed();
        self.wake_all();
        Ok(())
    }

    /// Asks for a soft bound between two joints, or takes it back, and wakes their bodies. It ends with either joint.
    ///
    /// # Errors
    /// A handle is not a joint of this world; the two are the same; a number of `bound` is out of range.
    pub fn set_soft_bound(&mut self, joint_a: JointId, joint_b: JointId, bound: Option<SoftBound>) -> Result<()> {
        let named = |argument| move |error| Error { argument, ..error };
        let slots = [self.joints.find(joint_a).map_err(named("joint_a"))?, self.joints.find(joint_b).map_err(named("joint_b"))?];
        if joint_a == joint_b {
            return Err(Error::new(ErrorKind::NotApplicable, "joint_b", "is the same as joint_a"));
        }
        if let Some(bound) = &bound {
            bound.check()?;
        }
        let ends = if joint_a < joint_b { [joint_a, joint_b] } else { [joint_b, joint_a] };
        slots.iter().for_each(|&slot| self.joint_changed(slot));
        self.long_range.soft.retain(|asked| asked.joints != ends);
        self.long_range.soft.extend(bound.map(|bound| AskedBound { joints: ends, bound }));
        self.long_range.graph_changed();
        for slot in slots {
            self.joint_changed(slot);
            self.wake_for(Edited::Joint(slot));
        }
        Ok(())
    }

    /// What bounds carry from step to step, and whether they are to be derived anew.
    pub(super) fn carried_bounds(&self) -> (bool, Vec<CarriedBound>) {
        // The give of what was asked for comes from the request.
        let carried = |&BoundRecord { bound, ends, softness: _, impulses, far_force, active }: &BoundRecord| {
            let Bound { kind, level, near: _, far: _, upper, lower, path: _, inner: _, request: _ } = bound;
            CarriedBound { kind, level, upper, lower, ends, impulses, far_force, active }
        };
        (self.long_range.stale, self.long_range.records.iter().map(carried).collect())
    }

    /// Derives all bounds anew after a restore, with what they carried; not if the next step would do so anyway.
    pub(super) fn restart_long_range(&mut self, stale: bool, carried: &[CarriedBound], asked: Vec<AskedBound>) {
        let records: Vec<BoundRecord> = carried.iter().map(BoundRecord::carried).collect();
        let mut derived = std::mem::take(&mut self.long_range.derived);
        derived.forget_places();
        self.long_range = LongRange { stale: true, soft: asked, derived, ..LongRange::default() };
        if stale {
            self.long_range.records = records;
            return;
        }
        self.derive_long_range();
        // The same joints give the same bounds in the same order.
        let derived = self.long_range.records.iter_mut().zip(&records);
        for (record, old) in derived.filter(|(record, old)| record.key() == old.key()) {
            (record.impulses, record.far_force, record.active) = (old.impulses, old.far_force, old.active);
        }
    }

    /// Every bound that was derived for the last step, with what it did.
    pub fn bounds(&self) -> impl Iterator<Item = BoundState> + '_ {
        self.long_range.records.iter().filter_map(|record| self.bound_state(record))
    }

    fn bound_state(&self, record: &BoundRecord) -> Option<BoundState> {
        let point = |(joint, side): (u32, u8)| Some(self.joint_point(self.joints.get(joint)?, side as usize));
        let points = [point(record.ends[0])?, point(record.ends[1])?];
        let gap = (points[1] - points[0]).as_vec3();
        Some(BoundState {
            kind: record.bound.kind,
            level: u32::from(record.bound.level),
            near: self.joints.handle_of(record.ends[0].0),
            far: self.joints.handle_of(record.ends[1].0),
            points,
            distance: gap.length(),
            upper: record.bound.upper,
            lower: record.bound.lower,
            tension: -record.far_force.dot(gap.normalize_or_zero()),
            active: record.active,
        })
    }

    /// World position of a joint's point on one of its bodies (m).
    pub(super) fn joint_point(&self, joint: &Joint, side: usize) -> DVec3 {
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        match joint.bodies[side] {
            None => frame.position,
            Some(body) => self.bodies[body].pose().transform_point(frame.position.as_vec3()),
        }
    }

    /// Give of a bound's upper and lower row.
    pub(super) fn bound_give(def: &LongRangeDef, record: &BoundRecord) -> [Softness; 2] {
        match record.bound.kind {
            BoundKind::Soft => [Softness::RIGID, record.softness],
            BoundKind::Attachment => [def.attachment.upper, def.attachment.lower],
            _ => [def.hierarchy.upper, def.hierarchy.lower],
        }
    }
}

impl LongRange {
    /// What the host asked for, as the derivation wants it; what named a joint that is gone is dropped.
    fn requests(&mut self, joints: &Pool<Joint, JointId>, links: &[Option<PointLink>], settings: &LongRangeDef) -> Vec<Request> {
        self.soft.retain(|asked| asked.joints.iter().all(|&joint| joints.find(joint).is_ok()));
        self.asked.clear();
        let Self { soft, asked, .. } = self;
        let place = |joint: JointId| joints.find(joint).ok().filter(|&slot| links[slot as usize].is_some());
        let mut requests = Vec::new();
        for (number, AskedBound { joints: ends, bound }) in soft.iter().enumerate().filter(|_| settings.enabled && settings.soft)
        {
            if let [Some(a), Some(b)] = ends.map(place) {
                asked.push(number);
                requests.push(Request { links: [a, b], share: bound.share });
            }
        }
        requests
    }

    /// Notes all bodies connected to what the host asked a bound for.
    fn mark_swept(&mut self) {
        self.swept.clear();
        for body in self.derived.bodies_with_requests() {
            self.swept.resize(self.derived.input.masses.len(), false);
            self.swept[body as usize] = true;
        }
    }

    /// Makes records of the bounds; those that were there before keep their multipliers.
    fn take_over(&mut self) {
        std::mem::swap(&mut self.records, &mut self.previous);
        let Self { derived, records, previous, starts, of_body, far_bodies, soft, asked, .. } = self;
        records.clear();
        records.extend(derived.bounds.iter().map(|&bound| {
            let ends = [bound.near, bound.far].map(|end| (end.link, end.side));
            let asked_for = bound.request.and_then(|request| soft.get(asked[request as usize]));
            let softness = asked_for.map_or(Softness::RIGID, |asked| asked.bound.softness);
            BoundRecord { bound, ends, softness, impulses: [0.0; 2], far_force: Vec3::ZERO, active: false }
        }));
        for &PartBounds { first, count, kept } in derived.of_parts.iter() {
            if let Some(before) = kept {
                let same = &mut previous[before as usize..(before + count) as usize];
                for (record, old) in records[first as usize..].iter_mut().zip(same) {
                    record.take_over(old);
                }
            }
        }
        previous.retain(|old| old.bound.level != TAKEN);
        // Of records that say the same, the first is taken over first.
        previous.sort_by_key(BoundRecord::key);
        for part in derived.of_parts.iter().filter(|part| part.kept.is_none()) {
            for record in &mut records[part.first as usize..(part.first + part.count) as usize] {
                let first = previous.partition_point(|old| old.key() < record.key());
                let same = previous[first..].iter_mut().take_while(|old| old.key() == record.key());
                if let Some(old) = same.into_iter().find(|old| old.bound.level != TAKEN) {
                    record.take_over(old);
                }
            }
        }
        far_bodies.clear();
        far_bodies.extend(derived.bounds.iter().map(|bound| derived.dynamic_body(bound.far)));
        starts.clear();
        starts.resize(derived.input.masses.len() + 1, 0);
        for &body in far_bodies.iter().flatten() {
            starts[body as usize + 1] += 1;
        }
        for body in 1..starts.len() {
            starts[body] += starts[body - 1];
        }
        let mut next = starts.clone();
        of_body.clear();
        of_body.resize(*starts.last().unwrap_or(&0) as usize, 0);
        for (number, body) in far_bodies.iter().enumerate() {
            if let Some(body) = *body {
                of_body[next[body as usize] as usize] = number as u32;
                next[body as usize] += 1;
            }
        }
    }
}
