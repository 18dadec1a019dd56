//! When friction of a contact slides, and when it sticks.

use super::row::{Row, RowState};

/// Error below which a fixed row stays fixed (m/s, rad/s, or m and rad in a projection).
pub(super) const FREE_BELOW: f64 = 1.0e-10;

/// Change of sliding friction, over its size, that asks for another pass.
const CONE_TOLERANCE: f64 = 1.0e-2;

/// Revises a pair of friction rows against the radius of their cone; true if anything changed.
pub(super) fn revise_cone([u, v]: [&mut Row; 2], slip: [f64; 2], limit: f64, may_free: bool) -> bool {
    let size = length(u.impulse, v.impulse);
    if u.state == RowState::Free {
        if size <= limit {
            return false;
        }
        let share = limit / size;
        u.fix(u.impulse * share);
        v.fix(v.impulse * share);
        return true;
    }
    let speed = length(slip[0], slip[1]);
    let drives = u.impulse * slip[0] + v.impulse * slip[1] > FREE_BELOW * size;
    let starts = size == 0.0 && limit > 0.0 && speed > FREE_BELOW;
    if may_free && (drives || starts) {
        (u.state, v.state) = (RowState::Free, RowState::Free);
        return true;
    }
    let direction = if speed > FREE_BELOW {
        [-slip[0] / speed, -slip[1] / speed]
    } else if size > 0.0 {
        [u.impulse / size, v.impulse / size]
    } else {
        [0.0; 2]
    };
    // Halfway, as a full step turns past the direction that it looks for.
    let new = if size > 0.0 {
        let kept = [u.impulse / size, v.impulse / size];
        [0, 1].map(|i| 0.5 * (direction[i] + kept[i]) * limit)
    } else {
        direction.map(|share| share * limit)
    };
    let changed = length(new[0] - u.impulse, new[1] - v.impulse) > CONE_TOLERANCE * limit.max(size);
    u.fix(new[0]);
    v.fix(new[1]);
    changed
}

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
