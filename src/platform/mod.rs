//! All that differs by platform: no other file of this crate asks what it is compiled for (`tests/platforms.rs` holds that).
//!
//! A processor's file gives [`F32x8`] and [`F64x4`], the registers in which the solver's kernels compute, the macros that enter
//! a kernel with them, and [`prefetch`]. On every processor each operation is one rounded operation of IEEE 754 a lane, so the
//! bits of a step are the same on all of them.

#[cfg_attr(target_arch = "x86_64", path = "x86_64.rs")]
#[cfg_attr(target_arch = "aarch64", path = "aarch64.rs")]
#[cfg_attr(all(target_arch = "wasm32", target_feature = "simd128"), path = "wasm32.rs")]
#[cfg_attr(
    not(any(target_arch = "x86_64", target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128"))),
    path = "plain.rs"
)]
mod processor;

#[cfg(any(target_arch = "x86_64", target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))]
mod halves;
#[cfg(any(target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))]
use processor::{doubles, singles};

// x86-64 has macros of its own: there alone a processor of the target may lack the best registers.
#[cfg(not(target_arch = "x86_64"))]
mod entered;
#[cfg(target_arch = "x86_64")]
mod sse2;
#[cfg(target_arch = "x86_64")]
use sse2::{doubles, singles};

// A browser's module without a host has no clock that the standard library knows.
#[cfg_attr(all(target_arch = "wasm32", target_os = "unknown"), path = "no_clock.rs")]
mod clock;

#[cfg(any(test, target_arch = "x86_64"))]
mod baseline;

#[cfg(any(test, target_arch = "x86_64"))]
pub(crate) use baseline::*;
pub(crate) use clock::Moment;
#[cfg(not(target_arch = "x86_64"))]
pub(crate) use entered::{dispatched, in_registers};
pub(crate) use processor::*;

/// As `in_registers`, of a kernel that is generic over [`Wide`](crate::lanes::wide::Wide).
macro_rules! in_lanes {
    ($(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $crate::platform::in_registers!(
            $(#[$doc])* $vis $name, $body, ($crate::platform::F32x8, $crate::platform::Baseline32),
            ($($arg: $type),*) $(-> $result)?
        );
    };
}

pub(crate) use in_lanes;

/// As `in_registers`, of a kernel that is generic over [`Four`](crate::lanes::four::Four).
macro_rules! in_fours {
    ($(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $crate::platform::in_registers!(
            $(#[$doc])* $vis $name, $body, ($crate::platform::F64x4, $crate::platform::Baseline64),
            ($($arg: $type),*) $(-> $result)?
        );
    };
}

pub(crate) use in_fours;
