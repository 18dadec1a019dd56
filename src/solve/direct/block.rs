//! Products of small dense blocks, four numbers at a time.
//!
//! A block of m × n is stored row by row, each row in as many lanes of four as hold n, with zeros behind: every loop over lanes is
//! one register wide. Common sizes are loops of constant length, and for 3 × 3 of nothing else.
//!
//! Plain loops over arrays, since what is not inlined is compiled without the wide registers of its caller.

#![expect(clippy::needless_range_loop, reason = "an index runs over rows, lanes and numbers in lanes alike")]

/// Four numbers side by side.
pub(super) type Lanes = [f64; 4];

pub(super) const ZERO: Lanes = [0.0; 4];

/// Lanes that hold this many numbers.
#[inline(always)]
pub(super) const fn width(count: usize) -> usize {
    count.div_ceil(4)
}

/// row += share · other.
#[inline(always)]
pub(super) fn add_scaled(row: &mut Lanes, share: f64, other: &Lanes) {
    for j in 0..4 {
        row[j] += share * other[j];
    }
}

#[inline(always)]
pub(super) fn sum(lanes: &Lanes) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// A block of 3 × 3: that of two joints which hold points.
pub(super) type Block3 = [Lanes; 3];

/// The block of 3 × 3 that begins here.
#[inline(always)]
pub(super) fn block3(values: &[Lanes]) -> &Block3 {
    values.first_chunk().expect("blocks lie within what their plan has counted")
}

#[inline(always)]
pub(super) fn block3_mut(values: &mut [Lanes]) -> &mut Block3 {
    values.first_chunk_mut().expect("blocks lie within what their plan has counted")
}

/// A B.
#[inline(always)]
pub(super) fn product3(a: &Block3, b: &Block3) -> Block3 {
    let mut product = [ZERO; 3];
    for i in 0..3 {
        for j in 0..4 {
            product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    product
}

/// C − A B.
#[inline(always)]
pub(super) fn minus_product3(c: &Block3, a: &Block3, b: &Block3) -> Block3 {
    let mut difference = *c;
    for i in 0..3 {
        for j in 0..4 {
            difference[i][j] -= a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    difference
}

#[inline(always)]
pub(super) fn transposed3(a: &Block3) -> Block3 {
    [[a[0][0], a[1][0], a[2][0], 0.0], [a[0][1], a[1][1], a[2][1], 0.0], [a[0][2], a[1][2], a[2][2], 0.0]]
}

/// x − L y.
#[inline(always)]
pub(super) fn minus_rows3(x: &Lanes, l: &Block3, y: &Lanes) -> Lanes {
    let mut difference = *x;
    for i in 0..3 {
        difference[i] -= l[i][0] * y[0] + l[i][1] * y[1] + l[i][2] * y[2];
    }
    difference
}

/// Lᵀ x.
#[inline(always)]
pub(super) fn columns3(l: &Block3, x: &Lanes) -> Lanes {
    let mut product = ZERO;
    for j in 0..4 {
        product[j] = l[0][j] * x[0] + l[1][j] * x[1] + l[2][j] * x[2];
    }
    product
}

/// y − z.
#[inline(always)]
pub(super) fn minus(y: &Lanes, z: &Lanes) -> Lanes {
    let mut difference = *y;
    for j in 0..4 {
        difference[j] -= z[j];
    }
    difference
}

/// C −= A B, with A of m × k, B of k × n.
#[inline(always)]
pub(super) fn subtract_product(c: &mut [Lanes], a: &[Lanes], b: &[Lanes], m: usize, k: usize, n: usize) {
    match (k, width(n)) {
        (3, 1) => product_of::<3, 1, 1, true>(c, a, b, m),
        (3, 2) => product_of::<3, 1, 2, true>(c, a, b, m),
        (4, 1) => product_of::<4, 1, 1, true>(c, a, b, m),
        (4, 2) => product_of::<4, 1, 2, true>(c, a, b, m),
        (5, 1) => product_of::<5, 2, 1, true>(c, a, b, m),
        (5, 2) => product_of::<5, 2, 2, true>(c, a, b, m),
        (6, 1) => product_of::<6, 2, 1, true>(c, a, b, m),
        (6, 2) => product_of::<6, 2, 2, true>(c, a, b, m),
        _ => product_of_any::<true>(c, a, b, m, k, width(n)),
    }
}

/// C = A B, with A of m × k, B of k × k.
#[inline(always)]
pub(super) fn set_product(c: &mut [Lanes], a: &[Lanes], b: &[Lanes], m: usize, k: usize) {
    match k {
        3 => product_of::<3, 1, 1, false>(c, a, b, m),
        4 => product_of::<4, 1, 1, false>(c, a, b, m),
        5 => product_of::<5, 2, 2, false>(c, a, b, m),
        6 => product_of::<6, 2, 2, false>(c, a, b, m),
        _ => product_of_any::<false>(c, a, b, m, k, width(k)),
    }
}

/// With A of K numbers in WA lanes a row, and B of W lanes.
#[inline(always)]
fn product_of<const K: usize, const WA: usize, const W: usize, const SUBTRACT: bool>(
    c: &mut [Lanes],
    a: &[Lanes],
    b: &[Lanes],
    m: usize,
) {
    let (c, a) = (&mut c[..m * W].as_chunks_mut::<W>().0[..m], &a[..m * WA].as_chunks::<WA>().0[..m]);
    let b: &[[Lanes; W]; K] = b[..K * W].as_chunks::<W>().0.first_chunk().expect("the slice is K rows of W lanes");
    for i in 0..m {
        let mut row = if SUBTRACT { c[i] } else { [ZERO; W] };
        for l in 0..K {
            let share = a[i][l / 4][l % 4];
            for j in 0..W {
                add_scaled(&mut row[j], if SUBTRACT { -share } else { share }, &b[l][j]);
            }
        }
        c[i] = row;
    }
}

#[inline(always)]
fn product_of_any<const SUBTRACT: bool>(c: &mut [Lanes], a: &[Lanes], b: &[Lanes], m: usize, k: usize, w: usize) {
    if w == 0 || k == 0 {
        return;
    }
    for (row_c, row_a) in c[..m * w].chunks_exact_mut(w).zip(a[..m * width(k)].chunks_exact(width(k))) {
        if !SUBTRACT {
            row_c.fill(ZERO);
        }
        for (l, row_b) in b[..k * w].chunks_exact(w).enumerate() {
            let share = row_a[l / 4][l % 4];
            for (lanes, other) in row_c.iter_mut().zip(row_b) {
                add_scaled(lanes, if SUBTRACT { -share } else { share }, other);
            }
        }
    }
}

/// x −= L y, with L of m × k.
#[inline(always)]
pub(super) fn subtract_rows(x: &mut [Lanes], l: &[Lanes], y: &[Lanes], m: usize) {
    match y.len() {
        0 => {}
        1 => subtract_rows_of::<1>(x, l, y, m),
        2 => subtract_rows_of::<2>(x, l, y, m),
        w => {
            for (i, row) in l[..m * w].chunks_exact(w).enumerate() {
                let mut products = ZERO;
                for (a, b) in row.iter().zip(y) {
                    add_product(&mut products, a, b);
                }
                x[i / 4][i % 4] -= sum(&products);
            }
        }
    }
}

#[inline(always)]
fn subtract_rows_of<const W: usize>(x: &mut [Lanes], l: &[Lanes], y: &[Lanes], m: usize) {
    let y: &[Lanes; W] = y.try_into().expect("the slice has W lanes");
    for (i, row) in l[..m * W].as_chunks::<W>().0.iter().enumerate() {
        let mut products = ZERO;
        for (a, b) in row.iter().zip(y) {
            add_product(&mut products, a, b);
        }
        x[i / 4][i % 4] -= sum(&products);
    }
}

#[inline(always)]
pub(super) fn add_product(into: &mut Lanes, a: &Lanes, b: &Lanes) {
    for j in 0..4 {
        into[j] += a[j] * b[j];
    }
}

/// y += sign · Lᵀ x, with L of m × k.
#[inline(always)]
pub(super) fn add_columns(y: &mut [Lanes], l: &[Lanes], x: &[Lanes], m: usize, sign: f64) {
    let w = y.len();
    for (i, row) in l[..m * w].chunks_exact(w.max(1)).enumerate() {
        let share = sign * x[i / 4][i % 4];
        for (lanes, other) in y.iter_mut().zip(row) {
            add_scaled(lanes, share, other);
        }
    }
}

/// The transpose of a block of m × k.
#[inline(always)]
pub(super) fn transpose(into: &mut [Lanes], from: &[Lanes], m: usize, k: usize) {
    let (w, wk) = (width(m), width(k));
    into[..k * w].fill(ZERO);
    for i in 0..m {
        for l in 0..k {
            into[l * w + i / 4][i % 4] = from[i * wk + l / 4][l % 4];
        }
    }
}

/// A pivot this much smaller than the diagonal was before elimination is noise.
const SINGULAR: f64 = 1.0e-14;

/// Most rows of a block.
pub(super) const MAX_ROWS: usize = 24;

/// Inverts a symmetric positive definite matrix of n × n in place; a row that depends on those before it gets no multiplier.
#[inline(always)]
pub(super) fn invert(a: &mut [Lanes], n: usize) {
    match n {
        3 => invert_of::<3, 1>(a),
        4 => invert_of::<4, 1>(a),
        5 => invert_of::<5, 2>(a),
        6 => invert_of::<6, 2>(a),
        _ => invert_any(a, n, width(n)),
    }
}

/// As [`invert_any`], in loops of constant length.
#[inline(always)]
fn invert_of<const N: usize, const W: usize>(values: &mut [Lanes]) {
    let values: &mut [[Lanes; W]; N] =
        values[..N * W].as_chunks_mut::<W>().0.first_chunk_mut().expect("the slice is N rows of W lanes");
    let mut a = *values;
    let mut own = [0.0; N];
    for i in 0..N {
        own[i] = a[i][i / 4][i % 4];
    }
    for k in 0..N {
        let pivot = a[k][k / 4][k % 4];
        if pivot <= SINGULAR * own[k] || !pivot.is_finite() {
            a[k] = [ZERO; W];
            for i in 0..N {
                a[i][k / 4][k % 4] = 0.0;
            }
            continue;
        }
        let inverse = 1.0 / pivot;
        a[k][k / 4][k % 4] = 1.0;
        for j in 0..W {
            for value in &mut a[k][j] {
                *value *= inverse;
            }
        }
        for i in 0..N {
            if i != k {
                let share = -a[i][k / 4][k % 4];
                a[i][k / 4][k % 4] = 0.0;
                for j in 0..W {
                    let other = a[k][j];
                    add_scaled(&mut a[i][j], share, &other);
                }
            }
        }
    }
    *values = a;
}

/// Gauss–Jordan steps on the diagonal.
#[inline(always)]
fn invert_any(a: &mut [Lanes], n: usize, w: usize) {
    let a = &mut a[..n * w];
    let mut own = [0.0; MAX_ROWS];
    let mut pivot_row = [ZERO; width(MAX_ROWS)];
    for (i, value) in own[..n].iter_mut().enumerate() {
        *value = a[i * w + i / 4][i % 4];
    }
    for k in 0..n {
        let pivot = a[k * w + k / 4][k % 4];
        if pivot <= SINGULAR * own[k] || !pivot.is_finite() {
            a[k * w..(k + 1) * w].fill(ZERO);
            for i in 0..n {
                a[i * w + k / 4][k % 4] = 0.0;
            }
            continue;
        }
        let inverse = 1.0 / pivot;
        // The pivot's row and column are left out by making them those of a step that is already done.
        a[k * w + k / 4][k % 4] = 1.0;
        for (lanes, row) in pivot_row[..w].iter_mut().zip(&mut a[k * w..(k + 1) * w]) {
            row.iter_mut().for_each(|value| *value *= inverse);
            *lanes = *row;
        }
        for i in 0..n {
            if i != k {
                let share = -a[i * w + k / 4][k % 4];
                a[i * w + k / 4][k % 4] = 0.0;
                for (lanes, other) in a[i * w..(i + 1) * w].iter_mut().zip(&pivot_row[..w]) {
                    add_scaled(lanes, share, other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dependent_row_gets_no_multiplier() {
        let mut a = [[2.0, 2.0, 0.5, 0.0], [2.0, 2.0, 0.5, 0.0], [0.5, 0.5, 1.0, 0.0]];
        invert(&mut a, 3);
        assert!(a.iter().flatten().all(|value| value.is_finite()), "the inverse is {a:?}");
        assert_eq!(a[1], ZERO, "the second row repeats the first");
    }
}
