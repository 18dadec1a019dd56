//! Stages that read joint loads, break overloaded joints, and report the pieces.
//!
//! Nothing that the solver computes reaches the records before [`World::store_results`], so a step in which joints break is simply
//! solved again from the same state without them: what a blow has freed meets the rest of the blow by itself. A joint is judged
//! once a step, by what it bears while all of them hold. What is left is judged in the next step, its window holding what it bore
//! in this one: judged at once it would be by contacts of the fragments, that no number of sweeps has worked out yet. Joints beyond
//! the step's budget are *condemned*: they break at the start of the next step.
//!
//! A joint bears a part of the step before it breaks: as much of its load as takes it to its limit. That part, the least among the
//! joints that break in one island together, is given to its two bodies as one that the joint could give them where they are at the
//! step's start ([`World::given_back`]), which keeps momentum and adds no energy that the unbroken body would not have had.

use glam::{DVec3, Quat, Vec3};

use super::World;
use super::union_loads::halfway;
use super::unions::Anchor;
use super::wake::Edited;
use crate::body::{SleepState, within_limit};
use crate::fracture::strain::Judgement;
use crate::fracture::{BreakCause, JointBreak, JointLoad, Piece, Split, Strength};
use crate::id::JointId;
use crate::joint::JointKind;
use crate::joint_record::Joint;
use crate::solve::joint::kinds::{holds_points, is_distance};
use crate::speed_limits::{MAX_ANGULAR_SPEED, MAX_LINEAR_SPEED};

mod query;

/// What the stages keep.
#[derive(Debug, Default)]
pub(super) struct Fracture {
    /// Joints that can break, by slot, unless `stale`.
    limited: Vec<u32>,
    stale: bool,
    /// Joints that are to break in the next step because the host says so, sorted.
    asked: Vec<JointId>,
    /// Joints that break in this round.
    breaking: Vec<Breaking>,
    /// Joints that have broken in this step, with their bodies: seeds of the pieces.
    seeds: Vec<[Option<u32>; 2]>,
    /// Piece of each body in the search for pieces, by slot; zero is none.
    piece_of: Vec<u32>,
}

/// A joint about to break.
#[derive(Debug, Clone, Copy)]
struct Breaking {
    slot: u32,
    load: JointLoad,
    judgement: Judgement,
    cause: BreakCause,
    /// Part of the step's load that it still bears.
    part: f32,
    /// Union or island of its bodies: what breaks at one time.
    island: (Option<u32>, u32),
}

impl Fracture {
    pub(super) fn restored(asked: Vec<JointId>) -> Self {
        Self { stale: true, asked, ..Self::default() }
    }

    /// Says that joints were made or destroyed, or can bear more or less.
    pub(super) fn joints_changed(&mut self) {
        self.stale = true;
    }

    pub(super) fn asked(&self) -> &[JointId] {
        &self.asked
    }

    fn is_asked(&self, joint: JointId) -> bool {
        self.asked.binary_search(&joint).is_ok()
    }
}

impl World {
    /// Breaks what the last step condemned, and wakes what is to break in this one.
    pub(super) fn break_condemned(&mut self) {
        self.find_limited();
        self.fracture.seeds.clear();
        let asked = std::mem::take(&mut self.fracture.asked);
        for &id in &asked {
            let Ok(slot) = self.joints.find(id) else { continue };
            // Where the server broke the joint, its bodies were awake, and nothing but the break has changed them.
            let rests = |body: u32| !self.bodies[body].is_awake() || self.bodies[body].held;
            if self.joints[slot].bodies.into_iter().flatten().any(rests) {
                self.wake_for(Edited::Joint(slot));
            }
        }
        self.fracture.asked = asked;
        let mut broken = 0;
        for number in 0..self.fracture.limited.len() {
            let slot = self.fracture.limited[number];
            let joint = &self.joints[slot];
            let Some(strain) = joint.strain.as_ref().filter(|strain| strain.condemned) else { continue };
            if broken == self.def.fracture.most || !self.may_break(slot) {
                continue;
            }
            let load = JointLoad::default();
            let present = strain.present(&joint.def.strength);
            let (share, limit) = joint.def.strength.share(&present);
            let judgement = Judgement { load: present, share, limit, damage: strain.damage };
            let cause = if strain.damage >= 1.0 { BreakCause::Damage } else { BreakCause::Load };
            self.break_joint(&Breaking { slot, load, judgement, cause, part: 0.0, island: (None, 0) }, 0.0, 0.0);
            broken += 1;
        }
        self.find_limited();
    }

    /// Gives every joint the force and torque that this step's solve found.
    pub(super) fn read_joint_loads(&mut self, dt: f32) {
        self.read_row_loads(dt);
        self.add_bound_loads(dt);
        self.find_union_loads(dt);
    }

    /// Breaks the joints that bear too much, and solves the step again without them.
    pub(super) fn break_overloaded(&mut self, dt: f32) {
        if self.fracture.limited.is_empty() && self.fracture.asked.is_empty() {
            return;
        }
        self.choose_what_breaks(dt);
        if !self.fracture.breaking.is_empty() {
            let breaking = std::mem::take(&mut self.fracture.breaking);
            for joint in &breaking {
                // The islands break each at its own time.
                let borne = breaking.iter().filter(|other| other.island == joint.island).map(|other| other.part);
                self.break_joint(joint, borne.fold(1.0, f32::min), dt);
            }
            self.fracture.breaking = breaking;
            self.find_limited();
            self.form_unions_again();
            self.solve_from_start(dt);
        }
        self.note_strain(dt);
        self.fracture.asked.clear();
    }

    /// Lists the joints that break now, at most as many as the step's budget has left.
    fn choose_what_breaks(&mut self, dt: f32) {
        let mut breaking = std::mem::take(&mut self.fracture.breaking);
        breaking.clear();
        let mut condemned = Vec::new();
        for &slot in &self.fracture.limited {
            let Some((load, judgement)) = self.judge(slot, dt).filter(|(_, judgement)| judgement.breaks()) else { continue };
            if self.may_break(slot) {
                let cause = if judgement.share > 1.0 { BreakCause::Load } else { BreakCause::Damage };
                breaking.push(self.breaking(slot, load, judgement, cause, dt));
            } else {
                condemned.push(slot);
            }
        }
        for &id in &self.fracture.asked {
            let Ok(slot) = self.joints.find(id) else { continue };
            if breaking.iter().all(|other| other.slot != slot) {
                let load = self.step_load(slot);
                let judgement = self.joints[slot].strain.as_ref().map_or_else(
                    || judgement_of(&Strength::UNBREAKABLE, load),
                    |strain| strain.judge(&self.joints[slot].def.strength, &load, dt),
                );
                breaking.push(self.breaking(slot, load, judgement, BreakCause::Applied, dt));
            }
        }
        breaking.sort_unstable_by_key(|joint| joint.slot);
        let room = self.def.fracture.most.saturating_sub(self.report.counts.joints_broken) as usize;
        for late in breaking.drain(room.min(breaking.len())..).filter(|late| late.cause != BreakCause::Applied) {
            condemned.push(late.slot);
        }
        for slot in condemned {
            if let Some(strain) = &mut self.joints[slot].strain {
                strain.condemned = true;
            }
        }
        self.fracture.breaking = breaking;
    }

    fn breaking(&self, slot: u32, load: JointLoad, judgement: Judgement, cause: BreakCause, dt: f32) -> Breaking {
        let joint = &self.joints[slot];
        let part = joint.strain.as_ref().map_or(1.0, |strain| strain.part_borne(&joint.def.strength, &load, dt));
        let member = joint.bodies.into_iter().flatten().find(|&body| self.bodies[body].is_dynamic());
        // What moves as one breaks as one; a union may touch several islands, or none.
        let island = member.map_or((None, 0), |body| match self.unions.number_of(body) {
            Some(union) => (Some(union), 0),
            None => (None, self.islands.groups.island[body as usize]),
        });
        Breaking { slot, load, judgement, cause, part, island }
    }

    /// Whether the joint breaks when it bears too much: by itself, or because the host has asked for it.
    fn may_break(&self, slot: u32) -> bool {
        self.def.fracture.by_load || self.fracture.is_asked(self.joints.handle_of(slot))
    }

    /// What a joint that was solved in this step bears; `None` for one that was not, or cannot break.
    fn judge(&self, slot: u32, dt: f32) -> Option<(JointLoad, Judgement)> {
        let joint = &self.joints[slot];
        let strain = joint.strain.as_ref()?;
        let is_solved = |&body: &u32| {
            let record = &self.bodies[body];
            // What stands like its anchor is not solved, and bears its load all the same.
            let stands = self.unions.of(body).is_some_and(|union| union.anchor != Anchor::Free);
            record.is_dynamic() && (stands || (record.is_mover() && !record.held))
        };
        joint.bodies.iter().flatten().any(is_solved).then(|| {
            let load = self.step_load(slot);
            (load, strain.judge(&joint.def.strength, &load, dt))
        })
    }

    /// The step's load of a joint, in axes of its strength halfway through the step.
    fn step_load(&self, slot: u32) -> JointLoad {
        let joint = &self.joints[slot];
        let turned = joint.bodies[0].filter(|_| !is_distance(&joint.def)).map_or(Quat::IDENTITY, |body| {
            let (now, after) = (self.bodies[body].rotation, self.rotation_after(body));
            // A solve that found no finite state is not stored: the body stays as it was.
            halfway(now, if after.is_finite() { after } else { now }) * now.conjugate()
        });
        self.load_in(slot, turned * self.strength_axes(joint))
    }

    /// Rotation of a body at the end of the solve.
    fn rotation_after(&self, body: u32) -> Quat {
        if let Some(union) = self.unions.moving(body) {
            return self.unions.motion_of(body, &self.motion_after(union)).rotation;
        }
        self.solved_at(body).map_or(self.bodies[body].rotation, |(batch, slot)| batch.motions[slot].rotation)
    }

    /// Takes a joint out, gives its bodies what it has borne of this step, and says so.
    fn break_joint(&mut self, breaking: &Breaking, part: f32, dt: f32) {
        let Breaking { slot, load, judgement, cause, .. } = *breaking;
        let joint = &self.joints[slot];
        let (id, bodies, def) = (self.joints.handle_of(slot), joint.bodies, joint.def);
        let point = self.joint_point(joint, 1);
        let axes = self.strength_axes(joint);
        let (points, force) = self.given_back(joint, axes * load.force);
        self.events.broken.push(JointBreak {
            joint: id,
            user_word: def.user_word,
            bodies: [def.body_a, def.body_b],
            point,
            force: axes * judgement.load.force,
            torque: axes * judgement.load.torque,
            share: judgement.share,
            limit: judgement.limit,
            cause,
            step: self.report.step,
        });
        self.report.counts.joints_broken += 1;
        let (linear, angular) = (force * (part * dt), axes * load.torque * (part * dt));
        if matches!(def.kind, JointKind::Fixed) {
            self.fracture.seeds.push(bodies);
        }
        // What breaks before the step has velocities that the last one has solved: its jolts are spent.
        let within_step = dt > 0.0;
        if let Some(body) = bodies.into_iter().flatten().find(|&body| within_step && self.bodies[body].is_dynamic()) {
            self.take_back_jolts(body);
        }
        // What stood like its anchor has a mass of its own again once the joint is gone.
        self.remove_joint(slot);
        for ((body, point), sign) in bodies.into_iter().zip(points).zip([-1.0, 1.0]) {
            if let Some(body) = body.filter(|_| part * dt > 0.0) {
                self.push(body, point, linear * sign, angular * sign);
            }
        }
    }

    /// Where on A and on B a joint's load acts at the step's start, and what of the force on B, a mean over the step turned back to its
    /// start, the joint could exert there.
    ///
    /// Rows push both bodies at one point: B's, or halfway between the two where what holds them together gives. A distance joint
    /// pushes along the line between its points, each body at its own. What the line has turned by in the step would be a lever of the
    /// joint's length.
    fn given_back(&self, joint: &Joint, force: Vec3) -> ([DVec3; 2], Vec3) {
        let [a, b] = [0, 1].map(|side| self.joint_point(joint, side));
        if is_distance(&joint.def) {
            // The line does not turn with A.
            let line = (b - a).as_vec3().normalize_or_zero();
            return ([a, b], line * line.dot(joint.force));
        }
        let point = if joint.def.linear.compliance > 0.0 && holds_points(&joint.def.kind) { a + (b - a) * 0.5 } else { b };
        ([point; 2], force)
    }

    /// An impulse (N·s) at a point and one about it (N·m·s).
    fn push(&mut self, body: u32, point: DVec3, linear: Vec3, angular: Vec3) {
        let body = &mut self.bodies[body];
        if !body.is_dynamic() {
            return;
        }
        let lever = (point - body.center).as_vec3();
        let free = crate::body::free_axes(body.settings.locked_axes.translation);
        let linear_velocity = body.linear_velocity + linear * body.inverse_mass() * free;
        let angular_velocity = body.angular_velocity + body.world_inverse_inertia() * (lever.cross(linear) + angular);
        // What a joint of enormous strength has borne may be more than a light body can take up.
        body.linear_velocity = within_limit(linear_velocity, MAX_LINEAR_SPEED);
        body.angular_velocity = within_limit(angular_velocity, MAX_ANGULAR_SPEED);
    }

    /// Notes in every joint that can break what it has borne, and condemns what is past a limit.
    fn note_strain(&mut self, dt: f32) {
        for number in 0..self.fracture.limited.len() {
            let slot = self.fracture.limited[number];
            let Some((load, judgement)) = self.judge(slot, dt) else { continue };
            let joint = &mut self.joints[slot];
            if let Some(strain) = &mut joint.strain {
                strain.note(&joint.def.strength, &load, dt);
                self.report.counts.joints_condemned += u32::from(strain.condemned);
                // What wears out goes on wearing, and a load above a limit has its window to last for.
                let wears = joint.def.strength.damage.is_some_and(|damage| judgement.share > damage.from);
                if wears || joint.def.strength.share(&load).0 > 1.0 {
                    for body in joint.bodies.into_iter().flatten() {
                        if let SleepState::Awake { quiet_for, .. } = &mut self.bodies[body].sleep {
                            *quiet_for = 0.0;
                        }
                    }
                }
            }
        }
    }

    fn find_limited(&mut self) {
        let Self { fracture, joints, .. } = self;
        if std::mem::take(&mut fracture.stale) {
            fracture.limited.clear();
            fracture.limited.extend(joints.iter().filter(|(_, joint)| joint.strain.is_some()).map(|(slot, _)| slot));
        }
    }

    /// Tells which unions have fallen into pieces.
    pub(super) fn report_splits(&mut self) {
        if self.fracture.seeds.is_empty() {
            return;
        }
        let mut fracture = std::mem::take(&mut self.fracture);
        fracture.piece_of.clear();
        fracture.piece_of.resize(self.bodies.slot_count(), 0);
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        for body in fracture.seeds.iter().flatten().flatten().copied() {
            if self.bodies[body].is_dynamic() && fracture.piece_of[body as usize] == 0 {
                pieces.push(self.flood(body, pieces.len() as u32 + 1, &mut fracture.piece_of));
            }
        }
        // Pieces that a broken joint connected were one union.
        let numbers: Vec<u32> = (0..=pieces.len() as u32).collect();
        let mut unions = crate::island::UnionFind::default();
        unions.reset(numbers.len(), &numbers);
        let mut anchored = vec![false; numbers.len()];
        for ends in &fracture.seeds {
            match ends.map(|body| body.map_or(0, |body| fracture.piece_of[body as usize])) {
                [0, piece] | [piece, 0] => anchored[piece as usize] = true,
                [a, b] => unions.union(a, b),
            }
        }
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); numbers.len()];
        for piece in 1..=pieces.len() as u32 {
            let root = unions.find(piece);
            members[root as usize].push(piece);
            let was_anchored = anchored[piece as usize] || self.is_anchored(&pieces[piece as usize - 1]);
            anchored[root as usize] |= was_anchored;
        }
        let mut split: Vec<(u32, bool, Vec<&[u32]>)> = Vec::new();
        for (root, numbers) in members.iter().enumerate() {
            let mut parts: Vec<&[u32]> = numbers.iter().map(|&piece| &pieces[piece as usize - 1][..]).collect();
            let lost_anchor = anchored[root] && parts.iter().any(|part| !self.is_anchored(part));
            if parts.len() > 1 || lost_anchor {
                parts.sort_unstable_by_key(|part| part[0]);
                split.push((parts[0][0], anchored[root], parts));
            }
        }
        split.sort_unstable_by_key(|&(first, ..)| first);
        for (_, was_anchored, parts) in &split {
            self.list_split(*was_anchored, parts);
        }
        fracture.seeds.clear();
        self.fracture = fracture;
    }

    fn list_split(&mut self, anchored: bool, parts: &[&[u32]]) {
        let first_piece = self.events.pieces.len() as u32;
        let all: Vec<u32> = parts.concat();
        for part in parts {
            let first = self.events.piece_bodies.len() as u32;
            self.events.piece_bodies.extend(part.iter().map(|&body| self.bodies.handle_of(body)));
            let GroupMotion { mass, center, linear_velocity, angular_velocity } = self.motion_of(part);
            let still_anchored = self.is_anchored(part);
            self.events.pieces.push(Piece {
                first_body: self.bodies.handle_of(part[0]),
                bodies: (first, self.events.piece_bodies.len() as u32),
                mass,
                center,
                linear_velocity,
                angular_velocity,
                anchored: still_anchored,
                cut_loose: anchored && !still_anchored,
            });
        }
        let GroupMotion { mass, center, linear_velocity, .. } = self.motion_of(&all);
        self.events.splits.push(Split {
            first_body: self.bodies.handle_of(all[0]),
            body_count: all.len() as u32,
            mass,
            center,
            linear_velocity,
            anchored,
            pieces: (first_piece, self.events.pieces.len() as u32),
            step: self.report.step,
        });
    }

    /// The dynamic bodies that fixed joints connect to this one, by slot; each is marked with `number`.
    fn flood(&self, from: u32, number: u32, marks: &mut [u32]) -> Vec<u32> {
        let mut members = vec![from];
        marks[from as usize] = number;
        let mut next = 0;
        while let Some(&body) = members.get(next) {
            next += 1;
            for other in self.welds_of(body).flat_map(|joint| joint.bodies).flatten() {
                if self.bodies[other].is_dynamic() && marks[other as usize] == 0 {
                    marks[other as usize] = number;
                    members.push(other);
                }
            }
        }
        members.sort_unstable();
        members
    }

    /// The fixed joints of a body.
    fn welds_of(&self, body: u32) -> impl Iterator<Item = &Joint> {
        let slots = self.bodies[body].joints.iter().filter_map(|&id| self.joints.find(id).ok());
        slots.map(|slot| &self.joints[slot]).filter(|joint| matches!(joint.def.kind, JointKind::Fixed))
    }

    /// Whether a fixed joint ties one of these bodies to the world, or to a body that is not dynamic.
    fn is_anchored(&self, members: &[u32]) -> bool {
        let fixed = |end: Option<u32>| end.is_none_or(|body| !self.bodies[body].is_dynamic());
        members.iter().any(|&body| self.welds_of(body).any(|joint| joint.bodies.into_iter().any(fixed)))
    }

    /// The motion of a set of bodies as that of one rigid body.
    fn motion_of(&self, members: &[u32]) -> GroupMotion {
        use glam::DMat3;
        let mut mass = 0.0_f64;
        let (mut first_moment, mut momentum) = (DVec3::ZERO, DVec3::ZERO);
        let origin = self.bodies[members[0]].center;
        let weighed = || members.iter().filter_map(|&body| Some((&self.bodies[body], self.bodies[body].mass.as_ref()?)));
        for (body, own) in weighed() {
            let own = f64::from(own.mass);
            mass += own;
            first_moment += (body.center - origin) * own;
            momentum += body.linear_velocity.as_dvec3() * own;
        }
        let (center, velocity) = (first_moment / mass, momentum / mass);
        let (mut inertia, mut spin) = (DMat3::ZERO, DVec3::ZERO);
        for (body, own) in weighed() {
            let lever = body.center - origin - center;
            let axes = DMat3::from_quat((body.rotation.as_dquat() * own.inertia_frame.as_dquat()).normalize());
            let local = axes * DMat3::from_diagonal(own.principal_inertia.as_dvec3()) * axes.transpose();
            let own = f64::from(own.mass);
            let around = DMat3::from_cols(lever * lever.x, lever * lever.y, lever * lever.z);
            inertia += local + (DMat3::IDENTITY * lever.length_squared() - around) * own;
            spin += local * body.angular_velocity.as_dvec3() + lever.cross((body.linear_velocity.as_dvec3() - velocity) * own);
        }
        GroupMotion {
            mass: mass as f32,
            center: origin + center,
            linear_velocity: velocity.as_vec3(),
            angular_velocity: (inertia.inverse() * spin).as_vec3(),
        }
    }
}

/// Mass (kg), centre (m) and velocities (m/s, rad/s) of a set of bodies.
struct GroupMotion {
    mass: f32,
    center: DVec3,
    linear_velocity: Vec3,
    angular_velocity: Vec3,
}

fn judgement_of(strength: &Strength, load: JointLoad) -> Judgement {
    let (share, limit) = strength.share(&load);
    Judgement { load, share, limit, damage: 0.0 }
}
