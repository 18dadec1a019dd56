//! What bodies without joints stand on and lean against, which says whether sweeps hold them.

use std::f32::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use glam::{Vec3, Vec4};

use super::contact::{ContactInput, tangents};
use super::state::{BodyMotion, BodyVelocity};
use crate::tuning::plan::{ASIDE, BESIDE, LEANING, RESTING, SPARSE, STANDS};

/// What is known of a body's contacts.
#[derive(Debug, Clone, Copy)]
struct Stance {
    touches: bool,
    stands: bool,
    /// How far the points that it stands on are from below its centre of mass, at most, in eight horizontal directions: four, and back (m).
    reaches: [Vec4; 2],
    /// Whether a contact of it bears its load aside of the middle of its points.
    bears_aside: bool,
}

impl Stance {
    const NONE: Self = Self { touches: false, stands: false, reaches: [Vec4::NEG_INFINITY; 2], bears_aside: false };

    /// Whether it touches something and would fall over without what it leans against: nothing that it stands on is in some direction from
    /// below its centre of mass.
    fn leans(&self) -> bool {
        let [there, back] = self.reaches;
        let (most, least) = (there.max(back).max_element(), there.min(back).min_element());
        self.touches && (least < -BESIDE * most || !self.stands)
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
    /// Takes what these contacts say, of a batch with so many slots; `asks_for_loads` is whether it is asked where they bear them.
    pub(super) fn find<'a>(
        &mut self,
        slots: usize,
        contacts: impl Iterator<Item = &'a ContactInput>,
        gravity: Vec3,
        asks_for_loads: bool,
    ) {
        self.list.clear();
        self.list.resize(slots, Stance::NONE);
        let up = -gravity.normalize_or_zero();
        let (east, north) = tangents(up);
        // Near ones too: in its first step nothing presses yet.
        for contact in contacts {
            let rise = contact.normal.dot(up);
            let bears_aside = asks_for_loads && is_aside(contact);
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
                    let (x, y) = (lever.dot(east), lever.dot(north));
                    let along = Vec4::new(x, (x + y) * FRAC_1_SQRT_2, y, (y - x) * FRAC_1_SQRT_2);
                    stance.reaches = [stance.reaches[0].max(along), stance.reaches[1].max(-along)];
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
