//! Joint meshes (sheets and lattices): sweeps along conjugate directions, continued until they converge.
//!
//! A sheet of n × n bodies is too much work for the direct solve, has no derived bounds, and needs some n² sweeps: its lower part falls
//! until the load has come up to what holds it. A net of 100 × 100 balls that hung by seven of them fell for a second under two sweeps
//! a substep and tore its joints open by more than their levers; such gaps then made velocities that no further sweep took out. So here
//! sweeps are the preconditioner of a method that needs some n of them.
//!
//! **What is minimised.** All rows here are equations. With v* the velocities that forces leave, λ the multipliers, b the biases of the
//! rows and v = v* + M⁻¹ Jᵀ λ, rows hold, J v + b = 0, where
//!
//! ```text
//! F(λ) = ½ vᵀ M v + bᵀ λ
//! ```
//!
//! is least: its gradient is J v + b. b is of second order, so F is nearly the kinetic energy T, and the error that is left is nearly the
//! kinetic energy above the least.
//!
//! **Sweeps.** A forward and a backward sweep change (v, λ) by d: that is a symmetric preconditioner applied to the gradient. With p the
//! change before that, the next point is the least of F over both directions,
//!
//! ```text
//! p ← α d + β p,    | dᵀM d   dᵀM p | | α |     | vᵀM d + bᵀ d |
//!                   | dᵀM p   pᵀM p | | β | = − | vᵀM p + bᵀ p |,
//! ```
//!
//! where d and p stand for changes of velocities beside M and for changes of multipliers beside b. On one system this is the
//! method of conjugate gradients (Hestenes, Stiefel 1952; in this form, which does not trust what was computed before, Takahashi
//! 1965). p goes on from substep to substep and from step to step, while systems change. Moves end once one lowers F by less than
//! a share (`ENOUGH`) of the energy that forces add to the sheet at rest and of a share (`SHARE_OF_MOTION`) of the energy that it
//! has.
//!
//! **Between substeps** joints keep p as multipliers, and its velocities are computed anew from the rows of each substep. Any p is a valid
//! direction, so a stale one costs sweeps and no accuracy.
//!
//! **Carried multipliers** λ₀ are those that the load needs again, plus those that took out an error of the last substep. Applying the
//! second part again puts the error back with the other sign: it rings, as if the joints were springs. So λ₀ is scaled to add no energy:
//! with w = M⁻¹ Jᵀ λ₀, T of v* + s w is least at s* = −v*ᵀ M w/(wᵀ M w), is back at its first value at 2 s*, and s = min(1, 2 s*). From
//! there on F only falls.
//!
//! **Energy.** So T(v) is at most T(v*); but from rest, where v* = h a, that lets a whole sheet rise at h a/2 for ever, since
//! T(−h a/2) = T(−h a/2 + h a). The work of forces in a substep is h aᵀ M (v₀ + v)/2, of the velocities v₀ before forces and v after all
//! rows, and T(v) is at most T(v₀) and that: with c = h a/2,
//!
//! ```text
//! T(v − c) ≤ T(v* − c),
//! ```
//!
//! an equality where rows hold before and after. Where it fails, v is slowed to the share of it at which it holds. A sheet that nothing
//! holds is not slowed: it keeps its momentum.
//!
//! **Position errors** C at the start of a substep are corrected by displacements δ with J δ = −C. One forward and one backward sweep over
//! the same rows find δ, and it is added once bodies have moved. Velocities do not change.

use glam::Vec3;

use super::batch::Batch;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::search_direction::{BodyDirections, Products};
use crate::joint_graph::mesh::is_sheet;
use crate::tight_vec::resize;
use crate::workers::Workers;

/// Most moves (a forward and a backward sweep each) in a substep: a sheet that is let go takes that many for some steps, one that hangs
/// one to three.
const MAX_MOVES: u32 = 16;

/// Substeps that a sheet takes at least: in fewer it needs so many more moves that they take longer and leave more.
const MIN_SUBSTEPS: u32 = 4;

/// Share of the energy that forces add to the sheet at rest. A move that lowers F by less is the last one.
const ENOUGH: f64 = 0.01;

/// Share of the energy that the sheet has which counts as if forces had added it.
const SHARE_OF_MOTION: f64 = 1.0e-4;

/// Determinant of the two by two system, over dᵀM d · pᵀM p, above which d and p count as linearly independent.
const TWO_LINES: f64 = 1.0e-6;

/// The sheet of a batch, if it is one.
#[derive(Debug, Default)]
pub(crate) struct JointMesh {
    is_one: bool,
    search: BodyDirections,
    /// Displacements δ of the bodies that correct position errors, by slot.
    pushes: Vec<BodyVelocity>,
    /// Buffer: a sum for each piece of the bodies that a thread takes.
    sums: Vec<[f64; 3]>,
}

impl JointMesh {
    /// Whether the batch is one sheet.
    pub(crate) fn is_one(&self) -> bool {
        self.is_one
    }

    /// Forgets the batch of the last step.
    pub(crate) fn clear(&mut self) {
        self.is_one = false;
    }

    /// Finds out whether the batch is one sheet, and nothing else; `is_passive` says that nothing gives it energy.
    pub(crate) fn prepare(&mut self, batch: &mut Batch, threads: &Workers, is_passive: bool) {
        let bodies = batch.motions.len() - 1;
        let has_other_rows =
            !batch.contacts.is_empty() || !batch.long_range.bounds.entries.is_empty() || !batch.planes.entries.is_empty();
        self.is_one = is_sheet(batch.joints.entries.len(), bodies)
            && batch.islands.len() == 1
            && is_passive
            && batch.joints.are_all_in_lanes()
            && !has_other_rows;
        if self.is_one {
            batch.joints.begin_course(threads);
        }
    }

    /// Warm start and sweeps of a substep of length `h` (s), from velocities to which forces have been added; `noted` are those without
    /// forces. Returns whether `batch.poses` has the kinetic energies of the velocities that it ends with.
    pub(crate) fn solve(&mut self, batch: &mut Batch, noted: &[BodyVelocity], threads: &Workers, h: f32) -> bool {
        let moving = batch.moving();
        let Self { search, sums, pushes, .. } = self;
        let Batch { poses, joints, velocities, motions, free, .. } = batch;
        poses.begin_course(search, threads, velocities, motions);
        let [added, had, _] = sum(threads, sums, motions, |slot, motion| {
            let gain = motion.acceleration * h;
            let added = 0.5 * f64::from(gain.length_squared() / velocities[slot].inverse_mass.x);
            [added, f64::from(poses.energies[slot]), 0.0]
        });
        let enough = ENOUGH * (added + SHARE_OF_MOTION * had);

        resize(pushes, velocities.len(), BodyVelocity::FIXED);
        threads.share(pushes.chunks_mut(PIECE).zip(velocities.chunks(PIECE)), |(pushes, velocities)| {
            pushes.iter_mut().zip(velocities).for_each(|(push, velocity)| *push = velocity.at_rest());
        });
        joints.apply_way(threads, pushes);
        poses.take_way(search, threads, pushes);
        threads.share(pushes.chunks_mut(PIECE), |pushes| {
            pushes.iter_mut().for_each(|push| (push.linear, push.angular) = (Vec3::ZERO, Vec3::ZERO));
        });
        joints.push(threads, pushes, h);

        poses.note_course(search, threads, velocities);
        joints.warm_start(threads, velocities);
        let Products { dd, vd, .. } = poses.weigh_course(search, threads, velocities);
        if -2.0 * vd < dd {
            let share = (-2.0 * vd / dd).max(0.0) as f32;
            joints.scale_impulses(share);
            for (velocity, before) in velocities.iter_mut().zip(noted) {
                velocity.linear = before.linear + (velocity.linear - before.linear) * share;
                velocity.angular = before.angular + (velocity.angular - before.angular) * share;
            }
        }

        for _ in 0..MAX_MOVES {
            poses.note_course(search, threads, velocities);
            let bias = joints.sweep_course(threads, velocities);
            let (shares, fall) = least(&poses.weigh_course(search, threads, velocities), bias);
            let shares = shares.map(|share| share as f32);
            joints.steer_course(threads, shares);
            poses.steer_course(search, threads, (&mut *velocities, moving), shares);
            if fall.is_nan() || fall <= enough {
                break;
            }
        }
        free.is_empty() && !self.slow(batch, noted, threads, h, had)
    }

    /// Corrects positions by the displacements found when the substep began.
    pub(crate) fn displace(&self, batch: &mut Batch, threads: &Workers) {
        batch.poses.displace(threads, &mut batch.motions, &self.pushes);
    }

    /// Slows the sheet where it has more energy than forces have given it: T(v − c) > T(v* − c), see the [module](self). `had` is T(v*).
    /// Returns whether the sheet was slowed; `poses.energies` are then those before.
    fn slow(&mut self, batch: &mut Batch, noted: &[BodyVelocity], threads: &Workers, h: f32, had: f64) -> bool {
        let Self { sums, .. } = self;
        let Batch { poses, velocities, motions, .. } = batch;
        poses.find_energies(threads, velocities, motions);
        let [has, given, taken] = sum(threads, sums, motions, |slot, motion| {
            let half_gain = motion.acceleration * (0.5 * h / velocities[slot].inverse_mass.x);
            let half_spin = motion.torque * (0.5 * h);
            let product = |v: &BodyVelocity| f64::from(half_gain.dot(v.linear) + half_spin.dot(v.angular));
            [f64::from(poses.energies[slot]), product(&velocities[slot]), product(&noted[slot])]
        });
        let allowed = had - taken;
        let is_too_much = has - given > allowed;
        if is_too_much {
            let root = (given * given + 4.0 * has * allowed).max(0.0).sqrt();
            let kept = ((given + root) / (2.0 * has)).clamp(0.0, 1.0) as f32;
            for velocity in velocities.iter_mut() {
                velocity.linear *= kept;
                velocity.angular *= kept;
            }
        }
        is_too_much
    }
}

/// Factors α of d and β of p at which F is least, and what it falls by.
fn least(products: &Products, bias: [f64; 2]) -> ([f64; 2], f64) {
    let Products { dd, dp, pp, vd, vp } = *products;
    let (along_d, along_p) = (vd + bias[0], vp + bias[1]);
    let determinant = dd * pp - dp * dp;
    let shares = if determinant > TWO_LINES * dd * pp {
        [(dp * along_p - pp * along_d) / determinant, (dp * along_d - dd * along_p) / determinant]
    } else if dd > 0.0 {
        [-along_d / dd, 0.0]
    } else {
        [0.0; 2]
    };
    (shares, -0.5 * (shares[0] * along_d + shares[1] * along_p))
}

/// Bodies in a piece of work. Each piece has its own sum, so that the bits do not depend on the number of threads.
const PIECE: usize = 512;

/// Sum of three numbers over the bodies that move; `sums` is a buffer.
fn sum(
    threads: &Workers,
    sums: &mut Vec<[f64; 3]>,
    motions: &[BodyMotion],
    of: impl Fn(usize, &BodyMotion) -> [f64; 3] + Sync,
) -> [f64; 3] {
    let add = |[a, b, c]: [f64; 3], [x, y, z]: [f64; 3]| [a + x, b + y, c + z];
    sums.resize(motions.len().div_ceil(PIECE), [0.0; 3]);
    threads.share(sums.iter_mut().zip(motions.chunks(PIECE)).zip((0..).step_by(PIECE)), |((sum, motions), first)| {
        let moving = (first..).zip(motions).filter(|(_, motion)| motion.is_dynamic());
        *sum = moving.map(|(slot, motion)| of(slot, motion)).fold([0.0; 3], add);
    });
    sums.iter().copied().fold([0.0; 3], add)
}

impl Batch {
    /// Raises the substeps of a sheet to at least [`MIN_SUBSTEPS`], or to half of that where its motion is smooth; returns how many the
    /// batch takes. Rows are not laid out yet, so this goes by the lists of joints and manifolds.
    pub(crate) fn refine_sheet(&mut self, substeps: u32, is_smooth: impl FnOnce(&Self) -> bool) -> u32 {
        let is_one = is_sheet(self.joints.entries.len(), self.bodies.len() - 1)
            && self.islands.len() == 1
            && self.manifolds.ends.is_empty()
            && self.long_range.slots.is_empty()
            && self.planes.chains.is_empty();
        // Islands that take several substeps at once (a stride above one) have as many as they need.
        if !is_one || self.stride > 1.0 || substeps >= MIN_SUBSTEPS {
            return substeps;
        }
        let least = if is_smooth(self) { MIN_SUBSTEPS / 2 } else { MIN_SUBSTEPS };
        if substeps >= least {
            return substeps;
        }
        let share = substeps as f32 / least as f32;
        self.stride *= share;
        for entry in &mut self.joints.entries {
            entry.impulses = entry.impulses.scaled(share);
            entry.acted = entry.acted.map(|acted| acted * share);
        }
        least
    }
}
