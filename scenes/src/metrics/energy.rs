//! Energy and momentum of a run, in `f64` from poses and velocities.

use longspan::glam::DVec3;

use super::{Errors, Metric, View, Worst, or_infinite, world_inertia};

/// Kinetic and potential energy of a body (J), heights taken from the scene's origin.
pub fn energy_of(view: &View, body: usize) -> f64 {
    let Some(mass) = view.mass(body) else { return 0.0 };
    let (v, w) = (view.engine.linear_velocity(body).as_dvec3(), view.engine.angular_velocity(body).as_dvec3());
    let inertia = world_inertia(&mass, &view.engine.pose(body));
    let fall = view.gravity.as_dvec3() * f64::from(view.bodies[body].gravity_scale);
    let m = f64::from(mass.mass);
    0.5 * m * v.length_squared() + 0.5 * w.dot(inertia * w) - m * fall.dot(view.center(body))
}

pub(super) fn total_energy(view: &View) -> f64 {
    view.dynamic().map(|body| energy_of(view, body)).sum()
}

/// How far the total energy leaves its start, at worst: `name` either way, `rise_name` upwards, in per cent of a scale.
pub struct EnergyError {
    name: &'static str,
    rise_name: Option<&'static str>,
    scale: Option<f64>,
    start: f64,
    error: Worst,
    rise: Worst,
}

impl EnergyError {
    /// In per cent of `scale` (J), of the energy at the start if `None`.
    pub fn new(name: &'static str, rise_name: Option<&'static str>, scale: Option<f64>) -> Self {
        Self { name, rise_name, scale, start: 0.0, error: Worst::ZERO, rise: Worst::ZERO }
    }
}

impl Metric for EnergyError {
    fn observe(&mut self, view: &View) {
        let energy = total_energy(view);
        if view.step == 0 {
            self.start = energy;
            return;
        }
        let gained = 100.0 * (energy - self.start) / self.scale.unwrap_or(self.start.abs());
        self.error.note(gained.abs());
        self.rise.note(gained);
    }

    fn report(&self, errors: &mut Errors) {
        errors.push((self.name, self.error.value()));
        if let Some(name) = self.rise_name {
            errors.push((name, self.rise.value()));
        }
    }
}

/// The greatest rise of total energy above its start after the first step, in per cent of a scale; negative if it never rose.
pub struct EnergyRise {
    name: &'static str,
    scale: f64,
    start: f64,
    greatest: f64,
}

impl EnergyRise {
    /// In per cent of `scale` (J).
    pub fn new(name: &'static str, scale: f64) -> Self {
        Self { name, scale, start: 0.0, greatest: f64::NEG_INFINITY }
    }
}

impl Metric for EnergyRise {
    fn observe(&mut self, view: &View) {
        let energy = total_energy(view);
        if view.step == 0 {
            self.start = energy;
        } else {
            self.greatest = self.greatest.max(or_infinite(100.0 * (energy - self.start) / self.scale));
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push((self.name, self.greatest));
    }
}

/// `energy_growth_pct`: the greatest rise of total energy above its start, in per cent of the kinetic energy at the start plus the
/// work of gravity over one metre, so that a scene at rest has a scale too.
pub struct EnergyGrowth {
    start: f64,
    scale: f64,
    rise: Worst,
}

impl Default for EnergyGrowth {
    fn default() -> Self {
        Self { start: 0.0, scale: 1.0, rise: Worst::ZERO }
    }
}

impl Metric for EnergyGrowth {
    fn observe(&mut self, view: &View) {
        let energy = total_energy(view);
        if view.step == 0 {
            let over_a_metre = f64::from(view.gravity.length());
            let mass: f64 = view.dynamic().filter_map(|body| view.mass(body)).map(|mass| f64::from(mass.mass)).sum();
            let fall = view.gravity.as_dvec3();
            let potential: f64 = view
                .dynamic()
                .filter_map(|body| Some((body, view.mass(body)?)))
                .map(|(body, mass)| -f64::from(mass.mass * view.bodies[body].gravity_scale) * fall.dot(view.center(body)))
                .sum();
            self.start = energy;
            self.scale = (energy - potential + mass * over_a_metre).max(1e-12);
        }
        self.rise.note(100.0 * (energy - self.start) / self.scale);
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("energy_growth_pct", self.rise.value()));
    }
}

/// `ang_momentum_err_pct`: how far the angular momentum of all bodies about the scene's origin leaves its start, as a vector.
#[derive(Default)]
pub struct AngularMomentumError {
    start: DVec3,
    worst: f64,
}

impl Metric for AngularMomentumError {
    fn observe(&mut self, view: &View) {
        let mut momentum = DVec3::ZERO;
        for body in view.dynamic() {
            let Some(mass) = view.mass(body) else { continue };
            let (v, w) = (view.engine.linear_velocity(body).as_dvec3(), view.engine.angular_velocity(body).as_dvec3());
            momentum += world_inertia(&mass, &view.engine.pose(body)) * w + f64::from(mass.mass) * view.center(body).cross(v);
        }
        if view.step == 0 {
            self.start = momentum;
        }
        let mut worst = Worst::ZERO;
        worst.note(self.worst);
        worst.note(100.0 * (momentum - self.start).length() / self.start.length());
        self.worst = worst.value();
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("ang_momentum_err_pct", self.worst));
    }
}

/// `lin_momentum_err_pct`: how far the linear momentum of all bodies leaves its start, as a vector.
#[derive(Default)]
pub struct LinearMomentumError {
    start: DVec3,
    worst: f64,
}

impl Metric for LinearMomentumError {
    fn observe(&mut self, view: &View) {
        let of_body = |body: usize| Some(f64::from(view.mass(body)?.mass) * view.engine.linear_velocity(body).as_dvec3());
        let momentum: DVec3 = view.dynamic().filter_map(of_body).sum();
        if view.step == 0 {
            self.start = momentum;
        }
        let mut worst = Worst::ZERO;
        worst.note(self.worst);
        worst.note(100.0 * (momentum - self.start).length() / self.start.length());
        self.worst = worst.value();
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("lin_momentum_err_pct", self.worst));
    }
}
