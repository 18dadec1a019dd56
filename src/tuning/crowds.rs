//! Where contacts that stay apart are left out: see `world/crowds.rs`.

/// Pairs near each other, over bodies that move, from which on those that stay apart in a step are left out of it.
/// Why: each body of a heap of equal balls touches twelve others, six pairs for each, and has ten near it as it falls. A cloud of n splinters
/// has n/2, and solves them in a third of a microsecond each and substep: of 65 in 1.5 ms, of 200 in 57 and of 400 in 310.
/// Scenes: clouds of 50 to 400 balls and boxes of 5 mm that fly apart at 5 to 150 m/s, piles.
/// Test: tests/robustness.rs
pub(crate) const CROWD: usize = 32;
