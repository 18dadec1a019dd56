//! Position recovery of islands in which heavier bodies stand on lighter ones.
//!
//! What the ground lifts a light body by, a sweep takes back for the most part where something heavy lies on it: a slab under a crate of 100
//! times its mass would come out of the floor within seconds, and sleep before. Of all displacements δ that take out what recovery asks for,
//! those with the least ½ δᵀ M δ are found as velocities are, but without friction.

use super::rows::{NewtonContact, ROWS, Six};
use super::{ContactIsland, ContactNewton, set, six};
use crate::solve::batch::Batch;
use crate::solve::contact_block::ContactBlocks;
use crate::solve::contact_kernels::asked_by_recovery;
use crate::solve::state::BodyVelocity;
use crate::tuning::uneven::LEFT;

/// Share of what recovery asks for at most at any point that may be missing.
const MISSING: f64 = 0.01;

impl ContactNewton {
    /// Finds pushes anew for uneven islands in which sweeps have left undone more than [`LEFT`] of the most that recovery asks for.
    pub(crate) fn recover(&mut self, batch: &Batch, pushes: &mut [BodyVelocity], dt: f32) {
        for number in 0..self.islands.len() {
            let island = self.islands[number];
            if !island.is_uneven {
                continue;
            }
            let Self { bodies, contacts, start, now, .. } = self;
            let contacts = &mut contacts[island.contacts()];
            contacts.iter_mut().for_each(|contact| contact.ask_apart(&batch.contacts, dt));
            now.clear();
            now.extend(bodies[island.bodies()].iter().map(|body| six(&pushes[body.slot as usize])));
            let (mut asked, mut undone) = (0.0_f64, 0.0_f64);
            for contact in &*contacts {
                asked = asked.max(contact.closing_speed(&contact.bias));
                undone = undone.max(contact.closing_speed(&contact.rates(now)));
            }
            if undone <= LEFT * asked {
                continue;
            }
            start.clear();
            start.resize(now.len(), Six::default());
            now.clone_from(start);
            if self.solve(&island, [MISSING * asked; 2]) {
                self.store_pushes(&island, pushes);
            }
        }
    }

    fn store_pushes(&mut self, island: &ContactIsland, pushes: &mut [BodyVelocity]) {
        let Self { bodies, contacts, start, now, .. } = self;
        let bodies = &bodies[island.bodies()];
        now.clone_from(start);
        contacts[island.contacts()].iter().for_each(|contact| contact.push(&contact.lambda, 1.0, bodies, now));
        for (body, now) in bodies.iter().zip(&*now) {
            set(&mut pushes[body.slot as usize], now);
        }
    }
}

impl NewtonContact {
    /// Asks for what recovery does along its normals, from no multipliers and without friction.
    fn ask_apart(&mut self, contacts: &ContactBlocks, dt: f32) {
        let (normals, lane) = (self.normals(), usize::from(self.lane));
        self.bias = [0.0; ROWS];
        for i in 0..normals {
            self.bias[i] = f64::from(asked_by_recovery(contacts.rows(self.block as usize, i).separation[lane], dt));
        }
        (self.warm, self.lambda, self.load) = ([0.0; ROWS], [0.0; ROWS], 0.0);
        (self.friction, self.twist_arm) = (0.0, 0.0);
    }
}
