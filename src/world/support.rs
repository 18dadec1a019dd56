//! Stage that updates the support graph: only pairs whose links may have changed are read.
//!
//! A link is made anew when its manifold was, when a body has turned under it, or when it begins or ends to be pressed or to
//! slide; everything else of the graph stays. What sleeps is not looked at. While nothing stands on, or hangs from, what needs no
//! support itself, nothing is: the stage *rests*, and what is asked of it meanwhile is worked out for those who ask.

mod arch_stability;
mod dirty_pairs;
mod pair_view;
mod query;
mod record;

use std::sync::OnceLock;

use glam::{Quat, Vec3};

use super::World;
use crate::body::{Body, BodyKind};
use crate::collide::cache::put_in_places;
use crate::collide::pairs::Word;
use crate::dwell_time::DwellTime;
use crate::joint::{Axis, JointKind, Motor};
use crate::joint_graph::support::verdict::SupportChange;
use crate::joint_graph::support::{NodeKind, SupportGraph, SupportNode};
use crate::joint_record::Joint;
use crate::tuning::support::GAIN_TIME;
use arch_stability::Thrust;
use dirty_pairs::TURNED;
pub(super) use pair_view::{PairFrame, PairView, told_by};
use record::{Record, Seen};

/// Whether the stage rests, and what keeps it from that.
#[derive(Debug, Default)]
pub(super) struct SupportRest {
    pub rests: bool,
    /// Whether something has come to stand on what needs no support since.
    pub has_landed: bool,
    /// Whether a joint holds anything to what needs no support, and whether anything is braced or pressed against such.
    has_anchors: bool,
    leans: bool,
}

/// What has changed since the last update.
#[derive(Debug, Default)]
pub(super) struct SupportChanges {
    /// Whether everything must be looked at, also what sleeps.
    is_new: bool,
    pub bodies: bool,
    pub joints: bool,
}

impl SupportChanges {
    const ALL: Self = Self { is_new: true, bodies: true, joints: true };
}

/// The analysis of a world, and what it was made from.
#[derive(Debug, Default)]
pub(super) struct SupportState {
    pub graph: SupportGraph,
    pub frame: Option<PairFrame>,
    gravity: Vec3,
    /// What the links of each pair were made from, by pair slot.
    records: Vec<Record>,
    /// Rotation of each body that its links were made for.
    made_for: Vec<Quat>,
    /// What may have changed the links of each shape in the step, as in `look`.
    signs: Vec<u8>,
    kinematic: Vec<u32>,
    /// Pairs to look at, of those that are being reported.
    near: Vec<u32>,
    /// Pairs that touch after the step, of bodies that are not all held, where thrust is looked for.
    pressed: Vec<u32>,
    /// Pairs that have fallen asleep, or are held with a unit, since the last update: they are at rest now, and looked at once more.
    pub came_to_rest: Vec<u32>,
    /// Pairs looked at so far.
    looked_at: u64,
    pub rest: SupportRest,
    /// Whether what stands by thrust is looked for, and what was found.
    pub by_thrust: bool,
    thrust: Thrust,
    /// The analysis for those who ask while the stage rests.
    view: OnceLock<Box<Self>>,
    pub changed: SupportChanges,
    /// Bodies whose verdict is not what was last said of them, and for how long.
    watched: Vec<(u32, DwellTime)>,
    said: Vec<bool>,
    pub supported_count: u32,
    pub events: Vec<SupportChange>,
}

impl SupportState {
    fn new(slots: usize, by_thrust: bool) -> Self {
        let said = vec![false; slots];
        Self { by_thrust, changed: SupportChanges::ALL, said, ..Self::default() }
    }

    /// Bodies that were said to be supported, and those whose verdict is watched: what a snapshot keeps.
    pub(super) fn said(&self) -> (Vec<u32>, Vec<(u32, DwellTime)>) {
        let supported = (0..self.said.len() as u32).filter(|&body| self.said[body as usize]);
        (supported.collect(), self.watched.clone())
    }

    /// Starts anew under another gravity; what was said of bodies stays.
    fn turn_to(&mut self, gravity: Vec3) {
        self.gravity = gravity;
        let frame = PairFrame::new(gravity);
        if frame == self.frame {
            return;
        }
        self.frame = frame;
        self.records.iter_mut().for_each(|record| record.clear(&mut self.graph));
        self.graph.clear();
        self.thrust.clear();
        self.begin_anew();
        self.watched
            .extend((0..self.said.len() as u32).filter(|&body| self.said[body as usize]).map(|body| (body, DwellTime::NONE)));
    }

    /// Looks at everything in the next update.
    fn begin_anew(&mut self) {
        self.rest.rests = false;
        self.changed = SupportChanges::ALL;
    }

    /// Does nothing from now on.
    fn rest(&mut self) {
        self.records.clear();
        self.graph.clear();
        self.pressed.clear();
        self.came_to_rest.clear();
        self.rest.rests = true;
    }

    fn forget_body(&mut self, index: u32) {
        let Some(node) = self.graph.node(index) else { return };
        // A pair has a link for each of its manifolds, and forgetting it removes them all.
        let mut pairs: Vec<u32> = node.below.iter().chain(&node.above).map(|&link| self.graph.link(link).pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.into_iter().for_each(|pair| self.forget_pair(pair));
        self.graph.set_kind(index, NodeKind::Absent);
        self.thrust.forget_body(index);
        if std::mem::take(&mut self.said[index as usize]) {
            self.supported_count -= 1;
        }
    }

    fn forget_pair(&mut self, slot: u32) {
        self.records[slot as usize].clear(&mut self.graph);
    }

    /// Follows pairs that have gone to other slots.
    pub(super) fn move_pairs(&mut self, places: &[u32]) {
        let place = |slot: &mut u32| *slot = places[*slot as usize];
        self.came_to_rest.iter_mut().for_each(place);
        if !self.records.is_empty() {
            self.records.resize_with(places.len(), Record::default);
            put_in_places(&mut self.records, places);
        }
        self.graph.name_pairs(|pair| places[pair as usize]);
        self.view.take();
    }

    /// Makes the links of a pair anew if they are not what they were, and says what there is to remember of it.
    fn sync_pair(&mut self, site: &PairView, frame: &PairFrame) -> Word {
        let Self { records, graph, signs, .. } = self;
        if records.len() <= site.slot as usize {
            records.resize_with(site.slot as usize + 1, Record::default);
        }
        let record = &mut records[site.slot as usize];
        let pair = site.pair;
        if pair.manifolds.is_empty() && !record.has_links {
            return Word::Nothing;
        }
        self.looked_at += 1;
        let mut is_same = record.key == Some(pair.key) && record.version == pair.version;
        if record.manifolds.len() != pair.manifolds.len() {
            let gone = record.manifolds.drain(pair.manifolds.len().min(record.manifolds.len())..);
            gone.filter_map(|seen| seen.link).for_each(|link| graph.remove(link));
            record.manifolds.resize(pair.manifolds.len(), Seen::NOTHING);
        }
        for (manifold, seen) in pair.manifolds.iter().zip(&mut record.manifolds) {
            let now = site.told_state(&manifold, seen.holds);
            is_same &= now == (seen.points, seen.holds);
            (seen.points, seen.holds) = now;
        }
        record.bodies = [site.shapes.0.body, site.shapes.1.body];
        let rise = Some(pair.told.rise()).filter(|_| pair.is_told());
        let (a, b) = pair.key.shapes();
        let turned = |shape: u32| signs.get(shape as usize).is_some_and(|signs| signs & TURNED != 0);
        if is_same && !turned(a) && !turned(b) {
            return record.word(rise);
        }
        (record.key, record.version) = (Some(pair.key), pair.version);
        for (manifold, seen) in pair.manifolds.iter().zip(&mut record.manifolds) {
            let link = if seen.points == 0 { None } else { site.link(&manifold, seen.points, seen.holds, frame) };
            seen.link = match (seen.link, link) {
                (None, link) => link.map(|link| graph.insert(link)),
                (Some(number), Some(link)) => Some(graph.replace(number, link)),
                (Some(number), None) => {
                    graph.remove(number);
                    None
                }
            };
        }
        record.has_links = record.manifolds.iter().any(|seen| seen.link.is_some());
        record.word(rise)
    }
}

/// What a body is to the graph.
pub(super) fn kind_of(body: &Body) -> NodeKind {
    match body.kind {
        BodyKind::Static => NodeKind::Ground,
        BodyKind::Kinematic if body.is_mover() => NodeKind::Moving,
        BodyKind::Kinematic => NodeKind::Ground,
        BodyKind::Dynamic if body.quarantined => NodeKind::Absent,
        BodyKind::Dynamic => NodeKind::Body,
    }
}

impl World {
    /// Keeps the support analysis up after each step from now on, or no longer; see [`support`](Self::support).
    pub fn set_support(&mut self, on: bool) {
        if on == self.support.is_some() {
            return;
        }
        self.def.support = on;
        self.collision.pairs.follow_releases(on);
        self.support = on.then(|| Box::new(SupportState::new(self.bodies.slot_count(), self.def.support_by_thrust)));
        self.judge_support();
    }

    /// Makes the analysis anew after a restore, with what was said of bodies before.
    pub(super) fn restart_support(&mut self, said: &[u32], watched: Vec<(u32, DwellTime)>) {
        let on = self.def.support;
        (self.def.support, self.support) = (false, None);
        self.set_support(on);
        if let Some(state) = &mut self.support {
            state.events.clear();
            state.said.fill(false);
            for &body in said {
                if let Some(is_said) = state.said.get_mut(body as usize) {
                    *is_said = true;
                }
            }
            state.supported_count = state.said.iter().filter(|&&is_said| is_said).count() as u32;
            state.watched = watched;
            state.watched.retain(|&(body, _)| (body as usize) < state.said.len());
        }
    }

    /// Brings the support analysis up to date with the step.
    pub(super) fn judge_support(&mut self) {
        let Some(mut state) = self.support.take() else { return };
        self.collision.pairs.settle();
        self.forget_released(&mut state);
        state.events.clear();
        state.view.take();
        if state.gravity != self.def.gravity || state.frame.is_none() {
            state.turn_to(self.def.gravity);
        }
        if state.changed.joints {
            state.rest.has_anchors = self.has_anchors();
        }
        if state.rest.rests && (state.rest.has_landed || state.rest.has_anchors) {
            state.begin_anew();
        }
        if !state.rest.rests {
            self.update_analysis(&mut state);
            self.list_changes(&mut state);
            if !state.graph.has_bases() && !state.rest.has_anchors && !state.rest.leans {
                state.rest();
            }
        }
        if state.rest.rests {
            (state.changed.joints, state.rest.has_landed) = (false, false);
            state.came_to_rest.clear();
        }
        self.support = Some(state);
    }

    fn update_analysis(&mut self, state: &mut SupportState) {
        self.sync_bodies(state);
        let Some(frame) = state.frame else { return };
        let all = state.changed.is_new;
        self.sync_contacts(state);
        self.sync_joints(state);
        state.graph.update();
        if state.by_thrust {
            self.judge_thrust(state, &frame, all);
        }
        state.pressed.clear();
        state.came_to_rest.clear();
    }

    fn sync_joints(&self, state: &mut SupportState) {
        if std::mem::take(&mut state.changed.joints) {
            let (ties, anchors) = self.ties(|_| true);
            state.graph.set_joints(&ties, &anchors);
        }
    }

    /// The analysis of the world as it is.
    fn analysis_anew(&self, gravity: Vec3) -> SupportState {
        let mut state = SupportState::new(self.bodies.slot_count(), false);
        state.turn_to(gravity);
        self.sync_bodies(&mut state);
        if let Some(frame) = state.frame {
            self.sync_all(&mut state, &frame);
            self.sync_joints(&mut state);
            state.graph.update();
        }
        state
    }

    /// Whether a joint that can carry weight holds a body to what needs no support, moving or not.
    fn has_anchors(&self) -> bool {
        let is_base = |side: &Option<u32>| side.is_none_or(|index| !self.bodies[index].is_dynamic());
        self.joints.iter().any(|(_, joint)| joint.bodies.iter().any(is_base) && self.holds_up(joint))
    }

    /// Tells the analysis that bodies or joints were made, changed or destroyed.
    pub(super) fn topology_changed(&mut self) {
        if let Some(state) = &mut self.support {
            state.changed.bodies = true;
            state.changed.joints = true;
            state.view.take();
        }
    }

    /// Tells the analysis that a body is about to be destroyed.
    pub(super) fn forget_support(&mut self, index: u32) {
        if let Some(state) = &mut self.support {
            state.forget_body(index);
        }
        self.topology_changed();
    }

    /// Tells the analysis that the centre of mass of a body has moved in it.
    pub(super) fn center_changed(&mut self, index: u32) {
        if let Some(made_for) = self.support.as_mut().and_then(|state| state.made_for.get_mut(index as usize)) {
            *made_for = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
        }
    }

    fn sync_bodies(&self, state: &mut SupportState) {
        if std::mem::take(&mut state.changed.bodies) {
            let count = self.bodies.slot_count();
            state.made_for.resize(count, Quat::IDENTITY);
            state.said.resize(count, false);
            state.kinematic.clear();
            for index in 0..count as u32 {
                let kind = self.bodies.get(index).map_or(NodeKind::Absent, kind_of);
                if kind == NodeKind::Absent {
                    state.forget_body(index);
                } else {
                    state.graph.set_kind(index, kind);
                }
                if kind != NodeKind::Body {
                    state.thrust.forget_body(index);
                }
                if self.bodies.get(index).is_some_and(|body| body.kind == BodyKind::Kinematic) {
                    state.kinematic.push(index);
                }
            }
        }
        for number in 0..state.kinematic.len() {
            let index = state.kinematic[number];
            let kind = kind_of(&self.bodies[index]);
            if state.graph.node(index).is_some_and(|node| node.kind != kind) {
                state.graph.set_kind(index, kind);
                state.changed.joints = true;
            }
        }
    }

    /// Pairs of dynamic bodies that joints tie together, and bodies that a joint holds to what is at rest, of bodies that `keep`.
    pub(super) fn ties(&self, keep: impl Fn(u32) -> bool) -> (Vec<(u32, u32)>, Vec<u32>) {
        let (mut ties, mut anchors) = (Vec::new(), Vec::new());
        let kind = |side: Option<u32>| side.map_or(NodeKind::Ground, |index| kind_of(&self.bodies[index]));
        for (_, joint) in self.joints.iter() {
            if !joint.bodies.into_iter().flatten().all(&keep) || !self.holds_up(joint) {
                continue;
            }
            match (joint.bodies, joint.bodies.map(kind)) {
                ([Some(a), Some(b)], [NodeKind::Body, NodeKind::Body]) => ties.push((a, b)),
                ([Some(a), _], [NodeKind::Body, NodeKind::Ground]) => anchors.push(a),
                ([_, Some(b)], [NodeKind::Ground, NodeKind::Body]) => anchors.push(b),
                _ => {}
            }
        }
        (ties, anchors)
    }

    /// Whether a joint can carry weight.
    fn holds_up(&self, joint: &Joint) -> bool {
        let is_held = |axis: &Axis| axis.limits.min.is_finite() || axis.limits.max.is_finite() || axis.motor != Motor::Off;
        match &joint.def.kind {
            JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => true,
            JointKind::Distance { limits, spring_length, motor } => {
                limits.max.is_finite() || spring_length.is_some() || *motor != Motor::Off
            }
            JointKind::Prismatic { limits, motor } => {
                let rotation = joint.bodies[0].map_or(Quat::IDENTITY, |index| self.bodies[index].rotation);
                let axis = rotation * (joint.def.frame_a.rotation * Vec3::X);
                let slides_down = axis.dot(self.def.gravity).abs() > 0.5 * self.def.gravity.length();
                !slides_down || is_held(&Axis { limits: *limits, motor: *motor }) || joint.def.friction > 0.0
            }
            JointKind::Generic { linear, .. } => {
                linear.iter().any(is_held) || joint.def.axis_friction[..3].iter().any(|&friction| friction > 0.0)
            }
        }
    }

    fn list_changes(&self, state: &mut SupportState) {
        let SupportState { graph, thrust, watched, said, events, supported_count, frame, .. } = state;
        let has_frame = frame.is_some();
        let is_supported =
            |index: u32| has_frame && (graph.node(index).is_some_and(SupportNode::is_supported) || thrust.braces(index));
        watched.extend(graph.changed().iter().map(|&index| (index, DwellTime::NONE)));
        // Of a body that is watched already, the time stays.
        watched.sort_unstable_by(|(a, a_for), (b, b_for)| a.cmp(b).then(b_for.total_cmp(a_for)));
        watched.dedup_by_key(|&mut (index, _)| index);
        watched.retain_mut(|(index, lasted)| {
            let now = is_supported(*index);
            if now == said[*index as usize] || self.bodies.get(*index).is_none() {
                return false;
            }
            lasted.count(true, self.last.dt);
            if now && !lasted.reaches(GAIN_TIME) {
                return true;
            }
            said[*index as usize] = now;
            *supported_count = supported_count.wrapping_add_signed(if now { 1 } else { -1 });
            let body = self.bodies.handle_of(*index);
            events.push(SupportChange { body, user_word: self.bodies[*index].settings.user_word, supported: now });
            false
        });
    }
}

#[cfg(test)]
mod tests;
