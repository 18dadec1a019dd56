//! Recordings: every call that changes a world, written down, and played again.

use std::ffi::{CStr, c_char, c_void};
use std::fs::File;

use ls_core::{RecordingSink, Replay, Replayed};

use crate::access::{edit, edit_hosted};
use crate::boundary::call;
use crate::enums;
use crate::float_environment::as_host;
use crate::handle::LsWorld;
use crate::pointer::{host, null, slice};
use crate::registry;
use crate::result::{Failure, LS_ERROR_OTHER, LsResult, Outcome};
use crate::sized::{SizedOut, Versioned};

/// Recording: the hash of the world's state follows every call, not steps only. Finds the very call that first differs; costs as
/// much as reading all bodies, for each call.
pub const LS_RECORD_HASH_EVERY_CALL: u32 = 1;

/// Takes the next bytes of a recording; given to ls_world_recording_start.
///
/// Called on the thread whose call is recorded, under its own floating-point settings, while the world is held: inside it every
/// call with that world returns LS_ERROR_WORLD_BUSY. It must return normally (no exception, no longjmp).
/// @param data  valid during the call
/// @param size  number of bytes
/// @param user  as given to ls_world_recording_start
/// @return 0; anything else ends the recording
pub type LsRecordCallback = Option<unsafe extern "C" fn(data: *const c_void, size: usize, user: *mut c_void) -> i32>;

/// What a replay has done. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsReplay {
    /// Calls read, those included that had been refused.
    pub calls: u64,
    /// Calls that had been refused; they changed nothing and are not made again.
    pub refused: u64,
    /// Steps taken.
    pub steps: u64,
    /// 1 if something came out otherwise than recorded: nothing was played after that. Else 0, and so are the fields of it below.
    pub diverged: u32,
    /// 1 if the recording ends in the middle of a call, as after a crash; else 0.
    pub cut_short: u32,
    /// Number of the call that differs, from 0.
    pub call: u64,
    /// Steps taken when it was made, itself included.
    pub step: u64,
    /// What was recorded: the hash of the state, or what the call returned.
    pub recorded: u64,
    /// What came out now.
    pub found: u64,
    /// 1 if the two are hashes of the state, 0 if they are what the call returned.
    pub in_state: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Name of the call that differs, without "ls_", in words of the library; ends with a zero.
    pub method: [c_char; 40],
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsReplay {
    const SIZES: &'static [usize] = &[112];
}

impl Default for LsReplay {
    fn default() -> Self {
        (&Replayed::default()).into()
    }
}

impl From<&Replayed> for LsReplay {
    fn from(done: &Replayed) -> Self {
        let mut report = Self {
            calls: done.calls,
            refused: done.refused,
            steps: done.steps,
            diverged: done.divergence.is_some().into(),
            cut_short: done.cut_short.into(),
            call: 0,
            step: 0,
            recorded: 0,
            found: 0,
            in_state: 0,
            reserved: 0,
            method: [0; 40],
        };
        if let Some(divergence) = &done.divergence {
            (report.call, report.step) = (divergence.call, divergence.step);
            (report.recorded, report.found) = (divergence.recorded, divergence.found);
            report.in_state = divergence.in_state.into();
            for (c, byte) in report.method[..39].iter_mut().zip(divergence.method.bytes()) {
                *c = byte as c_char;
            }
        }
        report
    }
}

struct Sink {
    callback: unsafe extern "C" fn(*const c_void, usize, *mut c_void) -> i32,
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back, and the header says on which threads.
unsafe impl Send for Sink {}
// SAFETY: as above.
unsafe impl Sync for Sink {}

impl RecordingSink for Sink {
    fn write(&mut self, data: &[u8]) -> bool {
        let mut answer = 0;
        // SAFETY: the host promised a function of this type that accepts its own pointer.
        as_host(|| answer = unsafe { (self.callback)(data.as_ptr().cast(), data.len(), self.user) });
        answer == 0
    }
}

fn hash_every_call(flags: u32) -> Outcome<bool> {
    if flags & !LS_RECORD_HASH_EVERY_CALL != 0 {
        return Err(enums::unknown("flags"));
    }
    Ok(flags & LS_RECORD_HASH_EVERY_CALL != 0)
}

/// Begins to record: the world as it is now, and from then on every call that changes it, with the hash of its state after each
/// step. A recording of this world that is under way ends.
///
/// Calls that are refused are listed. What does not reach the state is not: reads, threads and job systems, callbacks.
/// @param world     the world; any value is safe
/// @param callback  takes the bytes, in order; not NULL
/// @param flags     0 or LS_RECORD_HASH_EVERY_CALL
/// @param user      handed back to the callback; must stay valid until the recording ends or the world is destroyed
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM, LS_ERROR_UNSUPPORTED (the callback refused)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_recording_start(
    world: LsWorld,
    callback: LsRecordCallback,
    flags: u32,
    user: *mut c_void,
) -> LsResult {
    call("ls_world_recording_start", || {
        let callback = callback.ok_or_else(|| null("callback"))?;
        let hashed = hash_every_call(flags)?;
        edit(world, |world| world.record(Box::new(Sink { callback, user }), hashed))
    })
}

/// As ls_world_recording_start, into a file: what was there before is gone.
///
/// Each call is written when it is made, so that the file of a program that crashed holds all calls but the one that crashed.
/// @param world  the world; any value is safe
/// @param path   name of the file, UTF-8, ends with a zero
/// @param flags  0 or LS_RECORD_HASH_EVERY_CALL
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM, LS_ERROR_UNSUPPORTED (the file took nothing),
///         LS_ERROR_OTHER (the file cannot be made)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_recording_start_to_file(world: LsWorld, path: *const c_char, flags: u32) -> LsResult {
    call("ls_world_recording_start_to_file", || {
        if path.is_null() {
            return Err(null("path"));
        }
        // SAFETY: the header asks the host for a string that ends with a zero.
        let path = unsafe { CStr::from_ptr(path) };
        let hashed = hash_every_call(flags)?;
        let cannot = || Failure::Refused(LS_ERROR_OTHER, "path", "is not that of a file that can be made");
        let path = path.to_str().map_err(|_| cannot())?;
        // Only once the world has been found and may be changed: making the file empties one that is there.
        edit_hosted(world, |hosted| {
            let file = File::create(path).map_err(|_| cannot())?;
            Ok(hosted.world.record(Box::new(file), hashed)?)
        })
    })
}

/// Ends the recording of a world.
///
/// @param world  the world; any value is safe
/// @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (it is not recorded), LS_ERROR_UNSUPPORTED (the file or callback has
///         refused a part of the recording, which ended there)
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_world_recording_stop(world: LsWorld) -> LsResult {
    call("ls_world_recording_stop", || edit(world, |world| world.stop_recording()))
}

/// Plays a recording in a world of its own, to its end or to the first call that comes out otherwise than recorded.
///
/// A difference is no failure of this call: the report names it. The same version of the library, on any machine, gives none.
/// @param recording       the bytes, as they were written
/// @param recording_size  number of bytes
/// @param most_steps      after so many steps the replay stops; UINT64_MAX for all
/// @param out             the world as the replay left it, on LS_OK, for the host to look at, go on with and destroy; may be NULL
/// @param report          what was done, filled on LS_OK
/// @param size            sizeof *report as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_SNAPSHOT (the bytes are not a recording of this
///         version, or a call in it makes no sense), LS_ERROR_CAPACITY_EXCEEDED
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_recording_replay(
    recording: *const c_void,
    recording_size: usize,
    most_steps: u64,
    out: *mut LsWorld,
    report: *mut LsReplay,
    size: usize,
) -> LsResult {
    call("ls_recording_replay", || {
        let report = host!(SizedOut::new, report, size);
        let recording = recording.cast::<u8>();
        let recording: &[u8] = host!(slice, recording, recording_size);
        let mut replay = Replay::new(recording)?;
        let done = replay.run(most_steps)?;
        if !out.is_null() {
            let world = registry::insert(replay.into_world())?;
            // SAFETY: the header asks the host for NULL or room for a handle.
            unsafe { out.write_unaligned(world) };
        }
        report.write(&(&done).into())
    })
}
