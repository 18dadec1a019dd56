//! Bodies of an island as its problem knows them.

use glam::{DMat3, DVec3};

use super::problem::BodyMass;
use crate::solve::direct::body::DirectBody;
use crate::solve::joint::LocalPose;

/// Mass of a body with its damping; locked axes have one that nothing pushes.
pub(super) fn mass_of(body: &DirectBody, stance: &LocalPose, h: f64) -> BodyMass {
    let free = body.free_axes();
    let inverse = body.inverse_mass.to_array();
    // Locked axes have the mass of those that are not: nothing moves along them, but how light a body is at its lightest is asked.
    let own = body.mass().unwrap_or(1.0);
    let linear = std::array::from_fn(|i| if free[i] == 0.0 { own } else { 1.0 / inverse[i] });
    let inertia = body.inertia_at(stance) * body.weights(h)[1];
    let turning = DVec3::new(free[3], free[4], free[5]);
    if turning == DVec3::ONE {
        return BodyMass { linear, angular: inertia.to_cols_array_2d(), ..BodyMass::default() };
    }
    let only = DMat3::from_diagonal(turning);
    let angular = only * inertia * only + DMat3::from_diagonal(DVec3::ONE - turning);
    BodyMass { linear, angular: angular.to_cols_array_2d(), ..BodyMass::default() }
}
