//! Exact motions to measure against: as simple as can be, in `f64` and small steps, in coordinates in which no joint can open.
//!
//! [`PlanarChain`]: a chain in a plane. [`StoppedChain`]: the same with stops, which strike without rebound. [`BallTree`]: bodies
//! hung from one another by ball joints, in space.

mod planar;
mod stops;
mod tree;

pub use planar::{Link, PlanarChain, SUBSTEPS};
pub use stops::StoppedChain;
pub use tree::{BallTree, HungBody};
