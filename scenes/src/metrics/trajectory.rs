//! A body's path against the path that it should take.

use longspan::glam::DVec3;

use super::{Errors, Metric, View, Worst};

type Path = Box<dyn FnMut(u32, f64) -> DVec3>;

/// Distance of a body's centre of mass from a reference path: the greatest and the root mean square (m).
pub struct TrajectoryError {
    body: usize,
    /// Position (m) after this many steps, at this time (s).
    reference: Path,
    max_name: &'static str,
    rms_name: Option<&'static str>,
    max: Worst,
    squares: f64,
    samples: u32,
}

impl TrajectoryError {
    /// `reference` gives the position (m) after a number of steps, at a time (s); asked in order of time.
    pub fn new(
        body: usize,
        max_name: &'static str,
        rms_name: Option<&'static str>,
        reference: impl FnMut(u32, f64) -> DVec3 + 'static,
    ) -> Self {
        Self { body, reference: Box::new(reference), max_name, rms_name, max: Worst::ZERO, squares: 0.0, samples: 0 }
    }
}

impl Metric for TrajectoryError {
    fn observe(&mut self, view: &View) {
        let error = view.center(self.body).distance((self.reference)(view.step, view.time));
        self.max.note(error);
        self.squares += error * error;
        self.samples += 1;
    }

    fn report(&self, errors: &mut Errors) {
        errors.push((self.max_name, self.max.value()));
        if let Some(name) = self.rms_name {
            errors.push((name, super::or_infinite((self.squares / f64::from(self.samples.max(1))).sqrt())));
        }
    }
}
