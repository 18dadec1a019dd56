//! Drawing what a world holds, layer by layer.

mod joints;
mod spans;

use std::fmt::{self, Write};

use glam::{DVec3, Quat, Vec3};

use super::World;
use crate::body::{Body, BodyKind};
use crate::debug::form;
use crate::debug::{Color, DebugDraw, DrawLayers, DrawOptions};
use crate::error::Result;
use crate::report::Contact;

/// Half the extent of what of a half-space counts as near (m): it has no end.
const PLANE_REACH: f64 = 30.0;

/// What a layer draws with.
struct Pen<'a> {
    out: &'a mut dyn DebugDraw,
    options: DrawOptions,
    words: String,
}

impl Pen<'_> {
    fn line(&mut self, from: DVec3, to: DVec3, color: Color) {
        self.out.line(from, to, color);
    }

    fn text(&mut self, at: DVec3, text: fmt::Arguments, color: Color) {
        self.words.clear();
        // Writing to a string does not fail.
        let _ = self.words.write_fmt(text);
        self.out.text(at, &self.words, color);
    }

    /// A line with a small cross at its far end.
    fn arrow(&mut self, from: DVec3, along: Vec3, color: Color) {
        if along != Vec3::ZERO {
            let to = from + along.as_dvec3();
            self.out.line(from, to, color);
            self.cross(to, self.options.mark_size * 0.3, color);
        }
    }

    fn cross(&mut self, at: DVec3, size: f32, color: Color) {
        for axis in DVec3::AXES {
            let half = axis * f64::from(size * 0.5);
            self.out.line(at - half, at + half, color);
        }
    }

    fn axes(&mut self, at: DVec3, rotation: Quat, length: f32) {
        for (axis, color) in Vec3::AXES.into_iter().zip([Color::RED, Color::GREEN, Color::BLUE]) {
            self.out.line(at, at + (rotation * axis * length).as_dvec3(), color);
        }
    }

    /// Whether any of a ball may be near enough to be drawn.
    fn reaches(&self, center: DVec3, radius: f64) -> bool {
        self.options.within.is_none_or(|(eye, distance)| eye.distance(center) <= distance + radius)
    }

    fn wants(&self, layers: DrawLayers) -> bool {
        self.options.layers.intersects(layers)
    }
}

impl World {
    /// Draws what the world holds now: the layers that `options` names, each in an order that depends on the world alone.
    ///
    /// # Errors
    /// A number of `options` is out of range.
    pub fn draw(&self, options: &DrawOptions, out: &mut dyn DebugDraw) -> Result<()> {
        options.check()?;
        let mut pen = Pen { out, options: *options, words: String::new() };
        if pen.wants(DrawLayers::SHAPES | DrawLayers::SURFACES | DrawLayers::BOXES) {
            self.draw_shapes(&mut pen);
        }
        if pen.wants(DrawLayers::MASS | DrawLayers::VELOCITIES) {
            self.draw_motion(&mut pen);
        }
        if pen.wants(DrawLayers::CONTACTS | DrawLayers::CONTACT_FORCES) {
            self.draw_contacts(&mut pen);
        }
        if pen.wants(DrawLayers::JOINTS | DrawLayers::JOINT_LIMITS | DrawLayers::JOINT_LOADS) {
            self.draw_joints(&mut pen);
        }
        if pen.wants(DrawLayers::ISLANDS) {
            self.draw_islands(&mut pen);
        }
        if pen.wants(DrawLayers::BOUNDS) {
            self.draw_bounds(&mut pen);
        }
        if pen.wants(DrawLayers::PLANES) {
            self.draw_planes(&mut pen);
        }
        if pen.wants(DrawLayers::UNIONS) {
            self.draw_unions(&mut pen);
        }
        if pen.wants(DrawLayers::SUPPORT) {
            self.draw_support(&mut pen);
        }
        Ok(())
    }

    fn draw_shapes(&self, pen: &mut Pen) {
        for (_, shape) in self.colliders.iter() {
            let body = &self.bodies[shape.body];
            let reach = f64::from(shape.reach).min(PLANE_REACH);
            if !pen.reaches(body.center, reach) {
                continue;
            }
            let (at, rotation) = shape.world_pose(body);
            let (color, world) =
                (if shape.sensor { Color::GREEN } else { color_of(body) }, |point: Vec3| at + (rotation * point).as_dvec3());
            if pen.wants(DrawLayers::SHAPES) {
                form::outline(shape.shape.parry(), &mut |from, to| pen.line(world(from), world(to), color));
            }
            if pen.wants(DrawLayers::SURFACES) {
                form::surface(shape.shape.parry(), &mut |corners| pen.out.triangle(corners.map(world), color));
            }
            if let Some(kept) = shape.fat_box.filter(|_| pen.wants(DrawLayers::BOXES)) {
                form::box_edges(kept.mins, kept.maxs, &mut |from, to| pen.line(from.as_dvec3(), to.as_dvec3(), Color::MAGENTA));
            }
        }
    }

    fn draw_motion(&self, pen: &mut Pen) {
        for (_, body) in self.bodies.iter().filter(|(_, body)| body.kind != BodyKind::Static) {
            if !pen.reaches(body.center, 0.0) {
                continue;
            }
            if let Some(mass) = body.mass.filter(|_| pen.wants(DrawLayers::MASS)) {
                pen.axes(body.center, body.rotation * mass.inertia_frame, pen.options.mark_size);
            }
            if pen.wants(DrawLayers::VELOCITIES) {
                pen.arrow(body.center, body.linear_velocity * pen.options.velocity_scale, Color::CYAN);
            }
        }
    }

    fn draw_contacts(&self, pen: &mut Pen) {
        let asleep = self.islands.sleeping.pairs().map(|slot| (self.collision.pairs.get(slot).key, slot));
        for (key, slot) in self.collision.pairs.listed().iter().copied().chain(asleep) {
            self.contacts_now(key, slot).for_each(|contact| draw_contact(pen, &contact));
        }
    }

    fn draw_islands(&self, pen: &mut Pen) {
        let awake = self.islands.groups.islands().map(|members| (members, true));
        let asleep = self.islands.sleeping.islands().iter().flatten().map(|island| (island.bodies.as_slice(), false));
        for (members, is_awake) in awake.chain(asleep) {
            let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            // Groups are those of the last step: since then members may have been destroyed, or fallen asleep.
            let here =
                |&&index: &&u32| self.bodies.get(index).is_some_and(|body| body.is_dynamic() && body.is_awake() == is_awake);
            for &index in members.iter().filter(here) {
                let shapes = self.bodies[index].shapes.iter().filter_map(|&id| self.colliders.find(id).ok());
                for shape in shapes.map(|slot| &self.colliders[slot]) {
                    let around = shape.box_at(shape.world_pose(&self.bodies[index]), 0.0);
                    (min, max) = (min.min(around.mins), max.max(around.maxs));
                }
            }
            let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
            if min.x <= max.x && pen.reaches(center.as_dvec3(), f64::from(half.length())) {
                let color = if is_awake { Color::of_number(members[0]) } else { Color::DIM };
                form::box_edges(min, max, &mut |from, to| pen.line(from.as_dvec3(), to.as_dvec3(), color));
            }
        }
        for island in &self.events.islands {
            let Ok(at) = self.bodies.find(island.body).map(|index| self.bodies[index].center) else { continue };
            if pen.reaches(at, 0.0) {
                let note = if island.given_up { ", given up" } else { "" };
                pen.text(at, format_args!("{:?}{note}", island.plan), Color::WHITE);
            }
        }
    }
}

fn draw_contact(pen: &mut Pen, contact: &Contact) {
    let (scale, size) = (pen.options.force_scale, pen.options.mark_size);
    let pressing: f32 = contact.points().iter().map(|point| point.normal_force).sum();
    for point in contact.points() {
        if !pen.reaches(point.position, 0.0) {
            continue;
        }
        if pen.wants(DrawLayers::CONTACTS) {
            let color = if point.normal_force > 0.0 { Color::WHITE } else { Color::GREY };
            pen.cross(point.position, size * 0.5, color);
            pen.line(point.position, point.position + (contact.normal * size).as_dvec3(), color);
        }
        if pen.wants(DrawLayers::CONTACT_FORCES) && point.normal_force > 0.0 {
            // Friction acts on the whole contact: each point is drawn with its share by load.
            pen.arrow(point.position, contact.normal * (point.normal_force * scale), Color::RED);
            pen.arrow(point.position, contact.friction_force * (point.normal_force / pressing * scale), Color::ORANGE);
        }
    }
}

fn color_of(body: &Body) -> Color {
    match body.kind {
        _ if body.quarantined => Color::RED,
        BodyKind::Static => Color::GREY,
        BodyKind::Kinematic => Color::BLUE,
        BodyKind::Dynamic if !body.is_awake() => Color::DIM,
        BodyKind::Dynamic if body.held => Color::YELLOW,
        BodyKind::Dynamic => Color::ORANGE,
    }
}
