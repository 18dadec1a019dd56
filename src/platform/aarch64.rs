//! aarch64: registers of NEON, which every such processor has.
//!
//! None of these operations is fused or estimated. The greater and the lesser of two are chosen by comparison, as `fmax` and
//! `fmin` of this processor do otherwise with what is not a number and with zeros of different signs.

pub(crate) use super::halves::{F32x8, F64x4};

/// Four `f32`.
pub(super) mod singles {
    use std::arch::aarch64::*;

    use super::doubles;

    pub(crate) type Register = float32x4_t;
    pub(crate) type Mask = uint32x4_t;

    macro_rules! operations {
        ($($name:ident($($arg:ident: $type:ty),*) -> $result:ty = $intrinsic:ident),* $(,)?) => {
            $(#[inline(always)]
            pub(crate) fn $name($($arg: $type),*) -> $result {
                // SAFETY: every processor of this target has NEON, and nothing is read but the arguments.
                unsafe { $intrinsic($($arg),*) }
            })*
        };
    }
    pub(super) use operations;

    operations! {
        add(a: Register, b: Register) -> Register = vaddq_f32,
        sub(a: Register, b: Register) -> Register = vsubq_f32,
        mul(a: Register, b: Register) -> Register = vmulq_f32,
        div(a: Register, b: Register) -> Register = vdivq_f32,
        neg(a: Register) -> Register = vnegq_f32,
        sqrt(a: Register) -> Register = vsqrtq_f32,
        abs(a: Register) -> Register = vabsq_f32,
        above(a: Register, b: Register) -> Mask = vcgtq_f32,
        either(a: Mask, b: Mask) -> Mask = vorrq_u32,
        select(mask: Mask, then: Register, other: Register) -> Register = vbslq_f32,
    }

    #[inline(always)]
    pub(crate) fn of(lanes: [f32; 4]) -> Register {
        // SAFETY: the array has four numbers, and the load needs no alignment; every processor of this target has NEON.
        unsafe { vld1q_f32(lanes.as_ptr()) }
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f32; 4] {
        let mut lanes = [0.0; 4];
        // SAFETY: the array has room for four numbers, and the store needs no alignment; every processor of this target has NEON.
        unsafe { vst1q_f32(lanes.as_mut_ptr(), a) };
        lanes
    }

    #[inline(always)]
    pub(crate) fn with_sign_of(a: Register, b: Register) -> Register {
        // SAFETY: every processor of this target has NEON, and nothing is read but the arguments.
        unsafe { vbslq_f32(vdupq_n_u32(1 << 31), b, a) }
    }

    #[inline(always)]
    pub(crate) fn any(mask: Mask) -> bool {
        // SAFETY: every processor of this target has NEON, and nothing is read but the argument.
        unsafe { vmaxvq_u32(mask) != 0 }
    }

    #[inline(always)]
    pub(crate) fn widened(a: Register) -> (doubles::Register, doubles::Register) {
        // SAFETY: every processor of this target has NEON, and nothing is read but the argument.
        unsafe { (vcvt_f64_f32(vget_low_f32(a)), vcvt_high_f64_f32(a)) }
    }

    #[inline(always)]
    pub(crate) fn transpose([r0, r1, r2, r3]: [Register; 4]) -> [Register; 4] {
        // SAFETY: every processor of this target has NEON, and nothing is read but the arguments.
        unsafe {
            // Pairs of rows interleaved by numbers, then by pairs of numbers.
            let [a0, a1] = [vtrn1q_f32(r0, r1), vtrn2q_f32(r0, r1)].map(|row| vreinterpretq_f64_f32(row));
            let [a2, a3] = [vtrn1q_f32(r2, r3), vtrn2q_f32(r2, r3)].map(|row| vreinterpretq_f64_f32(row));
            [vtrn1q_f64(a0, a2), vtrn1q_f64(a1, a3), vtrn2q_f64(a0, a2), vtrn2q_f64(a1, a3)].map(|row| vreinterpretq_f32_f64(row))
        }
    }
}

/// Two `f64`.
pub(super) mod doubles {
    use std::arch::aarch64::*;

    use super::singles::operations;

    pub(crate) type Register = float64x2_t;
    pub(crate) type Mask = uint64x2_t;

    operations! {
        add(a: Register, b: Register) -> Register = vaddq_f64,
        sub(a: Register, b: Register) -> Register = vsubq_f64,
        mul(a: Register, b: Register) -> Register = vmulq_f64,
        div(a: Register, b: Register) -> Register = vdivq_f64,
        neg(a: Register) -> Register = vnegq_f64,
        sqrt(a: Register) -> Register = vsqrtq_f64,
        abs(a: Register) -> Register = vabsq_f64,
        below(a: Register, b: Register) -> Mask = vcltq_f64,
        at_most(a: Register, b: Register) -> Mask = vcleq_f64,
        both(a: Mask, b: Mask) -> Mask = vandq_u64,
        select(mask: Mask, then: Register, other: Register) -> Register = vbslq_f64,
        firsts(a: Register, b: Register) -> Register = vtrn1q_f64,
        seconds(a: Register, b: Register) -> Register = vtrn2q_f64,
    }

    #[inline(always)]
    pub(crate) fn of(lanes: [f64; 2]) -> Register {
        // SAFETY: the array has two numbers, and the load needs no alignment; every processor of this target has NEON.
        unsafe { vld1q_f64(lanes.as_ptr()) }
    }

    #[inline(always)]
    pub(crate) fn lanes(a: Register) -> [f64; 2] {
        let mut lanes = [0.0; 2];
        // SAFETY: the array has room for two numbers, and the store needs no alignment; every processor of this target has NEON.
        unsafe { vst1q_f64(lanes.as_mut_ptr(), a) };
        lanes
    }

    #[inline(always)]
    pub(crate) fn truths(mask: Mask) -> [bool; 2] {
        // SAFETY: every processor of this target has NEON, and nothing is read but the argument.
        unsafe { [vgetq_lane_u64::<0>(mask) != 0, vgetq_lane_u64::<1>(mask) != 0] }
    }
}

/// Memory cannot be asked for without instructions that the compiler does not offer.
#[inline(always)]
pub(crate) fn prefetch<T: ?Sized>(_: &T) {}
