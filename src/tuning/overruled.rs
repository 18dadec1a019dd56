//! Motors without a greatest force that meet what has none either: see `solve/newton/overruled.rs` and `solve/direct/active_set.rs`.

/// Compliance with which they give way in islands that are solved as one, over their own response J M⁻¹ Jᵀ.
/// Why: a load of a hundred times a motor's body costs it a thousandth of what falls freely in a substep meanwhile. At 1e-6 the impulses of
/// contacts do not settle against it.
/// Scenes: bodies driven into a wall, and into what stands before one, at 30 to 240 Hz.
/// Test: tests/overruled_motors.rs
pub(crate) const GIVE: f64 = 1.0e-5;
/// The same in articulations.
/// Why: as far above the compliance of contacts as below one. It pushes with a thousand times what would bring about what it asks for, and
/// what it holds up meanwhile sinks at a thousandth of what falls freely in a substep.
/// Scenes: motors and servos against limits, ropes, welds and walls at 30 to 240 Hz.
/// Test: tests/overruled_motors.rs
pub(crate) const OVERRULED_COMPLIANCE: f64 = 1.0e-3;
/// By how much a substep may turn a body further than it would have turned before its motors yield (rad).
/// Why: rows that hold at a substep's start miss by the square of it. At 0.5 a crank is flung past its dead centre at 8 times the speed asked for.
/// Scenes: cranks at dead centre, chains let down on what stands, at 30 to 240 Hz.
/// Test: tests/dead_centres.rs
pub(crate) const FLUNG: f64 = 0.1;
/// Share of the speed asked for that such a motor misses at least if it yields: others, as one that winds up a chain which whirls, go on.
/// Why: a motor's own rotor costs it a thousandth; at a dead centre nothing is left.
/// Scenes: as above, chains that a driven box winds up.
/// Test: tests/dead_centres.rs
pub(crate) const STRAINED: f64 = 0.5;
