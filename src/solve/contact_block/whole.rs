//! View of a contact block with its optional rows, and how a manifold is written into a lane of it.

use glam::{Vec2, Vec3, Vec4};

use super::super::contact::{ContactInput, Lane, NEGLIGIBLE_FRICTION, POINTS, TOUCHED, tangents};
use super::{ContactBlock, MaterialRows, MultiPointRows, PointRows, get, put};

/// A block, and what it has beside it.
pub(crate) struct BlockView<'a> {
    pub block: &'a mut ContactBlock,
    pub face: Option<&'a mut MultiPointRows>,
    pub extra: Option<&'a mut MaterialRows>,
}

impl BlockView<'_> {
    /// All multipliers of its manifolds.
    pub(crate) fn multipliers(&mut self) -> impl Iterator<Item = &mut Lane> {
        let Self { block, face, extra } = self;
        let of_face = face.iter_mut().flat_map(|MultiPointRows { more, twist, .. }| {
            more.iter_mut().map(|rows| &mut rows.lambda).chain([&mut twist.lambda])
        });
        let of_extra = extra
            .iter_mut()
            .flat_map(|MaterialRows { rolling_lambda, twist, .. }| rolling_lambda.iter_mut().chain([&mut twist.lambda]));
        [&mut block.first.lambda].into_iter().chain(&mut block.tangent_lambda).chain(of_face).chain(of_extra)
    }

    fn rows(&self, point: usize) -> &PointRows {
        match &self.face {
            Some(face) if point > 0 => &face.more[point - 1],
            _ => &self.block.first,
        }
    }

    fn rows_mut(&mut self, point: usize) -> &mut PointRows {
        match &mut self.face {
            Some(face) if point > 0 => &mut face.more[point - 1],
            _ => &mut self.block.first,
        }
    }

    /// Prepares one manifold in lane `l`, all but its effective masses; points closer than `reach` (m) count as touching.
    pub(crate) fn set_lane(&mut self, l: usize, input: &ContactInput, reach: f32) {
        let n = input.normal;
        let (t1, t2) = tangents(n);
        let count = input.count;
        for i in 0..count {
            let rows = self.rows_mut(i);
            put(&mut rows.lever_a, l, input.lever_a[i]);
            put(&mut rows.lever_b, l, input.lever_b[i]);
            rows.separation[l] = input.separation[i];
            let impulse = input.impulses.normal[i];
            rows.lambda[l] = if impulse > TOUCHED { impulse } else { 0.0 };
        }
        let room = if self.face.is_some() { POINTS } else { 1 };
        for i in count..room {
            let rows = self.rows_mut(i);
            put(&mut rows.lever_a, l, Vec3::ZERO);
            put(&mut rows.lever_b, l, Vec3::ZERO);
            (rows.separation[l], rows.lambda[l]) = (0.0, 0.0);
        }
        // Some of several may have inherited what others bore. One alone may have been stopped in the air and then have lost its rebound to another
        // hit; less than a fall of a substep it gapes in heaps, too.
        let near = if count > 1 { input.touching } else { input.touching.max(reach) };
        let hangs = (0..count).any(|i| self.rows(i).lambda[l] > 0.0 && input.separation[i] > near);
        let block = &mut *self.block;
        block.hangs[l] = f32::from(u8::from(hangs));
        block.a[l] = input.a;
        block.b[l] = input.b;
        put(&mut block.normal, l, n);
        block.count[l] = count as u8;
        block.is_pressed[l] = input.impulses.normal[..count].iter().any(|&impulse| impulse > TOUCHED);

        let pressed: f32 = input.impulses.normal.iter().sum();
        let carried = |lambda: f32| if lambda.abs() > NEGLIGIBLE_FRICTION * pressed { lambda } else { 0.0 };
        block.friction[l] = input.material.friction;
        block.tangent_lambda[0][l] = carried(input.impulses.friction.dot(t1));
        block.tangent_lambda[1][l] = carried(input.impulses.friction.dot(t2));
        if let Some(face) = &mut self.face {
            let inverse_count = 1.0 / count as f32;
            let center_a = input.lever_a[..count].iter().sum::<Vec3>() * inverse_count;
            let center_b = input.lever_b[..count].iter().sum::<Vec3>() * inverse_count;
            put(&mut face.center_a, l, center_a);
            put(&mut face.center_b, l, center_b);
            let spread = input.lever_a[..count].iter().map(|lever| (*lever - center_a).length()).sum::<f32>() * inverse_count;
            face.twist.arm[l] = input.material.friction * spread + input.material.spinning;
            face.twist.lambda[l] = carried(input.impulses.twist);
        }
        if count == POINTS {
            self.level(l, reach);
        }
        if let Some(extra) = &mut self.extra {
            extra.set_lane(l, input, [t1, t2], carried(input.impulses.twist));
        }
    }

    /// Evens out the load of four touching points in lane `l` of a block without changing its force or moments.
    ///
    /// Four points of a face have one combination ν of multipliers that does nothing: Σν = 0, Σν r = 0. Where some of them
    /// overlap by a micrometre and others gape by one, their rows contradict each other along ν, and the sweeps would shift the
    /// load along it until two points carry all and the face rocks on a diagonal.
    fn level(&mut self, l: usize, reach: f32) {
        if (0..POINTS).any(|i| self.rows(i).separation[l] > reach) {
            return;
        }
        let (t1, t2) = tangents(get(&self.block.normal, l));
        let p: [Vec2; POINTS] = std::array::from_fn(|i| {
            let lever = get(&self.rows(i).lever_a, l);
            Vec2::new(lever.dot(t1), lever.dot(t2))
        });
        let area = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp_dot(c - a);
        let idle = Vec4::new(area(p[1], p[2], p[3]), -area(p[0], p[2], p[3]), area(p[0], p[1], p[3]), -area(p[0], p[1], p[2]));
        let Some(idle) = idle.try_normalize() else { return };
        let lambda = Vec4::from_array(std::array::from_fn(|i| self.rows(i).lambda[l]));
        let shift = idle * idle.dot(lambda);
        let least = (lambda - shift).min_element();
        if least >= 0.0 {
            for i in 0..POINTS {
                self.rows_mut(i).lambda[l] = lambda[i] - shift[i];
            }
        }
    }
}
