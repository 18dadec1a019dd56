//! The host's floating-point settings are set aside while the library computes.
//!
//! A host may flush denormals to zero, round upwards or trap on inexact results. The solver's promise of equal bits holds only
//! under the default settings (round to nearest, no flushing, all exceptions masked), so each entry saves what it finds, sets
//! the default and restores on exit. Callbacks run under the host's settings. Threads that a world starts inherit the default.

use std::cell::Cell;
use std::marker::PhantomData;

use crate::platform::control;

thread_local! {
    /// Settings of the host code that the library was entered from last.
    static HOST: Cell<control::Word> = const { Cell::new(control::DEFAULT) };
}

/// The default settings are in force while this lives.
pub(crate) struct FloatEnvironment {
    found: control::Word,
    outer_host: control::Word,
    this_thread: PhantomData<*const ()>,
}

impl FloatEnvironment {
    pub(crate) fn enter() -> Self {
        let found = control::get();
        control::set(control::DEFAULT);
        Self { found, outer_host: HOST.replace(found), this_thread: PhantomData }
    }
}

impl Drop for FloatEnvironment {
    fn drop(&mut self) {
        HOST.set(self.outer_host);
        control::set(self.found);
    }
}

/// Runs host code under the settings that the host came with, inside a [`FloatEnvironment`].
pub(crate) fn as_host(host_code: impl FnOnce()) {
    let ours = control::get();
    control::set(HOST.get());
    host_code();
    control::set(ours);
}
