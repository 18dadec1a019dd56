//! Peer engines, each behind a cargo feature.

use longspan::WorldDef;
use longspan_scenes::{Effort, Engine};

/// The peer called `name`, set up as `world` says; `None` if this build has no such peer.
pub fn create(name: &str, world: &WorldDef, effort: Effort, threads: usize) -> Option<Box<dyn Engine>> {
    let _ = (name, world, effort, threads);
    None
}
