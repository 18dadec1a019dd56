//! Linear algebra without physics.
//!
//! | file | what it does |
//! |---|---|
//! | `block.rs` | products and inverses of small blocks, four numbers a register |
//! | `order.rs` | the order of elimination, by least degree |
//! | `factor.rs` | sparse Cholesky factor of a matrix in blocks, and substitution |
//! | `border.rs` | a few dense rows beside such a factor, by a Schur complement |
//! | `eigen.rs` | eigenvalues of a symmetric 3×3 matrix |
//! | `held_axes.rs` | what answers where some axes are held |
//! | `rotation32.rs` | rotations in `f32` by power series, and what is next to nothing |
//! | `narrowing.rs` | writes `f64` results into `f32` state |

pub(crate) mod block;
pub(crate) mod border;
pub(crate) mod eigen;
pub(crate) mod factor;
pub(crate) mod held_axes;
pub(crate) mod narrowing;
#[cfg(test)]
pub(crate) mod noise;
mod order;
pub(crate) mod rotation32;
