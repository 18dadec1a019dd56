//! Gathers the bodies of one side of a block into lanes, and scatters them back.

use super::contact::LANES;
use super::disjoint::Slots;
use super::integrate::PredictedPose;
use super::state::{BodyMotion, BodyVelocity};
use super::wide_matrix::{Wide6, WideQuat};
use crate::lanes::wide::{Wide, Wide3};

/// Velocities and inverse masses of one side of a block.
pub(crate) struct WideVelocities<W> {
    pub linear: Wide3<W>,
    pub angular: Wide3<W>,
    inverse_mass: Wide3<W>,
    pub inverse_inertia: Wide6<W>,
}

impl<W: Wide> WideVelocities<W> {
    #[inline(always)]
    pub fn gather<V: Slots<BodyVelocity> + ?Sized>(slots: &[u32; LANES], velocities: &V) -> Self {
        let mut rows = [[W::zero(); LANES]; 2];
        for l in 0..LANES {
            let [first, second] = velocities.get(slots[l]).halves();
            (rows[0][l], rows[1][l]) = (W::load(first), W::load(second));
        }
        let [lx, ly, lz, ax, ay, az, mx, my] = W::transpose(rows[0]);
        let [mz, xx, yy, zz, xy, xz, yz, _] = W::transpose(rows[1]);
        Self {
            linear: Wide3::new(lx, ly, lz),
            angular: Wide3::new(ax, ay, az),
            inverse_mass: Wide3::new(mx, my, mz),
            inverse_inertia: Wide6([xx, yy, zz, xy, xz, yz]),
        }
    }

    #[inline(always)]
    pub fn scatter<V: Slots<BodyVelocity> + ?Sized>(&self, slots: &[u32; LANES], velocities: &mut V) {
        let Self { linear, angular, inverse_mass, .. } = self;
        let rows = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z, inverse_mass.x, inverse_mass.y];
        let rows = W::transpose(rows);
        for l in 0..LANES {
            rows[l].store(velocities.get_mut(slots[l]).first_half_mut());
        }
    }

    /// As [`scatter`](Self::scatter), with inverse masses and inertias.
    #[inline(always)]
    pub fn scatter_whole<V: Slots<BodyVelocity> + ?Sized>(&self, slots: &[u32; LANES], velocities: &mut V) {
        let Self { linear, angular, inverse_mass, inverse_inertia } = self;
        let [xx, yy, zz, xy, xz, yz] = inverse_inertia.0;
        let first = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z, inverse_mass.x, inverse_mass.y];
        let (first, second) = (W::transpose(first), W::transpose([inverse_mass.z, xx, yy, zz, xy, xz, yz, W::zero()]));
        for l in 0..LANES {
            let [a, b] = velocities.get_mut(slots[l]).halves_mut();
            first[l].store(a);
            second[l].store(b);
        }
    }

    /// Applies an impulse and an angular impulse to every lane.
    #[inline(always)]
    pub fn apply(&mut self, impulse: Wide3<W>, torque: Wide3<W>) {
        self.linear = self.linear + self.inverse_mass.scale(impulse);
        self.turn(torque);
    }

    /// Applies an angular impulse to every lane.
    #[inline(always)]
    pub fn turn(&mut self, torque: Wide3<W>) {
        self.angular = self.angular + self.inverse_inertia.mul(torque);
    }

    #[inline(always)]
    pub fn inverse_mass(&self) -> Wide3<W> {
        self.inverse_mass
    }

    /// I⁻¹ v.
    #[inline(always)]
    pub fn response(&self, v: Wide3<W>) -> Wide3<W> {
        self.inverse_inertia.mul(v)
    }

    /// The same bodies at rest, to gather displacements in.
    #[inline(always)]
    pub fn at_rest(&self) -> Self {
        Self {
            linear: Wide3::zero(),
            angular: Wide3::zero(),
            inverse_mass: self.inverse_mass,
            inverse_inertia: self.inverse_inertia,
        }
    }

    /// K = M⁻¹ − [r]× I⁻¹ [r]×: how a point at `lever` answers to an impulse there.
    #[inline(always)]
    pub fn response_at(&self, lever: Wide3<W>) -> Wide6<W> {
        self.inverse_inertia.seen_at(lever).plus_diagonal(self.inverse_mass)
    }
}

/// Linear and angular velocities of one side of a block.
#[inline(always)]
pub(crate) fn gather_velocities<W: Wide>(slots: &[u32; LANES], velocities: &[BodyVelocity]) -> (Wide3<W>, Wide3<W>) {
    let mut rows = [W::zero(); LANES];
    for l in 0..LANES {
        rows[l] = W::load(velocities[slots[l] as usize].halves()[0]);
    }
    let [lx, ly, lz, ax, ay, az, _, _] = W::transpose(rows);
    (Wide3::new(lx, ly, lz), Wide3::new(ax, ay, az))
}

/// Displacements and turns of one side of a block since the start of the step.
#[inline(always)]
pub(crate) fn moved<W: Wide>(slots: &[u32; LANES], motions: &[BodyMotion]) -> (Wide3<W>, Wide3<W>) {
    let mut rows = [W::zero(); LANES];
    for l in 0..LANES {
        rows[l] = W::load(motions[slots[l] as usize].moved());
    }
    let [x, y, z, turn_x, turn_y, turn_z, _, _] = W::transpose(rows);
    (Wide3::new(x, y, z), Wide3::new(turn_x, turn_y, turn_z))
}

/// Where the bodies of one side of a block are, since the start of the step.
pub(crate) struct WidePoses<W> {
    pub displacement: Wide3<W>,
    pub turn: Wide3<W>,
    damping: [W; 2],
    pub rotation: WideQuat<W>,
    rest: [W; 4],
}

impl<W: Wide> WidePoses<W> {
    #[inline(always)]
    pub fn gather<M: Slots<BodyMotion> + ?Sized>(slots: &[u32; LANES], motions: &M) -> Self {
        let mut rows = [[W::zero(); LANES]; 2];
        for l in 0..LANES {
            let [first, second] = motions.get(slots[l]).halves();
            (rows[0][l], rows[1][l]) = (W::load(first), W::load(second));
        }
        let [x, y, z, turn_x, turn_y, turn_z, d0, d1] = W::transpose(rows[0]);
        let [qx, qy, qz, qw, r0, r1, r2, r3] = W::transpose(rows[1]);
        Self {
            displacement: Wide3::new(x, y, z),
            turn: Wide3::new(turn_x, turn_y, turn_z),
            damping: [d0, d1],
            rotation: WideQuat { v: Wide3::new(qx, qy, qz), w: qw },
            rest: [r0, r1, r2, r3],
        }
    }

    #[inline(always)]
    pub fn scatter<M: Slots<BodyMotion> + ?Sized>(&self, slots: &[u32; LANES], motions: &mut M) {
        let Self { displacement: d, turn: t, damping, rotation: q, rest } = self;
        let first = W::transpose([d.x, d.y, d.z, t.x, t.y, t.z, damping[0], damping[1]]);
        let second = W::transpose([q.v.x, q.v.y, q.v.z, q.w, rest[0], rest[1], rest[2], rest[3]]);
        for l in 0..LANES {
            let [a, b] = motions.get_mut(slots[l]).halves_mut();
            first[l].store(a);
            second[l].store(b);
        }
    }

    #[inline(always)]
    pub fn place(&self) -> WideMotion<W> {
        WideMotion { displacement: self.displacement, rotation: self.rotation }
    }

    /// Moves what can move by a displacement (m) and a rotation vector (rad); where nothing turns, rotations keep their bits.
    #[inline(always)]
    pub fn displace(&mut self, displacement: Wide3<W>, turn: Wide3<W>, most: f32) {
        let size = turn.dot(turn).sqrt();
        let most = W::splat(most);
        let turn = turn * W::select(size.above(most), most / size, W::splat(1.0));
        self.displacement = self.displacement + displacement;
        self.turn = self.turn + turn;
        let turned = self.rotation.turned(turn);
        let moves = size.above(W::zero());
        self.rotation = WideQuat {
            v: Wide3::new(
                W::select(moves, turned.v.x, self.rotation.v.x),
                W::select(moves, turned.v.y, self.rotation.v.y),
                W::select(moves, turned.v.z, self.rotation.v.z),
            ),
            w: W::select(moves, turned.w, self.rotation.w),
        };
    }
}

/// How the bodies of one side of a block are turned.
#[inline(always)]
pub(crate) fn gather_rotations<W: Wide>(slots: &[u32; LANES], motions: &[BodyMotion]) -> WideQuat<W> {
    let mut rows = [W::zero(); LANES];
    for l in 0..LANES {
        rows[l] = W::load(motions[slots[l] as usize].halves()[1]);
    }
    let [x, y, z, w, ..] = W::transpose(rows);
    WideQuat { v: Wide3::new(x, y, z), w }
}

/// Notes where the bodies of a block will be at the end of the substep: turned by `turn`, to `rotation`, and displaced since the
/// start of the step.
#[inline(always)]
pub(crate) fn scatter_outlooks<W: Wide>(
    slots: &[u32; LANES],
    turn: &WideQuat<W>,
    displacement: Wide3<W>,
    rotation: &WideQuat<W>,
    predicted_poses: &mut (impl Slots<PredictedPose> + ?Sized),
) {
    let (zero, t, q, d) = (W::zero(), turn, rotation, displacement);
    let first = W::transpose([t.v.x, t.v.y, t.v.z, t.w, zero, zero, zero, zero]);
    let second = W::transpose([q.v.x, q.v.y, q.v.z, q.w, d.x, d.y, d.z, zero]);
    for l in 0..LANES {
        let [a, b] = predicted_poses.get_mut(slots[l]).halves_mut();
        first[l].store(a);
        second[l].store(b);
    }
}

/// What the predicted substep turns the bodies of one side of a block by.
#[inline(always)]
pub(crate) fn gather_turns<W: Wide>(slots: &[u32; LANES], predicted_poses: &[PredictedPose]) -> WideQuat<W> {
    let mut rows = [W::zero(); LANES];
    for l in 0..LANES {
        rows[l] = W::load(predicted_poses[slots[l] as usize].halves()[0]);
    }
    let [x, y, z, w, ..] = W::transpose(rows);
    WideQuat { v: Wide3::new(x, y, z), w }
}

/// Where the bodies of one side of a block are: displacement since the start of the step (m), and rotation.
pub(crate) struct WideMotion<W> {
    pub displacement: Wide3<W>,
    pub rotation: WideQuat<W>,
}

impl<W: Wide> WideMotion<W> {
    /// At the end of the substep, as predicted.
    #[inline(always)]
    pub fn then(slots: &[u32; LANES], predicted_poses: &[PredictedPose]) -> Self {
        let mut rows = [W::zero(); LANES];
        for l in 0..LANES {
            rows[l] = W::load(predicted_poses[slots[l] as usize].halves()[1]);
        }
        let [qx, qy, qz, qw, x, y, z, _] = W::transpose(rows);
        Self { displacement: Wide3::new(x, y, z), rotation: WideQuat { v: Wide3::new(qx, qy, qz), w: qw } }
    }

    #[inline(always)]
    pub fn now(slots: &[u32; LANES], motions: &[BodyMotion]) -> Self {
        WidePoses::gather(slots, motions).place()
    }
}
