//! What closed-form scenes are judged by: one number of the motion against its formula.

use longspan::glam::DVec3;

use crate::metrics::{Errors, Metric, View};

fn percent(measured: f64, expected: f64) -> f64 {
    let error = 100.0 * (measured - expected).abs() / expected.abs();
    if error.is_nan() { f64::INFINITY } else { error }
}

/// `force_err_pct`: mean contact force over the last steps against the weight, of an engine that reports it.
pub(crate) struct ForceError {
    body: usize,
    weight: f64,
    last: u32,
    sum: DVec3,
    samples: u32,
}

impl ForceError {
    pub(crate) fn new(body: usize, weight: f64, last: u32) -> Self {
        Self { body, weight, last, sum: DVec3::ZERO, samples: 0 }
    }
}

impl Metric for ForceError {
    fn observe(&mut self, view: &View) {
        if view.step > 0
            && view.in_last(self.last)
            && let Some(force) = view.engine.contact_force(self.body)
        {
            self.sum += force.as_dvec3();
            self.samples += 1;
        }
    }

    fn report(&self, errors: &mut Errors) {
        if self.samples > 0 {
            errors.push(("force_err_pct", percent(self.sum.length() / f64::from(self.samples), self.weight)));
        }
    }
}

/// `way_err_m` and, if it should move at all, `way_err_pct`: how far a body is from its start at the end, against a formula.
pub(crate) struct Distance {
    body: usize,
    formula: Box<dyn Fn(f64) -> f64>,
    start: DVec3,
    way: f64,
    expected: f64,
}

impl Distance {
    /// `formula` gives the way (m) at a time (s).
    pub(crate) fn new(body: usize, formula: impl Fn(f64) -> f64 + 'static) -> Self {
        Self { body, formula: Box::new(formula), start: DVec3::ZERO, way: 0.0, expected: 0.0 }
    }
}

impl Metric for Distance {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.start = view.center(self.body);
        } else if view.at_end() {
            self.way = view.center(self.body).distance(self.start);
            self.expected = (self.formula)(view.time);
        }
    }

    fn report(&self, errors: &mut Errors) {
        let error = (self.way - self.expected).abs();
        errors.push(("way_err_m", if error.is_nan() { f64::INFINITY } else { error }));
        if self.expected > 0.0 {
            errors.push(("way_err_pct", percent(self.way, self.expected)));
        }
    }
}

/// `height_err_pct`: height of the first rebound against the formula; `height_m` the height itself.
pub(crate) struct ReboundError {
    body: usize,
    radius: f64,
    expected: f64,
    has_hit: bool,
    falls_again: bool,
    highest: f64,
}

impl ReboundError {
    pub(crate) fn new(body: usize, radius: f64, expected: f64) -> Self {
        Self { body, radius, expected, has_hit: false, falls_again: false, highest: 0.0 }
    }
}

impl Metric for ReboundError {
    fn observe(&mut self, view: &View) {
        let height = view.center(self.body).y - self.radius;
        let rising = view.engine.linear_velocity(self.body).y > 0.0;
        self.has_hit |= rising;
        if self.has_hit && !self.falls_again {
            self.highest = self.highest.max(height);
            self.falls_again = !rising;
        }
    }

    fn report(&self, errors: &mut Errors) {
        if self.expected > 0.0 {
            errors.push(("height_err_pct", percent(self.highest, self.expected)));
        }
        errors.push(("height_m", self.highest));
    }
}

/// `period_err_pct`: mean time between passages of a coordinate through its middle in one direction against the formula.
pub(crate) struct PeriodError {
    body: usize,
    axis: DVec3,
    middle: f64,
    expected: f64,
    before: Option<(f64, f64)>,
    passages: Vec<f64>,
}

impl PeriodError {
    /// The coordinate is that of the body's centre along `axis`; `middle` (m) is where it swings about.
    pub(crate) fn new(body: usize, axis: DVec3, middle: f64, expected: f64) -> Self {
        Self { body, axis, middle, expected, before: None, passages: Vec::new() }
    }
}

impl Metric for PeriodError {
    fn observe(&mut self, view: &View) {
        let now = (view.time, view.center(self.body).dot(self.axis) - self.middle);
        if let Some(before) = self.before
            && before.1 > 0.0
            && now.1 <= 0.0
        {
            self.passages.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
        }
        self.before = Some(now);
    }

    fn report(&self, errors: &mut Errors) {
        let error = match (self.passages.first(), self.passages.last()) {
            (Some(first), Some(last)) if last > first => {
                percent((last - first) / (self.passages.len() - 1) as f64, self.expected)
            }
            _ => f64::INFINITY,
        };
        errors.push(("period_err_pct", error));
    }
}

/// Worst difference of a speed from its formula, in per cent of a scale, under a name.
pub(crate) struct SpeedError {
    name: &'static str,
    scale: f64,
    speed: Box<dyn Fn(&View) -> f64>,
    formula: Box<dyn Fn(u32, f64) -> f64>,
    worst: f64,
}

impl SpeedError {
    /// `formula` gives what `speed` should be after a number of steps, at a time (s).
    pub(crate) fn new(
        name: &'static str,
        scale: f64,
        speed: impl Fn(&View) -> f64 + 'static,
        formula: impl Fn(u32, f64) -> f64 + 'static,
    ) -> Self {
        Self { name, scale, speed: Box::new(speed), formula: Box::new(formula), worst: 0.0 }
    }
}

impl Metric for SpeedError {
    fn observe(&mut self, view: &View) {
        let error = 100.0 * ((self.speed)(view) - (self.formula)(view.step, view.time)).abs() / self.scale;
        self.worst = self.worst.max(if error.is_nan() { f64::INFINITY } else { error });
    }

    fn report(&self, errors: &mut Errors) {
        errors.push((self.name, self.worst));
    }
}
