//! Joints that are swept one by one, with any rows: built in `f64`, swept in `f32`.

use std::ops::Range;

use glam::{DVec3, Mat3, Vec3};

use super::angles;
use super::body_response::{BodyResponse, MotorAnswers};
use super::driven::{self, DrivenParts};
use super::geometry::{JointGeometry, Placement};
use super::kinds;
use super::locks::{self, Freedom};
use super::rebound;
use super::row_sink::RowSink;
use super::rows::{self, Phase, Rate, RowRates};
use super::sweep::{self, BlockRow, ScalarRow};
use super::{JointEntry, MOMENTUM_RETURN_LIMIT, MovingBodies};
use crate::id::{JointId, Pool};
use crate::joint_rebounds::Rebounds;
use crate::joint_record::{Joint, JointImpulses};
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Passes over the rows of a joint that has scalar ones: they are solved one by one, and see each other only so.
const SCALAR_PASSES: usize = 3;

/// Rows of one joint in this substep.
#[derive(Debug, Clone, Copy)]
struct SingleJointRows {
    /// The joint among the batch's.
    entry: usize,
    a: u32,
    b: u32,
    point: Option<BlockRow>,
    direction: Option<BlockRow>,
    /// Range of its scalar rows, and whether they lean on the points.
    scalars: (u32, u32),
    leans: bool,
}

impl SingleJointRows {
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
            if self.leans {
                sweep::solve_leaning(self.scalars(all), &mut self.point, &mut a, &mut b, false);
                continue;
            }
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
            if self.leans {
                sweep::solve_leaning(self.scalars(all), &mut self.point, &mut a, &mut b, true);
                continue;
            }
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

impl JointEntry {
    /// What the host moves of the joint, which is placed like this, in a substep so far from the end of the step (s).
    fn driven<'a>(
        &self,
        joint: &'a Joint,
        motions: &[BodyMotion],
        placement: &Placement,
        left: [f64; 2],
    ) -> Option<DrivenParts<'a>> {
        let drive = joint.drive()?;
        let local_poses = [self.a, self.b].map(|slot| motions[slot as usize].stance());
        Some(DrivenParts::new(drive, local_poses.each_ref(), placement, left))
    }
}

/// Turn of a substep up to which the nearest of all angles that a rotation allows is the right one, whatever it was before (rad).
const SURE_TURN: f64 = 1.0;

/// The joints of a batch that are swept one by one, by their places among its entries.
#[derive(Debug, Default)]
pub(super) struct Singles {
    numbers: Vec<usize>,
    /// By what the second body of each has turned against the first in the step, as its angles were last followed (rad).
    turned: Vec<Vec3>,
    rows: Vec<SingleJointRows>,
    scalars: Vec<ScalarRow>,
    /// Whether any of these rows is that of a motor.
    any_motors: bool,
    /// What the joint at hand asks in scalar rows.
    asked: Vec<rows::ScalarRow>,
    /// Stops that may be met in the substep, by entry and row, and the speeds at which they are to be left then.
    approaches: Vec<(usize, u8, f32)>,
}

/// Rows as they were.
#[derive(Debug, Default)]
pub(super) struct KeptRows {
    rows: Vec<SingleJointRows>,
    scalars: Vec<ScalarRow>,
}

impl Singles {
    /// Forgets all joints and rows but keeps the memory.
    pub(super) fn clear(&mut self) {
        // All of it: a step without swept joints builds no rows, and would go on with what is left of the step before.
        let Self { numbers, turned, rows, scalars, any_motors, asked, approaches } = self;
        numbers.clear();
        turned.clear();
        rows.clear();
        scalars.clear();
        *any_motors = false;
        asked.clear();
        approaches.clear();
    }

    pub(super) fn add(&mut self, numbers: &[u32]) {
        self.numbers.extend(numbers.iter().map(|&number| number as usize));
        self.turned.resize(self.numbers.len(), Vec3::ZERO);
    }

    pub(super) fn len(&self) -> usize {
        self.numbers.len()
    }

    pub(super) fn entries(&self) -> impl Iterator<Item = usize> {
        self.numbers.iter().copied()
    }

    /// Brings angles that count turns up to where the bodies are now, `left` (s) from the end of the step.
    pub(super) fn follow(
        &mut self,
        entries: &mut [JointEntry],
        joints: &Pool<Joint, JointId>,
        motions: &[BodyMotion],
        left: f32,
    ) {
        for (&number, before) in self.numbers.iter().zip(&mut self.turned) {
            let entry = &mut entries[number];
            if entry.counts_turns {
                let joint = &joints[entry.joint];
                let [a, b] = [entry.a, entry.b].map(|slot| motions[slot as usize].stance());
                let placement = driven::before(entry.placement(a, b), joint.drive(), [&a, &b], f64::from(left));
                let kind = &joint.def.kind;
                let turned = motions[entry.b as usize].turn - motions[entry.a as usize].turn;
                let way = (turned - std::mem::replace(before, turned)).as_dvec3();
                if way.length_squared() > SURE_TURN * SURE_TURN {
                    let moved = angles::rates(kind, &placement, entry.angles, way);
                    entry.angles.iter_mut().zip(moved).for_each(|(angle, moved)| *angle += moved);
                }
                entry.follow(kind, &placement);
            }
        }
    }

    /// Builds the rows of all.
    pub(super) fn prepare(
        &mut self,
        entries: &[JointEntry],
        joints: &Pool<Joint, JointId>,
        &MovingBodies { velocities, motions, predicted_poses }: &MovingBodies<'_>,
        (h, left): (f32, f32),
        again: bool,
    ) {
        let left = [left, left - h].map(f64::from);
        if !again {
            self.approaches.clear();
        }
        self.rows.clear();
        self.scalars.clear();
        self.any_motors = false;
        for &number in &self.numbers {
            let entry = &entries[number];
            let joint = &joints[entry.joint];
            let [start, predicted, gradient] = entry.search((velocities, motions, predicted_poses), h, joint.drive(), left);
            let first = self.scalars.len() as u32;
            let bodies = [&velocities[entry.a as usize], &velocities[entry.b as usize]];
            let driven = entry.driven(joint, motions, &gradient, left);
            let answer = |side: usize| answer_of(bodies[side], &motions[[entry.a, entry.b][side] as usize]);
            let geometry = JointGeometry { start: &start, predicted: &predicted, gradient: &gradient, is_still: false };
            let rates = RowRates { bodies: bodies.map(Rate::of), frames: driven.map(|driven| driven.rates) };
            let velocity = (Phase::Velocity { h: f64::from(h) }, rates);
            let mut sink = RowSink {
                driven,
                impulses: &entry.impulses,
                rebounds: entry.rebounds,
                answers: MotorAnswers { bodies: &answer, in_loop: None },
                left: left[1],
                closing_share: rows::DRIVE_SHARE,
                // What hangs on other joints is not known here: a motor does not set it going faster than sweeps stop it.
                most_speed: if entry.motors.are_chained { rows::MAX_RECOVERY_SPEED } else { f64::INFINITY },
                applied: f64::from(u8::from(again)),
                ..RowSink::new(geometry, &joint.def, velocity, entry.angles, &mut self.asked)
            };
            kinds::add_rows(&mut sink);
            locks::take_out(&mut sink, locks_of(entry, velocities, motions));
            let (rates, point, direction) = (sink.rates, sink.point, sink.direction);
            if entry.restitution > 0.0 && !again {
                let force = |slot: u32| Rate { linear: motions[slot as usize].acceleration.as_dvec3(), angular: DVec3::ZERO };
                let forces = [force(entry.a), force(entry.b)];
                for row in self.asked.iter().filter(|row| row.is_stop() && row.impulse <= 0.0) {
                    let (rate, acceleration) = (row.jacobian.rate(&rates.bodies) + row.driven, row.jacobian.rate(&forces));
                    let distance = (row.bias - row.driven).max(0.0) * f64::from(h);
                    let speed = rebound::speed_after(entry.restitution, distance, rate, acceleration, f64::from(h));
                    self.approaches.push((number, row.id, speed as f32));
                }
            }
            let point = point.map(|row| BlockRow::point(&row, bodies));
            let direction = direction.map(|row| BlockRow::direction(&row, bodies));
            self.scalars.extend(self.asked.iter().map(|row| ScalarRow::new(row, bodies)));
            let scalars = (first, self.scalars.len() as u32);
            let leans = point.is_some() && first != scalars.1 || entry.traits.has_friction;
            if leans {
                sweep::lean(&mut self.scalars[first as usize..], point.as_ref(), bodies);
            }
            self.any_motors |= entry.traits.has_motor;
            self.rows.push(SingleJointRows { entry: number, a: entry.a, b: entry.b, point, direction, scalars, leans });
        }
    }

    /// Applies the carried multipliers.
    pub(super) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        for rows in &self.rows {
            let (mut a, mut b) = (velocities[rows.a as usize], velocities[rows.b as usize]);
            if let Some(row) = &rows.direction {
                a.apply(Vec3::ZERO, -row.impulse);
                b.apply(Vec3::ZERO, row.impulse);
            }
            let scalars = &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize];
            for row in scalars {
                row.push(row.impulse, &mut a, &mut b);
            }
            if let Some(row) = &rows.point {
                let leaning = if rows.leans { scalars.iter().map(ScalarRow::leaning).sum() } else { Vec3::ZERO };
                let impulse = row.impulse + leaning;
                a.apply(-impulse, -row.lever_a.cross(impulse));
                b.apply(impulse, row.lever_b.cross(impulse));
            }
            velocities[rows.a as usize] = a;
            velocities[rows.b as usize] = b;
        }
    }

    /// Slots of the bodies of each joint with a motor.
    pub(super) fn motor_slots(&self, entries: &[JointEntry]) -> impl Iterator<Item = [u32; 2]> {
        let rows = if self.any_motors { &self.rows[..] } else { &[] };
        rows.iter().filter(|rows| entries[rows.entry].traits.has_motor).map(|rows| [rows.a, rows.b])
    }

    /// Has motors do for the rest of the substep what they do now.
    pub(super) fn hold_motors(&mut self, entries: &[JointEntry]) {
        let Self { rows, scalars, .. } = self;
        for rows in rows.iter().filter(|rows| entries[rows.entry].traits.has_motor) {
            let motors = entries[rows.entry].motors.rows;
            rows.scalars(scalars).iter_mut().filter(|row| motors.axis(row.id).is_some()).for_each(ScalarRow::hold);
        }
    }

    /// Keeps all rows as they are.
    pub(super) fn keep(&self, kept: &mut KeptRows) {
        kept.rows.clone_from(&self.rows);
        kept.scalars.clone_from(&self.scalars);
    }

    /// Puts the rows of joints back that are on none of these slots.
    pub(super) fn put_back(&mut self, kept: &KeptRows, slots: &[bool]) {
        let Self { rows, scalars, .. } = self;
        for (rows, kept_rows) in
            rows.iter_mut().zip(&kept.rows).filter(|(rows, _)| !(slots[rows.a as usize] || slots[rows.b as usize]))
        {
            *rows = *kept_rows;
            let own = rows.scalars.0 as usize..rows.scalars.1 as usize;
            scalars[own.clone()].copy_from_slice(&kept.scalars[own]);
        }
    }

    /// One sweep over a range of joints.
    pub(super) fn sweep(&mut self, range: Range<usize>, velocities: &mut [BodyVelocity], backwards: bool) {
        let Self { rows, scalars, .. } = self;
        if backwards {
            rows[range].iter_mut().rev().for_each(|rows| rows.sweep_backwards(scalars, velocities));
        } else {
            rows[range].iter_mut().for_each(|rows| rows.sweep(scalars, velocities));
        }
    }

    /// Sets the multipliers of joints on these slots to nothing.
    pub(super) fn give_up(&mut self, slots: &[bool]) {
        for rows in self.rows.iter_mut().filter(|rows| slots[rows.a as usize] || slots[rows.b as usize]) {
            rows.point.iter_mut().chain(&mut rows.direction).for_each(|row| row.impulse = Vec3::ZERO);
            let scalars = &mut self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize];
            scalars.iter_mut().for_each(|row| row.impulse = 0.0);
        }
    }

    /// Adds the substep's multipliers to the joints' loads, and notes which stops press and which are to be left again.
    pub(super) fn add_loads(&self, entries: &mut [JointEntry]) {
        for rows in &self.rows {
            let entry = &mut entries[rows.entry];
            entry.rebounds = Rebounds::NONE;
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
                if let Some(axis) = entry.motors.rows.axis(row.id) {
                    entry.motors.sums[axis] += row.impulse;
                }
            }
            entry.linear_sum += linear;
            entry.angular_sum += angular;
        }
        for &(number, row, speed) in &self.approaches {
            let entry = &mut entries[number];
            if entry.impulses.scalar[row as usize] > 0.0 {
                entry.rebounds.add(row, speed);
            }
        }
    }

    /// What the motors of each joint do on its bodies, λ J v (J): handed over with the slots of the two.
    pub(super) fn find_work(
        &self,
        entries: &[JointEntry],
        velocities: &[BodyVelocity],
        mut hand_over: impl FnMut([u32; 2], f64),
    ) {
        for rows in &self.rows {
            let entry = &entries[rows.entry];
            let (a, b) = (&velocities[rows.a as usize], &velocities[rows.b as usize]);
            let scalars = &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize];
            let gives = |row: &&ScalarRow| entry.motors.rows.axis(row.id).is_some() || entry.rebounds.of(row.id) > 0.0;
            let motors = scalars.iter().filter(gives);
            let work = motors.map(|row| f64::from(row.impulse) * f64::from(row.rate(a, b))).sum();
            hand_over([rows.a, rows.b], work);
        }
    }

    /// Keeps the multipliers for rows that are built anew.
    pub(super) fn keep_impulses(&self, entries: &mut [JointEntry]) {
        for rows in &self.rows {
            let entry = &mut entries[rows.entry];
            let mut kept = JointImpulses::ZERO;
            kept.point = rows.point.as_ref().map_or(Vec3::ZERO, |row| row.impulse);
            kept.angular = rows.direction.as_ref().map_or(Vec3::ZERO, |row| row.impulse);
            for row in &self.scalars[rows.scalars.0 as usize..rows.scalars.1 as usize] {
                match kept.scalar.get_mut(row.id as usize) {
                    Some(kept) => *kept = row.impulse,
                    None => kept.angular += row.angular_b * row.impulse,
                }
            }
            entry.impulses = kept;
        }
    }

    /// One sweep of position rows, joint by joint at the poses of now: rigid errors are taken out, angular momentum is kept.
    pub(super) fn project(
        &mut self,
        range: Range<usize>,
        entries: &[JointEntry],
        joints: &Pool<Joint, JointId>,
        (velocities, motions): (&mut [BodyVelocity], &mut [BodyMotion]),
        h: f32,
        left: f32,
    ) {
        for &number in &self.numbers[range] {
            let entry = &entries[number];
            let joint = &joints[entry.joint];
            let [stance_a, stance_b] = [entry.a, entry.b].map(|slot| motions[slot as usize].stance());
            let placement = entry.placement(stance_a, stance_b);
            let placement = driven::before(placement, joint.drive(), [&stance_a, &stance_b], f64::from(left));
            let [mut a, mut b] = [entry.a, entry.b].map(|slot| velocities[slot as usize].at_rest());
            let rates = RowRates { bodies: [Rate::of(&a), Rate::of(&b)], frames: None };
            let position = (Phase::Position { most: rows::MAX_RECOVERY_SPEED * f64::from(h) }, rates);
            let mut sink = RowSink {
                driven: entry.driven(joint, motions, &placement, [f64::from(left); 2]),
                ..RowSink::new(JointGeometry::at(&placement), &joint.def, position, entry.angles, &mut self.asked)
            };
            kinds::add_rows(&mut sink);
            locks::take_out(&mut sink, locks_of(entry, velocities, motions));
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

/// Along and about what the rows of a joint move its bodies, where both have locked axes.
pub(super) fn locks_of(entry: &JointEntry, velocities: &[BodyVelocity], motions: &[BodyMotion]) -> Option<[Freedom; 2]> {
    let is_whole = |slot: u32| {
        let motion = &motions[slot as usize];
        motion.is_dynamic()
            && motion.free_rotation() == Vec3::ONE
            && velocities[slot as usize].inverse_mass.cmpgt(Vec3::ZERO).all()
    };
    if is_whole(entry.a) || is_whole(entry.b) {
        return None;
    }
    let of = |slot: u32| match &motions[slot as usize] {
        motion if motion.is_dynamic() => {
            let inverse_mass = velocities[slot as usize].inverse_mass.as_dvec3();
            Freedom::new(inverse_mass, motion.free_rotation().as_dvec3(), motion.inertia.as_dvec3())
        }
        _ => Freedom::NONE,
    };
    Freedom::of_both(of(entry.a), of(entry.b))
}

/// How a body answers to its motor.
pub(super) fn answer_of(velocity: &BodyVelocity, motion: &BodyMotion) -> BodyResponse {
    let inverse_inertia = velocity.inverse_inertia.to_mat3().as_dmat3();
    let linear = if motion.is_dynamic() { motion.acceleration.as_dvec3() } else { DVec3::ZERO };
    let acceleration = Rate { linear, angular: inverse_inertia * motion.torque.as_dvec3() };
    BodyResponse { inverse_mass: velocity.inverse_mass.as_dvec3(), inverse_inertia, acceleration, center: DVec3::ZERO }
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
