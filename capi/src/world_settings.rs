//! Changing what a live world was created with.

use crate::access::edit;
use crate::boundary::call;
use crate::handle::LsWorld;
use crate::pointer::{self, host};
use crate::result::LsResult;
use crate::world_def::{LsArticulationSettings, LsSleepSettings};

/// Sets how much work a step does, from the next step on.
///
/// @param world       the world; any value is safe
/// @param substeps    substeps a step, 1 to 256
/// @param iterations  sweeps a substep, 1 to 256
/// @return LS_OK, a world error, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_effort_set(world: LsWorld, substeps: u32, iterations: u32) -> LsResult {
    call("ls_world_effort_set", || edit(world, |world| world.set_effort(substeps, iterations)))
}

/// Sets how much work articulations may take, from the next step on.
///
/// @param world     the world; any value is safe
/// @param settings  read during the call
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_articulation_settings_set(world: LsWorld, settings: *const LsArticulationSettings) -> LsResult {
    call("ls_world_articulation_settings_set", || {
        let settings = host!(pointer::read, settings);
        edit(world, |world| world.set_articulation_settings(settings.into()))
    })
}

/// Sets when bodies fall asleep; if they no longer may, all wake.
///
/// @param world     the world; any value is safe
/// @param settings  read during the call; speeds (m/s, rad/s) and time (s), each >= 0
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_sleep_settings_set(world: LsWorld, settings: *const LsSleepSettings) -> LsResult {
    call("ls_world_sleep_settings_set", || {
        let settings = host!(pointer::read, settings);
        edit(world, |world| world.set_sleep_settings(settings.into()))
    })
}

/// Sets the approach speed above which contacts are listed by ls_world_hits_get.
///
/// @param world  the world; any value is safe
/// @param speed  (m/s), >= 0; INFINITY for never
/// @return LS_OK, a world error, LS_ERROR_NOT_FINITE (NaN), LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_hit_threshold_set(world: LsWorld, speed: f32) -> LsResult {
    call("ls_world_hit_threshold_set", || edit(world, |world| world.set_hit_threshold(speed)))
}

/// Sets the approach speed below which nothing bounces.
///
/// @param world  the world; any value is safe
/// @param speed  (m/s), >= 0
/// @return LS_OK, a world error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_restitution_threshold_set(world: LsWorld, speed: f32) -> LsResult {
    call("ls_world_restitution_threshold_set", || edit(world, |world| world.set_restitution_threshold(speed)))
}
