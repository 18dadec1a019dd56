//! Unions: bodies that rigid fixed joints make one.

use ls_core::{BodyId, UnionInfo};

use crate::access::read;
use crate::boundary::call;
use crate::handle::{LsBody, LsWorld};
use crate::pointer::{Buffer, Out, host};
use crate::result::LsResult;

/// Bodies that rigid fixed joints make one, as the last step left them. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsUnion {
    /// Its dynamic body that was made first: it names the union while both last. Null for no union.
    pub lead: LsBody,
    /// Number of its dynamic bodies; 0 for no union.
    pub members: u32,
    /// Number of fixed joints that it is made of.
    pub joints: u32,
    /// World position of the centre of mass of its dynamic bodies (m).
    pub center: [f64; 3],
    /// Velocity of the centre of mass (m/s).
    pub linear_velocity: [f32; 3],
    /// Angular velocity (rad/s).
    pub angular_velocity: [f32; 3],
    /// Mass of its dynamic bodies (kg).
    pub mass: f32,
    /// 1 if static or kinematic bodies, or the world, hold it, else 0.
    pub anchored: u32,
    /// Worst distance by which its joints contradict one another (m).
    pub distance_residual: f32,
    /// Worst angle by which its joints contradict one another (rad).
    pub angle_residual: f32,
}

impl From<&UnionInfo> for LsUnion {
    fn from(union: &UnionInfo) -> Self {
        Self {
            lead: union.lead.into(),
            members: union.members,
            joints: union.joints,
            center: union.center.to_array(),
            linear_velocity: union.linear_velocity.to_array(),
            angular_velocity: union.angular_velocity.to_array(),
            mass: union.mass,
            anchored: union.anchored.into(),
            distance_residual: union.distance_residual,
            angle_residual: union.angle_residual,
        }
    }
}

impl LsUnion {
    fn none() -> Self {
        Self {
            lead: BodyId::NULL.into(),
            members: 0,
            joints: 0,
            center: [0.0; 3],
            linear_velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
            mass: 0.0,
            anchored: 0,
            distance_residual: 0.0,
            angle_residual: 0.0,
        }
    }
}

/// The union that a dynamic body belongs to. Joints made or changed since the last step count from the next one on, and until then
/// their bodies belong to no union.
///
/// @param world  the world; any value is safe
/// @param body   a body of that world; any value is safe
/// @param out    filled on LS_OK; with a null lead and no members where the body belongs to none
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_union_get(world: LsWorld, body: LsBody, out: *mut LsUnion) -> LsResult {
    call("ls_body_union_get", || {
        let out = host!(Out::new, out);
        read(world, |world| {
            let union = world.union_of(body.into())?;
            out.write(union.as_ref().map_or_else(LsUnion::none, LsUnion::from))
        })
    })
}

/// Dynamic bodies of the union that a body belongs to, in order of their slots; none where it belongs to none.
///
/// @param world     the world; any value is safe
/// @param body      a body of that world; any value is safe
/// @param out       room for capacity handles; may be NULL if capacity is 0
/// @param capacity  number of handles that fit
/// @param count     number of members there are, written whenever it is not NULL and the body can be read
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_body_union_members_get(
    world: LsWorld,
    body: LsBody,
    out: *mut LsBody,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_body_union_members_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            drop(world.union_members(body.into())?);
            buffer.fill(|| world.union_members(body.into()).into_iter().flatten().map(LsBody::from))
        })
    })
}

/// Every union of a world, by lead.
///
/// @param world     the world; any value is safe
/// @param out       room for capacity unions; may be NULL if capacity is 0
/// @param capacity  number of unions that fit
/// @param count     number of unions there are, written whenever it is not NULL and the world can be read
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_unions_get(world: LsWorld, out: *mut LsUnion, capacity: usize, count: *mut usize) -> LsResult {
    call("ls_world_unions_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| buffer.fill(|| world.unions().map(|union| LsUnion::from(&union))))
    })
}
