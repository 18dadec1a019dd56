//! The articulations of a batch that touch what moves: their part in the sweeps over contacts, by themselves or in lockstep.

use super::Direct;
use super::articulation::Articulation;
use crate::id::{JointId, Pool};
use crate::joint::Joint;
use crate::solve::state::{BodyMotion, BodyVelocity};

impl Direct {
    fn coupled(&mut self) -> impl Iterator<Item = &mut Articulation> {
        self.articulations[..self.count].iter_mut().filter(|articulation| articulation.coupled)
    }

    /// Those that go by themselves.
    fn alone(&mut self) -> impl Iterator<Item = &mut Articulation> {
        self.coupled().filter(|articulation| !articulation.in_lockstep)
    }

    /// Has the articulations that touch what moves answer contacts as in the first substep, of length `h` (s).
    pub(crate) fn get_ready(&mut self, velocities: &mut [BodyVelocity], motions: &[BodyMotion], h: f32) {
        self.coupled().for_each(|articulation| articulation.get_ready(velocities, motions, f64::from(h)));
        self.locksteps.gather(&mut self.articulations[..self.count]);
    }

    /// Begins a substep of the articulations that touch what moves, `rest` (s) from the end of the step.
    pub(crate) fn couple(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &mut [BodyVelocity],
        motions: &mut [BodyMotion],
        h: f32,
        rest: f32,
    ) {
        let [h, rest] = [h, rest].map(f64::from);
        self.coupled().for_each(|articulation| articulation.couple(joints, velocities, motions, h, rest));
    }

    /// Applies the carried multipliers of the articulations that touch what moves.
    pub(crate) fn warm_start(&mut self, velocities: &mut [BodyVelocity], iterations: u32) {
        self.alone().for_each(|articulation| articulation.warm_start(velocities, iterations));
        let Self { locksteps, articulations, .. } = self;
        locksteps.iter_mut().for_each(|group| group.warm_start(articulations, velocities, iterations));
    }

    /// Solves the joints of the articulations that touch what moves.
    pub(crate) fn sweep(&mut self, velocities: &mut [BodyVelocity]) {
        self.alone().for_each(|articulation| articulation.sweep(velocities));
        let Self { locksteps, articulations, .. } = self;
        locksteps.iter_mut().for_each(|group| group.sweep(articulations, velocities));
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
    pub(crate) fn find_work(&self, joints: &Pool<Joint, JointId>, mut hand_over: impl FnMut([u32; 2], f64)) {
        for articulation in self.articulations().iter().filter(|articulation| articulation.coupled) {
            if let Some(slot) = articulation.moved_slots().next() {
                hand_over([slot; 2], articulation.work(joints));
            }
        }
    }

    /// Hands the multipliers of a substep back to the joints.
    pub(crate) fn keep_impulses(&mut self) {
        self.coupled().for_each(Articulation::keep_swept_impulses);
    }

    /// Mends the positions of the articulations that touch what moves, at the end of a substep or of the step.
    pub(crate) fn settle(
        &mut self,
        joints: &Pool<Joint, JointId>,
        velocities: &[BodyVelocity],
        motions: &mut [BodyMotion],
        is_end: bool,
    ) {
        self.alone().for_each(|articulation| articulation.settle(joints, velocities, motions, is_end));
        let Self { locksteps, articulations, .. } = self;
        locksteps.iter_mut().for_each(|group| group.settle(articulations, joints, velocities, motions, is_end));
    }
}
