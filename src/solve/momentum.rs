//! Angular momentum of what nothing holds.
//!
//! Joints and contacts act and react, so they change neither momentum of an island that touches nothing fixed. What a solver does
//! beside does: geometric stiffness turns bodies without an opposite, mended positions carry momentum along, and friction acts at
//! two points where a gap is between them. What a substep so changes of the angular momentum L about the common centre of mass is
//! given back as one rotation of the whole,
//!
//! ```text
//! ω = J⁻¹ ΔL,    v_i ← v_i + ω × r_i,    ω_i ← ω_i + ω,    J = Σ I_i + m_i (r_i² 1 − r_i r_iᵀ).
//! ```
//!
//! No joint and no contact inside feels it: J v = 0 for every rigid motion.

use glam::{DMat3, DVec3};

use super::state::{BodyMotion, BodyVelocity};

/// Sums over bodies, positions from a point near them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Whole {
    /// (kg)
    mass: f64,
    /// Σ m r (kg·m)
    first: DVec3,
    /// Σ m v (N·s)
    linear: DVec3,
    /// About the point (N·m·s).
    angular: DVec3,
}

impl Whole {
    /// Adds a body: its mass (kg), centre (m), velocity (m/s) and own angular momentum (N·m·s).
    #[inline]
    pub(crate) fn add(&mut self, mass: f64, center: DVec3, velocity: DVec3, spin: DVec3) {
        let own = velocity * mass;
        self.mass += mass;
        self.first += center * mass;
        self.linear += own;
        self.angular += center.cross(own) + spin;
    }

    /// Mass of all (kg).
    pub(crate) fn mass(&self) -> f64 {
        self.mass
    }

    /// Common centre of mass (m).
    pub(crate) fn center(&self) -> DVec3 {
        self.first / self.mass
    }

    /// Angular momentum about the centre of mass (N·m·s).
    pub(crate) fn spin(&self) -> DVec3 {
        self.angular - self.center().cross(self.linear)
    }
}

/// Inertia of bodies as one (kg·m²).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inertia(DMat3);

impl Inertia {
    pub(crate) const ZERO: Self = Self(DMat3::ZERO);

    /// Adds a body: its mass (kg), centre from the common one (m), and own inertia (kg·m²).
    #[inline]
    pub(crate) fn add(&mut self, mass: f64, arm: DVec3, own: DMat3) {
        let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        self.0 += own + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * mass;
    }

    /// Rotation of all that has this angular momentum (rad/s); none where all lie in one line without thickness.
    pub(crate) fn rate_of(&self, momentum: DVec3) -> DVec3 {
        let determinant = self.0.determinant();
        let rate = self.0.inverse() * momentum;
        if determinant > 0.0 && rate.is_finite() { rate } else { DVec3::ZERO }
    }
}

/// Islands of a batch that nothing holds, without what an articulation moves by itself.
#[derive(Debug, Default)]
pub(crate) struct FreeIslands {
    /// Range of each in `members`, and its angular momentum.
    islands: Vec<(usize, usize, DVec3)>,
    /// Slot of each body, and where displacements count from (m).
    members: Vec<(u32, DVec3)>,
    /// Number of the island of each slot, and whether each island is held.
    owner: Vec<u32>,
    held: Vec<bool>,
}

/// What is in no island: the world, and bodies that move by themselves.
const NOBODY: u32 = u32::MAX;

impl FreeIslands {
    pub(crate) fn clear(&mut self) {
        self.islands.clear();
    }

    /// Finds what is free: `firsts` are the first slots of the islands, `links` the ends of joints and contacts; `origin` is where
    /// the displacement of a slot counts from.
    pub(crate) fn find(
        &mut self,
        firsts: &[u32],
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        links: impl Iterator<Item = (u32, u32)>,
        origin: impl Fn(u32) -> DVec3,
    ) {
        self.islands.clear();
        self.members.clear();
        self.held.clear();
        self.owner.clear();
        self.owner.resize(motions.len(), NOBODY);
        for (number, &first) in firsts.iter().enumerate() {
            let next = firsts.get(number + 1).map_or(motions.len(), |&next| next as usize);
            let mut bodies = 0;
            let mut held = false;
            for slot in (first as usize..next).filter(|&slot| motions[slot].is_dynamic()) {
                self.owner[slot] = number as u32;
                bodies += 1;
                held |= velocities[slot].inverse_mass.min_element() <= 0.0 || motions[slot].free_rotation != glam::Vec3::ONE;
            }
            self.held.push(held || bodies < 2);
        }
        if self.held.iter().all(|&held| held) {
            return;
        }
        for (a, b) in links {
            let owners = [a, b].map(|slot| self.owner[slot as usize]);
            for owner in owners.into_iter().filter(|&owner| owner != NOBODY && owners.contains(&NOBODY)) {
                self.held[owner as usize] = true;
            }
        }
        for (number, &first) in firsts.iter().enumerate().filter(|&(number, _)| !self.held[number]) {
            let next = firsts.get(number + 1).map_or(motions.len(), |&next| next as usize);
            let start = self.members.len();
            let near = origin(first);
            let moved =
                (first..next as u32).filter(|&slot| motions[slot as usize].is_dynamic() && !motions[slot as usize].direct);
            self.members.extend(moved.map(|slot| (slot, origin(slot) - near)));
            if self.members.len() > start + 1 {
                self.islands.push((start, self.members.len(), DVec3::ZERO));
            }
        }
    }

    /// Notes the angular momentum that each has, and is to keep.
    pub(crate) fn note(&mut self, velocities: &[BodyVelocity], motions: &[BodyMotion]) {
        let Self { islands, members, .. } = self;
        for (start, end, spin) in islands {
            *spin = whole(&members[*start..*end], velocities, motions).spin();
        }
    }

    /// Gives back what has been lost of it since, or takes what has been won.
    pub(crate) fn restore(&self, velocities: &mut [BodyVelocity], motions: &[BodyMotion]) {
        for &(start, end, spin) in &self.islands {
            let members = &self.members[start..end];
            let now = whole(members, velocities, motions);
            let center = now.center();
            let mut inertia = Inertia::ZERO;
            for &(slot, origin) in members {
                let (velocity, motion) = (&velocities[slot as usize], &motions[slot as usize]);
                let frame = frame(motion);
                let own = frame * DMat3::from_diagonal(motion.inertia.as_dvec3()) * frame.transpose();
                inertia.add(mass(velocity), origin + motion.displacement.as_dvec3() - center, own);
            }
            let turn = inertia.rate_of(spin - now.spin());
            if turn == DVec3::ZERO {
                continue;
            }
            for &(slot, origin) in members {
                let (velocity, motion) = (&mut velocities[slot as usize], &motions[slot as usize]);
                velocity.linear += turn.cross(origin + motion.displacement.as_dvec3() - center).as_vec3();
                velocity.angular += turn.as_vec3();
            }
        }
    }
}

fn mass(velocity: &BodyVelocity) -> f64 {
    1.0 / f64::from(velocity.inverse_mass.x)
}

fn frame(motion: &BodyMotion) -> DMat3 {
    DMat3::from_quat((motion.rotation.as_dquat() * motion.inertia_frame.as_dquat()).normalize())
}

fn whole(members: &[(u32, DVec3)], velocities: &[BodyVelocity], motions: &[BodyMotion]) -> Whole {
    let mut sum = Whole::default();
    for &(slot, origin) in members {
        let (velocity, motion) = (&velocities[slot as usize], &motions[slot as usize]);
        let frame = frame(motion);
        let spin = frame * (motion.inertia.as_dvec3() * (frame.transpose() * velocity.angular.as_dvec3()));
        sum.add(mass(velocity), origin + motion.displacement.as_dvec3(), velocity.linear.as_dvec3(), spin);
    }
    sum
}
