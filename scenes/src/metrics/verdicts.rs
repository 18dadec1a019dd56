//! What the support analysis says of bodies, against what becomes of them.

use longspan::glam::DVec3;

use super::{Errors, Metric, View};

/// Step after which verdicts are read: contacts bear load, and what is not supported has hardly begun to move.
const JUDGED_AT: u32 = 6;

/// `stay`: bodies that end no farther than a reach from where they started; `supported`: those judged supported at the beginning;
/// `wrongly_loose` and `wrongly_supported`: those of which the verdict is not what became of them. Nothing where no engine judges.
pub struct Verdicts {
    reach: f64,
    start: Vec<DVec3>,
    supported: Vec<Option<bool>>,
    stays: Vec<bool>,
}

impl Verdicts {
    /// Farther than `reach` (m) from its start a body has fallen.
    pub fn within(reach: f64) -> Self {
        Self { reach, start: Vec::new(), supported: Vec::new(), stays: Vec::new() }
    }
}

impl Metric for Verdicts {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.start = view.dynamic().map(|body| view.center(body)).collect();
        }
        if view.step == JUDGED_AT {
            self.supported = view.dynamic().map(|body| view.engine.is_supported(body)).collect();
        }
        self.stays.clear();
        self.stays.extend(view.dynamic().zip(&self.start).map(|(body, start)| view.center(body).distance(*start) <= self.reach));
    }

    fn report(&self, errors: &mut Errors) {
        let judged: Vec<(bool, bool)> =
            self.supported.iter().zip(&self.stays).filter_map(|(supported, &stays)| Some(((*supported)?, stays))).collect();
        if judged.is_empty() {
            return;
        }
        let count = |test: &dyn Fn(bool, bool) -> bool| judged.iter().filter(|&&(says, stays)| test(says, stays)).count() as f64;
        errors.push(("stay", count(&|_, stays| stays)));
        errors.push(("supported", count(&|says, _| says)));
        errors.push(("wrongly_loose", count(&|says, stays| !says && stays)));
        errors.push(("wrongly_supported", count(&|says, stays| says && !stays)));
    }
}
