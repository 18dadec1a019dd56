//! The demand of a motor on its coordinate.
//!
//! **Velocity motors** ask for their speed, with a bounded force. **Soft position motors** are a spring and damper, one row with give.
//!
//! **Rigid position motors** go to their target as fast as their force allows and stop there. With D the distance left and a the
//! deceleration that the motor can hold, the greatest speed v from which substeps of length h come to rest in time covers h v in this
//! one and h (v − a h), h (v − 2 a h) … in those to come, D = h v/2 + v²/(2 a):
//!
//! ```text
//! v = min(D/h, √(a²h²/4 + 2 a D) − a h/2).
//! ```
//!
//! The row asks for v towards the target, and its bounds do the rest: at first it pushes with all it has, then it brakes along v(D),
//! and the last substep of less than a h² arrives. Without a bound it arrives in one substep.
//!
//! a = w F − d, with F the greatest force, w = J M⁻¹ Jᵀ the inverse effective mass of the coordinate *with the rest of the joint held*
//! (a door of mass m on a lever r is m r² heavier than about its centre), and d what external forces accelerate it by, both found by
//! orthogonalising J against the joint's other rows in the metric of M⁻¹. An articulation
//! gives what hangs on other joints too (*../direct/composite.rs*, in loops *servo_loops.rs*); of a for what is not known
//! [`BRAKING_SHARE`] is left.
//!
//! A *reference* that moves at u has r(t) = target − u (T − t), T the end of the step: all of this is then about x − r and v − u.

use glam::DVec3;

use super::body_response::BodyResponse;
use super::row_sink::{JointCoordinate, RowSink};
use super::rows::{Demand, Error1, HeldDirections, Jacobian, Phase, Rate, SoftParams};
use crate::joint::{Drive, ForceSide, Limits, Motor, Softness};

/// Share of the deceleration found for a rigid position motor by which it brakes: a tenth is left for loads that are not known.
/// A motion between two points takes 2.7 % longer by it.
const BRAKING_SHARE: f64 = 0.9;

/// Least deceleration that it counts on, over that without loads: a motor that cannot hold its load comes to its target somehow.
const MIN_BRAKING: f64 = 0.05;

/// Most that a rigid position motor turns by in a substep (rad): beyond it the direction of a lever has no meaning.
const MAX_TURN: f64 = 1.0;

/// Speed beyond which a rigid position motor is on its way, not holding still (m/s, rad/s): well above what rounding makes it mend,
/// 1 µm in a substep of 1/240 s.
const ON_ITS_WAY: f64 = 1.0e-3;

/// Share of its square below which a row is a sum of others.
const DEPENDENT: f64 = 1.0e-9;

/// How a coordinate answers to its motor, with the rest of the joint held.
#[derive(Debug, Clone, Copy)]
struct Ease {
    /// J M⁻¹ Jᵀ (1/kg, 1/(kg·m²)).
    ease: f64,
    /// What external forces accelerate it by (m/s², rad/s²).
    acceleration: f64,
    /// Its rate once the joint's other rows hold (m/s, rad/s).
    rate: f64,
}

/// A row over the motions of two bodies.
#[derive(Debug, Clone, Copy)]
struct Covector([Rate; 2]);

impl Covector {
    fn of(jacobian: &Jacobian) -> Self {
        Self([
            Rate { linear: -jacobian.linear, angular: -jacobian.angular_a },
            Rate { linear: jacobian.linear, angular: jacobian.angular_b },
        ])
    }

    fn dot(&self, other: &[Rate; 2]) -> f64 {
        (0..2).map(|i| self.0[i].linear.dot(other[i].linear) + self.0[i].angular.dot(other[i].angular)).sum()
    }

    /// M⁻¹ of it.
    fn response(&self, answers: &[BodyResponse; 2]) -> [Rate; 2] {
        std::array::from_fn(|i| answers[i].response(&self.0[i]))
    }

    fn less(&self, factor: f64, other: &Self) -> Self {
        Self(std::array::from_fn(|i| Rate {
            linear: self.0[i].linear - other.0[i].linear * factor,
            angular: self.0[i].angular - other.0[i].angular * factor,
        }))
    }
}

/// Rows that a joint holds, orthogonal to each other in the metric of M⁻¹.
struct HeldRows {
    rows: [(Covector, [Rate; 2], f64); 6],
    count: usize,
}

impl HeldRows {
    fn without(&self, mut row: Covector) -> Covector {
        for (held, response, square) in &self.rows[..self.count] {
            row = row.less(row.dot(response) / square, held);
        }
        row
    }

    fn add(&mut self, row: Covector, answers: &[BodyResponse; 2]) {
        let before = row.dot(&row.response(answers));
        let row = self.without(row);
        let response = row.response(answers);
        let square = row.dot(&response);
        if square > DEPENDENT * before && self.count < self.rows.len() {
            self.rows[self.count] = (row, response, square);
            self.count += 1;
        }
    }
}

impl RowSink<'_> {
    /// How a coordinate answers; the rows that the joint holds rigidly have been added before.
    fn ease_of(&self, jacobian: &Jacobian) -> Ease {
        let answers = [0, 1].map(self.answers.bodies);
        let none = Rate { linear: DVec3::ZERO, angular: DVec3::ZERO };
        let mut held = HeldRows { rows: [(Covector([none; 2]), [none; 2], 0.0); 6], count: 0 };
        let axes = |held: HeldDirections| match held {
            HeldDirections::All => [Some(DVec3::X), Some(DVec3::Y), Some(DVec3::Z)],
            HeldDirections::Across(axis) => {
                let (u, v) = axis.any_orthonormal_pair();
                [Some(u), Some(v), None]
            }
            HeldDirections::Along(axis) => [Some(axis), None, None],
            HeldDirections::Nothing => [None; 3],
        };
        if let Some(block) = self.point.as_ref().filter(|block| block.gamma == 0.0) {
            for axis in axes(block.held).into_iter().flatten() {
                let [angular_a, angular_b] = block.levers.map(|lever| lever.cross(axis));
                held.add(Covector::of(&Jacobian { linear: axis, angular_a, angular_b }), &answers);
            }
        }
        if let Some(block) = self.direction.as_ref().filter(|block| block.gamma == 0.0) {
            for axis in axes(block.held).into_iter().flatten() {
                held.add(Covector::of(&Jacobian::angular(axis)), &answers);
            }
        }
        for row in self.scalars.iter().filter(|row| row.gamma == 0.0 && row.min == f64::NEG_INFINITY) {
            if row.max == f64::INFINITY {
                held.add(Covector::of(&row.jacobian), &answers);
            }
        }
        let row = held.without(Covector::of(jacobian));
        Ease {
            ease: row.dot(&row.response(&answers)),
            acceleration: row.dot(&answers.map(|answer| answer.acceleration())),
            rate: row.dot(&self.rates.bodies),
        }
    }

    /// Deceleration that a rigid motor with forces in these bounds can hold on its way to C = 0 from `error`.
    fn braking(&self, jacobian: &Jacobian, error: f64, bounds: [f64; 2]) -> f64 {
        let found = self.answers.in_loop.and_then(|in_loop| in_loop(jacobian));
        let own = || {
            let Ease { ease, acceleration, .. } = self.ease_of(jacobian);
            [ease, acceleration]
        };
        braking(found.unwrap_or_else(own), error, bounds)
    }

    /// What a unit of impulse along a coordinate changes of its rate, with the rest of the joint held (1/kg, 1/(kg·m²)).
    pub(crate) fn ease_along(&self, jacobian: &Jacobian) -> f64 {
        self.ease_of(jacobian).ease
    }

    /// Whether the rows are for sweeps, which close a part of what a motor has left.
    fn is_swept(&self) -> bool {
        self.closing_share < 1.0
    }

    /// Adds the row of a coordinate's motor, whose multiplier is `id`; all rows that the joint holds have been added before.
    pub(super) fn drive(&mut self, coordinate: &JointCoordinate, limits: Limits, motor: &Motor, id: u8) {
        let Some(drive) = motor.drive() else { return };
        let &JointCoordinate { jacobian, start, predicted, factor } = coordinate;
        let h = self.phase.h();
        let bounds = drive.bounds().map(|force| force * h);
        let Some(target) = drive.target else {
            // A motor that pushed on past the joint's own stop would fight it, without end if its force has none.
            let (min, max) = (f64::from(limits.min), f64::from(limits.max));
            let (least, most) = ((min - start).min(0.0) / h, (max - start).max(0.0) / h);
            let wanted = f64::from(drive.velocity);
            self.arrives |= u32::from(wanted < least) << (id - 2) | u32::from(wanted > most) << (id - 1);
            let target = wanted.clamp(least, most) * factor;
            let give = SoftParams::rigid(self.phase);
            let error = Error1 { start: start * factor, predicted: predicted * factor };
            // Swept, a row is of the substep's start; what swings round on a winch is drawn in all the same. A direct solve looks at its end, and
            // a turn by more than its axis bears in a substep tells nothing.
            let bends = self.is_swept() && jacobian.linear != DVec3::ZERO;
            let curvature = if bends { give.curvature(error, self.rates.read(|rates| jacobian.rate(rates), 0.0)) } else { 0.0 };
            return self.scalar(jacobian, Demand::Speed { target: target - curvature, bounds }, give, id);
        };
        if matches!(self.phase, Phase::Position { .. }) {
            return;
        }
        let speed = f64::from(drive.velocity);
        // A servo stops at its joint's own stops; a spring that is stretched beyond them presses on them.
        let is_spring = drive.softness.compliance > 0.0;
        let target = if is_spring { target } else { target.clamp(limits.min, limits.max) };
        let target = f64::from(target) - speed * (self.left + h / self.share);
        let error = Error1 { start: (start - target) * factor, predicted: (predicted - target) * factor };
        let speed = speed * factor;
        if is_spring {
            self.pull(&jacobian, error, speed, &drive, bounds, id);
        } else {
            let is_bounded = drive.max_force < f32::INFINITY;
            let braking = if is_bounded { self.braking(&jacobian, error.start, drive.bounds()) } else { f64::INFINITY };
            let most = most_speed(&jacobian, f64::from(drive.max_speed).min(self.most_speed), h / self.share);
            self.approach(&jacobian, error, MotorApproach { braking, most, speed }, bounds, id);
        }
    }

    /// A spring and damper, no faster than it may be: where it would be, a motor at that speed with what the spring has left.
    fn pull(&mut self, jacobian: &Jacobian, error: Error1, speed: f64, drive: &Drive, bounds: [f64; 2], id: u8) {
        let (give, speed) = (self.spring(drive.softness, &[*jacobian]), [speed / self.share, speed]);
        let most = f64::from(drive.max_speed);
        if most < f64::INFINITY {
            let ease = self.ease_of(jacobian);
            let given = f64::from(self.impulses.scalar[id as usize]) * self.share * self.applied;
            let rate = ease.rate - ease.ease * given;
            let (bias, gamma) = give.spring(error, speed, self.rates.read(|rates| jacobian.rate(rates), 0.0));
            let impulse = (-(rate + bias) / (ease.ease + gamma)).clamp(bounds[0], bounds[1]);
            let (reached, way) = (rate + ease.ease * impulse, impulse.signum());
            // A second-order substep goes on with 4/3 of what this one has gained, and a spring does not brake.
            self.is_under_way |= reached * way > 0.5 * most;
            if reached * way > most {
                let left = -(way * most + bias) / gamma;
                let bounds = [left.min(0.0).max(bounds[0]), left.max(0.0).min(bounds[1])];
                return self.scalar(*jacobian, Demand::Speed { target: way * most, bounds }, SoftParams::rigid(self.phase), id);
            }
        }
        self.scalar(*jacobian, Demand::Drive { error, speed, bounds }, give, id);
    }

    /// A rigid motor on its way to C = 0.
    fn approach(&mut self, jacobian: &Jacobian, error: Error1, approach: MotorApproach, bounds: [f64; 2], id: u8) {
        let full = self.phase.h() / self.share;
        let distance = error.start.abs();
        let speed = approach_speed(distance, approach.braking, full, self.closing_share);
        let closing = (speed * error.start.signum() - approach.speed).clamp(-approach.most, approach.most) + approach.speed;
        self.is_under_way |= closing.abs() > ON_ITS_WAY;
        // Over the whole substep, of which the row may have a part.
        let [closing, speed] = [closing, approach.speed].map(|speed| speed / self.share);
        let demand = Demand::Approach { error, closing, speed, bounds };
        self.scalar(*jacobian, demand, SoftParams::rigid(self.phase), id);
    }

    /// Drives the rotation to the rotation vector `error` (A's frame, rad) away from its target: along it, with up to `max_torque` about
    /// each of A's axes.
    pub(super) fn turn_to(&mut self, error: impl Fn(&super::geometry::Placement) -> DVec3, softness: Softness, max_torque: f32) {
        if matches!(self.phase, Phase::Position { .. }) {
            return;
        }
        let axes = self.geometry.gradient.axes_a();
        let (start, predicted) = self.geometry.read(error);
        let (h, full) = (self.phase.h(), self.phase.h() / self.share);
        let most = f64::from(max_torque) * h;
        let bounds = [-most, most];
        let mut closing = DVec3::ZERO;
        if softness.compliance == 0.0 {
            let braking = if max_torque < f32::INFINITY {
                let way = Jacobian::angular(axes * start.normalize_or(DVec3::X));
                self.braking(&way, start.length(), [-f64::from(max_torque), f64::from(max_torque)])
            } else {
                f64::INFINITY
            };
            let speed = approach_speed(start.length(), braking, full, self.closing_share);
            let speed = speed.min(self.most_speed).min(MAX_TURN / full);
            closing = start.normalize_or_zero() * speed;
            self.is_under_way |= speed > ON_ITS_WAY;
        }
        for i in 0..3 {
            let error = Error1 { start: start[i], predicted: predicted[i] };
            let (jacobian, id) = (Jacobian::angular(axes.col(i)), 4 + i as u8);
            if softness.compliance > 0.0 {
                let demand = Demand::Drive { error, speed: [0.0; 2], bounds };
                self.scalar(jacobian, demand, self.spring(softness, &[jacobian]), id);
            } else {
                let demand = Demand::Approach { error, closing: closing[i] / self.share, speed: 0.0, bounds };
                self.scalar(jacobian, demand, SoftParams::rigid(self.phase), id);
            }
        }
    }
}

/// How a rigid motor may come to its target.
#[derive(Debug, Clone, Copy)]
struct MotorApproach {
    /// Deceleration that it can hold (m/s², rad/s²).
    braking: f64,
    /// Greatest speed, and that of its reference (m/s, rad/s).
    most: f64,
    speed: f64,
}

/// Deceleration that a motor with forces in these bounds can hold on its way to C = 0 from `error`, along a coordinate that answers so and is
/// accelerated by this much.
fn braking([ease, acceleration]: [f64; 2], error: f64, [least, most]: [f64; 2]) -> f64 {
    let way = -error.signum();
    let against = if way > 0.0 { -least } else { most };
    let found = ease * against - way * acceleration;
    BRAKING_SHARE * found.max(MIN_BRAKING * ease * most.max(-least))
}

/// Greatest speed of a coordinate (m/s, rad/s) in a substep of length `h` (s).
fn most_speed(jacobian: &Jacobian, most: f64, h: f64) -> f64 {
    if jacobian.linear == DVec3::ZERO { most.min(MAX_TURN / h) } else { most }
}

/// Distance, in units of what one substep's braking is worth in one substep, beyond which substeps make no difference to a speed.
const MANY_PARTS: f64 = 1.0e12;

/// Greatest speed from which what is `distance` away comes to rest in time, in substeps of length `h`, of which the last ones close this
/// share of what is left.
fn approach_speed(distance: f64, braking: f64, h: f64, share: f64) -> f64 {
    let arrives = distance * share / h;
    let slowed = braking * h;
    if slowed == f64::INFINITY {
        return arrives;
    }
    let parts = distance / (slowed * h);
    if parts > MANY_PARTS || parts.is_nan() {
        return arrives.min((2.0 * braking * distance).sqrt());
    }
    // In units of ah and ah²: a speed v, less by one in each substep, goes v + (v − 1) + … = (n + 1) v − n (n + 1)/2 with n = ⌊v⌋.
    let whole = (0.5 * ((1.0 + 8.0 * parts).sqrt() - 1.0)).floor();
    arrives.min(slowed * (parts / (whole + 1.0) + 0.5 * whole))
}

impl Drive {
    /// Least and greatest force (N or N·m).
    fn bounds(&self) -> [f64; 2] {
        let most = f64::from(self.max_force);
        match self.side {
            ForceSide::Both => [-most, most],
            ForceSide::Pull => [-most, 0.0],
            ForceSide::Push => [0.0, most],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_approach_comes_to_rest_on_its_target_in_whole_substeps() {
        for (braking, h, distance) in
            [(10.0, 1.0 / 240.0, 1.0), (3.0e4, 1.0 / 60.0, 0.5), (0.1, 1.0 / 960.0, 2.0), (50.0, 0.02, 1.0e-3)]
        {
            let (mut left, mut speed) = (distance, approach_speed(distance, braking, h, 1.0));
            left -= speed * h;
            let mut substeps = 1;
            while left > 1.0e-12 {
                let next = approach_speed(left, braking, h, 1.0);
                assert!(
                    speed - next <= braking * h * (1.0 + 1.0e-9),
                    "from {speed} to {next} m/s: brakes harder than {braking} m/s²"
                );
                speed = next;
                left -= speed * h;
                assert!(left > -1.0e-12, "overshoots by {left} m");
                substeps += 1;
                assert!(substeps < 100_000, "{left} m are left");
            }
            assert!(speed <= braking * h * (1.0 + 1.0e-9), "arrives at {speed} m/s, which a substep cannot stop");
        }
    }
}
