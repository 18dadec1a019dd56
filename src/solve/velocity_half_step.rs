//! Half-step correction of reported velocities.
//!
//! The velocity v that moves a body through a substep, x ← x + h v, is that of the substep's middle. Told at its end it is half a
//! substep old: a weight that swings up on a chain has ½ h m v·g too much energy, 0.22 % of m g L from the level at four substeps.
//! And a start from v takes it as half a substep old too, and falls by ½ h g t too far. So in islands whose rows can give no energy
//! (*joint_energy.rs*), with δ and δ' what the last substep and the one before have made of an island's velocities, and M its masses,
//!
//! ```text
//! told: v + ℓ,   ℓ = ½ δ · clamp(δᵀ M δ' / δᵀ M δ, 0, 1),
//! ```
//!
//! no more than δ' has of it, so that a blow is not told once and a half; as one share of the whole island, whose momenta it keeps. The next step takes ℓ back first, and its substeps go on as
//! if nothing had been said; in the first step of an island, when nothing has been told yet, the first substep keeps half of δ. That
//! is the leapfrog, of second order in h, with the velocities of its whole steps.

use super::state::{BodyMotion, BodyVelocity};
use crate::step_history::Twist;

fn twist(velocity: &BodyVelocity) -> Twist {
    [velocity.linear, velocity.angular]
}

fn difference(a: &Twist, b: &Twist) -> Twist {
    [a[0] - b[0], a[1] - b[1]]
}

fn add(velocity: &mut BodyVelocity, change: Twist, share: f32) {
    velocity.linear += change[0] * share;
    velocity.angular += change[1] * share;
}

/// What the bodies of a batch are told to be faster than they have moved, by slot.
#[derive(Debug, Default)]
pub(crate) struct HalfStepVelocities {
    /// What was told last; `None` where nothing was.
    pub told: Vec<Option<Twist>>,
    /// Whether a slot is that of a union: what is told of its members is not kept.
    united: Vec<bool>,
    /// Velocities at the start of this substep, and of the one before.
    start: Vec<Twist>,
    start_before: Vec<Twist>,
}

impl HalfStepVelocities {
    pub(crate) fn clear(&mut self) {
        self.told.clear();
        self.united.clear();
    }

    /// Whether velocities of this batch are carried on.
    fn is_active(&self) -> bool {
        !self.told.is_empty()
    }

    /// Takes back what was told, as `told` knows it of each slot; `united` says which are unions.
    pub(crate) fn take_back(
        &mut self,
        velocities: &mut [BodyVelocity],
        united: impl Fn(usize) -> bool,
        told: impl Fn(usize) -> Option<Twist>,
    ) {
        self.start.clear();
        for (slot, velocity) in velocities.iter_mut().enumerate() {
            self.united.push(united(slot));
            let lead = told(slot).filter(|_| !self.united[slot]);
            self.told.push(lead);
            let lead = lead.unwrap_or_default();
            add(velocity, lead, -1.0);
            let mut before = *velocity;
            add(&mut before, lead, -2.0);
            self.start.push(twist(&before));
        }
    }

    /// Makes room for a slot of which nothing is told.
    pub(crate) fn add_slot(&mut self, velocity: &BodyVelocity) {
        if self.is_active() {
            self.told.push(None);
            self.united.push(false);
            self.start.push(twist(velocity));
        }
    }

    /// Adds to what is told of a slot, where anything is kept of that.
    pub(crate) fn add_lead(&mut self, slot: usize, [linear, angular]: Twist) {
        if self.is_active() && !self.united[slot] {
            let [before, turning] = self.told[slot].unwrap_or_default();
            self.told[slot] = Some([before + linear, turning + angular]);
        }
    }

    /// Notes the velocities that this substep begins with, if it is the first or one of the last two.
    pub(crate) fn begin_substep(&mut self, velocities: &[BodyVelocity], substep: u32, substeps: u32) {
        if self.is_active() && (substep == 0 || substep + 2 >= substeps) {
            std::mem::swap(&mut self.start, &mut self.start_before);
            self.start.clear();
            self.start.extend(velocities.iter().map(twist));
        }
    }

    /// In the first substep of a step: where nothing was told of the bodies of an island, half of what it has made of their velocities.
    pub(crate) fn halve_start(&self, islands: impl Iterator<Item = std::ops::Range<usize>>, velocities: &mut [BodyVelocity]) {
        if !self.is_active() {
            return;
        }
        for slots in islands.filter(|slots| self.keeps(slots) && self.told[slots.clone()].iter().all(Option::is_none)) {
            for slot in slots {
                let [linear, angular] = self.start[slot];
                let velocity = &mut velocities[slot];
                velocity.linear = linear + (velocity.linear - linear) * 0.5;
                velocity.angular = angular + (velocity.angular - angular) * 0.5;
            }
        }
    }

    /// Whether what is told of all bodies of an island is kept.
    fn keeps(&self, slots: &std::ops::Range<usize>) -> bool {
        !self.united[slots.clone()].contains(&true)
    }

    /// Carries the velocities of these islands on to the end of the step.
    pub(crate) fn tell(
        &mut self,
        islands: impl Iterator<Item = std::ops::Range<usize>>,
        velocities: &mut [BodyVelocity],
        motions: &[BodyMotion],
    ) {
        if !self.is_active() {
            return;
        }
        self.told.fill(None);
        for slots in islands {
            if !self.keeps(&slots) {
                continue;
            }
            let (mut along, mut squared) = (0.0, 0.0);
            for slot in slots.clone() {
                let (velocity, motion) = (&velocities[slot], &motions[slot]);
                let change = difference(&twist(velocity), &self.start[slot]);
                let before = difference(&self.start[slot], &self.start_before[slot]);
                if motion.is_dynamic() {
                    let (mass, spin) = (1.0 / velocity.inverse_mass.x, motion.angular_momentum(change[1]));
                    along += f64::from(mass * change[0].dot(before[0]) + spin.dot(before[1]));
                    squared += f64::from(mass * change[0].length_squared() + spin.dot(change[1]));
                }
            }
            let share = if squared > 0.0 { 0.5 * (along / squared).clamp(0.0, 1.0) as f32 } else { 0.0 };
            for slot in slots {
                let lead = difference(&twist(&velocities[slot]), &self.start[slot]).map(|change| change * share);
                add(&mut velocities[slot], lead, 1.0);
                self.told[slot] = Some(lead);
            }
        }
    }
}
