//! The events of a step through callbacks, in one struct.

use std::ffi::c_void;

use crate::access::{Hosted, edit_hosted};
use crate::boundary::call;
use crate::events::{LsContactPair, LsHit, LsJointStop, LsMoved};
use crate::float_environment::as_host;
use crate::handle::LsWorld;
use crate::pointer::host;
use crate::result::LsResult;
use crate::sized::{self, Definition, SizedOut, Versioned};

/// Receives pairs of shapes of a step; given in an LsCallbacks.
///
/// Each callback of an LsCallbacks is called once a step, if there is anything to tell, after the solve on the thread that steps,
/// under its own floating-point settings, in the order in which they stand in the struct. They must return normally (no exception,
/// no longjmp). Inside them reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
/// @param world  the world that steps
/// @param pairs  count pairs: the array of the function of the same name, valid as long as that
/// @param count  number of pairs, > 0
/// @param user   as given in the LsCallbacks
pub type LsPairsCallback =
    Option<unsafe extern "C" fn(world: LsWorld, pairs: *const LsContactPair, count: usize, user: *mut c_void)>;

/// Receives the hits of a step; given in an LsCallbacks, see LsPairsCallback.
/// @param world  the world that steps
/// @param hits   count hits: the array of ls_world_hits_get
/// @param count  number of hits, > 0
/// @param user   as given in the LsCallbacks
pub type LsHitsCallback = Option<unsafe extern "C" fn(world: LsWorld, hits: *const LsHit, count: usize, user: *mut c_void)>;

/// Receives the joints that came to a stop in a step; given in an LsCallbacks, see LsPairsCallback.
/// @param world  the world that steps
/// @param stops  count joints: the array of ls_world_joint_stops_get
/// @param count  number of joints, > 0
/// @param user   as given in the LsCallbacks
pub type LsJointStopsCallback =
    Option<unsafe extern "C" fn(world: LsWorld, stops: *const LsJointStop, count: usize, user: *mut c_void)>;

/// Receives the bodies that moved in a step; given in an LsCallbacks, see LsPairsCallback.
/// @param world  the world that steps
/// @param moved  count bodies: the array of ls_world_moved_bodies_get
/// @param count  number of bodies, > 0
/// @param user   as given in the LsCallbacks
pub type LsMovedCallback = Option<unsafe extern "C" fn(world: LsWorld, moved: *const LsMoved, count: usize, user: *mut c_void)>;

/// Who is told what a step did. Fill it with ls_callbacks_init first.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsCallbacks {
    /// Size of this struct in the host, set by ls_callbacks_init.
    pub struct_size: u32,
    /// Not used; 0.
    pub reserved: u32,
    /// Handed back to all callbacks; default NULL.
    pub user: *mut c_void,
    /// Receives contacts that began; NULL, the default, for none.
    pub contact_began: LsPairsCallback,
    /// Receives contacts that ended; default NULL.
    pub contact_ended: LsPairsCallback,
    /// Receives hits; default NULL.
    pub hits: LsHitsCallback,
    /// Receives shapes that began to overlap sensors; default NULL.
    pub sensor_began: LsPairsCallback,
    /// Receives shapes that ceased to overlap sensors; default NULL.
    pub sensor_ended: LsPairsCallback,
    /// Receives joints that came to a stop; default NULL.
    pub joint_stops: LsJointStopsCallback,
    /// Receives bodies that moved; default NULL.
    pub moved: LsMovedCallback,
}

// SAFETY: numbers and pointers without padding.
unsafe impl Versioned for LsCallbacks {
    const SIZES: &'static [usize] = &[size_of::<Self>()];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsCallbacks {}

// SAFETY: the pointer is only handed back, and the header says on which thread.
unsafe impl Send for LsCallbacks {}
// SAFETY: as above.
unsafe impl Sync for LsCallbacks {}

impl Default for LsCallbacks {
    fn default() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            user: std::ptr::null_mut(),
            contact_began: None,
            contact_ended: None,
            hits: None,
            sensor_began: None,
            sensor_ended: None,
            joint_stops: None,
            moved: None,
        }
    }
}

impl LsCallbacks {
    /// Tells the host what the step did.
    pub(crate) fn run(&self, world: LsWorld, hosted: &Hosted) {
        macro_rules! tell {
            ($($event:ident),*) => {$(
                if let Some(callback) = self.$event {
                    let (elements, count) = hosted.$event();
                    if count > 0 {
                        // SAFETY: the host promised a function of this type that accepts its own pointer.
                        as_host(|| unsafe { callback(world, elements, count, self.user) });
                    }
                }
            )*};
        }
        tell!(contact_began, contact_ended, hits, sensor_began, sensor_ended, joint_stops, moved);
    }
}

/// Fills a set of callbacks with none.
///
/// @param callbacks  filled on LS_OK
/// @param size       sizeof *callbacks as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_callbacks_init(callbacks: *mut LsCallbacks, size: usize) -> LsResult {
    call("ls_callbacks_init", || host!(SizedOut::new, callbacks, size).write_definition(&LsCallbacks::default()))
}

/// Sets who is told what each step did; at the start nobody is. The arrays that tell the same are there anyway.
///
/// @param world      the world; any value is safe
/// @param callbacks  filled by ls_callbacks_init and changed as wanted; read during the call
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_callbacks_set(world: LsWorld, callbacks: *const LsCallbacks) -> LsResult {
    call("ls_world_callbacks_set", || {
        let callbacks = host!(sized::read, callbacks);
        edit_hosted(world, |hosted| {
            hosted.callbacks = callbacks;
            Ok(())
        })
    })
}
