//! Momentum of a free articulation.
//!
//! Joints act and react, so they change neither momentum; but geometric stiffness turns bodies without an opposite, and mended
//! positions carry momentum along. What a substep so changes of the angular momentum about the common centre of mass is given back
//! as one rotation of the whole articulation, ω = I⁻¹ ΔL: joints do not feel it, as J v = 0 for every rigid motion.

use glam::{DMat3, DVec3};

use super::body::DirectBody;
use crate::solve::joint::Stance;
use crate::solve::joint::rows::Rate;

/// Centre, angular momentum and inertia of a group of bodies.
pub(crate) struct Momentum {
    center: DVec3,
    /// About the centre (N·m·s).
    pub angular: DVec3,
    /// About the centre (kg·m²).
    inertia: DMat3,
}

impl Momentum {
    /// Of bodies that stood at `origins` (m) at the start of the step; `None` unless all of them move freely.
    pub(crate) fn of(bodies: &[DirectBody], origins: &[DVec3], stances: &[Stance], rates: &[Rate]) -> Option<Self> {
        let all = || bodies.iter().zip(origins).zip(stances.iter().zip(rates)).skip(1);
        let (mut mass, mut weighted, mut momentum) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for ((body, &origin), (stance, rate)) in all() {
            let own = body.free_mass()?;
            mass += own;
            weighted += own * (origin - origins[1] + stance.0);
            momentum += own * rate.linear;
        }
        let (center, velocity) = (weighted / mass, momentum / mass);
        let (mut angular, mut inertia) = (DVec3::ZERO, DMat3::ZERO);
        for ((body, &origin), (stance, rate)) in all() {
            let own = body.free_mass()?;
            let arm = origin - origins[1] + stance.0 - center;
            let (spin, own_inertia) = body.spin_momentum(stance, rate);
            angular += spin + own * arm.cross(rate.linear - velocity);
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            inertia += own_inertia + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * own;
        }
        Some(Self { center: center + origins[1], angular, inertia })
    }

    /// Adds `missing` angular momentum to the rates of these bodies as one rotation of all.
    pub(crate) fn give_back(
        &self,
        missing: DVec3,
        bodies: &[DirectBody],
        origins: &[DVec3],
        stances: &[Stance],
        rates: &mut [Rate],
    ) {
        let spin = self.inertia.inverse() * missing;
        if !spin.is_finite() {
            return;
        }
        for i in (0..bodies.len()).filter(|&i| bodies[i].is_dynamic()) {
            let arm = origins[i] + stances[i].0 - self.center;
            rates[i].linear += spin.cross(arm);
            rates[i].angular += spin;
        }
    }
}
