//! Every measured scene once: built through the public API, run on any [`Engine`], judged by one piece of code.
mod engine;

pub use engine::{Effort, Engine, SceneJoint};
