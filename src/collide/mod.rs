//! Collision detection: finds which shapes touch, and where. Only this module and the queries use parry3d.
//!
//! | file | what |
//! |---|---|
//! | `collider`, `collider_state` | a shape on a body, and its state in this step |
//! | `broad`, `aabb_set` | which boxes overlap |
//! | `cache`, `pairs`, `persistent_manifold` | pairs of shapes, with the contacts that they keep from step to step |
//! | `narrow` | manifolds from two shapes and their relative pose |
//! | `predict`, `part_approach`, `found_contacts`, `motion_ahead`, `curvature`, `round_features` | manifolds at the poses in which shapes will press; how surfaces bend there, and turn in themselves |
//! | `sweep` | continuous detection of fast bodies |

mod aabb_set;
pub(crate) mod active_hits;
pub(crate) mod broad;
pub(crate) mod cache;
pub(crate) mod collider;
pub(crate) mod collider_state;
pub(crate) mod curvature;
mod found_contacts;
mod motion_ahead;
pub(crate) mod narrow;
pub(crate) mod pairs;
mod part_approach;
pub(crate) mod persistent_manifold;
pub(crate) mod predict;
pub(crate) mod quantized_pose;
pub(crate) mod round_features;
pub(crate) mod sweep;
