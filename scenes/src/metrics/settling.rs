//! How soon what was put together loosely comes to rest, and whether it stays.

use longspan::glam::DVec3;

use super::{Errors, Metric, View, Worst};

/// `settled_s`: from when on every body is slower than 20 mm/s; `late_drift_m`: how far a body moves at most between a time by which
/// all should have settled and the end of the watch.
pub struct Settling {
    due: u32,
    until: u32,
    settled: f64,
    before: Vec<DVec3>,
    drift: Worst,
}

impl Settling {
    /// Slower than this is at rest (m/s).
    const SPEED: f32 = 0.02;

    /// Settled is due after `due` steps; watched until `until` steps.
    pub fn between(due: u32, until: u32) -> Self {
        Self { due, until, settled: 0.0, before: Vec::new(), drift: Worst::ZERO }
    }
}

impl Metric for Settling {
    fn observe(&mut self, view: &View) {
        if view.step > self.until {
            return;
        }
        if !view.dynamic().all(|body| view.engine.linear_velocity(body).length() < Self::SPEED) {
            self.settled = view.time;
        }
        if view.step == self.due {
            self.before = (0..view.bodies.len()).map(|body| view.center(body)).collect();
        } else if view.step == self.until && view.step > self.due {
            view.dynamic().for_each(|body| self.drift.note(view.center(body).distance(self.before[body])));
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("settled_s", self.settled), ("late_drift_m", self.drift.value())]);
    }
}
