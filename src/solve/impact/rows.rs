//! Rows of an impact: points along the normal, and friction of a manifold.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::ImpactBody;

/// Sweeps over the points of a manifold within a visit: they are coupled by the body that they belong to.
const INNER_SWEEPS: usize = 4;

/// Share of the greatest answer of a row that it must have to be solved.
const IMMOVABLE: f64 = 1.0e-12;

/// One point of a manifold.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ImpactPoint {
    pub lever_a: DVec3,
    pub lever_b: DVec3,
    /// Normal velocity at the moment of the hit (m/s), negative; zero where it has not hit in this substep.
    pub impact_speed: f64,
    /// Multiplier of the substep, or of the solve at hand (N·s).
    pub lambda: f64,
    /// Sum of the multipliers of the rounds (N·s).
    pub blow: f64,
    /// Whether it presses or touches.
    pub takes_part: bool,
    pub(super) is_active: bool,
    /// J v at the start of a solve (m/s).
    pub(super) rate: f64,
    /// The least speed to leave at, negative (m/s).
    pub(super) target: f64,
    /// 1/(J M⁻¹ Jᵀ); zero where nothing moves.
    pub(super) mass: f64,
}

/// Up to four points with one normal, and their friction.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImpactManifold {
    pub a: u32,
    pub b: u32,
    /// From A to B.
    pub normal: DVec3,
    pub tangents: [DVec3; 2],
    /// Where friction acts.
    pub center_a: DVec3,
    pub center_b: DVec3,
    pub points: Range<usize>,
    pub restitution: f64,
    pub friction: f64,
    /// Torque limits per normal force about the normal and across it (m).
    pub twist_arm: f64,
    pub rolling_arm: f64,
    /// Multipliers of friction (N·s), about the normal and across it (N·m·s).
    pub slide: DVec2,
    pub twist: f64,
    pub roll: DVec2,
    /// Whether any of its points has been hit in a round.
    pub was_hit: bool,
    pub(super) slide_mass: Mass2,
    pub(super) roll_mass: Mass2,
    pub(super) twist_mass: f64,
}

/// Inverse of a symmetric 2×2 matrix: 11, 12, 22; and its lesser eigenvalue.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mass2 {
    entries: [f64; 3],
    least: f64,
}

impl Mass2 {
    fn inverse_of([k11, k12, k22]: [f64; 3]) -> Self {
        let determinant = k11 * k22 - k12 * k12;
        if !(determinant > IMMOVABLE * k11 * k22 && k11 > 0.0 && k22 > 0.0) {
            return Self::default();
        }
        let greatest = 0.5 * (k11 + k22) + (0.25 * (k11 - k22) * (k11 - k22) + k12 * k12).sqrt();
        Self { entries: [k22 / determinant, -k12 / determinant, k11 / determinant], least: 1.0 / greatest }
    }

    /// New multipliers inside the disc of radius `limit`: those that stop the slip, or a step against it.
    fn solve(&self, old: DVec2, slip: DVec2, limit: f64) -> DVec2 {
        let [m11, m12, m22] = self.entries;
        let free = old - DVec2::new(m11 * slip.x + m12 * slip.y, m12 * slip.x + m22 * slip.y);
        if free.length_squared() <= limit * limit { free } else { (old - slip * self.least).clamp_length_max(limit) }
    }
}

impl ImpactManifold {
    /// Forms the masses of its rows.
    pub(super) fn prepare(&mut self, bodies: &[ImpactBody], points: &mut [ImpactPoint]) {
        let (a, b, n) = (&bodies[self.a as usize], &bodies[self.b as usize], self.normal);
        let inverse_mass = a.inverse_mass + b.inverse_mass;
        let coupling = |(arm_a, arm_b): (DVec3, DVec3), (other_a, other_b): (DVec3, DVec3)| {
            arm_a.dot(a.inverse_inertia * other_a) + arm_b.dot(b.inverse_inertia * other_b)
        };
        for point in &mut points[self.points.clone()] {
            let arms = (point.lever_a.cross(n), point.lever_b.cross(n));
            let answer = n.dot(inverse_mass * n) + coupling(arms, arms);
            let most = inverse_mass.element_sum();
            point.mass = if answer > IMMOVABLE * most { 1.0 / answer } else { 0.0 };
            point.is_active = false;
        }
        let [t1, t2] = self.tangents;
        let arms = self.tangents.map(|t| (self.center_a.cross(t), self.center_b.cross(t)));
        let k = |s: DVec3, t: DVec3, i: usize, j: usize| s.dot(inverse_mass * t) + coupling(arms[i], arms[j]);
        self.slide_mass = Mass2::inverse_of([k(t1, t1, 0, 0), k(t1, t2, 0, 1), k(t2, t2, 1, 1)]);
        let turn = |s: DVec3, t: DVec3| coupling((s, s), (t, t));
        self.roll_mass = Mass2::inverse_of([turn(t1, t1), turn(t1, t2), turn(t2, t2)]);
        let about = turn(n, n);
        self.twist_mass = if about > 0.0 { 1.0 / about } else { 0.0 };
    }

    /// J v of a point (m/s).
    pub(super) fn rate(&self, point: &ImpactPoint, bodies: &[ImpactBody]) -> f64 {
        self.normal.dot(self.speed_at(point.lever_a, point.lever_b, bodies))
    }

    fn speed_at(&self, lever_a: DVec3, lever_b: DVec3, bodies: &[ImpactBody]) -> DVec3 {
        let (a, b) = (&bodies[self.a as usize], &bodies[self.b as usize]);
        b.linear + b.angular.cross(lever_b) - a.linear - a.angular.cross(lever_a)
    }

    fn spin(&self, bodies: &[ImpactBody]) -> DVec3 {
        bodies[self.b as usize].angular - bodies[self.a as usize].angular
    }

    fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.tangents[0]), v.dot(self.tangents[1]))
    }

    fn along(&self, p: DVec2) -> DVec3 {
        self.tangents[0] * p.x + self.tangents[1] * p.y
    }

    fn push(&self, bodies: &mut [ImpactBody], impulse: DVec3, (lever_a, lever_b): (DVec3, DVec3), moment: DVec3) {
        let a = &mut bodies[self.a as usize];
        a.linear -= a.inverse_mass * impulse;
        a.angular -= a.inverse_inertia * (lever_a.cross(impulse) + moment);
        let b = &mut bodies[self.b as usize];
        b.linear += b.inverse_mass * impulse;
        b.angular += b.inverse_inertia * (lever_b.cross(impulse) + moment);
    }

    /// Solves the normal rows of points that are active; says by how much a normal speed has changed at most (m/s).
    pub(super) fn press(&self, bodies: &mut [ImpactBody], points: &mut [ImpactPoint]) -> f64 {
        let mut most = 0.0_f64;
        for _ in 0..INNER_SWEEPS {
            let mut change = 0.0_f64;
            for point in points[self.points.clone()].iter_mut().filter(|point| point.is_active && point.mass > 0.0) {
                let new = (point.lambda - (self.rate(point, bodies) + point.target) * point.mass).max(0.0);
                let more = new - point.lambda;
                point.lambda = new;
                if more != 0.0 {
                    self.push(bodies, self.normal * more, (point.lever_a, point.lever_b), DVec3::ZERO);
                    change = change.max(more.abs() / point.mass);
                }
            }
            most = most.max(change);
            if change == 0.0 {
                break;
            }
        }
        most
    }

    /// Begins the last solve: with the multipliers of the substep where no round has hit, else with none.
    pub(super) fn begin_last(&mut self, from: &[ImpactBody], bodies: &mut [ImpactBody], points: &mut [ImpactPoint]) {
        if self.was_hit {
            (self.slide, self.twist, self.roll) = (DVec2::ZERO, 0.0, DVec2::ZERO);
        }
        for point in &mut points[self.points.clone()] {
            point.rate = self.normal.dot(self.speed_at(point.lever_a, point.lever_b, from));
            point.target = 0.0;
            point.is_active = point.takes_part;
            if self.was_hit {
                point.lambda = 0.0;
            } else if point.lambda > 0.0 {
                self.push(bodies, self.normal * point.lambda, (point.lever_a, point.lever_b), DVec3::ZERO);
            }
        }
        let moment = self.normal * self.twist + self.along(self.roll);
        self.push(bodies, self.along(self.slide), (self.center_a, self.center_b), moment);
    }

    /// Solves friction, about the normal and of rolling, within the load of the rounds and of now.
    pub(super) fn rub(&mut self, bodies: &mut [ImpactBody], points: &[ImpactPoint]) {
        let load: f64 = points[self.points.clone()].iter().map(|point| point.lambda + point.blow).sum();
        let slip = self.across(self.speed_at(self.center_a, self.center_b, bodies));
        let slide = self.slide_mass.solve(self.slide, slip, self.friction * load);
        let spin = self.spin(bodies);
        let limit = self.twist_arm * load;
        let twist = (self.twist - self.twist_mass * spin.dot(self.normal)).clamp(-limit, limit);
        let roll = self.roll_mass.solve(self.roll, self.across(spin), self.rolling_arm * load);
        let moment = self.normal * (twist - self.twist) + self.along(roll - self.roll);
        let impulse = self.along(slide - self.slide);
        (self.slide, self.twist, self.roll) = (slide, twist, roll);
        if impulse != DVec3::ZERO || moment != DVec3::ZERO {
            self.push(bodies, impulse, (self.center_a, self.center_b), moment);
        }
    }

    /// Σ λ J v of all its rows (J).
    pub(super) fn power(&self, bodies: &[ImpactBody], points: &[ImpactPoint]) -> f64 {
        let pressed: f64 = points[self.points.clone()].iter().map(|point| point.lambda * self.rate(point, bodies)).sum();
        let slip = self.across(self.speed_at(self.center_a, self.center_b, bodies));
        let spin = self.spin(bodies);
        pressed + self.slide.dot(slip) + self.twist * spin.dot(self.normal) + self.roll.dot(self.across(spin))
    }

    /// Takes a share of the multipliers of the last solve.
    pub(super) fn scale(&mut self, points: &mut [ImpactPoint], share: f64) {
        points[self.points.clone()].iter_mut().for_each(|point| point.lambda *= share);
        (self.slide, self.twist, self.roll) = (self.slide * share, self.twist * share, self.roll * share);
    }
}
