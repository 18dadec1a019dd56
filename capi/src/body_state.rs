//! Mass, damping, sleep and contacts of bodies.

use crate::access::{edit, read};
use crate::body_def::{LsMass, LsMassProperties};
use crate::boundary::call;
use crate::enums;
use crate::events::LsContact;
use crate::handle::{LsBody, LsWorld};
use crate::pointer::{self, Buffer, Out, host};
use crate::result::{Failure, LS_ERROR_NOT_APPLICABLE, LsResult};

/// Mass properties of a dynamic body.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (a body without mass),
///         LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_mass_get(world: LsWorld, body: LsBody, out: *mut LsMassProperties) -> LsResult {
    call("ls_body_mass_get", || {
        let out = host!(Out::new, out);
        let without = Failure::Refused(LS_ERROR_NOT_APPLICABLE, "body", "has no mass: it is not dynamic");
        read(world, |world| out.write(world.mass_properties(body.into())?.ok_or(without)?.into()))
    })
}

/// Sets where a dynamic body's mass comes from; its frame stays where it is.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param mass   read during the call
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_mass_set(world: LsWorld, body: LsBody, mass: *const LsMass) -> LsResult {
    call("ls_body_mass_set", || {
        let mass = host!(pointer::read, mass).try_into()?;
        edit(world, |world| world.set_mass(body.into(), mass))
    })
}

/// Rates at which velocities decay.
///
/// @param world    the world; any value is safe
/// @param body     a body of that world; any value is safe
/// @param linear   rate for the linear velocity (1/s), filled on LS_OK
/// @param angular  rate for the angular velocity (1/s), filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_damping_get(world: LsWorld, body: LsBody, linear: *mut f32, angular: *mut f32) -> LsResult {
    call("ls_body_damping_get", || {
        let (linear, angular) = (host!(Out::new, linear), host!(Out::new, angular));
        read(world, |world| {
            let rates = world.damping(body.into())?;
            linear.write(rates.0)?;
            angular.write(rates.1)
        })
    })
}

/// Sets the rates at which velocities decay. That is implicit: a rate k makes v / (1 + k h) of a velocity v in each substep of
/// length h (s), which is v exp(-k t) for small k h, and never turns a velocity around.
///
/// @param world    the world; any value is safe
/// @param body     a body of that world; any value is safe
/// @param linear   rate for the linear velocity (1/s), >= 0
/// @param angular  rate for the angular velocity (1/s), >= 0
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_damping_set(world: LsWorld, body: LsBody, linear: f32, angular: f32) -> LsResult {
    call("ls_body_damping_set", || edit(world, |world| world.set_damping(body.into(), linear, angular)))
}

/// Factor on the world's gravity.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_gravity_scale_get(world: LsWorld, body: LsBody, out: *mut f32) -> LsResult {
    call("ls_body_gravity_scale_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.gravity_scale(body.into())?))
    })
}

/// Sets the factor on the world's gravity.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param scale  any finite number
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_gravity_scale_set(world: LsWorld, body: LsBody, scale: f32) -> LsResult {
    call("ls_body_gravity_scale_set", || edit(world, |world| world.set_gravity_scale(body.into(), scale)))
}

/// Degrees of freedom taken away.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    bit set of LS_LOCK_ constants, filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_locked_axes_get(world: LsWorld, body: LsBody, out: *mut u32) -> LsResult {
    call("ls_body_locked_axes_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(enums::from_locked_axes(world.locked_axes(body.into())?)))
    })
}

/// Sets which degrees of freedom are taken away.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param axes   bit set of LS_LOCK_ constants
/// @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_locked_axes_set(world: LsWorld, body: LsBody, axes: u32) -> LsResult {
    call("ls_body_locked_axes_set", || {
        let axes = enums::locked_axes(axes)?;
        edit(world, |world| world.set_locked_axes(body.into(), axes))
    })
}

/// Whether a body is swept through the step.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    1 if it is, else 0; filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_fast_get(world: LsWorld, body: LsBody, out: *mut u32) -> LsResult {
    call("ls_body_fast_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.is_fast(body.into())?.into()))
    })
}

/// Sets whether a body is swept through the step, so that it cannot tunnel through anything thin.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param fast   not 0: it is
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_fast_set(world: LsWorld, body: LsBody, fast: u32) -> LsResult {
    call("ls_body_fast_set", || edit(world, |world| world.set_fast(body.into(), fast != 0)))
}

/// Whether a body may fall asleep.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    1 if it may, else 0; filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_can_sleep_get(world: LsWorld, body: LsBody, out: *mut u32) -> LsResult {
    call("ls_body_can_sleep_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.can_sleep(body.into())?.into()))
    })
}

/// Sets whether a body may fall asleep; one that may not is woken.
///
/// @param world      the world; any value is safe
/// @param body       a body of that world; any value is safe
/// @param can_sleep  not 0: it may
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_can_sleep_set(world: LsWorld, body: LsBody, can_sleep: u32) -> LsResult {
    call("ls_body_can_sleep_set", || edit(world, |world| world.set_can_sleep(body.into(), can_sleep != 0)))
}

/// Whether a body is awake; static and kinematic ones always are, what is welded to static ones and may sleep never is.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    1 if it is, else 0; filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_awake_get(world: LsWorld, body: LsBody, out: *mut u32) -> LsResult {
    call("ls_body_awake_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.is_awake(body.into())?.into()))
    })
}

/// Wakes a body and everything that fell asleep with it.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_wake(world: LsWorld, body: LsBody) -> LsResult {
    call("ls_body_wake", || edit(world, |world| world.wake(body.into())))
}

/// Puts a dynamic body to sleep with everything it touched or was jointed to in the last step.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_body_sleep(world: LsWorld, body: LsBody) -> LsResult {
    call("ls_body_sleep", || edit(world, |world| world.put_to_sleep(body.into())))
}

/// Net force of all contacts on a body in the last substep (N): of those that there were then, also where what touched it has been
/// destroyed or moved since.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    three floats, filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
/// cbindgen:ptrs-as-arrays=[[out;3]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_contact_force_get(world: LsWorld, body: LsBody, out: *mut f32) -> LsResult {
    call("ls_body_contact_force_get", || {
        let out = host!(Out::three, out);
        read(world, |world| out.write(world.contact_force(body.into())?.to_array()))
    })
}

/// All contacts of a body.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity contacts, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of contacts that fit
/// @param count     number of contacts, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_contacts_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsContact,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_body_contacts_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let contacts: Vec<_> = world.contacts_of(body.into())?.map(LsContact::from).collect();
            buffer.fill(|| contacts.iter().copied())
        })
    })
}
