//! A pair of shapes as the support analysis sees it: is it pressed, does it hold, which body stands on which.

use glam::{Vec2, Vec3};

use crate::body::Body;
use crate::collide::collider::Collider;
use crate::collide::pairs::{CarriedManifold, Pair, WorldManifold, touching};
use crate::id::{BodyId, Pool, ShapeId};
use crate::solve::contact::tangents;
use crate::span::support::Link;
use crate::span::support::slip::Slip;

/// Least cosine between a contact's normal and the vertical for one body to stand on the other.
const MIN_RISE: f32 = 0.3;

/// Up, and two axes across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::world) struct Frame {
    pub up: Vec3,
    pub across: (Vec3, Vec3),
}

impl Frame {
    pub(in crate::world) fn new(gravity: Vec3) -> Option<Self> {
        let up = (-gravity).try_normalize()?;
        Some(Self { up, across: tangents(up) })
    }

    fn project(&self, v: Vec3) -> Vec2 {
        Vec2::new(v.dot(self.across.0), v.dot(self.across.1))
    }
}

/// A pair with its shapes and bodies.
pub(in crate::world) struct Site<'a> {
    pub pair: &'a Pair,
    pub slot: u32,
    pub shapes: (&'a Collider, &'a Collider),
    pub bodies: (&'a Body, &'a Body),
}

impl<'a> Site<'a> {
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

    fn world(&self, manifold: &CarriedManifold) -> WorldManifold {
        WorldManifold::new(&manifold.geometry, (self.shapes.0, self.bodies.0), (self.shapes.1, self.bodies.1))
    }

    /// Points of a manifold that take part, as bits, if it is pressed; and whether it holds, given that it held before or not.
    pub(in crate::world) fn state(&self, manifold: &CarriedManifold, held: bool) -> (u8, bool) {
        let points = touching(manifold, self.shapes.0.least_extent.min(self.shapes.1.least_extent));
        if points == 0 {
            return (0, held);
        }
        let (a, b) = self.bodies;
        let (linear, turning) =
            (b.linear_velocity - a.linear_velocity, |body: &Body, shape: &Collider| body.angular_velocity.length() * shape.reach);
        if linear.length() + turning(a, self.shapes.0) + turning(b, self.shapes.1) <= Slip::ALWAYS_HOLDS {
            return (points, true);
        }
        let world = self.world(manifold);
        let count = manifold.geometry.count as usize;
        let center = |levers: &[Vec3; 4]| levers[..count].iter().sum::<Vec3>() / count as f32;
        let rate = linear + b.angular_velocity.cross(center(&world.lever_b)) - a.angular_velocity.cross(center(&world.lever_a));
        let approach = rate.dot(world.normal);
        let slip = Slip {
            slip: (rate - world.normal * approach).length(),
            approach,
            friction: manifold.impulses.friction.length(),
            limit: self.pair.material.friction * manifold.impulses.normal.iter().sum::<f32>(),
        };
        (points, slip.holds(held))
    }

    /// The link of a pressed manifold with these points, if one of the bodies stands on the other.
    pub(in crate::world) fn link(&self, manifold: &CarriedManifold, points: u8, holds: bool, frame: &Frame) -> Option<Link> {
        let world = self.world(manifold);
        let rise = world.normal.dot(frame.up);
        if rise.abs() < MIN_RISE {
            return None;
        }
        let (a, b) = (self.shapes.0.body, self.shapes.1.body);
        let (lower, upper, on_lower, on_upper) =
            if rise > 0.0 { (a, b, &world.lever_a, &world.lever_b) } else { (b, a, &world.lever_b, &world.lever_a) };
        let stands = if rise > 0.0 { self.bodies.1.is_dynamic() } else { self.bodies.0.is_dynamic() };
        if !stands {
            return None;
        }
        let mut link = Link { lower, upper, points: [Vec2::ZERO; 4], count: 0, offset: Vec2::ZERO, holds, pair: self.slot };
        for i in (0..4).filter(|i| points & (1 << i) != 0) {
            link.points[link.count as usize] = frame.project(on_lower[i]);
            link.offset += frame.project(on_upper[i] - on_lower[i]);
            link.count += 1;
        }
        link.offset /= f32::from(link.count);
        Some(link)
    }

    /// Impulse of all manifolds of the pair on its second body, upwards (N·s).
    pub(in crate::world) fn force(&self, frame: &Frame) -> f32 {
        let upwards = |manifold: &CarriedManifold| {
            let normal = self.world(manifold).normal * manifold.impulses.normal.iter().sum::<f32>();
            (normal + manifold.impulses.friction).dot(frame.up)
        };
        self.pair.manifolds.iter().map(upwards).sum()
    }
}
