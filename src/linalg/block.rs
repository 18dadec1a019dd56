//! Products of small dense blocks, four numbers at a time.
//!
//! A block of m × n is stored row by row, each row in as many lanes of four as hold n, with zeros behind: every loop over lanes is
//! one register wide. Common sizes are loops of constant length, and for 3 × 3 of nothing else.
//!
//! Plain loops over arrays, since what is not inlined is compiled without the wide registers of its caller.

/// Four numbers side by side.
pub(crate) type Lanes = [f64; 4];

pub(crate) const ZERO: Lanes = [0.0; 4];

/// Lanes that hold this many numbers.
#[inline(always)]
pub(crate) const fn width(count: usize) -> usize {
    count.div_ceil(4)
}

/// into = from. Few lanes are moved as such, without a call.
#[inline(always)]
pub(crate) fn copy(into: &mut [Lanes], from: &[Lanes]) {
    match from {
        [only] => into[0] = *only,
        [first, second] => [into[0], into[1]] = [*first, *second],
        _ => into.copy_from_slice(from),
    }
}

/// row += share · other.
#[inline(always)]
pub(crate) fn add_scaled(row: &mut Lanes, share: f64, other: &Lanes) {
    for j in 0..4 {
        row[j] += share * other[j];
    }
}

#[inline(always)]
pub(crate) fn sum(lanes: &Lanes) -> f64 {
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// The columns of four rows.
#[inline(always)]
fn columns_of(rows: &[Lanes; 4]) -> [Lanes; 4] {
    let mut columns = [ZERO; 4];
    for i in 0..4 {
        for j in 0..4 {
            columns[j][i] = rows[i][j];
        }
    }
    columns
}

/// The sums of four lanes each, side by side.
#[inline(always)]
pub(crate) fn sums(rows: &[Lanes; 4]) -> Lanes {
    let columns = columns_of(rows);
    let mut sums = ZERO;
    for i in 0..4 {
        sums[i] = (columns[0][i] + columns[1][i]) + (columns[2][i] + columns[3][i]);
    }
    sums
}

/// L y, for L of m × k in W lanes a row, with zeros behind.
#[inline(always)]
fn products<const W: usize>(l: &[Lanes], y: &[Lanes; W], m: usize) -> [Lanes; width(MAX_ROWS)] {
    let mut found = [ZERO; width(MAX_ROWS)];
    match m {
        3 => products_of::<3, W>(&mut found, l, y),
        4 => products_of::<4, W>(&mut found, l, y),
        5 => products_of::<5, W>(&mut found, l, y),
        6 => products_of::<6, W>(&mut found, l, y),
        _ => products_of_rows(&mut found, &l.as_chunks::<W>().0[..m], y),
    }
    found
}

/// As [`products_of_rows`], in loops of constant length.
#[inline(always)]
fn products_of<const M: usize, const W: usize>(found: &mut [Lanes], l: &[Lanes], y: &[Lanes; W]) {
    let rows: &[[Lanes; W]; M] = l.as_chunks::<W>().0.first_chunk().expect("blocks lie within what their plan has counted");
    products_of_rows(found, rows, y);
}

/// Four rows at a time.
#[inline(always)]
fn products_of_rows<const W: usize>(found: &mut [Lanes], rows: &[[Lanes; W]], y: &[Lanes; W]) {
    for (four, rows) in found.iter_mut().zip(rows.chunks(4)) {
        let mut products = [ZERO; 4];
        for (product, row) in products.iter_mut().zip(rows) {
            for j in 0..W {
                add_product(product, &row[j], &y[j]);
            }
        }
        *four = sums(&products);
    }
}

/// A block of 3 × 3: that of two joints which hold points.
pub(crate) type Block3 = [Lanes; 3];

/// The block of 3 × 3 that begins here.
#[inline(always)]
pub(crate) fn block3(values: &[Lanes]) -> &Block3 {
    values.first_chunk().expect("blocks lie within what their plan has counted")
}

#[inline(always)]
pub(crate) fn block3_mut(values: &mut [Lanes]) -> &mut Block3 {
    values.first_chunk_mut().expect("blocks lie within what their plan has counted")
}

/// A B.
#[inline(always)]
pub(crate) fn product3(a: &Block3, b: &Block3) -> Block3 {
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
pub(crate) fn minus_product3(c: &Block3, a: &Block3, b: &Block3) -> Block3 {
    let mut difference = *c;
    for i in 0..3 {
        for j in 0..4 {
            difference[i][j] -= a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    difference
}

#[inline(always)]
pub(crate) fn transposed3(a: &Block3) -> Block3 {
    [[a[0][0], a[1][0], a[2][0], 0.0], [a[0][1], a[1][1], a[2][1], 0.0], [a[0][2], a[1][2], a[2][2], 0.0]]
}

/// x − L y.
#[inline(always)]
pub(crate) fn minus_rows3(x: &Lanes, l: &Block3, y: &Lanes) -> Lanes {
    let mut difference = *x;
    for i in 0..3 {
        difference[i] -= l[i][0] * y[0] + l[i][1] * y[1] + l[i][2] * y[2];
    }
    difference
}

/// Lᵀ x.
#[inline(always)]
pub(crate) fn columns3(l: &Block3, x: &Lanes) -> Lanes {
    let mut product = ZERO;
    for j in 0..4 {
        product[j] = l[0][j] * x[0] + l[1][j] * x[1] + l[2][j] * x[2];
    }
    product
}

/// U x.
#[inline(always)]
pub(crate) fn rows3(u: &Block3, x: &Lanes) -> Lanes {
    let mut product = ZERO;
    for i in 0..3 {
        product[i] = u[i][0] * x[0] + u[i][1] * x[1] + u[i][2] * x[2];
    }
    product
}

/// y − z.
#[inline(always)]
pub(crate) fn minus(y: &Lanes, z: &Lanes) -> Lanes {
    let mut difference = *y;
    for j in 0..4 {
        difference[j] -= z[j];
    }
    difference
}

/// C −= A B, with A of m × k, B of k × n.
#[inline(always)]
pub(crate) fn subtract_product(c: &mut [Lanes], a: &[Lanes], b: &[Lanes], m: usize, k: usize, n: usize) {
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
pub(crate) fn set_product(c: &mut [Lanes], a: &[Lanes], b: &[Lanes], m: usize, k: usize) {
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
pub(crate) fn subtract_rows(x: &mut [Lanes], l: &[Lanes], y: &[Lanes], m: usize) {
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
    for (i, products) in products(l, y, m).iter().enumerate().take(width(m)) {
        x[i] = minus(&x[i], products);
    }
}

#[inline(always)]
pub(crate) fn add_product(into: &mut Lanes, a: &Lanes, b: &Lanes) {
    for j in 0..4 {
        into[j] += a[j] * b[j];
    }
}

/// x = U y, with U of m × m.
#[inline(always)]
pub(crate) fn set_rows(x: &mut [Lanes], u: &[Lanes], y: &[Lanes], m: usize) {
    match y.len() {
        1 => set_rows_of::<1>(x, u, y, m),
        2 => set_rows_of::<2>(x, u, y, m),
        w => {
            x.fill(ZERO);
            for (i, row) in u[..m * w].chunks_exact(w).enumerate() {
                let mut products = ZERO;
                for (a, b) in row.iter().zip(y) {
                    add_product(&mut products, a, b);
                }
                x[i / 4][i % 4] = sum(&products);
            }
        }
    }
}

#[inline(always)]
fn set_rows_of<const W: usize>(x: &mut [Lanes], u: &[Lanes], y: &[Lanes], m: usize) {
    let y: &[Lanes; W] = y.try_into().expect("the slice has W lanes");
    let products = products(u, y, m);
    x.copy_from_slice(&products[..W]);
}

/// y += sign · Lᵀ x, with L of m × k.
#[inline(always)]
pub(crate) fn add_columns(y: &mut [Lanes], l: &[Lanes], x: &[Lanes], m: usize, sign: f64) {
    match y.len() {
        0 => {}
        1 => add_columns_of::<1>(y, l, x, m, sign),
        2 => add_columns_of::<2>(y, l, x, m, sign),
        w => {
            for (i, row) in l[..m * w].chunks_exact(w).enumerate() {
                let share = sign * x[i / 4][i % 4];
                for (lanes, other) in y.iter_mut().zip(row) {
                    add_scaled(lanes, share, other);
                }
            }
        }
    }
}

#[inline(always)]
fn add_columns_of<const W: usize>(y: &mut [Lanes], l: &[Lanes], x: &[Lanes], m: usize, sign: f64) {
    let y: &mut [Lanes; W] = y.try_into().expect("the slice has W lanes");
    let mut total = *y;
    for (i, row) in l[..m * W].as_chunks::<W>().0.iter().enumerate() {
        let share = sign * x[i / 4][i % 4];
        for (lanes, other) in total.iter_mut().zip(row) {
            add_scaled(lanes, share, other);
        }
    }
    *y = total;
}

/// The transpose of a block of m × k.
#[inline(always)]
pub(crate) fn transpose(into: &mut [Lanes], from: &[Lanes], m: usize, k: usize) {
    match width(k) {
        1 => transpose_of::<1>(into, from, m, k),
        2 => transpose_of::<2>(into, from, m, k),
        wk => transpose_tiles(into, from, m, k, wk),
    }
}

/// As [`transpose_tiles`], with rows of constant length.
#[inline(always)]
fn transpose_of<const W: usize>(into: &mut [Lanes], from: &[Lanes], m: usize, k: usize) {
    transpose_tiles(into, from, m, k, W);
}

/// Four rows by four columns at a time, of rows of `wk` lanes.
#[inline(always)]
fn transpose_tiles(into: &mut [Lanes], from: &[Lanes], m: usize, k: usize, wk: usize) {
    let w = width(m);
    for (i, rows) in from[..m * wk].chunks(4 * wk).enumerate() {
        for j in 0..wk {
            let mut tile = [ZERO; 4];
            for (lanes, row) in tile.iter_mut().zip(rows.chunks_exact(wk)) {
                *lanes = row[j];
            }
            for (row, column) in into[4 * j * w..k * w].chunks_exact_mut(w).zip(columns_of(&tile)) {
                row[i] = column;
            }
        }
    }
}

/// Most rows of a block.
pub(crate) const MAX_ROWS: usize = 24;

/// Turns a symmetric positive definite matrix A of n × n, lower triangle, into U = L⁻ᵀ, with A = L Lᵀ: so A⁻¹ = U Uᵀ.
///
/// A row whose pivot is not above its `least` depends on those before it and gets no multiplier: its column of U is 0. The inverse
/// itself would not do: rows that repeat others leave blocks of condition 1e7 and more, whose inverse is off by as much of rounding, and
/// later pivots with it; that of the root is off by its square root.
#[inline(always)]
pub(crate) fn invert_root(a: &mut [Lanes], n: usize, least: &[Lanes]) {
    match n {
        3 => invert_root_of::<3, 1>(a, least),
        4 => invert_root_of::<4, 1>(a, least),
        5 => invert_root_of::<5, 2>(a, least),
        6 => invert_root_of::<6, 2>(a, least),
        _ => invert_root_any(a, n, width(n), least),
    }
}

/// As [`invert_root_any`], in loops of constant length.
#[inline(always)]
fn invert_root_of<const N: usize, const W: usize>(values: &mut [Lanes], least: &[Lanes]) {
    let values: &mut [[Lanes; W]; N] =
        values[..N * W].as_chunks_mut::<W>().0.first_chunk_mut().expect("the slice is N rows of W lanes");
    let least: &[Lanes; W] = least.first_chunk().expect("a diagonal has as many lanes as a row");
    let (mut a, mut t, mut scale) = (*values, [[ZERO; W]; N], [0.0; N]);
    for k in 0..N {
        t[k][k / 4][k % 4] = 1.0;
    }
    for k in 0..N {
        let pivot = a[k][k / 4][k % 4];
        if !is_sound(pivot, least[k / 4][k % 4]) {
            continue;
        }
        scale[k] = 1.0 / pivot.sqrt();
        let inverse = -scale[k] * scale[k];
        for i in k + 1..N {
            let share = a[i][k / 4][k % 4] * inverse;
            for j in 0..W {
                let (row_a, row_t) = (a[k][j], t[k][j]);
                add_scaled(&mut a[i][j], share, &row_a);
                add_scaled(&mut t[i][j], share, &row_t);
            }
        }
    }
    *values = [[ZERO; W]; N];
    for k in 0..N {
        for i in k..N {
            values[k][i / 4][i % 4] = scale[i] * t[i][k / 4][k % 4];
        }
    }
}

#[inline(always)]
fn is_sound(pivot: f64, least: f64) -> bool {
    pivot > least && pivot.is_finite()
}

/// Eliminates below each pivot, in the matrix and in a unit matrix beside it, which becomes the inverse of L with a diagonal of 1.
#[inline(always)]
fn invert_root_any(a: &mut [Lanes], n: usize, w: usize, least: &[Lanes]) {
    let a = &mut a[..n * w];
    let (mut t, mut scale) = ([ZERO; MAX_ROWS * width(MAX_ROWS)], [0.0; MAX_ROWS]);
    for k in 0..n {
        t[k * w + k / 4][k % 4] = 1.0;
    }
    for k in 0..n {
        let pivot = a[k * w + k / 4][k % 4];
        if !is_sound(pivot, least[k / 4][k % 4]) {
            continue;
        }
        scale[k] = 1.0 / pivot.sqrt();
        let inverse = -scale[k] * scale[k];
        for i in k + 1..n {
            let share = a[i * w + k / 4][k % 4] * inverse;
            for j in 0..w {
                let (row_a, row_t) = (a[k * w + j], t[k * w + j]);
                add_scaled(&mut a[i * w + j], share, &row_a);
                add_scaled(&mut t[i * w + j], share, &row_t);
            }
        }
    }
    a.fill(ZERO);
    for k in 0..n {
        for i in k..n {
            a[k * w + i / 4][i % 4] = scale[i] * t[i * w + k / 4][k % 4];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dependent_row_gets_no_multiplier() {
        let mut a = [[2.0, 2.0, 0.5, 0.0], [2.0, 2.0, 0.5, 0.0], [0.5, 0.5, 1.0, 0.0]];
        invert_root(&mut a, 3, &[[2.0e-14, 2.0e-14, 1.0e-14, 0.0]]);
        assert!(a.iter().flatten().all(|value| value.is_finite()), "the root is {a:?}");
        assert_eq!(a[1], ZERO, "the second row repeats the first");
        assert_eq!([a[0][1], a[2][1]], [0.0; 2], "no other row pushes for it");
    }
}
