//! Where bodies are, how they move, and what pushes them.

use crate::access::{edit, read};
use crate::boundary::call;
use crate::handle::{LsBody, LsWorld};
use crate::math::LsPose;
use crate::pointer::{self, Out, host, vector};
use crate::result::LsResult;

/// Frame of a body in the world.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_pose_get(world: LsWorld, body: LsBody, out: *mut LsPose) -> LsResult {
    call("ls_body_pose_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.pose(body.into())?.into()))
    })
}

/// Puts a body somewhere else at once and wakes it and what it touched; velocities stay. To move a kinematic body so that it
/// pushes, use ls_body_move_to.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param pose   its new frame
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_pose_set(world: LsWorld, body: LsBody, pose: *const LsPose) -> LsResult {
    call("ls_body_pose_set", || {
        let pose = host!(pointer::read, pose);
        edit(world, |world| world.set_pose(body.into(), pose.into()))
    })
}

/// Says where a kinematic body shall be at the end of the next step; it moves there with the velocity that takes, and then
/// stands still unless it is told again. A velocity or a pose that it is given before that step ends this: the last call counts.
///
/// @param world   the world; any value is safe
/// @param body    a body of that world; any value is safe
/// @param target  its frame at the end of the next step
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_move_to(world: LsWorld, body: LsBody, target: *const LsPose) -> LsResult {
    call("ls_body_move_to", || {
        let target = host!(pointer::read, target);
        edit(world, |world| world.move_to(body.into(), target.into()))
    })
}

/// Centre of mass of a body in the world (m).
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    three doubles, filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[out;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_center_of_mass_get(world: LsWorld, body: LsBody, out: *mut f64) -> LsResult {
    call("ls_body_center_of_mass_get", || {
        let out = host!(Out::three, out);
        read(world, |world| out.write(world.center_of_mass(body.into())?.to_array()))
    })
}

/// Velocity of a body's centre of mass (m/s).
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    three floats, filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[out;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_linear_velocity_get(world: LsWorld, body: LsBody, out: *mut f32) -> LsResult {
    call("ls_body_linear_velocity_get", || {
        let out = host!(Out::three, out);
        read(world, |world| out.write(world.linear_velocity(body.into())?.to_array()))
    })
}

/// Sets the velocity of a body's centre of mass (m/s). A kinematic body forgets where ls_body_move_to was to take it in the next step.
///
/// @param world            the world; any value is safe
/// @param body             a body of that world; any value is safe
/// @param linear_velocity  three floats (m/s), together at most 1e4
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[linear_velocity;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_linear_velocity_set(world: LsWorld, body: LsBody, linear_velocity: *const f32) -> LsResult {
    call("ls_body_linear_velocity_set", || {
        let linear_velocity = host!(vector, linear_velocity);
        edit(world, |world| world.set_linear_velocity(body.into(), linear_velocity))
    })
}

/// Angular velocity of a body, world axes (rad/s).
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    three floats, filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[out;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_angular_velocity_get(world: LsWorld, body: LsBody, out: *mut f32) -> LsResult {
    call("ls_body_angular_velocity_get", || {
        let out = host!(Out::three, out);
        read(world, |world| out.write(world.angular_velocity(body.into())?.to_array()))
    })
}

/// Sets the angular velocity of a body, world axes (rad/s). A kinematic body forgets where ls_body_move_to was to take it in the next step.
///
/// @param world             the world; any value is safe
/// @param body              a body of that world; any value is safe
/// @param angular_velocity  three floats (rad/s), together at most 1e4
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[angular_velocity;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_angular_velocity_set(world: LsWorld, body: LsBody, angular_velocity: *const f32) -> LsResult {
    call("ls_body_angular_velocity_set", || {
        let angular_velocity = host!(vector, angular_velocity);
        edit(world, |world| world.set_angular_velocity(body.into(), angular_velocity))
    })
}

/// Adds a force at a dynamic body's centre of mass, for the next step.
///
/// The step changes its velocity by force · step / mass. What touches nothing and has no joints is moved by the velocity at
/// the step's end, gravity included (symplectic Euler), and so is, as a whole, what touches or is jointed only among itself:
/// springs, orbits, magnets and buoyancy that are worked out of the poses before each step keep their energy, and a constant
/// thrust is half a step ahead of its parabola. On what touches or is jointed to something fixed the force is spread over the
/// step.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param force  three floats (N)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[force;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_force_add(world: LsWorld, body: LsBody, force: *const f32) -> LsResult {
    call("ls_body_force_add", || {
        let force = host!(vector, force);
        edit(world, |world| world.add_force(body.into(), force))
    })
}

/// Adds a force at a point of a dynamic body, for the next step.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param force  three floats (N)
/// @param point  three doubles: where it acts, in the world (m)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[force;3]; [point;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_force_add_at(world: LsWorld, body: LsBody, force: *const f32, point: *const f64) -> LsResult {
    call("ls_body_force_add_at", || {
        let (force, point) = (host!(vector, force), host!(pointer::point, point));
        edit(world, |world| world.add_force_at(body.into(), force, point))
    })
}

/// Adds a torque to a dynamic body, world axes, for the next step.
///
/// @param world   the world; any value is safe
/// @param body    a body of that world; any value is safe
/// @param torque  three floats (N m)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[torque;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_torque_add(world: LsWorld, body: LsBody, torque: *const f32) -> LsResult {
    call("ls_body_torque_add", || {
        let torque = host!(vector, torque);
        edit(world, |world| world.add_torque(body.into(), torque))
    })
}

/// Adds an impulse at a dynamic body's centre of mass, at once.
///
/// @param world    the world; any value is safe
/// @param body     a body of that world; any value is safe
/// @param impulse  three floats (N s)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE (beyond 1e4 m/s or rad/s)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[impulse;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_impulse_add(world: LsWorld, body: LsBody, impulse: *const f32) -> LsResult {
    call("ls_body_impulse_add", || {
        let impulse = host!(vector, impulse);
        edit(world, |world| world.add_impulse(body.into(), impulse))
    })
}

/// Adds an impulse at a point of a dynamic body, at once.
///
/// @param world    the world; any value is safe
/// @param body     a body of that world; any value is safe
/// @param impulse  three floats (N s)
/// @param point    three doubles: where it acts, in the world (m)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[impulse;3]; [point;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_impulse_add_at(
    world: LsWorld,
    body: LsBody,
    impulse: *const f32,
    point: *const f64,
) -> LsResult {
    call("ls_body_impulse_add_at", || {
        let (impulse, point) = (host!(vector, impulse), host!(pointer::point, point));
        edit(world, |world| world.add_impulse_at(body.into(), impulse, point))
    })
}

/// Adds an angular impulse to a dynamic body, world axes, at once.
///
/// @param world    the world; any value is safe
/// @param body     a body of that world; any value is safe
/// @param impulse  three floats (N m s)
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE (beyond 1e4 m/s or rad/s)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[impulse;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_angular_impulse_add(world: LsWorld, body: LsBody, impulse: *const f32) -> LsResult {
    call("ls_body_angular_impulse_add", || {
        let impulse = host!(vector, impulse);
        edit(world, |world| world.add_angular_impulse(body.into(), impulse))
    })
}
