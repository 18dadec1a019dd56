//! The C interface of longspan: marshalling only.
//!
//! Every export goes through [`boundary::call`]: panics are caught, the host's floating-point environment is set aside, failures
//! become a code and a message. Worlds live in [`registry`] behind handles that are safe to pass whatever their bits; [`access`]
//! decides who may read or edit a world now. `include/longspan/longspan.h` is generated from the items and comments here, which
//! are therefore written for readers of C.

// The order of the modules is the order of the header.
mod result;
mod version;

mod last_error;
mod log;
mod memory;

mod handle;
mod math;

mod shape_def;

mod body_def;

mod strength;

mod motor_def;

mod joint_def;

mod events;
mod report;
mod world_def;

mod callbacks;
mod world;
mod world_events;
mod world_settings;

mod jobs;
mod profiler;

mod query_def;

mod cast;
mod distance;
mod query;

mod draw;

mod snapshot;

mod record;

mod body;
mod body_motion;
mod body_state;

mod shape;

mod joint;

mod support;

mod long_range;

mod chain;

mod union;

mod fracture;

mod cells;

mod stream_def;

mod stream;
mod stream_reader;

// What the header does not show.
mod access;
mod boundary;
mod callback;
mod enums;
mod float_environment;
mod platform;
mod pointer;
mod published;
mod registry;
mod sized;
#[cfg(streams)]
mod stream_host;
#[cfg(streams)]
mod stream_reading;

#[cfg(test)]
mod tests;
