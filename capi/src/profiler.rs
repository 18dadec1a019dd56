//! A profiler of the host is told where steps are.

use std::ffi::{CStr, c_char, c_void};
use std::sync::Arc;

use ls_core::Profiler;

use crate::access::edit;
use crate::boundary::call;
use crate::float_environment::as_host;
use crate::handle::LsWorld;
use crate::result::LsResult;

/// Told that a zone of a step begins or ends; given to ls_world_profiler_set.
///
/// Zones nest: "longspan step" around one for each stage. Called on the thread that steps, under its own floating-point settings.
/// It must return normally (no exception, no longjmp). The world that steps cannot be used inside it.
/// @param name  UTF-8, lives as long as the library: the same pointer each time
/// @param user  as given to ls_world_profiler_set
pub type LsZoneCallback = Option<unsafe extern "C" fn(name: *const c_char, user: *mut c_void)>;

struct HostProfiler {
    begin: unsafe extern "C" fn(*const c_char, *mut c_void),
    end: unsafe extern "C" fn(*const c_char, *mut c_void),
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back, and the header says on which thread.
unsafe impl Send for HostProfiler {}
// SAFETY: as above.
unsafe impl Sync for HostProfiler {}

impl Profiler for HostProfiler {
    fn begin(&self, zone: &'static CStr) {
        // SAFETY: the host promised a function of this type that accepts its own pointer.
        as_host(|| unsafe { (self.begin)(zone.as_ptr(), self.user) });
    }

    fn end(&self, zone: &'static CStr) {
        // SAFETY: as above.
        as_host(|| unsafe { (self.end)(zone.as_ptr(), self.user) });
    }
}

/// Sets the functions that are told where a world's steps are; at the start there are none. The bits of a step do not depend on
/// them.
///
/// @param world  the world; any value is safe
/// @param begin  told that a zone begins; NULL, as end, for none
/// @param end    told that a zone ends; NULL, as begin, for none
/// @param user   handed back to both; must stay valid until others are set or the world is destroyed
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_profiler_set(
    world: LsWorld,
    begin: LsZoneCallback,
    end: LsZoneCallback,
    user: *mut c_void,
) -> LsResult {
    call("ls_world_profiler_set", || {
        let profiler = begin.zip(end).map(|(begin, end)| Arc::new(HostProfiler { begin, end, user }) as Arc<dyn Profiler>);
        edit(world, |world| {
            world.set_profiler(profiler);
            Ok(())
        })
    })
}
