//! Round features: caps and rims, which touch elsewhere on themselves as their body turns.
//!
//! A shape of circles touches what lies along its outward normal d at
//!
//! ```text
//! r = c + ρ e + a d,    e along d − (d·u) u,
//! ```
//!
//! with c a point of its axis u, ρ the radius of a circle about it and a that of a ball around that: of a cap ρ = 0, of a rim a = 0, of the tip
//! of a cone both. As the body turns, c and u go with it and d stays: a top that spins touches the floor below the middle of its tip, not
//! where a point of its surface has been carried to. Nothing but the motion of c and u tells where a surface of circles is: turned about
//! its own axis it stays where it was.

use glam::{DQuat, DVec3, Quat, Vec2, Vec3};

use super::collider_state::{ColliderState, Follow};
use crate::shape::{Geometry, Shape};

/// How far the middle of a round feature may lie beside the axis of its shape, over the shape's radius: what the narrow phase is off by.
const ASIDE: f32 = 1.0e-2;

/// Squared sine of the angle between a normal and an axis from which on a rim has a lowest point.
const LEVEL: f32 = 1.0e-6;

/// Centripetal acceleration of the round features of a body that turns, over gravity, from which on they are followed in each substep.
///
/// Why: what is accelerated by more than gravity leaves a floor, unless it lies near the axis about which its body spins, as the tip of a top
/// does. A top that stands has 18 and more. How near it is does not count: at the cusps of its way the axis of a top stands still.
/// Scenes: tops of 3 mm to 30 cm, 30 to 200 rad/s, 60 to 240 Hz.
/// Test: tests/tops.rs
const SWUNG: f32 = 1.0;

/// Change of the height of the ends of a shape's axis within a step, over its half length, from which on its features are not followed.
///
/// Why: another feature comes down to the floor then, and the manifold has none there: of 1440 solids that were thrown onto floors with up to 50
/// rad/s a capsule of 5 mm fell through a height field. A top nods by a hundredth.
/// Scenes: thrown solids at 30 to 120 Hz; tops, and coins spun on their edge.
/// Test: tests/fast_bodies.rs
const TIPPED: f32 = 0.5;

/// A cap, a rim or a tip.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoundFeature {
    /// Axis of the shape (unit vector), radius of the circle about it (m), and that of the ball around that (m).
    axis: DVec3,
    rim: f64,
    ball: f64,
}

impl RoundFeature {
    /// The feature of a shape at a point of its surface with this outward normal, in the shape's frame; none where it is flat or not round.
    pub(crate) fn at(shape: &Shape, at: Vec3, outward: Vec3) -> Option<Self> {
        let (rim, ball, radius) = match *shape.geometry() {
            Geometry::Ball { radius } | Geometry::Capsule { radius, .. } => (0.0, radius, radius),
            Geometry::Cylinder { radius, .. } => (radius, 0.0, radius),
            Geometry::Cone { half_height, radius } => (radius * (0.5 - 0.5 * at.y / half_height).clamp(0.0, 1.0), 0.0, radius),
            _ => return None,
        };
        if rim > 0.0 && outward.x * outward.x + outward.z * outward.z < LEVEL {
            return None;
        }
        let feature = Self { axis: DVec3::Y, rim: f64::from(rim), ball: f64::from(ball) };
        let middle = at - feature.reach(DQuat::IDENTITY, outward.as_dvec3()).as_vec3();
        (Vec2::new(middle.x, middle.z).length() <= ASIDE * radius).then_some(feature)
    }

    /// The same feature in axes in which the shape is turned like this.
    pub(crate) fn turned(self, rotation: Quat) -> Self {
        Self { axis: rotation.as_dquat().normalize() * self.axis, ..self }
    }

    /// From the feature's middle to where its surface has this outward normal, with its body turned by `turn` (m).
    pub(crate) fn reach(&self, turn: DQuat, outward: DVec3) -> DVec3 {
        let axis = turn * self.axis;
        outward * self.ball + outward.reject_from_normalized(axis).normalize_or_zero() * self.rim
    }
}

/// How far the ends of a round shape's axis are from its middle, and the greatest radius of a circle about it that is a feature (m).
fn sizes(shape: &Shape) -> Option<(f32, f32)> {
    match *shape.geometry() {
        Geometry::Ball { .. } => Some((0.0, 0.0)),
        Geometry::Capsule { half_height, .. } => Some((half_height, 0.0)),
        Geometry::Cylinder { half_height, radius } | Geometry::Cone { half_height, radius } => Some((half_height, radius)),
        _ => None,
    }
}

/// How far a turn (rad) of its body takes what a round shape at `offset` from the centre of mass is made of, or how fast it does at an angular
/// velocity (rad/s); none for other shapes.
pub(crate) fn carried_by(shape: &Shape, (offset, rotation): (Vec3, Quat), turn: Vec3) -> Option<f32> {
    let (half_height, rim) = sizes(shape)?;
    let axis = rotation * Vec3::Y;
    let ends = [-half_height, half_height].map(|end| turn.cross(offset + axis * end).length());
    Some(ends[0].max(ends[1]) + rim * turn.cross(axis).length())
}

impl ColliderState {
    /// Whether its body, which turns at `angular` (rad/s), swings round features so fast that they are to be followed in each substep; `gravity` is
    /// the acceleration of free fall (m/s²), in a step of length `dt` (s).
    fn is_swung(&self, shape: &Shape, angular: Vec3, gravity: Vec3, dt: f32) -> bool {
        // What turns this slowly is not, however long it is: a shape of circles reaches no further than √2 of what holds it.
        let may_be = angular.length_squared() * (2.0 * self.turning * self.turning) > SWUNG * SWUNG * gravity.length_squared();
        if !may_be || !self.is_round || self.is_unmoved() {
            return false;
        }
        let (offset, rotation) = self.frame();
        let Some((half_height, rim)) = sizes(shape) else { return false };
        let axis = rotation * Vec3::Y;
        if angular.cross(axis).dot(gravity).abs() * dt > TIPPED * gravity.length() {
            return false;
        }
        let axis = axis * half_height;
        let reach = (offset + axis).length().max((offset - axis).length()) + rim;
        // Written so that what does not turn is not, without gravity either.
        angular.length_squared() * reach > SWUNG * gravity.length()
    }
}

/// Of two shapes that press, whose round features are swung so fast that they are followed in each substep, and not turned ahead. Joints hold what
/// they hold by rows of their own, and levers on what the host turns go with that.
pub(crate) fn swung((a, b): (&ColliderState, &ColliderState), [of_a, of_b]: &[Follow; 2], gravity: Vec3, dt: f32) -> [bool; 2] {
    let is_other = |of: &Follow| of.is_jointed || of.is_driven && of.angular != Vec3::ZERO;
    if is_other(of_a) || is_other(of_b) {
        return [false; 2];
    }
    [(a, of_a), (b, of_b)].map(|(state, of)| state.is_swung(of.shape, of.angular, gravity, dt))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In closed form: the lowest points of shapes that lean.
    #[test]
    fn features_reach_to_the_lowest_point_of_a_leaning_shape() {
        let lean = DQuat::from_rotation_z(0.3);
        let down = DVec3::NEG_Y;
        let cylinder = Shape::new(Geometry::Cylinder { half_height: 1.0, radius: 0.5 }).unwrap();
        let (sin, cos) = 0.3_f32.sin_cos();
        let outward = Vec3::new(-sin, -cos, 0.0);
        let rim = RoundFeature::at(&cylinder, Vec3::new(-0.5, -1.0, 0.0), outward).expect("a rim");
        let reach = rim.reach(lean, down);
        let expected = DVec3::new(-0.5 * 0.3_f64.cos(), -0.5 * 0.3_f64.sin(), 0.0);
        assert!((reach - expected).length() < 1e-7, "{reach}, expected {expected}");
        let capsule = Shape::capsule(1.0, 0.5).unwrap();
        let cap = RoundFeature::at(&capsule, Vec3::NEG_Y + outward * 0.5, outward).expect("a cap");
        assert_eq!(cap.reach(lean, down), down * 0.5);
        let cone = Shape::new(Geometry::Cone { half_height: 1.0, radius: 0.5 }).unwrap();
        let tip = RoundFeature::at(&cone, Vec3::Y, Vec3::Y).expect("a tip");
        assert_eq!(tip.reach(lean, down), DVec3::ZERO);
        assert!(RoundFeature::at(&cylinder, Vec3::new(0.2, -1.0, 0.0), Vec3::NEG_Y).is_none(), "a flat end");
    }

    #[test]
    fn spin_about_its_own_axis_takes_a_round_shape_nowhere() {
        let disc = Shape::new(Geometry::Cylinder { half_height: 0.1, radius: 1.0 }).unwrap();
        let pose = (Vec3::Y * 0.4, Quat::IDENTITY);
        assert_eq!(carried_by(&disc, pose, Vec3::Y * 10.0), Some(0.0));
        assert_eq!(carried_by(&disc, pose, Vec3::X), Some(1.5));
        assert_eq!(carried_by(&Shape::cuboid(Vec3::ONE).unwrap(), pose, Vec3::Y), None);
    }
}
