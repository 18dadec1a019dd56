//! Paths of bodies against the paths that they should take.

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

type Motion = Box<dyn FnMut(u32) -> Vec<DVec3>>;

/// `traj_err_max_m` and `traj_err_rms_m`: distance of the centres of bodies from a reference motion, the greatest and the root mean
/// square; `ref_err_m`: the greatest distance of that reference from one at coarser steps, so how far it can be trusted.
pub struct MotionError {
    bodies: Vec<usize>,
    reference: Motion,
    coarser: Motion,
    max: Worst,
    own: Worst,
    squares: f64,
    samples: u32,
}

impl MotionError {
    /// Both motions give the positions (m) of `bodies` after a number of steps; asked in order of time.
    pub fn new(
        bodies: Vec<usize>,
        reference: impl FnMut(u32) -> Vec<DVec3> + 'static,
        coarser: impl FnMut(u32) -> Vec<DVec3> + 'static,
    ) -> Self {
        let (reference, coarser): (Motion, Motion) = (Box::new(reference), Box::new(coarser));
        Self { bodies, reference, coarser, max: Worst::ZERO, own: Worst::ZERO, squares: 0.0, samples: 0 }
    }
}

impl Metric for MotionError {
    fn observe(&mut self, view: &View) {
        let (exact, coarse) = ((self.reference)(view.step), (self.coarser)(view.step));
        for ((&body, exact), coarse) in self.bodies.iter().zip(exact).zip(coarse) {
            let error = view.center(body).distance(exact);
            self.max.note(error);
            self.own.note(exact.distance(coarse));
            self.squares += error * error;
            self.samples += 1;
        }
    }

    fn report(&self, errors: &mut Errors) {
        let rms = super::or_infinite((self.squares / f64::from(self.samples.max(1))).sqrt());
        errors.extend([("traj_err_max_m", self.max.value()), ("traj_err_rms_m", rms), ("ref_err_m", self.own.value())]);
    }
}
