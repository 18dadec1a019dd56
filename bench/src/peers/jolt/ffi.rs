//! `jolt_shim.h` as Rust sees it; the comments are there.

use glam::{Quat, Vec3};

#[repr(C)]
pub struct JoltWorld {
    _private: [u8; 0],
}

#[repr(C)]
pub struct JoltShape {
    _private: [u8; 0],
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct JoltVec3 {
    x: f32,
    y: f32,
    z: f32,
}

impl From<Vec3> for JoltVec3 {
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<JoltVec3> for Vec3 {
    fn from(v: JoltVec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct JoltQuat {
    x: f32,
    y: f32,
    z: f32,
    w: f32,
}

impl From<Quat> for JoltQuat {
    fn from(q: Quat) -> Self {
        Self { x: q.x, y: q.y, z: q.z, w: q.w }
    }
}

impl From<JoltQuat> for Quat {
    fn from(q: JoltQuat) -> Self {
        Self::from_xyzw(q.x, q.y, q.z, q.w)
    }
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct JoltFrame {
    pub position: JoltVec3,
    pub rotation: JoltQuat,
}

#[repr(C)]
pub struct JoltWorldDef {
    pub gravity: JoltVec3,
    pub restitution_threshold: f32,
    pub collision_steps: u32,
    pub threads: u32,
    pub allow_sleeping: bool,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct JoltMass {
    pub mass: f32,
    pub center: JoltVec3,
    pub inertia: [f32; 9],
}

pub const JOLT_STATIC: u32 = 0;
pub const JOLT_KINEMATIC: u32 = 1;
pub const JOLT_DYNAMIC: u32 = 2;

#[repr(C)]
pub struct JoltBodyDef {
    pub frame: JoltFrame,
    pub linear_velocity: JoltVec3,
    pub angular_velocity: JoltVec3,
    pub mass: JoltMass,
    pub friction: f32,
    pub restitution: f32,
    pub linear_damping: f32,
    pub angular_damping: f32,
    pub gravity_factor: f32,
    pub motion: u32,
    pub member_of: u32,
    pub collides_with: u32,
    pub allowed_axes: u8,
    pub continuous: bool,
    pub allow_sleeping: bool,
}

pub const JOLT_FIXED: u32 = 0;
pub const JOLT_HINGE: u32 = 1;
pub const JOLT_POINT: u32 = 2;
pub const JOLT_DISTANCE: u32 = 3;
pub const JOLT_SLIDER: u32 = 4;
pub const JOLT_CONE: u32 = 5;

pub const JOLT_GROUND: u32 = u32::MAX;

#[repr(C)]
pub struct JoltJointDef {
    pub kind: u32,
    pub a: u32,
    pub b: u32,
    pub frame_a: JoltFrame,
    pub frame_b: JoltFrame,
    pub limited: bool,
    pub min: f32,
    pub max: f32,
    pub driven: bool,
    pub motor_speed: f32,
    pub motor_torque: f32,
    pub collide_connected: bool,
}

unsafe extern "C" {
    pub fn jolt_world_create(def: *const JoltWorldDef) -> *mut JoltWorld;
    pub fn jolt_world_destroy(world: *mut JoltWorld);
    pub fn jolt_world_step(world: *mut JoltWorld, dt: f32) -> u32;
    pub fn jolt_world_set_gravity(world: *mut JoltWorld, gravity: JoltVec3);

    pub fn jolt_shape_ball(radius: f32) -> *mut JoltShape;
    pub fn jolt_shape_box(half_extents: JoltVec3) -> *mut JoltShape;
    pub fn jolt_shape_capsule(half_height: f32, radius: f32) -> *mut JoltShape;
    pub fn jolt_shape_cylinder(half_height: f32, radius: f32) -> *mut JoltShape;
    pub fn jolt_shape_hull(points: *const JoltVec3, count: usize) -> *mut JoltShape;
    pub fn jolt_shape_placed(shape: *const JoltShape, frame: JoltFrame) -> *mut JoltShape;
    pub fn jolt_shape_compound(shapes: *const *const JoltShape, count: usize) -> *mut JoltShape;
    pub fn jolt_shape_release(shape: *mut JoltShape);

    pub fn jolt_body_create(world: *mut JoltWorld, shape: *const JoltShape, def: *const JoltBodyDef) -> u32;
    pub fn jolt_body_remove(world: *mut JoltWorld, body: u32);
    pub fn jolt_body_frame(world: *const JoltWorld, body: u32) -> JoltFrame;
    pub fn jolt_body_linear_velocity(world: *const JoltWorld, body: u32) -> JoltVec3;
    pub fn jolt_body_angular_velocity(world: *const JoltWorld, body: u32) -> JoltVec3;
    pub fn jolt_body_set_linear_velocity(world: *mut JoltWorld, body: u32, velocity: JoltVec3);
    pub fn jolt_body_add_impulse(world: *mut JoltWorld, body: u32, impulse: JoltVec3);
    pub fn jolt_body_is_active(world: *const JoltWorld, body: u32) -> bool;
    pub fn jolt_body_mass(world: *const JoltWorld, body: u32) -> JoltMass;

    pub fn jolt_joint_create(world: *mut JoltWorld, def: *const JoltJointDef) -> u32;
    pub fn jolt_joint_force(world: *const JoltWorld, joint: u32, force: *mut JoltVec3) -> bool;
}
