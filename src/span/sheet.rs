//! Which graphs are left without derived bounds: sheets and lattices, of which every body hangs on many paths.
//!
//! A bound says what the shortest of a body's paths allows. On a chain or a bridge that is what carries the load; in a sheet load
//! spreads over all paths, and bounds between its bodies come by the dozen for each. In a sheet of 100 × 100 balls they took 14
//! times the time of the sweeps they were to help (482 ms against 34 ms a step) and left gaps of 53 mm after a second, where sweeps
//! alone with 64 substeps leave 16 mm in 189 ms. So a sheet has sweeps of its own instead (*solve/sheet.rs*).

/// Joints for each moving body from which on a graph is a sheet: 1 in a chain or loop, 1.33 in a ladder, 1.43 in a rope bridge of 112
/// planks, 1.5 in a truss of bars in triangles, 2 in a square net; but 2 as well in a narrow footbridge whose planks are tied to both
/// pieces of each rope.
const SHEET: f32 = 1.75;

/// Bodies below which a sheet is like any other graph: its bounds are few, and it may be a footbridge.
pub(crate) const LEAST_BODIES: usize = 400;

/// Whether a part of so many joints and moving bodies is a sheet.
pub(crate) fn is_sheet(joints: usize, bodies: usize) -> bool {
    bodies >= LEAST_BODIES && joints as f32 >= SHEET * bodies as f32
}
