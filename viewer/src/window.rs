//! The window: turn, select, pause, scrub, choose a stream, save what is seen.

use std::collections::HashMap;
use std::time::Instant;

use longspan::glam::{DVec3, Vec3 as Direction};
use longspan_scenes::picture::{Drawn, points_and_triangles};
use longspan_stream::{Domain, Poll, Reader};
use macroquad::models::{Mesh, Vertex};
use macroquad::prelude::*;

use crate::Outcome;
use crate::parts::{Layers, of_scene, pose_of};

/// Segments around what is round; a window has less time for a picture than a file.
const SEGMENTS: u32 = 12;

/// Vertices and indices of one call to the graphics driver. macroquad cuts off what is more.
const CALL_VERTICES: usize = 30_000;
const CALL_INDICES: usize = 60_000;

/// When a picture is taken that was asked for on the command line (s).
const SHOT_AFTER: f32 = 2.0;

const SKY: Color = Color::new(0.80, 0.87, 0.94, 1.0);
const TEXT: Color = Color::new(0.08, 0.09, 0.10, 1.0);
const SELECTED: Color = Color::new(1.0, 1.0, 1.0, 1.0);

struct View {
    reader: Reader,
    domain: Domain,
    layers: Layers,
    paused: bool,
    selected: Option<u64>,
    /// Where the eye looks, from which directions and how far away.
    center: DVec3,
    yaw: f32,
    pitch: f32,
    distance: f32,
    framed: bool,
    dragging: bool,
    wants_picture: bool,
    mouse: (f32, f32),
    problem: String,
    status: String,
}

/// Opens a window on a reader, until it is closed.
pub fn open(reader: Reader, domain: &Domain, shot: Option<String>) -> Outcome<()> {
    let conf = macroquad::conf::Conf {
        miniquad_conf: miniquad::conf::Conf {
            window_title: "longspan".to_owned(),
            window_width: 1200,
            window_height: 760,
            ..Default::default()
        },
        draw_call_vertex_capacity: CALL_VERTICES,
        draw_call_index_capacity: CALL_INDICES,
        ..Default::default()
    };
    let view = View {
        reader,
        domain: domain.clone(),
        layers: Layers { contacts: false, ..Layers::ALL },
        paused: false,
        selected: None,
        center: DVec3::ZERO,
        yaw: 0.4,
        pitch: 0.35,
        distance: 10.0,
        framed: false,
        dragging: false,
        wants_picture: false,
        mouse: (0.0, 0.0),
        problem: String::new(),
        status: String::new(),
    };
    macroquad::Window::from_config(conf, run(view, shot));
    Ok(())
}

async fn run(mut view: View, shot: Option<String>) {
    let start = Instant::now();
    loop {
        view.advance();
        view.turn();
        view.keys();
        clear_background(SKY);
        let parts = of_scene(view.reader.scene(), view.layers);
        view.frame(&parts);
        view.draw(&parts);
        view.write();
        if std::mem::take(&mut view.wants_picture) {
            save(&format!("longspan-{}.png", view.reader.scene().frame().step));
        }
        if let Some(file) = shot.as_ref().filter(|_| start.elapsed().as_secs_f32() > SHOT_AFTER) {
            save(file);
            return;
        }
        if is_key_down(KeyCode::Escape) {
            return;
        }
        next_frame().await;
    }
}

/// Saves what has been drawn of this frame.
fn save(file: &str) {
    // Changing the camera is what makes macroquad draw what it has collected; after the frame the buffer means nothing any more.
    set_default_camera();
    get_screen_data().export_png(file);
}

impl View {
    fn advance(&mut self) {
        if self.paused {
            return;
        }
        self.problem.clear();
        let poll = if self.reader.recording().is_some() { self.reader.poll_next() } else { self.reader.poll() };
        self.status = match poll {
            Ok(Poll::Frame { lost_frames: 0, lost_records: 0, .. }) => String::new(),
            Ok(Poll::Frame { lost_frames, lost_records, .. }) => format!("lost {lost_frames} frames, {lost_records} records"),
            Ok(Poll::Nothing) => return,
            Ok(Poll::Gone) => "nobody publishes".to_owned(),
            Ok(Poll::End) => "the recording is over".to_owned(),
            Err(problem) => {
                self.problem = problem.to_string();
                return;
            }
        };
        self.reader.forget_events();
    }

    /// Mouse: turns with the left button, selects with a click, comes nearer with the wheel; scrubs in the bar at the bottom.
    fn turn(&mut self) {
        let (x, y) = mouse_position();
        let (dx, dy) = (x - self.mouse.0, y - self.mouse.1);
        if is_mouse_button_down(MouseButton::Left) {
            if y > screen_height() - 24.0 && self.reader.recording().is_some() {
                self.scrub(x / screen_width());
            } else if !is_mouse_button_pressed(MouseButton::Left) && dx.abs() + dy.abs() > 0.0 {
                self.dragging = true;
                self.yaw -= 0.006 * dx;
                self.pitch = (self.pitch + 0.006 * dy).clamp(-1.5, 1.5);
            }
        }
        if is_mouse_button_released(MouseButton::Left) {
            if !std::mem::take(&mut self.dragging) {
                self.select(x, y);
            }
        }
        self.distance *= (1.0 - 0.1 * mouse_wheel().1.clamp(-3.0, 3.0)).max(0.2);
        self.mouse = (x, y);
    }

    fn scrub(&mut self, share: f32) {
        if let Some((first, last)) = self.reader.recording().and_then(|recording| recording.steps) {
            let step = first + ((last - first) as f64 * f64::from(share.clamp(0.0, 1.0))) as u64;
            self.seek(step);
        }
    }

    fn seek(&mut self, step: u64) {
        self.paused = true;
        if let Err(problem) = self.reader.seek(step) {
            self.problem = problem.to_string();
        }
    }

    fn keys(&mut self) {
        let here = self.reader.scene().frame().step;
        if is_key_pressed(KeyCode::Space) {
            self.paused = !self.paused;
        }
        if self.reader.recording().is_some() {
            if is_key_pressed(KeyCode::Right) {
                self.seek(here + 1);
            }
            if is_key_pressed(KeyCode::Left) {
                self.seek(here.saturating_sub(1));
            }
        }
        let Layers { support, unions, bounds, joints, contacts, planes } = &mut self.layers;
        let switches = [
            (KeyCode::S, support),
            (KeyCode::U, unions),
            (KeyCode::B, bounds),
            (KeyCode::J, joints),
            (KeyCode::C, contacts),
            (KeyCode::P, planes),
        ];
        for (key, layer) in switches {
            if is_key_pressed(key) {
                *layer = !*layer;
            }
        }
        if is_key_pressed(KeyCode::F) {
            self.framed = false;
        }
        if is_key_pressed(KeyCode::Tab) {
            self.next_source();
        }
        if is_key_pressed(KeyCode::F12) {
            self.wants_picture = true;
        }
    }

    /// Goes to the stream that comes after this one in the list of all.
    fn next_source(&mut self) {
        let (Ok(sources), Some(here)) = (self.domain.sources(), self.reader.source()) else { return };
        let next = sources.iter().find(|source| *source > here).or(sources.first());
        if let Some(reader) = next.and_then(|source| Reader::attach(&self.domain, &source.name).ok()) {
            self.reader = reader;
            self.framed = false;
        }
    }

    /// Stands back so far that everything fits, once.
    fn frame(&mut self, parts: &[(u64, Drawn)]) {
        if self.framed || parts.is_empty() {
            return;
        }
        let scene = self.reader.scene();
        let moving = scene.bodies().filter(|body| body.kind != 0).map(|body| DVec3::from_array(body.position));
        let (min, max) = moving.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), at| (min.min(at), max.max(at)));
        if min.is_finite() {
            self.center = 0.5 * (min + max);
            self.distance = 1.3 * (max - min).length() as f32 + 3.0;
            self.framed = true;
        }
    }

    fn eye(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        self.distance * vec3(cos * self.yaw.sin(), sin, cos * self.yaw.cos())
    }

    fn camera(&self) -> Camera3D {
        Camera3D { position: self.eye(), target: Vec3::ZERO, up: Vec3::Y, fovy: 0.7, ..Default::default() }
    }

    fn draw(&self, parts: &[(u64, Drawn)]) {
        set_camera(&self.camera());
        let light = Direction::new(-0.35, 1.0, 0.55).normalize();
        let mut forms: HashMap<String, (Vec<Direction>, Vec<[u32; 3]>)> = HashMap::new();
        let mut mesh = Mesh { vertices: Vec::new(), indices: Vec::new(), texture: None };
        for (body, part) in parts {
            // Bodies of one form share its triangles.
            let key = format!("{:?}", part.geometry);
            let (points, triangles) = forms.entry(key).or_insert_with(|| points_and_triangles(&part.geometry, SEGMENTS));
            let offset = (part.pose.position - self.center).as_vec3();
            let chosen = self.selected == Some(*body) && *body != 0;
            for corners in triangles {
                let corners = corners.map(|corner| offset + part.pose.rotation * points[corner as usize]);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
                let lit = 0.45 + 0.55 * (0.5 + 0.5 * normal.dot(light));
                let shade = (part.color * lit).powf(1.0 / 2.2);
                let color = if chosen { SELECTED } else { Color::new(shade.x, shade.y, shade.z, 1.0) };
                let first = mesh.vertices.len() as u16;
                mesh.vertices.extend(corners.map(|at| Vertex::new(at.x, at.y, at.z, 0.0, 0.0, color)));
                mesh.indices.extend([first, first + 1, first + 2]);
                if mesh.vertices.len() + 3 > CALL_VERTICES {
                    draw_mesh(&mesh);
                    mesh.vertices.clear();
                    mesh.indices.clear();
                }
            }
        }
        draw_mesh(&mesh);
        set_default_camera();
    }

    /// Selects the body whose middle the ray through a point of the window passes nearest to the eye, if it passes near one.
    fn select(&mut self, x: f32, y: f32) {
        let turned = self.camera().matrix();
        let at = vec2(2.0 * x / screen_width() - 1.0, 1.0 - 2.0 * y / screen_height());
        let mut best: Option<(f32, u64)> = None;
        for body in self.reader.scene().bodies().filter(|body| body.kind != 0) {
            let from_center = (pose_of(body).position - self.center).as_vec3();
            let clip = turned * vec4(from_center.x, from_center.y, from_center.z, 1.0);
            let on_screen = vec2(clip.x, clip.y) / clip.w;
            let near = clip.w > 0.0 && (on_screen - at).length() < 0.06;
            if near && best.is_none_or(|(depth, _)| clip.w < depth) {
                best = Some((clip.w, body.body));
            }
        }
        self.selected = best.map(|(_, body)| body);
    }

    fn write(&self) {
        let scene = self.reader.scene();
        let frame = scene.frame();
        let mut lines = vec![
            format!("step {}  {:.2} s  {} bodies  {} joints  hash {:016x}", frame.step, frame.time, scene.bodies().len(), scene.joints().len(), frame.state_hash),
            format!("{} {}{}", self.status, self.problem, if self.paused { " paused" } else { "" }),
            "space pause  arrows step  tab next stream  S support  U unions  B bounds  J joints  C contacts  P planes  F frame  F12 picture".to_owned(),
        ];
        if let Some(body) = self.selected.and_then(|body| scene.body(body)) {
            let [x, y, z] = body.position;
            let speed = Direction::from_array(body.linear_velocity).length();
            let turn = Direction::from_array(body.angular_velocity).length();
            lines.extend([
                format!("body {:#x}  word {}  union {:#x}", body.body, body.user_word, body.union_id),
                format!("at {x:.4} {y:.4} {z:.4} m  {speed:.3} m/s  {turn:.3} rad/s  {:.3} kg", body.mass),
                format!(
                    "support {}  margin {:.4} m  load {:.1} N  flags {:#x}",
                    body.support, body.support_margin, body.support_load, body.flags
                ),
            ]);
        }
        let worst = scene.joint_loads().iter().max_by(|a, b| a.share.total_cmp(&b.share).then(a.force.total_cmp(&b.force)));
        if let Some(load) = worst {
            let [force, torque, share] = [load.force, load.torque, 100.0 * load.share];
            lines.push(format!("worst joint {:#x}: {force:.1} N, {torque:.1} N m, {share:.0} % of its limit", load.joint));
        }
        for (number, line) in lines.iter().enumerate() {
            draw_text(line, 10.0, 20.0 + 18.0 * number as f32, 18.0, TEXT);
        }
        if let Some((first, last)) = self.reader.recording().and_then(|recording| recording.steps) {
            let share = (frame.step.saturating_sub(first)) as f32 / (last - first).max(1) as f32;
            let (width, height) = (screen_width(), screen_height());
            draw_rectangle(0.0, height - 24.0, width, 24.0, Color::new(0.6, 0.65, 0.7, 1.0));
            draw_rectangle(0.0, height - 24.0, width * share, 24.0, Color::new(0.25, 0.45, 0.7, 1.0));
        }
    }
}
