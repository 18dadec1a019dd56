//! Peer engines, each behind a cargo feature: the same definitions in, the same questions answered.
//!
//! What an engine has no equal of is refused with a panic that starts with `not supported by`, never approximated in silence.

// A build without any peer has no use for what they share.
#![cfg_attr(not(any(feature = "peer-rapier", feature = "peer-box3d", feature = "peer-jolt")), allow(dead_code, unused_variables))]

use longspan::WorldDef;
use longspan_scenes::{Effort, Engine};

#[cfg(feature = "peer-box3d")]
mod box3d;
mod checks;
#[cfg(feature = "peer-jolt")]
mod jolt;
mod mass;
mod parts;
#[cfg(feature = "peer-rapier")]
mod rapier;

/// The peer called `name`, set up as `world` says; `None` if this build has no such peer.
///
/// # Panics
/// With `not supported by …` where the engine has no equal of what is asked; if effort or threads are none at all.
pub fn create(name: &str, world: &WorldDef, effort: Effort, threads: usize) -> Option<Box<dyn Engine>> {
    assert!(effort != Effort::N(0) && threads != 0, "an engine needs at least one substep and one thread");
    match name {
        #[cfg(feature = "peer-rapier")]
        "rapier" => Some(Box::new(rapier::Rapier::new(world, effort, threads))),
        #[cfg(feature = "peer-box3d")]
        "box3d" => Some(Box::new(box3d::Box3d::new(world, effort, threads))),
        #[cfg(feature = "peer-jolt")]
        "jolt" => Some(Box::new(jolt::Jolt::new(world, effort, threads))),
        _ => None,
    }
}

/// Gives up on a scene that `engine` cannot express.
fn unsupported(engine: &str, what: &str) -> ! {
    panic!("not supported by {engine}: {what}")
}
