//! Solves one large batch on several threads: blocks of one colour side by side, then bodies.
//!
//! Colours follow one another as they do on one thread, and within one no block sees what another does, so the bits are the same. It
//! takes a team that is awake: a sweep over a colour is some 20 µs.

use std::ops::Range;

use smallvec::SmallVec;

use super::contact_block::{BlockView, ContactBlocks};
use super::contact_kernels;
use super::contact_partition::{BlockPart, BlockRange, DividedBlocks};
use super::disjoint::{DisjointMut, Shared};
use super::state::{BodyMotion, BodyVelocity};
use crate::workers::Workers;

/// Blocks from which on several threads go through them, and how long one thread takes for one (µs): 3 µs for 16.
const SHARED_BLOCKS: usize = 64;
const BLOCK_TIME: f32 = 0.2;

/// Sweeps over the contacts of bodies that joints hold, with each other and with what is fixed, between two sweeps over the joints. A
/// contact sees of such a body its own mass alone: what a vehicle rests on its track with, or the track's pull round a sprocket, gets
/// through links of a hundredth of its mass a little at a time. An odd number, to and fro, so that sweeps back are the exact reverse.
const JOINTED_SWEEPS: u32 = 3;

/// Threads that sweeps over the contacts feed: the same for all ranges and purposes, so that each keeps its blocks and bodies.
fn useful_places(contacts: &ContactBlocks, threads: &Workers) -> usize {
    threads.places_for(contacts.len() as f32 * BLOCK_TIME, contacts.colors.len())
}

/// Goes through the blocks of a range with the velocities of bodies, so many of which move: colour after colour, or backwards.
pub(super) fn in_colors(
    contacts: &mut ContactBlocks,
    range: Range<usize>,
    threads: &Workers,
    (velocities, moving): (&mut [BodyVelocity], usize),
    backwards: bool,
    work: impl Fn(&mut BlockPart<'_>, &mut DisjointMut<'_, BodyVelocity>) + Sync,
) {
    if range.is_empty() {
        return;
    }
    if range.len() < SHARED_BLOCKS || !threads.has_team() {
        return work(&mut contacts.part(range), &mut DisjointMut::alone(velocities, moving));
    }
    in_colors_shared(contacts, range, threads, (velocities, moving), backwards, work);
}

/// [`in_colors`] by several threads, out of the way of one that is alone.
#[inline(never)]
fn in_colors_shared(
    contacts: &mut ContactBlocks,
    range: Range<usize>,
    threads: &Workers,
    (velocities, moving): (&mut [BodyVelocity], usize),
    backwards: bool,
    work: impl Fn(&mut BlockPart<'_>, &mut DisjointMut<'_, BodyVelocity>) + Sync,
) {
    debug_assert!(contacts.are_apart(moving), "blocks of one colour share a moving body");
    let shared = Shared::new(velocities, moving);
    let places = useful_places(contacts, threads);
    let pieces = contacts.colored_pieces(&range, places);
    let pieces = pieces.into_iter().map(|piece| (piece.phase, piece.place, piece.runs));
    let work = |runs: SmallVec<[BlockRange<'_>; 2]>| {
        // SAFETY: what is worked on at the same time is of one phase, the blocks of one colour, which share no moving body.
        let mut hand = unsafe { shared.hand() };
        let mut work = |mut run: BlockRange<'_>| work(&mut run.part, &mut hand);
        if backwards { runs.into_iter().rev().for_each(work) } else { runs.into_iter().for_each(&mut work) }
    };
    if backwards {
        threads.share_in_phases(pieces.rev(), work);
    } else {
        threads.share_in_phases(pieces, work);
    }
}

/// Goes through all blocks in any order, each with the thread that goes through it in sweeps.
pub(super) fn side_by_side(contacts: &mut ContactBlocks, threads: &Workers, work: impl Fn(BlockRange<'_>) + Sync) {
    if threads.has_team() {
        let places = useful_places(contacts, threads);
        let pieces = contacts.colored_pieces(&(0..contacts.len()), places);
        threads.share_in_phases(pieces.into_iter().map(|piece| (0, piece.place, piece.runs)), |runs| {
            runs.into_iter().for_each(&work)
        });
    } else {
        let piece = threads.piece(contacts.len(), SHARED_BLOCKS);
        threads.share(contacts.parts(piece).zip((0..).step_by(piece)), |(part, first)| work(BlockRange { first, part }));
    }
}

/// Goes through the manifolds that have these lanes, in their order, each with the thread that goes through its block in sweeps;
/// `places` is overwritten.
pub(super) fn each_manifold(
    contacts: &mut ContactBlocks,
    threads: &Workers,
    lanes: &[(u32, u32)],
    places: &mut Vec<u8>,
    work: impl Fn(&mut BlockView<'_>, usize, usize) + Sync,
) {
    let count = useful_places(contacts, threads);
    contacts.note_places(count, places);
    let shared = DividedBlocks::new(contacts);
    threads.share_among_all(0..count, |place| {
        // SAFETY: each block has one place, and each place is one thread's.
        let mut own = unsafe { shared.part() };
        for (number, &(block, lane)) in lanes.iter().enumerate() {
            if places.get(block as usize).is_some_and(|&own| usize::from(own) == place) {
                work(&mut own.whole(block), lane as usize, number);
            }
        }
    });
}

/// One sweep over the contacts, and [`JOINTED_SWEEPS`] over those of bodies that joints hold, the last ones;
/// backwards, all in the opposite order. Manifolds of free bodies end with their normal rows on the way back, and forth if `presses_last`.
pub(super) fn sweep(
    contacts: &mut ContactBlocks,
    threads: &Workers,
    (velocities, moving): (&mut [BodyVelocity], usize),
    backwards: bool,
    presses_last: bool,
) {
    let (free, jointed) = (0..contacts.first_jointed, contacts.first_jointed..contacts.len());
    let mut sweep = |range: &Range<usize>, backwards: bool, presses_last: bool| {
        in_colors(contacts, range.clone(), threads, (velocities, moving), backwards, |part, velocities| {
            contact_kernels::sweep(part, velocities, backwards, presses_last);
        });
    };
    if !backwards {
        sweep(&free, false, presses_last);
    }
    for number in 0..JOINTED_SWEEPS {
        sweep(&jointed, backwards != (number % 2 == 1), true);
    }
    if backwards {
        sweep(&free, true, true);
    }
}

/// One sweep over the contacts of bodies that joints hold.
pub(super) fn sweep_jointed(contacts: &mut ContactBlocks, threads: &Workers, (velocities, moving): (&mut [BodyVelocity], usize)) {
    let jointed = contacts.first_jointed..contacts.len();
    in_colors(contacts, jointed, threads, (velocities, moving), false, |part, velocities| {
        contact_kernels::sweep(part, velocities, false, true);
    });
}

/// Forms the masses of blocks anew of which the inertia of a body has been.
pub(super) fn refresh_masses(
    contacts: &mut ContactBlocks,
    threads: &Workers,
    velocities: &[BodyVelocity],
    motions: &[BodyMotion],
) {
    side_by_side(contacts, threads, |BlockRange { part, .. }| {
        for mut block in part.iter().filter(|whole| whole.block.is_refreshed(motions)) {
            contact_kernels::set_masses(&mut block, velocities);
        }
    });
}
