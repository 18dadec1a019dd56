//! Decides which graphs get no derived bounds: sheets and lattices, in which every body hangs on many paths.
//!
//! A bound says what the shortest of a body's paths allows. On a chain or a bridge that is what carries the load; in a sheet load
//! spreads over all paths, and bounds between its bodies come by the dozen for each. In a sheet of 100 × 100 balls they took 14
//! times the time of the sweeps they were to help (482 ms against 34 ms a step) and left gaps of 53 mm after a second, where sweeps
//! alone with 64 substeps leave 16 mm in 189 ms. So a sheet has sweeps of its own instead (*solve/joint_mesh.rs*).

pub(crate) use crate::tuning::sheets::MIN_BODIES;
use crate::tuning::sheets::SHEET;

/// Whether a part of so many joints and moving bodies is a sheet.
pub(crate) fn is_sheet(joints: usize, bodies: usize) -> bool {
    bodies >= MIN_BODIES && joints as f32 >= SHEET * bodies as f32
}
