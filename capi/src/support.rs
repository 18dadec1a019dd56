//! What holds a body up, and what would fall without it.

use ls_core::{BodyId, BodySupport, SupportChange, Verdict};

use crate::access::{edit, read};
use crate::boundary::call;
use crate::handle::{LsBody, LsWorld};
use crate::pointer::{self, Buffer, Out, OutArray, host};
use crate::result::{LsResult, Outcome};

/// The body stands: its centre of mass lies over the hull of the supporting contacts below it.
pub const LS_SUPPORT_SUPPORTED: i32 = 0;
/// Joints hold the body to the ground, or to a body that is supported.
pub const LS_SUPPORT_HELD_BY_JOINTS: i32 = 1;
/// The body is static, or kinematic and at rest: it needs no support.
pub const LS_SUPPORT_GROUND: i32 = 2;
/// Nothing presses against the body from below.
pub const LS_SUPPORT_NO_CONTACT: i32 = 3;
/// Every contact below the body slides.
pub const LS_SUPPORT_SLIDING: i32 = 4;
/// What the body stands on carries no load there: it is unsupported itself, moves, or ends before there.
pub const LS_SUPPORT_ON_UNSUPPORTED: i32 = 5;
/// The body's centre of mass lies outside the hull of its supporting contacts, or on its edge.
pub const LS_SUPPORT_OUTSIDE_HULL: i32 = 6;
/// Joints tie the body to others, none of which is supported.
pub const LS_SUPPORT_HANGING_LOOSE: i32 = 7;
/// The body is kinematic and on the move.
pub const LS_SUPPORT_MOVING: i32 = 8;
/// There is no gravity.
pub const LS_SUPPORT_NO_GRAVITY: i32 = 9;
/// The pushes of contacts that hold balance the body's weight, though they are not all below it: it is held up.
pub const LS_SUPPORT_BRACED: i32 = 10;

/// The verdict on a body at the end of the last step. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSupport {
    /// LS_SUPPORT_ constant; the first three, and LS_SUPPORT_BRACED, mean that the body is held up.
    pub verdict: i32,
    /// How far its centre of mass lies inside the hull of its supporting contacts, seen along gravity (m): negative outside,
    /// minus infinity without supporting contacts.
    pub margin: f32,
}

/// A body that gained or lost its support in a step. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsSupportChange {
    /// The body.
    pub body: LsBody,
    /// The word its host gave it.
    pub user_word: u64,
    /// 1 if it is supported now, else 0.
    pub supported: u32,
    /// Not used; 0.
    pub reserved: u32,
}

impl From<BodySupport> for LsSupport {
    fn from(support: BodySupport) -> Self {
        let verdict = match support.verdict {
            Verdict::Supported => LS_SUPPORT_SUPPORTED,
            Verdict::HeldByJoints => LS_SUPPORT_HELD_BY_JOINTS,
            Verdict::Ground => LS_SUPPORT_GROUND,
            Verdict::NoContact => LS_SUPPORT_NO_CONTACT,
            Verdict::Sliding => LS_SUPPORT_SLIDING,
            Verdict::OnUnsupported => LS_SUPPORT_ON_UNSUPPORTED,
            Verdict::OutsideHull => LS_SUPPORT_OUTSIDE_HULL,
            Verdict::HangingLoose => LS_SUPPORT_HANGING_LOOSE,
            Verdict::Moving => LS_SUPPORT_MOVING,
            Verdict::NoGravity => LS_SUPPORT_NO_GRAVITY,
            Verdict::Braced => LS_SUPPORT_BRACED,
        };
        Self { verdict, margin: support.margin }
    }
}

impl From<&SupportChange> for LsSupportChange {
    fn from(change: &SupportChange) -> Self {
        let SupportChange { body, user_word, supported } = *change;
        Self { body: body.into(), user_word, supported: supported.into(), reserved: 0 }
    }
}

/// Switches the support analysis on or off; at the start it is off and costs nothing.
///
/// While it is on, every step ends with it, and the other ls_support_ functions answer.
/// @param world  the world; any value is safe
/// @param on     0 for off, anything else for on
/// @return LS_OK, a world error
/// Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
#[unsafe(no_mangle)]
pub extern "C" fn ls_support_enabled_set(world: LsWorld, on: u32) -> LsResult {
    call("ls_support_enabled_set", || {
        edit(world, |world| {
            world.set_support(on != 0);
            Ok(())
        })
    })
}

/// Whether bodies are held up, or why not.
///
/// @param world   the world; any value is safe
/// @param bodies  bodies of that world; any values are safe; may be NULL if count is 0
/// @param count   number of bodies
/// @param out     room for as many verdicts, filled on LS_OK; may be NULL if count is 0
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_get(world: LsWorld, bodies: *const LsBody, count: usize, out: *mut LsSupport) -> LsResult {
    call("ls_support_get", || {
        // SAFETY: the header asks the host for as many bodies, and for room for as many verdicts.
        let (bodies, out) = unsafe { (pointer::slice(bodies, count, "bodies")?, OutArray::new(out, count, "out")?) };
        read(world, |world| {
            let supports = bodies.iter().map(|&body| Ok(world.support(body.into())?.into()));
            let supports = supports.collect::<Outcome<Vec<LsSupport>>>()?;
            out.write(supports.into_iter());
            Ok(())
        })
    })
}

/// Number of dynamic bodies that have support, by the changes told so far.
///
/// @param world  the world; any value is safe
/// @param out    filled on LS_OK
/// @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_count_get(world: LsWorld, out: *mut usize) -> LsResult {
    call("ls_support_count_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.supported_count()?))
    })
}

/// Dynamic bodies that gained or lost support in the last step. A loss is told at once, a gain when it has lasted for six steps.
///
/// @param world     the world; any value is safe
/// @param out       room for capacity changes; may be NULL if capacity is 0
/// @param capacity  number of changes that fit
/// @param count     number of changes there are, written whenever it is not NULL and the world can be read
/// @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_changes_get(
    world: LsWorld,
    out: *mut LsSupportChange,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_changes_get", || {
        let out = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let changes = world.support_changes()?;
            out.fill(|| changes.iter().map(LsSupportChange::from))
        })
    })
}

/// Corners of the hull of a body's supporting contacts, seen along gravity: in the plane through its centre of mass across gravity.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity points of three numbers (m); may be NULL if capacity is 0
/// @param capacity  number of points that fit
/// @param count     number of corners, written whenever it is not NULL and the body can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_hull_get(
    world: LsWorld,
    body: LsBody,
    out: *mut [f64; 3],
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_hull_get", || {
        let out = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let hull = world.support_hull(body.into())?;
            out.fill(|| hull.iter().map(|point| point.to_array()))
        })
    })
}

/// Bodies that carry a body, through supporting contacts or joints.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity bodies; may be NULL if capacity is 0
/// @param capacity  number of bodies that fit
/// @param count     number of bodies there are, written whenever it is not NULL and the body can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_carriers_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsBody,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_carriers_get", || {
        let out = host!(Buffer::new, out, capacity, count);
        read(world, |world| fill(&out, &world.supporters(body.into())?))
    })
}

/// Bodies that a body carries through supporting contacts, or that hang on it by joints.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity bodies; may be NULL if capacity is 0
/// @param capacity  number of bodies that fit
/// @param count     number of bodies there are, written whenever it is not NULL and the body can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_carried_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsBody,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_carried_get", || {
        let out = host!(Buffer::new, out, capacity, count);
        read(world, |world| fill(&out, &world.supported_by(body.into())?))
    })
}

/// The way that a body's weight takes to the ground: the body itself, then always what carries most of the one before, to a body
/// that needs no support. Empty for a body without support; a joint to the world itself ends the way.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity bodies; may be NULL if capacity is 0
/// @param capacity  number of bodies that fit
/// @param count     number of bodies there are, written whenever it is not NULL and the body can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_path_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsBody,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_path_get", || {
        let out = host!(Buffer::new, out, capacity, count);
        read(world, |world| fill(&out, &world.path_to_ground(body.into())?))
    })
}

/// Force with which everything that stands on a body presses it down, along gravity, in the last substep.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    force (N), filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_load_get(world: LsWorld, body: LsBody, out: *mut f32) -> LsResult {
    call("ls_support_load_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.load_on(body.into())?))
    })
}

/// Force with which one body presses another down through their contacts, along gravity, in the last substep.
///
/// @param world  the world; any value is safe
/// @param upper  a body of that world; any value is safe
/// @param lower  a body of that world; any value is safe
/// @param out    force (N), filled on LS_OK
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_load_between_get(world: LsWorld, upper: LsBody, lower: LsBody, out: *mut f32) -> LsResult {
    call("ls_support_load_between_get", || {
        let out = host!(Out::new, out);
        read(world, |world| out.write(world.load_between(upper.into(), lower.into())?))
    })
}

/// Bodies that are supported now and would not be without some others. The world stays as it is.
///
/// This asks the graph of contacts, joints and hulls; it is not a simulation. It knows what no longer reaches the ground or has its
/// centre of mass over nothing, but not what a fall would knock over, nor that what is left might slide.
/// @param world          the world; any value is safe
/// @param removed        bodies of that world; any values are safe; may be NULL if removed_count is 0
/// @param removed_count  number of them
/// @param out            room for capacity bodies; may be NULL if capacity is 0
/// @param capacity       number of bodies that fit
/// @param count          number of bodies there are, written whenever it is not NULL and the bodies can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
///         LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_support_loss_predict(
    world: LsWorld,
    removed: *const LsBody,
    removed_count: usize,
    out: *mut LsBody,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_support_loss_predict", || {
        // SAFETY: the header asks the host for as many bodies.
        let removed = unsafe { pointer::slice(removed, removed_count, "removed")? };
        let out = host!(Buffer::new, out, capacity, count);
        let removed: Vec<BodyId> = removed.iter().map(|&body| body.into()).collect();
        read(world, |world| fill(&out, &world.would_lose_support(&removed)?))
    })
}

fn fill(out: &Buffer<LsBody>, bodies: &[BodyId]) -> Outcome<()> {
    out.fill(|| bodies.iter().map(|&body| LsBody::from(body)))
}
