//! The state of a collider in this step: everything that contact generation reads of a shape and its body.
//!
//! A pile has ten pairs for each body. Each asks for a few numbers of two shapes and two bodies, records of hundreds of bytes of which
//! a large pile has more than the cache holds; these are two lines of it, and the first alone says that boxes do not meet.

use glam::{DVec3, Quat, Vec3};
use parry3d::bounding_volume::Aabb;

use super::collider::{Collider, margin_of};
use crate::body::{Body, BodyKind};
use crate::material::Material;
use crate::shape::Shape;

/// Copies of what [`Collider`] and [`Body`] have when contacts are brought up to date.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct ColliderState {
    pub tight_box: Aabb,
    pub body: u32,
    pub least_extent: f32,
    /// World position of the shape's origin (m).
    pub position: DVec3,
    /// Speed at which the farthest point of the shape turns (m/s).
    pub turning: f32,
    /// Factor on gravity; zero for what it does not pull.
    fall: f32,
    pub rotation: Quat,
    pub velocity: Vec3,
    /// From the body's centre of mass to the shape's origin (m, world axes).
    pub offset: Vec3,
    pub material: Material,
    /// Whether nothing has moved the body since its contacts were made, or can.
    pub still: bool,
    /// Whether it is a ball or a shape of circles.
    pub is_round: bool,
    /// Whether the host moves the body.
    is_driven: bool,
}

/// Way in a step from which on a body glides over another that moves, over the lesser least extent: what goes less far loses nothing to
/// speak of at a seam. Over what can't be pushed it glides at any speed, for what lies there at rest must not be held by a seam either.
const MIN_GLIDE: f32 = 1.0e-4;

/// Turn of a body in a step from which on its contacts with what joints hold are looked for along its way (rad).
const FAR_TURN: f32 = 0.1;

/// Speed, over that of what glides over it, below which a body is still.
const STILLNESS: f32 = 0.01;

const _: () = assert!(size_of::<ColliderState>() == 128);

/// What is asked of a shape whose manifolds are made anew.
#[derive(Clone, Copy)]
pub(crate) struct Follow<'a> {
    pub shape: &'a Shape,
    /// Angular velocity of its body (rad/s).
    pub angular: Vec3,
    /// Whether joints hold the body: it does not go on as it moves, and articulations follow bent surfaces by themselves.
    pub is_jointed: bool,
    /// Whether the host moves the body.
    pub is_driven: bool,
    /// Whether contacts can move the body once it is awake.
    pub is_free: bool,
}

impl<'a> Follow<'a> {
    /// Whether no joint holds the body, and it turns so far in a step of length `dt` (s) that levers of its contacts tell nothing of where they go.
    pub(super) fn is_free_and_turns(&self, dt: f32) -> bool {
        !self.is_jointed && self.is_free && self.angular.length() * dt > FAR_TURN
    }

    pub(crate) fn of(collider: &'a Collider, body: &Body) -> Self {
        let is_driven = body.is_mover() && !body.is_free();
        Self {
            shape: &collider.shape,
            angular: body.angular_velocity,
            is_jointed: !body.joints.is_empty(),
            is_driven,
            is_free: body.is_free(),
        }
    }
}

impl ColliderState {
    /// In place of one that nobody has asked for yet.
    pub(crate) const UNKNOWN: Self = Self {
        tight_box: Aabb { mins: Vec3::ZERO, maxs: Vec3::ZERO },
        body: u32::MAX,
        least_extent: 0.0,
        position: DVec3::ZERO,
        turning: 0.0,
        fall: 0.0,
        rotation: Quat::IDENTITY,
        velocity: Vec3::ZERO,
        offset: Vec3::ZERO,
        material: Material::PLAIN,
        still: true,
        is_round: false,
        is_driven: false,
    };

    pub(crate) fn of(shape: &Collider, body: &Body) -> Self {
        let is_mover = body.is_mover();
        Self {
            tight_box: shape.tight_box,
            body: shape.body,
            least_extent: shape.least_extent,
            position: shape.place.0,
            turning: body.angular_velocity.length() * shape.reach,
            fall: if body.is_free() && is_mover { body.settings.gravity_scale } else { 0.0 },
            rotation: shape.place.1,
            velocity: body.linear_velocity,
            offset: shape.offset_on(body),
            material: shape.material,
            still: body.held || !is_mover,
            is_round: shape.shape.is_round(),
            is_driven: body.kind == BodyKind::Kinematic,
        }
    }

    /// How far two shapes can move against each other in a step (m).
    pub(crate) fn motion_against(&self, other: &Self, gravity: Vec3, dt: f32) -> f32 {
        let closing = other.velocity - self.velocity + other.falls_against(self, gravity, dt);
        (closing.length() + self.turning + other.turning) * dt
    }

    /// What gravity changes of the velocity against another in a step (m/s).
    pub(crate) fn falls_against(&self, other: &Self, gravity: Vec3, dt: f32) -> Vec3 {
        gravity * ((self.fall - other.fall) * dt)
    }

    /// Whether another body moves over this one, rather than this over that: this is what can't be pushed, or else what a round one rolls on, or
    /// else what moves along more slowly.
    pub(crate) fn is_ground_of(&self, other: &Self) -> bool {
        match self.is_unmoved() == other.is_unmoved() {
            true if self.is_round != other.is_round => other.is_round,
            true => self.velocity.length_squared() < other.velocity.length_squared(),
            false => self.is_unmoved(),
        }
    }

    /// Whether what lies on the body cannot push it.
    pub(crate) fn is_unmoved(&self) -> bool {
        self.still || self.is_driven
    }

    /// Whether a round body moves over a flat one that moves too: how this one moves is judged against its neighbours.
    fn rolls_over(&self, other: &Self) -> bool {
        self.is_round && !other.is_round && !other.is_unmoved()
    }

    /// Whether the body moves along over another that hardly moves, but as the host moves it along or what rolls over it does, or may begin to. Of
    /// those that a body may roll over and push along, only what joints hold is a way, as planks of a bridge are: the rest lies in heaps.
    pub(crate) fn glides_over(&self, other: &Self, dt: f32, is_held: impl Fn(u32) -> bool) -> bool {
        let way = MIN_GLIDE * self.least_extent.min(other.least_extent);
        let rolls = self.rolls_over(other) && is_held(other.body);
        let [over, own] = match other.is_driven || rolls {
            true => [self.velocity - other.velocity, Vec3::ZERO],
            false => [self.velocity, other.velocity],
        };
        let speed_squared = over.length_squared();
        if speed_squared * (dt * dt) <= way * way {
            return other.is_unmoved() && other.turning == 0.0 && !self.is_unmoved();
        }
        rolls || own.length() + other.turning < STILLNESS * speed_squared.sqrt()
    }

    /// Distance at which two shapes become contacts even without relative motion (m).
    pub(crate) fn contact_margin(&self, other: &Self) -> f32 {
        margin_of(self.least_extent).min(margin_of(other.least_extent))
    }

    /// From the centre of mass to the shape's origin (m), and how the shape is turned.
    pub(crate) fn frame(&self) -> (Vec3, Quat) {
        (self.offset, self.rotation)
    }
}
