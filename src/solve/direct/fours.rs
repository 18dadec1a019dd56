//! Vectors, rotations and symmetric matrices of four bodies side by side in `f64`: each component is a [`Four`], one lane to a body.

use std::ops::{Add, Div, Mul, Sub};

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::block::Lanes;
use crate::lanes::four::{Four, Plain};
use crate::solve::rotation::{FEW_TERMS, FEW_TERMS_BELOW, SERIES, SERIES_BELOW, rotated};

/// Square of the sine of half an angle below which a rotation is small.
const SMALL_SQUARE: f64 = 1.0e-3;

/// A vector of each of four bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vec3x4<F> {
    pub x: F,
    pub y: F,
    pub z: F,
}

macro_rules! by_component {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<F: Four> $trait for Vec3x4<F> {
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

impl<F: Four> Mul<F> for Vec3x4<F> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, share: F) -> Self {
        Self { x: self.x * share, y: self.y * share, z: self.z * share }
    }
}

impl<F: Four> Vec3x4<F> {
    #[inline(always)]
    pub(super) fn of(v: [DVec3; 4]) -> Self {
        Self {
            x: F::of([v[0].x, v[1].x, v[2].x, v[3].x]),
            y: F::of([v[0].y, v[1].y, v[2].y, v[3].y]),
            z: F::of([v[0].z, v[1].z, v[2].z, v[3].z]),
        }
    }

    #[inline(always)]
    pub(super) fn widened(v: [Vec3; 4]) -> Self {
        Self {
            x: F::widened([v[0].x, v[1].x, v[2].x, v[3].x]),
            y: F::widened([v[0].y, v[1].y, v[2].y, v[3].y]),
            z: F::widened([v[0].z, v[1].z, v[2].z, v[3].z]),
        }
    }

    #[inline(always)]
    pub(super) fn load(kept: &Vec3x4<Plain>) -> Self {
        Self { x: F::load(&kept.x.0), y: F::load(&kept.y.0), z: F::load(&kept.z.0) }
    }

    /// The vector of each body.
    #[inline(always)]
    pub(super) fn each(self) -> [DVec3; 4] {
        let [a, b, c, d] = F::transpose([self.x, self.y, self.z, self.z]);
        [vector(a.lanes()), vector(b.lanes()), vector(c.lanes()), vector(d.lanes())]
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> F {
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
    pub(super) fn select(mask: F::Mask, then: Self, other: Self) -> Self {
        Self { x: F::select(mask, then.x, other.x), y: F::select(mask, then.y, other.y), z: F::select(mask, then.z, other.z) }
    }

    /// The same vectors, shortened to a length of `most` where they are longer.
    #[inline(always)]
    pub(super) fn clamp_length(self, most: f64) -> Self {
        let square = self.dot(self);
        let beyond = F::splat(most * most).below(square);
        if !F::any(beyond) {
            return self;
        }
        self * F::select(beyond, F::splat(most) / square.sqrt(), F::splat(1.0))
    }
}

#[inline(always)]
fn vector([x, y, z, _]: Lanes) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A rotation of each of four bodies, as unit quaternions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quatx4<F> {
    v: Vec3x4<F>,
    w: F,
}

impl<F: Four> Mul for Quatx4<F> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { v: other.v * self.w + self.v * other.w + self.v.cross(other.v), w: self.w * other.w - self.v.dot(other.v) }
    }
}

impl<F: Four> Quatx4<F> {
    #[inline(always)]
    pub(super) fn of(q: [DQuat; 4]) -> Self {
        Self {
            v: Vec3x4 {
                x: F::of([q[0].x, q[1].x, q[2].x, q[3].x]),
                y: F::of([q[0].y, q[1].y, q[2].y, q[3].y]),
                z: F::of([q[0].z, q[1].z, q[2].z, q[3].z]),
            },
            w: F::of([q[0].w, q[1].w, q[2].w, q[3].w]),
        }
    }

    #[inline(always)]
    pub(super) fn load(kept: &Quatx4<Plain>) -> Self {
        Self { v: Vec3x4::load(&kept.v), w: F::load(&kept.w.0) }
    }

    /// The rotation of each body.
    #[inline(always)]
    pub(super) fn each(self) -> [DQuat; 4] {
        let [a, b, c, d] = F::transpose([self.v.x, self.v.y, self.v.z, self.w]);
        [DQuat::from_array(a.lanes()), DQuat::from_array(b.lanes()), DQuat::from_array(c.lanes()), DQuat::from_array(d.lanes())]
    }

    #[inline(always)]
    pub(super) fn conjugate(self) -> Self {
        let zero = F::splat(0.0);
        Self { v: Vec3x4 { x: zero - self.v.x, y: zero - self.v.y, z: zero - self.v.z }, w: self.w }
    }

    /// The vector turned by the rotation.
    #[inline(always)]
    pub(super) fn rotate(self, v: Vec3x4<F>) -> Vec3x4<F> {
        let twice = self.v.cross(v) * F::splat(2.0);
        v + twice * self.w + self.v.cross(twice)
    }

    /// Turned further by a rotation vector in world axes (rad), as [`crate::solve::rotation::rotated`] does.
    #[inline(always)]
    pub(super) fn turned(self, vector: Vec3x4<F>) -> Self {
        let half = vector * F::splat(0.5);
        let x = half.dot(half);
        if F::any(F::splat(SERIES_BELOW).below(x)) {
            let (turns, vectors) = (self.each(), vector.each());
            return Self::of([0, 1, 2, 3].map(|j| rotated(turns[j], vectors[j])));
        }
        let few = !F::any(F::splat(FEW_TERMS_BELOW).below(x));
        let terms = if few { FEW_TERMS } else { SERIES.len() };
        let one = F::splat(1.0);
        let (mut sine_over_angle, mut cosine) = (one, one);
        for k in (0..terms).rev() {
            let (sine_term, cosine_term) = SERIES[k];
            sine_over_angle = one - x * F::splat(sine_term) * sine_over_angle;
            cosine = one - x * F::splat(cosine_term) * cosine;
        }
        let product = Self { v: half * sine_over_angle, w: cosine } * self;
        let share = one / (product.v.dot(product.v) + product.w * product.w).sqrt();
        Self { v: product.v * share, w: product.w * share }
    }

    /// Rotation vectors of small rotations (rad), and a mask of the lanes where they are valid: turns by less than 3.6°, for which the
    /// series of 2 asin(s)/s is exact to rounding of `f32`.
    #[inline(always)]
    pub(super) fn small_vector(self) -> (Vec3x4<F>, F::Mask) {
        let square = self.v.dot(self.v);
        let third = F::splat(3.0 / 20.0) + square * F::splat(5.0 / 56.0);
        let share = F::splat(2.0) + square * (F::splat(1.0 / 3.0) + square * third);
        let sign = F::select(self.w.below(F::splat(0.0)), -share, share);
        (self.v * sign, square.below(F::splat(SMALL_SQUARE)))
    }

    /// A D Aᵀ, with A the matrix of the rotation and D diagonal: principal moments of inertia in world axes.
    #[inline(always)]
    pub(super) fn turn_diagonal(self, d: Vec3x4<F>) -> Sym3x4<F> {
        let Self { v: Vec3x4 { x, y, z }, w } = self;
        let (one, two) = (F::splat(1.0), F::splat(2.0));
        let (x2, y2, z2) = (x * two, y * two, z * two);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz, wx, wy, wz) = (x * y2, x * z2, y * z2, w * x2, w * y2, w * z2);
        let first = Vec3x4 { x: one - (yy + zz), y: xy - wz, z: xz + wy };
        let second = Vec3x4 { x: xy + wz, y: one - (xx + zz), z: yz - wx };
        let third = Vec3x4 { x: xz - wy, y: yz + wx, z: one - (xx + yy) };
        let (scaled_first, scaled_second) = (first * d, second * d);
        Sym3x4 {
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
pub(super) struct Sym3x4<F> {
    xx: F,
    yy: F,
    zz: F,
    xy: F,
    xz: F,
    yz: F,
}

impl<F: Four> Sym3x4<F> {
    #[inline(always)]
    pub(super) fn of(m: [&DMat3; 4]) -> Self {
        Self {
            xx: F::of([m[0].x_axis.x, m[1].x_axis.x, m[2].x_axis.x, m[3].x_axis.x]),
            yy: F::of([m[0].y_axis.y, m[1].y_axis.y, m[2].y_axis.y, m[3].y_axis.y]),
            zz: F::of([m[0].z_axis.z, m[1].z_axis.z, m[2].z_axis.z, m[3].z_axis.z]),
            xy: F::of([m[0].x_axis.y, m[1].x_axis.y, m[2].x_axis.y, m[3].x_axis.y]),
            xz: F::of([m[0].x_axis.z, m[1].x_axis.z, m[2].x_axis.z, m[3].x_axis.z]),
            yz: F::of([m[0].y_axis.z, m[1].y_axis.z, m[2].y_axis.z, m[3].y_axis.z]),
        }
    }

    /// The matrix of each body.
    #[inline(always)]
    pub(super) fn each(self) -> [DMat3; 4] {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let ([a0, b0, c0, d0], [a1, b1, c1, d1]) = (F::transpose([xx, xy, xz, xy]), F::transpose([yy, yz, xz, yz]));
        let zz = zz.lanes();
        [
            matrix(a0.lanes(), a1.lanes(), zz[0]),
            matrix(b0.lanes(), b1.lanes(), zz[1]),
            matrix(c0.lanes(), c1.lanes(), zz[2]),
            matrix(d0.lanes(), d1.lanes(), zz[3]),
        ]
    }

    #[inline(always)]
    pub(super) fn times(self, v: Vec3x4<F>) -> Vec3x4<F> {
        Vec3x4 {
            x: self.xx * v.x + self.xy * v.y + self.xz * v.z,
            y: self.xy * v.x + self.yy * v.y + self.yz * v.z,
            z: self.xz * v.x + self.yz * v.y + self.zz * v.z,
        }
    }

    /// This matrix plus `share` times another.
    #[inline(always)]
    pub(super) fn plus(self, other: Self, share: F) -> Self {
        Self {
            xx: self.xx + other.xx * share,
            yy: self.yy + other.yy * share,
            zz: self.zz + other.zz * share,
            xy: self.xy + other.xy * share,
            xz: self.xz + other.xz * share,
            yz: self.yz + other.yz * share,
        }
    }

    /// This matrix plus `by` times the unit matrix.
    #[inline(always)]
    pub(super) fn shifted(self, by: F) -> Self {
        Self { xx: self.xx + by, yy: self.yy + by, zz: self.zz + by, ..self }
    }

    /// Inverse of the part of this matrix along the axes where `free` is 1, zero along those where it is 0.
    #[inline(always)]
    pub(super) fn held(self, free: Vec3x4<F>) -> Self {
        let only = self.scaled(free);
        let one = F::splat(1.0);
        let (xx, yy, zz) = (only.xx + (one - free.x), only.yy + (one - free.y), only.zz + (one - free.z));
        Self { xx, yy, zz, ..only }.inverse().scaled(free)
    }

    /// B A B, with A this matrix and B the diagonal matrix of `by`.
    #[inline(always)]
    fn scaled(self, by: Vec3x4<F>) -> Self {
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
        let share = F::splat(1.0) / (xx * of_xx + xy * of_xy + xz * of_xz);
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
    pub(super) fn characteristic(self) -> (F, [F; 3]) {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let (off_xy, off_xz, off_yz) = (xy.abs(), xz.abs(), yz.abs());
        let bound = (xx - off_xy - off_xz).min(yy - off_xy - off_yz).min(zz - off_xz - off_yz);
        let minor = yy * zz - yz * yz;
        let minors = xx * yy - xy * xy + (zz * xx - xz * xz) + minor;
        let determinant = xx * minor + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy);
        (bound, [xx + yy + zz, minors, determinant])
    }
}

/// A matrix from its nine numbers, column by column.
#[inline(always)]
fn matrix(first: Lanes, second: Lanes, last: f64) -> DMat3 {
    let ([a, b, c, d], [e, f, g, h]) = (first, second);
    DMat3::from_cols(DVec3::new(a, b, c), DVec3::new(d, e, f), DVec3::new(g, h, last))
}
