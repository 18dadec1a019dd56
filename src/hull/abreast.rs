//! Vectors of a hull, its corners or the normals of its faces, four abreast: which of them goes farthest along a direction.

use glam::{Vec3, Vec4};

/// Vectors in the order in which they came, four to a share; the last share is filled up with the first one.
#[derive(Debug, Clone, Default)]
pub(super) struct Abreast {
    shares: Vec<[Vec4; 3]>,
}

impl Abreast {
    pub(super) fn of(vectors: impl Iterator<Item = Vec3>) -> Self {
        let vectors: Vec<Vec3> = vectors.collect();
        let share = |first: usize| {
            let of = |lane: usize| vectors.get(first + lane).unwrap_or(&vectors[0]);
            let lanes = |axis: usize| Vec4::from_array(std::array::from_fn(|lane| of(lane)[axis]));
            [lanes(0), lanes(1), lanes(2)]
        };
        Self { shares: (0..vectors.len()).step_by(4).map(share).collect() }
    }

    /// The first of those that go farthest along a direction, in single precision: what goes less far by rounding may be taken for it.
    #[inline]
    pub(super) fn farthest(&self, direction: Vec3) -> u32 {
        let [x, y, z] = [direction.x, direction.y, direction.z].map(Vec4::splat);
        let (mut heights, mut shares, mut share) = (Vec4::NEG_INFINITY, Vec4::ZERO, Vec4::ZERO);
        for of in &self.shares {
            let found = of[0] * x + of[1] * y + of[2] * z;
            let is_higher = found.cmpgt(heights);
            (heights, shares) = (Vec4::select(is_higher, found, heights), Vec4::select(is_higher, share, shares));
            share += Vec4::ONE;
        }
        let numbers = shares * 4.0 + Vec4::new(0.0, 1.0, 2.0, 3.0);
        Vec4::select(heights.cmpeq(Vec4::splat(heights.max_element())), numbers, Vec4::INFINITY).min_element() as u32
    }
}
