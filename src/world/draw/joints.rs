//! Draws joints for the debug view: frames, limits, loads.

use std::f32::consts::PI;

use glam::{DVec3, Quat, Vec3};

use super::Pen;
use crate::debug::form::arc_from;
use crate::debug::{Color, DrawLayers};
use crate::joint::{JointKind, Limits};
use crate::joint_record::Joint;
use crate::world::World;

/// Radius of the arc of an angle's limits, and half the length of a mark across a sliding joint, over the size of a mark.
const LIMIT_SIZE: f32 = 2.0;
const STOP_SIZE: f32 = 0.5;

/// Rim lines of a swing limit's cone.
const CONE_LINES: u32 = 16;

/// Both sides of a joint in the world: centre of mass of the body if there is one, anchor point and joint frame.
struct Sides {
    centers: [Option<DVec3>; 2],
    points: [DVec3; 2],
    frames: [Quat; 2],
}

impl World {
    pub(super) fn draw_joints(&self, pen: &mut Pen) {
        for (slot, joint) in self.joints.iter() {
            let ends = [self.end(joint, 0), self.end(joint, 1)];
            let sides = Sides {
                centers: [0, 1].map(|side| joint.bodies[side].map(|index| self.bodies[index].center)),
                points: [0, 1].map(|side: usize| ends[side].origin + ends[side].lever.as_dvec3()),
                frames: [0, 1].map(|side: usize| ends[side].frame),
            };
            if !pen.reaches(sides.points[0], sides.points[0].distance(sides.points[1])) {
                continue;
            }
            if pen.wants(DrawLayers::JOINTS) {
                draw_sides(pen, &sides);
            }
            if pen.wants(DrawLayers::JOINT_LIMITS)
                && let Ok(state) = self.joint_state(self.joints.handle_of(slot))
            {
                draw_limits(pen, &joint.def.kind, &sides, state.position);
            }
            if pen.wants(DrawLayers::JOINT_LOADS) {
                draw_load(pen, joint, sides.points[1]);
            }
        }
    }
}

fn draw_sides(pen: &mut Pen, sides: &Sides) {
    for side in 0..2 {
        if let Some(center) = sides.centers[side] {
            pen.line(center, sides.points[side], Color::CYAN);
        }
        pen.axes(sides.points[side], sides.frames[side], pen.options.mark_size * if side == 0 { 1.0 } else { 0.7 });
    }
    pen.line(sides.points[0], sides.points[1], Color::RED);
}

fn draw_limits(pen: &mut Pen, kind: &JointKind, sides: &Sides, position: f32) {
    let (at, frame, size) = (sides.points[0], sides.frames[0], pen.options.mark_size * LIMIT_SIZE);
    let world = |point: Vec3| at + (frame * point).as_dvec3();
    match *kind {
        JointKind::Hinge { limits, .. } => {
            draw_angle(pen, &world, limits, size);
            let (sin, cos) = libm::sincosf(position);
            pen.line(at, world(Vec3::new(0.0, cos, sin) * size), Color::YELLOW);
        }
        JointKind::Spherical { swing_limit, twist_limits, .. } => {
            if swing_limit < PI {
                draw_cone(pen, &world, swing_limit, size);
            }
            draw_angle(pen, &world, twist_limits, size * 0.6);
            pen.line(at, at + (sides.frames[1] * Vec3::X * size).as_dvec3(), Color::YELLOW);
        }
        JointKind::Prismatic { limits, .. } => {
            draw_slide(pen, &world, limits);
            pen.cross(world(Vec3::X * position), pen.options.mark_size * STOP_SIZE, Color::YELLOW);
        }
        JointKind::Distance { limits, .. } => {
            let along = (sides.points[1] - at).normalize_or(DVec3::X);
            for stop in [limits.min, limits.max].into_iter().filter(|stop| stop.is_finite()) {
                pen.cross(at + along * f64::from(stop), pen.options.mark_size * STOP_SIZE, Color::MAGENTA);
            }
            pen.line(at, sides.points[1], Color::YELLOW);
        }
        JointKind::Generic { linear, .. } => {
            for (axis, direction) in linear.iter().zip(Vec3::AXES) {
                let turn = Quat::from_rotation_arc(Vec3::X, direction);
                draw_slide(pen, &|point| world(turn * point), axis.limits);
            }
        }
        JointKind::Fixed => {}
    }
}

/// An arc about the joint axis between two angles, with the rays at its ends.
fn draw_angle(pen: &mut Pen, world: &dyn Fn(Vec3) -> DVec3, limits: Limits, size: f32) {
    if !limits.min.is_finite() && !limits.max.is_finite() {
        return;
    }
    // A full circle where the limits are a turn or more apart, or only one is finite.
    let (min, max) = if limits.max - limits.min < 2.0 * PI { (limits.min, limits.max) } else { (-PI, PI) };
    arc_from(Vec3::ZERO, (Vec3::Y, Vec3::Z), size, (min, max), &mut |from, to| pen.line(world(from), world(to), Color::MAGENTA));
    for stop in [limits.min, limits.max].into_iter().filter(|stop| stop.is_finite()) {
        let (sin, cos) = libm::sincosf(stop);
        pen.line(world(Vec3::ZERO), world(Vec3::new(0.0, cos, sin) * size), Color::MAGENTA);
    }
}

fn draw_cone(pen: &mut Pen, world: &dyn Fn(Vec3) -> DVec3, half_angle: f32, size: f32) {
    let (sin, cos) = libm::sincosf(half_angle);
    let rim = |i: u32| {
        let (y, z) = libm::sincosf(i as f32 / CONE_LINES as f32 * 2.0 * PI);
        Vec3::new(cos, sin * y, sin * z) * size
    };
    for i in 0..CONE_LINES {
        pen.line(world(rim(i)), world(rim(i + 1)), Color::MAGENTA);
        if i % 4 == 0 {
            pen.line(world(Vec3::ZERO), world(rim(i)), Color::MAGENTA);
        }
    }
}

/// The line between two stops, with a mark across it at each.
fn draw_slide(pen: &mut Pen, world: &dyn Fn(Vec3) -> DVec3, limits: Limits) {
    let stops = [limits.min, limits.max];
    let half = Vec3::Y * (pen.options.mark_size * STOP_SIZE);
    for stop in stops.into_iter().filter(|stop| stop.is_finite() && limits.min < limits.max) {
        pen.line(world(Vec3::X * stop - half), world(Vec3::X * stop + half), Color::MAGENTA);
    }
    if stops.iter().all(|stop| stop.is_finite()) && limits.min < limits.max {
        pen.line(world(Vec3::X * limits.min), world(Vec3::X * limits.max), Color::MAGENTA);
    }
}

fn draw_load(pen: &mut Pen, joint: &Joint, at: DVec3) {
    let (force, torque) = (joint.force.length(), joint.torque.length());
    let share = (force / joint.def.break_force).max(torque / joint.def.break_torque);
    // Against a limit of zero or of infinity there is no share.
    let color = if share.is_finite() { Color::of_share(share) } else { Color::RED };
    pen.arrow(at, joint.force * pen.options.force_scale, color);
    pen.text(at, format_args!("{force:.0} N"), color);
}
