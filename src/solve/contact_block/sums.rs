//! Sums of a block's multipliers over the substeps of a step: of all its manifolds side by side, and of one when they are read.

use super::super::contact::{ContactImpulses, LANES, Lane, POINTS, tangents};
use super::{ContactBlocks, ZERO};

/// What the manifolds of a block have done in a step: along normals and tangents, about both.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockSums {
    normal: [Lane; POINTS],
    along: [Lane; 2],
    twist: Lane,
    rolling: [Lane; 2],
}

impl BlockSums {
    pub(crate) const NONE: Self = Self { normal: [ZERO; POINTS], along: [ZERO; 2], twist: ZERO, rolling: [ZERO; 2] };
}

fn add(sum: &mut Lane, more: &Lane) {
    (0..LANES).for_each(|l| sum[l] += more[l]);
}

impl ContactBlocks {
    /// Adds the multipliers of the last substep of a block.
    pub(crate) fn add_up(&self, number: usize, sums: &mut BlockSums) {
        let block = &self.blocks[number];
        for i in 0..self.room_of(number) {
            add(&mut sums.normal[i], &self.rows(number, i).lambda);
        }
        sums.along.iter_mut().zip(&block.tangent_lambda).for_each(|(sum, more)| add(sum, more));
        if let Some(twist) = self.twist_of(number) {
            add(&mut sums.twist, &twist.lambda);
        }
        if let Some(extra) = self.extras.get(block.extra as usize) {
            sums.rolling.iter_mut().zip(&extra.rolling_lambda).for_each(|(sum, more)| add(sum, more));
        }
    }

    /// What these sums are of lane `l` of a block.
    pub(crate) fn sum_of(&self, number: usize, l: usize, sums: &BlockSums) -> ContactImpulses {
        let (t1, t2) = tangents(self.blocks[number].normal_of(l));
        ContactImpulses {
            normal: sums.normal.map(|lane| lane[l]),
            friction: t1 * sums.along[0][l] + t2 * sums.along[1][l],
            twist: sums.twist[l],
            rolling: t1 * sums.rolling[0][l] + t2 * sums.rolling[1][l],
        }
    }
}
