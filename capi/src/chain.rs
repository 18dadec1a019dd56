//! Chains of joints: how far they are stretched, and what their links bear.

use ls_core::{ChainLink, ChainState};

use crate::access::read;
use crate::boundary::call;
use crate::handle::{LsBody, LsJoint, LsWorld};
use crate::pointer::{Buffer, host};
use crate::result::LsResult;
use crate::sized::{SizedOut, Versioned};

/// A chain of joints as the last step left it. Later versions append fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LsChainState {
    /// Links: bodies between two joints.
    pub link_count: u32,
    /// Length at rest: the sum of its links (m).
    pub rest_length: f32,
    /// Length now: with what each joint is apart, those at both ends among them (m).
    pub length: f32,
    /// Fraction of its length at rest by which it is longer than that.
    pub stretch: f32,
    /// Greatest tension of a link, mean over the last step (N); negative where all are pushed together.
    pub greatest_tension: f32,
}

// SAFETY: numbers without padding.
unsafe impl Versioned for LsChainState {
    const SIZES: &'static [usize] = &[20];
}

/// A link of a chain: a body between two joints. The layout of this struct never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LsChainLink {
    /// The body; of a union, the member at the first joint.
    pub body: LsBody,
    /// The joints at its two ends.
    pub joints: [LsJoint; 2],
    /// Distance of the two joints on it (m).
    pub length: f32,
    /// Force that the two pull it apart with, mean over the last step (N); negative where they push.
    pub tension: f32,
}

/// How far the chain between two joints is stretched, and what it bears. It leads along the shortest path past bodies that joints can
/// move and joints that hold two points together without give.
///
/// @param world    the world; any value is safe
/// @param joint_a  a joint of that world; any value is safe
/// @param joint_b  another one, connected to it; any value is safe
/// @param out      filled on LS_OK
/// @param size     sizeof *out as the host knows it
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (the two are the
///         same, or no chain connects them)
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_chain_state_get(
    world: LsWorld,
    joint_a: LsJoint,
    joint_b: LsJoint,
    out: *mut LsChainState,
    size: usize,
) -> LsResult {
    call("ls_chain_state_get", || {
        let out = host!(SizedOut::new, out, size);
        read(world, |world| out.write(&(&world.chain(joint_a.into(), joint_b.into())?).into()))
    })
}

/// The links of the chain between two joints, from the first joint to the second, as ls_chain_state_get finds it.
///
/// @param world     the world; any value is safe
/// @param joint_a   a joint of that world; any value is safe
/// @param joint_b   another one, connected to it; any value is safe
/// @param out       room for `capacity` links, may be NULL if that is 0
/// @param capacity  how many fit
/// @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
/// @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out`
///         then), LS_ERROR_NOT_APPLICABLE (the two are the same, or no chain connects them)
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_chain_links_get(
    world: LsWorld,
    joint_a: LsJoint,
    joint_b: LsJoint,
    out: *mut LsChainLink,
    capacity: usize,
    count: *mut usize,
) -> LsResult {
    call("ls_chain_links_get", || {
        let buffer = host!(Buffer::new, out, capacity, count);
        read(world, |world| {
            let chain = world.chain(joint_a.into(), joint_b.into())?;
            buffer.fill(|| chain.links.iter().map(LsChainLink::from))
        })
    })
}

impl From<&ChainState> for LsChainState {
    fn from(chain: &ChainState) -> Self {
        Self {
            link_count: chain.links.len() as u32,
            rest_length: chain.rest_length,
            length: chain.length,
            stretch: chain.stretch,
            greatest_tension: chain.greatest_tension(),
        }
    }
}

impl From<&ChainLink> for LsChainLink {
    fn from(link: &ChainLink) -> Self {
        let &ChainLink { body, joints, length, tension } = link;
        Self { body: body.into(), joints: joints.map(LsJoint::from), length, tension }
    }
}
