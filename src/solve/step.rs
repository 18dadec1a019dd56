//! The stages of a batch's step, in the order in which they run.

use std::sync::atomic::{AtomicBool, Ordering};

use super::batch::{Batch, LongRangeRows};
use super::body_warm_start::BodyWarmStart;
use super::contact_energy::{ContactEnergy, LoadRelease};
use super::contact_newton::ContactNewton;
use super::direct::{Direct, SolveContext};
use super::followed_velocity::FollowedVelocities;
use super::impact::gather::Impacts;
use super::initial_impulses::InitialImpulses;
use super::joint::MovingBodies;
use super::joint_closing::{JointClosing, OpenJoints};
use super::joint_energy::JointEnergy;
use super::joint_mesh::JointMesh;
use super::momentum_pass::MomentumPass;
use super::recovery::Recovery;
use super::slides::Slides;
use super::smeared_spins::SmearedSpins;
use super::yielding_motors::YieldingMotors;
use super::{StepSettings, contact_kernels, integrate, parallel_contacts};
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::workers::Workers;

/// Sweeps in a substep from which rows of bounds are built anew before the last one, as rows of joints always are. A substep of few
/// sweeps is short: a bound changes little in it, and building its row costs as much as sweeping it twice.
const LONG_SUBSTEP: u32 = 3;

/// What each stage of a batch's step keeps to itself: the batch has what they share.
#[derive(Debug, Default)]
pub(crate) struct BatchStages {
    initial_impulses: InitialImpulses,
    pub momentum_pass: MomentumPass,
    contact_newton: ContactNewton,
    yielding: YieldingMotors,
    pub body_warm_start: BodyWarmStart,
    pub joint_mesh: JointMesh,
    joint_energy: JointEnergy,
    pub contact_energy: ContactEnergy,
    load_release: LoadRelease,
    followed: FollowedVelocities,
    smeared: SmearedSpins,
    impacts: Impacts,
    closing: JointClosing,
    pub slides: Slides,
    recovery: Recovery,
}

impl BatchStages {
    /// Moves all bodies of the batch through the step.
    pub(crate) fn solve(&mut self, batch: &mut Batch, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings) {
        let h = settings.dt / settings.substeps as f32;
        self.slides.clear();
        if batch.is_done() {
            self.report_unswept(batch, joints, threads, settings, h);
            return;
        }
        self.begin_step(batch, threads, settings, h);
        for substep in 0..settings.substeps {
            self.take_substep(batch, joints, threads, settings, h, substep);
        }
        self.end_step(batch, joints, threads, settings, h);
    }

    /// What a batch reports whose bodies have all been moved by direct solves.
    fn report_unswept(
        &mut self,
        batch: &mut Batch,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        settings: &StepSettings,
        h: f32,
    ) {
        // What it says of the bodies is stored with them, and asked of those without joints.
        match batch.motions[1..].iter().all(|motion| motion.jointed) {
            true => self.momentum_pass.clear(),
            false => self.momentum_pass.prepare(batch, threads, settings, h),
        }
        self.joint_mesh.clear();
        batch.residuals.penetration = batch.direct.penetration().max(batch.newton.penetration()) as f32;
        batch.residuals.joint_gap = batch.direct.joint_gap(joints, &batch.motions, threads).max(batch.newton.joint_gap(joints));
    }

    /// Prepares whatever acts on the bodies of the batch, for all substeps.
    fn begin_step(&mut self, batch: &mut Batch, threads: &Workers, settings: &StepSettings, h: f32) {
        self.initial_impulses.start_contacts(batch, threads, settings.gravity, h);
        self.momentum_pass.prepare(batch, threads, settings, h);
        self.contact_newton.prepare(batch, settings.gravity, h, settings.iterations);
        batch.lay_out_bounds(h);
        batch.mark_falling();
        batch.poses.lay_out(threads, (&batch.velocities, &mut batch.motions), &batch.body_flags, h);
        batch.poses.limit_spins_of_needles(&mut batch.velocities, h);
        self.joint_energy.find_islands(batch);
        self.followed.begin_step(batch.direct.left(&batch.joints.links), &batch.islands, &batch.motions);
        self.contact_energy.lay_out(&self.joint_energy, &batch.velocities, &batch.motions);
        self.joint_mesh.prepare(batch, threads, self.joint_energy.slots().next().is_some());
        self.body_warm_start.prepare(batch, self.momentum_pass.is_idle() && self.contact_newton.is_idle(), h);
        self.impacts.prepare(&batch.contacts);
    }

    /// One substep: forces, rows, sweeps, poses, position rows, impacts.
    fn take_substep(
        &mut self,
        batch: &mut Batch,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        settings: &StepSettings,
        h: f32,
        substep: u32,
    ) {
        let is_last = substep + 1 == settings.substeps;
        batch.bend_paths(h, substep, settings.substeps);
        batch.joints.left = h * (settings.substeps - substep) as f32;
        batch.half_steps.begin_substep(&batch.velocities, substep, settings.substeps);
        self.apply_forces(batch, joints, threads, h, substep, settings.substeps);
        if substep == 0 {
            self.load_release.note(batch);
        }
        self.joint_energy.note(threads, &batch.velocities, &batch.poses);
        self.impacts.note(&batch.velocities, &batch.contacts);
        batch.prepare_joints(joints, threads, h, false, true);
        let is_mesh = self.joint_mesh.is_one();
        let is_weighed = is_mesh && self.joint_mesh.solve(batch, self.joint_energy.noted(), threads, h);
        if !is_mesh {
            self.smeared.show(&mut batch.velocities, |_| true);
            self.sweep_all(batch, joints, threads, h, settings.iterations, substep);
            self.smeared.give_back(&mut batch.velocities, |_| true);
        }
        self.joint_energy.restrain(batch, joints, threads, is_weighed);
        self.contact_energy.dissipate(batch, threads, settings.iterations, &self.smeared);
        if substep == 0 {
            self.load_release.solve_anew(batch, threads, settings.iterations);
            batch.half_steps.halve_start(self.joint_energy.slots(), &mut batch.velocities);
        }
        batch.joints.end_substep(threads);
        batch.add_bound_loads();
        if is_last {
            batch.planes.fit_velocities(&mut batch.velocities, &batch.motions, &batch.poses, h);
        }
        self.impacts.find(batch, &self.smeared, settings.restitution_threshold, h);
        self.advance(batch, threads, h);
        self.followed.mark(&batch.motions);
        if !is_mesh {
            batch.poses.note_rotations(self.joint_energy.all_slots(), &batch.motions);
        }
        batch.joints.left -= h;
        batch.project_bounds(h);
        if is_mesh {
            self.joint_mesh.displace(batch, threads);
        } else {
            batch.joints.project(joints, threads, &mut batch.velocities, &mut batch.motions, h);
            batch.poses.keep_turning(threads, &mut batch.velocities, &batch.motions);
        }
        if is_last {
            batch.flatten();
        }
        self.settle(batch, joints, threads, false);
        self.followed.add_up(&batch.motions);
        if !is_last {
            self.rebound(batch, settings.restitution_threshold, h);
        }
    }

    /// Closes joints, recovers positions, and reads out multipliers and residuals.
    fn end_step(&mut self, batch: &mut Batch, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings, h: f32) {
        self.followed.mark(&batch.motions);
        if self.joint_mesh.is_one() {
            batch.joints.end_course(threads);
        } else {
            self.close_joints(batch, joints, threads, h);
            batch.poses.keep_turning(threads, &mut batch.velocities, &batch.motions);
        }
        self.rebound(batch, settings.restitution_threshold, h);
        batch.place_round_contacts();
        self.slides.find(&batch.contacts, &batch.velocities, &batch.motions, (h, settings.substeps), threads);
        self.recovery.recover_positions(batch, &mut self.contact_newton, threads, settings.dt);
        self.settle(batch, joints, threads, true);
        let Batch { half_steps, velocities, motions, .. } = batch;
        half_steps.tell(self.joint_energy.slots(), velocities, motions);
        self.followed.add_up(motions);
        self.followed.tell(velocities, motions, settings.dt, |slot, change| half_steps.add_lead(slot, change));
        if let Some(limits) = &settings.limits {
            contact_kernels::tell(&mut batch.contacts, &batch.velocities, limits, &mut batch.manifolds.tally.told);
        }
        batch.joints.store(joints, threads, &batch.motions);
        batch.long_range.bounds.store();
        batch.long_range.taut.store();
        let swept_gap = batch.joints.worst_gap(joints, threads, &batch.motions);
        let direct_gap = batch.direct.joint_gap(joints, &batch.motions, threads);
        batch.residuals.joint_gap = direct_gap.max(swept_gap).max(batch.newton.joint_gap(joints));
    }

    /// Lets points that have hit something in the substep leave again, and adds up its multipliers.
    fn rebound(&mut self, batch: &mut Batch, threshold: f32, h: f32) {
        self.impacts.apply(batch);
        contact_kernels::restitute(&mut batch.contacts, &mut batch.velocities, threshold);
        self.contact_newton.end_blows(batch, h);
        batch.add_to_tally();
        batch.contacts.end_blows();
        self.impacts.forget(&mut batch.contacts);
        self.contact_newton.forget_blows(&mut batch.contacts);
    }

    /// Warm start and sweeps of a substep of length `h`.
    fn sweep_all(
        &mut self,
        batch: &mut Batch,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        h: f32,
        iterations: u32,
        substep: u32,
    ) {
        batch.joints.warm_start(threads, &mut batch.velocities);
        batch.long_range.bounds.warm_start(&mut batch.velocities);
        batch.long_range.wraps.begin_substep(&mut batch.velocities, &batch.motions, h);
        let is_carried = self.body_warm_start.is_on() && substep > 0;
        // Levers are those of the start of the step.
        let middle = (substep as f32 + 0.5) * h;
        if !is_carried {
            batch.place_round_contacts();
            batch.start_sweeps(threads, h, middle);
            batch.aim_round_contacts(h, true);
        }
        let (direct, context) = batch.direct_and_context(threads);
        direct.warm_start(context, iterations);
        self.momentum_pass.apply(batch, threads);
        self.contact_newton.apply(batch);
        for iteration in 0..iterations {
            let is_last = iteration + 1 == iterations;
            if iteration > 0 && is_last {
                batch.prepare_joints(joints, threads, h, true, iterations >= LONG_SUBSTEP);
            }
            if iteration > 0 {
                batch.aim_round_contacts(h, false);
            }
            if iteration % 2 == 0 {
                batch.sweep_bounds(false);
                batch.sweep_articulations(threads);
                batch.joints.sweep(threads, &mut batch.velocities, false);
                if is_carried && iteration == 0 {
                    batch.sweep_anew(threads, h, is_last);
                } else {
                    batch.sweep_contacts(threads, false, is_last);
                }
            } else {
                batch.sweep_contacts(threads, true, is_last);
                batch.joints.sweep(threads, &mut batch.velocities, true);
                batch.sweep_articulations(threads);
                batch.sweep_bounds(true);
            }
        }
        self.yielding.apply(batch, threads);
    }

    /// Sweeps position rows on where joints are left ajar.
    fn close_joints(&mut self, batch: &mut Batch, all: &Pool<Joint, JointId>, threads: &Workers, h: f32) {
        let end = batch.moving() + 1;
        let Batch { joints, planes, poses, velocities, motions, body_flags, islands, .. } = batch;
        let mut open = OpenJoints { joints, all, planes, poses, velocities, motions, body_flags, islands, end };
        self.closing.close(&mut open, threads, h);
    }

    /// Takes errors of articulations out of positions, and restores the angular momentum of islands that nothing holds.
    fn settle(&mut self, batch: &mut Batch, joints: &Pool<Joint, JointId>, threads: &Workers, is_end: bool) {
        let (direct, context) = batch.direct_and_context(threads);
        direct.settle(joints, context, is_end);
        if !batch.free.is_empty() {
            batch.poses.find_inertia(&batch.motions);
            let Batch { free, velocities, motions, poses, islands, .. } = batch;
            free.restore(velocities, motions, poses, |slot| !is_end && self.impacts.has_struck(islands, slot));
        }
    }

    /// Begins a substep of length `h` (s), one of so many.
    fn apply_forces(
        &mut self,
        batch: &mut Batch,
        joints: &Pool<Joint, JointId>,
        threads: &Workers,
        h: f32,
        substep: u32,
        substeps: u32,
    ) {
        if self.body_warm_start.is_on() {
            self.smeared.find(false, &batch.velocities, &batch.motions);
            if self.body_warm_start.apply_forces(batch, threads, h, substep == 0) {
                parallel_contacts::refresh_masses(&mut batch.contacts, threads, &batch.velocities, &batch.motions);
            }
            return;
        }
        // What is cut off of a speed is momentum too, where that is noted.
        let is_noted = !batch.free.is_empty();
        // What joints hold may be refreshed elsewhere.
        let refreshes = AtomicBool::new(!batch.joints.slots.is_empty());
        let smears = AtomicBool::new(false);
        let Batch { poses, velocities, motions, .. } = batch;
        poses.each_single(threads, (velocities, motions), |velocity, motion| {
            integrate::apply_forces(velocity, motion, h);
            if motion.world_inertia.refreshed {
                refreshes.store(true, Ordering::Relaxed);
            }
            if motion.world_inertia.smeared {
                smears.store(true, Ordering::Relaxed);
            }
            if !is_noted {
                integrate::limit_speeds(velocity, motion);
            }
        });
        poses.apply_forces(threads, velocities, motions, h);
        batch.find_inertia();
        let Batch { poses, velocities, motions, free, .. } = batch;
        if is_noted {
            free.note(velocities, motions, poses, |_| true);
            poses.each_single(threads, (velocities, motions), |velocity, motion| integrate::limit_speeds(velocity, motion));
        }
        poses.limit_speeds(threads, velocities);
        self.contact_energy.note_energy(velocities, motions, poses, h);
        let (direct, context) = batch.direct_and_context(threads);
        direct.couple(joints, context, h, h * (substeps - substep) as f32);
        self.contact_energy.note_velocities(&batch.velocities);
        self.smeared.find(smears.into_inner(), &batch.velocities, &batch.motions);
        if !batch.contacts.is_empty()
            && refreshes.into_inner()
            && batch.motions.iter().any(|motion| motion.world_inertia.refreshed)
        {
            parallel_contacts::refresh_masses(&mut batch.contacts, threads, &batch.velocities, &batch.motions);
        }
    }

    /// Moves bodies by the velocities of a substep of length `h` (s).
    fn advance(&mut self, batch: &mut Batch, threads: &Workers, h: f32) {
        if self.body_warm_start.is_on() {
            self.body_warm_start.keep_changes(&batch.velocities, threads);
        }
        let moving = batch.moving();
        let Batch { poses, velocities, motions, .. } = batch;
        poses.each_alone(threads, (velocities, motions), |velocity, motion| integrate::advance(velocity, motion, h));
        poses.advance(threads, (velocities, motions, moving), h);
    }
}

impl Batch {
    /// The articulations, and what those that are swept work on.
    pub(crate) fn direct_and_context<'a>(&'a mut self, threads: &'a Workers) -> (&'a mut Direct, SolveContext<'a>) {
        let Self { direct, velocities, motions, .. } = self;
        (direct, SolveContext { threads, velocities, motions })
    }

    /// Whether articulations have moved all bodies through the step, and nothing is left to solve.
    fn is_done(&self) -> bool {
        self.contacts.is_empty() && self.motions[1..].iter().all(|motion| motion.direct)
    }

    /// Builds rows of joints at the poses predicted by now, and those of bounds and taut lines; `again` where they have been built in
    /// this substep, and `bounds_too` where those of bounds are to be built anew with them.
    fn prepare_joints(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32, again: bool, bounds_too: bool) {
        let Self { poses, velocities, motions, long_range: LongRangeRows { bounds, taut, .. }, .. } = self;
        if self.joints.entries.is_empty() {
            return;
        }
        poses.predict(threads, velocities, motions, h);
        let bodies = MovingBodies { velocities, motions, predicted_poses: &poses.predicted_poses };
        self.joints.prepare(joints, threads, &bodies, h, again);
        if bounds_too {
            bounds.prepare(velocities, motions, &poses.predicted_poses, h, again);
            taut.prepare(bounds, velocities, motions, &poses.predicted_poses, h);
        }
    }

    /// Lays out the rows of bounds for substeps of length `h` (s).
    fn lay_out_bounds(&mut self, h: f32) {
        self.long_range.bounds.lay_out(&self.motions, h);
        self.long_range.taut.lay_out(&self.long_range.bounds);
    }

    /// Adds the multipliers of a substep to the loads of bounds.
    fn add_bound_loads(&mut self) {
        self.long_range.bounds.add_loads();
        self.long_range.wraps.add_loads();
        self.long_range.taut.add_loads();
    }

    /// One sweep over the bounds, or backwards.
    fn sweep_bounds(&mut self, backwards: bool) {
        let Self { long_range: LongRangeRows { wraps, bounds, taut, .. }, velocities, .. } = self;
        if backwards {
            taut.sweep(velocities, true);
            bounds.sweep(velocities, true);
            wraps.sweep(velocities, true);
        } else {
            wraps.sweep(velocities, false);
            bounds.sweep(velocities, false);
            taut.sweep(velocities, false);
        }
    }

    /// Takes what bounds are exceeded by out of positions.
    fn project_bounds(&mut self, h: f32) {
        self.long_range.wraps.project(&self.velocities, &mut self.motions);
        self.long_range.bounds.project(&self.velocities, &mut self.motions, h);
        self.long_range.taut.project(&self.long_range.bounds, &self.velocities, &mut self.motions, h);
    }

    /// Finds the inertia of bodies as they stand now, where sums of their angular momentum are asked for.
    fn find_inertia(&mut self) {
        if !self.free.is_empty() || !self.planes.entries.is_empty() {
            self.poses.find_inertia(&self.motions);
        }
    }

    /// Puts hinge chains back into their planes.
    fn flatten(&mut self) {
        if !self.planes.entries.is_empty() {
            self.planes.project(&mut self.velocities, &mut self.motions, &mut self.poses);
        }
    }

    /// Gives what the host moves the mean velocity of this substep of length `h` (s), one of so many.
    fn bend_paths(&mut self, h: f32, substep: u32, substeps: u32) {
        let first = self.moving() + 1;
        // The first substep begins with the mean of the whole step.
        let ahead = if substep == 0 { -0.5 * (substeps - 1) as f32 * h } else { h };
        for (velocity, motion) in self.velocities[first..].iter_mut().zip(&self.motions[first..]) {
            velocity.linear += motion.acceleration * ahead;
            velocity.angular += motion.torque * ahead;
        }
    }

    fn sweep_articulations(&mut self, threads: &Workers) {
        let (direct, context) = self.direct_and_context(threads);
        direct.sweep(context);
    }

    /// Applies the multipliers that contacts have carried on, and looks how far their surfaces are apart by now.
    fn start_sweeps(&mut self, threads: &Workers, h: f32, middle: f32) {
        let (all, moving) = (0..self.contacts.len(), self.moving());
        let Self { contacts, velocities, motions, .. } = self;
        parallel_contacts::in_colors(contacts, all, threads, (velocities, moving), false, |part, velocities| {
            contact_kernels::warm_start(part, velocities, motions, h, middle);
        });
    }

    /// Brings the levers of round features that are swung to where bodies are now.
    fn place_round_contacts(&mut self) {
        let Self { contacts, velocities, motions, manifolds, .. } = self;
        manifolds.round.place(contacts, velocities, motions);
    }

    /// Has the rows of round features that are swung hold at the end of the substep, with velocities as they are now.
    fn aim_round_contacts(&mut self, h: f32, is_first: bool) {
        let Self { contacts, velocities, motions, manifolds, .. } = self;
        manifolds.round.aim(contacts, velocities, motions, h, is_first);
    }

    /// The first sweep of a substep over contacts whose bodies carry what they have done; looks how far their surfaces are apart by now.
    fn sweep_anew(&mut self, threads: &Workers, h: f32, is_last: bool) {
        let presses_last = is_last || !self.reverses_rows();
        let (all, moving) = (0..self.contacts.len(), self.moving());
        let Self { contacts, velocities, motions, .. } = self;
        parallel_contacts::in_colors(contacts, all, threads, (velocities, moving), false, |part, velocities| {
            contact_kernels::sweep_anew(part, velocities, motions, h, presses_last);
        });
    }

    /// One sweep over the contacts, or backwards, all in the opposite order.
    fn sweep_contacts(&mut self, threads: &Workers, backwards: bool, is_last: bool) {
        let (moving, presses_last) = (self.moving(), is_last || !self.reverses_rows());
        let bodies = (&mut self.velocities[..], moving);
        parallel_contacts::sweep(&mut self.contacts, threads, bodies, backwards, presses_last);
    }

    /// Whether sweeps go through the rows of each manifold in opposite orders on their two ways.
    ///
    /// Only then are the two one symmetric operator, and slow waves of load do not grow. Such waves are of large islands. In small ones friction
    /// comes before the normal rows on both ways: with two visits it then sees twice what these have made of the load, not once.
    fn reverses_rows(&self) -> bool {
        self.may_carry_changes()
    }
}
