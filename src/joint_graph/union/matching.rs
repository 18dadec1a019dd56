//! Generalized shape matching of rigid bodies (Müller et al. 2017, §3.5), with a velocity fit that keeps momentum.
//!
//! **Position.** The rest state is moved to where it is closest to the members as they are, weighed by mass: its centre to theirs,
//! its rotation to the rotational part of the moment matrix
//!
//! ```text
//! A = Σ R_i Ā_i + m_i r_i r̄_iᵀ,        Ā_i = ∫ ρ r̄ r̄ᵀ dV = ½ tr(I_i) 1 − I_i,
//! ```
//!
//! r_i and r̄_i from the common centres now and at rest, R_i the member's rotation from rest to now, I_i its inertia at rest. The
//! rotational part is found from a warm start by turning towards it (Müller, Bender, Chentanez, Macklin 2016),
//!
//! ```text
//! ω = Σ_k R_k × A_k / |Σ_k R_k · A_k|,    R ← exp(ω) R        (columns k).
//! ```
//!
//! Positions give no velocity: a velocity read off a projection adds angular momentum.
//!
//! **Velocity.** The one rigid motion that has the members' linear and angular momentum, taken where the members are:
//! v = Σ m_i v_i / M, ω = I⁻¹ Σ (r_i × m_i v_i + I_i ω_i). What kinetic energy falls by was motion of the members against each other.

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use super::{UnionMotion, inertia_of, outer};
use crate::mass::MassProperties;

/// Rotation of one turn below which the extraction has ended (rad).
const NEGLIGIBLE_TURN: f64 = 1.0e-11;

/// Most turns of one extraction. Each closes the error by a factor; half a turn off takes about thirty.
const MAX_TURNS: usize = 100;

/// A member as it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loose {
    pub mass: MassProperties,
    pub motion: UnionMotion,
}

/// Second moment of a body's mass about its centre, in its own axes (kg·m²). A given inertia that no mass distribution has is cut
/// off at zero.
fn covariance(mass: &MassProperties) -> DMat3 {
    let inertia = mass.principal_inertia.as_dvec3();
    let half_trace = 0.5 * (inertia.x + inertia.y + inertia.z);
    let axes = DMat3::from_quat(mass.inertia_frame.as_dquat().normalize());
    axes * DMat3::from_diagonal((DVec3::splat(half_trace) - inertia).max(DVec3::ZERO)) * axes.transpose()
}

/// Σ R_i Ā_i of members at rest in `places`, ready for the rotations of now.
#[derive(Debug, Clone, Default)]
pub(crate) struct Covariances(Vec<DMat3>);

impl Covariances {
    /// Forms Ā_i in the union's axes.
    pub(crate) fn new(masses: &[MassProperties], places: &[(Vec3, Quat)]) -> Self {
        let turned = |(mass, (_, rotation)): (&MassProperties, &(Vec3, Quat))| {
            let turn = DMat3::from_quat(rotation.as_dquat().normalize());
            turn * covariance(mass) * turn.transpose()
        };
        Self(masses.iter().zip(places).map(turned).collect())
    }

    /// Pose of the union, closest to its members as they are; the rotation is looked for from `start` on.
    pub(crate) fn fit_pose(&self, members: &[Loose], places: &[(Vec3, Quat)], start: Quat) -> (DVec3, Quat) {
        let center = center_of(members);
        let mut moment = DMat3::ZERO;
        for ((member, &(offset, rest)), covariance) in members.iter().zip(places).zip(&self.0) {
            let turn = member.motion.rotation.as_dquat().normalize() * rest.as_dquat().normalize().conjugate();
            moment += DMat3::from_quat(turn) * *covariance
                + outer(member.motion.center - center, offset.as_dvec3()) * f64::from(member.mass.mass);
        }
        (center, rotation_of(moment, start.as_dquat().normalize()).as_quat())
    }
}

fn center_of(members: &[Loose]) -> DVec3 {
    // From the first member, so that what is far out keeps its digits.
    let Some(first) = members.first().map(|member| member.motion.center) else { return DVec3::ZERO };
    let total: f64 = members.iter().map(|member| f64::from(member.mass.mass)).sum();
    first + members.iter().map(|member| (member.motion.center - first) * f64::from(member.mass.mass)).sum::<DVec3>() / total
}

/// Rotational part of `moment`, from a rotation near it.
fn rotation_of(moment: DMat3, mut rotation: DQuat) -> DQuat {
    for _ in 0..MAX_TURNS {
        let axes = DMat3::from_quat(rotation);
        let columns = [(axes.x_axis, moment.x_axis), (axes.y_axis, moment.y_axis), (axes.z_axis, moment.z_axis)];
        let torque: DVec3 = columns.iter().map(|(own, wanted)| own.cross(*wanted)).sum();
        let hold: f64 = columns.iter().map(|(own, wanted)| own.dot(*wanted)).sum();
        let turn = torque / (hold.abs() + f64::MIN_POSITIVE);
        if turn.is_nan() || turn.length_squared() <= NEGLIGIBLE_TURN * NEGLIGIBLE_TURN {
            break;
        }
        let angle = turn.length();
        rotation = (DQuat::from_axis_angle(turn / angle, angle.min(1.0)) * rotation).normalize();
    }
    rotation
}

/// Velocity of the centre and angular velocity with the members' momentum; `mass` is the union's, at this rotation.
pub(crate) fn fit_velocity(members: &[Loose], mass: &MassProperties, rotation: Quat) -> (Vec3, Vec3) {
    let center = center_of(members);
    let (mut momentum, mut spin, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for Loose { mass, motion } in members {
        let own = motion.linear.as_dvec3() * f64::from(mass.mass);
        momentum += own;
        total += f64::from(mass.mass);
        spin += (motion.center - center).cross(own)
            + inertia_of(mass, motion.rotation.as_dquat().normalize()) * motion.angular.as_dvec3();
    }
    let frame = (rotation.as_dquat() * mass.inertia_frame.as_dquat()).normalize();
    let angular = frame * ((frame.conjugate() * spin) / mass.principal_inertia.as_dvec3());
    ((momentum / total).as_vec3(), angular.as_vec3())
}

#[cfg(test)]
mod tests {
    use super::super::{Compound, Pose64};
    use super::*;

    fn scattered(noise: f64) -> (Vec<Loose>, Compound, Covariances, Quat) {
        let mut word = 12345_u64;
        let mut random = move || {
            word = word.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (word >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut random3 = move || DVec3::new(random(), random(), random());
        let masses: Vec<MassProperties> =
            (0..9).map(|i| MassProperties::new(1.0 + i as f32, Vec3::new(0.1, 0.2, 0.25) * (1.0 + i as f32))).collect();
        let rest: Vec<Pose64> =
            (0..9).map(|_| Pose64 { position: random3() * 2.0, rotation: DQuat::from_scaled_axis(random3() * 3.0) }).collect();
        let compound = Compound::new(&rest, &masses);
        let covariances = Covariances::new(&masses, &compound.places);
        let turn = DQuat::from_scaled_axis(DVec3::new(1.2, -2.0, 0.7));
        let union = UnionMotion { center: DVec3::new(1.0e4, 3.0, -2.0), rotation: turn.as_quat(), ..UnionMotion::ORIGIN };
        let members = masses
            .iter()
            .zip(&compound.places)
            .map(|(&mass, &(offset, rotation))| {
                let mut motion = union.at(offset, rotation);
                motion.center += random3() * noise;
                motion.rotation = (DQuat::from_scaled_axis(random3() * noise) * motion.rotation.as_dquat()).normalize().as_quat();
                (motion.linear, motion.angular) = (random3().as_vec3() * 4.0, random3().as_vec3() * 9.0);
                Loose { mass, motion }
            })
            .collect();
        (members, compound, covariances, turn.as_quat())
    }

    #[test]
    fn a_moved_union_is_found_where_it_is_from_any_start() {
        let (members, compound, covariances, turn) = scattered(0.0);
        for start in [turn, Quat::IDENTITY, Quat::from_rotation_y(3.0) * turn] {
            let (center, rotation) = covariances.fit_pose(&members, &compound.places, start);
            assert!((center - DVec3::new(1.0e4, 3.0, -2.0)).length() < 1.0e-6, "{center}");
            assert!(rotation.dot(turn).abs() > 1.0 - 1.0e-6, "{rotation} instead of {turn}");
        }
    }

    #[test]
    fn a_fitted_velocity_has_the_momentum_and_less_energy() {
        let (members, compound, covariances, turn) = scattered(0.1);
        let (center, rotation) = covariances.fit_pose(&members, &compound.places, turn);
        let (linear, angular) = fit_velocity(&members, &compound.mass, rotation);
        let inertia = inertia_of(&compound.mass, rotation.as_dquat());
        let (mut momentum, mut spin, mut energy) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for Loose { mass, motion } in &members {
            let own = motion.linear.as_dvec3() * f64::from(mass.mass);
            let turning = inertia_of(mass, motion.rotation.as_dquat()) * motion.angular.as_dvec3();
            momentum += own;
            spin += (motion.center - center).cross(own) + turning;
            energy += 0.5 * (own.dot(motion.linear.as_dvec3()) + turning.dot(motion.angular.as_dvec3()));
        }
        let fitted = (linear.as_dvec3() * f64::from(compound.mass.mass), inertia * angular.as_dvec3());
        assert!((fitted.0 - momentum).length() < 1.0e-6 * momentum.length(), "{} kg·m/s", (fitted.0 - momentum).length());
        assert!((fitted.1 - spin).length() < 1.0e-6 * spin.length(), "{} kg·m²/s", (fitted.1 - spin).length());
        let rigid = 0.5 * (fitted.0.dot(linear.as_dvec3()) + fitted.1.dot(angular.as_dvec3()));
        assert!(rigid < energy, "{rigid} J of {energy} J");
    }
}
