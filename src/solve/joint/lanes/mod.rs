//! Joints that hold their points, and all, two or none of their directions: eight of one colour in lanes.
//!
//! The rows are those of [`super::rows`], in `f32` and formed from *differences*: with R a body's rotation now, δR what the
//! substep turns it by, and r a lever, δr = (δR − 1) r is found from the quaternion of δR as 2 v × (w r + v × r), which is exact to
//! rounding of the way itself. So the bias (C* − C₀)/h − J v*, which is of second order in the substep, keeps its digits: at rest
//! it is zero, and a lever of a metre costs none.
//!
//! What does not change within the step is laid out once; levers and errors of now are found once a substep, gradients, effective
//! masses and biases each time that rows are built. Multipliers and their sums stay in the block until the step ends.

mod begin;
mod project;
pub(crate) mod rows;
mod search_direction;
mod sweep;
#[cfg(test)]
mod tests;

use glam::Vec3;

use super::JointEntry;
use crate::joint::{JointKind, Limits, Motor, Softness};
use crate::joint_record::JointImpulses;
use crate::platform::in_lanes;
use crate::solve::contact::{LANES, Lane, Lane3};
use crate::solve::disjoint::Slots;
use crate::solve::integrate::PredictedPose;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// How many directions a joint in lanes holds; joints of one block hold alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Holds {
    Points,
    /// B's joint axis on A's.
    Axis,
    /// All directions.
    Frame,
}

impl Holds {
    /// In their order.
    pub(crate) const ALL: [Self; 3] = [Self::Points, Self::Axis, Self::Frame];

    /// `None` where a joint, of so many rows at most, has rows that are not laid out in lanes; `free` where none of its stops is within
    /// reach.
    pub(crate) fn of(kind: &JointKind, most_rows: u32, free: bool) -> Option<Self> {
        match kind {
            JointKind::Fixed => Some(Self::Frame),
            JointKind::Hinge { .. } if free => Some(Self::Axis),
            JointKind::Spherical { .. } if free => Some(Self::Points),
            JointKind::Hinge { limits, motor } if *limits == Limits::NONE && *motor == Motor::Off => Some(Self::Axis),
            kind if super::kinds::is_plain(kind, most_rows) => Some(Self::Points),
            _ => None,
        }
    }
}

/// Compliance and damping of eight rows in one substep: see [`super::rows`].
#[derive(Debug, Clone, Copy)]
struct GiveLanes {
    /// γ/(1+k).
    gamma: Lane,
    /// 1/(1+k), the share of the bias that acts.
    share: Lane,
    /// The same for the error at the substep's start, over its length (1/s); zero where a row is rigid.
    start: Lane,
    /// 1 where position rows act.
    rigid: Lane,
}

impl GiveLanes {
    const RIGID: Self = Self { gamma: [0.0; LANES], share: [1.0; LANES], start: [0.0; LANES], rigid: [1.0; LANES] };

    fn set(&mut self, l: usize, softness: Softness, h: f32) {
        // Lanes begin so.
        if softness == Softness::RIGID {
            return;
        }
        let k = softness.damping * softness.compliance / h;
        let share = 1.0 / (1.0 + k);
        let rigid = softness.compliance == 0.0;
        self.gamma[l] = softness.compliance / (h * h) * share;
        self.share[l] = share;
        self.start[l] = if rigid { 0.0 } else { share / h };
        self.rigid[l] = f32::from(u8::from(rigid));
    }
}

/// Rows on the points of eight joints; unused lanes act on the world slot and do nothing.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct PointBlock {
    a: [u32; LANES],
    b: [u32; LANES],
    /// Its joints among the batch's, and how many.
    numbers: [u32; LANES],
    count: u32,
    /// Its rows on directions, among the batch's.
    directions: Option<u32>,
    give: GiveLanes,
    /// From A's origin to B's at the start of the step, and joint points from there in the bodies' frames (m).
    offset: Lane3,
    local: [Lane3; 2],
    /// 1 over the sum of the levers' lengths where the points are held without give, else 0 (1/m).
    shortness: Lane,
    /// At the start of the substep: levers, and the gap between the points (m).
    lever: [Lane3; 2],
    gap: Lane3,
    /// From the centres of mass to where the bodies are pushed (m).
    arm: [Lane3; 2],
    /// Inverse of J M⁻¹ Jᵀ + γ.
    mass: [Lane; 6],
    bias: Lane3,
    impulse: Lane3,
    /// Sum over the substeps.
    sum: Lane3,
}

/// Rows on the directions of eight joints.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct DirectionBlock {
    holds: Holds,
    give: GiveLanes,
    /// [`Holds::Axis`]: the joint axes in the bodies' frames. [`Holds::Frame`]: A's frame to B's, in B's, as a quaternion.
    local_axis: [Lane3; 2],
    rest: [Lane; 4],
    /// At the start of the substep: the joint axes, or the rotation from A's frame to B's, in world axes.
    axis: [Lane3; 2],
    relative: [Lane; 4],
    /// C₀, and the angle over the sine in it (rad).
    error: Lane3,
    arc: Lane,
    /// The axis about which the joint turns freely.
    free_axis: Lane3,
    mass: [Lane; 6],
    bias: Lane3,
    impulse: Lane3,
    sum: Lane3,
}

const ZERO: Lane = [0.0; LANES];
const ONE: Lane = [1.0; LANES];
const ZERO3: Lane3 = [ZERO; 3];
const X: Lane3 = [ONE, ZERO, ZERO];

impl PointBlock {
    const EMPTY: Self = Self {
        a: [0; LANES],
        b: [0; LANES],
        numbers: [0; LANES],
        count: 0,
        directions: None,
        give: GiveLanes::RIGID,
        offset: ZERO3,
        local: [ZERO3; 2],
        shortness: ZERO,
        lever: [ZERO3; 2],
        gap: ZERO3,
        arm: [ZERO3; 2],
        mass: [ZERO; 6],
        bias: ZERO3,
        impulse: ZERO3,
        sum: ZERO3,
    };

    /// Its joints among the batch's.
    fn numbers(&self) -> &[u32] {
        &self.numbers[..self.count as usize]
    }

    fn set(&mut self, l: usize, entry: &JointEntry, first: u32, give: Softness, h: f32) {
        (self.a[l], self.b[l]) = (entry.a - first, entry.b - first);
        self.give.set(l, give, h);
        put(&mut self.offset, l, entry.offset.as_vec3());
        for side in [0, 1] {
            put(&mut self.local[side], l, entry.local_lever[side].as_vec3());
        }
        let levers = entry.local_lever[0].length() + entry.local_lever[1].length();
        let is_rigid = give.compliance == 0.0 && levers > 0.0;
        self.shortness[l] = if is_rigid { (1.0 / levers) as f32 } else { 0.0 };
        put(&mut self.impulse, l, entry.impulses.point);
    }
}

impl DirectionBlock {
    const EMPTY: Self = Self {
        holds: Holds::Frame,
        give: GiveLanes::RIGID,
        local_axis: [X; 2],
        rest: [ZERO, ZERO, ZERO, ONE],
        axis: [X; 2],
        relative: [ZERO, ZERO, ZERO, ONE],
        error: ZERO3,
        arc: ONE,
        free_axis: X,
        mass: [ZERO; 6],
        bias: ZERO3,
        impulse: ZERO3,
        sum: ZERO3,
    };

    fn set(&mut self, l: usize, entry: &JointEntry, give: Softness, h: f32) {
        self.give.set(l, give, h);
        let [a, b] = entry.local_frame;
        for (lanes, frame) in self.local_axis.iter_mut().zip([a, b]) {
            put(lanes, l, (frame * glam::DVec3::X).as_vec3());
        }
        let rest = (b * a.conjugate()).as_quat().to_array();
        for (lane, number) in self.rest.iter_mut().zip(rest) {
            lane[l] = number;
        }
        put(&mut self.impulse, l, entry.impulses.angular);
    }
}

fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    [lanes[0][l], lanes[1][l], lanes[2][l]] = v.to_array();
}

fn get(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}

/// Joints of a batch that are swept in lanes: all, or those of a range of slots.
#[derive(Debug, Default)]
pub(crate) struct JointLanes {
    /// The slot that those of its blocks count from, as do those of the arrays that it is given.
    first: u32,
    points: Vec<PointBlock>,
    directions: Vec<DirectionBlock>,
    search: search_direction::JointDirections,
}

impl JointLanes {
    /// Empties it, for joints on slots from `first` on.
    pub(crate) fn clear(&mut self, first: u32) {
        self.first = first;
        self.points.clear();
        self.directions.clear();
    }

    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Lays out joints of one colour that hold alike, each with its number among the batch's joints and the give of its points and of
    /// its directions.
    pub(crate) fn add<'a>(&mut self, joints: impl Iterator<Item = (u32, &'a JointEntry, [Softness; 2])>, holds: Holds, h: f32) {
        for (place, (number, entry, [linear, angular])) in joints.enumerate() {
            let l = place % LANES;
            if l == 0 {
                let mut block = PointBlock::EMPTY;
                if holds != Holds::Points {
                    block.directions = Some(self.directions.len() as u32);
                    self.directions.push(DirectionBlock { holds, ..DirectionBlock::EMPTY });
                }
                self.points.push(block);
            }
            if let Some(block) = self.points.last_mut() {
                block.numbers[l] = number;
                block.count += 1;
                block.set(l, entry, self.first, linear, h);
                if let Some(directions) = block.directions {
                    self.directions[directions as usize].set(l, entry, angular, h);
                }
            }
        }
    }

    /// Hands multipliers and their sums back to the joints, and has `follow` bring those up to now whose angles count turns.
    pub(crate) fn store<E: Slots<JointEntry> + ?Sized>(&self, entries: &mut E, follow: impl Fn(&mut JointEntry)) {
        for block in &self.points {
            for (l, &number) in block.numbers().iter().enumerate() {
                let entry = entries.get_mut(number);
                entry.impulses = JointImpulses { point: get(&block.impulse, l), ..JointImpulses::ZERO };
                entry.linear_sum = get(&block.sum, l);
                if entry.counts_turns {
                    follow(entry);
                }
                if let Some(directions) = block.directions {
                    let directions = &self.directions[directions as usize];
                    entry.impulses.angular = get(&directions.impulse, l);
                    entry.angular_sum = get(&directions.sum, l);
                }
            }
        }
    }

    /// Finds levers and errors of now, at the start of a substep.
    pub(crate) fn begin(&mut self, motions: &[BodyMotion]) {
        begin_all(self, motions);
    }

    /// Builds the rows at the poses that `predicted_poses` predict from the velocities of now.
    pub(crate) fn prepare(&mut self, velocities: &[BodyVelocity], predicted_poses: &[PredictedPose], h: f32) {
        prepare_all(self, velocities, predicted_poses, h);
    }

    /// Applies the carried multipliers.
    pub(crate) fn warm_start(&self, velocities: &mut [BodyVelocity]) {
        warm_start_all(self, velocities);
    }

    /// One sweep over a range of blocks, of which none shares a moving body.
    pub(crate) fn sweep(&mut self, range: std::ops::Range<usize>, velocities: &mut [BodyVelocity], backwards: bool) {
        sweep_range(self, range.start, range.end, velocities, backwards);
    }

    /// One sweep over a range of blocks of displacements that take out the errors found at the substep's start, each of at most `most`
    /// (m or rad).
    pub(crate) fn push(&self, range: std::ops::Range<usize>, pushes: &mut [BodyVelocity], most: f32, backwards: bool) {
        push_range(self, range.start, range.end, pushes, most, backwards);
    }

    /// Sets the multipliers of joints on these slots to nothing.
    pub(crate) fn give_up(&mut self, slots: &[bool]) {
        for block in &mut self.points {
            for l in (0..block.count as usize).filter(|&l| slots[block.a[l] as usize] || slots[block.b[l] as usize]) {
                put(&mut block.impulse, l, Vec3::ZERO);
                if let Some(number) = block.directions {
                    put(&mut self.directions[number as usize].impulse, l, Vec3::ZERO);
                }
            }
        }
    }

    /// Keeps the multipliers of points and directions of each block as they are.
    pub(super) fn keep(&self, kept: &mut Vec<[Lane3; 2]>) {
        let of_directions = |block: &PointBlock| block.directions.map(|number| self.directions[number as usize].impulse);
        kept.clear();
        kept.extend(self.points.iter().map(|block| [block.impulse, of_directions(block).unwrap_or_default()]));
    }

    /// Puts the multipliers of joints back that are on none of these slots.
    pub(super) fn put_back(&mut self, kept: &[[Lane3; 2]], slots: &[bool]) {
        for (block, [points, turns]) in self.points.iter_mut().zip(kept) {
            for l in (0..block.count as usize).filter(|&l| !(slots[block.a[l] as usize] || slots[block.b[l] as usize])) {
                put(&mut block.impulse, l, get(points, l));
                if let Some(number) = block.directions {
                    put(&mut self.directions[number as usize].impulse, l, get(turns, l));
                }
            }
        }
    }

    /// Adds the substep's multipliers to their sums.
    pub(crate) fn add_loads(&mut self) {
        let add = |sum: &mut Lane3, impulse: &Lane3| {
            for (sum, impulse) in sum.iter_mut().zip(impulse) {
                sum.iter_mut().zip(impulse).for_each(|(sum, impulse)| *sum += impulse);
            }
        };
        self.points.iter_mut().for_each(|block| add(&mut block.sum, &block.impulse));
        self.directions.iter_mut().for_each(|block| add(&mut block.sum, &block.impulse));
    }

    /// Position rows of a range of blocks at the poses of now, in which errors of at most `most` (m or rad) are taken out.
    pub(crate) fn project(
        &self,
        range: std::ops::Range<usize>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        most: f32,
    ) {
        project_range(self, range.start, range.end, velocities, motions, most);
    }

    /// Greatest distance between joint points at the poses of now (m).
    pub(crate) fn worst_gap(&self, motions: &[BodyMotion]) -> f32 {
        let mut worst = 0.0;
        worst_gap_of(self, motions, &mut worst);
        worst
    }

    /// Greatest distance of points that are held without give, as a share of their levers.
    pub(crate) fn opening(&self, motions: &[BodyMotion]) -> f32 {
        let mut widest = 0.0;
        opening_of(self, motions, &mut widest);
        widest
    }

    /// Tells the same of each joint, with the slots of its bodies.
    pub(super) fn each_opening(&self, motions: &[BodyMotion], tell: &mut impl FnMut([u32; 2], f32)) {
        begin::each_opening(self, motions, tell);
    }
}

in_lanes!(opening_of, begin::opening, (lanes: &JointLanes, motions: &[BodyMotion], widest: &mut f32));
in_lanes!(begin_all, begin::all, (lanes: &mut JointLanes, motions: &[BodyMotion]));
in_lanes!(worst_gap_of, begin::worst_gap, (lanes: &JointLanes, motions: &[BodyMotion], worst: &mut f32));
in_lanes!(prepare_all, rows::prepare, (lanes: &mut JointLanes, velocities: &[BodyVelocity], predicted_poses: &[PredictedPose], h: f32));
in_lanes!(warm_start_all, sweep::warm_start, (lanes: &JointLanes, velocities: &mut [BodyVelocity]));
in_lanes!(
    sweep_range, sweep::sweep,
    (lanes: &mut JointLanes, start: usize, end: usize, velocities: &mut [BodyVelocity], backwards: bool)
);
in_lanes!(
    push_range, sweep::push,
    (lanes: &JointLanes, start: usize, end: usize, pushes: &mut [BodyVelocity], most: f32, backwards: bool)
);
in_lanes!(
    project_range, project::project,
    (lanes: &JointLanes, start: usize, end: usize, velocities: &mut [BodyVelocity], motions: &mut [BodyMotion], most: f32)
);
