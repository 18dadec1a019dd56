//! The one way from C into the library and back.
//!
//!     host's float settings aside → catch_unwind → the call's own work → log, message, code → host's float settings back
//!
//! No panic and no unwind crosses: a caught one becomes `LS_ERROR_PANIC`, and the world that was in use is poisoned on the way
//! (see `access`). The message of a failure is stored after the log callback ran, so that a callback's own failures do not
//! replace it.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::float_environment::FloatEnvironment;
use crate::last_error::{self, Message};
use crate::log;
use crate::result::{Failure, LS_OK, LsResult, Outcome};

/// Runs the work of the export named `function`.
pub(crate) fn call(function: &'static str, work: impl FnOnce() -> Outcome<()>) -> LsResult {
    let environment = FloatEnvironment::enter();
    // Unwind safe: whatever a panic leaves half-done is a world, which is poisoned, or a buffer that is refilled before use.
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(Failure::Panicked(describe(payload))));
    let result = match outcome {
        Ok(()) => LS_OK,
        Err(failure) => report(function, &failure),
    };
    drop(environment);
    result
}

fn report(function: &'static str, failure: &Failure) -> LsResult {
    let (level, message) = match failure {
        Failure::Refused(_, argument, problem) => {
            (log::LS_LOG_WARNING, Message::new(format_args!("{function}: {argument}: {problem}")))
        }
        Failure::Described(_, what) => (log::LS_LOG_WARNING, Message::new(format_args!("{function}: {what}"))),
        Failure::Panicked(what) => {
            (log::LS_LOG_ERROR, Message::new(format_args!("{function}: the library failed inside this call: {what}")))
        }
    };
    log::emit(level, &message);
    log::abort_if_told(level);
    last_error::set(message);
    failure.code()
}

fn describe(payload: Box<dyn Any + Send>) -> String {
    let text = match (payload.downcast_ref::<&str>(), payload.downcast_ref::<String>()) {
        (Some(text), _) => (*text).to_owned(),
        (_, Some(text)) => text.clone(),
        _ => "no message".to_owned(),
    };
    // A payload whose drop panics would unwind into C.
    std::mem::forget(payload);
    text
}
