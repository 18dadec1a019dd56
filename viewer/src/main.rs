//! Watches a stream, or looks through a recording of one.

fn main() {}
