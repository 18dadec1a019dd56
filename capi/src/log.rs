//! What the library has to say besides its results, handed to the host.

use std::cell::Cell;
use std::ffi::{c_char, c_void};
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::boundary::call;
use crate::enums;
use crate::float_environment::as_host;
use crate::last_error::Message;
use crate::result::LsResult;

/// Log level: nothing.
pub const LS_LOG_OFF: i32 = 0;
/// Log level: the library itself failed; a world is poisoned.
pub const LS_LOG_ERROR: i32 = 1;
/// Log level: a call was refused, or a body was quarantined.
pub const LS_LOG_WARNING: i32 = 2;

/// Receives log messages.
///
/// Called on the thread whose call has something to say, under the host's floating-point settings. It must return normally
/// (no exception, no longjmp). Inside it, reads work if the world allows them, edits of any world return
/// LS_ERROR_WORLD_LOCKED, and what those calls have to say is not logged.
/// @param level    LS_LOG_ERROR or LS_LOG_WARNING
/// @param message  UTF-8, valid during the call
/// @param user     as given to ls_log_callback_set
pub type LsLogCallback = Option<unsafe extern "C" fn(level: i32, message: *const c_char, user: *mut c_void)>;

struct Handler {
    callback: unsafe extern "C" fn(i32, *const c_char, *mut c_void),
    user: *mut c_void,
    level: i32,
}

// SAFETY: the pointer is only handed back, and the header says that this happens on any thread that calls the library.
unsafe impl Send for Handler {}

/// Messages up to this level end the process.
static ABORT_LEVEL: AtomicI32 = AtomicI32::new(LS_LOG_OFF);

static HANDLER: Mutex<Option<Handler>> = Mutex::new(None);

thread_local! {
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is inside a log callback.
pub(crate) fn inside_callback() -> bool {
    INSIDE.get()
}

/// Hands a message to the host; to be called while no world is held for editing.
pub(crate) fn emit(level: i32, message: &Message) {
    if inside_callback() {
        return;
    }
    let handler = HANDLER.lock().unwrap_or_else(PoisonError::into_inner);
    let Some((callback, user)) = handler.as_ref().filter(|handler| level <= handler.level).map(|h| (h.callback, h.user)) else {
        return;
    };
    // The callback may set another callback.
    drop(handler);
    INSIDE.set(true);
    // SAFETY: the host promised a function of this type that accepts its own pointer.
    as_host(|| unsafe { callback(level, message.as_ptr(), user) });
    INSIDE.set(false);
}

/// Ends the process if a message of this level is one that the host does not want to live on with; after it was logged.
pub(crate) fn abort_if_told(level: i32) {
    if level <= ABORT_LEVEL.load(Ordering::Relaxed) {
        std::process::abort();
    }
}

/// Sets whether a mistake ends the process (abort) where it happens, after it was logged, so that a debugger stops there.
///
/// @param level  LS_LOG_OFF, the default: never; LS_LOG_ERROR: when the library itself fails; LS_LOG_WARNING: also when a call is
///               refused
/// @return LS_OK, LS_ERROR_INVALID_ENUM
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub extern "C" fn ls_abort_level_set(level: i32) -> LsResult {
    call("ls_abort_level_set", || {
        ABORT_LEVEL.store(enums::log_level(level)?, Ordering::Relaxed);
        Ok(())
    })
}

/// Sets the function that receives log messages of all worlds; at the start there is none.
///
/// @param callback  called on any thread that calls the library; NULL for none
/// @param level     LS_LOG_OFF, LS_LOG_ERROR or LS_LOG_WARNING: the least important level to be handed over
/// @param user      handed back to the callback; a call that is under way on another thread may still use the old one
/// @return LS_OK, LS_ERROR_INVALID_ENUM
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_log_callback_set(callback: LsLogCallback, level: i32, user: *mut c_void) -> LsResult {
    call("ls_log_callback_set", || {
        let level = enums::log_level(level)?;
        let handler = callback.map(|callback| Handler { callback, user, level });
        *HANDLER.lock().unwrap_or_else(PoisonError::into_inner) = handler;
        Ok(())
    })
}
