//! Worlds: create, step, read, destroy.

use ls_core::World;

use crate::access::{destroy, edit, read};
use crate::boundary::call;
use crate::events::LsContact;
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::math::LsPose;
use crate::pointer::{Buffer, Out, OutArray, host, slice, vector};
use crate::registry;
use crate::report::LsStepReport;
use crate::result::LsResult;
use crate::sized::{self, SizedOut};
use crate::world_def::LsWorldDef;

/// Creates an empty world.
///
/// @param def  filled by ls_world_def_init and changed as wanted; read during the call
/// @param out  the world, on LS_OK; the host destroys it with ls_world_destroy
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE, LS_ERROR_UNSUPPORTED, LS_ERROR_CAPACITY_EXCEEDED
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_create(def: *const LsWorldDef, out: *mut LsWorld) -> LsResult {
    call("ls_world_create", || {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        out.write(registry::insert(World::new(&def.try_into()?)?)?)
    })
}

/// Destroys a world with all it holds; its handles and arrays end here. A poisoned world can be destroyed like any other.
///
/// @param world  the world; any value is safe
/// @return LS_OK, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_ALREADY_DESTROYED, LS_ERROR_WORLD_BUSY,
///         LS_ERROR_WORLD_LOCKED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_destroy(world: LsWorld) -> LsResult {
    call("ls_world_destroy", || destroy(world))
}

/// Report of the last step.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_report_get(world: LsWorld, out: *mut LsStepReport, size: usize) -> LsResult {
    call("ls_world_report_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write(&world.report().into()))
    })
}

/// The definition that the world has now: as it was created, with what has been set since, which is gravity, effort, sleep,
/// thresholds of hits and of restitution, whether support is kept up, and all else that has a call to set it.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_def_get(world: LsWorld, out: *mut LsWorldDef, size: usize) -> LsResult {
    call("ls_world_def_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write_definition(&world.def().into()))
    })
}

/// Gravity (m/s^2).
///
/// @param world  the world; any value is safe
/// @param out    three floats, filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[out;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_gravity_get(world: LsWorld, out: *mut f32) -> LsResult {
    call("ls_world_gravity_get", || {
        let out = host!(Out::three, out);
        read(world, |world| out.write(world.gravity().to_array()))
    })
}

/// Sets gravity (m/s^2) and wakes all bodies.
///
/// @param world    the world; any value is safe
/// @param gravity  three finite floats
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[gravity;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_gravity_set(world: LsWorld, gravity: *const f32) -> LsResult {
    call("ls_world_gravity_set", || {
        let gravity = host!(vector, gravity);
        edit(world, |world| world.set_gravity(gravity))
    })
}

/// Simulated time (s): the sum of all steps.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_time_get(world: LsWorld, out: *mut f64) -> LsResult {
    call("ls_world_time_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.time()))
    })
}

/// Number of steps taken.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_step_count_get(world: LsWorld, out: *mut u64) -> LsResult {
    call("ls_world_step_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.step_count()))
    })
}

/// Number of bodies.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_body_count_get(world: LsWorld, out: *mut usize) -> LsResult {
    call("ls_world_body_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.body_count()))
    })
}

/// Number of awake dynamic bodies.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_awake_body_count_get(world: LsWorld, out: *mut usize) -> LsResult {
    call("ls_world_awake_body_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.awake_body_count()))
    })
}

/// Number of shapes.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_shape_count_get(world: LsWorld, out: *mut usize) -> LsResult {
    call("ls_world_shape_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.shape_count()))
    })
}

/// Number of joints.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_joint_count_get(world: LsWorld, out: *mut usize) -> LsResult {
    call("ls_world_joint_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.joint_count()))
    })
}

/// Hash of the poses and velocities of all bodies, bit for bit: equal for equal states, whatever the number of threads.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_state_hash_get(world: LsWorld, out: *mut u64) -> LsResult {
    call("ls_world_state_hash_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.state_hash()))
    })
}

/// All bodies.
///
/// @param world     the world; any value is safe
/// @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of bodies, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_bodies_get(world: LsWorld, out: *mut LsBody, capacity: usize, count: *mut usize) -> LsResult {
    call("ls_world_bodies_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.bodies().map(LsBody::from)))
    })
}

/// All joints.
///
/// @param world     the world; any value is safe
/// @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_joints_get(world: LsWorld, out: *mut LsJoint, capacity: usize, count: *mut usize) -> LsResult {
    call("ls_world_joints_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.joints().map(LsJoint::from)))
    })
}

/// All contacts of awake bodies.
///
/// @param world     the world; any value is safe
/// @param out       room for capacity contacts, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of contacts that fit
/// @param count     number of contacts, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_contacts_get(
    world: LsWorld,
    out: *mut LsContact,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_world_contacts_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.contacts().map(LsContact::from)))
    })
}

/// Poses of many bodies in one call.
///
/// @param world   the world; any value is safe
/// @param bodies  count handles
/// @param count   number of handles; 0 is allowed
/// @param out     room for count poses, filled on LS_OK in the order of the handles; one bad handle, and none is written
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_poses_get(world: LsWorld, bodies: *const LsBody, count: usize, out: *mut LsPose) -> LsResult {
    call("ls_world_poses_get", || {
        let (bodies, out) = (host!(slice, bodies, count), host!(OutArray::new, out, count));
        read(world, |world| {
            bodies.iter().try_for_each(|&body| world.body_kind(body.into()).map(drop))?;
            out.write(bodies.iter().filter_map(|&body| world.pose(body.into()).ok()).map(LsPose::from));
            Ok(())
        })
    })
}
