//! A step whose set of pairs does not change takes no memory.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::Run;
use longspan_scenes::DT;

/// The system's allocator, counting what this thread takes.
struct Counting;

thread_local! {
    static TAKEN: Cell<u64> = const { Cell::new(0) };
}

fn note() {
    // Threads that are ending have no counter any more; none of them steps a world.
    let _ = TAKEN.try_with(|taken| taken.set(taken.get() + 1));
}

// SAFETY: every call is handed on unchanged to the system's allocator, which keeps the contract.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        note();
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note();
        // SAFETY: the caller keeps the contract of `realloc`.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations in each of a hundred steps after a scene's end.
fn allocations_after(name: &str, keys: &[(&str, &str)]) -> (Vec<u64>, Run) {
    let mut run = Run::of(name, keys);
    let counts = (0..100).map(|_| {
        let before = TAKEN.get();
        run.engine.world_mut().step(DT).expect("the step length is valid");
        TAKEN.get() - before
    });
    (counts.collect(), run)
}

#[track_caller]
fn takes_no_memory(name: &str, keys: &[(&str, &str)]) {
    let (counts, run) = allocations_after(name, keys);
    let total: u64 = counts.iter().sum();
    let pairs = run.world().report().counts.pairs;
    assert_eq!(total, 0, "{name}: allocations in 100 steps at rest with {pairs} pairs, bound 0; by step {counts:?}");
}

#[test]
fn the_allocator_counts() {
    let before = TAKEN.get();
    std::hint::black_box(Vec::<u8>::with_capacity(100));
    assert_eq!(TAKEN.get() - before, 1, "allocations of one vector");
}

#[test]
fn boxes_balls_capsules_and_joints_at_rest_take_no_memory() {
    takes_no_memory("resting", &[]);
}

#[test]
fn a_swinging_chain_takes_no_memory() {
    takes_no_memory("hanging_chain", &[("n", "10"), ("ratio", "10"), ("seconds", "2")]);
}

#[test]
fn a_bridge_under_its_load_takes_no_memory() {
    takes_no_memory("footbridge", &[("seconds", "6")]);
}

#[test]
fn a_standing_tower_takes_no_memory() {
    takes_no_memory("tower", &[("bodies", "200"), ("ball", "off"), ("seconds", "2")]);
}

#[test]
fn a_sleeping_world_takes_no_memory() {
    let (counts, run) = allocations_after("idle", &[("what", "asleep"), ("n", "100")]);
    assert_eq!(run.world().awake_body_count(), 0, "bodies awake");
    assert_eq!(counts.iter().sum::<u64>(), 0, "allocations in 100 steps asleep, bound 0; by step {counts:?}");
}
