//! The active rows of a system packed side by side: four rows a register.
//!
//! A node's rows fill lanes, with zeros behind. Of each of the two bodies it holds J as six lists (linear x, y, z, angular x, y, z),
//! one number a row, and I⁻¹ Jᵀ as three; of M⁻¹ Jᵀ the linear part is one factor more. So a block J_i M̃⁻¹ J_jᵀ is nine products
//! of a number with lanes for each row of i.

#![expect(clippy::needless_range_loop, reason = "an index runs over axes, sides and lanes alike")]

use std::ops::Range;

use glam::DVec3;

use super::block::{self, Lanes, MAX_ROWS, ZERO, add_product, add_scaled, width};
use super::body::DirectBody;
use super::factor::BlockFactor;
use super::row::{Row, RowState};
use super::topology::{SystemNode, Topology};
use crate::platform::dispatched;
use crate::solve::joint::rows::Rate;

/// Rows that take part, by node; lanes of a node are those of its vectors in the [`BlockFactor`].
#[derive(Debug, Clone, Default)]
pub(super) struct PackedRows {
    /// J, twelve lists a node, and I⁻¹ Jᵀ, six.
    jacobian: Vec<Lanes>,
    response: Vec<Lanes>,
    bias: Vec<Lanes>,
    gamma: Vec<Lanes>,
    /// Shares of the diagonal that are added to it, and below which pivots are noise.
    added: Vec<Lanes>,
    noise: Vec<Lanes>,
    pub impulse: Vec<Lanes>,
    /// Row in each place.
    pub index: Vec<[u32; 4]>,
}

/// No row.
const NONE: u32 = u32::MAX;

impl PackedRows {
    /// Chooses the rows that are free; `counts` becomes how many each node has.
    pub(super) fn choose(&mut self, nodes: &[SystemNode], rows: &[Row], counts: &mut Vec<u32>) {
        counts.clear();
        self.index.clear();
        for node in nodes {
            let mut count = 0;
            for number in (node.first..node.last).filter(|&row| rows[row as usize].state == RowState::Free) {
                match self.index.last_mut() {
                    Some(lane) if count % 4 != 0 => lane[count % 4] = number,
                    _ => self.index.push([number, NONE, NONE, NONE]),
                }
                count += 1;
            }
            counts.push(count as u32);
        }
        let lanes = self.index.len();
        self.jacobian.resize(12 * lanes, ZERO);
        self.response.resize(6 * lanes, ZERO);
        self.bias.resize(lanes, ZERO);
        self.gamma.resize(lanes, ZERO);
        self.added.resize(lanes, ZERO);
        self.noise.resize(lanes, ZERO);
    }

    /// Takes the biases of the rows anew.
    pub(super) fn take_biases(&mut self, rows: &[Row]) {
        for (&row, bias) in self.index.iter().flatten().zip(self.bias.iter_mut().flatten()) {
            if row != NONE {
                *bias = rows[row as usize].bias;
            }
        }
    }

    /// Writes what has been added to the diagonal of each row that does not give, times its multiplier.
    pub(super) fn find_added(&self, factor: &BlockFactor, added: &mut [Lanes]) {
        for (lane, into) in added.iter_mut().enumerate() {
            let (share, noise, least) = (&self.added[lane], &self.noise[lane], &factor.least[lane]);
            for j in 0..4 {
                // The pivot that is noise is a share of the diagonal; where there is no row there is none.
                let gives = self.gamma[lane][j] > 0.0 || noise[j] == 0.0;
                into[j] = if gives { 0.0 } else { share[j] / noise[j] * least[j] * self.impulse[lane][j] };
            }
        }
    }

    /// Hands the multipliers back to the rows.
    pub(super) fn unpack(&self, rows: &mut [Row]) {
        for (&row, &impulse) in self.index.iter().flatten().zip(self.impulse.iter().flatten()) {
            if row != NONE {
                rows[row as usize].impulse = impulse;
            }
        }
    }
}

dispatched!(
    /// Writes the rows that have been chosen into their lanes.
    pack, pack_body,
    (packed_rows: &mut PackedRows, nodes: &[SystemNode], rows: &[Row], factor: &BlockFactor, topology: &Topology, bodies: &[DirectBody])
);

dispatched!(
    /// Forms J M̃⁻¹ Jᵀ + γ, slightly regularised.
    assemble, assemble_body,
    (factor: &mut BlockFactor, packed_rows: &PackedRows, nodes: &[SystemNode], topology: &Topology, bodies: &[DirectBody])
);

dispatched!(
    /// Writes what the rows still lack, −(J v + b + γ p); returns the greatest.
    find_residuals, find_residuals_body,
    (residuals: &mut [Lanes], packed_rows: &PackedRows, nodes: &[SystemNode], factor: &BlockFactor, rates: &[Rate]) -> f64
);

dispatched!(
    /// Adds a share of the increments to the multipliers, and their push to the rates.
    add_impulses, add_impulses_body,
    (packed_rows: &mut PackedRows, increments: &[Lanes], share: f64, nodes: &[SystemNode], factor: &BlockFactor, bodies: &[DirectBody],
     rates: &mut [Rate])
);

#[inline(always)]
fn pack_body(
    packed_rows: &mut PackedRows,
    nodes: &[SystemNode],
    rows: &[Row],
    factor: &BlockFactor,
    topology: &Topology,
    bodies: &[DirectBody],
) {
    let PackedRows { jacobian, response, bias, gamma, added, noise, index, .. } = packed_rows;
    for (number, node) in nodes.iter().enumerate() {
        let lanes = factor.lanes(number);
        let w = lanes.len();
        let jacobian = &mut jacobian[12 * lanes.start..12 * lanes.end];
        let response = &mut response[6 * lanes.start..6 * lanes.end];
        let [a, b] = [&bodies[node.bodies[0] as usize], &bodies[node.bodies[1] as usize]];
        let inertias = [a.inverse_inertia.to_cols_array_2d(), b.inverse_inertia.to_cols_array_2d()];
        for lane in 0..w {
            let mut own = [&Row::EMPTY; 4];
            for j in 0..4 {
                let row = index[lanes.start + lane][j];
                if row != NONE {
                    own[j] = &rows[row as usize];
                }
            }
            bias[lanes.start + lane] = [own[0].bias, own[1].bias, own[2].bias, own[3].bias];
            gamma[lanes.start + lane] = [own[0].gamma, own[1].gamma, own[2].gamma, own[3].gamma];
            let regularizations = own.map(|row| &topology.regularizations[row.repeats as usize]);
            added[lanes.start + lane] = regularizations.map(|guard| guard.added);
            noise[lanes.start + lane] = regularizations.map(|guard| guard.noise);
            for side in 0..2 {
                let linear = side_by_side(&[own[0].linear[side], own[1].linear[side], own[2].linear[side], own[3].linear[side]]);
                let angular =
                    side_by_side(&[own[0].angular[side], own[1].angular[side], own[2].angular[side], own[3].angular[side]]);
                for axis in 0..3 {
                    jacobian[(side * 6 + axis) * w + lane] = linear[axis];
                    jacobian[(side * 6 + 3 + axis) * w + lane] = angular[axis];
                    let mut answer = ZERO;
                    for other in 0..3 {
                        add_scaled(&mut answer, inertias[side][other][axis], &angular[other]);
                    }
                    response[(side * 3 + axis) * w + lane] = answer;
                }
            }
        }
    }
}

/// The components of four vectors, by axis.
#[inline(always)]
fn side_by_side(v: &[DVec3; 4]) -> [Lanes; 3] {
    [[v[0].x, v[1].x, v[2].x, v[3].x], [v[0].y, v[1].y, v[2].y, v[3].y], [v[0].z, v[1].z, v[2].z, v[3].z]]
}

#[inline(always)]
fn assemble_body(
    factor: &mut BlockFactor,
    packed_rows: &PackedRows,
    nodes: &[SystemNode],
    topology: &Topology,
    bodies: &[DirectBody],
) {
    for (number, node) in nodes.iter().enumerate() {
        let (lanes, k) = (factor.lanes(number), factor.rows(number));
        let w = lanes.len();
        let block = &mut factor.block_mut(topology.plan.diagonal(number))[..k * w];
        for side in 0..2 {
            let (mass, own) = (bodies[node.bodies[side] as usize].inverse_mass, packed_rows.half(&lanes, side));
            if w == 1 { add_narrow(block, &own, &own, mass) } else { add_wide(block, &own, &own, mass) }
        }
        let mut least = [ZERO; width(MAX_ROWS)];
        for i in 0..k {
            let (lane, j) = (lanes.start + i / 4, i % 4);
            let diagonal = &mut block[i * w + i / 4][i % 4];
            *diagonal += packed_rows.gamma[lane][j] + packed_rows.added[lane][j] * *diagonal;
            least[i / 4][j] = packed_rows.noise[lane][j] * *diagonal;
        }
        factor.least[lanes].copy_from_slice(&least[..w]);
    }
    for coupling in &topology.couplings {
        let (late, early) = (factor.lanes(coupling.late as usize), factor.lanes(coupling.early as usize));
        let (m, w) = (factor.rows(coupling.late as usize), early.len());
        let rows = packed_rows.half(&late, coupling.late_side as usize);
        let columns = packed_rows.half(&early, coupling.early_side as usize);
        let mass = bodies[coupling.body as usize].inverse_mass;
        let block = &mut factor.block_mut(coupling.start)[..m * w];
        if late.len() == 1 && w == 1 { add_narrow(block, &rows, &columns, mass) } else { add_wide(block, &rows, &columns, mass) }
    }
}

/// What the rows of a node do to one of its bodies: three lists each.
struct Half<'a> {
    linear: &'a [Lanes],
    angular: &'a [Lanes],
    response: &'a [Lanes],
}

impl PackedRows {
    #[inline(always)]
    fn half(&self, lanes: &Range<usize>, side: usize) -> Half<'_> {
        let w = lanes.len();
        let (linear, response) = (12 * lanes.start + 6 * side * w, 6 * lanes.start + 3 * side * w);
        Half {
            linear: &self.jacobian[linear..linear + 3 * w],
            angular: &self.jacobian[linear + 3 * w..linear + 6 * w],
            response: &self.response[response..response + 3 * w],
        }
    }
}

/// The first N lists of W lanes each.
#[inline(always)]
fn lists<const W: usize, const N: usize>(lanes: &[Lanes]) -> &[[Lanes; W]; N] {
    lanes.as_chunks::<W>().0.first_chunk().expect("a node has as many lists of as many lanes as it has been counted")
}

/// Adds J_i M̃⁻¹ J_jᵀ over one body to a block of nodes of one lane.
#[inline(always)]
fn add_narrow(block: &mut [Lanes], rows: &Half, columns: &Half, mass: DVec3) {
    let (linear, angular) = (lists::<1, 3>(rows.linear), lists::<1, 3>(rows.angular));
    let (push, turn) = (lists::<1, 3>(columns.linear), lists::<1, 3>(columns.response));
    for (i, row) in block.iter_mut().enumerate().take(4) {
        let mut sum = *row;
        add_scaled(&mut sum, mass.x * linear[0][0][i], &push[0][0]);
        add_scaled(&mut sum, mass.y * linear[1][0][i], &push[1][0]);
        add_scaled(&mut sum, mass.z * linear[2][0][i], &push[2][0]);
        add_scaled(&mut sum, angular[0][0][i], &turn[0][0]);
        add_scaled(&mut sum, angular[1][0][i], &turn[1][0]);
        add_scaled(&mut sum, angular[2][0][i], &turn[2][0]);
        *row = sum;
    }
}

/// As [`add_narrow`], for nodes of any width.
#[inline(always)]
fn add_wide(block: &mut [Lanes], rows: &Half, columns: &Half, mass: DVec3) {
    match columns.linear.len() / 3 {
        // A joint of which no row takes part.
        0 => {}
        1 => add_wide_of::<1>(block, rows, columns, mass),
        2 => add_wide_of::<2>(block, rows, columns, mass),
        _ => add_wider(block, rows, columns, mass),
    }
}

/// As [`add_wider`], for W lanes of columns.
#[inline(always)]
fn add_wide_of<const W: usize>(block: &mut [Lanes], rows: &Half, columns: &Half, mass: DVec3) {
    let (push, turn) = (*lists::<W, 3>(columns.linear), *lists::<W, 3>(columns.response));
    let (row_w, mass) = (rows.linear.len() / 3, [mass.x, mass.y, mass.z]);
    for (i, row) in block.as_chunks_mut::<W>().0.iter_mut().enumerate() {
        let mut sum = *row;
        for axis in 0..3 {
            let at = axis * row_w + i / 4;
            let (along, about) = (mass[axis] * rows.linear[at][i % 4], rows.angular[at][i % 4]);
            for lane in 0..W {
                add_scaled(&mut sum[lane], along, &push[axis][lane]);
                add_scaled(&mut sum[lane], about, &turn[axis][lane]);
            }
        }
        *row = sum;
    }
}

#[inline(always)]
fn add_wider(block: &mut [Lanes], rows: &Half, columns: &Half, mass: DVec3) {
    let (row_w, w) = (rows.linear.len() / 3, columns.linear.len() / 3);
    let mass = [mass.x, mass.y, mass.z];
    for (i, row) in block.chunks_exact_mut(w).enumerate() {
        for (lane, into) in row.iter_mut().enumerate() {
            let mut sum = *into;
            for axis in 0..3 {
                let at = axis * row_w + i / 4;
                add_scaled(&mut sum, mass[axis] * rows.linear[at][i % 4], &columns.linear[axis * w + lane]);
                add_scaled(&mut sum, rows.angular[at][i % 4], &columns.response[axis * w + lane]);
            }
            *into = sum;
        }
    }
}

/// Calls a kernel of constant width for a node of one or two lanes, and one of any width for others; none where no row takes part.
macro_rules! by_width {
    ($w:expr, $narrow:ident, $any:ident, ($($arg:expr),*)) => {
        match $w {
            0 => {}
            1 => $narrow::<1>($($arg),*),
            2 => $narrow::<2>($($arg),*),
            _ => $any($($arg),*),
        }
    };
}

/// The speeds of a node's two bodies, in the order of its lists.
#[inline(always)]
fn speeds_of(node: &SystemNode, rates: &[Rate]) -> [f64; 12] {
    let (a, b) = (&rates[node.bodies[0] as usize], &rates[node.bodies[1] as usize]);
    let [al, aa, bl, ba] = [a.linear, a.angular, b.linear, b.angular];
    [al.x, al.y, al.z, aa.x, aa.y, aa.z, bl.x, bl.y, bl.z, ba.x, ba.y, ba.z]
}

#[inline(always)]
fn find_residuals_body(
    residuals: &mut [Lanes],
    packed_rows: &PackedRows,
    nodes: &[SystemNode],
    factor: &BlockFactor,
    rates: &[Rate],
) -> f64 {
    let mut worst = ZERO;
    for (number, node) in nodes.iter().enumerate() {
        let lanes = factor.lanes(number);
        let speeds = speeds_of(node, rates);
        by_width!(
            lanes.len(),
            find_residuals_of,
            find_residuals_any,
            (&mut residuals[lanes.clone()], packed_rows, lanes, &speeds, &mut worst)
        );
    }
    worst[0].max(worst[1]).max(worst[2].max(worst[3]))
}

/// Of a node of W lanes.
#[inline(always)]
fn find_residuals_of<const W: usize>(
    residuals: &mut [Lanes],
    packed_rows: &PackedRows,
    lanes: Range<usize>,
    speeds: &[f64; 12],
    worst: &mut Lanes,
) {
    let jacobian = lists::<W, 12>(&packed_rows.jacobian[12 * lanes.start..]);
    let [bias, gamma, impulse] =
        [&packed_rows.bias, &packed_rows.gamma, &packed_rows.impulse].map(|list| lists::<W, 1>(&list[lanes.start..])[0]);
    let residuals: &mut [Lanes; W] = residuals.first_chunk_mut().expect("a node has as many lanes as it has been counted");
    for lane in 0..W {
        let mut lack = bias[lane];
        add_product(&mut lack, &gamma[lane], &impulse[lane]);
        for part in 0..12 {
            add_scaled(&mut lack, speeds[part], &jacobian[part][lane]);
        }
        residuals[lane] = lacking(lack, worst);
    }
}

#[inline(always)]
fn find_residuals_any(
    residuals: &mut [Lanes],
    packed_rows: &PackedRows,
    lanes: Range<usize>,
    speeds: &[f64; 12],
    worst: &mut Lanes,
) {
    let w = lanes.len();
    let jacobian = &packed_rows.jacobian[12 * lanes.start..12 * lanes.end];
    for (own, lane) in lanes.enumerate() {
        let mut lack = packed_rows.bias[lane];
        add_product(&mut lack, &packed_rows.gamma[lane], &packed_rows.impulse[lane]);
        for part in 0..12 {
            add_scaled(&mut lack, speeds[part], &jacobian[part * w + own]);
        }
        residuals[own] = lacking(lack, worst);
    }
}

/// What rows with these errors lack; `worst` is kept up to date.
#[inline(always)]
fn lacking(mut errors: Lanes, worst: &mut Lanes) -> Lanes {
    for j in 0..4 {
        let size = errors[j].abs();
        worst[j] = if size > worst[j] { size } else { worst[j] };
        errors[j] = -errors[j];
    }
    errors
}

#[inline(always)]
fn add_impulses_body(
    packed_rows: &mut PackedRows,
    increments: &[Lanes],
    share: f64,
    nodes: &[SystemNode],
    factor: &BlockFactor,
    bodies: &[DirectBody],
    rates: &mut [Rate],
) {
    for (number, node) in nodes.iter().enumerate() {
        let lanes = factor.lanes(number);
        let increments = &increments[lanes.clone()];
        for side in 0..2 {
            let body = node.bodies[side] as usize;
            let own = packed_rows.half(&lanes, side);
            let mut sums = [ZERO; 6];
            by_width!(increments.len(), push_of, push_any, (&own, increments, &mut sums));
            let [x, y, z, about_x] = block::sums(&[sums[0], sums[1], sums[2], sums[3]]);
            let [about_y, about_z, ..] = block::sums(&[sums[4], sums[5], ZERO, ZERO]);
            rates[body].linear += bodies[body].inverse_mass * DVec3::new(x, y, z) * share;
            rates[body].angular += DVec3::new(about_x, about_y, about_z) * share;
        }
        for (impulse, increment) in packed_rows.impulse[lanes].iter_mut().zip(increments) {
            add_scaled(impulse, share, increment);
        }
    }
}

/// What increments of W lanes push on one body, linear and angular.
#[inline(always)]
fn push_of<const W: usize>(own: &Half, increments: &[Lanes], sums: &mut [Lanes; 6]) {
    let (linear, response) = (lists::<W, 3>(own.linear), lists::<W, 3>(own.response));
    let increments = &lists::<W, 1>(increments)[0];
    for axis in 0..3 {
        for lane in 0..W {
            add_product(&mut sums[axis], &increments[lane], &linear[axis][lane]);
            add_product(&mut sums[3 + axis], &increments[lane], &response[axis][lane]);
        }
    }
}

#[inline(always)]
fn push_any(own: &Half, increments: &[Lanes], sums: &mut [Lanes; 6]) {
    let w = increments.len();
    for axis in 0..3 {
        for lane in 0..w {
            add_product(&mut sums[axis], &increments[lane], &own.linear[axis * w + lane]);
            add_product(&mut sums[3 + axis], &increments[lane], &own.response[axis * w + lane]);
        }
    }
}
