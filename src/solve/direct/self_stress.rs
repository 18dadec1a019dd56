//! States of self-stress: loads of joints that hold one another up and move nothing, as four ropes of one platform have one and a truss
//! with a bar too many. Rows that repeat others leave the solution without them: three ropes bear all, and what they bear may be a push.
//!
//! With d a row that the factor has dropped, y = (e_d, −A_ff⁻¹ A_fd) is such a state: Jᵀ y = 0. Of all loads p + Σ c y that do the same
//! to the bodies, real ones take those that strain their bodies least. A bar of one material that pulls at a lever r from its middle is
//! as soft there as r²/m, so that
//!
//! ```text
//! c minimises Σ_k w_k |p_k|²,   w_k = Σ r²/m over both bodies of joint k.
//! ```

use glam::DVec3;

use super::block::{Lanes, ZERO};

/// Softness of a joint that no lever gives any, as a share of the greatest one.
const FLOOR: f64 = 1.0e-6;

/// States of self-stress, each orthogonal to those before it and of length 1 in the weights of the joints.
#[derive(Debug, Clone, Default)]
pub(super) struct SelfStresses {
    weights: Vec<f64>,
    states: Vec<DVec3>,
    /// Multipliers before a state is added to them.
    before: Vec<DVec3>,
}

impl SelfStresses {
    /// Forgets all states, for joints as soft as this (1/kg times m²).
    pub(super) fn start(&mut self, softness: impl Iterator<Item = f64>) {
        self.states.clear();
        self.weights.clear();
        self.weights.extend(softness);
        let floor = FLOOR * self.weights.iter().fold(0.0, |most: f64, &weight| most.max(weight));
        self.weights.iter_mut().for_each(|weight| *weight = weight.max(floor));
    }

    /// Notes the multipliers before a state is added to them.
    pub(super) fn note(&mut self, impulses: impl Iterator<Item = DVec3>) {
        self.before.clear();
        self.before.extend(impulses);
    }

    /// Adds the state by which the multipliers differ from those noted.
    pub(super) fn add(&mut self, impulses: impl Iterator<Item = DVec3>) {
        let (begin, joints) = (self.states.len(), self.weights.len());
        self.states.extend(impulses.zip(&self.before).map(|(impulse, before)| impulse - before));
        let (others, own) = self.states.split_at_mut(begin);
        // Twice is enough for them to be orthogonal to rounding.
        for other in others.chunks_exact(joints).chain(others.chunks_exact(joints)) {
            let share = dot(&self.weights, other, own.iter().copied());
            own.iter_mut().zip(other).for_each(|(own, other)| *own -= share * other);
        }
        let length = dot(&self.weights, own, own.iter().copied()).sqrt();
        if length.is_normal() {
            own.iter_mut().for_each(|own| *own /= length);
        } else {
            self.states.truncate(begin);
        }
    }

    /// Finds what to add to the multipliers so that they stress the joints least.
    pub(super) fn relax(&self, impulses: impl Iterator<Item = DVec3> + Clone, changes: &mut [Lanes]) {
        changes.fill(ZERO);
        for state in self.states.chunks_exact(self.weights.len()) {
            let share = dot(&self.weights, state, impulses.clone());
            for (change, part) in changes.iter_mut().zip(state) {
                (0..3).for_each(|i| change[i] -= share * part[i]);
            }
        }
    }
}

fn dot(weights: &[f64], a: &[DVec3], b: impl Iterator<Item = DVec3>) -> f64 {
    weights.iter().zip(a).zip(b).map(|((weight, a), b)| weight * a.dot(b)).sum()
}
