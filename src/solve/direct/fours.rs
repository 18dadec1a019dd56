//! Vectors, rotations and symmetric matrices of four bodies side by side, `f64`.
//!
//! Plain loops over arrays, as in [`super::block`]. No value is passed to a closure, which would be compiled without the wide
//! registers of its caller.

#![expect(clippy::needless_range_loop, reason = "an index runs over lanes")]

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{DMat3, DQuat, DVec3};

use super::block::Lanes;
use crate::solve::rotation::{FEW_TERMS, FEW_TERMS_BELOW, SERIES};

/// Square of the sine of half an angle below which a rotation is small.
const SMALL_SQUARE: f64 = 1.0e-3;

/// A number of each of four bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Four(pub Lanes);

/// A truth of each of four bodies.
pub(super) type Mask = [bool; 4];

macro_rules! lanewise {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Four {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut result = self.0;
                for j in 0..4 {
                    result[j] = self.0[j] $operator other.0[j];
                }
                Self(result)
            }
        }
    };
}

lanewise!(Add, add, +);
lanewise!(Sub, sub, -);
lanewise!(Mul, mul, *);
lanewise!(Div, div, /);

impl Neg for Four {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2], -self.0[3]])
    }
}

impl Four {
    #[inline(always)]
    pub(super) fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        let mut result = self.0;
        for j in 0..4 {
            result[j] = result[j].sqrt();
        }
        Self(result)
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        let mut result = self.0;
        for j in 0..4 {
            result[j] = result[j].abs();
        }
        Self(result)
    }

    /// The lesser one; `other` where either is not a number.
    #[inline(always)]
    pub(super) fn min(self, other: Self) -> Self {
        Self::select(self.below(other), self, other)
    }

    /// Whether it is less than `other`; false where either is not a number.
    #[inline(always)]
    pub(super) fn below(self, other: Self) -> Mask {
        let mut mask = [false; 4];
        for j in 0..4 {
            mask[j] = self.0[j] < other.0[j];
        }
        mask
    }

    /// Whether it is no greater than `other`; false where either is not a number.
    #[inline(always)]
    pub(super) fn at_most(self, other: Self) -> Mask {
        let mut mask = [false; 4];
        for j in 0..4 {
            mask[j] = self.0[j] <= other.0[j];
        }
        mask
    }

    /// `then` where `mask` holds, else `other`.
    #[inline(always)]
    pub(super) fn select(mask: Mask, then: Self, other: Self) -> Self {
        let mut result = other.0;
        for j in 0..4 {
            result[j] = if mask[j] { then.0[j] } else { other.0[j] };
        }
        Self(result)
    }
}

/// Whether it holds of any.
#[inline(always)]
pub(super) fn any(mask: Mask) -> bool {
    (mask[0] | mask[1]) | (mask[2] | mask[3])
}

/// Whether both hold.
#[inline(always)]
pub(super) fn both(a: Mask, b: Mask) -> Mask {
    [a[0] & b[0], a[1] & b[1], a[2] & b[2], a[3] & b[3]]
}

/// A vector of each of four bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Four3 {
    pub x: Four,
    pub y: Four,
    pub z: Four,
}

macro_rules! by_component {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Four3 {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { x: self.x $operator other.x, y: self.y $operator other.y, z: self.z $operator other.z }
            }
        }
    };
}

by_component!(Add, add, +);
by_component!(Sub, sub, -);
by_component!(Mul, mul, *);
by_component!(Div, div, /);

impl Mul<Four> for Four3 {
    type Output = Self;

    #[inline(always)]
    fn mul(self, share: Four) -> Self {
        Self { x: self.x * share, y: self.y * share, z: self.z * share }
    }
}

impl Four3 {
    #[inline(always)]
    pub(super) fn of(v: [DVec3; 4]) -> Self {
        Self {
            x: Four([v[0].x, v[1].x, v[2].x, v[3].x]),
            y: Four([v[0].y, v[1].y, v[2].y, v[3].y]),
            z: Four([v[0].z, v[1].z, v[2].z, v[3].z]),
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, j: usize) -> DVec3 {
        DVec3::new(self.x.0[j], self.y.0[j], self.z.0[j])
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Four {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub(super) fn select(mask: Mask, then: Self, other: Self) -> Self {
        Self {
            x: Four::select(mask, then.x, other.x),
            y: Four::select(mask, then.y, other.y),
            z: Four::select(mask, then.z, other.z),
        }
    }

    /// None longer than `most`.
    #[inline(always)]
    pub(super) fn clamp_length(self, most: f64) -> Self {
        let square = self.dot(self);
        let beyond = Four::splat(most * most).below(square);
        if !any(beyond) {
            return self;
        }
        self * Four::select(beyond, Four::splat(most) / square.sqrt(), Four::splat(1.0))
    }
}

/// A rotation of each of four bodies, as unit quaternions.
#[derive(Debug, Clone, Copy)]
pub(super) struct FourTurns {
    v: Four3,
    w: Four,
}

impl Mul for FourTurns {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { v: other.v * self.w + self.v * other.w + self.v.cross(other.v), w: self.w * other.w - self.v.dot(other.v) }
    }
}

impl FourTurns {
    #[inline(always)]
    pub(super) fn of(q: [DQuat; 4]) -> Self {
        Self {
            v: Four3 {
                x: Four([q[0].x, q[1].x, q[2].x, q[3].x]),
                y: Four([q[0].y, q[1].y, q[2].y, q[3].y]),
                z: Four([q[0].z, q[1].z, q[2].z, q[3].z]),
            },
            w: Four([q[0].w, q[1].w, q[2].w, q[3].w]),
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, j: usize) -> DQuat {
        DQuat::from_xyzw(self.v.x.0[j], self.v.y.0[j], self.v.z.0[j], self.w.0[j])
    }

    #[inline(always)]
    pub(super) fn conjugate(self) -> Self {
        let zero = Four::splat(0.0);
        Self { v: Four3 { x: zero - self.v.x, y: zero - self.v.y, z: zero - self.v.z }, w: self.w }
    }

    /// The vector in the frame that is turned so.
    #[inline(always)]
    pub(super) fn rotate(self, v: Four3) -> Four3 {
        let twice = self.v.cross(v) * Four::splat(2.0);
        v + twice * self.w + self.v.cross(twice)
    }

    /// Turned further by a rotation vector in world axes (rad), as [`crate::solve::rotation::rotated`] does.
    #[inline(always)]
    pub(super) fn turned(self, vector: Four3) -> Self {
        let half = vector * Four::splat(0.5);
        let x = half.dot(half);
        let few = !any(Four::splat(FEW_TERMS_BELOW).below(x));
        let terms = if few { FEW_TERMS } else { SERIES.len() };
        let one = Four::splat(1.0);
        let (mut sine_over_angle, mut cosine) = (one, one);
        for k in (0..terms).rev() {
            let (sine_term, cosine_term) = SERIES[k];
            sine_over_angle = one - x * Four::splat(sine_term) * sine_over_angle;
            cosine = one - x * Four::splat(cosine_term) * cosine;
        }
        let product = Self { v: half * sine_over_angle, w: cosine } * self;
        let share = one / (product.v.dot(product.v) + product.w * product.w).sqrt();
        Self { v: product.v * share, w: product.w * share }
    }

    /// The rotation vectors (rad), and where they are right: 2 asin(s)/s to rounding of `f32`, of rotations by less than 3.6°.
    #[inline(always)]
    pub(super) fn small_vector(self) -> (Four3, Mask) {
        let square = self.v.dot(self.v);
        let third = Four::splat(3.0 / 20.0) + square * Four::splat(5.0 / 56.0);
        let share = Four::splat(2.0) + square * (Four::splat(1.0 / 3.0) + square * third);
        let sign = Four::select(self.w.below(Four::splat(0.0)), -share, share);
        (self.v * sign, square.below(Four::splat(SMALL_SQUARE)))
    }

    /// A D Aᵀ, with A the matrix of the rotation.
    #[inline(always)]
    pub(super) fn turn_diagonal(self, d: Four3) -> FourSymmetric {
        let Self { v: Four3 { x, y, z }, w } = self;
        let (one, two) = (Four::splat(1.0), Four::splat(2.0));
        let (x2, y2, z2) = (x * two, y * two, z * two);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz, wx, wy, wz) = (x * y2, x * z2, y * z2, w * x2, w * y2, w * z2);
        let first = Four3 { x: one - (yy + zz), y: xy - wz, z: xz + wy };
        let second = Four3 { x: xy + wz, y: one - (xx + zz), z: yz - wx };
        let third = Four3 { x: xz - wy, y: yz + wx, z: one - (xx + yy) };
        let (scaled_first, scaled_second) = (first * d, second * d);
        FourSymmetric {
            xx: scaled_first.dot(first),
            yy: scaled_second.dot(second),
            zz: (third * d).dot(third),
            xy: scaled_first.dot(second),
            xz: scaled_first.dot(third),
            yz: scaled_second.dot(third),
        }
    }
}

/// A symmetric matrix of each of four bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct FourSymmetric {
    xx: Four,
    yy: Four,
    zz: Four,
    xy: Four,
    xz: Four,
    yz: Four,
}

impl FourSymmetric {
    #[inline(always)]
    pub(super) fn of(m: [&DMat3; 4]) -> Self {
        Self {
            xx: Four([m[0].x_axis.x, m[1].x_axis.x, m[2].x_axis.x, m[3].x_axis.x]),
            yy: Four([m[0].y_axis.y, m[1].y_axis.y, m[2].y_axis.y, m[3].y_axis.y]),
            zz: Four([m[0].z_axis.z, m[1].z_axis.z, m[2].z_axis.z, m[3].z_axis.z]),
            xy: Four([m[0].x_axis.y, m[1].x_axis.y, m[2].x_axis.y, m[3].x_axis.y]),
            xz: Four([m[0].x_axis.z, m[1].x_axis.z, m[2].x_axis.z, m[3].x_axis.z]),
            yz: Four([m[0].y_axis.z, m[1].y_axis.z, m[2].y_axis.z, m[3].y_axis.z]),
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, j: usize) -> DMat3 {
        let (xy, xz, yz) = (self.xy.0[j], self.xz.0[j], self.yz.0[j]);
        DMat3::from_cols(DVec3::new(self.xx.0[j], xy, xz), DVec3::new(xy, self.yy.0[j], yz), DVec3::new(xz, yz, self.zz.0[j]))
    }

    #[inline(always)]
    pub(super) fn times(self, v: Four3) -> Four3 {
        Four3 {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
    }

    /// Adds a share of another.
    #[inline(always)]
    pub(super) fn plus(self, other: Self, share: Four) -> Self {
        Self {
            xx: self.xx + other.xx * share,
            yy: self.yy + other.yy * share,
            zz: self.zz + other.zz * share,
            xy: self.xy + other.xy * share,
            xz: self.xz + other.xz * share,
            yz: self.yz + other.yz * share,
        }
    }

    /// Adds a multiple of the unit matrix.
    #[inline(always)]
    pub(super) fn shifted(self, by: Four) -> Self {
        Self { xx: self.xx + by, yy: self.yy + by, zz: self.zz + by, ..self }
    }

    /// With rows and columns scaled.
    #[inline(always)]
    pub(super) fn scaled(self, by: Four3) -> Self {
        Self {
            xx: self.xx * by.x * by.x,
            yy: self.yy * by.y * by.y,
            zz: self.zz * by.z * by.z,
            xy: self.xy * by.x * by.y,
            xz: self.xz * by.x * by.z,
            yz: self.yz * by.y * by.z,
        }
    }

    #[inline(always)]
    pub(super) fn inverse(self) -> Self {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let (of_xx, of_xy, of_xz) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
        let share = Four::splat(1.0) / (xx * of_xx + xy * of_xy + xz * of_xz);
        Self {
            xx: of_xx * share,
            yy: (xx * zz - xz * xz) * share,
            zz: (xx * yy - xy * xy) * share,
            xy: of_xy * share,
            xz: of_xz * share,
            yz: (xy * xz - xx * yz) * share,
        }
    }

    /// A lower bound on the lowest eigenvalue by Gershgorin's circles, and the coefficients of det(A − λ): trace, sum of minors,
    /// determinant.
    #[inline(always)]
    pub(super) fn characteristic(self) -> (Four, [Four; 3]) {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let (off_xy, off_xz, off_yz) = (xy.abs(), xz.abs(), yz.abs());
        let bound = (xx - off_xy - off_xz).min(yy - off_xy - off_yz).min(zz - off_xz - off_yz);
        let minor = yy * zz - yz * yz;
        let minors = xx * yy - xy * xy + (zz * xx - xz * xz) + minor;
        let determinant = xx * minor + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy);
        (bound, [xx + yy + zz, minors, determinant])
    }
}
