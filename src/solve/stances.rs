//! What bodies without joints stand on and lean against, which says whether sweeps hold them.

use std::ops::Range;

use glam::Vec3;

use super::contact::{ContactInput, tangents};
use super::state::{BodyMotion, BodyVelocity};
use crate::tuning::plan::{ASIDE, BESIDE, LEANING, RESTING, SPARSE, STANDS};

/// Horizontal directions in which it is asked how far what bears a body reaches.
const DIRECTIONS: usize = 8;

/// What is known of a body's contacts.
#[derive(Debug, Clone, Copy)]
struct Stance {
    touches: bool,
    stands: bool,
    /// How far the points that it stands on are from below its centre of mass, at most, in each direction (m); and in any.
    reaches: [f32; DIRECTIONS],
    reach: f32,
    /// Whether a contact of it bears its load aside of the middle of its points.
    bears_aside: bool,
}

impl Stance {
    const NONE: Self =
        Self { touches: false, stands: false, reaches: [f32::NEG_INFINITY; DIRECTIONS], reach: 0.0, bears_aside: false };

    /// Whether it touches something and would fall over without what it leans against: nothing that it stands on is in some direction from
    /// below its centre of mass.
    fn leans(&self) -> bool {
        self.touches && self.reaches.iter().any(|&reach| reach < -BESIDE * self.reach || reach == f32::NEG_INFINITY)
    }
}

/// What the contacts of bodies of a batch say of them, by slot.
#[derive(Debug, Default)]
pub(super) struct Stances {
    list: Vec<Stance>,
}

/// What is known of the bodies of an island.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Standing {
    /// Bodies that lean on others by their sides alone.
    pub sideways: u32,
    /// Bodies that would fall over without what they lean against, those among them.
    pub leaning: u32,
    /// Whether a contact bears its load aside of its middle.
    pub is_uneven: bool,
}

impl Stances {
    /// Takes what these contacts say, of a batch with so many slots.
    pub(super) fn find<'a>(&mut self, slots: usize, contacts: impl Iterator<Item = &'a ContactInput>, gravity: Vec3) {
        self.list.clear();
        self.list.resize(slots, Stance::NONE);
        let up = -gravity.normalize_or_zero();
        let (east, north) = tangents(up);
        const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;
        let directions = [east, (east + north) * HALF, north, (north - east) * HALF];
        // Near ones too: in its first step nothing presses yet.
        for contact in contacts {
            let rise = contact.normal.dot(up);
            let bears_aside = is_aside(contact);
            let sides = [(contact.a, rise <= -STANDS, &contact.lever_a), (contact.b, rise >= STANDS, &contact.lever_b)];
            for (slot, stands, levers) in sides {
                let stance = &mut self.list[slot as usize];
                stance.touches = true;
                stance.bears_aside |= bears_aside;
                if !stands {
                    continue;
                }
                stance.stands = true;
                for lever in &levers[..contact.count] {
                    for (number, direction) in directions.iter().enumerate() {
                        let along = lever.dot(*direction);
                        let [there, back] = [number, number + DIRECTIONS / 2];
                        stance.reaches[there] = stance.reaches[there].max(along);
                        stance.reaches[back] = stance.reaches[back].max(-along);
                        stance.reach = stance.reach.max(along.abs());
                    }
                }
            }
        }
    }

    /// What is known of the bodies of these slots.
    pub(super) fn of(&self, slots: Range<u32>) -> Standing {
        let list = &self.list[slots.start as usize..slots.end as usize];
        let count = |holds: fn(&Stance) -> bool| list.iter().filter(|stance| holds(stance)).count() as u32;
        Standing {
            sideways: count(|stance| stance.touches && !stance.stands),
            leaning: count(Stance::leans),
            is_uneven: list.iter().any(|stance| stance.bears_aside),
        }
    }
}

/// Whether these bodies, with so many contacts, were put where they are, are at rest against one another and have few contacts: see [`SPARSE`].
pub(super) fn rests_sparsely(velocities: &[BodyVelocity], motions: &[BodyMotion], contacts: u32) -> bool {
    let is_sparse = (LEANING..=SPARSE * velocities.len() as u32).contains(&contacts);
    let is_slow = |velocity| is_slow(velocity, velocities[0].linear);
    is_sparse && motions.iter().all(|motion| motion.young) && velocities.iter().all(is_slow)
}

/// Whether a body is at rest against this velocity.
pub(super) fn is_slow(velocity: &BodyVelocity, frame: Vec3) -> bool {
    let (speed, spin) = (velocity.linear.distance_squared(frame), velocity.angular.length_squared());
    speed <= RESTING[0] * RESTING[0] && spin <= RESTING[1] * RESTING[1]
}

/// Whether a contact bears its load aside of the middle of its points, by more than [`ASIDE`] of the way to the farthest.
fn is_aside(contact: &ContactInput) -> bool {
    let (points, loads) = (&contact.lever_a[..contact.count], &contact.impulses.normal[..contact.count]);
    let load: f32 = loads.iter().sum();
    // Written so that a NaN is none.
    let bears = load > 0.0;
    if !bears {
        return false;
    }
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let center = points.iter().zip(loads).map(|(&point, &own)| point * own).sum::<Vec3>() / load;
    let reach = points.iter().map(|point| point.distance_squared(middle)).fold(0.0, f32::max);
    center.distance_squared(middle) > ASIDE * ASIDE * reach
}
