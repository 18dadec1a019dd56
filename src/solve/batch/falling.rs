//! Islands that fall: their bodies touch each other, and nothing that stands.
//!
//! A substep moves bodies by the velocities at its end, which have gained the whole substep's acceleration g h: they fall ½ g h t too far.
//! A body that touches nothing is put back by ½ g h² in each substep (*integrate.rs*). So are all bodies of an island that falls, by the same
//! way: nothing changes between them, and what flies among them, an island of its own, does not meet them by falling otherwise.

use glam::Vec3;

use super::super::state::Constraints;
use super::Batch;

impl Batch {
    /// Marks the bodies of islands without joints that fall as a whole.
    pub(crate) fn mark_falling(&mut self) {
        let end = self.moving() + 1;
        self.note_contacts();
        let Self { islands, notes, body_flags, motions, .. } = self;
        for number in (0..islands.len()).filter(|&number| !notes[number].is_held) {
            let next = islands.get(number + 1).map_or(end, |&next| next as usize);
            let slots = islands[number] as usize..next;
            let (fall, damping) = (motions[slots.start].acceleration, motions[slots.start].linear_damping);
            let falls = |slot: usize| {
                let (motion, flags) = (&motions[slot], body_flags[slot]);
                motion.acceleration == fall && motion.linear_damping == damping && flags.is_loose() && flags.is_unlocked()
            };
            if slots.len() > 1 && fall != Vec3::ZERO && slots.clone().all(falls) {
                motions[slots].iter_mut().for_each(|motion| motion.constraints = Constraints::Falling);
            }
        }
    }
}
