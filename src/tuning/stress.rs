//! Forces of joints and contacts that hold one another: see `solve/newton/self_stress.rs`.

/// Time in which all but 1/e of them goes (s).
/// Why: 0.03 and 0.3 keep a tower standing too as a block is drawn out of it; velocities do not feel it.
/// Scenes: the tower of tests/self_stress.rs at 30 to 240 steps a second, elevator, arch, scissor_lift.
/// Test: tests/self_stress.rs
pub(crate) const TIME_CONSTANT: f64 = 0.1;
/// Part of the greatest force that presses from which on it is let go, and of the greatest load from which on contradictions are dropped.
/// Why: what yields by its compliance has 0.002 of an exact load look so, and told loads are to be exact; a hundredth does no harm.
/// A footbridge under 8 t sags by 2.3 mm in place of 2 where less than that is dropped; at 0.25 rods bear 1.7 times their share.
/// Scenes: elevator, scissor_lift, footbridge, platforms on rods.
/// Test: tests/parallel_ropes.rs
pub(crate) const LEAST_PART: f64 = 1.0e-2;
/// By how much joints that repeat one another may contradict each other so that one of them has no multiplier of its own (m/s²).
/// Why: in substeps of second order they do by 1e-6; a taut line is held by more from an angle of 2e-6 on.
/// Scenes: platforms on two to eight ropes of 1 to 13 links, 30 to 240 steps a second; taut lines and bridges of the catalogue.
/// Test: tests/parallel_ropes.rs
pub(crate) const CONTRADICTION: f64 = 1.0e-6;
/// By how much at most where they are solved with contacts (m/s). More is asked for: a rope made too short.
/// Why: found from 1e-17 to 1.3e-7, at 30 steps a second, 30 m and 3 m/s; in 1/30 s it opens a joint by 30 nm.
/// Scenes: as above.
/// Test: tests/parallel_ropes.rs
pub(crate) const TOLERATED: f64 = 1.0e-6;
