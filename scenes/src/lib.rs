//! Every measured scene once: built through the public API, run on any [`Engine`], judged by one piece of code.
//!
//! [`build`] makes a scene from its name and keys, [`run`] runs it on an engine and returns errors, [`time`] the time of its steps:
//!
//! ```
//! use longspan_scenes::{Effort, LongspanEngine, build, run};
//!
//! let keys = [("n".to_owned(), "3".to_owned()), ("seconds".to_owned(), "0.1".to_owned())];
//! let scene = build("hanging_chain", &keys)?;
//! let mut engine = LongspanEngine::new(&scene.world, Effort::Default, 1)?;
//! let measurement = run(scene, &mut engine, Effort::Default, 1)?;
//! assert_eq!(measurement.steps, 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
mod against;
mod arm;
mod assemble;
pub mod bits;
mod branching;
mod bridge;
mod bridge_car;
mod cable_car;
mod cantilever;
mod catalogue;
mod chain;
mod closed_form;
mod crossbow;
mod crowd;
mod drums;
mod engine;
mod footbridge;
mod fracture;
mod free;
mod friction;
mod gallery;
mod hinge_loop;
mod hoists;
mod idle;
mod impact;
mod longspan_engine;
mod machines;
mod masonry;
pub mod metrics;
mod net;
mod outcome;
mod params;
pub mod picture;
mod pile;
mod platform;
pub mod promises;
mod ragdoll;
mod random;
pub mod reference;
mod run;
mod scene;
mod shifted;
mod stack;
pub mod stress;
mod tensegrity;
mod timing;
mod toppling;
mod track;
mod units;
mod vase;
mod violent;

pub use catalogue::{CATALOGUE, Entry, build};
pub use engine::{Effort, Engine, SceneJoint};
pub use longspan_engine::LongspanEngine;
pub use params::{LONG_RANGE_KINDS, SceneError};
pub use random::Random;
pub use run::{Measurement, NOT_FINITE, RunError, run, run_watched};
pub use scene::{Action, DT, GRAVITY, Scene, Scheduled};
pub use shifted::Shifted;
pub use timing::{Spread, Timing, time};
pub use units::Units;
