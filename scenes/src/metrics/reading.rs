//! One number of the scene's own, read off the running scene.

use super::{Errors, Metric, View, Worst, or_infinite};

type Gauge = Box<dyn Fn(&View) -> f64>;

/// A number under the scene's own name: how it stood after a step, or the mean or the worst of the last steps.
pub struct Reading {
    name: &'static str,
    when: When,
    gauge: Gauge,
    found: Worst,
    samples: u32,
}

enum When {
    After(u32),
    WorstOf(u32),
    MeanOf(u32),
}

impl Reading {
    /// As it stands after `step` steps; said only by runs that get so far.
    pub fn after(step: u32, name: &'static str, gauge: impl Fn(&View) -> f64 + 'static) -> Self {
        Self::new(When::After(step), name, gauge)
    }

    /// The greatest of the last `last` steps, at least zero.
    pub fn worst_of_last(last: u32, name: &'static str, gauge: impl Fn(&View) -> f64 + 'static) -> Self {
        Self::new(When::WorstOf(last), name, gauge)
    }

    /// The mean of the last `last` steps.
    pub fn mean_of_last(last: u32, name: &'static str, gauge: impl Fn(&View) -> f64 + 'static) -> Self {
        Self::new(When::MeanOf(last), name, gauge)
    }

    fn new(when: When, name: &'static str, gauge: impl Fn(&View) -> f64 + 'static) -> Self {
        Self { name, when, gauge: Box::new(gauge), found: Worst::ZERO, samples: 0 }
    }
}

impl Metric for Reading {
    fn observe(&mut self, view: &View) {
        let counts = match self.when {
            When::After(step) => view.step == step,
            When::WorstOf(last) | When::MeanOf(last) => view.step > 0 && view.in_last(last),
        };
        if !counts {
            return;
        }
        self.samples += 1;
        let value = or_infinite((self.gauge)(view));
        match self.when {
            When::After(_) => self.found = Worst(value),
            When::WorstOf(_) => self.found.note(value),
            When::MeanOf(_) => self.found.0 += (value - self.found.0) / f64::from(self.samples),
        }
    }

    fn report(&self, errors: &mut Errors) {
        if self.samples > 0 {
            errors.push((self.name, or_infinite(self.found.value())));
        }
    }
}
