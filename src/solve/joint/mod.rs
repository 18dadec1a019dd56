//! Joint rows of a batch: built once a substep at predicted poses, swept with the contacts, read out at the end.
//!
//! **Where the Jacobian is taken.** At the pose of the substep's start, impulses act at one point of both bodies, so angular
//! momentum is kept to rounding and energy does not drift (this is SHAKE, Ryckaert et al. 1977). But tension then acts as an
//! explicit transverse spring and becomes unstable once κ = h² T r / I passes about one: a 1 kg link under 10 t has κ ≈ 50. At
//! the predicted pose the same spring is implicit: stable at any tension, at the price of some damping. Each joint blends
//! between the two by its own κ.

use glam::{DQuat, DVec3, Mat3, Vec3};

mod distance;
mod fixed;
mod generic;
pub(crate) mod geometry;
mod hinge;
pub(crate) mod kinds;
mod prismatic;
pub(crate) mod rows;
mod spherical;
mod sweep;

use geometry::{JointGeometry, Placement, Side};
use kinds::RowSink;
use rows::{Phase, Rate};
use sweep::{BlockRow, ScalarRow};

use super::color::{Coloring, MAX_COLORS};
use super::integrate;
use super::state::{BodyMotion, BodyVelocity};
use crate::id::{JointId, Pool};
use crate::joint::{Joint, JointImpulses, JointKind};

/// Transverse stiffness κ below which the Jacobian is taken at the start, and above which it is taken at the predicted pose.
pub(super) const IMPLICIT_RANGE: (f32, f32) = (0.5, 2.0);

/// Passes over the rows of a joint that has scalar ones: they are solved one by one, and see each other only so.
const SCALAR_PASSES: usize = 3;

/// Greatest change of angular velocity, over the sum of both bodies', by which angular momentum is given back.
const MOMENTUM_RETURN_LIMIT: f32 = 0.2;

/// Where a body is: its displacement since the start of the step (m) and its rotation.
pub(crate) type Stance = (DVec3, DQuat);

/// One joint as its batch holds it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointEntry {
    /// Slot in the world's pool.
    pub joint: u32,
    pub a: u32,
    pub b: u32,
    /// From A's origin to B's at the start of the step (m); the origin is the centre of mass, or the joint point of a fixed side.
    pub offset: DVec3,
    /// Joint point from the origin, in the body's frame (m).
    pub local_lever: [DVec3; 2],
    /// Joint frame in the body's frame.
    pub local_frame: [DQuat; 2],
    pub impulses: JointImpulses,
    /// Sums over the substeps of the impulses on B (N·s, N·m·s).
    pub linear_sum: Vec3,
    pub angular_sum: Vec3,
    /// Of the last substep, if a direct solve took it.
    pub acted: [Vec3; 2],
    /// Scalar rows that ended a substep with a positive multiplier, as bits.
    pub pressed: u32,
}

/// Rows of one joint in this substep.
#[derive(Debug, Clone, Copy)]
struct JointRows {
    a: u32,
    b: u32,
    point: Option<BlockRow>,
    direction: Option<BlockRow>,
    /// Range of its scalar rows.
    scalars: (u32, u32),
}

impl JointRows {
    fn scalars<'a>(&self, all: &'a mut [ScalarRow]) -> &'a mut [ScalarRow] {
        &mut all[self.scalars.0 as usize..self.scalars.1 as usize]
    }

    fn passes(&self) -> usize {
        if self.scalars.0 == self.scalars.1 { 1 } else { SCALAR_PASSES }
    }

    fn sweep(&mut self, all: &mut [ScalarRow], velocities: &mut [BodyVelocity]) {
        let (mut a, mut b) = (velocities[self.a as usize], velocities[self.b as usize]);
        if let Some(row) = &mut self.direction {
            row.solve_direction(&mut a, &mut b);
        }
        for _ in 0..self.passes() {
            for row in self.scalars(all) {
                row.solve(&mut a, &mut b);
            }
            if let Some(row) = &mut self.point {
                row.solve_point(&mut a, &mut b);
            }
        }
        velocities[self.a as usize] = a;
        velocities[self.b as usize] = b;
    }

    fn sweep_backwards(&mut self, all: &mut [ScalarRow], velocities: &mut [BodyVelocity]) {
        let (mut a, mut b) = (velocities[self.a as usize], velocities[self.b as usize]);
        for _ in 0..self.passes() {
            if let Some(row) = &mut self.point {
                row.solve_point(&mut a, &mut b);
            }
            for row in self.scalars(all).iter_mut().rev() {
                row.solve(&mut a, &mut b);
            }
        }
        if let Some(row) = &mut self.direction {
            row.solve_direction(&mut a, &mut b);
        }
        velocities[self.a as usize] = a;
        velocities[self.b as usize] = b;
    }
}

/// All joints of a batch, in colour order.
#[derive(Debug, Default)]
pub(crate) struct BatchJoints {
    pub entries: Vec<JointEntry>,
    rows: Vec<JointRows>,
    scalars: Vec<ScalarRow>,
    /// What the joint at hand asks in scalar rows.
    asked: Vec<rows::ScalarRow>,
    /// Where each jointed body will be at the end of the substep, as predicted when rows were last built.
    pub predicted: Vec<Stance>,
    keys: Vec<(u32, u32)>,
    sorted: Vec<JointEntry>,
}

impl BatchJoints {
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
    }

    /// Puts the joints in the order of their colours; joints of one colour share no moving body.
    pub(crate) fn sort_by_color(&mut self, coloring: &mut Coloring, motions: &[BodyMotion]) {
        coloring.reset(motions.len());
        self.keys.clear();
        for (index, entry) in self.entries.iter().enumerate() {
            let end = |slot: u32| (slot, motions[slot as usize].is_dynamic());
            let color = coloring.assign(end(entry.a), end(entry.b)).unwrap_or(MAX_COLORS as u32);
            self.keys.push((color, index as u32));
        }
        self.keys.sort_unstable();
        self.sorted.clear();
        self.sorted.extend(self.keys.iter().map(|&(_, index)| self.entries[index as usize]));
        std::mem::swap(&mut self.entries, &mut self.sorted);
    }

    /// Builds this substep's rows at the poses predicted from the velocities of now; multipliers go on from where they are.
    ///
    /// Done again before the last sweep, so that the rows hold to second order at the poses that the substep ends in: what the
    /// position rows would have to mend costs angular momentum.
    pub(crate) fn prepare(&mut self, joints: &Pool<Joint, JointId>, velocities: &[BodyVelocity], motions: &[BodyMotion], h: f32) {
        self.rows.clear();
        self.scalars.clear();
        if self.entries.is_empty() {
            return;
        }
        self.predicted.clear();
        self.predicted.extend(velocities.iter().zip(motions).map(|(velocity, motion)| {
            if motion.jointed { stance(integrate::predict(velocity, motion, h)) } else { motion.stance() }
        }));
        for entry in &self.entries {
            let geometry = entry.geometry(velocities, motions, &self.predicted, h);
            let first = self.scalars.len() as u32;
            let bodies = [&velocities[entry.a as usize], &velocities[entry.b as usize]];
            self.asked.clear();
            let mut sink = RowSink {
                rates: bodies.map(Rate::of),
                geometry: &geometry,
                def: &joints[entry.joint].def,
                impulses: &entry.impulses,
                phase: Phase::Velocity { h: f64::from(h) },
                point: None,
                direction: None,
                scalars: &mut self.asked,
            };
            kinds::add_rows(&mut sink);
            let point = sink.point.map(|row| BlockRow::point(&row, bodies));
            let direction = sink.direction.map(|row| BlockRow::direction(&row, bodies));
            self.scalars.extend(self.asked.iter().map(|row| ScalarRow::new(row, bodies)));
            self.rows.push(JointRows { a: entry.a, b: entry.b, point, direction, scalars: (first, self.scalars.len() as u32) });
        }
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        for rows in &self.rows {
            let (mut a, mut b) = (velocities[rows.a as usize], velocities[rows.b as usize]);
            if let Some(row) = &rows.direction {
                a.apply(Vec3::ZERO, -row.impulse);
                b.apply(Vec3::ZERO, row.impulse);
            }
            for row in &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize] {
                row.push(row.impulse, &mut a, &mut b);
            }
            if let Some(row) = &rows.point {
                a.apply(-row.impulse, -row.lever_a.cross(row.impulse));
                b.apply(row.impulse, row.lever_b.cross(row.impulse));
            }
            velocities[rows.a as usize] = a;
            velocities[rows.b as usize] = b;
        }
    }

    /// One sweep over all joints: directions, coordinates, then points; backwards, all in the opposite order.
    ///
    /// Sweeps to and fro are symmetric, which carried multipliers need: with r the residual of a substep, μ = A λ what is carried
    /// and g an eigenvalue of the error that the sweeps leave, r' = g (r + μ), μ' = g μ − (1 − g) r grows by |z| a substep, z² −
    /// 2 g z + g = 0. For g in 0…1, as a symmetric sweep has it, |z| = √g < 1; sweeps in one direction have complex g, |z| may
    /// pass 1, and a tree of fixed joints tears itself apart.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity], backwards: bool) {
        if backwards {
            self.rows.iter_mut().rev().for_each(|rows| rows.sweep_backwards(&mut self.scalars, velocities));
        } else {
            self.rows.iter_mut().for_each(|rows| rows.sweep(&mut self.scalars, velocities));
        }
    }

    /// Adds the substep's multipliers to the joints' loads, and notes which stops press.
    pub(crate) fn add_loads(&mut self) {
        for (entry, rows) in self.entries.iter_mut().zip(&self.rows) {
            let (mut linear, mut angular) = (Vec3::ZERO, Vec3::ZERO);
            if let Some(row) = &rows.point {
                linear += row.impulse;
            }
            if let Some(row) = &rows.direction {
                angular += row.impulse;
            }
            let lever_b = rows.point.as_ref().map(|row| row.lever_b);
            for row in &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize] {
                linear += row.linear * row.impulse;
                let about_point = row.angular_b - lever_b.map_or(row.angular_b, |lever| lever.cross(row.linear));
                angular += about_point * row.impulse;
                entry.pressed |= u32::from(row.impulse > 0.0) << row.id;
            }
            entry.linear_sum += linear;
            entry.angular_sum += angular;
        }
    }

    /// Keeps the multipliers for rows that are built anew.
    pub(crate) fn keep_impulses(&mut self) {
        for (entry, rows) in self.entries.iter_mut().zip(&self.rows) {
            let mut kept = JointImpulses::ZERO;
            kept.point = rows.point.as_ref().map_or(Vec3::ZERO, |row| row.impulse);
            kept.angular = rows.direction.as_ref().map_or(Vec3::ZERO, |row| row.impulse);
            for row in &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize] {
                kept.scalar[row.id as usize] = row.impulse;
            }
            entry.impulses = kept;
        }
    }

    /// One sweep of position rows, joint by joint at the poses of now: rigid errors are taken out, angular momentum is kept.
    pub(crate) fn project(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        h: f32,
    ) {
        for entry in &self.entries {
            let now = |slot: u32| motions[slot as usize].stance();
            let placement = entry.placement(now(entry.a), now(entry.b));
            let [mut a, mut b] = [entry.a, entry.b].map(|slot| velocities[slot as usize].at_rest());
            self.asked.clear();
            let mut sink = RowSink {
                rates: [Rate::of(&a), Rate::of(&b)],
                geometry: &JointGeometry::at(placement),
                def: &joints[entry.joint].def,
                impulses: &JointImpulses::ZERO,
                phase: Phase::Position { most: rows::MAX_RECOVERY_SPEED * f64::from(h) },
                point: None,
                direction: None,
                scalars: &mut self.asked,
            };
            kinds::add_rows(&mut sink);
            let (point, direction) = (sink.point, sink.direction);
            if let Some(row) = direction {
                BlockRow::direction(&row, [&a, &b]).solve_direction(&mut a, &mut b);
            }
            for row in &self.asked {
                ScalarRow::new(row, [&a, &b]).solve(&mut a, &mut b);
            }
            if let Some(row) = point {
                BlockRow::point(&row, [&a, &b]).solve_point(&mut a, &mut b);
            }
            keep_angular_momentum(velocities, motions, [(entry.a as usize, &a), (entry.b as usize, &b)]);
            motions[entry.a as usize].displace(a.linear, a.angular);
            motions[entry.b as usize].displace(b.linear, b.angular);
        }
    }
}

/// Gives a pair of bodies back the angular momentum that moving them by position rows would take.
///
/// A displacement δ of a body moving at v changes x × m v by δ × m v, and a rotation θ changes I ω by θ × I ω − I (θ × ω). The two
/// bodies take the sum back as one more rotation together, where it is small beside what they have: a joint far open is no
/// measure of momentum.
fn keep_angular_momentum(velocities: &mut [BodyVelocity], motions: &[BodyMotion], pushes: [(usize, &BodyVelocity); 2]) {
    let moves = |slot: usize| motions[slot].is_dynamic() && velocities[slot].inverse_mass.min_element() > 0.0;
    if !pushes.iter().all(|&(slot, _)| moves(slot)) {
        return;
    }
    let (mut lost, mut inertia, mut spin) = (Vec3::ZERO, Mat3::ZERO, 0.0);
    for (slot, push) in pushes {
        let body = &velocities[slot];
        let own = body.inverse_inertia.to_mat3().inverse();
        lost += (push.linear / body.inverse_mass).cross(body.linear);
        lost += push.angular.cross(own * body.angular) - own * push.angular.cross(body.angular);
        inertia += own;
        spin += body.angular.length();
    }
    let change = inertia.inverse() * lost;
    if change.is_finite() && change.length() <= MOMENTUM_RETURN_LIMIT * spin {
        for (slot, _) in pushes {
            velocities[slot].angular -= change;
        }
    }
}

/// A stance in the precision that joint rows are formed in.
fn stance((displacement, rotation): (Vec3, glam::Quat)) -> Stance {
    (displacement.as_dvec3(), rotation.as_dquat().normalize())
}

impl BodyMotion {
    /// Where the body is, for joint rows.
    pub(crate) fn stance(&self) -> Stance {
        stance((self.displacement, self.rotation))
    }
}

impl JointEntry {
    pub(crate) fn placement(&self, a: Stance, b: Stance) -> Placement {
        let side =
            |rotation: DQuat, i: usize| Side { lever: rotation * self.local_lever[i], frame: rotation * self.local_frame[i] };
        let (side_a, side_b) = (side(a.1, 0), side(b.1, 1));
        Placement { a: side_a, b: side_b, gap: self.offset + (b.0 - a.0) + (side_b.lever - side_a.lever) }
    }

    /// The joint points alone; frames are left out.
    pub(crate) fn points(&self, a: &Stance, b: &Stance) -> Placement {
        let side = |rotation: DQuat, i: usize| Side { lever: rotation * self.local_lever[i], frame: DQuat::IDENTITY };
        let (side_a, side_b) = (side(a.1, 0), side(b.1, 1));
        Placement { a: side_a, b: side_b, gap: self.offset + (b.0 - a.0) + (side_b.lever - side_a.lever) }
    }

    fn geometry(&self, velocities: &[BodyVelocity], motions: &[BodyMotion], predicted: &[Stance], h: f32) -> JointGeometry {
        let (a, b) = (self.a as usize, self.b as usize);
        let now = |slot: usize| motions[slot].stance();
        let start = self.placement(now(a), now(b));
        let end = self.placement(predicted[a], predicted[b]);
        let stiffness = h
            * self.impulses.point.length()
            * (turning_ease(&velocities[a], start.a.lever.as_vec3()) + turning_ease(&velocities[b], start.b.lever.as_vec3()));
        let implicit = ((stiffness - IMPLICIT_RANGE.0) / (IMPLICIT_RANGE.1 - IMPLICIT_RANGE.0)).clamp(0.0, 1.0);
        let gradient = if implicit == 0.0 {
            start
        } else if implicit == 1.0 {
            end
        } else {
            let blend = |slot: usize| {
                let (from, to) = (now(slot), predicted[slot]);
                (from.0.lerp(to.0, f64::from(implicit)), from.1.lerp(to.1, f64::from(implicit)))
            };
            self.placement(blend(a), blend(b))
        };
        JointGeometry { start, predicted: end, gradient }
    }
}

/// How readily a transverse force at `lever` turns a body, over the lever's length: |r| tr(I⁻¹ across r) (1/(kg·m)).
pub(super) fn turning_ease(body: &BodyVelocity, lever: Vec3) -> f32 {
    let length = lever.length();
    if length == 0.0 {
        return 0.0;
    }
    let axis = lever / length;
    let [xx, yy, zz, ..] = *body.inverse_inertia.entries();
    length * (xx + yy + zz - axis.dot(body.inverse_inertia.mul(axis)))
}

/// Worst distance between joint points beyond what the joints allow (m).
pub(crate) fn worst_gap<'a>(
    entries: impl Iterator<Item = &'a JointEntry>,
    joints: &Pool<Joint, JointId>,
    motions: &[BodyMotion],
) -> f32 {
    let gap = |entry: &JointEntry| {
        let (a, b) = (motions[entry.a as usize].stance(), motions[entry.b as usize].stance());
        let kind = &joints[entry.joint].def.kind;
        // Frames cost more than points, and few kinds allow a gap that is seen in them.
        let turns = matches!(kind, JointKind::Prismatic { .. } | JointKind::Generic { .. });
        gap_of(kind, &if turns { entry.placement(a, b) } else { entry.points(&a, &b) })
    };
    entries.map(gap).fold(0.0, f64::max) as f32
}

/// Distance between the joint points beyond what the kind of joint allows (m).
pub(crate) fn gap_of(kind: &JointKind, placement: &Placement) -> f64 {
    let beyond = |value: f64, min: f32, max: f32| (f64::from(min) - value).max(value - f64::from(max)).max(0.0);
    match kind {
        JointKind::Fixed | JointKind::Hinge { .. } | JointKind::Spherical { .. } => placement.gap.length(),
        JointKind::Distance { limits, .. } => beyond(placement.gap.length(), limits.min, limits.max),
        JointKind::Prismatic { limits, .. } => {
            let gap = placement.local_gap();
            DVec3::new(beyond(gap.x, limits.min, limits.max), gap.y, gap.z).length()
        }
        JointKind::Generic { linear, .. } => {
            let gap = placement.local_gap();
            DVec3::from_array(std::array::from_fn(|i| beyond(gap[i], linear[i].limits.min, linear[i].limits.max))).length()
        }
    }
}

/// Coordinate of the free axis of a joint (rad or m) and its gradient, for read-out.
pub(crate) fn coordinate(kind: &JointKind, placement: &Placement) -> (f64, DVec3) {
    let axis = placement.a.frame * DVec3::X;
    match kind {
        JointKind::Hinge { .. } => (placement.twist(), axis),
        JointKind::Prismatic { .. } => (placement.local_gap().x, axis),
        JointKind::Distance { .. } => (placement.gap.length(), placement.gap.normalize_or(axis)),
        _ => (0.0, DVec3::ZERO),
    }
}

/// Both joint frames of a joint outside a step.
pub(crate) fn placement_of(offset: DVec3, levers: [DVec3; 2], frames: [DQuat; 2]) -> Placement {
    let [a, b] = [0, 1].map(|i| Side { lever: levers[i], frame: frames[i] });
    Placement { a, b, gap: offset + (levers[1] - levers[0]) }
}
