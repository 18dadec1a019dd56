//! Angular momentum of free islands, kept through the sweeps.
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
//!
//! Bodies that neither a joint nor friction connects are no such whole. What they do to each other goes along normals, and never turns a
//! ball. A blow of them is right where they are when they touch, and L is amiss only as poses of the substep are of another moment; a
//! rotation of all would give them spin that nothing could.

use glam::{DMat3, DVec3};

use super::body_flags::BodyFlags;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_bodies::WideBodies;

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

    /// Momentum of all (N·s).
    pub(crate) fn linear(&self) -> DVec3 {
        self.linear
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

/// Moments of mass of bodies about a point near them (kg·m²).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    /// Sum of the bodies' own inertia, and of m (r² 1 − r rᵀ): xx, yy, zz, xy, xz, yz.
    sums: [f64; 6],
}

impl Moments {
    /// Adds a body: its mass (kg), centre (m), and own inertia: xx, yy, zz, xy, xz, yz (kg·m²).
    #[inline]
    pub(crate) fn add(&mut self, mass: f64, r: DVec3, own: &[f64; 6]) {
        let (xx, yy, zz) = (mass * r.x * r.x, mass * r.y * r.y, mass * r.z * r.z);
        let shifted = [yy + zz, xx + zz, xx + yy, -mass * r.x * r.y, -mass * r.x * r.z, -mass * r.y * r.z];
        for (sum, (own, shift)) in self.sums.iter_mut().zip(own.iter().zip(shifted)) {
            *sum += own + shift;
        }
    }

    /// Of the bodies as one about their common centre of mass.
    pub(crate) fn about(&self, whole: &Whole) -> Inertia {
        let mut shift = Self::default();
        shift.add(whole.mass, whole.center(), &[0.0; 6]);
        let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| self.sums[i] - shift.sums[i]);
        Inertia(DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]))
    }
}

/// A symmetric matrix (xx, yy, zz, xy, xz, yz) times a vector.
#[inline]
pub(crate) fn times([xx, yy, zz, xy, xz, yz]: &[f64; 6], v: DVec3) -> DVec3 {
    DVec3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
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
    /// Whether a joint or friction acts in each.
    turns: Vec<bool>,
}

/// What is in no island: the world, and bodies that move by themselves.
const NOBODY: u32 = u32::MAX;

impl FreeIslands {
    pub(crate) fn clear(&mut self) {
        self.islands.clear();
    }

    /// Finds what is free: `firsts` are the first slots of the islands, `links` the ends of joints and contacts, of these with their number;
    /// `rubs` says whether friction may turn what a contact acts on, and `origin` where the displacement of a slot counts from.
    pub(crate) fn find(
        &mut self,
        firsts: &[u32],
        body_flags: &[BodyFlags],
        motions: &[BodyMotion],
        links: impl Iterator<Item = ([u32; 2], Option<usize>)> + Clone,
        rubs: impl Fn(usize) -> bool,
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
            for slot in (first as usize..next).filter(|&slot| body_flags[slot].moves()) {
                self.owner[slot] = number as u32;
                bodies += 1;
                held |= !body_flags[slot].is_unlocked();
            }
            self.held.push(held || bodies < 2);
        }
        if self.held.iter().all(|&held| held) {
            return;
        }
        for (ends, _) in links.clone() {
            let owners = ends.map(|slot| self.owner[slot as usize]);
            for owner in owners.into_iter().filter(|&owner| owner != NOBODY && owners.contains(&NOBODY)) {
                self.held[owner as usize] = true;
            }
        }
        self.leave_out_what_only_presses(links, rubs);
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

    /// Leaves out islands in which nothing can turn what it acts on: no joint, and no contact with friction.
    fn leave_out_what_only_presses(
        &mut self,
        links: impl Iterator<Item = ([u32; 2], Option<usize>)>,
        rubs: impl Fn(usize) -> bool,
    ) {
        let Self { owner, held, turns, .. } = self;
        turns.clear();
        turns.resize(held.len(), false);
        for ([slot, _], contact) in links {
            let number = owner[slot as usize];
            if number != NOBODY && !held[number as usize] && !turns[number as usize] {
                turns[number as usize] = contact.is_none_or(&rubs);
            }
        }
        held.iter_mut().zip(turns).for_each(|(held, turns)| *held |= !*turns);
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.islands.is_empty()
    }

    /// Notes the angular momentum that those have, and are to keep, of which `is_asked` says so of a slot; `poses` hold the inertia of
    /// now.
    pub(crate) fn note(
        &mut self,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        poses: &WideBodies,
        is_asked: impl Fn(u32) -> bool,
    ) {
        let Self { islands, members, .. } = self;
        for (start, end, spin) in islands.iter_mut().filter(|&&mut (start, ..)| is_asked(members[start].0)) {
            let mut whole = Whole::default();
            for member in &members[*start..*end] {
                MovingMember::of(member, velocities, motions, poses).add_to(&mut whole);
            }
            *spin = whole.spin();
        }
    }

    /// Gives back what has been lost of it since, or takes what has been won, but where `is_exempt` says so of a slot.
    pub(crate) fn restore(
        &self,
        velocities: &mut [BodyVelocity],
        motions: &[BodyMotion],
        poses: &WideBodies,
        is_exempt: impl Fn(u32) -> bool,
    ) {
        for &(start, end, spin) in self.islands.iter().filter(|&&(start, ..)| !is_exempt(self.members[start].0)) {
            let members = &self.members[start..end];
            let (mut whole, mut moments) = (Whole::default(), Moments::default());
            for member in members {
                let body = MovingMember::of(member, velocities, motions, poses);
                body.add_to(&mut whole);
                moments.add(body.mass, body.center, &body.inertia);
            }
            let turn = moments.about(&whole).rate_of(spin - whole.spin());
            if turn == DVec3::ZERO {
                continue;
            }
            let center = whole.center();
            for &(slot, origin) in members {
                let (velocity, motion) = (&mut velocities[slot as usize], &motions[slot as usize]);
                velocity.linear += turn.cross(origin + motion.displacement.as_dvec3() - center).as_vec3();
                velocity.angular += turn.as_vec3();
            }
        }
    }
}

impl FreeIslands {
    /// Whether a free island begins with this slot.
    pub(crate) fn begins_at(&self, first: u32) -> bool {
        self.islands.iter().any(|&(start, ..)| self.members[start].0 == first)
    }

    /// Slows the motion of the members of the free island that begins with this slot against one another, to the share that `kept` says
    /// where the kinetic energy of that motion has grown (J, from and to); `false` if no free island begins there.
    pub(crate) fn slow(
        &self,
        first: u32,
        (from, to): (f64, f64),
        kept: impl Fn(f64, f64) -> f64,
        velocities: &mut [BodyVelocity],
        motions: &[BodyMotion],
        poses: &WideBodies,
    ) -> bool {
        let found = self.islands.iter().find(|&&(start, ..)| self.members[start].0 == first);
        let Some(&(start, end, _)) = found else { return false };
        let members = &self.members[start..end];
        let (mut whole, mut moments) = (Whole::default(), Moments::default());
        for member in members {
            let body = MovingMember::of(member, velocities, motions, poses);
            body.add_to(&mut whole);
            moments.add(body.mass, body.center, &body.inertia);
        }
        let (center, linear) = (whole.center(), whole.linear() / whole.mass());
        let turn = moments.about(&whole).rate_of(whole.spin());
        let as_one = 0.5 * whole.linear().dot(linear) + 0.5 * whole.spin().dot(turn);
        let kept = if to > as_one { kept((from - as_one).max(0.0), to - as_one) } else { 1.0 };
        for &(slot, origin) in members {
            let (velocity, motion) = (&mut velocities[slot as usize], &motions[slot as usize]);
            let own = linear + turn.cross(origin + motion.displacement.as_dvec3() - center);
            velocity.linear = (own + (velocity.linear.as_dvec3() - own) * kept).as_vec3();
            velocity.angular = (turn + (velocity.angular.as_dvec3() - turn) * kept).as_vec3();
        }
        true
    }
}

/// A member of an island as it moves.
struct MovingMember {
    mass: f64,
    center: DVec3,
    linear: DVec3,
    angular: DVec3,
    inertia: [f64; 6],
}

impl MovingMember {
    #[inline]
    fn of(&(slot, origin): &(u32, DVec3), velocities: &[BodyVelocity], motions: &[BodyMotion], poses: &WideBodies) -> Self {
        let (velocity, motion) = (&velocities[slot as usize], &motions[slot as usize]);
        Self {
            mass: 1.0 / f64::from(velocity.inverse_mass.x),
            center: origin + motion.displacement.as_dvec3(),
            linear: velocity.linear.as_dvec3(),
            angular: velocity.angular.as_dvec3(),
            inertia: poses.inertia_of(slot, motion),
        }
    }

    #[inline]
    fn add_to(&self, whole: &mut Whole) {
        whole.add(self.mass, self.center, self.linear, times(&self.inertia, self.angular));
    }
}
