//! What collision and the solver both know of a contact: its multipliers, and what the solver says of it. Data alone.

mod impulses;
pub(crate) mod told;

pub(crate) use impulses::{ContactImpulses, POINTS, TOUCHED, tangents};
