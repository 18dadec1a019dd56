//! The solver: substeps of one batch of islands, on arrays of its own.
//!
//! A *batch* is one island, or several small ones, with its own copy of the bodies' state and its own rows, sorted by colour.
//! Batches share nothing and are solved side by side; an island's result does not depend on the batch it is in.
//!
//! A substep: forces → joint rows at predicted poses, warm start → sweeps of joints and contacts → poses → position rows of
//! joints → impacts. After the substeps: position recovery of contacts. What moves positions gives no velocity.

pub(crate) mod batch;
mod body_flags;
mod body_gather;
mod body_warm_start;
mod buckets;
mod color;
pub(crate) mod contact;
mod contact_block;
mod contact_energy;
mod contact_kernels;
mod contact_newton;
mod contact_partition;
pub(crate) mod direct;
pub(crate) mod disjoint;
pub(crate) mod distance_bound;
mod followed_velocity;
mod impact;
mod initial_impulses;
pub(crate) mod integrate;
pub(crate) mod joint;
mod joint_closing;
mod joint_energy;
mod joint_mesh;
pub(crate) mod momentum;
pub(crate) mod momentum_pass;
pub(crate) mod newton;
mod parallel_contacts;
pub(crate) mod plan;
pub(crate) mod plane;
mod recovery;
mod rotation;
pub(crate) mod slides;
pub(crate) mod state;
pub(crate) mod taut_line;
pub(crate) mod velocity_half_step;
mod wide_bodies;
mod wide_matrix;
pub(crate) mod wrapped_bound;

use std::sync::atomic::{AtomicBool, Ordering};

use batch::Batch;
use direct::{Direct, SolveContext};
use joint::MovingBodies;
use joint_closing::OpenJoints;

pub(crate) use crate::contact::status;
use crate::id::{JointId, Pool};
use crate::joint_record::Joint;
use crate::workers::Workers;

/// Sweeps in a substep from which rows of bounds are built anew before the last one, as rows of joints always are. A substep of few
/// sweeps is short: a bound changes little in it, and building its row costs as much as sweeping it twice.
const LONG_SUBSTEP: u32 = 3;

/// What all batches of a step have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepSettings {
    /// Length of the step (s).
    pub dt: f32,
    /// Acceleration of free fall (m/s²).
    pub gravity: glam::Vec3,
    pub substeps: u32,
    pub iterations: u32,
    pub articulations: crate::settings::ArticulationSettings,
    /// Approach speed above which a contact rebounds (m/s).
    pub restitution_threshold: f32,
    /// What contacts are told by, where somebody wants to know.
    pub limits: Option<status::StatusThresholds>,
}

impl StepSettings {
    /// Those of a batch that takes so many substeps at once, or several for each.
    pub(crate) fn striding(&self, stride: f32) -> Self {
        Self { substeps: (self.substeps as f32 / stride).round() as u32, ..*self }
    }
}

impl Batch {
    /// Moves all bodies of the batch through the step.
    pub(crate) fn solve(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings) {
        let h = settings.dt / settings.substeps as f32;
        if self.is_done() {
            self.report_unswept(joints, threads, settings, h);
            return;
        }
        self.begin_step(threads, settings, h);
        for substep in 0..settings.substeps {
            self.take_substep(joints, threads, settings, h, substep);
        }
        self.end_step(joints, threads, settings, h);
    }

    /// What a batch reports whose bodies have all been moved by direct solves.
    fn report_unswept(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings, h: f32) {
        // What it says of the bodies is stored with them, and asked of those without joints.
        match self.motions[1..].iter().all(|motion| motion.jointed) {
            true => self.momentum_pass.clear(),
            false => self.prepare_momentum_pass(threads, settings.gravity, h),
        }
        (0..settings.substeps).for_each(|_| self.add_to_tally());
        self.penetration = self.direct.penetration().max(self.newton.penetration()) as f32;
        self.joint_gap = self.direct.joint_gap(joints, &self.motions, threads).max(self.newton.joint_gap(joints));
    }

    /// Prepares whatever acts on the bodies of the batch, for all substeps.
    fn begin_step(&mut self, threads: &Workers, settings: &StepSettings, h: f32) {
        self.start_contacts(threads, settings.gravity, h);
        self.prepare_momentum_pass(threads, settings.gravity, h);
        self.prepare_exact(settings.gravity, h);
        self.bounds.lay_out(&self.motions, h);
        self.taut.lay_out(&self.bounds);
        self.poses.lay_out(threads, (&self.velocities, &mut self.motions), &self.body_flags, h);
        self.find_passive_islands();
        self.followed.begin_step(self.direct.left(&self.joints.links), &self.islands, &self.motions);
        self.contact_energy.lay_out(&self.joint_energy, &self.velocities, &self.motions);
        self.find_sheet(threads);
        self.prepare_carry();
        self.impacts.prepare(&self.contacts);
    }

    /// One substep: forces, rows, sweeps, poses, position rows, impacts.
    fn take_substep(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings, h: f32, substep: u32) {
        let is_last = substep + 1 == settings.substeps;
        self.bend_paths(h, substep, settings.substeps);
        self.joints.left = h * (settings.substeps - substep) as f32;
        self.half_steps.begin_substep(&self.velocities, substep, settings.substeps);
        self.apply_forces(joints, threads, h, substep, settings.substeps);
        self.joint_energy.note(threads, &self.velocities, &self.poses);
        self.note_impacts();
        self.prepare_joints(joints, threads, h, false, true);
        let is_weighed = self.mesh.is_one() && self.solve_sheet(threads, h);
        if !self.mesh.is_one() {
            self.sweep_all(joints, threads, h, settings.iterations, substep);
        }
        self.restrain(joints, threads, is_weighed);
        self.dissipate(threads, settings.iterations);
        if substep == 0 {
            self.half_steps.halve_start(self.joint_energy.slots(), &mut self.velocities);
        }
        self.joints.end_substep(threads);
        self.bounds.add_loads();
        self.wraps.add_loads();
        self.taut.add_loads();
        if is_last {
            self.planes.fit_velocities(&mut self.velocities, &self.motions, &self.poses, h);
        }
        self.find_impacts(settings.restitution_threshold);
        self.advance(threads, h);
        self.followed.mark(&self.motions);
        self.joints.left -= h;
        self.wraps.project(&self.velocities, &mut self.motions);
        self.bounds.project(&self.velocities, &mut self.motions, h);
        self.taut.project(&self.bounds, &self.velocities, &mut self.motions, h);
        if self.mesh.is_one() {
            self.push_sheet(threads);
        } else {
            self.joints.project(joints, threads, &mut self.velocities, &mut self.motions, h);
        }
        if is_last {
            self.flatten();
        }
        self.settle(joints, threads, false);
        self.followed.add_up(&self.motions);
        if !is_last {
            self.rebound(settings.restitution_threshold);
        }
    }

    /// Closes joints, recovers positions, and reads out multipliers and residuals.
    fn end_step(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, settings: &StepSettings, h: f32) {
        self.followed.mark(&self.motions);
        if self.mesh.is_one() {
            self.joints.end_course(threads);
        } else {
            self.close_joints(joints, threads, h);
        }
        self.rebound(settings.restitution_threshold);
        self.slides.find(&self.contacts, &self.velocities, &self.motions, (h, settings.substeps));
        self.recover_positions(threads, settings.dt);
        self.settle(joints, threads, true);
        self.half_steps.tell(self.joint_energy.slots(), &mut self.velocities, &self.motions);
        self.followed.add_up(&self.motions);
        self.followed
            .tell(&mut self.velocities, &self.motions, settings.dt, |slot, change| self.half_steps.add_lead(slot, change));
        if let Some(limits) = &settings.limits {
            contact_kernels::tell(&mut self.contacts, &self.velocities, limits, &mut self.told);
        }
        self.joints.store(joints, threads, &self.motions);
        self.bounds.store();
        self.taut.store();
        let swept_gap = self.joints.worst_gap(joints, threads, &self.motions);
        let direct_gap = self.direct.joint_gap(joints, &self.motions, threads);
        self.joint_gap = direct_gap.max(swept_gap).max(self.newton.joint_gap(joints));
    }

    /// Lets points that have hit something in the substep leave again, and adds up its multipliers.
    fn rebound(&mut self, threshold: f32) {
        self.apply_impacts();
        contact_kernels::restitute(&mut self.contacts, &mut self.velocities, threshold);
        self.add_to_tally();
        self.contacts.end_blows();
        self.forget_impacts();
    }

    /// Warm start and sweeps of a substep of length `h`.
    fn sweep_all(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32, iterations: u32, substep: u32) {
        self.joints.warm_start(threads, &mut self.velocities);
        self.bounds.warm_start(&mut self.velocities);
        self.wraps.begin_substep(&mut self.velocities, &self.motions, h);
        let is_carried = self.carry.is_on() && substep > 0;
        // Levers are those of the start of the step.
        let middle = (substep as f32 + 0.5) * h;
        if !is_carried {
            self.start_sweeps(threads, h, middle);
        }
        let (direct, floor) = self.direct_and_floor(threads);
        direct.warm_start(floor, iterations);
        self.pass_loads(threads);
        self.solve_exactly();
        for iteration in 0..iterations {
            let is_last = iteration + 1 == iterations;
            if iteration > 0 && is_last {
                self.prepare_joints(joints, threads, h, true, iterations >= LONG_SUBSTEP);
            }
            if iteration % 2 == 0 {
                self.wraps.sweep(&mut self.velocities, false);
                self.bounds.sweep(&mut self.velocities, false);
                self.taut.sweep(&mut self.velocities, false);
                self.sweep_articulations(threads);
                self.joints.sweep(threads, &mut self.velocities, false);
                if is_carried && iteration == 0 {
                    self.sweep_anew(threads, h, is_last);
                } else {
                    self.sweep_contacts(threads, false, is_last);
                }
            } else {
                self.sweep_contacts(threads, true, is_last);
                self.joints.sweep(threads, &mut self.velocities, true);
                self.sweep_articulations(threads);
                self.taut.sweep(&mut self.velocities, true);
                self.bounds.sweep(&mut self.velocities, true);
                self.wraps.sweep(&mut self.velocities, true);
            }
        }
    }

    /// The articulations, and what those that are swept work on.
    pub(crate) fn direct_and_floor<'a>(&'a mut self, threads: &'a Workers) -> (&'a mut Direct, SolveContext<'a>) {
        let Self { direct, velocities, motions, .. } = self;
        (direct, SolveContext { threads, velocities, motions })
    }

    fn sweep_articulations(&mut self, threads: &Workers) {
        let (direct, floor) = self.direct_and_floor(threads);
        direct.sweep(floor);
    }

    /// Whether articulations have moved all bodies through the step, and nothing is left to solve.
    fn is_done(&self) -> bool {
        self.contacts.is_empty() && self.motions[1..].iter().all(|motion| motion.direct)
    }

    /// Gives contacts that are born under load their static multipliers.
    fn start_contacts(&mut self, threads: &Workers, gravity: glam::Vec3, h: f32) {
        let mut initial_impulses = std::mem::take(&mut self.initial_impulses);
        initial_impulses.start_contacts(self, threads, gravity, h);
        self.initial_impulses = initial_impulses;
    }

    fn prepare_momentum_pass(&mut self, threads: &Workers, gravity: glam::Vec3, h: f32) {
        let mut pass = std::mem::take(&mut self.momentum_pass);
        pass.prepare(self, threads, gravity, h);
        self.momentum_pass = pass;
    }

    /// Hands what the substep has left unbalanced in stacks down to the ground.
    fn pass_loads(&mut self, threads: &Workers) {
        if self.momentum_pass.is_idle() {
            return;
        }
        let mut pass = std::mem::take(&mut self.momentum_pass);
        pass.apply(self, threads);
        self.momentum_pass = pass;
    }

    fn prepare_exact(&mut self, gravity: glam::Vec3, h: f32) {
        let mut contact_newton = std::mem::take(&mut self.contact_newton);
        contact_newton.prepare(self, gravity, h);
        self.contact_newton = contact_newton;
    }

    /// Solves contacts of small islands in which the heavy stands on the light.
    fn solve_exactly(&mut self) {
        if self.contact_newton.is_idle() {
            return;
        }
        let mut contact_newton = std::mem::take(&mut self.contact_newton);
        contact_newton.apply(self);
        self.contact_newton = contact_newton;
    }

    /// Builds rows of joints at the poses predicted by now, and those of bounds and taut lines; `again` where they have been built in
    /// this substep, and `bounds_too` where those of bounds are to be built anew with them.
    fn prepare_joints(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32, again: bool, bounds_too: bool) {
        let Self { poses, velocities, motions, bounds, .. } = self;
        if self.joints.entries.is_empty() {
            return;
        }
        poses.predict(threads, velocities, motions, h);
        self.joints.prepare(
            joints,
            threads,
            &MovingBodies { velocities, motions, predicted_poses: &poses.predicted_poses },
            h,
            again,
        );
        if bounds_too {
            bounds.prepare(velocities, motions, &poses.predicted_poses, h, again);
            self.taut.prepare(bounds, velocities, motions, &poses.predicted_poses, h);
        }
    }

    /// Finds the inertia of bodies as they stand now, where sums of their angular momentum are asked for.
    fn find_inertia(&mut self) {
        if !self.free.is_empty() || !self.planes.entries.is_empty() {
            self.poses.find_inertia(&self.motions);
        }
    }

    /// Sweeps position rows on where joints are left ajar.
    fn close_joints(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32) {
        let end = self.moving() + 1;
        let Self { joints: own, planes, poses, velocities, motions, body_flags, islands, closing, .. } = self;
        closing.close(
            &mut OpenJoints { joints: own, all: joints, planes, poses, velocities, motions, body_flags, islands, end },
            threads,
            h,
        );
    }

    /// Puts hinge chains back into their planes.
    fn flatten(&mut self) {
        if !self.planes.entries.is_empty() {
            self.planes.project(&mut self.velocities, &mut self.motions, &mut self.poses);
        }
    }

    /// Takes errors of articulations out of positions, and restores the angular momentum of islands that nothing holds.
    fn settle(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, is_end: bool) {
        let (direct, floor) = self.direct_and_floor(threads);
        direct.settle(joints, floor, is_end);
        if !self.free.is_empty() {
            self.poses.find_inertia(&self.motions);
            let Self { free, velocities, motions, poses, impacts, islands, .. } = self;
            free.restore(velocities, motions, poses, |slot| !is_end && impacts.has_struck(islands, slot));
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

    /// Begins a substep of length `h` (s), one of so many.
    fn apply_forces(&mut self, joints: &Pool<Joint, JointId>, threads: &Workers, h: f32, substep: u32, substeps: u32) {
        if self.carry.is_on() {
            if self.apply_forces_and_carry(threads, h, substep == 0) {
                parallel_contacts::refresh_masses(&mut self.contacts, threads, &self.velocities, &self.motions);
            }
            return;
        }
        // What is cut off of a speed is momentum too, where that is noted.
        let is_noted = !self.free.is_empty();
        // What joints hold may be refreshed elsewhere.
        let refreshes = AtomicBool::new(!self.joint_slots.is_empty());
        self.each_single(threads, |velocity, motion| {
            integrate::apply_forces(velocity, motion, h);
            if motion.refreshed {
                refreshes.store(true, Ordering::Relaxed);
            }
            if !is_noted {
                integrate::limit_speeds(velocity, motion);
            }
        });
        self.poses.apply_forces(threads, &mut self.velocities, &self.motions, h);
        self.find_inertia();
        if is_noted {
            self.free.note(&self.velocities, &self.motions, &self.poses, |_| true);
            self.each_single(threads, |velocity, motion| integrate::limit_speeds(velocity, motion));
        }
        self.poses.limit_speeds(threads, &mut self.velocities);
        self.contact_energy.note_energy(&self.velocities, &self.motions, &self.poses);
        let (direct, floor) = self.direct_and_floor(threads);
        direct.couple(joints, floor, h, h * (substeps - substep) as f32);
        self.contact_energy.note_velocities(&self.velocities);
        if !self.contacts.is_empty() && refreshes.into_inner() && self.motions.iter().any(|motion| motion.refreshed) {
            parallel_contacts::refresh_masses(&mut self.contacts, threads, &self.velocities, &self.motions);
        }
    }

    /// Applies the multipliers that contacts have carried on, and looks how far their surfaces are apart by now.
    fn start_sweeps(&mut self, threads: &Workers, h: f32, middle: f32) {
        let (range, moving, motions) = (0..self.contacts.len(), self.moving(), &self.motions);
        parallel_contacts::in_colors(
            &mut self.contacts,
            range,
            threads,
            (&mut self.velocities, moving),
            false,
            |part, velocities| {
                contact_kernels::warm_start(part, velocities, motions, h, middle);
            },
        );
    }

    /// The first sweep of a substep over contacts whose bodies carry what they have done; looks how far their surfaces are apart by now.
    fn sweep_anew(&mut self, threads: &Workers, h: f32, is_last: bool) {
        let presses_last = is_last || !self.reverses_rows();
        let (range, moving, motions) = (0..self.contacts.len(), self.moving(), &self.motions);
        parallel_contacts::in_colors(
            &mut self.contacts,
            range,
            threads,
            (&mut self.velocities, moving),
            false,
            |part, velocities| {
                contact_kernels::sweep_anew(part, velocities, motions, h, presses_last);
            },
        );
    }

    /// One sweep over the contacts, or backwards, all in the opposite order.
    fn sweep_contacts(&mut self, threads: &Workers, backwards: bool, is_last: bool) {
        let moving = self.moving();
        let presses_last = is_last || !self.reverses_rows();
        parallel_contacts::sweep(
            &mut self.contacts,
            self.first_jointed,
            threads,
            (&mut self.velocities, moving),
            backwards,
            presses_last,
        );
    }

    /// Whether sweeps go through the rows of each manifold in opposite orders on their two ways.
    ///
    /// Only then are the two one symmetric operator, and slow waves of load do not grow. Such waves are of large islands. In small ones friction
    /// comes before the normal rows on both ways: with two visits it then sees twice what these have made of the load, not once.
    fn reverses_rows(&self) -> bool {
        self.islands.len() == 1 && self.moving() >= body_warm_start::MIN_BODIES
    }

    fn advance(&mut self, threads: &Workers, h: f32) {
        if self.carry.is_on() {
            self.keep_changes(threads);
        }
        self.each_alone(threads, |velocity, motion| integrate::advance(velocity, motion, h));
        let moving = self.moving();
        self.poses.advance(threads, (&mut self.velocities, &mut self.motions, moving), h);
    }
}
