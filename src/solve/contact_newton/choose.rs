//! Chooses the islands that are solved at once, and lists their bodies and contacts.

use glam::Vec3;

use super::rows::{ExactBody, FIXED, NewtonContact};
use super::{COMPLIANCE, ContactIsland, ContactNewton, TOLERANCE};
use crate::solve::batch::Batch;
use crate::solve::contact::LANES;
use crate::solve::state::{BodyMotion, BodyVelocity};
use crate::tuning::blows::{SLIGHT, STRUCK};
use crate::tuning::needles::NEEDLE;
use crate::tuning::uneven::{LEFT, LEFT_WHILE_MOVING};

/// Most bodies and manifolds of an island that is solved here: more take longer than they are worth.
const MAX_BODIES: usize = 16;
const MAX_CONTACTS: usize = 32;

/// The same of an island in which bodies strike, and nothing heavy stands on something light: a step with a blow in each substep takes a
/// millisecond.
const MAX_STRIKING: usize = 6;
const MAX_STRIKES: usize = 16;

/// Least cosine between a contact's normal and the vertical for one body to stand on the other.
const MIN_RISE: f64 = 0.3;

impl ContactNewton {
    /// Finds the islands that need it, and their rows; `h` is the substep (s), in which contacts are swept so many times.
    pub(crate) fn prepare(&mut self, batch: &Batch, gravity: Vec3, h: f32, sweeps: u32) {
        self.islands.clear();
        self.bodies.clear();
        self.contacts.clear();
        let gained = gravity.length() * h;
        let blow = STRUCK * gained + SLIGHT;
        self.blow = f64::from(blow);
        self.tolerance = TOLERANCE * f64::from(if gained > 0.0 { gained } else { SLIGHT });
        self.local.clear();
        let end = batch.moving() + 1;
        let moves = |velocity: &BodyVelocity| (velocity.linear, velocity.angular) != (Vec3::ZERO, Vec3::ZERO);
        let is_pushed = batch.velocities[end..].iter().any(moves);
        for (number, &first) in batch.islands.iter().enumerate() {
            let end = batch.islands.get(number + 1).map_or(end, |&next| next as usize);
            let slots = first as usize..end;
            let (velocities, motions) = (&batch.velocities[slots.clone()], &batch.motions[slots.clone()]);
            let Some(ratio) = mass_ratio(velocities, motions) else { continue };
            // What is hit at its rim turns many times in a substep: its blows are no problem of one instant.
            let left = left_by_sweeps(ratio, sweeps);
            if left <= LEFT_WHILE_MOVING && motions.iter().any(is_needle) {
                continue;
            }
            let is_fast = is_fast(velocities, motions, blow);
            if left > LEFT || is_fast || is_pushed {
                self.enlist(batch, slots, is_fast);
            }
        }
        if self.islands.is_empty() {
            return;
        }
        self.list_contacts(batch);
        let Self { islands, bodies, contacts, above, .. } = self;
        let up = -gravity.normalize_or_zero();
        // One of its own sides: what moves elsewhere is no concern of an island.
        let pushes = |contact: &NewtonContact| {
            let mut sides = contact.bodies.iter().zip(contact.slots);
            sides.any(|(&body, slot)| body == FIXED && moves(&batch.velocities[slot as usize]))
        };
        islands.retain_mut(|island| {
            let (bodies, contacts) = (&bodies[island.bodies()], &contacts[island.contacts()]);
            let strikes = || island.is_fast || contacts.iter().any(pushes);
            let is_small = bodies.len() <= MAX_STRIKING && contacts.len() <= MAX_STRIKES;
            let most_left = if is_small || !island.is_fast { LEFT } else { LEFT_WHILE_MOVING };
            island.is_uneven = left_by_sweeps(carried_ratio(bodies, contacts, up, above), sweeps) > most_left;
            contacts.len() <= MAX_CONTACTS && (island.is_uneven || is_small && strikes())
        });
    }

    fn enlist(&mut self, batch: &Batch, slots: std::ops::Range<usize>, is_fast: bool) {
        self.local.resize(batch.velocities.len(), FIXED);
        let (first, number) = (self.bodies.len() as u32, self.islands.len() as u32);
        for slot in slots.filter(|&slot| batch.motions[slot].is_dynamic()) {
            let velocity = &batch.velocities[slot];
            let inverse_inertia = velocity.inverse_inertia.to_mat3().as_dmat3();
            self.local[slot] = self.bodies.len() as u32 - first;
            self.bodies.push(ExactBody {
                slot: slot as u32,
                island: number,
                mass: 1.0 / f64::from(velocity.inverse_mass.x),
                inertia: inverse_inertia.inverse(),
                inverse_inertia,
            });
        }
        self.islands.push(ContactIsland {
            bodies: (first, self.bodies.len() as u32),
            contacts: (0, 0),
            compliance: 0.0,
            gave_up: false,
            ratio: 1.0,
            is_fast,
            is_uneven: false,
            is_struck: false,
        });
    }

    /// Lists the manifolds of all islands, sorted by island.
    fn list_contacts(&mut self, batch: &Batch) {
        for (number, block) in batch.contacts.blocks.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| block.count[lane] > 0) {
                let slots = [block.a[lane], block.b[lane]];
                let locals = slots.map(|slot| self.local[slot as usize]);
                let Some(side) = locals.iter().position(|&local| local != FIXED) else { continue };
                let owner = self.bodies.partition_point(|body| body.slot < slots[side]);
                let mut contact = NewtonContact::new(&batch.contacts, number as u32, lane, locals);
                contact.island = self.bodies[owner].island;
                self.contacts.push(contact);
            }
        }
        self.contacts.sort_unstable_by_key(|contact| (contact.island, contact.block, contact.lane));
        for (number, island) in self.islands.iter_mut().enumerate() {
            let first = self.contacts.partition_point(|contact| contact.island < number as u32);
            let end = self.contacts.partition_point(|contact| contact.island <= number as u32);
            island.contacts = (first as u32, end as u32);
            let bodies = &self.bodies[island.bodies()];
            let masses = bodies.iter().map(|body| body.mass);
            let (least, most) = masses.fold((f64::INFINITY, 0.0_f64), |(least, most), mass| (least.min(mass), most.max(mass)));
            (island.compliance, island.ratio) = (COMPLIANCE * least / most, most / least);
            self.contacts[first..end].iter_mut().for_each(|contact| contact.find_masses(bodies));
        }
    }
}

/// How much heavier the heaviest body of an island is than the lightest; none where it has one body or more than a few, or where any is not
/// free in all directions.
fn mass_ratio(velocities: &[BodyVelocity], motions: &[BodyMotion]) -> Option<f64> {
    if velocities.len() > MAX_BODIES + motions.iter().filter(|motion| !motion.is_dynamic()).count() {
        return None;
    }
    let (mut least, mut most, mut count) = (f32::INFINITY, 0.0_f32, 0);
    for (velocity, motion) in velocities.iter().zip(motions).filter(|(_, motion)| motion.is_dynamic()) {
        let inverse_mass = velocity.inverse_mass;
        if motion.jointed || inverse_mass.min_element() != inverse_mass.max_element() || !motion.is_free_to_turn() {
            return None;
        }
        (least, most, count) = (least.min(inverse_mass.x), most.max(inverse_mass.x), count + 1);
    }
    (least > 0.0 && count > 1).then(|| f64::from(most / least))
}

/// Whether a body is so slender that it spins far more easily than it turns over: see [`NEEDLE`].
fn is_needle(motion: &BodyMotion) -> bool {
    motion.inertia.min_element() < NEEDLE * motion.inertia.max_element()
}

/// Whether any of these bodies, or a point of it at its radius of gyration, is faster than `blow` (m/s).
fn is_fast(velocities: &[BodyVelocity], motions: &[BodyMotion], blow: f32) -> bool {
    velocities.iter().zip(motions).any(|(velocity, motion)| {
        let gyration_squared = motion.inertia.max_element() * velocity.inverse_mass.max_element();
        let squared = velocity.linear.length_squared().max(velocity.angular.length_squared() * gyration_squared);
        squared > blow * blow
    })
}

/// Share of an error in the load of a body that so many sweeps leave under one that is `ratio` times heavier. One that visits the contact
/// between them takes back what that below has given, but for the lighter body's share of both masses.
pub(in crate::solve) fn left_by_sweeps(ratio: f64, sweeps: u32) -> f64 {
    let by_one = ratio / (1.0 + ratio);
    (0..sweeps).fold(1.0, |left, _| left * by_one)
}

/// How many times heavier than a body at most something is that stands on it, over however many others.
fn carried_ratio(bodies: &[ExactBody], contacts: &[NewtonContact], up: Vec3, above: &mut Vec<f64>) -> f64 {
    above.clear();
    above.resize(bodies.len(), 0.0);
    for _ in 0..bodies.len() {
        let mut grew = false;
        for contact in contacts.iter().filter(|contact| !contact.bodies.contains(&FIXED)) {
            let [a, b] = contact.bodies.map(|body| body as usize);
            let rise = contact.rise(up);
            let (lower, upper) = if rise > 0.0 { (a, b) } else { (b, a) };
            let carried = above[upper].max(bodies[upper].mass);
            if rise.abs() >= MIN_RISE && carried > above[lower] {
                above[lower] = carried;
                grew = true;
            }
        }
        if !grew {
            break;
        }
    }
    bodies.iter().zip(above).fold(0.0_f64, |most, (body, above)| most.max(*above / body.mass))
}
