//! How deep bodies sink into one another, from the exact geometry of boxes and balls.

use longspan::BodyKind;

use super::solid::{Solid, overlap_depth};
use super::{Errors, Metric, View, Worst};

/// Depth of overlap of all pairs of bodies that no joint connects: `pen_max_m` and `pen_p99_m` (over the overlapping pairs) of
/// the steps that are looked at, `pen_end_m` at the end.
pub struct Overlap {
    last: u32,
    every: u32,
    reports: Report,
    depths: Vec<f64>,
    worst: Worst,
    end: Worst,
}

#[derive(PartialEq)]
enum Report {
    Spread,
    End,
}

impl Overlap {
    /// `pen_max_m` and `pen_p99_m`, looking at each `every`th of the last `last` steps.
    pub fn spread(last: u32, every: u32) -> Self {
        Self { last, every, reports: Report::Spread, depths: Vec::new(), worst: Worst::ZERO, end: Worst::ZERO }
    }

    /// `pen_end_m`, and `pen_max_m` over all steps.
    pub fn at_end() -> Self {
        Self { last: u32::MAX, every: 1, reports: Report::End, depths: Vec::new(), worst: Worst::ZERO, end: Worst::ZERO }
    }
}

impl Metric for Overlap {
    fn observe(&mut self, view: &View) {
        let in_window = u64::from(view.step) + u64::from(self.last) > u64::from(view.steps);
        if !in_window || !(view.steps - view.step).is_multiple_of(self.every) {
            return;
        }
        let depths = overlaps(view);
        for &depth in &depths {
            self.worst.note(depth);
            if view.at_end() {
                self.end.note(depth);
            }
        }
        if self.reports == Report::Spread {
            self.depths.extend(depths);
        }
    }

    fn report(&self, errors: &mut Errors) {
        match self.reports {
            Report::End => errors.extend([("pen_end_m", self.end.value()), ("pen_max_m", self.worst.value())]),
            Report::Spread => {
                let mut sorted = self.depths.clone();
                sorted.sort_by(f64::total_cmp);
                let p99 = sorted.get((sorted.len() * 99) / 100).copied().unwrap_or(0.0);
                errors.extend([("pen_max_m", self.worst.value()), ("pen_p99_m", p99)]);
            }
        }
    }
}

/// Depths of all overlapping pairs (m); a single infinity if a body is nowhere.
fn overlaps(view: &View) -> Vec<f64> {
    let mut solids = Vec::new();
    for (body, def) in view.bodies.iter().enumerate().filter(|(body, _)| view.alive[*body]) {
        let pose = view.engine.pose(body);
        if !(pose.position.is_finite() && pose.rotation.is_finite()) {
            return vec![f64::INFINITY];
        }
        for solid in def.shapes.iter().filter_map(|shape| Solid::of(shape, &pose)) {
            solids.push((solid.bounds(), solid, body));
        }
    }
    // Sweep along x: each solid meets only those that begin before it ends.
    solids.sort_by(|a, b| a.0.0.x.total_cmp(&b.0.0.x).then(a.2.cmp(&b.2)));
    let jointed = jointed_pairs(view);
    let mut depths = Vec::new();
    for (index, ((a_min, a_max), a, body_a)) in solids.iter().enumerate() {
        for ((b_min, b_max), b, body_b) in solids[index + 1..].iter().take_while(|other| other.0.0.x <= a_max.x) {
            let apart = b_min.y > a_max.y || a_min.y > b_max.y || b_min.z > a_max.z || a_min.z > b_max.z;
            let one_moves = [body_a, body_b].into_iter().any(|&body| view.bodies[body].kind != BodyKind::Static);
            let pair = (*body_a.min(body_b), *body_a.max(body_b));
            if apart || body_a == body_b || !one_moves || jointed.binary_search(&pair).is_ok() {
                continue;
            }
            let depth = overlap_depth(a, b);
            if depth > 0.0 {
                depths.push(depth);
            }
        }
    }
    depths
}

fn jointed_pairs(view: &View) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(usize, usize)> = view
        .joints
        .iter()
        .filter(|joint| !joint.def.collide_connected)
        .filter_map(|joint| Some((joint.a?, joint.b?)))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    pairs.sort_unstable();
    pairs
}
