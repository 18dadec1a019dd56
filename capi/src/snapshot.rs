//! A whole world into a buffer of the host, and back.

use std::ffi::c_void;

use crate::access::{edit_hosted, read};
use crate::boundary::call;
use crate::handle::LsWorld;
use crate::pointer::{Buffer, host, slice};
use crate::result::LsResult;

/// Writes a whole world into a buffer: bodies, shapes, joints, contacts, sleep, and what the solver carries from step to step.
///
/// About 160 bytes a body, 48 a pair of shapes near each other and 40 a contact point, beside joints and one copy of each
/// distinct geometry. Arrays of the last step and callbacks are not part of it.
/// @param world     the world; any value is safe
/// @param buffer    room for capacity bytes, filled on LS_OK; may be NULL if capacity is 0
/// @param capacity  number of bytes that fit
/// @param size      number of bytes of the snapshot, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_save(world: LsWorld, buffer: *mut c_void, capacity: usize, size: *mut usize) -> LsResult {
    call("ls_world_save", || {
        let buffer = buffer.cast::<u8>();
        let buffer = host!(Buffer::new, buffer, capacity, size);
        read(world, |world| {
            let mut bytes = Vec::new();
            world.save(&mut bytes);
            buffer.fill_bytes(&bytes)
        })
    })
}

/// Makes a world what it was when the snapshot was written: every later step gives the same bits.
///
/// Handles of what existed then are valid again; those of what came later are not. Into another world a snapshot can be restored
/// too: handles then have that world's number in them (ls_world_bodies_get lists them). Arrays of the last step end here;
/// callbacks, threads and what the host's words mean stay as they are.
/// @param world          the world; any value is safe
/// @param snapshot       as ls_world_save wrote it, by the same version of the library
/// @param snapshot_size  its number of bytes
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_SNAPSHOT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_restore(world: LsWorld, snapshot: *const c_void, snapshot_size: usize) -> LsResult {
    call("ls_world_restore", || {
        let snapshot = snapshot.cast::<u8>();
        let bytes = host!(slice, snapshot, snapshot_size);
        edit_hosted(world, |hosted| {
            hosted.world.restore(bytes)?;
            hosted.published.expire();
            Ok(())
        })
    })
}
