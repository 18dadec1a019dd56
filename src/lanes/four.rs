//! Four `f64` lanes: the arithmetic of four bodies at a time.
//!
//! [`Four`] is implemented as [`Wide`](super::wide::Wide) is, by plain arrays and by registers, with the same bits. Of plain
//! arrays the compiler makes a mixture of narrow registers and single numbers even where it knows of AVX2: three instructions in
//! place of two. No value is passed to a closure, which would be compiled without the registers of its caller.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number of each of four bodies.
pub(crate) trait Four:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A truth of each.
    type Mask: Copy;

    fn splat(x: f64) -> Self;
    fn of(lanes: [f64; 4]) -> Self;
    fn widened(lanes: [f32; 4]) -> Self;
    fn load(lanes: &[f64; 4]) -> Self;
    fn lanes(self) -> [f64; 4];
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
pub(crate) struct Plain(pub [f64; 4]);

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
    fn of(lanes: [f64; 4]) -> Self {
        Self(lanes)
    }

    #[inline(always)]
    fn widened(lanes: [f32; 4]) -> Self {
        Self(lanes.map(f64::from))
    }

    #[inline(always)]
    fn load(lanes: &[f64; 4]) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn lanes(self) -> [f64; 4] {
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
