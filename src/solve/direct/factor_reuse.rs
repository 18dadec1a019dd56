//! Reuses the rows and the factor of a swept articulation for several substeps.
//!
//! A ragdoll in a heap hardly turns within a step, so that its rows, their factor and the inertia that answers stay as the first
//! substep has found them, as those of contacts do. What changes is how far stops are: it follows from the way since the last
//! substep, to first order. Rows last while
//!
//! - all joints hold points or frames together rigidly, or drive at a steady speed: nothing else in a row of a safe substep depends on
//!   where the bodies are;
//! - no body has turned by more than [`LASTING_TURN`] since they were built. A row that turns by θ leaves a gap of θ²/2 of its lever,
//!   most of which is given back as its gradient is that of halfway;
//! - no joint's force is so great that its geometric stiffness matters, κ below [`LASTING_STIFFNESS`]: that would have to follow it.
//!
//! While they last positions are not looked at either, until the end of the step. Errors are taken out then, and after each substep in
//! which a body has turned too far, with the factor of the same rows, stops that press and motors that hold among them; what that cannot
//! mend, a stop that is overrun without pressing, is left to rows built anew.

use glam::{DVec3, Vec3};

use super::articulation::Articulation;
use super::articulation_state::ReusedFactor;
use super::project::{Errors, greater, greatest};
use super::topology::NodeBodies;
use crate::id::{JointId, Pool};
use crate::joint::{JointKind, Limits, Motor, SphericalMotor};
use crate::joint_record::Joint;
use crate::linalg::narrowing;
use crate::solve::disjoint::Slots;
use crate::solve::joint::kinds;
use crate::solve::joint::rows::Rate;
use crate::solve::joint::{JointEntry, LocalPose};
use crate::solve::rotation;
use crate::solve::state::{BodyMotion, BodyVelocity};

/// Rotation of a body up to which rows last (rad): gaps of 2e-4 of a lever, of which positions may keep 5e-4.
const LASTING_TURN: f32 = 0.02;

/// Transverse stiffness κ of a joint up to which rows last.
const LASTING_STIFFNESS: f64 = 0.5;

/// Errors over the articulation's size that lasting rows mend: below, there is nothing to mend; beyond, what is left is of the order of
/// the error's square.
const NEGLIGIBLE: f64 = 1.0e-4;
const LINEAR: f64 = 0.05;

/// Times that they mend them at most, and share of an error that may be left for them to go on.
pub(super) const MENDINGS: usize = 2;
const MUST_FALL: f64 = 0.3;

/// Share of an angle that rows may leave unseen: what bodies turn by in a substep, mostly.
const MAX_OFF: f64 = 0.1;

/// Errors that positions end a step with, and whether lasting rows mend them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settling {
    pub errors: Errors,
    pub mends: bool,
}

impl Articulation {
    /// Whether its joints are such that rows can last.
    fn is_lasting_kind(&self, joints: &Pool<Joint, JointId>) -> bool {
        !self.is_points
            && self.entries.iter().all(|entry| {
                let joint = &joints[entry.joint];
                let def = &joint.def;
                let holds = match &def.kind {
                    JointKind::Fixed => true,
                    JointKind::Hinge { limits, motor } => match motor {
                        Motor::Off => true,
                        Motor::Velocity { .. } => *limits == Limits::NONE,
                        Motor::Position { .. } | Motor::Drive(_) => false,
                    },
                    JointKind::Spherical { motor, .. } => !matches!(motor, SphericalMotor::Position { .. }),
                    JointKind::Distance { .. } | JointKind::Prismatic { .. } | JointKind::Generic { .. } => false,
                };
                // A stop that is met and left again changes what its row asks for.
                holds && joint.drive.is_none() && def.restitution == 0.0 && kinds::gives_by_motors_alone(def)
            })
    }

    /// Notes where the bodies are as their rows are built, if those can last, and where they will be halfway between the start of this
    /// substep and that of the last one, `rest` (s) from the end of the step, if they go on as they do: gradients are taken there.
    /// Halfway through the rest of the step they would leave no gap, but angular momentum would be lost: forces act at the starts
    /// of substeps.
    pub(super) fn look_ahead(&mut self, joints: &Pool<Joint, JointId>, motions: &(impl Slots<BodyMotion> + ?Sized), rest: f64) {
        self.built.clear();
        self.predicted.clear();
        if !self.is_lasting_kind(joints) {
            return;
        }
        self.followed.clear();
        self.followed.extend(self.bodies.iter().map(|body| way_of(motions.get(body.slot))));
        self.built.extend(self.followed.iter().map(|[_, turn]| *turn));
        if self.lasting == ReusedFactor::Never {
            return;
        }
        self.lasting = ReusedFactor::Built;
        let most = f64::from(LASTING_TURN) / rest;
        if self.rates.iter().all(|rate| rate.angular.length_squared() <= most * most) {
            let h = 0.5 * (rest - self.h);
            let ahead =
                |(stance, rate): (&LocalPose, &Rate)| (stance.0 + rate.linear * h, rotation::rotated(stance.1, rate.angular * h));
            self.predicted.extend(self.local_poses.iter().zip(&self.rates).map(ahead));
        }
    }

    /// Notes at the end of a substep whether the rows last for the next; nothing moves in between but by velocities.
    pub(super) fn find_lasting(&mut self, motions: &(impl Slots<BodyMotion> + ?Sized)) -> bool {
        let still = self.lasting == ReusedFactor::Built
            && self.bodies.iter().zip(&self.built).all(|(body, &built)| {
                let motion = motions.get(body.slot);
                (motion.turn - built).length_squared() <= LASTING_TURN * LASTING_TURN
            })
            && self
                .eases
                .iter()
                .enumerate()
                .all(|(number, ease)| self.h * self.system.point_impulse(number) * ease <= LASTING_STIFFNESS);
        if still {
            self.lasting = ReusedFactor::Good;
        }
        still
    }

    /// Begins a substep with the rows of an earlier one.
    pub(super) fn go_on(
        &mut self,
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
    ) {
        self.take_rates(velocities);
        self.changes.clear();
        for (body, before) in self.bodies.iter().zip(&mut self.followed) {
            let now = way_of(motions.get(body.slot));
            let [way, turn] = std::mem::replace(before, now);
            self.changes.push(Rate { linear: (now[0] - way).as_dvec3() / self.h, angular: (now[1] - turn).as_dvec3() / self.h });
        }
        self.system.follow(&self.changes);
        self.answer_contacts(velocities, motions, false);
        self.lasting = ReusedFactor::Built;
    }

    /// Finds the errors of the positions, and asks the rows of the last substep to take them out where they are such as those can mend,
    /// and more than `least` (m).
    pub(super) fn ask_lasting_rows(&mut self, joints: &Pool<Joint, JointId>, least: f64) -> Settling {
        let mut errors = Errors::NONE;
        for number in 0..self.entries.len() {
            let [point, direction] = self.biases_of(number, joints);
            errors.add_joint(point, direction, &self.asked);
            self.system.take_errors(number, point, direction, &self.asked);
        }
        errors.judge(self.size);
        Settling { errors, mends: (least..LINEAR * self.size).contains(&errors.worst) }
    }

    /// Least error that lasting rows are asked to mend (m).
    pub(super) fn least_to_mend(&self) -> f64 {
        NEGLIGIBLE * self.size
    }

    /// Solves the rows of the last substep for what they have been asked for.
    pub(super) fn solve_lasting(&mut self) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), Rate { linear: DVec3::ZERO, angular: DVec3::ZERO });
        self.solve_lasting_rows();
    }

    /// Adds to the changes of the bodies what the rows of the last substep lack.
    pub(super) fn solve_lasting_rows(&mut self) {
        self.system.solve_lasting(&self.topology, &self.bodies, &mut self.changes);
    }

    /// Moves the bodies by what that solve has found, unless it leaves more than there was; what it leaves that is still noticeable the
    /// rows are asked for once more where they may be.
    pub(super) fn mend_with_lasting_rows(&mut self, joints: &Pool<Joint, JointId>, settling: &mut Settling, again: bool) {
        settling.mends = false;
        self.tried.clone_from(&self.local_poses);
        for ((body, stance), change) in self.bodies.iter().zip(&mut self.local_poses).zip(&self.changes) {
            body.displace(stance, change, 1.0);
        }
        // Points show by how much the rows have been off; directions are as near where they had not far to go.
        let mut left = Errors { gap: self.widest_gap(), angle: self.system.overrun(&self.changes), ..Errors::NONE };
        left.judge(self.size);
        if left.worst >= settling.errors.worst {
            self.local_poses.clone_from(&self.tried);
            return;
        }
        let (good, falls) = (self.good_enough(), left.worst < MUST_FALL * settling.errors.worst);
        let is_sure = left.worst <= good && settling.errors.angle * self.size * MAX_OFF <= good;
        settling.errors = left;
        if again && falls && !is_sure {
            *settling = self.ask_lasting_rows(joints, good);
        }
    }

    /// Whether it has the joints of another, between the same of its bodies, so that their systems have one structure.
    pub(super) fn is_twin(&self, other: &Self) -> bool {
        self.links == other.links && self.bodies.len() == other.bodies.len()
    }

    /// Whether its rows are solved beside those of its twins: not while it has a factor of its own, of rows that have changed their states.
    pub(super) fn goes_abreast(&self) -> bool {
        self.system.is_abreast || !self.system.is_factored
    }

    /// Greatest distance of joint points at the present poses, by components (m).
    fn widest_gap(&self) -> f64 {
        let gap = |(link, entry): (&NodeBodies, &JointEntry)| {
            let [a, b] = link.bodies.map(|body| &self.local_poses[body as usize]);
            greatest(entry.points(a, b).gap)
        };
        self.links.iter().zip(&self.entries).map(gap).fold(0.0, greater)
    }

    /// Lets contacts see the inertia that answers; `anew` where that has changed since the last substep.
    pub(super) fn answer_contacts(
        &mut self,
        velocities: &mut (impl Slots<BodyVelocity> + ?Sized),
        motions: &mut (impl Slots<BodyMotion> + ?Sized),
        anew: bool,
    ) {
        for (i, body) in self.bodies.iter().enumerate() {
            self.rates[i].angular = body.damped(&self.stiffness[i], &self.rates[i], 0.0);
            if body.is_dynamic() {
                let (velocity, motion) = (velocities.get_mut(body.slot), motions.get_mut(body.slot));
                velocity.angular = narrowing::speed(self.rates[i].angular);
                velocity.inverse_inertia = body.answer();
                motion.world_inertia.refreshed = anew;
            }
        }
    }
}

/// Way and turn of a body since the start of the step (m, rad).
fn way_of(motion: &BodyMotion) -> [Vec3; 2] {
    [motion.displacement, motion.turn]
}
