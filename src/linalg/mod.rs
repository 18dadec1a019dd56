//! Linear algebra without physics.
//!
//! | file | what it does |
//! |---|---|
//! | `block.rs` | products and inverses of small blocks, four numbers a register |
//! | `order.rs` | the order of elimination, by least degree |
//! | `factor.rs` | sparse Cholesky factor of a matrix in blocks, and substitution |
//! | `eigen.rs` | eigenvalues of a symmetric 3×3 matrix |

pub(crate) mod block;
pub(crate) mod eigen;
pub(crate) mod factor;
#[cfg(test)]
pub(crate) mod noise;
mod order;
