//! All that differs by platform in the C interface: the settings of the floating-point unit.

#[cfg(target_arch = "x86_64")]
pub(crate) mod control {
    //! Its control word.

    use std::arch::asm;

    pub(crate) type Word = u32;

    /// MXCSR after reset: round to nearest, all exceptions masked, no flags, denormals kept.
    pub(crate) const DEFAULT: Word = 0x1F80;

    pub(crate) fn get() -> Word {
        let mut word: Word = 0;
        // SAFETY: stores MXCSR in `word`, which is large enough and aligned.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut word, options(nostack, preserves_flags)) };
        word
    }

    pub(crate) fn set(word: Word) {
        // SAFETY: `word` is the default or was read from MXCSR, so it sets no reserved bit. Settings other than the default
        // are in force only while host code runs, or while nothing is computed.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const word, options(nostack, preserves_flags)) };
    }
}

#[cfg(target_arch = "aarch64")]
pub(crate) mod control {
    //! Its control word.

    use std::arch::asm;

    pub(crate) type Word = u64;

    /// FPCR: round to nearest, no traps, denormals kept.
    pub(crate) const DEFAULT: Word = 0;

    pub(crate) fn get() -> Word {
        let word: Word;
        // SAFETY: reads a register that any program may read.
        unsafe { asm!("mrs {}, fpcr", out(reg) word, options(nomem, nostack, preserves_flags)) };
        word
    }

    pub(crate) fn set(word: Word) {
        // SAFETY: `word` is the default or was read from FPCR. Settings other than the default are in force only while host
        // code runs, or while nothing is computed.
        unsafe { asm!("msr fpcr, {}", in(reg) word, options(nostack, preserves_flags)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
pub(crate) mod control {
    //! No control word: it cannot be set here.

    pub(crate) type Word = ();
    pub(crate) const DEFAULT: Word = ();
    pub(crate) fn get() -> Word {}
    pub(crate) fn set(_: Word) {}
}
