//! x86-64: registers of AVX2, where the processor has them, and requests for memory.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::lanes::four::Four;
use crate::lanes::wide::{LANES, Lane, Wide};

/// Makes a function that runs its body, an `#[inline(always)]` function, with the registers that the processor has.
macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $body:ident, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $(#[$doc])*
        pub(crate) fn $name($($arg: $type),*) $(-> $result)? {
            if std::arch::is_x86_feature_detected!("avx2") && !$crate::platform::holds_to_baseline() {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),*) $(-> $result)? {
                    $body($($arg),*)
                }
                // SAFETY: the processor has just been found to have AVX2, the only feature that the function needs.
                return unsafe { with_avx2($($arg),*) };
            }
            $body($($arg),*)
        }
    };
}

pub(crate) use dispatched;

/// Makes a function that runs a kernel, generic over the registers that it computes in, with those that the processor has: the
/// first of two types where it has AVX2, else the second.
macro_rules! in_registers {
    (
        $(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($own:ty, $baseline:ty), ($($arg:ident: $type:ty),*) $(-> $result:ty)?
    ) => {
        $(#[$doc])*
        $vis fn $name($($arg: $type),*) $(-> $result)? {
            use $body as body;
            if std::arch::is_x86_feature_detected!("avx2") && !$crate::platform::holds_to_baseline() {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),*) $(-> $result)? {
                    body::<$own>($($arg),*)
                }
                // SAFETY: the processor has just been found to have AVX2, the only feature that the function needs.
                return unsafe { with_avx2($($arg),*) };
            }
            body::<$baseline>($($arg),*)
        }
    };
}

pub(crate) use in_registers;

/// Asks for the memory of a value, all of it.
#[inline(always)]
pub(crate) fn prefetch<T: ?Sized>(value: &T) {
    const LINE: usize = 64;
    let (first, size) = (std::ptr::from_ref(value).cast::<i8>(), size_of_val(value));
    // SAFETY: nothing is read: it is a hint, whatever the address.
    let ask = |offset: usize| unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(offset)) };
    (0..size).step_by(LINE).for_each(ask);
    if align_of_val(value) < LINE {
        // What does not begin with a line may end in one more.
        ask(size.saturating_sub(1));
    }
}

/// Eight numbers in a register of AVX2. Only code that has found AVX2 on the processor may make one: `in_registers` does, before it enters a kernel.
#[derive(Clone, Copy)]
pub(crate) struct F32x8(__m256);

macro_rules! singles_operator {
    ($($trait:ident $name:ident $intrinsic:ident),*) => {
        $(impl $trait for F32x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where AVX2 does.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}
singles_operator!(Add add _mm256_add_ps, Sub sub _mm256_sub_ps, Mul mul _mm256_mul_ps, Div div _mm256_div_ps);

impl Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Wide for F32x8 {
    type Mask = __m256;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: kernels are entered with this type only where AVX2 has been found.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(lane: &Lane) -> Self {
        // SAFETY: the array has eight numbers; the load needs no alignment. Kernels are entered with this type only where
        // AVX2 has been found.
        Self(unsafe { _mm256_loadu_ps(lane.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, lane: &mut Lane) {
        // SAFETY: the array has room for eight numbers; the store needs no alignment. Values of this type exist only where
        // AVX2 does.
        unsafe { _mm256_storeu_ps(lane.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe {
            let sign = _mm256_set1_ps(-0.0);
            _mm256_or_ps(_mm256_andnot_ps(sign, self.0), _mm256_and_ps(sign, other.0))
        })
    }

    #[inline(always)]
    fn above(self, other: Self) -> __m256 {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn any(mask: __m256) -> bool {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe { _mm256_movemask_ps(mask) != 0 }
    }

    #[inline(always)]
    fn select(mask: __m256, then: Self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_blendv_ps(other.0, then.0, mask) })
    }

    #[inline(always)]
    fn transpose(rows: [Self; LANES]) -> [Self; LANES] {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe {
            let [r0, r1, r2, r3, r4, r5, r6, r7] = rows;
            let (r0, r1, r2, r3, r4, r5, r6, r7) = (r0.0, r1.0, r2.0, r3.0, r4.0, r5.0, r6.0, r7.0);
            // Pairs of rows interleaved, then fours, each within its half of the register; then the halves exchanged.
            let (a0, a1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
            let (a2, a3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
            let (a4, a5) = (_mm256_unpacklo_ps(r4, r5), _mm256_unpackhi_ps(r4, r5));
            let (a6, a7) = (_mm256_unpacklo_ps(r6, r7), _mm256_unpackhi_ps(r6, r7));
            let (b0, b1) = (_mm256_shuffle_ps::<0x44>(a0, a2), _mm256_shuffle_ps::<0xee>(a0, a2));
            let (b2, b3) = (_mm256_shuffle_ps::<0x44>(a1, a3), _mm256_shuffle_ps::<0xee>(a1, a3));
            let (b4, b5) = (_mm256_shuffle_ps::<0x44>(a4, a6), _mm256_shuffle_ps::<0xee>(a4, a6));
            let (b6, b7) = (_mm256_shuffle_ps::<0x44>(a5, a7), _mm256_shuffle_ps::<0xee>(a5, a7));
            [
                Self(_mm256_permute2f128_ps::<0x20>(b0, b4)),
                Self(_mm256_permute2f128_ps::<0x20>(b1, b5)),
                Self(_mm256_permute2f128_ps::<0x20>(b2, b6)),
                Self(_mm256_permute2f128_ps::<0x20>(b3, b7)),
                Self(_mm256_permute2f128_ps::<0x31>(b0, b4)),
                Self(_mm256_permute2f128_ps::<0x31>(b1, b5)),
                Self(_mm256_permute2f128_ps::<0x31>(b2, b6)),
                Self(_mm256_permute2f128_ps::<0x31>(b3, b7)),
            ]
        }
    }
}

/// Four numbers in a register of AVX2; made by no other code than an [`F32x8`].
#[derive(Clone, Copy)]
pub(crate) struct F64x4(__m256d);

macro_rules! doubles_operator {
    ($($trait:ident $name:ident $intrinsic:ident),*) => {
        $(impl $trait for F64x4 {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: values of this type exist only where AVX2 does.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}

doubles_operator!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for F64x4 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

impl Four for F64x4 {
    type Mask = __m256d;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: kernels are entered with this type only where AVX2 has been found.
        Self(unsafe { _mm256_set1_pd(x) })
    }

    #[inline(always)]
    fn of([a, b, c, d]: [f64; 4]) -> Self {
        // SAFETY: kernels are entered with this type only where AVX2 has been found.
        Self(unsafe { _mm256_setr_pd(a, b, c, d) })
    }

    #[inline(always)]
    fn widened([a, b, c, d]: [f32; 4]) -> Self {
        // SAFETY: kernels are entered with this type only where AVX2 has been found.
        Self(unsafe { _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d)) })
    }

    #[inline(always)]
    fn load(lanes: &[f64; 4]) -> Self {
        // SAFETY: the array has four numbers; the load needs no alignment. Kernels are entered with this type only where
        // AVX2 has been found.
        Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn lanes(self) -> [f64; 4] {
        let mut lanes = [0.0; 4];
        // SAFETY: the array has room for four numbers; the store needs no alignment. Values of this type exist only where
        // AVX2 does.
        unsafe { _mm256_storeu_pd(lanes.as_mut_ptr(), self.0) }
        lanes
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn below(self, other: Self) -> __m256d {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> __m256d {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn any(mask: __m256d) -> bool {
        // SAFETY: masks of this type exist only where AVX2 does.
        unsafe { _mm256_movemask_pd(mask) != 0 }
    }

    #[inline(always)]
    fn both(a: __m256d, b: __m256d) -> __m256d {
        // SAFETY: masks of this type exist only where AVX2 does.
        unsafe { _mm256_and_pd(a, b) }
    }

    #[inline(always)]
    fn truths(mask: __m256d) -> [bool; 4] {
        // SAFETY: masks of this type exist only where AVX2 does.
        let bits = unsafe { _mm256_movemask_pd(mask) };
        [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0, bits & 8 != 0]
    }

    #[inline(always)]
    fn select(mask: __m256d, then: Self, other: Self) -> Self {
        // SAFETY: values of this type exist only where AVX2 does.
        Self(unsafe { _mm256_blendv_pd(other.0, then.0, mask) })
    }

    #[inline(always)]
    fn transpose([r0, r1, r2, r3]: [Self; 4]) -> [Self; 4] {
        // SAFETY: values of this type exist only where AVX2 does.
        unsafe {
            // Pairs of rows interleaved, each within its half of the register; then the halves exchanged.
            let (a0, a1) = (_mm256_unpacklo_pd(r0.0, r1.0), _mm256_unpackhi_pd(r0.0, r1.0));
            let (a2, a3) = (_mm256_unpacklo_pd(r2.0, r3.0), _mm256_unpackhi_pd(r2.0, r3.0));
            [
                Self(_mm256_permute2f128_pd::<0x20>(a0, a2)),
                Self(_mm256_permute2f128_pd::<0x20>(a1, a3)),
                Self(_mm256_permute2f128_pd::<0x31>(a0, a2)),
                Self(_mm256_permute2f128_pd::<0x31>(a1, a3)),
            ]
        }
    }
}
