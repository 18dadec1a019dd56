//! Spins as rows see them of bodies whose axes a substep smears.
//!
//! Rows answer with Ĩ, in which an axis that turns by θ in a substep is no lighter than θ² of the heaviest (*integrate.rs*). A body has I. With
//!
//! ```text
//! K = √(I Ĩ⁻¹) in principal axes,    ω̂ = K ω:    ½ ω̂·Ĩ ω̂ = ½ ω·I ω
//! ```
//!
//! so rows that take energy of ω̂ with Ĩ take as much of the body. Were they shown ω itself, they would take a spin about a light axis for one
//! with Ĩ: a stick of 1:80 that goes round its length at 700 rad/s has next to no energy in that, and of what sweeps believed to take from it they
//! gave the stick ten times as much across.

use glam::{DMat3, DVec3, Vec3};

use super::state::{BodyMotion, BodyVelocity, Constraints, Symmetric};

/// A body whose axes are smeared.
#[derive(Debug, Clone, Copy)]
struct SmearedSpin {
    slot: usize,
    /// Its angular velocity, and the one that rows see (rad/s).
    own: Vec3,
    seen: Vec3,
    /// K⁻¹ in world axes.
    back: DMat3,
}

/// Those of a batch in a substep, by slot.
#[derive(Debug, Default)]
pub(crate) struct SmearedSpins {
    list: Vec<SmearedSpin>,
}

impl SmearedSpins {
    /// Begins a substep; `may_be` says whether the axes of any body may be smeared in it.
    pub(crate) fn find(&mut self, may_be: bool, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        self.list.clear();
        if may_be {
            let smeared = velocities.iter().zip(motions).zip(0..).filter(|((_, motion), _)| is_seen_smeared(motion));
            self.list.extend(smeared.map(|((velocity, motion), slot)| SmearedSpin::of(slot, velocity, motion)));
        }
    }

    /// Shows rows what they are to see of the bodies of these slots.
    pub(crate) fn show(&self, velocities: &mut [BodyVelocity], slots: impl Fn(usize) -> bool) {
        for spin in self.list.iter().filter(|spin| slots(spin.slot)) {
            velocities[spin.slot].angular = spin.seen;
        }
    }

    /// Gives bodies of these slots what rows have made of their spins.
    pub(crate) fn give_back(&self, velocities: &mut [BodyVelocity], slots: impl Fn(usize) -> bool) {
        for spin in self.list.iter().filter(|spin| slots(spin.slot)) {
            let velocity = &mut velocities[spin.slot];
            let change = velocity.angular.as_dvec3() - spin.seen.as_dvec3();
            velocity.angular = (spin.own.as_dvec3() + spin.back * change).as_vec3();
        }
    }

    /// What rows have not been shown of the spin of a slot at the start of the substep (rad/s).
    pub(crate) fn hidden(&self, slot: u32) -> DVec3 {
        let place = self.list.binary_search_by_key(&(slot as usize), |spin| spin.slot);
        place.map_or(DVec3::ZERO, |place| self.list[place].own.as_dvec3() - self.list[place].seen.as_dvec3())
    }
}

impl SmearedSpin {
    fn of(slot: usize, velocity: &BodyVelocity, motion: &BodyMotion) -> Self {
        let axes = DMat3::from_quat((motion.rotation * motion.inertia_frame).as_dquat().normalize());
        let answer = Symmetric::to_mat3(velocity.inverse_inertia).as_dmat3();
        let shares = DVec3::from_array(std::array::from_fn(|i| {
            let axis = axes.col(i);
            (axis.dot(answer * axis) * f64::from(motion.inertia[i])).sqrt().min(1.0)
        }));
        let in_world = |shares: DVec3| axes * DMat3::from_diagonal(shares) * axes.transpose();
        let seen = (in_world(shares) * velocity.angular.as_dvec3()).as_vec3();
        Self { slot, own: velocity.angular, seen, back: in_world(shares.recip()) }
    }
}

/// Whether contacts alone act on a body whose axes are smeared.
fn is_seen_smeared(motion: &BodyMotion) -> bool {
    motion.world_inertia.smeared
        && !motion.jointed
        && !motion.direct
        && motion.constraints != Constraints::None
        && motion.is_free_to_turn()
}
