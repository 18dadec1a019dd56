//! All articulations of a batch that touch moving bodies: solves their block constraints between sweeps, alone or four at a time,
//! on all threads where there are many.

use super::Direct;
use super::articulation::Articulation;
use super::articulation_batch::ArticulationBatch;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::solve::disjoint::{DisjointPart, DisjointSlices, Slots};
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::workers::Workers;

/// Articulations alone or in lockstep from which on several threads go through them, and what four ragdolls cost a thread on the mean (µs): a
/// sweep takes less, and to form their factors more.
const SHARED_UNITS: usize = 8;
const UNIT_TIME: f32 = 10.0;

/// Pieces for each thread: articulations differ in length.
const PIECES_EACH: usize = 2;

/// Threads, and the state of a batch's bodies on which they work.
pub(crate) struct SolveContext<'a> {
    pub threads: &'a Workers,
    pub velocities: &'a mut [BodyVelocity],
    pub motions: &'a mut [BodyMotion],
}

/// What one thread has of the bodies.
struct WorkerBodies<'a> {
    velocities: DisjointPart<'a, BodyVelocity>,
    motions: DisjointPart<'a, BodyMotion>,
}

impl Direct {
    fn coupled(&mut self) -> impl Iterator<Item = &mut Articulation> {
        self.articulations[..self.count].iter_mut().filter(|articulation| articulation.coupled)
    }

    /// Whether each body that they move is of one of them.
    fn are_apart(&self) -> bool {
        let swept = self.articulations().iter().zip(0..).filter(|(own, _)| own.coupled);
        swept
            .flat_map(|(own, number)| own.moved_slots().map(move |slot| (slot, number)))
            .all(|(slot, number)| self.local[slot as usize].0 == number)
    }

    /// Does one thing to those that go by themselves, and another to those that go in lockstep.
    fn each(
        &mut self,
        floor: SolveContext<'_>,
        alone: impl Fn(&mut Articulation, &mut WorkerBodies<'_>) + Sync,
        beside: impl Fn(&mut ArticulationBatch, &mut DisjointPart<'_, Articulation>, &mut WorkerBodies<'_>) + Sync,
    ) {
        let SolveContext { threads, velocities, motions } = floor;
        debug_assert!(self.are_apart(), "two articulations move one body");
        let articulations = &mut self.articulations[..self.count];
        let (lone, groups) = self.locksteps.parts();
        let units = lone.len() + groups.len();
        if units == 0 {
            return;
        }
        let (velocities, motions) = (DisjointSlices::new(velocities), DisjointSlices::new(motions));
        let (articulations, groups) = (DisjointSlices::new(articulations), DisjointSlices::new(groups));
        let places = if units >= SHARED_UNITS { threads.places_for(units as f32 * UNIT_TIME, 1) } else { 1 };
        let piece = if places > 1 { units.div_ceil(PIECES_EACH * places) } else { units };
        let count = units.div_ceil(piece);
        let pieces = (0..units).step_by(piece).zip(0..).map(|(first, number)| (0, number * places / count, first));
        threads.share_in_phases(pieces, |first| {
            // SAFETY: each unit is in one piece, each articulation is alone or a member of one group, and changes the state of bodies that it
            // moves, each of which is of one articulation.
            let (mut own, mut groups, mut hands) = unsafe {
                let hands = WorkerBodies { velocities: velocities.part(), motions: motions.part() };
                (articulations.part(), groups.part(), hands)
            };
            for unit in first..units.min(first + piece) {
                match lone.get(unit) {
                    Some(&number) => alone(own.get_mut(number), &mut hands),
                    None => {
                        let group = groups.get_mut((unit - lone.len()) as u32);
                        if !group.members().is_empty() {
                            beside(group, &mut own, &mut hands);
                        }
                    }
                }
            }
        });
    }

    /// Has the articulations that touch what moves answer contacts as in the first substep, of length `h` (s).
    pub(crate) fn get_ready(&mut self, floor: SolveContext<'_>, h: f32) {
        let h = f64::from(h);
        self.locksteps.gather(&mut self.articulations[..self.count]);
        let get_ready =
            |own: &mut Articulation, hands: &mut WorkerBodies<'_>| own.get_ready(&mut hands.velocities, &hands.motions, h);
        self.each(floor, get_ready, |group, own, hands| {
            group.members().iter().for_each(|&member| get_ready(own.get_mut(member), hands));
        });
    }

    /// Begins a substep of the articulations that touch what moves, `rest` (s) from the end of the step.
    pub(crate) fn couple(&mut self, joints: &Pool<Joint, JointId>, floor: SolveContext<'_>, h: f32, rest: f32) {
        let [h, rest] = [h, rest].map(f64::from);
        let couple = |own: &mut Articulation, WorkerBodies { velocities, motions }: &mut WorkerBodies<'_>| {
            own.couple(joints, velocities, motions, h, rest);
        };
        self.each(floor, couple, |group, own, hands| {
            group.members().iter().for_each(|&member| couple(own.get_mut(member), hands));
        });
    }

    /// Applies the carried multipliers of the articulations that touch what moves.
    pub(crate) fn warm_start(&mut self, floor: SolveContext<'_>, iterations: u32) {
        self.each(
            floor,
            |own, hands| own.warm_start(&mut hands.velocities, iterations),
            |group, own, hands| group.warm_start(own, &mut hands.velocities, iterations),
        );
    }

    /// Solves the joints of the articulations that touch what moves.
    pub(crate) fn sweep(&mut self, floor: SolveContext<'_>) {
        self.each(
            floor,
            |own, hands| own.sweep(&mut hands.velocities),
            |group, own, hands| group.sweep(own, &mut hands.velocities),
        );
    }

    /// Forgets the multipliers of those whose bodies have these slots, as if the substep had begun without any.
    pub(crate) fn drop_impulses(&mut self, slots: &[bool]) {
        self.coupled().filter(|articulation| articulation.is_on(slots)).for_each(Articulation::drop_impulses);
    }

    /// As [`sweep`](Self::sweep), of those alone.
    pub(crate) fn sweep_on(&mut self, slots: &[bool], velocities: &mut [BodyVelocity]) {
        self.coupled().filter(|articulation| articulation.is_on(slots)).for_each(|articulation| articulation.sweep(velocities));
    }

    /// What motors and springs of articulations that touch what moves have done in the substep (J): handed over with slots of each.
    pub(crate) fn find_work(&self, mut hand_over: impl FnMut([u32; 2], f64)) {
        for articulation in self.articulations().iter().filter(|articulation| articulation.coupled) {
            if let Some(slot) = articulation.moved_slots().next() {
                hand_over([slot; 2], articulation.work());
            }
        }
    }

    /// Has displacements of bodies leave the joints of the articulations that touch what moves as they are; the floor's velocities are
    /// those displacements.
    pub(crate) fn yield_to_pushes(&mut self, floor: SolveContext<'_>) {
        self.each(
            floor,
            |own, hands| own.yield_to(&mut hands.velocities),
            |group, own, hands| group.yield_to(own, &mut hands.velocities),
        );
    }

    /// Ends a substep of the articulations that touch what moves, or the step: of a substep the multipliers are kept, positions are mended.
    pub(crate) fn settle(&mut self, joints: &Pool<Joint, JointId>, floor: SolveContext<'_>, is_end: bool) {
        self.each(
            floor,
            |own, WorkerBodies { velocities, motions }| own.settle(joints, velocities, motions, is_end),
            |group, own, WorkerBodies { velocities, motions }| group.settle(own, joints, velocities, motions, is_end),
        );
    }
}
