//! Heavy bodies on light ones: see `solve/contact_newton/`.

/// Share of an error in the load of a light body that the sweeps of a substep leave, from which on its island needs more than sweeps.
/// Why: what is left is a spring that the load sways on, and gives way by more than recovery takes out. With two sweeps it is 0.44 at a ratio
/// of masses of 2, where nothing sinks, and 0.56 at 3; at 5 a slab ends in the floor in 8 of 24 falls at 30 Hz.
/// Scenes: a crate of 2 to 10,000 times the mass of the slab, beams, feet or logs under it, 30 to 240 Hz, 0.1 to 10 m; heaps of mixed boxes.
/// Test: tests/heavy_on_light.rs
pub(crate) const LEFT: f64 = 0.5;
/// The same where something of an island of more than a few bodies moves faster than bodies may without striking: solved at once in each
/// substep, such heaps take four times as long.
/// Why: a stack of ten that a heavy box topples from needs it, at 0.9998; heaps of boxes of up to 125 times each other's mass do not sink.
/// Scenes: heavy_on_light, heaps of 4 to 16 boxes whose edges differ up to fivefold.
/// Test: tests/stacks.rs
pub(crate) const LEFT_WHILE_MOVING: f64 = 0.98;
