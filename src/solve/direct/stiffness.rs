//! Geometric stiffness: how the force of a joint turns with the body that it acts on.
//!
//! A force f at lever r does the work f·(exp(θ) r − r) as the body turns by θ; its second derivative at θ = 0, negated, is
//!
//! ```text
//! G = (f·r) 1 − ½ (f rᵀ + r fᵀ)      (N·m; Tournier et al. 2015)
//! ```
//!
//! An implicit step of length h sees it as the inertia h² G, which is h times the same expression in the impulse h f. Tension in a
//! light link under a heavy weight is stiff beyond what any step resolves: κ = h² |f| |r| / I ≈ 50 for 1 kg under 10 t. With
//! I + h² G in place of I the step is stable at any κ; without it, it is unstable from κ ≈ 1.
//!
//! Compression has negative stiffness, which would take inertia away. Each body's sum is therefore shifted by its lowest
//! eigenvalue where that is negative: the step stays stable, and turns slower than it might.

use glam::{DMat3, DVec3};

use super::fours::Sym3x4;
use crate::lanes::four::Four;

/// Transverse stiffness κ of a joint below which a smooth substep takes its Jacobian at the start, and above which at the predicted
/// pose, with the geometric stiffness of its force.
pub(crate) const IMPLICIT_RANGE: (f64, f64) = (0.5, 2.0);

/// Newton steps towards the lowest eigenvalue.
const EIGENVALUE_STEPS: usize = 6;

/// Stiffness of an impulse (N·s) at a lever (m): as inertia (kg·m²) once multiplied by h (s).
pub(crate) fn of_impulse(impulse: DVec3, lever: DVec3) -> DMat3 {
    let (f, r) = (impulse, lever);
    let diagonal = DVec3::splat(f.dot(r)) - f * r;
    let across = |a: usize, b: usize| 0.0 - (f[a] * r[b] + r[a] * f[b]) * 0.5;
    let (xy, xz, yz) = (across(0, 1), across(0, 2), across(1, 2));
    DMat3::from_cols(DVec3::new(diagonal.x, xy, xz), DVec3::new(xy, diagonal.y, yz), DVec3::new(xz, yz, diagonal.z))
}

/// What joins [`of_impulse`] for a slender body with its length along `axis`, a unit vector, where its spin about that is counted apart
/// from how the axis turns.
///
/// The second derivative depends on the coordinates wherever there is a torque. With R = exp(θ) exp(φ a) and θ across a, it is that of the
/// rotation vector θ + φ a and ½ ((τ×a) aᵀ + a (τ×a)ᵀ), τ = r × f: a force at a lever along a never spins the body. With the rotation
/// vector alone, a rod that whips would be spun by half the torque times the turn, over the little that it weighs about its length.
pub(crate) fn about_axis(impulse: DVec3, lever: DVec3, axis: DVec3) -> DMat3 {
    let w = (impulse * lever.dot(axis) - lever * impulse.dot(axis)) * 0.5;
    let (xy, xz, yz) = (w.x * axis.y + w.y * axis.x, w.x * axis.z + w.z * axis.x, w.y * axis.z + w.z * axis.y);
    let diagonal = 2.0 * w * axis;
    DMat3::from_cols(DVec3::new(diagonal.x, xy, xz), DVec3::new(xy, diagonal.y, yz), DVec3::new(xz, yz, diagonal.z))
}

/// The same matrices with no negative eigenvalue, but for rounding and what a few Newton steps leave on the safe side.
///
/// p(λ) = det(A − λ) is convex and positive left of the lowest root, so that Newton's steps from a lower bound (Gershgorin's) never
/// pass it.
#[inline(always)]
pub(super) fn without_negative<F: Four>(g: Sym3x4<F>) -> Sym3x4<F> {
    let (mut lambda, [trace, minors, determinant]) = g.characteristic();
    let zero = F::splat(0.0);
    let mut open = lambda.below(zero);
    if !F::any(open) {
        return g;
    }
    for _ in 0..EIGENVALUE_STEPS {
        let value = ((trace - lambda) * lambda - minors) * lambda + determinant;
        let slope = (trace + trace - (lambda + lambda + lambda)) * lambda - minors;
        open = F::both(open, F::both(slope.below(zero), zero.below(value)));
        if !F::any(open) {
            break;
        }
        lambda = F::select(open, lambda - value / slope, lambda);
    }
    g.shifted(F::select(lambda.below(zero), -lambda, zero))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::lanes::four::Plain;

    #[test]
    fn tension_along_the_lever_stiffens_only_across_it() {
        let g = of_impulse(DVec3::new(0.0, -3.0, 0.0), DVec3::new(0.0, -0.5, 0.0));
        assert_eq!(g, DMat3::from_diagonal(DVec3::new(1.5, 0.0, 1.5)));
    }

    #[test]
    fn a_slender_body_has_the_stiffness_of_a_turn_of_its_axis_followed_by_a_spin() {
        let (axis, across) = (DVec3::Z, [DVec3::X, DVec3::Y]);
        let (force, lever) = (DVec3::new(3.0, -1.0, 5.0), DVec3::new(0.1, 0.2, 0.7));
        let work = |turn: DVec3| {
            let tilt = DQuat::from_scaled_axis(turn - axis * turn.dot(axis));
            force.dot(tilt * (DQuat::from_axis_angle(axis, turn.dot(axis)) * lever))
        };
        let found = of_impulse(force, lever) + about_axis(force, lever, axis);
        let step = 1.0e-4;
        for a in [axis, across[0], across[1]] {
            for b in [axis, across[0], across[1]] {
                let [more, less] =
                    [step, -step].map(|step| work((a + b) * step) - work(a * step) - work(b * step) + work(DVec3::ZERO));
                let expected = -0.5 * (more + less) / (step * step);
                let given = a.dot(found * b);
                assert!((given - expected).abs() < 1.0e-6, "{given} for {expected} N·m along {a} and {b}");
            }
        }
        let on_axis = of_impulse(force, axis) + about_axis(force, axis, axis);
        assert!((on_axis * axis).length() < 1.0e-12, "a force at the end of a rod spins it: {on_axis:?}");
    }

    /// Whether no principal minor is below `least`.
    fn is_positive(m: &DMat3, least: f64) -> bool {
        let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
        let minors = [a.x, b.y, c.z, a.x * b.y - a.y * a.y, b.y * c.z - b.z * b.z, a.x * c.z - a.z * a.z, m.determinant()];
        minors.iter().all(|&minor| minor > least)
    }

    #[test]
    fn no_negative_eigenvalue_is_left_and_little_is_added() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for _ in 0..1000 {
            let mut draw = || DVec3::new(next(), next(), next());
            let g = of_impulse(draw(), draw()) + of_impulse(draw(), draw());
            let shifted = without_negative(Sym3x4::<Plain>::of([&g; 4])).each()[0];
            let added = shifted.x_axis.x - g.x_axis.x;
            assert!(is_positive(&shifted, -1.0e-12), "{shifted:?} is indefinite");
            let less = g + DMat3::from_diagonal(DVec3::splat(added * 0.9 - 1.0e-6));
            assert!(added == 0.0 || !is_positive(&less, 0.0), "{g:?} was shifted by {added}");
        }
    }
}
