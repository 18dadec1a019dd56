//! Conjugate search directions over the velocities of all bodies in lanes, two at once (*solve/joint_mesh.rs*).

use super::{PoseBlock, WideBodies};
use crate::lanes::wide::{Wide, Wide3};
use crate::linalg::rotation32::NEGLIGIBLE_PUSH;
use crate::platform::in_lanes;
use crate::solve::body_gather::{WidePoses, WideVelocities, gather_rotations};
use crate::solve::contact::{Lane, Lane3};
use crate::solve::disjoint::{DisjointMut, Shared};
use crate::solve::state::{BodyMotion, BodyVelocity, MAX_PUSH_TURN};
use crate::solve::wide_matrix::rotated_in_lanes;
use crate::solve::wide_matrix::{Wide6, WideQuat};
use crate::workers::Workers;

/// What is known of eight bodies: masses, where they come from, and where they went last.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct BodyDirectionEntry {
    mass: Lane,
    inertia: [Lane; 6],
    /// Linear and angular velocity before the last sweeps, and what the last move changed it by.
    before: [Lane3; 2],
    way: [Lane3; 2],
}

impl BodyDirectionEntry {
    const EMPTY: Self = Self { mass: [0.0; 8], inertia: [[0.0; 8]; 6], before: [[[0.0; 8]; 3]; 2], way: [[[0.0; 8]; 3]; 2] };
}

/// Stations of the blocks of [`WideBodies`].
#[derive(Debug, Default)]
pub(crate) struct BodyDirections {
    direction_entries: Vec<BodyDirectionEntry>,
    /// Products of the pieces that threads go through.
    products: Vec<Products>,
}

/// Products with M of what sweeps have changed velocities by (d), of the last move (p), and of the velocities before (v).
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Products {
    pub dd: f64,
    pub dp: f64,
    pub pp: f64,
    pub vd: f64,
    pub vp: f64,
}

impl Products {
    fn plus(self, other: &Self) -> Self {
        Self {
            dd: self.dd + other.dd,
            dp: self.dp + other.dp,
            pp: self.pp + other.pp,
            vd: self.vd + other.vd,
            vp: self.vp + other.vp,
        }
    }
}

/// Blocks of bodies that one thread goes through. Sums are those of pieces, so it must not depend on the number of threads.
const PIECE: usize = 64;

impl WideBodies {
    /// Finds masses as the bodies stand now.
    pub(crate) fn begin_course(
        &self,
        search: &mut BodyDirections,
        threads: &Workers,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
    ) {
        search.direction_entries.resize(self.blocks.len(), BodyDirectionEntry::EMPTY);
        let pieces = self.blocks.chunks(PIECE).zip(search.direction_entries.chunks_mut(PIECE));
        threads.share(pieces, |(blocks, direction_entries)| begin_all(blocks, direction_entries, velocities, motions));
    }

    /// Notes the velocities that sweeps begin with.
    pub(crate) fn note_course(&self, search: &mut BodyDirections, threads: &Workers, velocities: &[BodyVelocity]) {
        let pieces = self.blocks.chunks(PIECE).zip(search.direction_entries.chunks_mut(PIECE));
        threads.share(pieces, |(blocks, direction_entries)| note_all(blocks, direction_entries, velocities));
    }

    /// Takes these velocities for the last move.
    pub(crate) fn take_way(&self, search: &mut BodyDirections, threads: &Workers, ways: &[BodyVelocity]) {
        let pieces = self.blocks.chunks(PIECE).zip(search.direction_entries.chunks_mut(PIECE));
        threads.share(pieces, |(blocks, direction_entries)| take_all(blocks, direction_entries, ways));
    }

    pub(crate) fn weigh_course(&self, search: &mut BodyDirections, threads: &Workers, velocities: &[BodyVelocity]) -> Products {
        let BodyDirections { direction_entries, products } = search;
        products.resize(self.blocks.len().div_ceil(PIECE), Products::default());
        let pieces = self.blocks.chunks(PIECE).zip(direction_entries.chunks(PIECE)).zip(&mut *products);
        threads
            .share(pieces, |((blocks, direction_entries), products)| weigh_all(blocks, direction_entries, velocities, products));
        products.iter().fold(Products::default(), Products::plus)
    }

    /// Displaces bodies by `pushes` (m, rad): as [`BodyMotion::displace`], to the same bits.
    pub(crate) fn displace(&self, threads: &Workers, motions: &mut [BodyMotion], pushes: &[BodyVelocity]) {
        let motions = Shared::new(motions, self.last);
        threads.share(self.blocks.chunks(PIECE), |blocks| {
            // SAFETY: each slot is in one block, which one thread goes through.
            displace_all(blocks, &mut unsafe { motions.hand() }, pushes);
        });
    }

    /// Moves from the velocities before by p ← α d + β p.
    pub(crate) fn steer_course(
        &self,
        search: &mut BodyDirections,
        threads: &Workers,
        (velocities, moving): (&mut [BodyVelocity], usize),
        shares: [f32; 2],
    ) {
        let velocities = Shared::new(velocities, moving);
        let pieces = self.blocks.chunks(PIECE).zip(search.direction_entries.chunks_mut(PIECE));
        threads.share(pieces, |(blocks, direction_entries)| {
            // SAFETY: each slot is in one block, which one thread goes through.
            steer_all(blocks, direction_entries, &mut unsafe { velocities.hand() }, shares);
        });
    }
}

in_lanes!(begin_all, begin, (blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], velocities: &[BodyVelocity], motions: &[BodyMotion]));
in_lanes!(note_all, note, (blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], velocities: &[BodyVelocity]));
in_lanes!(take_all, take, (blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], ways: &[BodyVelocity]));
in_lanes!(weigh_all, weigh, (blocks: &[PoseBlock], direction_entries: &[BodyDirectionEntry], velocities: &[BodyVelocity], products: &mut Products));
in_lanes!(displace_all, displace, (blocks: &[PoseBlock], motions: &mut DisjointMut<'_, BodyMotion>, pushes: &[BodyVelocity]));
in_lanes!(
    steer_all, steer,
    (blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], velocities: &mut DisjointMut<'_, BodyVelocity>, shares: [f32; 2])
);

#[inline(always)]
fn begin<W: Wide>(
    blocks: &[PoseBlock],
    direction_entries: &mut [BodyDirectionEntry],
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
) {
    for (block, direction_entry) in blocks.iter().zip(direction_entries) {
        let inverse = WideVelocities::<W>::gather(&block.slots, velocities).inverse_mass().x;
        // Unused lanes are the world.
        let moves = inverse.above(W::zero());
        W::select(moves, W::splat(1.0) / inverse, W::zero()).store(&mut direction_entry.mass);
        let axes = gather_rotations::<W>(&block.slots, motions).after(&WideQuat::load(&block.frame)).axes();
        Wide6::with_axes(&axes, Wide3::load(&block.inertia).only(moves)).store(&mut direction_entry.inertia);
    }
}

#[inline(always)]
fn note<W: Wide>(blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], velocities: &[BodyVelocity]) {
    for (block, direction_entry) in blocks.iter().zip(direction_entries) {
        let side = WideVelocities::<W>::gather(&block.slots, velocities);
        side.linear.store(&mut direction_entry.before[0]);
        side.angular.store(&mut direction_entry.before[1]);
    }
}

#[inline(always)]
fn take<W: Wide>(blocks: &[PoseBlock], direction_entries: &mut [BodyDirectionEntry], ways: &[BodyVelocity]) {
    for (block, direction_entry) in blocks.iter().zip(direction_entries) {
        let side = WideVelocities::<W>::gather(&block.slots, ways);
        side.linear.store(&mut direction_entry.way[0]);
        side.angular.store(&mut direction_entry.way[1]);
    }
}

#[inline(always)]
fn weigh<W: Wide>(
    blocks: &[PoseBlock],
    direction_entries: &[BodyDirectionEntry],
    velocities: &[BodyVelocity],
    products: &mut Products,
) {
    let mut sums = [W::zero(); 5];
    for (block, direction_entry) in blocks.iter().zip(direction_entries) {
        let side = WideVelocities::<W>::gather(&block.slots, velocities);
        let (mass, inertia) = (W::load(&direction_entry.mass), Wide6::<W>::load(&direction_entry.inertia));
        let v = [Wide3::load(&direction_entry.before[0]), Wide3::load(&direction_entry.before[1])];
        let p = [Wide3::load(&direction_entry.way[0]), Wide3::load(&direction_entry.way[1])];
        let d = [side.linear - v[0], side.angular - v[1]];
        let momentum = [d[0] * mass, inertia.mul(d[1])];
        sums[0] = sums[0] + (d[0].dot(momentum[0]) + d[1].dot(momentum[1]));
        sums[1] = sums[1] + (p[0].dot(momentum[0]) + p[1].dot(momentum[1]));
        sums[3] = sums[3] + (v[0].dot(momentum[0]) + v[1].dot(momentum[1]));
        let momentum = [p[0] * mass, inertia.mul(p[1])];
        sums[2] = sums[2] + (p[0].dot(momentum[0]) + p[1].dot(momentum[1]));
        sums[4] = sums[4] + (v[0].dot(momentum[0]) + v[1].dot(momentum[1]));
    }
    let [mut dd, mut dp, mut pp, mut vd, mut vp] = [[0.0; 8]; 5];
    sums[0].store(&mut dd);
    sums[1].store(&mut dp);
    sums[2].store(&mut pp);
    sums[3].store(&mut vd);
    sums[4].store(&mut vp);
    *products = Products { dd: total(&dd), dp: total(&dp), pp: total(&pp), vd: total(&vd), vp: total(&vp) };
}

fn total(lanes: &Lane) -> f64 {
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}

#[inline(always)]
fn steer<W: Wide>(
    blocks: &[PoseBlock],
    direction_entries: &mut [BodyDirectionEntry],
    velocities: &mut DisjointMut<'_, BodyVelocity>,
    shares: [f32; 2],
) {
    let (alpha, beta) = (W::splat(shares[0]), W::splat(shares[1]));
    for (block, direction_entry) in blocks.iter().zip(direction_entries) {
        let mut side = WideVelocities::<W>::gather(&block.slots, velocities);
        let [linear, angular] = [Wide3::load(&direction_entry.before[0]), Wide3::load(&direction_entry.before[1])];
        let way = [
            (side.linear - linear) * alpha + Wide3::load(&direction_entry.way[0]) * beta,
            (side.angular - angular) * alpha + Wide3::load(&direction_entry.way[1]) * beta,
        ];
        (side.linear, side.angular) = (linear + way[0], angular + way[1]);
        side.scatter(&block.slots, velocities);
        way[0].store(&mut direction_entry.way[0]);
        way[1].store(&mut direction_entry.way[1]);
    }
}

#[inline(always)]
fn displace<W: Wide>(blocks: &[PoseBlock], motions: &mut DisjointMut<'_, BodyMotion>, pushes: &[BodyVelocity]) {
    let most = W::splat(MAX_PUSH_TURN);
    for block in blocks {
        let side = WideVelocities::<W>::gather(&block.slots, pushes);
        let mut stand = WidePoses::gather(&block.slots, motions);
        // Unused lanes are the world.
        let moves = side.inverse_mass().x.above(W::zero());
        let angular = side.angular.settled(NEGLIGIBLE_PUSH);
        let squared = angular.dot(angular);
        let (is_far, length) = (squared.above(most * most), squared.sqrt());
        let turn = Wide3::new(
            W::select(is_far, most * (angular.x / length), angular.x),
            W::select(is_far, most * (angular.y / length), angular.y),
            W::select(is_far, most * (angular.z / length), angular.z),
        );
        stand.displacement = stand.displacement + side.linear.settled(NEGLIGIBLE_PUSH).only(moves);
        stand.turn = stand.turn + turn.only(moves);
        stand.rotation = WideQuat::select(moves, rotated_in_lanes(&stand.rotation, turn), stand.rotation);
        stand.scatter(&block.slots, motions);
    }
}
