//! The host's floating-point settings are set aside while the library computes.
//!
//! A host may flush denormals to zero, round upwards or trap on inexact results. The solver's promise of equal bits holds only
//! under the default settings (round to nearest, no flushing, all exceptions masked), so each entry saves what it finds, sets
//! the default and restores on exit. Callbacks run under the host's settings. Threads that a world starts inherit the default.

use std::cell::Cell;
use std::marker::PhantomData;

#[cfg(target_arch = "x86_64")]
mod control {
    use std::arch::asm;

    pub(super) type Word = u32;

    /// MXCSR after reset: round to nearest, all exceptions masked, no flags, denormals kept.
    pub(super) const DEFAULT: Word = 0x1F80;

    pub(super) fn get() -> Word {
        let mut word: Word = 0;
        // SAFETY: stores MXCSR in `word`, which is large enough and aligned.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags)) };
        word
    }

    pub(super) fn set(word: Word) {
        // SAFETY: `word` is the default or was read from MXCSR, so it sets no reserved bit. Settings other than the default
        // are in force only while host code runs, or while nothing is computed.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod control {
    use std::arch::asm;

    pub(super) type Word = u64;

    /// FPCR: round to nearest, no traps, denormals kept.
    pub(super) const DEFAULT: Word = 0;

    pub(super) fn get() -> Word {
        let word: Word;
        // SAFETY: reads a register that any program may read.
        unsafe { asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags)) };
        word
    }

    pub(super) fn set(word: Word) {
        // SAFETY: `word` is the default or was read from FPCR. Settings other than the default are in force only while host
        // code runs, or while nothing is computed.
        unsafe { asm!("msr fpcr, {}", in(reg) word, options(nostack, preserves_flags)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod control {
    pub(super) type Word = ();
    pub(super) const DEFAULT: Word = ();
    pub(super) fn get() -> Word {}
    pub(super) fn set(_: Word) {}
}

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
