//! Effective masses of a block's rows.

#![expect(clippy::needless_range_loop, reason = "an index runs over points and lanes of several arrays alike")]

use super::super::body_gather::WideVelocities;
use super::super::contact::{LANES, Lane, POINTS, tangents_in_lanes};
use super::super::contact_block::{BlockView, ContactBlock, MaterialRows, MultiPointRows};
use super::super::state::BodyVelocity;
use super::rows::{BlockManifolds, Faced, Single, load_all};
use crate::lanes::wide::{Wide, Wide3};

/// Share of the greatest diagonal entry that is added to a manifold's matrix before it is inverted.
const REGULARISATION: f32 = 1.0e-3;

/// Share of what a row would answer, if its lever and its direction stood at their best, below which the row is immovable.
///
/// A body with locked axes may be free across a row alone. Rounding turns that direction by some 1e-7, and its square would be an
/// effective mass of 1e14 times the body's, whose impulses overflow.
const IMMOVABLE: f32 = 1.0e-12;

/// Rows and columns of the entries of an inverse, in the order in which a block keeps them.
const ENTRIES: [(usize, usize); 10] = [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

#[inline(always)]
pub(super) fn set<W: Wide>(whole: &mut BlockView<'_>, velocities: &[BodyVelocity]) {
    let BlockView { block, face, extra } = whole;
    let (side_a, side_b) = (WideVelocities::<W>::gather(&block.a, velocities), WideVelocities::<W>::gather(&block.b, velocities));
    let immovable = Immovable::new(&side_a, &side_b);
    match face {
        Some(face) => {
            set_rows(&mut Faced(block, face), extra.as_deref_mut(), &side_a, &side_b, &immovable);
            set_inverse(block, face);
        }
        None => set_rows(&mut Single(block), extra.as_deref_mut(), &side_a, &side_b, &immovable),
    }
    if let Some(extra) = extra.as_deref_mut().filter(|extra| extra.has_rolling) {
        let [t1, t2] = tangents_in_lanes(Wide3::<W>::load(&block.normal));
        let (turn1, turn2) = (side_a.response(t1) + side_b.response(t1), side_a.response(t2) + side_b.response(t2));
        put_inverse2(&mut extra.rolling_mass, t1.dot(turn1), t1.dot(turn2), t2.dot(turn2), immovable.turning);
    }
}

/// Masses of all rows but those of rolling; inverses of manifolds of more than one point.
#[inline(always)]
fn set_rows<W: Wide, M: BlockManifolds>(
    of: &mut M,
    extra: Option<&mut MaterialRows>,
    side_a: &WideVelocities<W>,
    side_b: &WideVelocities<W>,
    immovable: &Immovable<W>,
) {
    let inverse_mass = side_a.inverse_mass() + side_b.inverse_mass();
    let n = Wide3::load(&of.block().normal);
    let [t1, t2] = tangents_in_lanes(n);
    set_normal(of, n, n.dot(inverse_mass.scale(n)), side_a, side_b, immovable);

    let (center_a, center_b) = of.centers::<W>();
    let least = immovable.at(center_a, center_b);
    let (arm_a1, arm_a2) = (center_a.cross(t1), center_a.cross(t2));
    let (arm_b1, arm_b2) = (center_b.cross(t1), center_b.cross(t2));
    let (push1, push2) = (inverse_mass.scale(t1), inverse_mass.scale(t2));
    let (turn_a1, turn_a2) = (side_a.response(arm_a1), side_a.response(arm_a2));
    let (turn_b1, turn_b2) = (side_b.response(arm_b1), side_b.response(arm_b2));
    let m11 = t1.dot(push1) + arm_a1.dot(turn_a1) + arm_b1.dot(turn_b1);
    let m12 = t1.dot(push2) + arm_a1.dot(turn_a2) + arm_b1.dot(turn_b2);
    let m22 = t2.dot(push2) + arm_a2.dot(turn_a2) + arm_b2.dot(turn_b2);
    put_inverse2(&mut of.block_mut().tangent_mass, m11, m12, m22, least);

    if let Some(twist) = of.twist(extra) {
        invert(n.dot(side_a.response(n) + side_b.response(n)), immovable.turning).store(&mut twist.mass);
    }
}

/// Inverse effective masses at or below which a row of two bodies is immovable: [`IMMOVABLE`] of the trace of M⁻¹ − [r]× I⁻¹ [r]×.
struct Immovable<W> {
    moving: W,
    turning_a: W,
    turning_b: W,
    /// Of a row that only turns (1/(kg m²)).
    turning: W,
}

impl<W: Wide> Immovable<W> {
    #[inline(always)]
    fn new(side_a: &WideVelocities<W>, side_b: &WideVelocities<W>) -> Self {
        let share = W::splat(IMMOVABLE);
        let (turning_a, turning_b) = (share * side_a.inverse_inertia.trace(), share * side_b.inverse_inertia.trace());
        let inverse_mass = side_a.inverse_mass() + side_b.inverse_mass();
        let moving = share * (inverse_mass.x + inverse_mass.y + inverse_mass.z);
        Self { moving, turning_a, turning_b, turning: turning_a + turning_b }
    }

    /// Of a row along a line through points at these levers (1/kg).
    #[inline(always)]
    fn at(&self, lever_a: Wide3<W>, lever_b: Wide3<W>) -> W {
        self.moving + self.turning_a * lever_a.dot(lever_a) + self.turning_b * lever_b.dot(lever_b)
    }
}

/// A_ij = n·M⁻¹n + (r_i×n)·I⁻¹(r_j×n), summed over both sides, and its inverses.
#[inline(always)]
fn set_normal<W: Wide, M: BlockManifolds>(
    of: &mut M,
    n: Wide3<W>,
    along_normal: W,
    side_a: &WideVelocities<W>,
    side_b: &WideVelocities<W>,
    immovable: &Immovable<W>,
) {
    let zero = W::zero();
    let mut exists = [[0.0; LANES]; POINTS];
    for i in 0..M::COUNT {
        for l in 0..LANES {
            exists[i][l] = f32::from(u8::from(i < usize::from(of.block().count[l])));
        }
    }
    let exists = load_all::<W, POINTS>(&exists);
    let mut torque = [(Wide3::zero(), Wide3::zero()); POINTS];
    let mut least = [zero; POINTS];
    for i in 0..M::COUNT {
        let (lever_a, lever_b) = (Wide3::load(&of.rows(i).lever_a), Wide3::load(&of.rows(i).lever_b));
        torque[i] = (lever_a.cross(n), lever_b.cross(n));
        least[i] = immovable.at(lever_a, lever_b);
    }
    let mut pair = 0;
    for i in 0..M::COUNT {
        let (turn_a, turn_b) = (side_a.response(torque[i].0), side_b.response(torque[i].1));
        let entry = along_normal + turn_a.dot(torque[i].0) + turn_b.dot(torque[i].1);
        let diagonal = W::select(exists[i].above(zero), entry, zero);
        invert(diagonal, least[i]).store(&mut of.rows_mut(i).inverse_diagonal);
        let Some(face) = of.face_mut() else { continue };
        diagonal.store(&mut face.diagonal[i]);
        for j in i + 1..M::COUNT {
            // Points exist in order: where j does, i does.
            let entry = along_normal + turn_a.dot(torque[j].0) + turn_b.dot(torque[j].1);
            W::select(exists[j].above(zero), entry, zero).store(&mut face.coupling[pair]);
            pair += 1;
        }
    }
}

/// Inverts the matrix of each lane. Four points of a face have a matrix of rank three; [`REGULARISATION`] makes it regular and picks
/// the multipliers of least norm. A = L D Lᵀ, A⁻¹ = Mᵀ D⁻¹ M with M = L⁻¹, in `f64`.
#[inline(always)]
fn set_inverse(block: &ContactBlock, face: &mut MultiPointRows) {
    let MultiPointRows { more: [second, third, fourth], diagonal, coupling, inverse: lanes, .. } = face;
    let rows = [&block.first, second, third, fourth];
    for l in 0..LANES {
        let extra =
            f64::from(diagonal.iter().fold(0.0_f32, |most, lane| if lane[l] > most { lane[l] } else { most }) * REGULARISATION);
        // No row may be left out that has a diagonal: where all points press, the inverse alone solves them.
        let exists = [0, 1, 2, 3].map(|i: usize| rows[i].inverse_diagonal[l] > 0.0);
        let d = [0, 1, 2, 3].map(|i: usize| if exists[i] { f64::from(diagonal[i][l]) + extra } else { 1.0 });
        let [c01, c02, c03, c12, c13, c23] = coupling.map(|lane| f64::from(lane[l]));

        let g0 = 1.0 / d[0];
        let (l10, l20, l30) = (c01 * g0, c02 * g0, c03 * g0);
        let g1 = 1.0 / (d[1] - l10 * c01);
        let (e12, e13) = (c12 - l10 * c02, c13 - l10 * c03);
        let (l21, l31) = (e12 * g1, e13 * g1);
        let g2 = 1.0 / (d[2] - l20 * c02 - l21 * e12);
        let e23 = c23 - l20 * c03 - l21 * e13;
        let l32 = e23 * g2;
        let g3 = 1.0 / (d[3] - l30 * c03 - l31 * e13 - l32 * e23);

        let (m10, m21, m32) = (-l10, -l21, -l32);
        let m20 = -l20 - l21 * m10;
        let m31 = -l31 - l32 * m21;
        let m30 = -l30 - l31 * m10 - l32 * m20;
        let entries = [
            g0 + m10 * m10 * g1 + m20 * m20 * g2 + m30 * m30 * g3,
            g1 + m21 * m21 * g2 + m31 * m31 * g3,
            g2 + m32 * m32 * g3,
            g3,
            m10 * g1 + m20 * m21 * g2 + m30 * m31 * g3,
            m20 * g2 + m30 * m32 * g3,
            m30 * g3,
            m21 * g2 + m31 * m32 * g3,
            m31 * g3,
            m32 * g3,
        ];
        for (k, (i, j)) in ENTRIES.into_iter().enumerate() {
            lanes[k][l] = if exists[i] && exists[j] { entries[k] as f32 } else { 0.0 };
        }
    }
}

#[inline(always)]
fn invert<W: Wide>(x: W, least: W) -> W {
    W::select(x.above(least), W::splat(1.0) / x, W::zero())
}

/// Inverse of [[m11, m12], [m12, m22]]: 11, 12, 22.
///
/// Bodies that cannot move along one direction make a matrix of rank one, λ v vᵀ with λ its trace: its inverse along v alone is the
/// matrix over λ², so that friction works along what is free. Where λ is not above `least` both rows are left out.
#[inline(always)]
fn put_inverse2<W: Wide>(lanes: &mut [Lane; 3], m11: W, m12: W, m22: W, least: W) {
    let (zero, one) = (W::zero(), W::splat(1.0));
    let (determinant, trace) = (m11 * m22 - m12 * m12, m11 + m22);
    let is_regular = determinant.above((W::splat(f32::EPSILON) * m11 * m22).max(least * m11.max(m22)));
    let scale = W::select(is_regular, one / determinant, zero);
    let along = W::select(trace.above(least), one / trace, zero);
    W::select(is_regular, m22 * scale, m11 * along * along).store(&mut lanes[0]);
    W::select(is_regular, -m12 * scale, m12 * along * along).store(&mut lanes[1]);
    W::select(is_regular, m11 * scale, m22 * along * along).store(&mut lanes[2]);
}
