//! Eight numbers in two registers of 128 bits, and four of twice the size: what NEON and WebAssembly's simd128 have in common.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{doubles, singles};
use crate::lanes::four::Four;
use crate::lanes::wide::{LANES, Lane, Wide};

/// Eight numbers in two registers.
#[derive(Clone, Copy)]
pub(crate) struct F32x8(singles::Register, singles::Register);

/// Four numbers in two registers.
#[derive(Clone, Copy)]
pub(crate) struct F64x4(doubles::Register, doubles::Register);

macro_rules! operators {
    ($type:ident $module:ident: $($trait:ident $name:ident),*) => {
        $(impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($module::$name(self.0, other.0), $module::$name(self.1, other.1))
            }
        })*
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self($module::neg(self.0), $module::neg(self.1))
            }
        }
    };
}
operators!(F32x8 singles: Add add, Sub sub, Mul mul, Div div);
operators!(F64x4 doubles: Add add, Sub sub, Mul mul, Div div);

impl Wide for F32x8 {
    type Mask = (singles::Mask, singles::Mask);

    #[inline(always)]
    fn splat(x: f32) -> Self {
        let all = singles::of([x; 4]);
        Self(all, all)
    }

    #[inline(always)]
    fn load(&[a, b, c, d, e, f, g, h]: &Lane) -> Self {
        Self(singles::of([a, b, c, d]), singles::of([e, f, g, h]))
    }

    #[inline(always)]
    fn store(self, lane: &mut Lane) {
        let ([a, b, c, d], [e, f, g, h]) = (singles::lanes(self.0), singles::lanes(self.1));
        *lane = [a, b, c, d, e, f, g, h];
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.above(other), self, other)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.above(self), self, other)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(singles::sqrt(self.0), singles::sqrt(self.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(singles::abs(self.0), singles::abs(self.1))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self(singles::with_sign_of(self.0, other.0), singles::with_sign_of(self.1, other.1))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        (singles::above(self.0, other.0), singles::above(self.1, other.1))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        singles::any(singles::either(mask.0, mask.1))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, then: Self, other: Self) -> Self {
        Self(singles::select(mask.0, then.0, other.0), singles::select(mask.1, then.1, other.1))
    }

    #[inline(always)]
    fn transpose([r0, r1, r2, r3, r4, r5, r6, r7]: [Self; LANES]) -> [Self; LANES] {
        // Its four quarters, each in itself; the two off the diagonal change places.
        let [a0, a1, a2, a3] = singles::transpose([r0.0, r1.0, r2.0, r3.0]);
        let [b0, b1, b2, b3] = singles::transpose([r4.0, r5.0, r6.0, r7.0]);
        let [c0, c1, c2, c3] = singles::transpose([r0.1, r1.1, r2.1, r3.1]);
        let [d0, d1, d2, d3] = singles::transpose([r4.1, r5.1, r6.1, r7.1]);
        [Self(a0, b0), Self(a1, b1), Self(a2, b2), Self(a3, b3), Self(c0, d0), Self(c1, d1), Self(c2, d2), Self(c3, d3)]
    }
}

impl Four for F64x4 {
    type Mask = (doubles::Mask, doubles::Mask);

    #[inline(always)]
    fn splat(x: f64) -> Self {
        let both = doubles::of([x; 2]);
        Self(both, both)
    }

    #[inline(always)]
    fn of([a, b, c, d]: [f64; 4]) -> Self {
        Self(doubles::of([a, b]), doubles::of([c, d]))
    }

    #[inline(always)]
    fn widened(lanes: [f32; 4]) -> Self {
        let (low, high) = singles::widened(singles::of(lanes));
        Self(low, high)
    }

    #[inline(always)]
    fn load(lanes: &[f64; 4]) -> Self {
        Self::of(*lanes)
    }

    #[inline(always)]
    fn lanes(self) -> [f64; 4] {
        let ([a, b], [c, d]) = (doubles::lanes(self.0), doubles::lanes(self.1));
        [a, b, c, d]
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(doubles::sqrt(self.0), doubles::sqrt(self.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(doubles::abs(self.0), doubles::abs(self.1))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.below(other), self, other)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        (doubles::below(self.0, other.0), doubles::below(self.1, other.1))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        (doubles::at_most(self.0, other.0), doubles::at_most(self.1, other.1))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        doubles::truths(mask.0) != [false; 2] || doubles::truths(mask.1) != [false; 2]
    }

    #[inline(always)]
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        (doubles::both(a.0, b.0), doubles::both(a.1, b.1))
    }

    #[inline(always)]
    fn truths(mask: Self::Mask) -> [bool; 4] {
        let ([a, b], [c, d]) = (doubles::truths(mask.0), doubles::truths(mask.1));
        [a, b, c, d]
    }

    #[inline(always)]
    fn select(mask: Self::Mask, then: Self, other: Self) -> Self {
        Self(doubles::select(mask.0, then.0, other.0), doubles::select(mask.1, then.1, other.1))
    }

    #[inline(always)]
    fn transpose([r0, r1, r2, r3]: [Self; 4]) -> [Self; 4] {
        let quarter = |a, b| (doubles::firsts(a, b), doubles::seconds(a, b));
        let ((a0, a1), (b0, b1)) = (quarter(r0.0, r1.0), quarter(r2.0, r3.0));
        let ((c0, c1), (d0, d1)) = (quarter(r0.1, r1.1), quarter(r2.1, r3.1));
        [Self(a0, b0), Self(a1, b1), Self(c0, d0), Self(c1, d1)]
    }
}
