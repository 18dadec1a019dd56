//! Divides the contact blocks of one colour among threads.
//!
//! A body that changes hands is read from the cache of another core, which takes as long as a block's rows. So colours are cut by the
//! bodies of their blocks, all in the same places, and a thread has the same bodies in each colour, sweep and step.

use std::ops::Range;

use smallvec::{SmallVec, smallvec};

use super::color::ColorRange;
use super::contact_block::{BlockView, ContactBlock, ContactBlocks, MaterialRows, MultiPointRows, NONE};
use super::disjoint::{DisjointPart, DisjointSlices, Slots};
use crate::prefetch::prefetch;

/// Parts into which blocks can be cut by their bodies.
pub(crate) const CUTS: usize = 64;

/// All pieces of some colours.
pub(crate) type ColoredPieces<'a> = SmallVec<[ColoredPiece<'a>; 64]>;

/// Blocks that one thread goes through in a phase, run by run, at its place among the pieces of the phase.
pub(crate) struct ColoredPiece<'a> {
    pub phase: u32,
    pub place: usize,
    pub runs: SmallVec<[BlockRange<'a>; 2]>,
}

/// Blocks that follow one another, and the number of the first of them.
pub(crate) struct BlockRange<'a> {
    pub first: usize,
    pub part: BlockPart<'a>,
}

/// Blocks of a colour from which on several threads go through them: some 3 µs.
const MIN_CUT: usize = 16;

/// Blocks of a batch from which on their memory is asked for ahead of its use, and how many blocks ahead; of what says where that memory
/// is, twice as many.
const FAR_BLOCKS: usize = 2048;
const BLOCKS_AHEAD: usize = 2;

impl ContactBlocks {
    /// Says of the next blocks, if there are any, that they share no moving body, or may; those without faces are of the colour
    /// before.
    pub(crate) fn add_color(&mut self, Range { start: first, end }: Range<usize>, round: usize, is_one: bool, has_faces: bool) {
        match self.colors.last_mut().filter(|last| is_one && last.is_one && !has_faces) {
            Some(last) => last.blocks.end = end,
            None => {
                self.colors.push(ColorRange { blocks: first..end, points: if has_faces { end } else { first }, round, is_one })
            }
        }
    }

    /// Blocks of a range in pieces that may be gone through side by side within their phases: so many for each colour, of which those in
    /// the same places have the same bodies where there are cuts, or one for colours that are not worth it. The range ends where colours
    /// do.
    pub(crate) fn colored_pieces(&mut self, range: &Range<usize>, places: usize) -> ColoredPieces<'_> {
        let Self { blocks, faces, extras, colors, cuts, firsts, first_jointed: _ } = self;
        debug_assert_eq!(colors.last().map_or(0, |last| last.blocks.end), blocks.len(), "blocks of no colour are left out");
        let mut ends = SmallVec::<[usize; 128]>::new();
        let colors = || colors.iter().filter(|color| range.contains(&color.blocks.start));
        for color in colors().filter(|color| is_worth_cutting(color)) {
            for run in [color.blocks.start..color.points, color.points..color.blocks.end] {
                let end = |place: usize| match cuts.get(color.round * CUTS + place * CUTS / places) {
                    Some(&cut) => firsts[run.clone()].partition_point(|&first| first < cut),
                    None => run.len() * place / places,
                };
                ends.extend((1..places).map(|place| run.start + end(place)));
                ends.push(run.end);
            }
        }
        let mut ends = ends.into_iter();
        let mut pieces = ColoredPieces::new();
        let is_far = blocks.len() >= FAR_BLOCKS;
        let mut rest = BlockPart { blocks, faces, extras, before: [0; 2], is_far };
        let mut first = range.start;
        rest.split_off(first);
        let mut part = |end: usize| {
            let begin = std::mem::replace(&mut first, end);
            BlockRange { first: begin, part: rest.split_off(end - begin) }
        };
        let (mut phase, mut was_cut) = (0, true);
        for color in colors() {
            let is_cut = is_worth_cutting(color);
            phase += u32::from(is_cut || was_cut);
            if is_cut {
                let own = pieces.len();
                pieces.extend((0..places).map(|place| ColoredPiece { phase, place, runs: SmallVec::new() }));
                (0..2 * places).zip(&mut ends).for_each(|(number, end)| pieces[own + number % places].runs.push(part(end)));
            } else if was_cut {
                pieces.push(ColoredPiece { phase, place: 0, runs: smallvec![part(color.blocks.end)] });
            } else if let Some(run) = pieces.last_mut().map(|piece| &mut piece.runs) {
                run.push(part(color.blocks.end));
            }
            was_cut = is_cut;
        }
        pieces
    }

    /// Notes for each block which of so many places it has.
    pub(crate) fn note_places(&mut self, places: usize, of_blocks: &mut Vec<u8>) {
        of_blocks.clear();
        of_blocks.resize(self.len(), 0);
        for ColoredPiece { place, runs, .. } in self.colored_pieces(&(0..self.len()), places) {
            runs.iter().for_each(|run| of_blocks[run.first..][..run.part.blocks.len()].fill(place as u8));
        }
    }

    /// Whether blocks of one colour share no slot of those, after the first, that move.
    pub(crate) fn are_apart(&self, moving: usize) -> bool {
        let mut taken = vec![0; moving + 1];
        self.colors.iter().zip(1..).filter(|(color, _)| color.is_one).all(|(color, mark)| {
            let slots = self.blocks[color.blocks.clone()].iter().flat_map(|block| block.a.iter().chain(&block.b));
            let mut moved = slots.map(|&slot| slot as usize).filter(|slot| (1..=moving).contains(slot));
            moved.all(|slot| std::mem::replace(&mut taken[slot], mark) != mark)
        })
    }

    /// All blocks as one part.
    pub(crate) fn all(&mut self) -> BlockPart<'_> {
        self.part(0..self.len())
    }

    /// Blocks that follow one another.
    pub(crate) fn part(&mut self, range: Range<usize>) -> BlockPart<'_> {
        let Self { blocks, faces, extras, .. } = self;
        let is_far = blocks.len() >= FAR_BLOCKS;
        BlockPart { blocks: &mut blocks[range], faces, extras, before: [0; 2], is_far }
    }

    /// All blocks in parts of this length.
    pub(crate) fn parts(&mut self, length: usize) -> impl Iterator<Item = BlockPart<'_>> {
        let mut rest = self.all();
        std::iter::from_fn(move || {
            let count = length.min(rest.blocks.len());
            (count > 0).then(|| rest.split_off(count))
        })
    }
}

/// Blocks that follow one another, and what they have beside them.
pub(crate) struct BlockPart<'a> {
    pub blocks: &'a mut [ContactBlock],
    pub faces: &'a mut [MultiPointRows],
    pub extras: &'a mut [MaterialRows],
    /// Faces and extras before those.
    pub before: [u32; 2],
    /// Whether all blocks together are more than the second-level cache holds.
    is_far: bool,
}

impl<'a> BlockPart<'a> {
    /// Takes the first `count` blocks out.
    pub(crate) fn split_off(&mut self, count: usize) -> Self {
        let (blocks, rest) = std::mem::take(&mut self.blocks).split_at_mut(count);
        let before = self.before;
        let next = rest.first().map(|next| next.before);
        let beside = |kind: usize, all: usize| next.map_or(all, |next| (next[kind] - before[kind]) as usize);
        let (own_faces, own_extras) = (beside(0, self.faces.len()), beside(1, self.extras.len()));
        let (faces, more_faces) = std::mem::take(&mut self.faces).split_at_mut(own_faces);
        let (extras, more_extras) = std::mem::take(&mut self.extras).split_at_mut(own_extras);
        let is_far = self.is_far;
        *self = Self { blocks: rest, faces: more_faces, extras: more_extras, before: next.unwrap_or(before), is_far };
        Self { blocks, faces, extras, before, is_far }
    }

    /// Asks for the memory of the blocks that come after this one, or before it.
    #[inline(always)]
    pub(crate) fn ask_for_next(&self, number: usize, backwards: bool) {
        if !self.is_far {
            return;
        }
        let next = |distance: usize| match backwards {
            true => self.blocks.get(number.wrapping_sub(distance)),
            false => self.blocks.get(number + distance),
        };
        if let Some(block) = next(2 * BLOCKS_AHEAD) {
            prefetch(block);
        }
        if let Some(face) = next(BLOCKS_AHEAD).and_then(|block| self.faces.get(block.face.wrapping_sub(self.before[0]) as usize))
        {
            prefetch(face);
        }
    }

    /// The blocks one by one.
    pub(crate) fn iter(self) -> impl Iterator<Item = BlockView<'a>> {
        let (mut faces, mut extras) = (self.faces.iter_mut(), self.extras.iter_mut());
        self.blocks.iter_mut().map(move |block| {
            let face = if block.face == NONE { None } else { faces.next() };
            let extra = if block.extra == NONE { None } else { extras.next() };
            BlockView { block, face, extra }
        })
    }

    /// Does the same to each of the blocks, whose memory is asked for ahead.
    pub(crate) fn each(&mut self, mut work: impl FnMut(BlockView<'_>)) {
        for number in 0..self.blocks.len() {
            self.ask_for_next(number, false);
            let Self { blocks, faces, extras, before, .. } = self;
            let block = &mut blocks[number];
            let face = faces.get_mut(block.face.wrapping_sub(before[0]) as usize);
            let extra = extras.get_mut(block.extra.wrapping_sub(before[1]) as usize);
            work(BlockView { block, face, extra });
        }
    }
}

/// All blocks of a list, which several threads change at once, each others.
pub(crate) struct DividedBlocks<'a> {
    blocks: DisjointSlices<'a, ContactBlock>,
    faces: DisjointSlices<'a, MultiPointRows>,
    extras: DisjointSlices<'a, MaterialRows>,
}

impl<'a> DividedBlocks<'a> {
    pub(crate) fn new(ContactBlocks { blocks, faces, extras, .. }: &'a mut ContactBlocks) -> Self {
        Self { blocks: DisjointSlices::new(blocks), faces: DisjointSlices::new(faces), extras: DisjointSlices::new(extras) }
    }

    /// Some of them, for one thread.
    ///
    /// # Safety
    /// While it lives no other part is used for a block that this one is used for.
    pub(crate) unsafe fn part(&self) -> SomeBlocks<'_> {
        // SAFETY: what a block has beside it is of no other, so the promise is that of each list.
        unsafe { SomeBlocks { blocks: self.blocks.part(), faces: self.faces.part(), extras: self.extras.part() } }
    }
}

/// Some blocks of a list.
pub(crate) struct SomeBlocks<'a> {
    blocks: DisjointPart<'a, ContactBlock>,
    faces: DisjointPart<'a, MultiPointRows>,
    extras: DisjointPart<'a, MaterialRows>,
}

impl SomeBlocks<'_> {
    /// A block with what it has beside it.
    pub(crate) fn whole(&mut self, number: u32) -> BlockView<'_> {
        let block = self.blocks.get_mut(number);
        let face = (block.face != NONE).then(|| self.faces.get_mut(block.face));
        let extra = (block.extra != NONE).then(|| self.extras.get_mut(block.extra));
        BlockView { block, face, extra }
    }
}

/// Whether a colour is large enough to be cut for several threads.
fn is_worth_cutting(color: &ColorRange) -> bool {
    color.is_one && color.blocks.len() >= MIN_CUT
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies of another round have numbers from here on.
    const NEXT: u32 = 1000;

    /// A colour of one round and two of the next, the last of them small, then blocks that are of none: each block's first body is its place
    /// in its run.
    fn blocks() -> ContactBlocks {
        let mut blocks = ContactBlocks::default();
        let runs = [
            (40, 0, true, true),
            (30, 0, true, false),
            (20, 1, true, true),
            (10, 1, true, false),
            (5, 1, true, true),
            (3, 1, false, true),
        ];
        let count = |of_faces: bool| runs.iter().filter(|(.., faces)| *faces || !of_faces).map(|(count, ..)| count).sum();
        blocks.begin(count(false), count(true));
        let (mut first, mut faces) = (0, 0);
        for (count, round, is_one, has_faces) in runs {
            blocks.lay_out(first..first + count, 0, has_faces, faces);
            blocks.add_color(first..first + count, round, is_one, has_faces);
            blocks.firsts.extend((0..count).map(|number| round as u32 * NEXT + (number * CUTS / count) as u32));
            first += count;
            faces += if has_faces { count } else { 0 };
        }
        blocks.cuts.extend((0..CUTS as u32).chain(NEXT..NEXT + CUTS as u32));
        blocks
    }

    #[test]
    fn pieces_have_each_block_once_with_its_face_and_those_of_a_place_the_same_bodies() {
        let mut blocks = blocks();
        for places in [1, 2, 3, 7] {
            let mut next = [0; 7];
            let (firsts, mut seen, mut phases) = (blocks.firsts.clone(), Vec::new(), Vec::new());
            for ColoredPiece { phase, place, runs } in blocks.colored_pieces(&(0..108), places) {
                phases.push(phase);
                for BlockRange { first, part } in runs {
                    for (number, whole) in (first..).zip(part.iter()) {
                        seen.push(number);
                        let has_face = !(40..70).contains(&number) && !(90..100).contains(&number);
                        assert_eq!(whole.face.is_some(), has_face, "block {number}");
                        if number < 100 {
                            let range = place * CUTS / places..(place + 1) * CUTS / places;
                            assert!(
                                range.contains(&((firsts[number] % NEXT) as usize)),
                                "block {number} is not of place {place} of {places}"
                            );
                        } else {
                            assert_eq!(place, 0, "block {number} is too little to cut");
                        }
                        next[place] += 1;
                    }
                }
            }
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..108) && phases.is_sorted(), "{places} places");
            assert_eq!(phases.last(), Some(&3), "what is too little to cut is one phase");
            assert!(next[..places].iter().all(|&count| count > 0));
        }
    }

    #[test]
    fn blocks_that_are_laid_out_again_keep_nothing_that_is_not_filled() {
        let mut blocks = blocks();
        blocks.blocks.iter_mut().for_each(|block| (block.a, block.count) = ([1; 8], [4; 8]));
        blocks.begin(2, 1);
        blocks.lay_out(0..1, 1, true, 0);
        blocks.lay_out(1..2, 0, false, 1);
        assert_eq!((blocks.len(), blocks.blocks[0].face, blocks.blocks[1].face), (2, 0, NONE));
        assert_eq!((blocks.blocks[1].a, blocks.blocks[1].count), ([0; 8], [0; 8]));
    }
}
