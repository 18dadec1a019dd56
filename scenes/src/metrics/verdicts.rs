//! What the support analysis says of bodies, against what becomes of them.

use longspan::glam::DVec3;

use super::{Errors, Metric, View};

/// When verdicts are read, and the names of what they come to: once contacts bear load, when what is not supported has hardly begun
/// to move; and once what stands has settled.
const TIMES: [(u32, [&str; 4]); 2] = [
    (6, ["stay", "supported", "wrongly_loose", "wrongly_supported"]),
    (60, ["later_stay", "later_supported", "later_wrongly_loose", "later_wrongly_supported"]),
];

/// `stay`: bodies that end no farther than a reach from where they were when verdicts were read; `supported`: those judged
/// supported then; `wrongly_loose` and `wrongly_supported`: those of which the verdict is not what became of them. `later_…`: the
/// same, read after a second. Nothing where no engine judges.
pub struct Verdicts {
    reach: f64,
    judged: [Vec<Judged>; 2],
}

/// A body when its verdict was read, and whether it has stayed there.
struct Judged {
    center: DVec3,
    supported: bool,
    stays: bool,
}

impl Verdicts {
    /// Farther than `reach` (m) a body has fallen.
    pub fn within(reach: f64) -> Self {
        Self { reach, judged: [Vec::new(), Vec::new()] }
    }
}

impl Metric for Verdicts {
    fn observe(&mut self, view: &View) {
        for (judged, (step, _)) in self.judged.iter_mut().zip(TIMES) {
            if view.step == step {
                let judge = |body: usize| {
                    Some(Judged { center: view.center(body), supported: view.engine.is_supported(body)?, stays: true })
                };
                *judged = view.dynamic().map(judge).collect::<Option<_>>().unwrap_or_default();
            }
            for (body, judged) in view.dynamic().zip(judged) {
                judged.stays = view.center(body).distance(judged.center) <= self.reach;
            }
        }
    }

    fn report(&self, errors: &mut Errors) {
        for (judged, (_, names)) in self.judged.iter().zip(TIMES).filter(|(judged, _)| !judged.is_empty()) {
            let count = |test: fn(&Judged) -> bool| judged.iter().filter(|&body| test(body)).count() as f64;
            let counts = [
                count(|body| body.stays),
                count(|body| body.supported),
                count(|body| !body.supported && body.stays),
                count(|body| body.supported && !body.stays),
            ];
            errors.extend(names.into_iter().zip(counts));
        }
    }
}
