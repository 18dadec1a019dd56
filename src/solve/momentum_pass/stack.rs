//! Bodies of stacks, with the manifolds and points that each stands on: target velocities going up, impulses going down. Threads each
//! handle a part of a level.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::super::batch::Batch;
use super::super::contact::POINTS;
use super::super::contact_block::ContactBlocks;
use super::super::disjoint::{DisjointPart, DisjointSlices, Slots};
use super::super::state::{BodyMotion, BodyVelocity};
use super::changes::LaneChanges;
use super::patch::{BalanceRows, Impulse, PatchPoint, SupportPatch};
use crate::load_distribution::{BoundedPoint, adjust};

/// Place of a body that the pass does not move: it is fixed or kinematic.
pub(super) const NO_PLACE: u32 = u32::MAX;

/// Share of what a body asks of its points that they may leave undone for it to be balanced on them.
const UNBALANCED_SHARE: f64 = 0.1;

/// A body that stands on others, or on which others stand.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Standing {
    pub slot: u32,
    pub island: u32,
    /// The first of its patches and of their points, and those after the last.
    patches: [u32; 2],
    points: [u32; 2],
    pub rows: BalanceRows,
    /// Velocity that it can keep (m/s).
    pub target: Vec3,
    /// Change of linear and angular velocity.
    pub change: (Vec3, Vec3),
}

/// What a body adds to the energy of its island along all changes (J).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Along {
    pub slope: f64,
    pub curvature: f64,
}

impl Standing {
    /// A body with these patches and points, from the first of them to those after the last.
    pub(super) fn new(slot: u32, island: u32, (patches, points): ([u32; 2], [u32; 2])) -> Self {
        Self { slot, island, patches, points, ..Self::default() }
    }

    /// Patches and points up to its last ones.
    pub(super) fn ends(&self) -> [usize; 2] {
        [self.patches[1], self.points[1]].map(|end| end as usize)
    }

    pub(super) fn patches(&self) -> Range<usize> {
        self.patches[0] as usize..self.patches[1] as usize
    }

    pub(super) fn points(&self) -> Range<usize> {
        self.points[0] as usize..self.points[1] as usize
    }

    /// The points of one of its patches, of all that it has.
    fn points_of(&self, patch: &SupportPatch) -> Range<usize> {
        let Range { start, end } = patch.points();
        start - self.points[0] as usize..end - self.points[0] as usize
    }
}

/// Bodies upper before lower, each with its patches and their points in a row.
#[derive(Debug, Default)]
pub(super) struct Stacks {
    pub bodies: Vec<Standing>,
    pub patches: Vec<SupportPatch>,
    pub points: Vec<PatchPoint>,
    pub bounded: Vec<BoundedPoint>,
    /// What is handed to the lower body, by the lane of a patch among those of all blocks.
    pub handed: Vec<Impulse>,
    /// By slot.
    pub along: Vec<Along>,
}

impl Stacks {
    pub(super) fn divide(&mut self) -> DividedStacks<'_> {
        let Self { bodies, patches, points, bounded, handed, along } = self;
        DividedStacks {
            bodies: DisjointSlices::new(bodies),
            patches: DisjointSlices::new(patches),
            points: DisjointSlices::new(points),
            bounded: DisjointSlices::new(bounded),
            handed: DisjointSlices::new(handed),
            along: DisjointSlices::new(along),
        }
    }
}

/// Stacks of which several threads change other bodies at once.
pub(super) struct DividedStacks<'a> {
    bodies: DisjointSlices<'a, Standing>,
    patches: DisjointSlices<'a, SupportPatch>,
    points: DisjointSlices<'a, PatchPoint>,
    bounded: DisjointSlices<'a, BoundedPoint>,
    handed: DisjointSlices<'a, Impulse>,
    along: DisjointSlices<'a, Along>,
}

impl DividedStacks<'_> {
    /// Some bodies, for one thread.
    ///
    /// # Safety
    /// While it lives no other part is used for a body that this one is used for, or for one that stands on such a body or under it.
    pub(super) unsafe fn part(&self) -> SomeStacks<'_> {
        // SAFETY: patches and points belong to the body that stands on them, as do the lanes of what it hands on and the energy of its slot; of
        // others, only what is handed on by those that stand on a body is read, and the velocities of those under it.
        unsafe {
            SomeStacks {
                bodies: self.bodies.part(),
                patches: self.patches.part(),
                points: self.points.part(),
                bounded: self.bounded.part(),
                handed: self.handed.part(),
                along: self.along.part(),
            }
        }
    }
}

/// Bodies of some stacks, with what they stand on.
pub(super) struct SomeStacks<'a> {
    bodies: DisjointPart<'a, Standing>,
    patches: DisjointPart<'a, SupportPatch>,
    points: DisjointPart<'a, PatchPoint>,
    bounded: DisjointPart<'a, BoundedPoint>,
    handed: DisjointPart<'a, Impulse>,
    along: DisjointPart<'a, Along>,
}

impl SomeStacks<'_> {
    /// Takes multipliers and closing speeds of now from the blocks, and finds the velocity that a body can keep, those below having
    /// theirs.
    pub(super) fn find_target(&mut self, place: u32, batch: &Batch, up: Vec3) {
        let Self { bodies, patches, points, .. } = self;
        let body = *bodies.get(place);
        let velocity = &batch.velocities[body.slot as usize];
        let points = points.range_mut(body.points());
        let (mut sum, mut count) = (0.0, 0.0);
        let (mut along, mut load) = (Vec3::ZERO, 0.0);
        for number in body.patches() {
            let patch = patches.get(number as u32);
            let below = match patch.below {
                NO_PLACE => batch.velocities[patch.stand.lower as usize].linear,
                place => bodies.get(place).target,
            };
            let (rise, block, lane) = (below.dot(up), patch.block(), patch.lane());
            for point in &mut points[body.points_of(patch)] {
                let rows = batch.contacts.rows(block, usize::from(point.index));
                (point.lambda, point.closing_speed) = (rows.lambda[lane], rows.closing_speed[lane]);
                let allowed = rise - point.closing_speed;
                let speed = (velocity.linear + velocity.angular.cross(point.lever_upper)).dot(up);
                point.takes_part = speed < allowed || point.lambda > 0.0;
                if point.takes_part {
                    sum += allowed;
                    count += 1.0;
                }
                along += below * point.lambda;
                load += point.lambda;
            }
        }
        let aside = if load > 0.0 { along / load } else { velocity.linear };
        let rise = if count > 0.0 { sum / count } else { velocity.linear.dot(up) };
        bodies.get_mut(place).target = aside.reject_from_normalized(up) + up * rise;
    }

    /// Finds changes of multipliers that give a body its velocity, with what is handed to it through the patches `above`; notes them for
    /// the rows.
    pub(super) fn hand_down(&mut self, place: u32, above: &[u32], batch: &Batch, up: Vec3, changes: &[LaneChanges]) {
        let mut body = *self.bodies.get(place);
        let (velocity, motion) = (&batch.velocities[body.slot as usize], &batch.motions[body.slot as usize]);
        let borne = above.iter().fold(Impulse::default(), |sum, &lane| sum + *self.handed.get(lane));
        let mut work = Work::default();
        let Self { patches, points, bounded, handed, .. } = self;
        if !body.patches().is_empty() {
            let mut under = Under {
                body: &body,
                patches: patches.range_mut(body.patches()),
                points: points.range_mut(body.points()),
                bounded: bounded.range_mut(body.points()),
            };
            under.adjust(borne + asked(&body, velocity, motion), up.as_dvec3());
            work = under.hand_on(batch, changes, handed);
        }
        let net = work.own - borne;
        let (linear, angular) = (net.linear.as_vec3(), net.angular.as_vec3());
        body.change = (velocity.inverse_mass * linear, velocity.inverse_inertia.mul(angular));
        *self.along.get_mut(body.slot) = Along {
            slope: work.closing + net.power(velocity.linear, velocity.angular),
            curvature: net.power(body.change.0, body.change.1),
        };
        *self.bodies.get_mut(place) = body;
    }
}

/// What a body must be given to move as it can.
fn asked(body: &Standing, velocity: &BodyVelocity, motion: &BodyMotion) -> Impulse {
    let mass = 1.0 / velocity.inverse_mass.max_element();
    Impulse {
        linear: (mass * (body.target - velocity.linear)).as_dvec3(),
        angular: -motion.angular_momentum(velocity.angular).as_dvec3(),
    }
}

/// What the changes under a body do.
#[derive(Default)]
struct Work {
    /// Their sum on the body.
    own: Impulse,
    /// Their power against closing speeds, and against what moves by itself (J).
    closing: f64,
}

/// What a body stands on.
struct Under<'a> {
    body: &'a Standing,
    patches: &'a mut [SupportPatch],
    points: &'a mut [PatchPoint],
    bounded: &'a mut [BoundedPoint],
}

impl Under<'_> {
    /// Finds changes that add up to an impulse, as nearly as pushing and friction can.
    fn adjust(&mut self, demand: Impulse, up: DVec3) {
        self.share_friction((demand.linear - up * demand.linear.dot(up)).as_vec3());
        if !self.adjust_points(demand) {
            // It turns over the edge of what is under it: the edge rests then, not the centre of mass.
            self.patches.iter_mut().for_each(|patch| patch.rub = Vec3::ZERO);
            self.adjust_points(demand);
        }
    }

    /// Friction that takes momentum across gravity, on every manifold by the load that it bears.
    fn share_friction(&mut self, push: Vec3) {
        let Self { body, patches, points, .. } = self;
        let pressed = |patch: &SupportPatch| points[body.points_of(patch)].iter().map(|point| point.lambda).sum::<f32>();
        let load: f32 = points.iter().map(|point| point.lambda).sum();
        for patch in &mut **patches {
            let share = if load > 0.0 { push * (pressed(patch) / load) } else { Vec3::ZERO };
            let [t1, t2] = patch.tangents;
            patch.rub = t1 * share.dot(t1) + t2 * share.dot(t2);
        }
    }

    /// Finds changes of the multipliers that, with friction, add up to an impulse, as nearly as pushing can; says whether they do.
    fn adjust_points(&mut self, demand: Impulse) -> bool {
        let rubbed = self.patches.iter().map(|patch| Impulse::at(patch.center_upper, patch.rub.as_dvec3()));
        let demand = self.body.rows.of_impulse(&rubbed.fold(demand, |left, rubbed| left - rubbed));
        for (point, bounded) in self.points.iter().zip(&mut *self.bounded) {
            bounded.begin(-point.lambda, point.takes_part);
        }
        adjust(self.bounded, demand);
        let left = self.bounded.iter().fold(demand, |left, bounded| left - bounded.effect());
        left.length_squared() <= UNBALANCED_SHARE * UNBALANCED_SHARE * demand.length_squared()
    }

    /// Cuts friction to what the new load allows, hands everything to what is below, and notes all changes.
    fn hand_on(&mut self, batch: &Batch, changes: &[LaneChanges], handed: &mut DisjointPart<'_, Impulse>) -> Work {
        let ContactBlocks { blocks, .. } = &batch.contacts;
        let mut work = Work::default();
        for patch in &mut *self.patches {
            let own = self.body.points_of(patch);
            let (mut deltas, mut load) = ([0.0; POINTS], 0.0);
            let (mut push, mut lever_upper, mut lever_lower) = (0.0, DVec3::ZERO, DVec3::ZERO);
            for (point, bounded) in self.points[own.clone()].iter().zip(&self.bounded[own]) {
                let delta = f64::from(bounded.change);
                load += point.lambda + bounded.change;
                push += delta;
                lever_upper += point.lever_upper.as_dvec3() * delta;
                lever_lower += point.lever_lower.as_dvec3() * delta;
                work.closing += delta * f64::from(point.closing_speed);
                deltas[usize::from(point.index)] = bounded.change;
            }
            let before = patch.rubbed(blocks);
            patch.rub = (before + patch.rub).clamp_length_max(patch.friction * load.max(0.0)) - before;
            changes[patch.block()].set(patch.lane(), deltas, patch.rub_along_tangents());
            let (normal, rub) = (patch.normal.as_dvec3(), patch.rub.as_dvec3());
            let linear = normal * push;
            let on = Impulse { linear, angular: lever_lower.cross(normal) } + Impulse::at(patch.center_lower, rub);
            *handed.get_mut(patch.all_lanes) = on;
            work.own = work.own + Impulse { linear, angular: lever_upper.cross(normal) } + Impulse::at(patch.center_upper, rub);
            if patch.below == NO_PLACE {
                let lower = &batch.velocities[patch.stand.lower as usize];
                work.closing -= on.power(lower.linear, lower.angular);
            }
        }
        work
    }
}
