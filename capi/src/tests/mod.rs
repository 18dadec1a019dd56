//! Tests that need the inside of the library: layout, locking, panics. What a host can see is tested from C, in `tests/`.

mod access;
mod layout;
mod panics;

use std::ptr;

use crate::body::ls_body_create;
use crate::body_def::{LS_BODY_STATIC, LsBodyDef};
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::joint::ls_joint_create;
use crate::joint_def::{LS_JOINT_SPHERICAL, LsJointDef};
use crate::math::LsPose;
use crate::result::{LS_OK, LsResult};
use crate::shape_def::LsShapeDef;
use crate::world::ls_world_create;
use crate::world_def::LsWorldDef;

const DT: f32 = 1.0 / 60.0;

fn out<T>(call: impl FnOnce(*mut T) -> LsResult) -> T {
    let mut value = std::mem::MaybeUninit::uninit();
    assert_eq!(call(value.as_mut_ptr()), LS_OK);
    // SAFETY: a call that succeeds has written its result; every result takes any bytes.
    unsafe { value.assume_init() }
}

fn create_world() -> LsWorld {
    // SAFETY: both pointers are valid.
    out(|world| unsafe { ls_world_create(&LsWorldDef::default(), world) })
}

fn create_ball(world: LsWorld, kind: i32, y: f64) -> LsBody {
    let shape = LsShapeDef::default();
    let pose = LsPose { position: [0.0, y, 0.0], rotation: [0.0, 0.0, 0.0, 1.0] };
    let def = LsBodyDef { kind, pose, shapes: ptr::from_ref(&shape), shape_count: 1, ..LsBodyDef::default() };
    // SAFETY: all pointers are valid.
    out(|body| unsafe { ls_body_create(world, &def, body) })
}

/// A ball that hangs from another by a joint too weak for it: 524 kg on 1 N.
fn create_overload(world: LsWorld) -> (LsBody, LsJoint) {
    let body_b = create_ball(world, crate::body_def::LS_BODY_DYNAMIC, -2.0);
    let below = LsPose { position: [0.0, -1.0, 0.0], rotation: [0.0, 0.0, 0.0, 1.0] };
    let above = LsPose { position: [0.0, 1.0, 0.0], ..below };
    let def = LsJointDef {
        kind: LS_JOINT_SPHERICAL,
        body_a: create_ball(world, LS_BODY_STATIC, 0.0),
        body_b,
        frame_a: below,
        frame_b: above,
        break_force: 1.0,
        ..LsJointDef::default()
    };
    // SAFETY: both pointers are valid.
    (body_b, out(|joint| unsafe { ls_joint_create(world, &def, joint) }))
}
