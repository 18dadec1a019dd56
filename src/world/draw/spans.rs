//! Draws long-range bounds, planes, unions and supports.

use glam::{DQuat, DVec3, Vec3};

use super::Pen;
use crate::debug::Color;
use crate::joint_graph::support::verdict::Verdict;
use crate::long_range::BoundState;
use crate::world::World;

impl World {
    pub(super) fn draw_bounds(&self, pen: &mut Pen) {
        for bound in self.bounds() {
            let middle = (bound.points[0] + bound.points[1]) * 0.5;
            if pen.reaches(middle, f64::from(bound.distance) * 0.5) {
                draw_bound(pen, &bound, middle);
            }
        }
    }

    pub(super) fn draw_planes(&self, pen: &mut Pen) {
        for chain in &self.long_range.chains {
            let frame = |index: u32| match self.unions.moving(index) {
                Some(union) => (union.motion.center, union.motion.rotation),
                None => (self.bodies[index].center, self.bodies[index].rotation),
            };
            let members: Vec<(DVec3, Vec3, f32)> = chain
                .members
                .iter()
                .map(|member| {
                    let (center, rotation) = frame(member.body);
                    (center, rotation * member.axis, member.height)
                })
                .collect();
            let normal = members.iter().map(|(_, axis, _)| *axis).sum::<Vec3>().normalize_or_zero();
            let foot = |&(center, _, height): &(DVec3, Vec3, f32)| center - (normal * height).as_dvec3();
            let middle = members.iter().map(foot).sum::<DVec3>() / members.len() as f64;
            let reach = members.iter().map(|member| foot(member).distance(middle)).fold(f64::from(chain.size), f64::max);
            if normal == Vec3::ZERO || !pen.reaches(middle, reach) {
                continue;
            }
            let color = Color::of_number(chain.joints.first().copied().unwrap_or_default());
            let corner = |turn: f64| {
                let about = DQuat::from_axis_angle(normal.as_dvec3().normalize(), turn * std::f64::consts::FRAC_PI_2);
                middle + about * (normal.any_orthonormal_vector().as_dvec3() * (reach * std::f64::consts::SQRT_2))
            };
            for side in 0..4 {
                pen.line(corner(f64::from(side)), corner(f64::from(side + 1)), color);
            }
            pen.arrow(middle, normal * (reach as f32 * 0.25), color);
            pen.text(middle, format_args!("plane of {}", members.len()), color);
            for member in &members {
                pen.line(member.0, foot(member), color);
                pen.cross(foot(member), pen.options.mark_size, color);
            }
        }
    }

    pub(super) fn draw_unions(&self, pen: &mut Pen) {
        for union in self.unions.iter() {
            let center = union.motion.center;
            let places: Vec<DVec3> = union.members.iter().map(|&member| self.bodies[member].center).collect();
            let reach = places.iter().map(|place| place.distance(center)).fold(0.0, f64::max);
            if !pen.reaches(center, reach) {
                continue;
            }
            let color = Color::of_number(union.lead);
            pen.cross(center, pen.options.mark_size, color);
            pen.text(center, format_args!("{} bodies", places.len()), color);
            places.into_iter().for_each(|place| pen.line(center, place, color));
        }
    }

    pub(super) fn draw_support(&self, pen: &mut Pen) {
        for (index, body) in self.bodies.iter().filter(|(_, body)| body.is_dynamic()) {
            let id = self.bodies.handle_of(index);
            let Ok(support) = self.support(id) else { return };
            if !pen.reaches(body.center, 0.0) {
                continue;
            }
            let color = color_of(support.verdict);
            pen.cross(body.center, pen.options.mark_size, color);
            let corners = self.support_hull(id).unwrap_or_default();
            let points = self.supporting_points(index);
            for &point in &points {
                pen.cross(point, pen.options.mark_size * 0.5, color);
            }
            // The hull is seen along gravity: it is drawn where the contacts are, below the centre of mass.
            let gravity = self.def.gravity.normalize_or_zero().as_dvec3();
            let depth = points.iter().map(|point| (*point - body.center).dot(gravity)).fold(0.0, f64::max);
            let corners: Vec<DVec3> = corners.iter().map(|corner| *corner + gravity * depth).collect();
            for (i, &corner) in corners.iter().enumerate() {
                pen.line(corner, corners[(i + 1) % corners.len()], color);
            }
            for pair in corners.windows(2).skip(1) {
                pen.out.triangle([corners[0], pair[0], pair[1]], color);
            }
            if !corners.is_empty() {
                pen.line(body.center, body.center + gravity * depth, color);
            }
        }
    }
}

/// A taut bound is red and says its tension (N), one that pushes blue, a slack one green with what is left of its length (m).
fn draw_bound(pen: &mut Pen, bound: &BoundState, middle: DVec3) {
    let [near, far] = bound.points;
    let color = match bound.tension {
        tension if tension > 0.0 => Color::RED,
        tension if tension < 0.0 => Color::BLUE,
        _ if bound.active => Color::YELLOW,
        _ => Color::GREEN,
    };
    pen.line(near, far, color);
    if bound.tension == 0.0 {
        pen.text(middle, format_args!("{:.3} m", bound.slack()), color);
    } else {
        pen.text(middle, format_args!("{:.0} N", bound.tension), color);
    }
}

fn color_of(verdict: Verdict) -> Color {
    match verdict {
        Verdict::Supported | Verdict::Ground => Color::GREEN,
        Verdict::HeldByJoints | Verdict::Braced => Color::CYAN,
        Verdict::OutsideHull | Verdict::OnUnsupported => Color::ORANGE,
        Verdict::Sliding => Color::YELLOW,
        Verdict::NoContact | Verdict::HangingLoose | Verdict::Moving | Verdict::NoGravity => Color::RED,
    }
}
