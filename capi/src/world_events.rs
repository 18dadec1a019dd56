//! The step, and what it tells: arrays to read until the next one, and callbacks.

use std::ffi::c_void;

use crate::access::{Hosted, edit_hosted, edit_then_call_back, read_hosted};
use crate::boundary::call;
use crate::events::{LsArticulation, LsContactPair, LsHit, LsIsland, LsJointOverload, LsJointStop, LsMoved};
use crate::float_environment::as_host;
use crate::handle::{LsBody, LsWorld};
use crate::last_error::Message;
use crate::log;
use crate::pointer::{Out, host};
use crate::result::{LsResult, Outcome};

/// Receives the joints that a step overloaded, one call each, in the order of ls_world_overloaded_joints_get.
///
/// Called after the solve on the thread that steps, under its own floating-point settings. It must return normally (no
/// exception, no longjmp). Inside it, reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
/// @param world     the world that steps
/// @param overload  the joint and its load, valid during the call
/// @param user      as given to ls_world_overload_callback_set
pub type LsOverloadCallback = Option<unsafe extern "C" fn(world: LsWorld, overload: *const LsJointOverload, user: *mut c_void)>;

pub(crate) struct OverloadHandler {
    callback: unsafe extern "C" fn(LsWorld, *const LsJointOverload, *mut c_void),
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back, and the header says that this happens on the thread that steps.
unsafe impl Send for OverloadHandler {}
// SAFETY: as above.
unsafe impl Sync for OverloadHandler {}

/// Steps a world by dt, then calls its callbacks.
///
/// A body that the step would have given a state that is NaN or infinite, or a position more than 1e9 m from the origin, is quarantined
/// (ls_world_quarantined_bodies_get); the rest goes on.
/// @param world  the world; any value is safe
/// @param dt     step (s), 1e-6 to 1; the same each time gives the best results, 1/60 is usual
/// @return LS_OK, a world error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_PANIC
/// Threads: edit; reads become possible while the callbacks run. Callbacks: LS_ERROR_WORLD_LOCKED; another world may be stepped.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_step(world: LsWorld, dt: f32) -> LsResult {
    call("ls_world_step", || {
        let step = |hosted: &mut Hosted| {
            hosted.world.step(dt)?;
            hosted.published.expire();
            #[cfg(streams)]
            hosted.streams.publish(&hosted.world);
            Ok(())
        };
        edit_then_call_back(world, step, |hosted| call_back(world, hosted))
    })
}

fn call_back(world: LsWorld, hosted: &Hosted) {
    for &body in hosted.world.quarantined() {
        let id = LsBody::from(body).id;
        let message = Message::new(format_args!("ls_world_step: body {id:#x} is no longer finite and was quarantined"));
        log::emit(log::LS_LOG_WARNING, &message);
    }
    crate::fracture::call_back(world, hosted);
    hosted.callbacks.run(world, hosted);
    if let Some(OverloadHandler { callback, user }) = hosted.overload_handler {
        for overload in hosted.world.overloaded().iter().map(LsJointOverload::from) {
            // SAFETY: the host promised a function of this type that accepts its own pointer.
            as_host(|| unsafe { callback(world, &raw const overload, user) });
        }
    }
}

/// Sets the function that receives overloaded joints; at the start there is none.
///
/// @param world     the world; any value is safe
/// @param callback  called by ls_world_step; NULL for none
/// @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_overload_callback_set(
    world: LsWorld,
    callback: LsOverloadCallback,
    user: *mut c_void,
) -> LsResult {
    call("ls_world_overload_callback_set", || {
        edit_hosted(world, |hosted| {
            hosted.overload_handler = callback.map(|callback| OverloadHandler { callback, user });
            Ok(())
        })
    })
}

/// Bodies that moved in the last step, with their poses and velocities, those that fell asleep at its end included.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_moved_bodies_get(world: LsWorld, out: *mut *const LsMoved, count: *mut usize) -> LsResult {
    call("ls_world_moved_bodies_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::moved)
    })
}

/// How each articulation was solved in the last step: bodies that joints connect and that are solved at once. Islands that sleep
/// or are held, and joints that are left to sweeps alone, are not among them.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_articulations_get(
    world: LsWorld,
    out: *mut *const LsArticulation,
    count: *mut usize,
) -> LsResult {
    call("ls_world_articulations_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| {
            hosted.published.articulations.get(hosted.world.articulations().iter().map(LsArticulation::from))
        })
    })
}

/// How each island with joints was solved in the last step, and why. Islands that sleep or are held, and those without joints, whose
/// contacts are swept, are not among them.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_islands_get(world: LsWorld, out: *mut *const LsIsland, count: *mut usize) -> LsResult {
    call("ls_world_islands_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, |hosted| hosted.published.islands.get(hosted.world.islands().iter().map(LsIsland::from)))
    })
}

/// Pairs of shapes that began to press on each other in the last step: a force acts between them at its end, they have rebounded in
/// it, or their hit is told. Shapes that touch or overlap while nothing presses them together are not among them, nor those that met
/// slower than hit_threshold and press no more at the end of the step; ls_body_contacts_get lists both.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_contacts_begun_get(
    world: LsWorld,
    out: *mut *const LsContactPair,
    count: *mut usize,
) -> LsResult {
    call("ls_world_contacts_begun_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::contact_began)
    })
}

/// Pairs of shapes that ceased to press on each other in the last step.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_contacts_ended_get(
    world: LsWorld,
    out: *mut *const LsContactPair,
    count: *mut usize,
) -> LsResult {
    call("ls_world_contacts_ended_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::contact_ended)
    })
}

/// Joints that carried more than their break_force or break_torque in the last step. They are reported, not removed.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_overloaded_joints_get(
    world: LsWorld,
    out: *mut *const LsJointOverload,
    count: *mut usize,
) -> LsResult {
    call("ls_world_overloaded_joints_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::overloaded)
    })
}

/// Bodies that the last step would have given a state that is NaN or infinite, or a position more than 1e9 m from the origin. They
/// stay where they were, without contacts, until the host gives them a pose or velocity.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_quarantined_bodies_get(world: LsWorld, out: *mut *const LsBody, count: *mut usize) -> LsResult {
    call("ls_world_quarantined_bodies_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::quarantined)
    })
}

/// Contacts of the last step whose shapes met faster than the world's hit_threshold, with the impulse.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_hits_get(world: LsWorld, out: *mut *const LsHit, count: *mut usize) -> LsResult {
    call("ls_world_hits_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::hits)
    })
}

/// Joints that came to a stop of theirs in the last step: a limit that did not press before it presses now.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_joint_stops_get(world: LsWorld, out: *mut *const LsJointStop, count: *mut usize) -> LsResult {
    call("ls_world_joint_stops_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::joint_stops)
    })
}

/// Shapes that began to overlap a sensor in the last step; of each pair, the sensor comes first.
///
/// A sensor sees, at the end of each step, every shape of another body that its filter accepts and that is no sensor itself, unless
/// both bodies are static.
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_sensor_overlaps_begun_get(
    world: LsWorld,
    out: *mut *const LsContactPair,
    count: *mut usize,
) -> LsResult {
    call("ls_world_sensor_overlaps_begun_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::sensor_began)
    })
}

/// Shapes that ceased to overlap a sensor in the last step, or of which either was destroyed since the step before it; of each
/// pair, the sensor comes first.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_sensor_overlaps_ended_get(
    world: LsWorld,
    out: *mut *const LsContactPair,
    count: *mut usize,
) -> LsResult {
    call("ls_world_sensor_overlaps_ended_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::sensor_ended)
    })
}

/// Everything that overlapped a sensor at the end of the last step; of each pair, the sensor comes first.
///
/// @param world  the world; any value is safe
/// @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
///               destruction, edits leave it as it is; do not follow it if the count is 0
/// @param count  number of elements
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_sensor_overlaps_get(
    world: LsWorld,
    out: *mut *const LsContactPair,
    count: *mut usize,
) -> LsResult {
    call("ls_world_sensor_overlaps_get", || {
        let (out, count) = (host!(Out::new, out), host!(Out::new, count));
        publish(world, &out, &count, Hosted::sensed)
    })
}

pub(crate) fn publish<T>(
    world: LsWorld,
    out: &Out<*const T>,
    count: &Out<usize>,
    array: impl FnOnce(&Hosted) -> (*const T, usize),
) -> Outcome<()> {
    read_hosted(world, |hosted| {
        let (elements, len) = array(hosted);
        out.write(elements)?;
        count.write(len)
    })
}
