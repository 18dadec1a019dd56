//! Four numbers side by side, `f64`: the arithmetic of four bodies at a time.
//!
//! [`Four`] is implemented twice, as [`Wide`](crate::solve::wide::Wide) is, by AVX2 registers and by plain arrays, with the same
//! bits. Of plain arrays the compiler makes a mixture of narrow registers and single numbers even where it knows of AVX2: three
//! instructions in place of two. No value is passed to a closure, which would be compiled without the registers of its caller.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::block::Lanes;

/// A number of each of four bodies.
pub(super) trait Four:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A truth of each.
    type Mask: Copy;

    fn splat(x: f64) -> Self;
    fn of(lanes: Lanes) -> Self;
    fn widened(lanes: [f32; 4]) -> Self;
    fn load(lanes: &Lanes) -> Self;
    fn lanes(self) -> Lanes;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// The lesser one; `other` where either is not a number.
    fn min(self, other: Self) -> Self;
    /// Whether it is less than `other`; false where either is not a number.
    fn below(self, other: Self) -> Self::Mask;
    /// Whether it is no greater than `other`; false where either is not a number.
    fn at_most(self, other: Self) -> Self::Mask;
    /// Whether it holds of any.
    fn any(mask: Self::Mask) -> bool;
    /// Whether both hold.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    fn truths(mask: Self::Mask) -> [bool; 4];
    /// `then` where `mask` holds, else `other`.
    fn select(mask: Self::Mask, then: Self, other: Self) -> Self;
    /// Column k of the four rows, for each k.
    fn transpose(rows: [Self; 4]) -> [Self; 4];
}

/// Four numbers in an array, for processors without wide registers, and as they are kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plain(pub Lanes);

macro_rules! plain_operator {
    ($($trait:ident $method:ident $operator:tt),*) => {
        $(impl $trait for Plain {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(std::array::from_fn(|j| self.0[j] $operator other.0[j]))
            }
        })*
    };
}

plain_operator!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Plain {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl Four for Plain {
    type Mask = [bool; 4];

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn of(lanes: Lanes) -> Self {
        Self(lanes)
    }

    #[inline(always)]
    fn widened(lanes: [f32; 4]) -> Self {
        Self(lanes.map(f64::from))
    }

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.below(other), self, other)
    }

    #[inline(always)]
    fn below(self, other: Self) -> [bool; 4] {
        std::array::from_fn(|j| self.0[j] < other.0[j])
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> [bool; 4] {
        std::array::from_fn(|j| self.0[j] <= other.0[j])
    }

    #[inline(always)]
    fn any(mask: [bool; 4]) -> bool {
        mask.contains(&true)
    }

    #[inline(always)]
    fn both(a: [bool; 4], b: [bool; 4]) -> [bool; 4] {
        std::array::from_fn(|j| a[j] & b[j])
    }

    #[inline(always)]
    fn truths(mask: [bool; 4]) -> [bool; 4] {
        mask
    }

    #[inline(always)]
    fn select(mask: [bool; 4], then: Self, other: Self) -> Self {
        Self(std::array::from_fn(|j| if mask[j] { then.0[j] } else { other.0[j] }))
    }

    #[inline(always)]
    fn transpose(rows: [Self; 4]) -> [Self; 4] {
        std::array::from_fn(|k| Self(rows.map(|row| row.0[k])))
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) mod avx2 {
    //! Four numbers in an AVX2 register.

    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Neg, Sub};

    use super::{Four, Lanes};

    /// A register. Only code that has found AVX2 on the processor may make one: `in_registers` does, before it enters a kernel.
    #[derive(Clone, Copy)]
    pub(in crate::solve::direct) struct Avx2(__m256d);

    macro_rules! avx2_operator {
        ($($trait:ident $name:ident $intrinsic:ident),*) => {
            $(impl $trait for Avx2 {
                type Output = Self;

                #[inline(always)]
                fn $name(self, other: Self) -> Self {
                    // SAFETY: values of this type exist only where AVX2 does.
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            })*
        };
    }

    avx2_operator!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

    impl Neg for Avx2 {
        type Output = Self;

        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: values of this type exist only where AVX2 does.
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    impl Four for Avx2 {
        type Mask = __m256d;

        #[inline(always)]
        fn splat(x: f64) -> Self {
            // SAFETY: kernels are entered with this type only where AVX2 has been found.
            Self(unsafe { _mm256_set1_pd(x) })
        }

        #[inline(always)]
        fn of([a, b, c, d]: Lanes) -> Self {
            // SAFETY: kernels are entered with this type only where AVX2 has been found.
            Self(unsafe { _mm256_setr_pd(a, b, c, d) })
        }

        #[inline(always)]
        fn widened([a, b, c, d]: [f32; 4]) -> Self {
            // SAFETY: kernels are entered with this type only where AVX2 has been found.
            Self(unsafe { _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d)) })
        }

        #[inline(always)]
        fn load(lanes: &Lanes) -> Self {
            // SAFETY: the array has four numbers; the load needs no alignment. Kernels are entered with this type only where
            // AVX2 has been found.
            Self(unsafe { _mm256_loadu_pd(lanes.as_ptr()) })
        }

        #[inline(always)]
        fn lanes(self) -> Lanes {
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
}
