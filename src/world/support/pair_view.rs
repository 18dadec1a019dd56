//! A pair of shapes as the support analysis sees it: whether it presses and holds, and which body stands on which.

use glam::{Vec2, Vec3};

use crate::body::Body;
use crate::collide::collider::Collider;
use crate::collide::pairs::{Pair, WorldManifold};
use crate::collide::persistent_manifold::{Carried, touching};
use crate::contact::status::StatusThresholds;
use crate::id::{BodyId, Pool, ShapeId};
use crate::joint_graph::support::SupportLink;
use crate::joint_graph::support::slip::Slip;
use crate::solve::contact::tangents;
use crate::tuning::support::EXHAUSTED_SHARE;
pub(super) use crate::tuning::support::MIN_RISE;

/// Rotation of a body after which its links are made anew (rad), and shift of a link's points that counts, over the lesser extent.
pub(super) const TURN: f32 = 1.0e-3;

/// Up, and two axes across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::world) struct PairFrame {
    pub up: Vec3,
    pub across: (Vec3, Vec3),
}

impl PairFrame {
    pub(in crate::world) fn new(gravity: Vec3) -> Option<Self> {
        let up = (-gravity).try_normalize()?;
        Some(Self { up, across: tangents(up) })
    }

    fn project(&self, v: Vec3) -> Vec2 {
        Vec2::new(v.dot(self.across.0), v.dot(self.across.1))
    }
}

/// What the solver is to tell manifolds by; nothing without gravity.
pub(in crate::world) fn told_by(gravity: Vec3) -> Option<StatusThresholds> {
    PairFrame::new(gravity).map(|frame| Slip::limits(frame.up, MIN_RISE, EXHAUSTED_SHARE))
}

/// A pair with its shapes and bodies.
pub(in crate::world) struct PairView<'a> {
    pub pair: &'a Pair,
    pub slot: u32,
    pub shapes: (&'a Collider, &'a Collider),
    pub bodies: (&'a Body, &'a Body),
}

impl<'a> PairView<'a> {
    pub(in crate::world) fn new(
        pair: &'a Pair,
        slot: u32,
        colliders: &'a Pool<Collider, ShapeId>,
        bodies: &'a Pool<Body, BodyId>,
    ) -> Self {
        let (a, b) = pair.key.shapes();
        let shapes = (&colliders[a], &colliders[b]);
        Self { pair, slot, shapes, bodies: (&bodies[shapes.0.body], &bodies[shapes.1.body]) }
    }

    fn world(&self, manifold: &Carried) -> WorldManifold {
        WorldManifold::new(manifold, (self.shapes.0, self.bodies.0), (self.shapes.1, self.bodies.1))
    }

    /// Points of a manifold that take part, as bits, if it is pressed; and whether it holds, given that it held before or not.
    pub(in crate::world) fn state(&self, manifold: &Carried, held: bool) -> (u8, bool) {
        let points = touching(manifold, self.shapes.0.least_extent.min(self.shapes.1.least_extent));
        if points == 0 {
            return (0, held);
        }
        let (a, b) = self.bodies;
        let turning = |body: &Body, shape: &Collider| body.angular_velocity.length() * shape.reach;
        let linear = (b.linear_velocity - a.linear_velocity).length();
        let turning = turning(a, self.shapes.0) + turning(b, self.shapes.1);
        let has_reserve = || has_reserve(manifold, self.shapes.0.surface_with(self.shapes.1).friction);
        let holds = Slip::at_speeds(linear - turning, linear + turning, held, has_reserve).unwrap_or_else(|| {
            let rate = self.rate(manifold);
            let normal = self.normal(manifold);
            let approach = rate.dot(normal);
            Slip { slip: (rate - normal * approach).length(), approach, has_reserve: has_reserve() }.holds(held)
        });
        (points, holds)
    }

    /// The same of one that the solver has just told of. It does not tell of what is at rest, nor of what it no longer moves.
    pub(super) fn told_state(&self, manifold: &Carried, held: bool) -> (u8, bool) {
        let (a, b) = self.bodies;
        if !self.pair.is_told() || a.held || b.held || !(a.is_solved() || b.is_solved()) {
            return self.state(manifold, held);
        }
        let points = self.pair.touches as u8;
        debug_assert_eq!(points, touching(manifold, self.shapes.0.least_extent.min(self.shapes.1.least_extent)));
        (points, if points == 0 { held } else { Slip::told_to_hold(self.pair.told, held) })
    }

    fn normal(&self, manifold: &Carried) -> Vec3 {
        self.shapes.0.place.1 * manifold.normal
    }

    /// Velocity of B's surface against A's in the middle of a manifold (m/s).
    fn rate(&self, manifold: &Carried) -> Vec3 {
        let points = manifold.points;
        let middle = points.iter().map(|point| point.on_a).sum::<Vec3>() / points.len() as f32;
        let (a, b) = self.bodies;
        let lever_a = lever(a, self.shapes.0, middle);
        let lever_b = lever_a + (a.center - b.center).as_vec3();
        b.linear_velocity - a.linear_velocity + b.angular_velocity.cross(lever_b) - a.angular_velocity.cross(lever_a)
    }

    /// Whether a manifold can be one through which one of the bodies stands on the other: how much its normal rises.
    fn rise(&self, manifold: &Carried, frame: &PairFrame) -> Option<f32> {
        Some(self.normal(manifold).dot(frame.up)).filter(|rise| rise.abs() >= MIN_RISE)
    }

    /// Whether one of the bodies needs no support, and the other stands on it, or presses it from any side if `by_thrust` counts.
    pub(in crate::world) fn is_on_base(&self, frame: Option<&PairFrame>, by_thrust: bool) -> bool {
        let Some(frame) = frame else { return false };
        let stands = |manifold: Carried| {
            let lower = |rise: f32| if rise > 0.0 { self.bodies.0 } else { self.bodies.1 };
            by_thrust || self.rise(&manifold, frame).is_some_and(|rise| !lower(rise).is_dynamic())
        };
        self.bodies.0.is_dynamic() != self.bodies.1.is_dynamic() && self.pair.manifolds.iter().any(stands)
    }

    /// The link of a pressed manifold with these points, if one of the bodies stands on the other.
    pub(in crate::world) fn link(&self, manifold: &Carried, points: u8, holds: bool, frame: &PairFrame) -> Option<SupportLink> {
        let rise = self.rise(manifold, frame)?;
        let (a, b) = ((self.bodies.0, self.shapes.0), (self.bodies.1, self.shapes.1));
        let (lower, upper) = if rise > 0.0 { (a, b) } else { (b, a) };
        if !upper.0.is_dynamic() {
            return None;
        }
        let slack = TURN * lower.1.least_extent.min(upper.1.least_extent);
        let (pair, offset) = (self.slot, frame.project((lower.0.center - upper.0.center).as_vec3()));
        let mut link = SupportLink {
            lower: lower.1.body,
            upper: upper.1.body,
            points: [Vec2::ZERO; 4],
            count: 0,
            offset,
            slack,
            holds,
            pair,
        };
        for (i, point) in manifold.points.iter().enumerate() {
            if !holds || points & (1 << i) == 0 {
                continue;
            }
            let on_lower = if rise > 0.0 { point.on_a } else { point.on_b };
            link.points[link.count as usize] = frame.project(lever(lower.0, lower.1, on_lower));
            link.count += 1;
        }
        Some(link)
    }

    /// Impulse of all manifolds of the pair on its second body, upwards (N·s).
    pub(in crate::world) fn force(&self, frame: &PairFrame) -> f32 {
        let upwards = |manifold: Carried| {
            let normal = self.world(&manifold).normal * manifold.impulses.normal.iter().sum::<f32>();
            (normal + manifold.impulses.friction).dot(frame.up)
        };
        self.pair.manifolds.iter().map(upwards).sum()
    }
}

/// Whether the friction of a manifold is below its limit.
pub(super) fn has_reserve(manifold: &Carried, friction: f32) -> bool {
    let limit = EXHAUSTED_SHARE * friction * manifold.impulses.normal.iter().sum::<f32>();
    manifold.impulses.friction.length_squared() < limit * limit
}

/// A point of a shape from its body's centre of mass, in world axes (m).
fn lever(body: &Body, shape: &Collider, point: Vec3) -> Vec3 {
    body.rotation * (shape.local_pose.position - body.local_center) + shape.place.1 * point
}
