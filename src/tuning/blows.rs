//! What strikes: see `solve/contact_newton/`.

/// Closing speed within a substep from which on bodies strike one another, over what gravity makes it in that time.
/// Why: what stands has one of these in each substep. What strikes at less goes up by less than a millimetre.
/// Scenes: balls and crates of 0.1 to 40 times the mass of what they fall on, rows pushed by walls, 30 to 240 Hz.
/// Test: tests/rebounds.rs
pub(crate) const STRUCK: f32 = 2.0;
/// Closing speed below which nothing strikes (m/s), without gravity either.
/// Why: without gravity every closing speed would be a blow, those of rounding too; what strikes at this one goes up by 5 micrometres.
/// Scenes: rows pushed by walls without gravity.
/// Test: tests/rebounds.rs
pub(crate) const SLIGHT: f32 = 0.01;
/// Ratio of masses up to which sweeps find what holds bodies after a blow.
/// Why: at ratios of 1 and 4 a crate sinks by 0.1 and 1 mm after a blow without a second solve, at 40 by 37 mm.
/// Scenes: crates of 100 to 4000 kg on one of 100 kg, balls of 3.5 to 1400 kg on a plate of 35 kg, 30 to 240 Hz.
/// Test: tests/rebounds.rs
pub(crate) const ALIKE: f64 = 3.0;
