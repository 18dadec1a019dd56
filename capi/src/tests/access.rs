//! Who may use a world when, and what everybody else gets at once.

use std::ffi::c_void;
use std::ptr;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use super::{DT, create_overload, create_world, out};
use crate::body::ls_body_destroy;
use crate::body_motion::ls_body_pose_get;
use crate::events::LsJointOverload;
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::joint::ls_joint_break_set;
use crate::result::*;
use crate::world::{ls_world_destroy, ls_world_gravity_set, ls_world_step_count_get};
use crate::world_events::{ls_world_overload_callback_set, ls_world_overloaded_joints_get, ls_world_step};

/// What calls from inside a callback got, on the stepping thread and on another.
#[derive(Debug, PartialEq, Default)]
struct Seen {
    calls: usize,
    own_reads: Vec<LsResult>,
    own_edits: Vec<LsResult>,
    other_reads: Vec<LsResult>,
    other_edits: Vec<LsResult>,
    listed: usize,
}

struct Scene {
    body: LsBody,
    joint: LsJoint,
    seen: Seen,
}

fn reads(world: LsWorld, body: LsBody) -> Vec<LsResult> {
    let mut pose = std::mem::MaybeUninit::uninit();
    let mut steps = 0;
    // SAFETY: all pointers are valid.
    unsafe { vec![ls_body_pose_get(world, body, pose.as_mut_ptr()), ls_world_step_count_get(world, &mut steps)] }
}

fn edits(world: LsWorld, body: LsBody, joint: LsJoint) -> Vec<LsResult> {
    let gravity = [0.0_f32; 3];
    vec![
        ls_joint_break_set(world, joint, 5.0, 5.0),
        ls_body_destroy(world, body),
        // SAFETY: three floats are there.
        unsafe { ls_world_gravity_set(world, gravity.as_ptr()) },
        ls_world_step(world, DT),
        ls_world_destroy(world),
    ]
}

unsafe extern "C" fn on_overload(world: LsWorld, overload: *const LsJointOverload, user: *mut c_void) {
    // SAFETY: the test gave this pointer to the callback, and waits for the step.
    let scene = unsafe { &mut *user.cast::<Scene>() };
    let (body, joint) = (scene.body, scene.joint);
    scene.seen.calls += 1;
    // SAFETY: valid during the call.
    assert_eq!(unsafe { (*overload).joint }, joint);
    scene.seen.own_reads = reads(world, body);
    scene.seen.own_edits = edits(world, body, joint);
    (scene.seen.other_reads, scene.seen.other_edits) =
        thread::spawn(move || (reads(world, body), edits(world, body, joint))).join().expect("the library does not unwind");
    let (mut list, mut count) = (ptr::null(), 0);
    // SAFETY: both pointers are valid.
    assert_eq!(unsafe { ls_world_overloaded_joints_get(world, &mut list, &mut count) }, LS_OK);
    scene.seen.listed = count;
}

#[test]
fn inside_a_callback_reads_work_and_edits_are_refused_without_waiting() {
    let world = create_world();
    let (body, joint) = create_overload(world);
    let mut scene = Scene { body, joint, seen: Seen::default() };
    // SAFETY: the scene outlives the callback.
    assert_eq!(unsafe { ls_world_overload_callback_set(world, Some(on_overload), (&raw mut scene).cast()) }, LS_OK);
    assert_eq!(ls_world_step(world, DT), LS_OK);
    let expected = Seen {
        calls: 1,
        own_reads: vec![LS_OK; 2],
        own_edits: vec![LS_ERROR_WORLD_LOCKED; 5],
        other_reads: vec![LS_OK; 2],
        other_edits: vec![LS_ERROR_WORLD_BUSY; 5],
        listed: 1,
    };
    assert_eq!(scene.seen, expected);
    assert_eq!(edits(world, body, joint), vec![LS_OK; 5], "after the step everything is allowed again");
}

#[test]
fn while_a_world_steps_other_threads_get_busy_at_once() {
    let world = create_world();
    for i in 0..2000 {
        super::create_ball(world, crate::body_def::LS_BODY_DYNAMIC, f64::from(i));
    }
    let (send, receive) = mpsc::channel();
    let stepping = thread::spawn(move || {
        while receive.try_recv().is_err() {
            let result = ls_world_step(world, 1.0e-4);
            assert!(matches!(result, LS_OK | LS_ERROR_WORLD_BUSY), "step: result {result}");
        }
    });
    let (mut busy, mut ok, mut longest) = (0, 0, Duration::ZERO);
    let deadline = Instant::now() + Duration::from_secs(10);
    while (busy == 0 || ok == 0) && Instant::now() < deadline {
        let start = Instant::now();
        let mut steps = 0_u64;
        // SAFETY: the pointer is valid.
        match unsafe { ls_world_step_count_get(world, &mut steps) } {
            LS_OK => ok += 1,
            LS_ERROR_WORLD_BUSY => busy += 1,
            other => panic!("read: result {other}"),
        }
        longest = longest.max(start.elapsed());
    }
    send.send(()).expect("the other thread listens");
    stepping.join().expect("the library does not unwind");
    assert!(busy > 0 && ok > 0, "{busy} reads were busy, {ok} worked, the longest took {longest:?}");
    assert_eq!(ls_world_destroy(world), LS_OK);
}

#[test]
fn of_two_threads_that_destroy_a_world_one_succeeds() {
    for _ in 0..50 {
        let world = create_world();
        let threads: Vec<_> = (0..2).map(|_| thread::spawn(move || ls_world_destroy(world))).collect();
        let mut results: Vec<LsResult> = threads.into_iter().map(|t| t.join().expect("the library does not unwind")).collect();
        results.sort_unstable();
        assert_eq!(results[0], LS_OK);
        assert!(matches!(results[1], LS_ERROR_ALREADY_DESTROYED | LS_ERROR_WORLD_BUSY), "second: result {}", results[1]);
    }
}

#[test]
fn every_bit_pattern_is_safe_as_a_world() {
    let world = create_world();
    assert_eq!(ls_world_step(world, DT), LS_OK);
    let mut pattern = 0x9E37_79B9_7F4A_7C15_u64;
    // The lowest 28 bits are the index: with another one, the handle may be that of a world of another test.
    for bit in 28..64 {
        let one_off = ls_world_step(LsWorld { id: world.id ^ (1 << bit) }, DT);
        assert!(matches!(one_off, LS_ERROR_INVALID_HANDLE | LS_ERROR_STALE_HANDLE), "bit {bit}: result {one_off}");
        pattern ^= pattern << 13;
        pattern ^= pattern >> 7;
        pattern ^= pattern << 17;
        assert_eq!(ls_world_step(LsWorld { id: pattern }, DT), LS_ERROR_INVALID_HANDLE, "{pattern:#x}");
        assert_eq!(ls_world_step(LsWorld { id: bit + 1 }, DT), LS_ERROR_INVALID_HANDLE, "{bit}");
    }
    assert_eq!(ls_world_destroy(world), LS_OK);
    assert_eq!(ls_world_step(world, DT), LS_ERROR_STALE_HANDLE);
    let next = out(|out| {
        // SAFETY: both pointers are valid.
        unsafe { crate::world::ls_world_create(&crate::world_def::LsWorldDef::default(), out) }
    });
    assert_ne!(next, world);
    assert_eq!(ls_world_destroy(world), LS_ERROR_ALREADY_DESTROYED);
    assert_eq!(ls_world_destroy(next), LS_OK);
}
