//! Contact rows in blocks of eight manifolds of one colour, laid out for SIMD lanes.
//!
//! Most manifolds have one point, no friction about it and no rebound, and a pile's blocks are gone through a dozen times a step from
//! beyond the cache. So a block has room for one point alone; what more points need is a [`MultiPointRows`] beside it, and what rolls, spins or
//! rebounds has an [`MaterialRows`].
//!
//! ```text
//! blocks  [ a b n · point 0 · friction ][ … ][ … ]…                      0.7 kB each
//! faces           [ centres · points 1, 2, 3 · 4×4 matrices · twist ]…   1.9 kB, for blocks with manifolds of more than one point
//! extras          [ rolling, spinning · restitution, impacts ]…          0.6 kB, for blocks with such materials
//! ```

use std::ops::Range;

use glam::Vec3;

use super::color::ColorRange;
use super::contact::{ContactImpulses, ContactInput, LANES, Lane, Lane3, POINTS, tangents};
use super::state::BodyMotion;
use crate::prefetch::prefetch;
use crate::tight_vec::{make_room, resize};

mod sums;
mod whole;

pub(crate) use sums::BlockSums;
pub(crate) use whole::BlockView;

/// Where a block has neither a face nor an extra.
pub(crate) const NONE: u32 = u32::MAX;

/// Rows of one point of each manifold.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct PointRows {
    pub lever_a: Lane3,
    pub lever_b: Lane3,
    /// 1/A_ii; zero for points that do not exist.
    pub inverse_diagonal: Lane,
    /// Separation at the start of the step (m).
    pub separation: Lane,
    /// max(s, 0)/h of this substep (m/s); once substeps are over, the multipliers of position recovery (kg m).
    pub closing_speed: Lane,
    pub lambda: Lane,
}

/// Row about the normal.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct TwistRow {
    pub mass: Lane,
    pub lambda: Lane,
    /// Torque limit per normal force (m).
    pub arm: Lane,
}

/// Eight manifolds; unused lanes act on the world slot and do nothing.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct ContactBlock {
    pub a: [u32; LANES],
    pub b: [u32; LANES],
    pub normal: Lane3,
    pub first: PointRows,
    /// Inverse of the tangential 2×2 matrix, along the [`tangents`] of the normal: 11, 12, 22.
    pub tangent_mass: [Lane; 3],
    pub tangent_lambda: [Lane; 2],
    pub friction: Lane,
    /// 1 where a point that begins the step under load is further off than what touches, or, alone, than a fall of a substep.
    pub hangs: Lane,
    /// Points of each manifold, and whether it begins with a multiplier of one of them.
    pub count: [u8; LANES],
    pub is_pressed: [bool; LANES],
    /// Places of its face and its extra, or [`NONE`].
    pub face: u32,
    pub extra: u32,
    /// Faces and extras of the blocks before this one.
    pub(super) before: [u32; 2],
}

/// What a block has beside it whose manifolds may have more than one point.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct MultiPointRows {
    /// Points 1 to 3.
    pub more: [PointRows; POINTS - 1],
    pub twist: TwistRow,
    /// Middle of the points, where friction acts.
    pub center_a: Lane3,
    pub center_b: Lane3,
    pub diagonal: [Lane; POINTS],
    /// A_ij for i < j: 01, 02, 03, 12, 13, 23.
    pub coupling: [Lane; 6],
    /// (A + ε)⁻¹ on the points that exist: 00, 11, 22, 33, 01, 02, 03, 12, 13, 23.
    pub inverse: [Lane; 10],
}

/// What a block has beside it of which a manifold resists rolling, or spinning by its material, or rebounds, or lies on what the host turns, or
/// is of a round feature that is swung.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct MaterialRows {
    /// Inverse of the angular 2×2 matrix about the tangents: 11, 12, 22.
    pub rolling_mass: [Lane; 3],
    pub rolling_lambda: [Lane; 2],
    /// Torque limit about the tangents per normal force (m).
    pub rolling_arm: Lane,
    /// Of manifolds of one point; those of more have theirs in the face.
    pub twist: TwistRow,
    pub restitution: Lane,
    /// Normal velocity at the moment of impact, negative when approaching (m/s); zero where there is none in this substep.
    pub impact_speed: [Lane; POINTS],
    /// Sum of the multipliers of the last rebound in this step (N·s).
    pub blow: Lane,
    /// Whether that was in this substep.
    pub rebounds: [bool; LANES],
    /// What the slip is greater by in the middle of the substep, as sides that the host turns carry the contact round, or as round features
    /// are swung (m/s).
    pub lean: [Lane; 2],
    pub has_lean: bool,
    pub has_rolling: bool,
    pub has_spinning: bool,
    pub has_restitution: bool,
}

const ZERO: Lane = [0.0; LANES];

impl PointRows {
    const EMPTY: Self = Self {
        lever_a: [ZERO; 3],
        lever_b: [ZERO; 3],
        inverse_diagonal: ZERO,
        separation: ZERO,
        closing_speed: ZERO,
        lambda: ZERO,
    };

    /// Levers of lane `l`.
    pub(crate) fn levers_of(&self, l: usize) -> (Vec3, Vec3) {
        (get(&self.lever_a, l), get(&self.lever_b, l))
    }
}

impl TwistRow {
    const EMPTY: Self = Self { mass: ZERO, lambda: ZERO, arm: ZERO };
}

impl ContactBlock {
    const EMPTY: Self = Self {
        a: [0; LANES],
        b: [0; LANES],
        normal: [ZERO; 3],
        first: PointRows::EMPTY,
        tangent_mass: [ZERO; 3],
        tangent_lambda: [ZERO; 2],
        friction: ZERO,
        hangs: ZERO,
        count: [0; LANES],
        is_pressed: [false; LANES],
        face: NONE,
        extra: NONE,
        before: [0; 2],
    };

    /// Whether the inertia of any of its bodies has been formed anew.
    pub(crate) fn is_refreshed(&self, motions: &[BodyMotion]) -> bool {
        self.a.iter().chain(&self.b).any(|&slot| motions[slot as usize].world_inertia.refreshed)
    }

    /// Whether lane `l` is in use, and its first point can be moved.
    pub(crate) fn is_movable(&self, l: usize) -> bool {
        self.first.inverse_diagonal[l] > 0.0
    }

    /// Normal of lane `l`.
    pub(crate) fn normal_of(&self, l: usize) -> Vec3 {
        get(&self.normal, l)
    }
}

impl MultiPointRows {
    const EMPTY: Self = Self {
        more: [PointRows::EMPTY; POINTS - 1],
        twist: TwistRow::EMPTY,
        center_a: [ZERO; 3],
        center_b: [ZERO; 3],
        diagonal: [ZERO; POINTS],
        coupling: [ZERO; 6],
        inverse: [ZERO; 10],
    };
}

impl MaterialRows {
    const EMPTY: Self = Self {
        rolling_mass: [ZERO; 3],
        rolling_lambda: [ZERO; 2],
        rolling_arm: ZERO,
        twist: TwistRow::EMPTY,
        restitution: ZERO,
        impact_speed: [ZERO; POINTS],
        blow: ZERO,
        rebounds: [false; LANES],
        lean: [ZERO; 2],
        has_lean: false,
        has_rolling: false,
        has_spinning: false,
        has_restitution: false,
    };

    fn set_lane(&mut self, l: usize, input: &ContactInput, [t1, t2]: [Vec3; 2], twist: f32) {
        if input.material.rolling > 0.0 {
            self.has_rolling = true;
            self.rolling_arm[l] = input.material.rolling;
            self.rolling_lambda[0][l] = input.impulses.rolling.dot(t1);
            self.rolling_lambda[1][l] = input.impulses.rolling.dot(t2);
        }
        if input.material.spinning > 0.0 {
            self.has_spinning = true;
            self.twist.arm[l] = input.material.spinning;
            self.twist.lambda[l] = twist;
        }
        if input.material.restitution > 0.0 {
            self.has_restitution = true;
            self.restitution[l] = input.material.restitution;
        }
    }
}

/// All blocks of a batch.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContactBlocks {
    pub blocks: Vec<ContactBlock>,
    /// The first of those last blocks of which joints hold all that moves.
    pub first_jointed: usize,
    pub faces: Vec<MultiPointRows>,
    pub extras: Vec<MaterialRows>,
    /// Which of them share no moving body, from the first to the last; nothing of lists that one thread goes through.
    pub colors: Vec<ColorRange>,
    /// First moving slots, less one, at each of so many equal parts of the manifolds of each round in the order of their bodies, and of all;
    /// none where blocks are in another order.
    pub cuts: Vec<u32>,
    /// The same of the first manifold of each block, where there are cuts.
    pub firsts: Vec<u32>,
}

impl ContactBlocks {
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.faces.clear();
        self.extras.clear();
        self.colors.clear();
        self.cuts.clear();
        self.firsts.clear();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    pub(crate) fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Begins a list of this many blocks, of which so many have faces, with what the last one has left in them.
    pub(crate) fn begin(&mut self, blocks: usize, faces: usize) {
        resize(&mut self.blocks, blocks, ContactBlock::EMPTY);
        resize(&mut self.faces, faces, MultiPointRows::EMPTY);
        self.extras.clear();
        self.colors.clear();
        self.cuts.clear();
        self.firsts.clear();
    }

    /// Lays out the blocks of a range, the first of which have a manifold in each lane: the others are emptied. Those with faces have
    /// them from `first_face` on.
    pub(crate) fn lay_out(&mut self, range: Range<usize>, full: usize, has_faces: bool, first_face: usize) {
        for (place, block) in self.blocks[range].iter_mut().enumerate() {
            if place >= full {
                *block = ContactBlock::EMPTY;
            }
            let before = first_face + if has_faces { place } else { 0 };
            (block.before, block.extra) = ([before as u32, 0], NONE);
            block.face = if has_faces { before as u32 } else { NONE };
            if has_faces && place >= full {
                self.faces[before] = MultiPointRows::EMPTY;
            }
        }
    }

    /// Points that a block has room for.
    pub(crate) fn room_of(&self, block: usize) -> usize {
        if self.blocks[block].face == NONE { 1 } else { POINTS }
    }

    /// Rows of a point of a block that has room for it.
    pub(crate) fn rows(&self, block: usize, point: usize) -> &PointRows {
        let block = &self.blocks[block];
        if point == 0 { &block.first } else { &self.faces[block.face as usize].more[point - 1] }
    }

    pub(crate) fn rows_mut(&mut self, block: usize, point: usize) -> &mut PointRows {
        let block = &mut self.blocks[block];
        if point == 0 { &mut block.first } else { &mut self.faces[block.face as usize].more[point - 1] }
    }

    /// Levers of the middle of a manifold, where friction acts.
    pub(crate) fn centers_of(&self, block: usize, l: usize) -> (Vec3, Vec3) {
        let block = &self.blocks[block];
        match self.faces.get(block.face as usize) {
            Some(face) => (get(&face.center_a, l), get(&face.center_b, l)),
            None => block.first.levers_of(l),
        }
    }

    /// Puts a point's lever on one side, A or B, elsewhere; its masses are those of before.
    pub(crate) fn set_lever(&mut self, block: usize, l: usize, (point, side): (usize, usize), lever: Vec3) {
        let rows = self.rows_mut(block, point);
        put(if side == 0 { &mut rows.lever_a } else { &mut rows.lever_b }, l, lever);
    }

    /// Brings the middle of a manifold to where its points are.
    pub(crate) fn recenter(&mut self, block: usize, l: usize) {
        let count = usize::from(self.blocks[block].count[l]);
        if self.room_of(block) == 1 || count == 0 {
            return;
        }
        let levers = (0..count).map(|point| self.rows(block, point).levers_of(l));
        let sums = levers.fold((Vec3::ZERO, Vec3::ZERO), |sums, levers| (sums.0 + levers.0, sums.1 + levers.1));
        let face = &mut self.faces[self.blocks[block].face as usize];
        put(&mut face.center_a, l, sums.0 / count as f32);
        put(&mut face.center_b, l, sums.1 / count as f32);
    }

    /// Has a manifold of a block with an extra slip by so much more (m/s).
    pub(crate) fn lean_by(&mut self, block: usize, l: usize, slip: Vec3) {
        let block = &self.blocks[block];
        let Some(extra) = self.extras.get_mut(block.extra as usize) else { return };
        let (t1, t2) = tangents(get(&block.normal, l));
        (extra.lean[0][l], extra.lean[1][l]) = (slip.dot(t1), slip.dot(t2));
        extra.has_lean = true;
    }

    /// Row about the normal, where a block has one.
    pub(crate) fn twist_of(&self, block: usize) -> Option<&TwistRow> {
        let block = &self.blocks[block];
        let of_point = || self.extras.get(block.extra as usize).map(|extra| &extra.twist);
        self.faces.get(block.face as usize).map(|face| &face.twist).or_else(of_point)
    }

    pub(crate) fn twist_mut(&mut self, block: usize) -> Option<&mut TwistRow> {
        let Self { blocks, faces, extras, .. } = self;
        let block = &blocks[block];
        match faces.get_mut(block.face as usize) {
            Some(face) => Some(&mut face.twist),
            None => extras.get_mut(block.extra as usize).map(|extra| &mut extra.twist),
        }
    }

    /// Gives each of the blocks that `need` says what manifolds have that roll, spin or rebound.
    pub(crate) fn add_extras(&mut self, needs: impl Iterator<Item = usize>) {
        needs.for_each(|number| self.blocks[number].extra = 0);
        let mut count = 0;
        for block in &mut self.blocks {
            block.before[1] = count;
            if block.extra != NONE {
                block.extra = count;
                count += 1;
            }
        }
        make_room(&mut self.extras, count as usize);
        self.extras.resize(count as usize, MaterialRows::EMPTY);
    }

    /// A block with what it has beside it.
    pub(crate) fn whole(&mut self, number: usize) -> BlockView<'_> {
        let block = &mut self.blocks[number];
        let (face, extra) = (self.faces.get_mut(block.face as usize), self.extras.get_mut(block.extra as usize));
        BlockView { block, face, extra }
    }

    /// Asks for the memory of a block.
    #[inline(always)]
    pub(crate) fn ask_for(&self, number: usize) {
        prefetch(&self.blocks[number]);
    }

    /// Multipliers of lane `l` of a block at the end of the last substep.
    pub(crate) fn impulses(&self, number: usize, l: usize) -> ContactImpulses {
        let block = &self.blocks[number];
        let (t1, t2) = tangents(get(&block.normal, l));
        let mut impulses = ContactImpulses {
            friction: t1 * block.tangent_lambda[0][l] + t2 * block.tangent_lambda[1][l],
            twist: self.twist_of(number).map_or(0.0, |twist| twist.lambda[l]),
            ..ContactImpulses::default()
        };
        for i in 0..self.room_of(number) {
            impulses.normal[i] = self.rows(number, i).lambda[l];
        }
        if let Some(extra) = self.extras.get(block.extra as usize) {
            impulses.rolling = t1 * extra.rolling_lambda[0][l] + t2 * extra.rolling_lambda[1][l];
        }
        impulses
    }

    /// Sum of the multipliers of the last rebound of a manifold in this step (N·s); zero without one.
    pub(crate) fn blow(&self, number: usize, l: usize) -> f32 {
        self.extras.get(self.blocks[number].extra as usize).map_or(0.0, |extra| extra.blow[l])
    }

    /// Ends a substep of what has rebounded in it: those are multipliers of a blow, and nothing to carry on.
    pub(crate) fn end_blows(&mut self) {
        let Self { blocks, faces, extras, .. } = self;
        if extras.is_empty() {
            return;
        }
        for block in blocks {
            let Some(extra) = extras.get_mut(block.extra as usize).filter(|extra| extra.has_restitution) else { continue };
            let rebounds = std::mem::take(&mut extra.rebounds);
            let face = faces.get_mut(block.face as usize);
            let mut whole = BlockView { block, face, extra: Some(extra) };
            (0..LANES).filter(|&l| rebounds[l]).for_each(|l| whole.multipliers().for_each(|lambda| lambda[l] = 0.0));
        }
    }

    /// Adds a copy of a block of another list, with what it has beside it.
    pub(crate) fn add_copy(&mut self, from: &Self, number: usize) -> BlockView<'_> {
        let mut block = from.blocks[number].clone();
        block.before = [self.faces.len() as u32, self.extras.len() as u32];
        if let Some(face) = from.faces.get(block.face as usize) {
            block.face = block.before[0];
            self.faces.push(face.clone());
        }
        if let Some(extra) = from.extras.get(block.extra as usize) {
            block.extra = block.before[1];
            self.extras.push(extra.clone());
        }
        self.blocks.push(block);
        self.whole(self.blocks.len() - 1)
    }
}

fn put(lanes: &mut Lane3, l: usize, v: Vec3) {
    lanes[0][l] = v.x;
    lanes[1][l] = v.y;
    lanes[2][l] = v.z;
}

fn get(lanes: &Lane3, l: usize) -> Vec3 {
    Vec3::new(lanes[0][l], lanes[1][l], lanes[2][l])
}
