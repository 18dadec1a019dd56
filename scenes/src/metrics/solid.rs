//! Exact depth of overlap of boxes and balls, in `f64`.
//!
//! Two boxes: the least translation that parts two convex polytopes is along a face normal of one or a cross product of one edge of
//! each, so the smallest overlap over these 15 axes is the depth. Box and ball: the distance to the nearest point of the box, or
//! to its nearest face if the ball's centre lies inside.

use longspan::glam::{DMat3, DQuat, DVec3};
use longspan::{Geometry, Pose, ShapeDef};

/// A box or a ball in the world.
#[derive(Debug, Clone, Copy)]
pub enum Solid {
    /// A box.
    Box {
        /// Centre (m).
        center: DVec3,
        /// Unit axes as columns.
        axes: DMat3,
        /// Half of each edge (m).
        half: DVec3,
    },
    /// A ball.
    Ball {
        /// Centre (m).
        center: DVec3,
        /// Radius (m).
        radius: f64,
    },
}

impl Solid {
    /// The solid of a shape on a body at `pose`; `None` for forms other than boxes and balls.
    pub fn of(shape: &ShapeDef, pose: &Pose) -> Option<Self> {
        let turn: DQuat = pose.rotation.as_dquat().normalize();
        let center = pose.position + turn * shape.local_pose.position.as_dvec3();
        match shape.shape.geometry() {
            Geometry::Ball { radius } => Some(Self::Ball { center, radius: f64::from(*radius) }),
            Geometry::Box { half_extents } => {
                let axes = DMat3::from_quat(turn * shape.local_pose.rotation.as_dquat().normalize());
                Some(Self::Box { center, axes, half: half_extents.as_dvec3() })
            }
            _ => None,
        }
    }

    /// Least and greatest corner of the axis-aligned box around it (m).
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (center, reach) = match *self {
            Self::Ball { center, radius } => (center, DVec3::splat(radius)),
            Self::Box { center, axes, half } => {
                (center, axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z)
            }
        };
        (center - reach, center + reach)
    }
}

/// Depth of overlap (m): the least distance that parts the two; negative or zero where they do not overlap.
pub fn overlap_depth(a: &Solid, b: &Solid) -> f64 {
    match (a, b) {
        (&Solid::Ball { center: p, radius: r }, &Solid::Ball { center: q, radius: s }) => r + s - p.distance(q),
        (&Solid::Ball { center, radius }, box_ @ Solid::Box { .. })
        | (box_ @ Solid::Box { .. }, &Solid::Ball { center, radius }) => radius - distance_to_box(center, box_),
        (Solid::Box { .. }, Solid::Box { .. }) => box_box(a, b),
    }
}

/// Distance of a point from a box, negative inside (m).
fn distance_to_box(point: DVec3, solid: &Solid) -> f64 {
    let &Solid::Box { center, axes, half } = solid else { return f64::INFINITY };
    let beyond = (axes.transpose() * (point - center)).abs() - half;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
}

fn box_box(a: &Solid, b: &Solid) -> f64 {
    let (&Solid::Box { center: p, axes: u, half: h }, &Solid::Box { center: q, axes: v, half: k }) = (a, b) else {
        return f64::NEG_INFINITY;
    };
    let between = q - p;
    let reach = |axes: &DMat3, half: DVec3, along: DVec3| (axes.transpose() * along).abs().dot(half);
    let overlap = |along: DVec3| reach(&u, h, along) + reach(&v, k, along) - between.dot(along).abs();
    let (edges_a, edges_b) = ([u.x_axis, u.y_axis, u.z_axis], [v.x_axis, v.y_axis, v.z_axis]);
    let mut depth = f64::INFINITY;
    for axis in edges_a.into_iter().chain(edges_b) {
        depth = depth.min(overlap(axis));
    }
    for edge_a in edges_a {
        for edge_b in edges_b {
            // Nearly parallel edges span no axis of their own; a face normal stands for them.
            let across = edge_a.cross(edge_b);
            if across.length_squared() > 1e-12 {
                depth = depth.min(overlap(across.normalize()));
            }
        }
    }
    depth
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, SQRT_2};

    use super::*;

    fn unit_box(center: DVec3, turn: DQuat) -> Solid {
        Solid::Box { center, axes: DMat3::from_quat(turn), half: DVec3::splat(0.5) }
    }

    fn ball(x: f64, y: f64, z: f64, radius: f64) -> Solid {
        Solid::Ball { center: DVec3::new(x, y, z), radius }
    }

    fn check(a: &Solid, b: &Solid, expected: f64) {
        for depth in [overlap_depth(a, b), overlap_depth(b, a)] {
            assert!((depth - expected).abs() < 1e-12, "{depth} m, expected {expected} m");
        }
    }

    #[test]
    fn boxes_overlap_by_what_parts_them() {
        let upright = unit_box(DVec3::ZERO, DQuat::IDENTITY);
        check(&upright, &unit_box(DVec3::new(0.1, 0.97, 0.0), DQuat::IDENTITY), 0.03);
        check(&upright, &unit_box(DVec3::new(0.0, 1.02, 0.0), DQuat::IDENTITY), -0.02);
        // A box standing on its edge reaches √½ down.
        let on_edge = DQuat::from_rotation_z(FRAC_PI_4);
        check(&upright, &unit_box(DVec3::new(0.0, 0.5 + FRAC_1_SQRT_2 - 0.01, 0.0), on_edge), 0.01);
        // Two edges crossing at right angles, seen along the line between them.
        let below = unit_box(DVec3::ZERO, DQuat::from_rotation_z(FRAC_PI_4));
        let above = unit_box(DVec3::new(0.0, SQRT_2 - 0.005, 0.0), DQuat::from_rotation_x(FRAC_PI_4));
        check(&below, &above, 0.005);
    }

    #[test]
    fn balls_overlap_boxes_outside_and_inside() {
        let upright = unit_box(DVec3::ZERO, DQuat::IDENTITY);
        check(&upright, &ball(0.0, 0.7, 0.0, 0.25), 0.05);
        let corner = 0.5 + 0.1 / 3.0_f64.sqrt();
        check(&upright, &ball(corner, corner, corner, 0.25), 0.15);
        check(&upright, &ball(0.0, 0.4, 0.1, 0.25), 0.35);
        check(&ball(0.0, 0.0, 0.0, 0.5), &ball(0.0, 0.0, 0.9, 0.5), 0.1);
    }
}
