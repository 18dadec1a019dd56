//! Contact data that collision and solver share: multipliers and status. No behaviour.

mod impulses;
pub(crate) mod status;

pub(crate) use impulses::{ContactImpulses, POINTS, TOUCHED, tangents};
