//! What a body stands on, as the pass sees it: manifolds and their points.

use glam::{DVec3, Vec3};

use super::super::batch::Batch;
use super::super::contact::tangents;
use super::super::contact_block::ContactBlocks;
use super::super::state::BodyVelocity;

/// A manifold through which `upper` stands on `lower`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    pub upper: u32,
    pub lower: u32,
    pub block: u32,
    pub lane: u8,
    /// Whether the upper body is the block's B.
    pub upper_is_b: bool,
    /// Number of its points, and the first of them.
    count: u8,
    first: u32,
    /// Its middle, from both centres of mass, and the directions of friction.
    pub center_upper: Vec3,
    pub center_lower: Vec3,
    pub tangents: [Vec3; 2],
    pub friction: f32,
}

impl Patch {
    /// The manifold of a lane, if the vertical lies in its friction cone.
    pub(super) fn of(contacts: &ContactBlocks, number: u32, lane: usize, up: Vec3) -> Option<Self> {
        let block = &contacts.blocks[number as usize];
        let normal = block.normal_of(lane);
        let rise = normal.dot(up);
        let friction = block.friction[lane];
        if !block.is_movable(lane) || rise * rise * (1.0 + friction * friction) < 1.0 {
            return None;
        }
        let (a, b) = (block.a[lane], block.b[lane]);
        let (center_a, center_b) = contacts.centers_of(number as usize, lane);
        let upper_is_b = rise > 0.0;
        let (lower, upper) = if upper_is_b { (a, b) } else { (b, a) };
        let (center_lower, center_upper) = if upper_is_b { (center_a, center_b) } else { (center_b, center_a) };
        let (t1, t2) = tangents(normal);
        let (lane, count, first, tangents) = (lane as u8, 0, 0, [t1, t2]);
        Some(Self { upper, lower, block: number, lane, upper_is_b, count, first, center_upper, center_lower, tangents, friction })
    }

    /// Adds its points to the end of `points`.
    pub(super) fn list_points(&mut self, batch: &Batch, axes: &[Vec3; 3], points: &mut Vec<Point>) {
        let (number, lane) = (self.block as usize, usize::from(self.lane));
        let normal = batch.contacts.blocks[number].normal_of(lane) * if self.upper_is_b { 1.0 } else { -1.0 };
        let responses = &batch.velocities[self.upper as usize];
        self.first = points.len() as u32;
        for index in 0..batch.contacts.room_of(number) {
            let rows = batch.contacts.rows(number, index);
            if rows.inverse_diagonal[lane] <= 0.0 {
                continue;
            }
            let (lever_a, lever_b) = rows.levers_of(lane);
            let (lever_lower, lever_upper) = if self.upper_is_b { (lever_a, lever_b) } else { (lever_b, lever_a) };
            let column = rows_of(responses, axes, normal, lever_upper.cross(normal));
            let Self { upper, lower, block, lane, .. } = *self;
            let (index, lambda, closing_speed) = (index as u8, 0.0, 0.0);
            points.push(Point {
                upper,
                lower,
                block,
                lane,
                index,
                normal,
                lever_upper,
                lever_lower,
                column,
                lambda,
                closing_speed,
            });
        }
        self.count = (points.len() - self.first as usize) as u8;
    }

    pub(super) fn points(&self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + usize::from(self.count)
    }

    /// Friction on the upper body now (N·s).
    pub(super) fn rubbed(&self, batch: &Batch) -> Vec3 {
        let block = &batch.contacts.blocks[self.block as usize];
        let [t1, t2] = self.tangents;
        let on_b = t1 * block.tangent_lambda[0][self.lane as usize] + t2 * block.tangent_lambda[1][self.lane as usize];
        if self.upper_is_b { on_b } else { -on_b }
    }
}

/// A point of a patch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub upper: u32,
    pub lower: u32,
    pub block: u32,
    pub lane: u8,
    pub index: u8,
    /// From lower to upper.
    pub normal: Vec3,
    pub lever_upper: Vec3,
    pub lever_lower: Vec3,
    /// What a unit of λ is in the rows that are balanced; see [`rows_of`].
    pub column: DVec3,
    /// Of this substep; see [`PointRows`](super::super::contact_block::PointRows).
    pub lambda: f32,
    pub closing_speed: f32,
}

/// The rows in which a body is balanced: momentum along up and angular momentum about the two axes across it, each of these over
/// the radius of gyration √(I/m).
///
/// What cannot be balanced is then least in ½ v·M v, as the sweeps have it, and not in a sum of forces and moments.
pub(super) fn rows_of(velocity: &BodyVelocity, &[up, u, v]: &[Vec3; 3], push: Vec3, turn: Vec3) -> DVec3 {
    let inverse_mass = velocity.inverse_mass.max_element();
    let inverse_gyration = |axis: Vec3| {
        let squared = axis.dot(velocity.inverse_inertia.mul(axis)) / inverse_mass;
        // What cannot turn has no such radius, and is balanced about any.
        if squared > 0.0 { squared.sqrt() } else { 1.0 }
    };
    Vec3::new(push.dot(up), turn.dot(u) * inverse_gyration(u), turn.dot(v) * inverse_gyration(v)).as_dvec3()
}
