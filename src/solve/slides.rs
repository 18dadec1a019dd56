//! Bodies that slide: where the velocity of a substep's end takes them too far or not far enough.
//!
//! Rows hold at the end of a substep, which moves bodies at its last velocity. A force that stays the same, as friction does on what slides,
//! has changed the velocity by Δv in the substep, and the true way is that at the mean of both velocities, longer by −½ h Δv. Left out, a
//! slide ends short of v²/(2 μ g) by half a substep of its first speed. What falls free has its parabola (*integrate.rs*); what sticks goes
//! with what it sticks to, which is right already.
//!
//! So a body all of whose contacts slide is moved by −½ h Δv once a step, if its velocity has changed in the step as the impulses of the
//! last substep would change it in each: a blow is no such force.

use std::ops::Range;

use glam::Vec3;

use super::contact::LANES;
use super::contact_block::ContactBlocks;
use super::state::{BodyMotion, BodyVelocity, MotionKind};
use crate::workers::Workers;

/// Blocks that are worth another thread's while to look through: some 2 µs.
const MIN_BLOCKS: usize = 64;

/// Share of what friction can give from which on a contact may slide: what it gives follows the load of the sweep before.
const LIMIT: f32 = 0.99;

/// Slip left after a substep, as a share of what friction has done to the velocity in it, from which on a contact slides: rows that stick leave
/// less than a thousandth.
const SLIP: f32 = 0.05;

/// Share by which the change of velocity in a step may differ from what the impulses of the last substep come to.
const UNSTEADY: f32 = 0.1;

/// Sine of the angle by which normals may differ along which one plane carries a body.
const FLAT: f32 = 1.0e-2;

/// What sliding bodies gain in a step.
#[derive(Debug, Default)]
pub(crate) struct Slides {
    /// Length of a substep (s).
    h: f32,
    /// Of each slot; none where nothing slides.
    changes: Vec<Change>,
    /// By part of the blocks: manifolds that are looked at closer.
    found: Vec<Vec<Loaded>>,
}

/// A manifold that presses, by block and lane, and the sum of its normal multipliers (N·s).
type Loaded = (usize, usize, f32);

#[derive(Debug, Clone, Copy)]
enum Change {
    None,
    Sticks,
    /// What impulses and forces as those of the last substep change the velocity by in a step (m/s), and the normal of what it slides on.
    By {
        steady: Vec3,
        normal: Vec3,
    },
}

impl Slides {
    pub(crate) fn clear(&mut self) {
        self.changes.clear();
    }

    /// Way beyond that of the velocities at the ends of substeps, of the body in this slot, whose velocity has changed so in the step (m).
    pub(crate) fn way(&self, slot: usize, change: Vec3) -> Vec3 {
        match self.changes.get(slot) {
            Some(&Change::By { steady, normal }) if (change - steady).length() <= UNSTEADY * steady.length() => {
                change.reject_from(normal) * (-0.5 * self.h)
            }
            _ => Vec3::ZERO,
        }
    }

    /// Finds what slides at the end of a step of so many substeps of length `h` (s).
    pub(crate) fn find(
        &mut self,
        contacts: &ContactBlocks,
        velocities: &[BodyVelocity],
        motions: &[BodyMotion],
        (h, substeps): (f32, u32),
        threads: &Workers,
    ) {
        let Self { changes, found, .. } = self;
        self.h = h;
        list(contacts, found, threads, |lane, load| slides(contacts, velocities, lane, load));
        for &(block, lane, _) in found.iter().flatten() {
            changes.resize(velocities.len(), Change::None);
            let own = &contacts.blocks[block];
            let slots = [own.a[lane], own.b[lane]].map(|slot| slot as usize);
            // What the host accelerates has velocities of the middles of substeps, and what slides along with it moves as it does.
            if slots.iter().any(|&slot| motions[slot].kind == MotionKind::Kinematic && motions[slot].acceleration != Vec3::ZERO) {
                continue;
            }
            for slot in slots {
                let motion = &motions[slot];
                if motion.is_dynamic() && !motion.jointed && !motion.direct {
                    let steady = motion.acceleration * (h * substeps as f32);
                    changes[slot] = Change::By { steady, normal: own.normal_of(lane) };
                }
            }
        }
        if changes.is_empty() {
            return;
        }
        list(contacts, found, threads, |(block, lane), _| {
            let own = &contacts.blocks[block];
            [own.a[lane], own.b[lane]].iter().any(|&slot| matches!(changes[slot as usize], Change::By { .. }))
        });
        for &(block, lane, load) in found.iter().flatten() {
            let own = &contacts.blocks[block];
            let across = own.normal_of(lane);
            let impulse = across * load + contacts.impulses(block, lane).friction;
            for (slot, sign) in [(own.a[lane], -1.0), (own.b[lane], 1.0)] {
                let change = &mut changes[slot as usize];
                let Change::By { steady, normal } = change else { continue };
                if across.cross(*normal).length() > FLAT || !slides(contacts, velocities, (block, lane), load) {
                    *change = Change::Sticks;
                } else {
                    *steady += velocities[slot as usize].inverse_mass * impulse * (sign * substeps as f32);
                }
            }
        }
    }
}

/// Lists the loaded manifolds of which `is_asked` says so, part after part, on all threads.
fn list(
    contacts: &ContactBlocks,
    found: &mut Vec<Vec<Loaded>>,
    threads: &Workers,
    is_asked: impl Fn((usize, usize), f32) -> bool + Sync,
) {
    let piece = if threads.has_team() { threads.piece(contacts.len(), MIN_BLOCKS) } else { contacts.len().max(1) };
    let parts = contacts.len().div_ceil(piece);
    if found.len() < parts {
        found.resize_with(parts, Vec::new);
    }
    found.iter_mut().for_each(Vec::clear);
    threads.share(found.iter_mut().zip((0..contacts.len()).step_by(piece)), |(found, first)| {
        let blocks = first..contacts.len().min(first + piece);
        found.extend(loaded(contacts, blocks).filter(|&(block, lane, load)| is_asked((block, lane), load)));
    });
}

/// Manifolds that press, by block and lane, and the sums of their normal multipliers (N·s).
fn loaded(contacts: &ContactBlocks, blocks: Range<usize>) -> impl Iterator<Item = Loaded> {
    let lanes = blocks.flat_map(|block| (0..LANES).map(move |lane| (block, lane)));
    let load = |(block, lane): (usize, usize)| {
        let points = usize::from(contacts.blocks[block].count[lane]);
        (block, lane, (0..points).map(|point| contacts.rows(block, point).lambda[lane]).sum::<f32>())
    };
    lanes.map(load).filter(|&(.., load)| load > 0.0)
}

/// Whether the surfaces of a manifold slide across each other, and friction does what it can.
fn slides(contacts: &ContactBlocks, velocities: &[BodyVelocity], (block, lane): (usize, usize), load: f32) -> bool {
    let own = &contacts.blocks[block];
    let [t1, t2] = own.tangent_lambda.map(|lanes| lanes[lane]);
    let friction = (t1 * t1 + t2 * t2).sqrt();
    if friction < LIMIT * own.friction[lane] * load {
        return false;
    }
    let (center_a, center_b) = contacts.centers_of(block, lane);
    let [a, b] = [own.a, own.b].map(|slots| &velocities[slots[lane] as usize]);
    let slip = (b.linear + b.angular.cross(center_b) - a.linear - a.angular.cross(center_a)).reject_from(own.normal_of(lane));
    let done = friction * a.inverse_mass.max_element().max(b.inverse_mass.max_element());
    slip.length() > SLIP * done
}
