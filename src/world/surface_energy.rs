//! Stage that keeps the energy of balls that slide or roll along smooth surfaces of triangles.
//!
//! A bowl of triangles stands for a smooth one, whose force is along its normal and does no work. In steps it does: a plane that is one
//! step old lets a ball sink in, which position recovery undoes without a velocity (a gain of up to g/R dt of the kinetic energy a second), and
//! rows take away what goes into the next plane (θ² of it at each edge of angle θ, or in each step of a finer mesh). The two do not cancel but
//! for one radius, amplitude and rate.
//!
//! So where nothing but such a surface acts on a ball, and it neither hits nor rubs, its energy is what it was but for gravity's work,
//!
//! ```text
//! v ← s v,  ω ← s ω,    s² T' = T + m g·(x' − x),
//! ```
//!
//! with x' after position recovery. A ball without friction keeps its ω. What turns by more than a smooth surface does is a hit, and loses
//! what a hit loses; the two sides of a groove are no such surface.

use glam::{DVec3, Vec3};

use super::body_shape_table::BodyShapeTable;
use super::{Collision, World};
use crate::body::{Body, LockedAxes};
use crate::collide::collider::Collider;
use crate::collide::collider_state::ColliderState;
use crate::collide::pairs::{Pair, PairKey};
use crate::contact::TOUCHED;
use crate::id::{BodyId, Pool, ShapeId};
use crate::material::PairMaterial;
use crate::shape::Geometry;
use crate::tuning::surface::{MAX_SINK, MAX_SLIP, MAX_TURN, MAX_TURN_OF_FAST};

/// Change of energy that is let be, as a share of the kinetic energy: rounding of `f32`.
const LET_BE: f64 = 1.0e-6;

/// Factor on the velocity up to which it has a direction worth keeping.
const MAX_SCALE: f32 = 10.0;

/// A ball that presses on a surface of triangles as the step begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct BallOnSurface {
    ball: u32,
    /// Slot of the pair, and whether the ball is its second.
    slot: u32,
    is_second: bool,
    has_friction: bool,
    radius: f32,
    center: DVec3,
    linear_velocity: Vec3,
    angular_velocity: Vec3,
}

impl BallOnSurface {
    /// Of a pair that presses as the step begins; the ball's next triangle need not yet.
    pub(super) fn of(
        slot: u32,
        key: PairKey,
        (a, b): (&ColliderState, &ColliderState),
        colliders: &Pool<Collider, ShapeId>,
        bodies: &Pool<Body, BodyId>,
    ) -> Option<Self> {
        let is_second = a.still;
        let (ball, surface) = if is_second { (b, a) } else { (a, b) };
        if !ball.is_round || ball.still || !surface.still || ball.offset != Vec3::ZERO {
            return None;
        }
        let (lower, upper) = key.shapes();
        let (shape, under) = if is_second { (upper, lower) } else { (lower, upper) };
        let Geometry::Ball { radius } = *colliders[shape].shape.geometry() else { return None };
        let is_surface =
            matches!(colliders[under].shape.geometry(), Geometry::TriangleMesh { .. } | Geometry::HeightField { .. });
        let material = PairMaterial::combine(&ball.material, &surface.material);
        let body = &bodies[ball.body];
        let is_plain = material.rolling == 0.0 && material.spinning == 0.0 && is_moved_by_gravity_alone(body);
        (is_surface && is_plain).then_some(Self {
            ball: ball.body,
            slot,
            is_second,
            has_friction: material.friction > 0.0,
            radius,
            center: body.center,
            linear_velocity: body.linear_velocity,
            angular_velocity: body.angular_velocity,
        })
    }

    /// Towards the ball, of each manifold that presses; none where one has rebounded.
    fn normals(&self, pair: &Pair, index: &BodyShapeTable) -> Option<impl Iterator<Item = Vec3>> {
        let turn = index.collider_state(pair.key.shapes().0).rotation;
        let sign = if self.is_second { 1.0 } else { -1.0 };
        let has_rebounded = pair.manifolds.iter().any(|manifold| manifold.impulses.normal[0] == TOUCHED);
        let pressed = pair.manifolds.iter().filter(|manifold| manifold.impulses.normal[0] > 0.0);
        (pair.pressed && !has_rebounded).then(|| pressed.map(move |manifold| turn * manifold.normal * sign))
    }

    /// Whether what it may come to in a step of length `dt` (s) is turned by more than a smooth surface is: the two sides of a groove.
    fn is_in_groove(&self, pair: &Pair, (gravity, dt): (Vec3, f32), max_turn: f32) -> bool {
        let way = (self.linear_velocity.length() + gravity.length() * dt) * dt + MAX_SINK * self.radius;
        let near = pair.manifolds.iter().filter(|manifold| manifold.points.iter().any(|point| point.separation < way));
        let mut first = None;
        near.map(|manifold| manifold.normal).any(|normal| normal.cross(*first.get_or_insert(normal)).length() > max_turn)
    }

    /// Whether a ball with these velocities follows a plane with this normal without rubbing on it, and comes to it turned by no more
    /// than a smooth surface turns in a step.
    fn follows(&self, normal: Vec3, linear: Vec3, angular: Vec3, max_turn: f32) -> bool {
        let speed = linear.length();
        let slip = linear - angular.cross(normal) * self.radius;
        let rubs = self.has_friction && slip.reject_from_normalized(normal).length() > MAX_SLIP * speed;
        linear.dot(normal) >= -max_turn * speed && !rubs
    }

    /// Sine of the angle by which a smooth surface may turn in a step: more where the ball goes farther than its own size.
    fn max_turn(&self, dt: f32) -> f32 {
        (self.linear_velocity.length() * dt / (4.0 * self.radius)).clamp(MAX_TURN, MAX_TURN_OF_FAST)
    }
}

/// Whether the body is a ball of one shape and nothing but gravity and contacts changes its velocity.
fn is_moved_by_gravity_alone(body: &Body) -> bool {
    let is_free = body.joints.is_empty() && body.settings.locked_axes == LockedAxes::default() && body.shapes.len() == 1;
    let is_pushed = body.force != Vec3::ZERO || body.torque != Vec3::ZERO;
    is_free && !is_pushed && body.settings.linear_damping == 0.0 && body.settings.angular_damping == 0.0
}

impl World {
    /// Gives balls on surfaces the speed that gravity's work leaves them.
    pub(super) fn keep_energy_on_surfaces(&mut self, dt: f32) {
        let Self { bodies, scratch, collision: Collision { pairs, touches, index, .. }, def, .. } = self;
        let balls = &mut scratch.balls_on_surfaces;
        balls.clear();
        scratch.found_balls.iter_mut().for_each(|found| balls.append(found));
        if balls.is_empty() {
            return;
        }
        // A ball that presses on anything else is left to its contacts.
        balls.sort_unstable_by_key(|ball| (ball.ball, ball.slot));
        let on_others = touches.touching().filter(|touch| pairs.get(touch.slot).pressed);
        let mut elsewhere = std::mem::take(&mut scratch.slots);
        elsewhere.clear();
        elsewhere.extend(on_others.flat_map(|touch| {
            touch
                .bodies
                .into_iter()
                .filter(|&body| balls.binary_search_by_key(&body, |ball| ball.ball).is_ok_and(|at| balls[at].slot != touch.slot))
        }));
        elsewhere.sort_unstable();
        for ball in balls.iter().filter(|ball| elsewhere.binary_search(&ball.ball).is_err()) {
            let Some(mut normals) = ball.normals(pairs.get(ball.slot), index) else { continue };
            let body = &mut bodies[ball.ball];
            let max_turn = ball.max_turn(dt);
            if ball.is_in_groove(pairs.get(ball.slot), (def.gravity, dt), max_turn) {
                continue;
            }
            let keeps = normals.all(|normal| {
                ball.follows(normal, ball.linear_velocity, ball.angular_velocity, max_turn)
                    && ball.follows(normal, body.linear_velocity, body.angular_velocity, max_turn)
            });
            if keeps && !body.quarantined {
                keep_energy(ball, body, def.gravity, max_turn);
            }
        }
        scratch.slots = elsewhere;
    }
}

/// Scales the velocities of a ball to the energy that it has after gravity's work.
fn keep_energy(ball: &BallOnSurface, body: &mut Body, gravity: Vec3, max_turn: f32) {
    let Some(mass) = body.mass else { return };
    // Over the mass, and twice.
    let inertia = f64::from(mass.principal_inertia.x / mass.mass);
    let turning = |angular: Vec3| if ball.has_friction { inertia * f64::from(angular.length_squared()) } else { 0.0 };
    let energy = |linear: Vec3, angular: Vec3| f64::from(linear.length_squared()) + turning(angular);
    let fall = gravity.as_dvec3().dot(body.center - ball.center) * f64::from(body.settings.gravity_scale);
    let before = energy(ball.linear_velocity, ball.angular_velocity);
    let after = energy(body.linear_velocity, body.angular_velocity);
    let wanted = before + 2.0 * fall;
    if (wanted - after).abs() <= LET_BE * after {
        return;
    }
    // What the surface can have taken: by turning the velocity, or by letting the ball sink to it.
    let most = f64::from(max_turn * max_turn) * before.max(after) + 2.0 * f64::from(MAX_SINK * ball.radius * gravity.length());
    let scale = ((wanted - after).clamp(-most, most) / after + 1.0).max(0.0).sqrt() as f32;
    if !scale.is_finite() || scale > MAX_SCALE {
        return;
    }
    body.linear_velocity *= scale;
    if ball.has_friction {
        body.angular_velocity *= scale;
    }
}
