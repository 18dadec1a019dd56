//! Eight `f32` lanes: the arithmetic of the contact kernels.
//!
//! [`Wide`] is implemented by plain arrays here, and by the registers of each processor in [`platform`](crate::platform). Each
//! operation is one rounded operation of IEEE 754 on every lane, never fused and never estimated, so all give the same bits. A
//! kernel is written once, generic over it, and runs with registers where the processor has them (see `in_lanes`). Kernels pass no `Wide` value to a closure: a
//! closure is compiled without the registers and is not inlined where they are.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers side by side.
pub(crate) const LANES: usize = 8;

/// One number for each lane.
pub(crate) type Lane = [f32; LANES];
/// One vector for each lane: x, y, z.
pub(crate) type Lane3 = [Lane; 3];

/// One number for each of eight lanes.
pub(crate) trait Wide:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// One truth for each lane.
    type Mask: Copy;

    fn splat(x: f32) -> Self;
    fn load(lane: &Lane) -> Self;
    fn store(self, lane: &mut Lane);
    /// The greater one; `other` where either is not a number.
    fn max(self, other: Self) -> Self;
    /// The lesser one; `other` where either is not a number.
    fn min(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// Its size with the sign of `other`, be that a zero.
    fn with_sign_of(self, other: Self) -> Self;
    /// Whether it is greater than `other`; false where either is not a number.
    fn above(self, other: Self) -> Self::Mask;
    /// Whether it holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// `then` where `mask` holds, else `other`.
    fn select(mask: Self::Mask, then: Self, other: Self) -> Self;
    /// Column k of the eight rows, for each k.
    fn transpose(rows: [Self; LANES]) -> [Self; LANES];

    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
}

/// A vector in each lane.
#[derive(Clone, Copy)]
pub(crate) struct Wide3<W> {
    pub x: W,
    pub y: W,
    pub z: W,
}

impl<W: Wide> Wide3<W> {
    #[inline(always)]
    pub fn new(x: W, y: W, z: W) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(W::zero(), W::zero(), W::zero())
    }

    #[inline(always)]
    pub fn load(lanes: &Lane3) -> Self {
        Self::new(W::load(&lanes[0]), W::load(&lanes[1]), W::load(&lanes[2]))
    }

    #[inline(always)]
    pub fn store(self, lanes: &mut Lane3) {
        self.x.store(&mut lanes[0]);
        self.y.store(&mut lanes[1]);
        self.z.store(&mut lanes[2]);
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> W {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(self.y * other.z - other.y * self.z, self.z * other.x - other.z * self.x, self.x * other.y - other.x * self.y)
    }

    /// A vector of one lane in all.
    #[inline(always)]
    pub fn splat(v: glam::Vec3) -> Self {
        Self::new(W::splat(v.x), W::splat(v.y), W::splat(v.z))
    }

    #[inline(always)]
    pub fn length(self) -> W {
        self.dot(self).sqrt()
    }

    /// `then` where `mask` holds, else `other`.
    #[inline(always)]
    pub fn select(mask: W::Mask, then: Self, other: Self) -> Self {
        Self::new(W::select(mask, then.x, other.x), W::select(mask, then.y, other.y), W::select(mask, then.z, other.z))
    }

    /// Shortened where it is longer than `most`.
    #[inline(always)]
    pub fn shortened(self, most: W) -> Self {
        let length = self.length();
        self * W::select(length.above(most), most / length, W::splat(1.0))
    }

    /// Every component between −most and most.
    #[inline(always)]
    pub fn clamped(self, most: f32) -> Self {
        let (least, most) = (W::splat(-most), W::splat(most));
        Self::new(self.x.max(least).min(most), self.y.max(least).min(most), self.z.max(least).min(most))
    }

    /// Zero where `mask` does not hold.
    #[inline(always)]
    pub fn only(self, mask: W::Mask) -> Self {
        let zero = W::zero();
        Self::new(W::select(mask, self.x, zero), W::select(mask, self.y, zero), W::select(mask, self.z, zero))
    }

    /// Zero where a component is no greater than `least`.
    #[inline(always)]
    pub fn settled(self, least: f32) -> Self {
        let (least, zero) = (W::splat(least), W::zero());
        Self::new(
            W::select(self.x.abs().above(least), self.x, zero),
            W::select(self.y.abs().above(least), self.y, zero),
            W::select(self.z.abs().above(least), self.z, zero),
        )
    }

    /// Each component times its own factor.
    #[inline(always)]
    pub fn scale(self, factors: Self) -> Self {
        Self::new(self.x * factors.x, self.y * factors.y, self.z * factors.z)
    }
}

impl<W: Wide> Add for Wide3<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<W: Wide> Sub for Wide3<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<W: Wide> Neg for Wide3<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<W: Wide> Mul<W> for Wide3<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: W) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

/// Eight numbers in an array, for processors without wide registers.
#[derive(Clone, Copy)]
pub(crate) struct Plain(Lane);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|l| f(self.0[l], other.0[l])))
    }
}

macro_rules! plain_operator {
    ($($trait:ident $name:ident $operator:tt),*) => {
        $(impl $trait for Plain {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
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

impl Wide for Plain {
    type Mask = [bool; LANES];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn load(lane: &Lane) -> Self {
        Self(*lane)
    }

    #[inline(always)]
    fn store(self, lane: &mut Lane) {
        *lane = self.0;
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        self.zip(other, f32::copysign)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        std::array::from_fn(|l| self.0[l] > other.0[l])
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.contains(&true)
    }

    #[inline(always)]
    fn select(mask: Self::Mask, then: Self, other: Self) -> Self {
        Self(std::array::from_fn(|l| if mask[l] { then.0[l] } else { other.0[l] }))
    }

    #[inline(always)]
    fn transpose(rows: [Self; LANES]) -> [Self; LANES] {
        std::array::from_fn(|k| Self(std::array::from_fn(|l| rows[l].0[k])))
    }
}
