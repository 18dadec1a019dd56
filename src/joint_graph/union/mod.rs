//! Rigid unions: bodies that fixed joints make one (Müller et al. 2017, §3.5).
//!
//! A graph of rigid fixed joints leaves its bodies six freedoms together. Instead of iterating the joints, all of them are met at
//! once: the *conforming rest state*, poses that satisfy every joint, is found from the joint frames alone, breadth-first; its
//! mass, centre and inertia are those of one rigid body, and that body is what the solver moves. Members that are not where the
//! rest state has them (made so, or put there by the host) are taken into it by shape matching, see [`matching`]. What each joint
//! carries follows from the members' motion, see [`loads`].
//!
//! Everything here is pure: joint frames and masses in, numbers out.

use std::collections::VecDeque;

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use crate::linalg::eigen::symmetric_eigen;
use crate::mass::MassProperties;

pub(crate) mod loads;
pub(crate) mod matching;

/// A pose in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pose64 {
    pub position: DVec3,
    pub rotation: DQuat,
}

impl Pose64 {
    pub(crate) const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// `inner`, given in this frame, where this frame is given.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        Self { position: self.position + self.rotation * inner.position, rotation: (self.rotation * inner.rotation).normalize() }
    }

    pub(crate) fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { position: -(rotation * self.position), rotation }
    }
}

/// A fixed joint between two members: where each has its frame, from the member's centre of mass and in its axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedLink {
    pub members: [u32; 2],
    pub frames: [Pose64; 2],
}

/// Poses that satisfy the joints, and by how much the joints contradict one another.
#[derive(Debug, Clone, Default)]
pub(crate) struct RestState {
    /// Centre of mass and axes of each member, in the frame of the first one.
    pub frames: Vec<Pose64>,
    /// Worst distance (m) and angle (rad) that a joint which closes a loop is off by.
    pub residual: (f64, f64),
}

impl RestState {
    /// Breadth-first from the first member, joints in their order. All members must be connected.
    pub(crate) fn conform(count: usize, fixed_links: &[FixedLink]) -> Self {
        let mut of_member = vec![Vec::new(); count];
        for (number, fixed_link) in fixed_links.iter().enumerate() {
            fixed_link.members.iter().enumerate().for_each(|(side, &member)| of_member[member as usize].push((number, side)));
        }
        let mut frames: Vec<Option<Pose64>> = vec![None; count];
        let mut queue = VecDeque::from([0_usize]);
        if let Some(first) = frames.first_mut() {
            *first = Some(Pose64::IDENTITY);
        }
        while let Some(member) = queue.pop_front() {
            let Some(own) = frames[member] else { continue };
            for &(number, side) in &of_member[member] {
                let fixed_link = &fixed_links[number];
                let other = fixed_link.members[1 - side] as usize;
                if frames[other].is_none() {
                    frames[other] = Some(own.then(&fixed_link.frames[side]).then(&fixed_link.frames[1 - side].inverse()));
                    queue.push_back(other);
                }
            }
        }
        let frames: Vec<Pose64> = frames.into_iter().map(|frame| frame.unwrap_or(Pose64::IDENTITY)).collect();
        let mut residual = (0.0_f64, 0.0_f64);
        for fixed_link in fixed_links {
            let [a, b] = [0, 1].map(|side| frames[fixed_link.members[side] as usize].then(&fixed_link.frames[side]));
            let turn = a.rotation.conjugate() * b.rotation;
            let sine = DVec3::new(turn.x, turn.y, turn.z).length();
            residual.0 = residual.0.max((b.position - a.position).length());
            residual.1 = residual.1.max(2.0 * libm::atan2(sine, turn.w.abs()));
        }
        Self { frames, residual }
    }
}

/// The one body that a union is: its mass, and where its members are in it.
#[derive(Debug, Clone)]
pub(crate) struct Compound {
    /// Mass and principal moments about the centre of mass, which is the origin of the union's frame.
    pub mass: MassProperties,
    /// Centre of mass in the rest state (m).
    pub center: DVec3,
    /// Members from the centre of mass (m), and their rotation.
    pub places: Vec<(Vec3, Quat)>,
}

impl Compound {
    /// Sum of the members' mass properties (parallel axis theorem). The union's axes are those of the rest state.
    pub(crate) fn new(rest: &[Pose64], masses: &[MassProperties]) -> Self {
        let total: f64 = masses.iter().map(|mass| f64::from(mass.mass)).sum();
        let center = rest.iter().zip(masses).map(|(frame, mass)| frame.position * f64::from(mass.mass)).sum::<DVec3>() / total;
        let mut tensor = DMat3::ZERO;
        for (frame, mass) in rest.iter().zip(masses) {
            let offset = frame.position - center;
            let steiner = DMat3::from_diagonal(DVec3::splat(offset.length_squared())) - outer(offset, offset);
            tensor += inertia_of(mass, frame.rotation) + steiner * f64::from(mass.mass);
        }
        let (moments, axes) = symmetric_eigen(tensor);
        let mass = MassProperties {
            mass: total as f32,
            center_of_mass: Vec3::ZERO,
            principal_inertia: moments.as_vec3(),
            inertia_frame: DQuat::from_mat3(&axes).normalize().as_quat(),
        };
        let place = |frame: &Pose64| ((frame.position - center).as_vec3(), frame.rotation.normalize().as_quat());
        Self { mass, center, places: rest.iter().map(place).collect() }
    }
}

/// Inertia tensor of a body about its centre of mass, its axes turned by `rotation` (kg·m²).
pub(crate) fn inertia_of(mass: &MassProperties, rotation: DQuat) -> DMat3 {
    let axes = DMat3::from_quat((rotation * mass.inertia_frame.as_dquat()).normalize());
    axes * DMat3::from_diagonal(mass.principal_inertia.as_dvec3()) * axes.transpose()
}

/// a bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Where a union is, and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UnionMotion {
    /// World position of the centre of mass (m).
    pub center: DVec3,
    pub rotation: Quat,
    pub linear: Vec3,
    pub angular: Vec3,
}

impl UnionMotion {
    pub(crate) const ORIGIN: Self =
        Self { center: DVec3::ZERO, rotation: Quat::IDENTITY, linear: Vec3::ZERO, angular: Vec3::ZERO };

    /// The motion that a member at this place has.
    pub(crate) fn at(&self, offset: Vec3, rotation: Quat) -> Self {
        let arm = self.rotation * offset;
        Self {
            center: self.center + arm.as_dvec3(),
            rotation: (self.rotation * rotation).normalize(),
            linear: self.linear + self.angular.cross(arm),
            angular: self.angular,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(length: f64) -> [Pose64; 2] {
        let turn = DQuat::from_rotation_y(0.3);
        [
            Pose64 { position: DVec3::X * 0.5 * length, rotation: turn },
            Pose64 { position: -DVec3::X * 0.5 * length, rotation: turn },
        ]
    }

    #[test]
    fn a_chain_conforms_and_a_crooked_loop_says_by_how_much() {
        let frames = bar(1.0);
        let mut fixed_links: Vec<FixedLink> = (0..3).map(|i| FixedLink { members: [i, i + 1], frames }).collect();
        let rest = RestState::conform(4, &fixed_links);
        assert!(rest.residual.0 < 1.0e-12 && rest.residual.1 < 1.0e-7, "{:?}", rest.residual);
        assert!((rest.frames[3].position - DVec3::X * 3.0).length() < 1.0e-12, "{}", rest.frames[3].position);
        let off = Pose64 { position: rest.frames[3].position + DVec3::Y * 0.01, rotation: DQuat::from_rotation_z(0.02) };
        fixed_links.push(FixedLink { members: [0, 3], frames: [off, Pose64::IDENTITY] });
        let rest = RestState::conform(4, &fixed_links);
        assert!((rest.residual.0 - 0.01).abs() < 0.01, "{} m", rest.residual.0);
        assert!(rest.residual.1 > 0.019, "{} rad", rest.residual.1);
    }

    #[test]
    fn a_compound_of_cubes_is_a_bar() {
        // Four cubes of 1 kg and edge 1 m in a row: I = m/12 (h² + w²) along, (L² + w²) across.
        let cube = MassProperties::new(1.0, Vec3::splat(1.0 / 6.0));
        let rest: Vec<Pose64> = (0..4)
            .map(|i| Pose64 { position: DVec3::X * f64::from(i), rotation: DQuat::from_rotation_x(f64::from(i)) })
            .collect();
        let compound = Compound::new(&rest, &[cube; 4]);
        let mut moments = compound.mass.principal_inertia.to_array();
        moments.sort_by(f32::total_cmp);
        assert_eq!(compound.mass.mass, 4.0);
        assert!((moments[0] - 4.0 / 6.0).abs() < 1.0e-6 && (moments[2] - 4.0 / 12.0 * 17.0).abs() < 1.0e-5, "{moments:?}");
        assert_eq!(compound.places[0].0, Vec3::X * -1.5);
    }
}
