//! Triangles into pixels, nearest first.

use longspan::glam::{Mat3, Vec2, Vec3};

use super::mesh::Triangle;

/// Nearer than this nothing is drawn (m).
const NEAR: f32 = 1e-3;

/// From the scene to pixels and depth.
pub(super) struct Projection {
    /// Scene to camera axes: right, up, backwards.
    pub turn: Mat3,
    pub origin: Vec3,
    /// Tangents of half the field of view; `None` looks along parallel rays, over a range from −1 to 1.
    pub tangents: Option<Vec2>,
    pub columns: usize,
    pub rows: usize,
}

impl Projection {
    /// Pixel coordinates and depth of a point; `None` behind a perspective camera.
    pub fn apply(&self, point: Vec3) -> Option<(Vec2, f32)> {
        let local = self.turn * (point - self.origin);
        let depth = -local.z;
        let plane = match self.tangents {
            Some(_) if depth < NEAR => return None,
            Some(tangents) => local.truncate() / (depth * tangents),
            None => local.truncate(),
        };
        let at = Vec2::new(1.0 + plane.x, 1.0 - plane.y) * 0.5 * Vec2::new(self.columns as f32, self.rows as f32);
        Some((at, depth))
    }
}

/// Depth of what is nearest, pixel by pixel.
pub(super) struct DepthMap {
    columns: usize,
    depths: Vec<f32>,
}

impl DepthMap {
    pub fn new(columns: usize, rows: usize) -> Self {
        Self { columns, depths: vec![f32::INFINITY; columns * rows] }
    }

    /// Infinite outside the picture.
    pub fn at(&self, column: i64, row: i64) -> f32 {
        if column < 0 || row < 0 || column >= self.columns as i64 {
            return f32::INFINITY;
        }
        self.depths.get(row as usize * self.columns + column as usize).copied().unwrap_or(f32::INFINITY)
    }
}

#[derive(Clone, Copy)]
struct Corner {
    point: Vec3,
    normal: Vec3,
}

/// Calls `paint` with index, point and normal of each pixel where the triangle is nearest so far.
pub(super) fn rasterize(
    triangle: &Triangle,
    projection: &Projection,
    depths: &mut DepthMap,
    paint: &mut impl FnMut(usize, Vec3, Vec3),
) {
    let corner = |index: usize| Corner { point: triangle.points[index], normal: triangle.normals[index] };
    let polygon = clipped([corner(0), corner(1), corner(2)], projection);
    for index in 2..polygon.len() {
        fill([polygon[0], polygon[index - 1], polygon[index]], projection, depths, paint);
    }
}

/// The part of a triangle before a perspective camera: three or four corners, or none.
fn clipped(corners: [Corner; 3], projection: &Projection) -> Vec<Corner> {
    if projection.tangents.is_none() {
        return corners.to_vec();
    }
    // Twice the nearest depth, so that rounding leaves no corner behind.
    let before = |corner: &Corner| -(projection.turn * (corner.point - projection.origin)).z - 2.0 * NEAR;
    let mut polygon = Vec::with_capacity(4);
    for index in 0..3 {
        let (here, next) = (corners[index], corners[(index + 1) % 3]);
        let (a, b) = (before(&here), before(&next));
        if a >= 0.0 {
            polygon.push(here);
        }
        if (a >= 0.0) != (b >= 0.0) {
            let share = a / (a - b);
            let cut = |from: Vec3, to: Vec3| from.lerp(to, share);
            polygon.push(Corner { point: cut(here.point, next.point), normal: cut(here.normal, next.normal) });
        }
    }
    polygon
}

fn fill(corners: [Corner; 3], projection: &Projection, depths: &mut DepthMap, paint: &mut impl FnMut(usize, Vec3, Vec3)) {
    let [Some(a), Some(b), Some(c)] = corners.map(|corner| projection.apply(corner.point)) else { return };
    let double_area = (b.0 - a.0).perp_dot(c.0 - a.0);
    if double_area == 0.0 || !double_area.is_finite() {
        return;
    }
    let limit = Vec2::new(projection.columns as f32, projection.rows as f32);
    let low = a.0.min(b.0).min(c.0).floor().clamp(Vec2::ZERO, limit);
    let high = a.0.max(b.0).max(c.0).ceil().clamp(Vec2::ZERO, limit);
    for row in low.y as usize..high.y as usize {
        for column in low.x as usize..high.x as usize {
            let at = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
            let on_screen = [(b.0 - at).perp_dot(c.0 - at), (c.0 - at).perp_dot(a.0 - at), (a.0 - at).perp_dot(b.0 - at)];
            let weights = Vec3::from_array(on_screen) / double_area;
            if weights.min_element() < 0.0 {
                continue;
            }
            // Under perspective, what is linear over the triangle is linear on the screen only after division by depth.
            let weights = match projection.tangents {
                Some(_) => weights / Vec3::new(a.1, b.1, c.1),
                None => weights,
            };
            let weights = weights / weights.element_sum();
            let depth = weights.dot(Vec3::new(a.1, b.1, c.1));
            let index = row * projection.columns + column;
            if depth < depths.depths[index] {
                depths.depths[index] = depth;
                let mix = |of: fn(&Corner) -> Vec3| {
                    of(&corners[0]) * weights.x + of(&corners[1]) * weights.y + of(&corners[2]) * weights.z
                };
                paint(index, mix(|corner| corner.point), mix(|corner| corner.normal).normalize_or_zero());
            }
        }
    }
}
