//! A box that tips over an edge, against the rigid body that it is.

use longspan::glam::{DVec2, DVec3};

use crate::metrics::{Errors, Metric, View};
use crate::scene::GRAVITY;

/// What the edge belongs to over which a box tips.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Foundation {
    /// It does not move.
    Fixed,
    /// A stack of unit boxes of this height (m), without mass beside the box: pushed backwards, its foot lifts, and it turns as a
    /// strut from the far edge of its foot to the edge.
    Strut { height: f64 },
}

/// `fall_time_s`: when a unit box tilts by 0.2 rad; `fall_time_err_pct`: against the rigid body.
pub(crate) struct Toppling {
    body: usize,
    /// How far its centre of mass lies beyond the edge (m).
    lean: f64,
    foundation: Option<Foundation>,
    last: (f64, f64),
    reached: Option<f64>,
}

impl Toppling {
    const TILT: f64 = 0.2;

    /// Of the body with this number; without a foundation there is nothing to compare it with.
    pub(crate) fn new(body: usize, lean: f64, foundation: Option<Foundation>) -> Self {
        Self { body, lean, foundation, last: (0.0, 0.0), reached: None }
    }

    /// Time in which the box tilts by `TILT` from rest.
    ///
    /// With θ its angle from the vertical, r from the edge to its centre of mass, s = (sin θ, cos θ) and c = ds/dθ, and a strut of
    /// length ℓ along u (t across it) that pushes with f a unit of mass:
    ///
    /// θ″ = 6 r f (s × u),   u·(ℓu + rs)″ = f − g u_y,   t·(ℓu + rs)″ = −g t_y.
    ///
    /// Over a fixed edge, (1/6 + r²) θ″ = g r sin θ.
    fn rigid_time(&self, foundation: Foundation) -> f64 {
        let gravity = f64::from(GRAVITY);
        let radius = self.lean.hypot(0.5);
        let start = self.lean.atan2(0.5);
        let strut = match foundation {
            Foundation::Fixed => DVec2::ZERO,
            Foundation::Strut { height } => DVec2::new(1.0, height),
        };
        let length = strut.length();
        let (mut angle, mut rate, mut time) = (start, 0.0_f64, 0.0);
        let (mut strut_angle, mut strut_rate) = (strut.to_angle(), 0.0_f64);
        let h = 1e-5;
        while angle < start + Self::TILT {
            let middle = angle + 0.5 * h * rate;
            let (outward, across) = (DVec2::new(middle.sin(), middle.cos()), DVec2::new(middle.cos(), -middle.sin()));
            let acceleration = match foundation {
                Foundation::Fixed => gravity * radius * middle.sin() / (1.0 / 6.0 + radius * radius),
                Foundation::Strut { .. } => {
                    let along = DVec2::from_angle(strut_angle + 0.5 * h * strut_rate);
                    let aside = along.perp();
                    let turning = 6.0 * radius * outward.perp_dot(along);
                    let swing = radius * rate * rate;
                    let load = gravity * along.y - length * strut_rate * strut_rate - swing * along.dot(outward);
                    let push = load / (1.0 - radius * turning * along.dot(across));
                    let acceleration = turning * push;
                    let sway = radius * acceleration * aside.dot(across) - swing * aside.dot(outward);
                    strut_rate += h * (-gravity * aside.y - sway) / length;
                    strut_angle += h * strut_rate;
                    acceleration
                }
            };
            angle += h * (rate + 0.5 * h * acceleration);
            rate += h * acceleration;
            time += h;
        }
        time
    }
}

impl Metric for Toppling {
    fn observe(&mut self, view: &View) {
        let up = view.engine.pose(self.body).rotation.as_dquat().normalize() * DVec3::Y;
        let tilt = up.x.hypot(up.z).atan2(up.y);
        if self.reached.is_none() && tilt >= Self::TILT {
            let share = (Self::TILT - self.last.1) / (tilt - self.last.1);
            self.reached = Some(self.last.0 + share * (view.time - self.last.0));
        }
        self.last = (view.time, tilt);
    }

    fn report(&self, errors: &mut Errors) {
        let time = self.reached.unwrap_or(f64::INFINITY);
        errors.push(("fall_time_s", time));
        if let Some(foundation) = self.foundation {
            let expected = self.rigid_time(foundation);
            errors.push(("fall_time_err_pct", 100.0 * (time - expected).abs() / expected));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strut_that_leans_back_lets_go_sooner_than_a_post() {
        let time = |lean, foundation| Toppling::new(0, lean, None).rigid_time(foundation);
        for (lean, strut, post) in [(0.1, 0.3479, 0.3886), (0.3, 0.1962, 0.2558)] {
            let (on_strut, on_post) = (time(lean, Foundation::Strut { height: 9.0 }), time(lean, Foundation::Fixed));
            assert!((on_strut - strut).abs() < 1e-4, "{on_strut} s on a strut, {lean} m beyond the edge");
            assert!(on_post > on_strut && (on_post - post).abs() < 1e-4, "{on_post} s on a post, {lean} m beyond the edge");
        }
    }
}
