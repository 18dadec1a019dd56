//! Rows and factor of up to four articulations of one structure, one lane each: the arithmetic of [`system`](super::system) and
//! [`factor`](super::factor) without sums or transpositions across lanes.
//!
//! Every number has four lanes, so that a block of k × m is k m lanes, where rows of one articulation side by side fill lanes with sums
//! that must be taken apart again. A node has as many rows here as the member that has most of them; what a member lacks are rows
//! of zeros, whose pivots are not sound and whose multipliers stay zero. No lane reads another: a member's numbers do not depend on who
//! goes beside it.

use super::block::{Lanes, MAX_ROWS, ZERO};
use super::factor::BlockLayout;
use super::redundancy::Regularization;
use super::topology::{SystemNode, Topology};
use crate::lanes::four::Four;
use crate::platform::in_fours;

/// Numbers of a row over its two bodies: linear x, y, z, angular x, y, z of each.
pub(super) const PARTS: usize = 12;

/// Inverse masses along the axes, then the columns of the inverse inertia.
pub(super) const MASSES: usize = 12;

/// Lanes of a block for each of its lanes in a [`BlockLayout`], which holds four numbers of one articulation.
const SPREAD: usize = 4;

/// What is known of the rows and bodies of all members.
#[derive(Debug, Default)]
pub(super) struct InterleavedSystem {
    /// Rows of each node, and the first row of each and one past the last.
    pub counts: Vec<u32>,
    pub starts: Vec<u32>,
    /// J and M̃⁻¹ Jᵀ, by row.
    pub jacobian: Vec<[Lanes; PARTS]>,
    response: Vec<[Lanes; PARTS]>,
    pub bias: Vec<Lanes>,
    pub gamma: Vec<Lanes>,
    pub impulse: Vec<Lanes>,
    /// By body.
    pub masses: Vec<[Lanes; MASSES]>,
    /// Linear and angular velocity, by body.
    pub rates: Vec<[Lanes; 6]>,
    /// The matrix, then its factor, and the pivots up to which a row has no multiplier.
    values: Vec<Lanes>,
    least: Vec<Lanes>,
    unknowns: Vec<Lanes>,
}

impl InterleavedSystem {
    /// Makes room for the rows of each node that have been counted, and so many bodies; what was there before stays.
    pub(super) fn start(&mut self, bodies: usize) {
        self.starts.clear();
        let mut next = 0;
        for &count in &self.counts {
            self.starts.push(next);
            next += count;
        }
        self.starts.push(next);
        let rows = next as usize;
        self.jacobian.resize(rows, [ZERO; PARTS]);
        self.response.resize(rows, [ZERO; PARTS]);
        self.least.resize(rows, ZERO);
        self.unknowns.resize(rows, ZERO);
        for list in [&mut self.bias, &mut self.gamma, &mut self.impulse] {
            list.resize(rows, ZERO);
        }
        self.masses.resize(bodies, [ZERO; MASSES]);
        self.rates.resize(bodies, [ZERO; 6]);
    }

    /// Rows of a node.
    #[inline(always)]
    pub(super) fn rows(&self, node: usize) -> std::ops::Range<usize> {
        self.starts[node] as usize..self.starts[node + 1] as usize
    }
}

in_fours!(
    /// Forms M̃⁻¹ Jᵀ.
    pub(super) respond, self::respond_body, (interleaved: &mut InterleavedSystem, nodes: &[SystemNode])
);

in_fours!(
    /// Forms J M̃⁻¹ Jᵀ + γ, slightly regularised, and factorises it.
    pub(super) factorize, self::factorize_body,
    (interleaved: &mut InterleavedSystem, nodes: &[SystemNode], topology: &Topology)
);

in_fours!(
    /// Adds the push of the multipliers of these lanes to the rates.
    pub(super) push, self::push_body,
    (interleaved: &mut InterleavedSystem, nodes: &[SystemNode], lanes: &[bool; 4])
);

in_fours!(
    /// Adds to the multipliers of these lanes what the rows lack, and its push to the rates; returns what they lacked, the greatest of
    /// each.
    pub(super) solve, self::solve_body,
    (interleaved: &mut InterleavedSystem, nodes: &[SystemNode], plan: &BlockLayout, lanes: &[bool; 4]) -> Lanes
);

in_fours!(
    /// Writes what the rows of these lanes lack, −(J v + b + γ p), as the unknowns; returns the greatest of each.
    pub(super) find_errors, self::find_errors_body,
    (interleaved: &mut InterleavedSystem, nodes: &[SystemNode], lanes: &[bool; 4]) -> Lanes
);

#[inline(always)]
fn respond_body<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode]) {
    for (number, node) in nodes.iter().enumerate() {
        let rows = interleaved.rows(number);
        for side in 0..2 {
            let masses = &interleaved.masses[node.bodies[side] as usize];
            for (row, response) in interleaved.jacobian[rows.clone()].iter().zip(&mut interleaved.response[rows.clone()]) {
                let row: [F; 6] = loaded(half(row, side));
                for axis in 0..3 {
                    response[6 * side + axis] = (F::load(&masses[axis]) * row[axis]).lanes();
                    let (of_x, of_y, of_z) = (&masses[3 + axis], &masses[6 + axis], &masses[9 + axis]);
                    let about = F::load(of_x) * row[3] + F::load(of_y) * row[4] + F::load(of_z) * row[5];
                    response[6 * side + 3 + axis] = about.lanes();
                }
            }
        }
    }
}

/// Calls a function for a node of so many rows, compiled for the counts that joints have, so that its inner loops have constant lengths.
macro_rules! by_rows {
    ($k:expr, $function:ident, ($($argument:expr),*)) => {
        match $k {
            0 => {}
            1 => $function::<F, 1>($($argument),*),
            2 => $function::<F, 2>($($argument),*),
            3 => $function::<F, 3>($($argument),*),
            4 => $function::<F, 4>($($argument),*),
            5 => $function::<F, 5>($($argument),*),
            6 => $function::<F, 6>($($argument),*),
            _ => $function::<F, ANY>($($argument),*),
        }
    };
}

/// Stands for a number of rows that is not known before.
const ANY: usize = 0;

#[inline(always)]
const fn known<const K: usize>(rows: usize) -> usize {
    if K == ANY { rows } else { K }
}

#[inline(always)]
fn factorize_body<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode], topology: &Topology) {
    assemble::<F>(interleaved, nodes, topology);
    let mut targets = topology.plan.targets();
    for (place, &node) in topology.plan.order().iter().enumerate() {
        let coupled = topology.plan.column(place).len();
        let (own, later) = targets.split_at(coupled * (coupled + 1) / 2);
        targets = later;
        by_rows!(interleaved.counts[node as usize], eliminate, (interleaved, &topology.plan, place, own));
    }
}

/// Eliminates the node at a place, of K rows.
#[inline(always)]
fn eliminate<F: Four, const K: usize>(interleaved: &mut InterleavedSystem, plan: &BlockLayout, place: usize, targets: &[u32]) {
    let InterleavedSystem { counts, starts, values, least, .. } = interleaved;
    let (node, column) = (plan.order()[place] as usize, plan.column(place));
    let k = known::<K>(counts[node] as usize);
    let own = SPREAD * plan.diagonal(node) as usize;
    invert_root::<F, K>(&mut values[own..own + k * k], &least[starts[node] as usize..starts[node + 1] as usize]);
    for &(other, start) in column {
        let (m, start) = (counts[other as usize] as usize, SPREAD * start as usize);
        let (early, late) = values.split_at_mut(start);
        multiply_by_root::<F, K>(&mut late[..m * k], &early[own..own + k * k]);
    }
    let mut targets = targets.iter();
    for (i, &(upper, upper_start)) in column.iter().enumerate() {
        let n = counts[upper as usize] as usize;
        for (&(lower, lower_start), &into) in column[i..].iter().zip(&mut targets) {
            let m = counts[lower as usize] as usize;
            if m == 0 || n == 0 {
                continue;
            }
            // Columns are stored one after another, and a target belongs to a later one.
            let (early, late) = values.split_at_mut(SPREAD * into as usize);
            let l = &early[SPREAD * lower_start as usize..][..m * k];
            let u = &early[SPREAD * upper_start as usize..][..n * k];
            for (into, row) in late[..m * n].chunks_exact_mut(n).zip(l.chunks_exact(k)) {
                for (into, other) in into.iter_mut().zip(u.chunks_exact(k)) {
                    *into = minus_dot(F::load(into), row, other).lanes();
                }
            }
        }
    }
}

#[inline(always)]
fn assemble<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode], topology: &Topology) {
    let Topology { plan, couplings, regularizations, .. } = topology;
    let InterleavedSystem { counts, starts, jacobian, response, gamma, values, least, .. } = interleaved;
    values.resize(SPREAD * plan.numbers() / 4, ZERO);
    for place in 0..nodes.len() {
        let k = counts[plan.order()[place] as usize] as usize;
        for &(other, start) in plan.column(place) {
            values[SPREAD * start as usize..][..counts[other as usize] as usize * k].fill(ZERO);
        }
    }
    // Where no joints close a loop, the guards of all rows are alike; friction here takes its part of what others hold as well.
    let [Regularization { added, noise }, ..] = regularizations;
    let (grown, noise) = (F::splat(1.0 + added), F::splat(*noise));
    for number in 0..nodes.len() {
        let (k, first) = (counts[number] as usize, starts[number] as usize);
        let start = SPREAD * plan.diagonal(number) as usize;
        let block = &mut values[start..start + k * k];
        for i in 0..k {
            let (a, b): ([F; 6], [F; 6]) = (loaded(half(&jacobian[first + i], 0)), loaded(half(&jacobian[first + i], 1)));
            for j in 0..=i {
                let column = &response[first + j];
                block[i * k + j] = plus_dot(plus_dot(F::splat(0.0), &a, half(column, 0)), &b, half(column, 1)).lanes();
            }
            let own = F::load(&block[i * k + i]) * grown + F::load(&gamma[first + i]);
            block[i * k + i] = own.lanes();
            least[first + i] = (noise * own).lanes();
        }
    }
    for coupling in couplings {
        let (late, early) = (coupling.late as usize, coupling.early as usize);
        let (m, k) = (counts[late] as usize, counts[early] as usize);
        let start = SPREAD * coupling.start as usize;
        let block = &mut values[start..start + m * k];
        for i in 0..m {
            let row: [F; 6] = loaded(half(&jacobian[starts[late] as usize + i], coupling.late_side as usize));
            for j in 0..k {
                let column = half(&response[starts[early] as usize + j], coupling.early_side as usize);
                block[i * k + j] = plus_dot(F::load(&block[i * k + j]), &row, column).lanes();
            }
        }
    }
}

/// Numbers of a row over one of its bodies.
#[inline(always)]
fn half(row: &[Lanes; PARTS], side: usize) -> &[Lanes; 6] {
    row[6 * side..].first_chunk().expect("a row has six numbers over each of its bodies")
}

#[inline(always)]
fn loaded<F: Four>(numbers: &[Lanes; 6]) -> [F; 6] {
    let [a, b, c, d, e, f] = numbers;
    [F::load(a), F::load(b), F::load(c), F::load(d), F::load(e), F::load(f)]
}

#[inline(always)]
fn plus_dot<F: Four>(mut sum: F, a: &[F; 6], b: &[Lanes; 6]) -> F {
    for part in 0..6 {
        sum = sum + a[part] * F::load(&b[part]);
    }
    sum
}

#[inline(always)]
fn minus_dot<F: Four>(mut sum: F, a: &[Lanes], b: &[Lanes]) -> F {
    for (a, b) in a.iter().zip(b) {
        sum = sum - F::load(a) * F::load(b);
    }
    sum
}

/// Turns symmetric positive definite matrices A, lower triangles, into U = L⁻ᵀ, with A = L Lᵀ; a row whose pivot is not above its `least`
/// gets no multiplier in its lane.
#[inline(always)]
fn invert_root<F: Four, const K: usize>(a: &mut [Lanes], least: &[Lanes]) {
    let k = known::<K>(least.len());
    let (a, least) = (&mut a[..k * k], &least[..k]);
    for j in 0..k {
        let (own, below) = a[j * k..].split_at_mut(k);
        let pivot = minus_dot(F::load(&own[j]), &own[..j], &own[..j]);
        let sound = F::both(F::load(&least[j]).below(pivot), pivot.below(F::splat(f64::INFINITY)));
        let scale = F::select(sound, F::splat(1.0) / pivot.sqrt(), F::splat(0.0));
        for row in below.chunks_exact_mut(k) {
            row[j] = (minus_dot(F::load(&row[j]), &row[..j], &own[..j]) * scale).lanes();
        }
        own[j] = scale.lanes();
    }
    // Row i of L⁻¹ goes where column i of U is: above the diagonal, which holds its own.
    for i in 1..k {
        let (above, row) = a.split_at_mut(i * k);
        let scale = F::load(&row[i]);
        for (j, column) in above.chunks_exact_mut(k).enumerate() {
            column[i] = (minus_dot(F::splat(0.0), &row[j..i], &column[j..i]) * scale).lanes();
        }
    }
}

/// W = A U in place, with U upper triangular of K × K.
#[inline(always)]
fn multiply_by_root<F: Four, const K: usize>(a: &mut [Lanes], root: &[Lanes]) {
    let k = known::<K>(root.len().isqrt());
    let root = &root[..k * k];
    for row in a.chunks_exact_mut(k) {
        for j in (0..k).rev() {
            let mut sum = F::splat(0.0);
            for (number, root) in row[..=j].iter().zip(root[j..].iter().step_by(k)) {
                sum = sum + F::load(number) * F::load(root);
            }
            row[j] = sum.lanes();
        }
    }
}

#[inline(always)]
fn push_body<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode], lanes: &[bool; 4]) {
    let chosen = mask::<F>(lanes);
    let InterleavedSystem { impulse, unknowns, .. } = interleaved;
    for (unknown, impulse) in unknowns.iter_mut().zip(&*impulse) {
        *unknown = F::select(chosen, F::load(impulse), F::splat(0.0)).lanes();
    }
    add_push::<F>(interleaved, nodes);
}

#[inline(always)]
fn mask<F: Four>(lanes: &[bool; 4]) -> F::Mask {
    F::splat(0.0).below(F::of(lanes.map(|chosen| if chosen { 1.0 } else { 0.0 })))
}

/// Adds the push of the unknowns to the rates.
#[inline(always)]
fn add_push<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode]) {
    for (number, node) in nodes.iter().enumerate() {
        let rows = interleaved.rows(number);
        for side in 0..2 {
            let rate = &mut interleaved.rates[node.bodies[side] as usize];
            let mut sums: [F; 6] = loaded(rate);
            for (response, unknown) in interleaved.response[rows.clone()].iter().zip(&interleaved.unknowns[rows.clone()]) {
                let (response, unknown) = (half(response, side), F::load(unknown));
                for part in 0..6 {
                    sums[part] = sums[part] + F::load(&response[part]) * unknown;
                }
            }
            for part in 0..6 {
                rate[part] = sums[part].lanes();
            }
        }
    }
}

#[inline(always)]
fn find_errors_body<F: Four>(interleaved: &mut InterleavedSystem, nodes: &[SystemNode], lanes: &[bool; 4]) -> Lanes {
    let (chosen, mut worst) = (mask::<F>(lanes), F::splat(0.0));
    for (number, node) in nodes.iter().enumerate() {
        let a: [F; 6] = loaded(&interleaved.rates[node.bodies[0] as usize]);
        let b: [F; 6] = loaded(&interleaved.rates[node.bodies[1] as usize]);
        for row in interleaved.rows(number) {
            let jacobian = &interleaved.jacobian[row];
            let mut error =
                F::load(&interleaved.bias[row]) + F::load(&interleaved.gamma[row]) * F::load(&interleaved.impulse[row]);
            error = plus_dot(plus_dot(error, &a, half(jacobian, 0)), &b, half(jacobian, 1));
            let lack = F::select(chosen, -error, F::splat(0.0));
            worst = F::select(worst.below(lack.abs()), lack.abs(), worst);
            interleaved.unknowns[row] = lack.lanes();
        }
    }
    worst.lanes()
}

#[inline(always)]
fn solve_body<F: Four>(
    interleaved: &mut InterleavedSystem,
    nodes: &[SystemNode],
    plan: &BlockLayout,
    lanes: &[bool; 4],
) -> Lanes {
    let worst = find_errors_body::<F>(interleaved, nodes, lanes);
    substitute::<F>(interleaved, plan);
    for (impulse, unknown) in interleaved.impulse.iter_mut().zip(&interleaved.unknowns) {
        *impulse = (F::load(impulse) + F::load(unknown)).lanes();
    }
    add_push::<F>(interleaved, nodes);
    worst
}

#[inline(always)]
fn substitute<F: Four>(interleaved: &mut InterleavedSystem, plan: &BlockLayout) {
    for (place, &node) in plan.order().iter().enumerate() {
        by_rows!(interleaved.counts[node as usize], go_forward, (interleaved, plan, place));
    }
    for (place, &node) in plan.order().iter().enumerate().rev() {
        by_rows!(interleaved.counts[node as usize], go_back, (interleaved, plan, place));
    }
}

/// y = Uᵀ x for the node at a place, of K rows, and x −= W y for those coupled to it.
#[inline(always)]
fn go_forward<F: Four, const K: usize>(interleaved: &mut InterleavedSystem, plan: &BlockLayout, place: usize) {
    let InterleavedSystem { counts, starts, values, unknowns, .. } = interleaved;
    let node = plan.order()[place] as usize;
    let k = known::<K>(counts[node] as usize);
    let root = &values[SPREAD * plan.diagonal(node) as usize..][..k * k];
    let own = &mut unknowns[starts[node] as usize..][..k];
    let mut y = [ZERO; MAX_ROWS];
    for j in 0..k {
        let mut sum = F::splat(0.0);
        for i in 0..=j {
            sum = sum + F::load(&root[i * k + j]) * F::load(&own[i]);
        }
        y[j] = sum.lanes();
    }
    own.copy_from_slice(&y[..k]);
    for &(other, start) in plan.column(place) {
        let m = counts[other as usize] as usize;
        let block = &values[SPREAD * start as usize..][..m * k];
        for (x, row) in unknowns[starts[other as usize] as usize..][..m].iter_mut().zip(block.chunks_exact(k)) {
            *x = minus_dot(F::load(x), row, &y[..k]).lanes();
        }
    }
}

/// x = U (y − Σ Wᵀ x) for the node at a place, of K rows.
#[inline(always)]
fn go_back<F: Four, const K: usize>(interleaved: &mut InterleavedSystem, plan: &BlockLayout, place: usize) {
    let InterleavedSystem { counts, starts, values, unknowns, .. } = interleaved;
    let node = plan.order()[place] as usize;
    let k = known::<K>(counts[node] as usize);
    let mut y = [ZERO; MAX_ROWS];
    y[..k].copy_from_slice(&unknowns[starts[node] as usize..][..k]);
    for &(other, start) in plan.column(place) {
        let m = counts[other as usize] as usize;
        let block = &values[SPREAD * start as usize..][..m * k];
        for (x, row) in unknowns[starts[other as usize] as usize..][..m].iter().zip(block.chunks_exact(k)) {
            let x = F::load(x);
            for (y, number) in y[..k].iter_mut().zip(row) {
                *y = (F::load(y) - F::load(number) * x).lanes();
            }
        }
    }
    let root = &values[SPREAD * plan.diagonal(node) as usize..][..k * k];
    let own = &mut unknowns[starts[node] as usize..][..k];
    for i in 0..k {
        let mut sum = F::splat(0.0);
        for j in i..k {
            sum = sum + F::load(&root[i * k + j]) * F::load(&y[j]);
        }
        own[i] = sum.lanes();
    }
}
