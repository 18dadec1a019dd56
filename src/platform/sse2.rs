//! x86-64 without AVX2: registers of SSE2, which every such processor has.

/// Four `f32`.
pub(super) mod singles {
    use std::arch::x86_64::*;

    use super::doubles;

    pub(crate) type Register = __m128;
    pub(crate) type Mask = __m128;

    macro_rules! operations {
        ($($name:ident($($arg:ident: $type:ty),*) -> $result:ty = $intrinsic:ident),* $(,)?) => {
            $(#[inline(always)]
            pub(crate) fn $name($($arg: $type),*) -> $result {
                // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
                unsafe { $intrinsic($($arg),*) }
            })*
        };
    }
    pub(super) use operations;

    operations! {
        add(a: Register, b: Register) -> Register = _mm_add_ps,
        sub(a: Register, b: Register) -> Register = _mm_sub_ps,
        mul(a: Register, b: Register) -> Register = _mm_mul_ps,
        div(a: Register, b: Register) -> Register = _mm_div_ps,
        sqrt(a: Register) -> Register = _mm_sqrt_ps,
        above(a: Register, b: Register) -> Mask = _mm_cmpgt_ps,
        either(a: Mask, b: Mask) -> Mask = _mm_or_ps,
    }

    #[inline(always)]
    pub(crate) fn of([a, b, c, d]: [f32; 4]) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe { _mm_setr_ps(a, b, c, d) }
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f32; 4] {
        let mut lanes = [0.0; 4];
        // SAFETY: the array has room for four numbers, and the store needs no alignment; every processor of this target has SSE2.
        unsafe { _mm_storeu_ps(lanes.as_mut_ptr(), a) };
        lanes
    }

    #[inline(always)]
    pub(crate) fn neg(a: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { _mm_xor_ps(a, _mm_set1_ps(-0.0)) }
    }

    #[inline(always)]
    pub(crate) fn abs(a: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), a) }
    }

    #[inline(always)]
    pub(crate) fn with_sign_of(a: Register, b: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe { select(_mm_set1_ps(-0.0), b, a) }
    }

    #[inline(always)]
    pub(crate) fn select(mask: Mask, then: Register, other: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe { _mm_or_ps(_mm_and_ps(mask, then), _mm_andnot_ps(mask, other)) }
    }

    #[inline(always)]
    pub(crate) fn any(mask: Mask) -> bool {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { _mm_movemask_ps(mask) != 0 }
    }

    #[inline(always)]
    pub(crate) fn widened(a: Register) -> (doubles::Register, doubles::Register) {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { (_mm_cvtps_pd(a), _mm_cvtps_pd(_mm_movehl_ps(a, a))) }
    }

    #[inline(always)]
    pub(crate) fn transpose([r0, r1, r2, r3]: [Register; 4]) -> [Register; 4] {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe {
            // Pairs of rows interleaved by numbers, then by pairs of numbers.
            let (a0, a1) = (_mm_unpacklo_ps(r0, r1), _mm_unpackhi_ps(r0, r1));
            let (a2, a3) = (_mm_unpacklo_ps(r2, r3), _mm_unpackhi_ps(r2, r3));
            [_mm_movelh_ps(a0, a2), _mm_movehl_ps(a2, a0), _mm_movelh_ps(a1, a3), _mm_movehl_ps(a3, a1)]
        }
    }
}

/// Two `f64`.
pub(super) mod doubles {
    use std::arch::x86_64::*;

    use super::singles::operations;

    pub(crate) type Register = __m128d;
    pub(crate) type Mask = __m128d;

    operations! {
        add(a: Register, b: Register) -> Register = _mm_add_pd,
        sub(a: Register, b: Register) -> Register = _mm_sub_pd,
        mul(a: Register, b: Register) -> Register = _mm_mul_pd,
        div(a: Register, b: Register) -> Register = _mm_div_pd,
        sqrt(a: Register) -> Register = _mm_sqrt_pd,
        below(a: Register, b: Register) -> Mask = _mm_cmplt_pd,
        at_most(a: Register, b: Register) -> Mask = _mm_cmple_pd,
        both(a: Mask, b: Mask) -> Mask = _mm_and_pd,
        firsts(a: Register, b: Register) -> Register = _mm_unpacklo_pd,
        seconds(a: Register, b: Register) -> Register = _mm_unpackhi_pd,
    }

    #[inline(always)]
    pub(crate) fn of([a, b]: [f64; 2]) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe { _mm_setr_pd(a, b) }
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f64; 2] {
        let mut lanes = [0.0; 2];
        // SAFETY: the array has room for two numbers, and the store needs no alignment; every processor of this target has SSE2.
        unsafe { _mm_storeu_pd(lanes.as_mut_ptr(), a) };
        lanes
    }

    #[inline(always)]
    pub(crate) fn neg(a: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { _mm_xor_pd(a, _mm_set1_pd(-0.0)) }
    }

    #[inline(always)]
    pub(crate) fn abs(a: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        unsafe { _mm_andnot_pd(_mm_set1_pd(-0.0), a) }
    }

    #[inline(always)]
    pub(crate) fn select(mask: Mask, then: Register, other: Register) -> Register {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the arguments.
        unsafe { _mm_or_pd(_mm_and_pd(mask, then), _mm_andnot_pd(mask, other)) }
    }

    #[inline(always)]
    pub(crate) fn truths(mask: Mask) -> [bool; 2] {
        // SAFETY: every processor of this target has SSE2, and nothing is read but the argument.
        let bits = unsafe { _mm_movemask_pd(mask) };
        [bits & 1 != 0, bits & 2 != 0]
    }
}
