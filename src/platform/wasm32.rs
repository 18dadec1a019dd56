//! WebAssembly with `simd128`, for which a module is compiled or not (`-C target-feature=+simd128`): it cannot ask.

pub(crate) use super::halves::{F32x8, F64x4};

/// Four `f32`.
pub(super) mod singles {
    use std::arch::wasm32::*;

    pub(crate) use std::arch::wasm32::{
        f32x4_abs as abs, f32x4_add as add, f32x4_div as div, f32x4_gt as above, f32x4_mul as mul, f32x4_neg as neg,
        f32x4_sqrt as sqrt, f32x4_sub as sub, v128_any_true as any, v128_or as either,
    };

    pub(crate) type Register = v128;
    pub(crate) type Mask = v128;

    #[inline(always)]
    pub(crate) fn of([a, b, c, d]: [f32; 4]) -> Register {
        f32x4(a, b, c, d)
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f32; 4] {
        [f32x4_extract_lane::<0>(a), f32x4_extract_lane::<1>(a), f32x4_extract_lane::<2>(a), f32x4_extract_lane::<3>(a)]
    }

    #[inline(always)]
    pub(crate) fn select(mask: Mask, then: Register, other: Register) -> Register {
        v128_bitselect(then, other, mask)
    }

    #[inline(always)]
    pub(crate) fn with_sign_of(a: Register, b: Register) -> Register {
        v128_bitselect(b, a, f32x4_splat(-0.0))
    }

    #[inline(always)]
    pub(crate) fn widened(a: Register) -> (Register, Register) {
        (f64x2_promote_low_f32x4(a), f64x2_promote_low_f32x4(i32x4_shuffle::<2, 3, 2, 3>(a, a)))
    }

    #[inline(always)]
    pub(crate) fn transpose([r0, r1, r2, r3]: [Register; 4]) -> [Register; 4] {
        // Pairs of rows interleaved by numbers, then by pairs of numbers.
        let (a0, a1) = (i32x4_shuffle::<0, 4, 2, 6>(r0, r1), i32x4_shuffle::<1, 5, 3, 7>(r0, r1));
        let (a2, a3) = (i32x4_shuffle::<0, 4, 2, 6>(r2, r3), i32x4_shuffle::<1, 5, 3, 7>(r2, r3));
        let firsts = |a, b| i64x2_shuffle::<0, 2>(a, b);
        let seconds = |a, b| i64x2_shuffle::<1, 3>(a, b);
        [firsts(a0, a2), firsts(a1, a3), seconds(a0, a2), seconds(a1, a3)]
    }
}

/// Two `f64`.
pub(super) mod doubles {
    use std::arch::wasm32::*;

    pub(crate) use std::arch::wasm32::{
        f64x2_abs as abs, f64x2_add as add, f64x2_div as div, f64x2_le as at_most, f64x2_lt as below, f64x2_mul as mul,
        f64x2_neg as neg, f64x2_sqrt as sqrt, f64x2_sub as sub, v128_and as both,
    };

    pub(crate) use super::singles::{Mask, Register, select};

    #[inline(always)]
    pub(crate) fn of([a, b]: [f64; 2]) -> Register {
        f64x2(a, b)
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f64; 2] {
        [f64x2_extract_lane::<0>(a), f64x2_extract_lane::<1>(a)]
    }

    #[inline(always)]
    pub(crate) fn truths(mask: Mask) -> [bool; 2] {
        [i64x2_extract_lane::<0>(mask) != 0, i64x2_extract_lane::<1>(mask) != 0]
    }

    #[inline(always)]
    pub(crate) fn firsts(a: Register, b: Register) -> Register {
        i64x2_shuffle::<0, 2>(a, b)
    }

    #[inline(always)]
    pub(crate) fn seconds(a: Register, b: Register) -> Register {
        i64x2_shuffle::<1, 3>(a, b)
    }
}

/// Memory cannot be asked for.
#[inline(always)]
pub(crate) fn prefetch<T: ?Sized>(_: &T) {}
