//! Long-range constraints of a world: derived from its joints when those have changed, handed to the batches, read out.

use glam::{DVec3, Vec3};

use super::World;
use crate::error::Result;
use crate::joint::{Joint, JointDef, JointKind, Softness};
use crate::long_range::{BoundKind, BoundState, LongRangeDef};
use crate::span::graph::{Link, Turn};
use crate::span::{Bound, Choice, Derived, JointSide};

/// A bound, and what steps leave in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundRecord {
    pub bound: Bound,
    /// Joint slot and side of its near and far end.
    pub ends: [(u32, u8); 2],
    /// Multipliers of the upper and the lower row at the end of the last substep (N·s).
    pub impulses: [f32; 2],
    /// Force on the far body, mean over the last step (N).
    pub far_force: Vec3,
    pub active: bool,
}

impl BoundRecord {
    fn key(&self) -> (BoundKind, [(u32, u8); 2]) {
        (self.bound.kind, self.ends)
    }
}

/// Everything long-range of a world.
#[derive(Debug, Default)]
pub(super) struct LongRange {
    /// Whether joints, limits, joint frames or masses have changed since bounds were derived.
    stale: bool,
    pub derived: Derived,
    pub records: Vec<BoundRecord>,
    previous: Vec<BoundRecord>,
    /// Bounds by the slot of their far body, as ranges in `of_body`.
    starts: Vec<u32>,
    of_body: Vec<u32>,
}

impl LongRange {
    /// Says that joints, limits, joint frames or masses have changed.
    pub(super) fn graph_changed(&mut self) {
        self.stale = true;
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
        let Self { long_range, joints, bodies, def, .. } = self;
        long_range.stale = false;
        long_range.derived.graph.clear(bodies.slot_count());
        let settings = &def.long_range;
        if settings.enabled {
            for (slot, body) in bodies.iter().filter(|(_, body)| body.is_dynamic()) {
                if let Some(mass) = &body.mass {
                    long_range.derived.graph.masses[slot as usize] = mass.mass;
                }
            }
            for (slot, joint) in joints.iter() {
                if let Some(turn) = turn_of(&joint.def) {
                    long_range.derived.graph.links.push(link_of(slot, joint, turn));
                }
            }
        }
        long_range.derived.rebuild(Choice {
            attachment: settings.attachment.enabled,
            hierarchy: settings.hierarchy.enabled,
            levels: settings.levels,
        });
        long_range.take_over();
        self.report.counts.bounds_derived = self.long_range.records.len() as u32;
    }

    /// Hands the bounds of everything awake to the batches of their far bodies.
    pub(super) fn hand_out_bounds(&mut self) {
        let Self { groups, batches, long_range, bodies, movers, report, .. } = self;
        if long_range.records.is_empty() {
            return;
        }
        for &body in movers.iter().filter(|&&body| bodies[body].is_dynamic() && !bodies[body].held) {
            let batch = &mut batches[groups.place[body as usize].0 as usize];
            batch.bound_slots.extend_from_slice(long_range.bounds_of(body));
        }
        for batch in &mut batches[..self.batch_count] {
            batch.bound_slots.sort_unstable();
            report.counts.bounds += batch.bound_slots.len() as u32;
        }
    }

    /// Writes multipliers back, and adds what bounds carry to the loads of the joints that they lead past.
    pub(super) fn store_bounds(&mut self, dt: f32) {
        let Self { batches, batch_count, long_range, joints, report, .. } = self;
        if long_range.records.is_empty() {
            return;
        }
        let LongRange { derived, records, .. } = long_range;
        derived.paths.unload();
        for batch in &batches[..*batch_count] {
            for entry in &batch.bounds.entries {
                let record = &mut records[entry.bound as usize];
                record.active = entry.acted;
                report.counts.bounds_active += u32::from(entry.acted);
                let force = entry.far_sum / dt;
                if force.is_finite() && entry.impulses.iter().all(|impulse| impulse.is_finite()) {
                    record.impulses = entry.impulses;
                    record.far_force = force;
                    derived.paths.load(record.bound.path, force);
                } else {
                    record.impulses = [0.0; 2];
                    record.far_force = Vec3::ZERO;
                }
            }
        }
        for batch in &batches[..*batch_count] {
            for entry in batch.taut.entries.iter().filter(|entry| entry.own_sum != Vec3::ZERO) {
                let (own, far) = (entry.own_sum / dt, entry.far_sum / dt);
                if own.is_finite() && far.is_finite() {
                    let bound = batch.bounds.entries[entry.bound as usize].bound;
                    derived.paths.load(derived.inner[entry.inner as usize].path, own);
                    derived.paths.load(records[bound as usize].bound.path, far);
                }
            }
        }
        let links = &derived.graph.links;
        derived.paths.hand_down(|beyond, force| {
            let on_b = if beyond.side == 1 { force } else { -force };
            joints[links[beyond.link as usize].joint].force += on_b;
        });
    }

    /// Changes what is derived, and wakes everything.
    ///
    /// # Errors
    /// Names the field of `def` that is out of range; nothing has changed then.
    pub fn set_long_range(&mut self, def: &LongRangeDef) -> Result<()> {
        def.check()?;
        self.def.long_range = *def;
        self.long_range.graph_changed();
        self.wake_all();
        Ok(())
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
    fn joint_point(&self, joint: &Joint, side: usize) -> DVec3 {
        let frame = if side == 0 { &joint.def.frame_a } else { &joint.def.frame_b };
        match joint.bodies[side] {
            None => frame.position,
            Some(body) => self.bodies[body].pose().transform_point(frame.position.as_vec3()),
        }
    }

    /// Give of a bound's upper and lower row.
    pub(super) fn bound_give(def: &LongRangeDef, kind: BoundKind) -> [Softness; 2] {
        match kind {
            BoundKind::Attachment => [def.attachment.upper, def.attachment.lower],
            _ => [def.hierarchy.upper, def.hierarchy.lower],
        }
    }
}

impl LongRange {
    /// Makes records of the bounds just derived; those that were there before keep their multipliers.
    fn take_over(&mut self) {
        std::mem::swap(&mut self.records, &mut self.previous);
        self.previous.sort_unstable_by_key(BoundRecord::key);
        let Self { derived, records, previous, starts, of_body, .. } = self;
        let place = |end: JointSide| (derived.graph.links[end.link as usize].joint, end.side);
        records.clear();
        records.extend(derived.bounds.iter().map(|&bound| {
            let ends = [place(bound.near), place(bound.far)];
            let mut record = BoundRecord { bound, ends, impulses: [0.0; 2], far_force: Vec3::ZERO, active: false };
            if let Ok(found) = previous.binary_search_by_key(&record.key(), BoundRecord::key) {
                record.impulses = previous[found].impulses;
            }
            record
        }));
        let far_body = |bound: &Bound| derived.graph.dynamic_body(bound.far);
        starts.clear();
        starts.resize(derived.graph.masses.len() + 1, 0);
        for body in derived.bounds.iter().filter_map(far_body) {
            starts[body as usize + 1] += 1;
        }
        for body in 1..starts.len() {
            starts[body] += starts[body - 1];
        }
        let mut next = starts.clone();
        of_body.clear();
        of_body.resize(*starts.last().unwrap_or(&0) as usize, 0);
        for (number, bound) in derived.bounds.iter().enumerate() {
            if let Some(body) = far_body(bound) {
                of_body[next[body as usize] as usize] = number as u32;
                next[body as usize] += 1;
            }
        }
    }
}

/// What a joint lets turn, if it holds its points together without give.
fn turn_of(def: &JointDef) -> Option<Turn> {
    if def.linear.compliance > 0.0 {
        return None;
    }
    let frames = [def.frame_a.rotation, def.frame_b.rotation];
    let stiff = def.angular.compliance == 0.0;
    let stops = stiff && def.limit.compliance == 0.0;
    match def.kind {
        JointKind::Fixed if stiff => Some(Turn::Fixed { frames }),
        JointKind::Hinge { limits, .. } if stops => Some(Turn::Hinge { frames, min: limits.min, max: limits.max }),
        JointKind::Hinge { .. } if stiff => Some(Turn::Hinge { frames, min: f32::NEG_INFINITY, max: f32::INFINITY }),
        JointKind::Spherical { swing_limit, .. } if def.limit.compliance == 0.0 => {
            Some(Turn::Swing { frames, limit: swing_limit })
        }
        JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => Some(Turn::Free),
        JointKind::Generic { linear, .. } => {
            let held = linear.iter().all(|axis| axis.limits.min == 0.0 && axis.limits.max == 0.0);
            (held && def.limit.compliance == 0.0).then_some(Turn::Free)
        }
        JointKind::Distance { .. } | JointKind::Prismatic { .. } => None,
    }
}

fn link_of(slot: u32, joint: &Joint, turn: Turn) -> Link {
    let points = [joint.def.frame_a.position.as_vec3(), joint.def.frame_b.position.as_vec3()];
    Link { joint: slot, bodies: joint.bodies, points, turn }
}
