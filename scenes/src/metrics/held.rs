//! Whether a run kept what is promised for it.

use super::{Errors, Metric, View};

/// `held`: 1 if every bounded error stayed within its bound, else 0; `of_bound`: the greatest share of its bound that an error
/// took (infinite where the bound is zero and the error is not); then the errors themselves.
pub struct Held {
    metrics: Vec<Box<dyn Metric>>,
    bounds: Vec<(&'static str, f64)>,
}

impl Held {
    /// Each of `bounds` names an error of `metrics` and its greatest value.
    pub fn new(metrics: Vec<Box<dyn Metric>>, bounds: Vec<(&'static str, f64)>) -> Self {
        Self { metrics, bounds }
    }
}

impl Metric for Held {
    fn observe(&mut self, view: &View) {
        for metric in &mut self.metrics {
            metric.observe(view);
        }
    }

    fn report(&self, errors: &mut Errors) {
        let mut found = Errors::new();
        for metric in &self.metrics {
            metric.report(&mut found);
        }
        let kept = |(name, bound): &(&str, f64)| found.iter().any(|(found, value)| found == name && value <= bound);
        errors.push(("held", f64::from(u8::from(self.bounds.iter().all(kept)))));
        let share = |(name, bound): &(&str, f64)| {
            let value = found.iter().find(|(found, _)| found == name).map_or(f64::INFINITY, |(_, value)| *value);
            if value == 0.0 { 0.0 } else { value / bound }
        };
        errors.push(("of_bound", self.bounds.iter().map(share).fold(0.0, f64::max)));
        errors.extend(found);
    }
}
