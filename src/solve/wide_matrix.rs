//! Symmetric matrices and rotations in lanes.

use std::ops::Add;

use glam::Mat3;

use super::contact::Lane;
use crate::lanes::wide::{Wide, Wide3};
use crate::linalg::rotation32::{COSINE_TERMS, NEGLIGIBLE_WAY, SINE_TERMS};

/// Determinant, over the product of the diagonal, at or below which a matrix counts as singular: rounding of `f32` leaves as much of
/// a determinant that is zero.
pub(crate) const SINGULAR: f32 = 1.0e-7;

/// Sum of the principal minors, over the square of the trace, above which a singular matrix counts as one of rank two: so far above
/// what rounding of `f32` leaves of zero that the inverse is good to some hundredths.
pub(crate) const RANK_TWO: f32 = 1.0e-6;

/// A symmetric 3×3 matrix in each lane: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy)]
pub(crate) struct Wide6<W>(pub [W; 6]);

impl<W: Wide> Wide6<W> {
    #[inline(always)]
    pub fn load(lanes: &[Lane; 6]) -> Self {
        let [xx, yy, zz, xy, xz, yz] = lanes;
        Self([W::load(xx), W::load(yy), W::load(zz), W::load(xy), W::load(xz), W::load(yz)])
    }

    #[inline(always)]
    pub fn store(self, lanes: &mut [Lane; 6]) {
        let ([xx, yy, zz, xy, xz, yz], [lxx, lyy, lzz, lxy, lxz, lyz]) = (self.0, lanes);
        xx.store(lxx);
        yy.store(lyy);
        zz.store(lzz);
        xy.store(lxy);
        xz.store(lxz);
        yz.store(lyz);
    }

    /// One matrix in all lanes.
    #[inline(always)]
    pub fn splat(m: &Mat3) -> Self {
        let [xx, yy, zz] = [W::splat(m.x_axis.x), W::splat(m.y_axis.y), W::splat(m.z_axis.z)];
        Self([xx, yy, zz, W::splat(m.x_axis.y), W::splat(m.x_axis.z), W::splat(m.y_axis.z)])
    }

    /// The matrix with these eigenvalues along these unit axes.
    #[inline(always)]
    pub fn with_axes(axes: &[Wide3<W>; 3], values: Wide3<W>) -> Self {
        let [a, b, c] = axes;
        let (p, q, r) = (*a * values.x, *b * values.y, *c * values.z);
        Self([
            p.x * a.x + q.x * b.x + r.x * c.x,
            p.y * a.y + q.y * b.y + r.y * c.y,
            p.z * a.z + q.z * b.z + r.z * c.z,
            p.x * a.y + q.x * b.y + r.x * c.y,
            p.x * a.z + q.x * b.z + r.x * c.z,
            p.y * a.z + q.y * b.z + r.y * c.z,
        ])
    }

    /// `then` where `mask` holds, else `other`.
    #[inline(always)]
    pub fn select(mask: W::Mask, then: Self, other: Self) -> Self {
        let ([a, b, c, d, e, f], [k, l, m, n, o, p]) = (then.0, other.0);
        Self([
            W::select(mask, a, k),
            W::select(mask, b, l),
            W::select(mask, c, m),
            W::select(mask, d, n),
            W::select(mask, e, o),
            W::select(mask, f, p),
        ])
    }

    #[inline(always)]
    pub fn mul(&self, v: Wide3<W>) -> Wide3<W> {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Wide3::new(xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z)
    }

    #[inline(always)]
    pub fn scaled(&self, factor: W) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Self([xx * factor, yy * factor, zz * factor, xy * factor, xz * factor, yz * factor])
    }

    #[inline(always)]
    pub fn plus_diagonal(&self, d: Wide3<W>) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Self([xx + d.x, yy + d.y, zz + d.z, xy, xz, yz])
    }

    /// −[r]× M [r]×: with M an inverse inertia, the turning part of the inverse effective mass of a point at `r`.
    #[inline(always)]
    pub fn seen_at(&self, r: Wide3<W>) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        // Columns of N = M [r]×; the result is [r]×ᵀ N.
        let x = Wide3::new(xy * r.z - xz * r.y, yy * r.z - yz * r.y, yz * r.z - zz * r.y);
        let y = Wide3::new(xz * r.x - xx * r.z, yz * r.x - xy * r.z, zz * r.x - xz * r.z);
        let z = Wide3::new(xx * r.y - xy * r.x, xy * r.y - yy * r.x, xz * r.y - yz * r.x);
        Self([
            r.z * x.y - r.y * x.z,
            r.x * y.z - r.z * y.x,
            r.y * z.x - r.x * z.y,
            r.z * y.y - r.y * y.z,
            r.z * z.y - r.y * z.z,
            r.x * z.z - r.z * z.x,
        ])
    }

    /// Minors xx, yy, zz, xy, xz, yz with their signs: the inverse times the determinant.
    #[inline(always)]
    fn adjugate(&self) -> Self {
        let [xx, yy, zz, xy, xz, yz] = self.0;
        Self([yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy, xz * yz - xy * zz, xy * yz - xz * yy, xy * xz - xx * yz])
    }

    /// The inverse; zero where the matrix is singular.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let adjugate = self.adjugate();
        let [xx, yy, zz, xy, xz, _] = self.0;
        let [a, _, _, b, c, _] = adjugate.0;
        let determinant = xx * a + xy * b + xz * c;
        let is_regular = determinant.above(W::splat(SINGULAR) * (xx * yy * zz));
        adjugate.scaled(W::select(is_regular, W::splat(1.0) / determinant, W::zero()))
    }

    /// The pseudo-inverse of a matrix without negative eigenvalues: the inverse on the directions in which bodies can move, zero on
    /// those that locked axes take away. In lanes what `inverse_where_it_moves` in `joint/sweep.rs` is for one joint.
    #[inline(always)]
    pub fn inverse_where_it_moves(&self) -> Self {
        let inverse = self.inverse();
        let trace = self.trace();
        let dropped = W::select(inverse.trace().above(W::zero()), W::zero(), trace * trace);
        let is_dropped = dropped.above(W::splat(f32::MIN_POSITIVE));
        if !W::any(is_dropped) {
            return inverse;
        }
        let adjugate = self.adjugate();
        let (minors, one) = (adjugate.trace(), W::splat(1.0));
        let null = adjugate.scaled(-trace / minors);
        let of_two = (null + self.scaled(-one)).plus_diagonal(Wide3::new(trace, trace, trace)).scaled(one / minors);
        let of_one = self.scaled(one / dropped);
        let is_of_two = minors.above(W::splat(RANK_TWO) * dropped);
        Self::select(is_dropped, Self::select(is_of_two, of_two, of_one), inverse)
    }

    /// The inverse on the directions across a unit vector `n`, zero along it.
    ///
    /// With A = P M P of rank two, P being the projection across, A⁻¹ = (tr A P − A)/d there, d = (tr² A − tr A²)/2. Of rank one, where
    /// bodies with locked axes move in one direction alone, it is A/tr² A. Zero where A is so small that its square is below the normal
    /// numbers and the inverse may be infinite.
    #[inline(always)]
    pub fn inverse_across(&self, n: Wide3<W>) -> Self {
        let along = self.mul(n);
        let twice = n.dot(along);
        // A = M − n (Mn)ᵀ − (Mn) nᵀ + n nᵀ (nᵀMn)
        let side = along - n * (twice * W::splat(0.5));
        let [xx, yy, zz, xy, xz, yz] = self.0;
        let two = W::splat(2.0);
        let a = Self([
            xx - two * n.x * side.x,
            yy - two * n.y * side.y,
            zz - two * n.z * side.z,
            xy - (n.x * side.y + n.y * side.x),
            xz - (n.x * side.z + n.z * side.x),
            yz - (n.y * side.z + n.z * side.y),
        ]);
        let [axx, ayy, azz, axy, axz, ayz] = a.0;
        let trace = axx + ayy + azz;
        let adjugate = a.adjugate();
        // The adjugate of a matrix of rank two is d n nᵀ.
        let determinant = adjugate.0[0] + adjugate.0[1] + adjugate.0[2];
        let least = (W::splat(f32::EPSILON * 0.25) * (trace * trace)).max(W::splat(f32::MIN_POSITIVE));
        let one = W::splat(1.0);
        let is_of_two = determinant.above(least);
        let factor = W::select(is_of_two, one / determinant, W::zero());
        let of_two = Self([
            trace * (one - n.x * n.x) - axx,
            trace * (one - n.y * n.y) - ayy,
            trace * (one - n.z * n.z) - azz,
            -(trace * n.x * n.y) - axy,
            -(trace * n.x * n.z) - axz,
            -(trace * n.y * n.z) - ayz,
        ])
        .scaled(factor);
        let squared = W::select(is_of_two, W::zero(), trace * trace);
        let is_of_one = squared.above(W::splat(f32::MIN_POSITIVE));
        if W::any(is_of_one) { Self::select(is_of_one, a.scaled(one / squared), of_two) } else { of_two }
    }

    /// Sum of its diagonal.
    #[inline(always)]
    pub fn trace(&self) -> W {
        self.0[0] + self.0[1] + self.0[2]
    }
}

impl<W: Wide> Add for Wide6<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c, d, e, f], [k, l, m, n, o, p]) = (self.0, other.0);
        Self([a + k, b + l, c + m, d + n, e + o, f + p])
    }
}

/// A rotation in each lane, as a quaternion.
#[derive(Clone, Copy)]
pub(crate) struct WideQuat<W> {
    pub v: Wide3<W>,
    pub w: W,
}

impl<W: Wide> WideQuat<W> {
    #[inline(always)]
    pub fn load(lanes: &[Lane; 4]) -> Self {
        let [x, y, z, w] = lanes;
        Self { v: Wide3::new(W::load(x), W::load(y), W::load(z)), w: W::load(w) }
    }

    #[inline(always)]
    pub fn rotate(&self, u: Wide3<W>) -> Wide3<W> {
        u + self.way_of(u)
    }

    /// The displacement of a vector's tip by the rotation, `rotate(u) − u`, without the rounding of that difference.
    #[inline(always)]
    pub fn way_of(&self, u: Wide3<W>) -> Wide3<W> {
        let side = self.v.cross(u);
        let twice = side + side;
        twice * self.w + self.v.cross(twice)
    }

    #[inline(always)]
    pub fn conjugate(&self) -> Self {
        Self { v: -self.v, w: self.w }
    }

    /// This rotation after `first`: the product of the quaternions.
    #[inline(always)]
    pub fn after(&self, first: &Self) -> Self {
        Self { v: first.v * self.w + self.v * first.w + self.v.cross(first.v), w: self.w * first.w - self.v.dot(first.v) }
    }

    /// The three coordinate axes, rotated: columns of its matrix.
    #[inline(always)]
    pub fn axes(&self) -> [Wide3<W>; 3] {
        let (one, v, w) = (W::splat(1.0), self.v, self.w);
        let twice = v + v;
        let (xx, yy, zz) = (v.x * twice.x, v.y * twice.y, v.z * twice.z);
        let (xy, xz, yz) = (v.x * twice.y, v.x * twice.z, v.y * twice.z);
        let (wx, wy, wz) = (w * twice.x, w * twice.y, w * twice.z);
        [
            Wide3::new(one - (yy + zz), xy + wz, xz - wy),
            Wide3::new(xy - wz, one - (xx + zz), yz + wx),
            Wide3::new(xz + wy, yz - wx, one - (xx + yy)),
        ]
    }

    /// The same quaternion at unit length.
    #[inline(always)]
    pub fn normalized(&self) -> Self {
        let scale = W::splat(1.0) / (self.v.dot(self.v) + self.w * self.w).sqrt();
        Self { v: self.v * scale, w: self.w * scale }
    }

    /// The same with components no greater than `least` set to zero.
    #[inline(always)]
    pub fn settled(&self, least: f32) -> Self {
        Self { v: self.v.settled(least), w: W::select(self.w.abs().above(W::splat(least)), self.w, W::zero()) }
    }

    /// `then` where `mask` holds, else `other`.
    #[inline(always)]
    pub fn select(mask: W::Mask, then: Self, other: Self) -> Self {
        let (x, y, z) =
            (W::select(mask, then.v.x, other.v.x), W::select(mask, then.v.y, other.v.y), W::select(mask, then.v.z, other.v.z));
        Self { v: Wide3::new(x, y, z), w: W::select(mask, then.w, other.w) }
    }

    /// Turned by a rotation vector of at most half a radian in world axes (rad), by power series.
    #[inline(always)]
    pub fn turned(&self, turn: Wide3<W>) -> Self {
        let one = W::splat(1.0);
        let half = turn * W::splat(0.5);
        let x = half.dot(half);
        let sine = one - x * W::splat(1.0 / 6.0) * (one - x * W::splat(1.0 / 20.0) * (one - x * W::splat(1.0 / 42.0)));
        let cosine = one
            - x * W::splat(0.5)
                * (one - x * W::splat(1.0 / 12.0) * (one - x * W::splat(1.0 / 30.0) * (one - x * W::splat(1.0 / 56.0))));
        Self { v: half * sine, w: cosine }.after(self).normalized()
    }
}

/// Coefficients of s¹⁷ to s⁵ of the power series of asin s, and of s⁶ to s of the polynomial in √(1 − s) · (π/2 + …) = acos s.
const SERIES: [f32; 7] =
    [6435.0 / 557_056.0, 143.0 / 10240.0, 231.0 / 13312.0, 63.0 / 2816.0, 35.0 / 1152.0, 5.0 / 112.0, 3.0 / 40.0];
const POLYNOMIAL: [f32; 6] = [0.006_670_09, -0.017_088_126, 0.030_891_88, -0.050_174_305, 0.088_978_99, -0.214_598_8];

/// asin(s)/s for s in 0…1.
///
/// The power series up to half of it, √(1 − s) times a polynomial beyond (Abramowitz and Stegun 1964, 4.4.46): error below 2e-7.
#[inline(always)]
pub(crate) fn arc_over_sine<W: Wide>(s: W) -> W {
    let one = W::splat(1.0);
    let s = s.min(one);
    let x = s * s;
    let mut near = W::splat(12155.0 / 1_245_184.0);
    for term in SERIES {
        near = near * x + W::splat(term);
    }
    near = (near * x + W::splat(1.0 / 6.0)) * x + one;
    let mut far = W::splat(-0.001_262_491_1);
    for term in POLYNOMIAL {
        far = far * s + W::splat(term);
    }
    far = far * s + W::splat(std::f32::consts::FRAC_PI_2);
    let far = (W::splat(std::f32::consts::FRAC_PI_2) - (one - s).sqrt() * far) / s;
    W::select(s.above(W::splat(0.5)), far, near)
}

/// Does in lanes what [`rotated`](crate::linalg::rotation32::rotated) does, to the same bits.
#[inline(always)]
pub(crate) fn rotated_in_lanes<W: Wide>(rotation: &WideQuat<W>, vector: Wide3<W>) -> WideQuat<W> {
    let (one, half) = (W::splat(1.0), vector * W::splat(0.5));
    let x = half.dot(half);
    let (mut sine_over_angle, mut cosine) = (one, one);
    for term in SINE_TERMS.into_iter().rev() {
        sine_over_angle = one - x * W::splat(term) * sine_over_angle;
    }
    for term in COSINE_TERMS.into_iter().rev() {
        cosine = one - x * W::splat(term) * cosine;
    }
    let (v, w, u) = (half * sine_over_angle, cosine, rotation.v);
    // In the order in which glam multiplies two `Quat`: [`WideQuat::after`] adds in another one and gives other bits.
    let x = w * u.x + v.x * rotation.w + v.y * u.z - v.z * u.y;
    let y = w * u.y - v.x * u.z + v.y * rotation.w + v.z * u.x;
    let z = w * u.z + v.x * u.y - v.y * u.x + v.z * rotation.w;
    let w = w * rotation.w - v.x * u.x - v.y * u.y - v.z * u.z;
    WideQuat { v: Wide3::new(x, y, z), w }.settled(NEGLIGIBLE_WAY).normalized()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::wide::Plain;
    use crate::solve::contact::LANES;

    #[test]
    fn a_matrix_too_small_to_invert_has_no_inverse_across_instead_of_an_infinite_one() {
        let (n, mut lanes) = (Wide3::<Plain>::splat(glam::Vec3::X), [[0.0; LANES]; 6]);
        for exponent in 0..45 {
            let matrix = Mat3::from_diagonal(glam::Vec3::new(1.0, 2.0, 1.5) * 10.0_f32.powi(-exponent));
            Wide6::<Plain>::splat(&matrix).inverse_across(n).store(&mut lanes);
            let finite = lanes.iter().flatten().all(|number| number.is_finite());
            assert!(finite, "inverse of a matrix of 1e-{exponent}: {:?}", lanes.map(|lane| lane[0]));
        }
    }
}
