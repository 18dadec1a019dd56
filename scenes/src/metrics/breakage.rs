//! What broke, and when.

use longspan::JointKind;

use super::{Errors, Metric, View};

/// `broken`: joints gone at the end; `pieces`: sets of dynamic bodies that the fixed joints left connect; `largest_piece`: the most
/// bodies in one of them; `quiet_s`: time of the last break (s).
#[derive(Default)]
pub struct Breakage {
    broken: usize,
    pieces: usize,
    largest: usize,
    last: f64,
}

impl Metric for Breakage {
    fn observe(&mut self, view: &View) {
        let broken = (0..view.joints.len()).filter(|&joint| !view.engine.has_joint(joint)).count();
        if broken != self.broken {
            (self.broken, self.last) = (broken, view.time);
        }
        if view.at_end() {
            let sizes = piece_sizes(view);
            (self.pieces, self.largest) = (sizes.len(), sizes.into_iter().max().unwrap_or(0));
        }
    }

    fn report(&self, errors: &mut Errors) {
        let counts = [("broken", self.broken), ("pieces", self.pieces), ("largest_piece", self.largest)];
        errors.extend(counts.map(|(name, count)| (name, count as f64)));
        errors.push(("quiet_s", self.last));
    }
}

fn piece_sizes(view: &View) -> Vec<usize> {
    let mut root: Vec<usize> = (0..view.bodies.len()).collect();
    let find = |root: &mut Vec<usize>, mut body: usize| {
        while root[body] != body {
            root[body] = root[root[body]];
            body = root[body];
        }
        body
    };
    let dynamic: Vec<usize> = view.dynamic().collect();
    for (number, joint) in view.joints.iter().enumerate() {
        if let (Some(a), Some(b), JointKind::Fixed) = (joint.a, joint.b, joint.def.kind)
            && view.engine.has_joint(number)
            && dynamic.binary_search(&a).is_ok()
            && dynamic.binary_search(&b).is_ok()
        {
            let (a, b) = (find(&mut root, a), find(&mut root, b));
            root[a.max(b)] = a.min(b);
        }
    }
    let mut sizes = vec![0; view.bodies.len()];
    for &body in &dynamic {
        sizes[find(&mut root, body)] += 1;
    }
    sizes.retain(|&size| size > 0);
    sizes
}

/// `break_load_err_pct`: how far gravity is from what statics says when the first joint breaks; `first_broken`: that joint. Both are
/// infinite if none does.
pub struct FirstBreak {
    expected: f64,
    found: Option<(usize, f64)>,
    last: f64,
}

impl FirstBreak {
    /// Gravity (m/s²) at which the first joint should break.
    pub fn at_gravity(expected: f64) -> Self {
        Self { expected, found: None, last: 0.0 }
    }
}

impl Metric for FirstBreak {
    fn observe(&mut self, view: &View) {
        if self.found.is_none() {
            // Gravity is set before a step and judged after it.
            self.found = (0..view.joints.len()).find(|&joint| !view.engine.has_joint(joint)).map(|joint| (joint, self.last));
            self.last = f64::from(view.gravity.length());
        }
    }

    fn report(&self, errors: &mut Errors) {
        let (joint, gravity) = self.found.map_or((f64::INFINITY, f64::INFINITY), |(joint, gravity)| (joint as f64, gravity));
        errors.push(("break_load_err_pct", 100.0 * (gravity / self.expected - 1.0).abs()));
        errors.push(("first_broken", joint));
    }
}
