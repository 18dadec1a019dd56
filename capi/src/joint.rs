//! Joints.

use ls_core::{JointAxisState, JointState};

use crate::access::{edit, read};
use crate::boundary::call;
use crate::enums;
use crate::handle::{LsJoint, LsWorld};
use crate::joint_def::LsJointDef;
use crate::math::LsPose;
use crate::motor_def::LsSoftness;
use crate::pointer::{self, Out, host};
use crate::result::LsResult;
use crate::sized::{self, SizedOut, Versioned};

/// What a joint does at the end of the last step. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsJointState {
    /// Coordinate of the free axis: angle, turns counted (rad), translation or distance (m); 0 for other kinds.
    pub position: f32,
    /// Its rate (rad/s or m/s).
    pub velocity: f32,
    /// Force that the joint exerts on body B at its point, world axes, mean over the step (N).
    pub force: [f32; 3],
    /// Torque that the joint exerts on body B about its point, world axes, mean over the step (N m).
    pub torque: [f32; 3],
    /// Distance between the two joint points beyond what the joint allows (m).
    pub gap: f32,
    /// Force (N) or torque (N m) on body B along the free axis, mean over the step: what motor, friction, spring, stops at limits and a
    /// distance that is held come to. 0 for kinds without a coordinate; of these torque has all.
    pub effort: f32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsJointState {
    const SIZES: &'static [usize] = &[36, 40];
}

impl From<JointState> for LsJointState {
    fn from(state: JointState) -> Self {
        Self {
            position: state.position,
            velocity: state.velocity,
            force: state.force.to_array(),
            torque: state.torque.to_array(),
            gap: state.gap,
            effort: state.effort,
        }
    }
}

/// One axis of a joint at the end of the last step. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsJointAxisState {
    /// Its coordinate: angle, turns counted (rad), translation or distance (m).
    pub position: f32,
    /// Rate of the coordinate (rad/s or m/s).
    pub velocity: f32,
    /// Force (N) or torque (N m) on body B along the axis, mean over the step: all that acts there.
    pub effort: f32,
    /// That of the motor alone (N or N m).
    pub motor: f32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsJointAxisState {
    const SIZES: &'static [usize] = &[16];
}

impl From<JointAxisState> for LsJointAxisState {
    fn from(state: JointAxisState) -> Self {
        Self { position: state.position, velocity: state.velocity, effort: state.effort, motor: state.motor }
    }
}

/// Creates a joint between two bodies, or a body and the world; it is idle while none of them is dynamic.
///
/// @param world  the world; any value is safe
/// @param def    filled by ls_joint_def_init and changed as wanted; read during the call
/// @param out    the joint, on LS_OK; the world owns it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
///         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_NOT_APPLICABLE,
///         LS_ERROR_CAPACITY_EXCEEDED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_create(world: LsWorld, def: *const LsJointDef, out: *mut LsJoint) -> LsResult {
    call("ls_joint_create", || {
        let (def, out) = (host!(sized::read, def), host!(Out::new, out));
        let def = (&def).try_into()?;
        out.write(edit(world, |world| world.create_joint(&def))?.into())
    })
}

/// Destroys a joint.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_destroy(world: LsWorld, joint: LsJoint) -> LsResult {
    call("ls_joint_destroy", || edit(world, |world| world.destroy_joint(joint.into())))
}

/// The definition that a joint has now. It may be given to ls_joint_create.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param out    filled on LS_OK; fields that the kind does not name have their defaults
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_def_get(world: LsWorld, joint: LsJoint, out: *mut LsJointDef, size: usize) -> LsResult {
    call("ls_joint_def_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write_definition(&(&world.joint_def(joint.into())?).try_into()?))
    })
}

/// What a joint does at the end of the last step.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_state_get(world: LsWorld, joint: LsJoint, out: *mut LsJointState, size: usize) -> LsResult {
    call("ls_joint_state_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write(&world.joint_state(joint.into())?.into()))
    })
}

/// One axis of a joint at the end of the last step, numbered as in LsJointStop: axis 0 of a hinge, a prismatic or a distance joint; the
/// twist (0) and the swing (1) of a spherical joint; the translations along x, y and z (0 to 2) and the rotations about them (3 to 5)
/// of a generic joint.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param axis   number of the axis
/// @param out    filled on LS_OK
/// @param size   sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_axis_state_get(
    world: LsWorld,
    joint: LsJoint,
    axis: u32,
    out: *mut LsJointAxisState,
    size: usize,
) -> LsResult {
    call("ls_joint_axis_state_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write(&world.joint_axis_state(joint.into(), axis)?.into()))
    })
}

/// Sets what a joint allows: new limits or motors of the same kind.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param def    of it, kind and the fields that the kind names are read; kind must be that of the joint
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
///         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_NOT_APPLICABLE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_kind_set(world: LsWorld, joint: LsJoint, def: *const LsJointDef) -> LsResult {
    call("ls_joint_kind_set", || {
        let kind = (&host!(sized::read, def)).try_into()?;
        edit(world, |world| world.set_joint_kind(joint.into(), kind))
    })
}

/// Sets the give of a joint.
///
/// @param world    the world; any value is safe
/// @param joint    a joint of that world; any value is safe
/// @param linear   give of the rows that hold points together, and of a distance joint's spring
/// @param angular  give of the rows that hold directions together
/// @param limit    give of the stops at limits
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_softness_set(
    world: LsWorld,
    joint: LsJoint,
    linear: *const LsSoftness,
    angular: *const LsSoftness,
    limit: *const LsSoftness,
) -> LsResult {
    call("ls_joint_softness_set", || {
        let linear = host!(pointer::read, linear).into();
        let angular = host!(pointer::read, angular).into();
        let limit = host!(pointer::read, limit).into();
        edit(world, |world| world.set_joint_softness(joint.into(), linear, angular, limit))
    })
}

/// Sets the dry friction of a hinge, prismatic or spherical joint, and wakes its bodies: LsJointDef.friction, which
/// ls_joint_def_get tells.
///
/// @param world     the world; any value is safe
/// @param joint     a joint of that world; any value is safe
/// @param friction  (N m; N of a prismatic joint), >= 0
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_friction_set(world: LsWorld, joint: LsJoint, friction: f32) -> LsResult {
    call("ls_joint_friction_set", || edit(world, |world| world.set_joint_friction(joint.into(), friction)))
}

/// Sets the dry friction of a generic joint's axes, and wakes its bodies: LsJointDef.axis_friction, which ls_joint_def_get tells.
///
/// @param world     the world; any value is safe
/// @param joint     a joint of that world; any value is safe
/// @param friction  six floats: along x, y, z (N), then about them (N m), >= 0
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
/// cbindgen:ptrs-as-arrays=[[friction;6]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_axis_friction_set(world: LsWorld, joint: LsJoint, friction: *const f32) -> LsResult {
    call("ls_joint_axis_friction_set", || {
        let friction = friction.cast::<[f32; 6]>();
        let friction = host!(pointer::read, friction);
        edit(world, |world| world.set_joint_axis_friction(joint.into(), friction))
    })
}

/// Sets the restitution of a joint's rigid stops, and wakes its bodies: LsJointDef.restitution, which ls_joint_def_get tells.
///
/// @param world        the world; any value is safe
/// @param joint        a joint of that world; any value is safe
/// @param restitution  coefficient of restitution, 0 to 1: a limit that is met at v is left at this share of v
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_restitution_set(world: LsWorld, joint: LsJoint, restitution: f32) -> LsResult {
    call("ls_joint_restitution_set", || edit(world, |world| world.set_joint_restitution(joint.into(), restitution)))
}

/// Sets the load at which a joint is reported as overloaded.
///
/// @param world         the world; any value is safe
/// @param joint         a joint of that world; any value is safe
/// @param break_force   (N), >= 0, INFINITY for never
/// @param break_torque  (N m), >= 0, INFINITY for never
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_break_set(world: LsWorld, joint: LsJoint, break_force: f32, break_torque: f32) -> LsResult {
    call("ls_joint_break_set", || edit(world, |world| world.set_joint_break(joint.into(), break_force, break_torque)))
}

/// Says whether long-range constraints are derived from a joint, and wakes its bodies. Without it a chain ends there.
///
/// @param world    the world; any value is safe
/// @param joint    a joint of that world; any value is safe
/// @param enabled  not 0: bounds lead past it, it may be in a plane of hinges, and, fixed, in a union; 0: none of these
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_long_range_set(world: LsWorld, joint: LsJoint, enabled: u32) -> LsResult {
    call("ls_joint_long_range_set", || edit(world, |world| world.set_joint_long_range(joint.into(), enabled != 0)))
}

/// Says how the articulation of a joint is solved, and wakes its bodies: LsJointDef.solver.
///
/// @param world   the world; any value is safe
/// @param joint   a joint of that world; any value is safe
/// @param solver  LS_SOLVER_ constant
/// @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_solver_set(world: LsWorld, joint: LsJoint, solver: i32) -> LsResult {
    call("ls_joint_solver_set", || {
        let solver = enums::solver(solver)?;
        edit(world, |world| world.set_joint_solver(joint.into(), solver))
    })
}

/// Sets where a joint is on its bodies and wakes them; the joint carries nothing over, as after a teleport.
///
/// @param world    the world; any value is safe
/// @param joint    a joint of that world; any value is safe
/// @param frame_a  joint frame on body A, in its frame (in world coordinates if A is the world); positions (m)
/// @param frame_b  joint frame on body B, likewise
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE,
///         LS_ERROR_NOT_UNIT
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_frames_set(
    world: LsWorld,
    joint: LsJoint,
    frame_a: *const LsPose,
    frame_b: *const LsPose,
) -> LsResult {
    call("ls_joint_frames_set", || {
        let (frame_a, frame_b) = (host!(pointer::read, frame_a), host!(pointer::read, frame_b));
        edit(world, |world| world.set_joint_frames(joint.into(), frame_a.into(), frame_b.into()))
    })
}

/// The host's own word of a joint.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_joint_user_word_get(world: LsWorld, joint: LsJoint, out: *mut u64) -> LsResult {
    call("ls_joint_user_word_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.joint_def(joint.into())?.user_word))
    })
}

/// Sets the host's own word of a joint.
///
/// @param world  the world; any value is safe
/// @param joint  a joint of that world; any value is safe
/// @param word   any value
/// @return LS_OK, a world error, a handle error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_joint_user_word_set(world: LsWorld, joint: LsJoint, word: u64) -> LsResult {
    call("ls_joint_user_word_set", || edit(world, |world| world.set_joint_user_word(joint.into(), word)))
}
