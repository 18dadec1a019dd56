//! Which shapes touch, and where. parry3d stays behind this door.
//!
//! `broad` finds candidates among kept `boxes`, `cache` keeps `pairs` of them with what was `carried` over of the contacts they had,
//! `narrow` makes manifolds from geometry alone where shapes have left their `stance`, `curvature` says how
//! surfaces bend where they touch, `sweep` stops fast bodies at what they would pass through.

pub(crate) mod blows;
mod boxes;
pub(crate) mod broad;
pub(crate) mod cache;
pub(crate) mod carried;
pub(crate) mod coarse;
pub(crate) mod collider;
pub(crate) mod curvature;
pub(crate) mod narrow;
pub(crate) mod pairs;
pub(crate) mod predict;
pub(crate) mod stance;
pub(crate) mod sweep;
