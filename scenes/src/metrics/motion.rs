//! Whether what should stand stays where it is, and how fast things are.

use longspan::glam::DVec3;
use longspan::{LockedAxes, Pose};

use super::{Errors, Metric, View, Worst, or_infinite};

/// Horizontal and vertical part of a displacement; "up" is against gravity, y without gravity.
fn split(view: &View, displacement: DVec3) -> (f64, f64) {
    let up = view.gravity.as_dvec3().try_normalize().map_or(DVec3::Y, |down| -down);
    let rise = displacement.dot(up);
    ((displacement - up * rise).length(), rise)
}

/// `drift_m`, `sink_m` and `speed_max_end`: the greatest horizontal displacement and fall of a body since the start, and the
/// greatest speed (m/s), after a number of steps.
pub struct Moved {
    at: u32,
    bodies: Option<Vec<usize>>,
    start: Vec<DVec3>,
    found: Option<[Worst; 3]>,
}

impl Moved {
    /// Judges after `at` steps, these bodies or all that can move.
    pub fn after(at: u32, bodies: Option<Vec<usize>>) -> Self {
        Self { at, bodies, start: Vec::new(), found: None }
    }

    fn watched(&self, view: &View) -> Vec<usize> {
        self.bodies.clone().unwrap_or_else(|| view.dynamic().collect())
    }
}

impl Metric for Moved {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.start = (0..view.bodies.len()).map(|body| view.center(body)).collect();
        }
        if view.step == self.at {
            let mut found = [Worst::ZERO; 3];
            for body in self.watched(view) {
                let (drift, rise) = split(view, view.center(body) - self.start[body]);
                found[0].note(drift);
                found[1].note(-rise);
                found[2].note(f64::from(view.engine.linear_velocity(body).length()));
            }
            self.found = Some(found);
        }
    }

    fn report(&self, errors: &mut Errors) {
        if let Some([drift, sink, speed]) = self.found {
            errors.extend([("drift_m", drift.value()), ("sink_m", sink.value()), ("speed_max_end", speed.value())]);
        }
    }
}

/// `stood`: 1 if no body was ever farther than a reach from where it started, else 0.
pub struct Stood {
    reach: f64,
    start: Vec<DVec3>,
    stood: bool,
}

impl Stood {
    /// Farther than `reach` (m) from its start a body has fallen.
    pub fn within(reach: f64) -> Self {
        Self { reach, start: Vec::new(), stood: true }
    }
}

impl Metric for Stood {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.start = (0..view.bodies.len()).map(|body| view.center(body)).collect();
        }
        let near = |body: usize| view.center(body).distance(self.start[body]) <= self.reach;
        self.stood &= view.dynamic().filter(|&body| body < self.start.len()).all(near);
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("stood", f64::from(u8::from(self.stood))));
    }
}

/// `blocks_displaced` and `blocks_moved`: how many of some bodies lie more than half a metre, and more than two centimetres, from
/// where they were after a number of steps.
pub struct Displaced {
    since: u32,
    bodies: Vec<usize>,
    before: Vec<DVec3>,
    counts: Option<[usize; 2]>,
}

impl Displaced {
    /// Compares the end with the state after `since` steps.
    pub fn since(since: u32, bodies: Vec<usize>) -> Self {
        Self { since, bodies, before: Vec::new(), counts: None }
    }
}

impl Metric for Displaced {
    fn observe(&mut self, view: &View) {
        if view.step == self.since {
            self.before = self.bodies.iter().map(|&body| view.center(body)).collect();
        } else if view.step > self.since && view.at_end() {
            let present = || self.bodies.iter().zip(&self.before).filter(|(body, _)| view.alive[**body]);
            let stayed = |body: usize, before: DVec3, reach: f64| view.center(body).distance(before) <= reach;
            let farther = |reach: f64| present().filter(|&(&body, before)| !stayed(body, *before, reach)).count();
            self.counts = Some([farther(0.5), farther(0.02)]);
        }
    }

    fn report(&self, errors: &mut Errors) {
        if let Some([displaced, moved]) = self.counts {
            errors.extend([("blocks_displaced", displaced as f64), ("blocks_moved", moved as f64)]);
        }
    }
}

/// `escaped`: how many bodies lie outside a box at the end.
pub struct Escaped {
    min: DVec3,
    max: DVec3,
    count: usize,
}

impl Escaped {
    /// The box from `min` to `max` (m).
    pub fn from(min: DVec3, max: DVec3) -> Self {
        Self { min, max, count: 0 }
    }
}

impl Metric for Escaped {
    fn observe(&mut self, view: &View) {
        if view.at_end() {
            let inside = |p: DVec3| p.cmpge(self.min).all() && p.cmple(self.max).all();
            self.count = view.dynamic().filter(|&body| !inside(view.center(body))).count();
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("escaped", self.count as f64));
    }
}

/// `mean_speed_end`: mean speed of all bodies at the end (m/s).
#[derive(Default)]
pub struct EndSpeeds {
    mean: f64,
}

impl Metric for EndSpeeds {
    fn observe(&mut self, view: &View) {
        if view.at_end() {
            let speeds: Vec<f64> = view.dynamic().map(|body| f64::from(view.engine.linear_velocity(body).length())).collect();
            self.mean = speeds.iter().sum::<f64>() / speeds.len().max(1) as f64;
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("mean_speed_end", or_infinite(self.mean)));
    }
}

/// `speed_peak`: the greatest speed of any body at any time after the start (m/s), and `spin_peak` (rad/s).
pub struct PeakSpeed {
    linear: Worst,
    angular: Worst,
}

impl Default for PeakSpeed {
    fn default() -> Self {
        Self { linear: Worst::ZERO, angular: Worst::ZERO }
    }
}

impl Metric for PeakSpeed {
    fn observe(&mut self, view: &View) {
        for body in view.dynamic().filter(|_| view.step > 0) {
            self.linear.note(f64::from(view.engine.linear_velocity(body).length()));
            self.angular.note(f64::from(view.engine.angular_velocity(body).length()));
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("speed_peak", self.linear.value()), ("spin_peak", self.angular.value())]);
    }
}

/// `pose_speed_max` and `speed_max`: the greatest change of a body's place per second of a step, and the greatest velocity that a
/// body claims to have, over the last steps (m/s).
pub struct PoseSpeed {
    last: u32,
    before: Vec<DVec3>,
    time: f64,
    by_pose: Worst,
    by_velocity: Worst,
}

impl PoseSpeed {
    /// Watches the last `last` steps.
    pub fn over_last(last: u32) -> Self {
        Self { last, before: Vec::new(), time: 0.0, by_pose: Worst::ZERO, by_velocity: Worst::ZERO }
    }
}

impl Metric for PoseSpeed {
    fn observe(&mut self, view: &View) {
        if view.step > 0 && view.in_last(self.last) {
            for body in view.dynamic().filter(|&body| body < self.before.len()) {
                self.by_pose.note(view.center(body).distance(self.before[body]) / (view.time - self.time));
                self.by_velocity.note(f64::from(view.engine.linear_velocity(body).length()));
            }
        }
        self.before.clear();
        self.before.extend((0..view.bodies.len()).map(|body| if view.alive[body] { view.center(body) } else { DVec3::NAN }));
        self.time = view.time;
    }

    fn report(&self, errors: &mut Errors) {
        errors.extend([("pose_speed_max", self.by_pose.value()), ("speed_max", self.by_velocity.value())]);
    }
}

/// `locked_shift_m`, `locked_turn_deg`: how far bodies move along and turn about axes that are locked, at worst; `free_shift_m`: how
/// far along those that are free. Of rotations either one is free or none.
#[derive(Default)]
pub struct LockedDrift {
    start: Vec<Pose>,
    found: [f64; 3],
}

impl Metric for LockedDrift {
    fn observe(&mut self, view: &View) {
        if view.step == 0 {
            self.start = (0..view.bodies.len()).map(|body| view.engine.pose(body)).collect();
        }
        for body in view.dynamic().filter(|&body| view.bodies[body].locked_axes != LockedAxes::default()) {
            let (locked, start, pose) = (view.bodies[body].locked_axes, &self.start[body], view.engine.pose(body));
            let mask = |locked: [bool; 3]| DVec3::from_array(locked.map(|locked| f64::from(u8::from(locked))));
            let shift = pose.position - start.position;
            let turn = (pose.rotation.as_dquat() * start.rotation.as_dquat().conjugate()).normalize();
            let about_locked = (DVec3::new(turn.x, turn.y, turn.z) * mask(locked.rotation)).length();
            let along_locked = shift * mask(locked.translation);
            let now = [along_locked.length(), 2.0 * about_locked.min(1.0).asin().to_degrees(), (shift - along_locked).length()];
            for (found, now) in self.found.iter_mut().zip(now) {
                *found = found.max(or_infinite(now));
            }
        }
    }

    fn report(&self, errors: &mut Errors) {
        let [shift, turn, free] = self.found;
        errors.extend([("locked_shift_m", shift), ("locked_turn_deg", turn), ("free_shift_m", free)]);
    }
}

/// `non_finite`: steps after which some body's pose or velocity was not finite.
#[derive(Default)]
pub struct NotFinite {
    steps: u32,
}

impl Metric for NotFinite {
    fn observe(&mut self, view: &View) {
        let finite = |body: usize| {
            let pose = view.engine.pose(body);
            let (v, w) = (view.engine.linear_velocity(body), view.engine.angular_velocity(body));
            pose.position.is_finite() && pose.rotation.is_finite() && v.is_finite() && w.is_finite()
        };
        if !view.dynamic().all(finite) {
            self.steps += 1;
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("non_finite", f64::from(self.steps)));
    }
}

/// `awake_end`: bodies that the engine still simulates at the end.
#[derive(Default)]
pub struct Awake {
    count: usize,
}

impl Metric for Awake {
    fn observe(&mut self, view: &View) {
        if view.at_end() {
            self.count = view.dynamic().filter(|&body| view.engine.is_awake(body)).count();
        }
    }

    fn report(&self, errors: &mut Errors) {
        errors.push(("awake_end", self.count as f64));
    }
}
