//! The window: turn, select, pause, scrub, choose a stream, save what is seen.
//!
//! What the user does is written to standard output, a line each, so that a script that presses keys can tell what they did.

mod text;

use std::collections::{HashMap, VecDeque};
use std::time::Instant;

use longspan::glam::{DVec3, Vec3 as Direction};
use longspan_scenes::picture::{Drawn, points_and_triangles};
use longspan_stream::{Domain, Poll, Reader, Scene, Source};
use macroquad::models::{Mesh, Vertex};
use macroquad::prelude::*;

use crate::parts::{Layers, broken_at, loaded_bounds, of_scene, place, reach};
use crate::pick::Ray;
use crate::{Options, Outcome};

/// Segments around what is round; a window has less time for a picture than a file.
const SEGMENTS: u32 = 12;

/// Vertices and indices of one call to the graphics driver. macroquad cuts off what is more.
const CALL_VERTICES: usize = 30_000;
const CALL_INDICES: usize = 60_000;

/// When a picture is taken that was asked for on the command line (s), unless its step was said.
const SHOT_AFTER: f32 = 2.0;

/// Field of view from top to bottom (rad), and how much farther away the eye is than it must be for everything to fit.
const FIELD: f32 = 0.7;
const MARGIN: f32 = 1.15;

/// How far the pointer may go while the button is down for it to be a click (pixels).
const CLICK: f32 = 3.0;

/// Height of the bar of a recording (pixels).
const BAR: f32 = 24.0;

/// How long the eye takes for two thirds of the way to where everything fits (s).
const FOLLOWS_IN: f32 = 0.15;

/// Most frames of a recording that are played for one picture.
const MAX_FRAMES: u32 = 16;

/// Steps for which the place of a break is shown.
const BREAKS_SEEN: u64 = 60;

/// How often the window looks which streams there are (s).
const LIST_EVERY: f32 = 1.0;

const SKY: Color = Color::new(0.80, 0.87, 0.94, 1.0);
/// What the left button does while it is held.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drag {
    Nothing,
    Turns,
    Scrubs,
}

/// A picture that was asked for on the command line.
struct Shot {
    file: String,
    /// Of the first frame of this step or a later one, or else after a while.
    step: Option<u64>,
}

/// A camera that sees through what is nearer.
struct Through(Camera3D);

impl Camera for Through {
    fn matrix(&self) -> Mat4 {
        self.0.matrix()
    }

    fn depth_enabled(&self) -> bool {
        false
    }

    fn render_pass(&self) -> Option<RenderPass> {
        self.0.render_pass()
    }

    fn viewport(&self) -> Option<(i32, i32, i32, i32)> {
        self.0.viewport()
    }
}

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
    drag: Drag,
    wants_picture: bool,
    mouse: (f32, f32),
    /// Where the left button was pressed.
    pressed: (f32, f32),
    /// Which of the moving bodies is to be selected at the start.
    select_first: Option<usize>,
    /// Time of a recording that is due to be played (s).
    playing: f64,
    /// Where joints broke in the last steps, and in which.
    breaks: VecDeque<(u64, [f64; 3])>,
    broken: usize,
    /// All streams, and when they were looked for.
    sources: Vec<Source>,
    listed: Option<Instant>,
    problem: String,
    status: String,
}

/// Opens a window on a reader, until it is closed.
pub fn open(reader: Reader, domain: &Domain, options: &Options) -> Outcome<()> {
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
        distance: 0.0,
        framed: false,
        drag: Drag::Nothing,
        wants_picture: false,
        mouse: (0.0, 0.0),
        pressed: (0.0, 0.0),
        select_first: options.select,
        playing: 0.0,
        breaks: VecDeque::new(),
        broken: 0,
        sources: Vec::new(),
        listed: None,
        problem: String::new(),
        status: String::new(),
    };
    let shot = options.shot.clone().map(|file| Shot { file, step: options.step });
    macroquad::Window::from_config(conf, run(view, shot));
    Ok(())
}

async fn run(mut view: View, shot: Option<Shot>) {
    let start = Instant::now();
    println!("a window is open");
    loop {
        view.advance();
        view.list_sources();
        view.turn();
        view.keys();
        clear_background(SKY);
        let mut parts = of_scene(view.reader.scene(), view.layers);
        let size = reach(&parts);
        parts.extend(view.breaks.iter().map(|&(_, at)| (0, broken_at(at, size))));
        view.frame();
        view.draw(&parts, &loaded_bounds(view.reader.scene(), view.layers, size));
        view.write();
        let scene = view.reader.scene();
        if std::mem::take(&mut view.wants_picture) {
            save(&format!("longspan-{}.png", scene.frame().step), scene);
        }
        if let Some(Shot { file, step }) = &shot {
            let due = match step {
                Some(step) => scene.is_complete() && scene.frame().step >= *step,
                None => start.elapsed().as_secs_f32() > SHOT_AFTER,
            };
            if due {
                return save(file, scene);
            }
        }
        if is_key_down(KeyCode::Escape) {
            return;
        }
        next_frame().await;
    }
}

/// Saves what has been drawn of a frame.
fn save(file: &str, scene: &Scene) {
    // Changing the camera is what makes macroquad draw what it has collected; after the frame the buffer means nothing any more.
    set_default_camera();
    get_screen_data().export_png(file);
    println!("step {} with hash {:016x}: {file}", scene.frame().step, scene.hash());
}

impl View {
    /// Takes in what is live, or plays as much of a recording as the time since the last picture is worth.
    fn advance(&mut self) {
        if self.paused {
            return;
        }
        self.problem.clear();
        if self.reader.recording().is_none() {
            let poll = self.reader.poll();
            return self.note(poll);
        }
        // A computer that is too slow for that plays slowly; it does not leap.
        self.playing += f64::from(get_frame_time()).min(0.25);
        for _ in 0..MAX_FRAMES {
            let before = self.reader.scene().frame().time;
            if self.playing <= 0.0 {
                return;
            }
            let poll = self.reader.poll_next();
            let over = !matches!(poll, Ok(Poll::Frame { .. }));
            self.note(poll);
            if over {
                self.playing = 0.0;
                return;
            }
            self.playing -= (self.reader.scene().frame().time - before).max(0.0);
        }
        self.playing = 0.0;
    }

    fn note(&mut self, poll: longspan_stream::Result<Poll>) {
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
        self.note_events();
    }

    /// Keeps places of breaks for a while, and forgets what a recording or another stream that begins anew had told.
    fn note_events(&mut self) {
        let scene = self.reader.scene();
        let now = scene.frame().step;
        self.broken += scene.breaks().len();
        self.breaks.extend(scene.breaks().iter().map(|joint| (joint.step, joint.point)));
        self.breaks.retain(|&(step, _)| step <= now && now - step < BREAKS_SEEN);
        if let Some(number) = self.select_first.take_if(|_| scene.is_complete()) {
            self.selected = scene.bodies().filter(|body| body.kind != 0).nth(number).map(|body| body.body);
        }
        self.reader.forget_events();
    }

    fn list_sources(&mut self) {
        if self.reader.recording().is_none() && self.listed.is_none_or(|listed| listed.elapsed().as_secs_f32() > LIST_EVERY) {
            self.listed = Some(Instant::now());
            self.sources = self.domain.sources().unwrap_or_default();
        }
    }

    /// Mouse: turns with the left button, selects with a click, comes nearer with the wheel; scrubs in the bar at the bottom.
    fn turn(&mut self) {
        let (x, y) = mouse_position();
        let (dx, dy) = (x - self.mouse.0, y - self.mouse.1);
        if is_mouse_button_pressed(MouseButton::Left) {
            let in_bar = y > screen_height() - BAR && self.reader.recording().is_some();
            self.drag = if in_bar { Drag::Scrubs } else { Drag::Nothing };
            self.pressed = (x, y);
        } else if is_mouse_button_down(MouseButton::Left) && self.drag == Drag::Nothing {
            // A hand that clicks is not quite still.
            if (x - self.pressed.0).hypot(y - self.pressed.1) > CLICK {
                (self.drag, self.framed) = (Drag::Turns, true);
            }
        } else if self.drag == Drag::Turns {
            self.yaw -= 0.006 * dx;
            self.pitch = (self.pitch + 0.006 * dy).clamp(-1.5, 1.5);
        }
        if self.drag == Drag::Scrubs {
            self.scrub(x / screen_width());
        }
        if is_mouse_button_released(MouseButton::Left) {
            match std::mem::replace(&mut self.drag, Drag::Nothing) {
                Drag::Nothing => self.select(x, y),
                Drag::Turns => println!("turned to {:.2} {:.2}", self.yaw, self.pitch),
                Drag::Scrubs => println!("at step {}", self.reader.scene().frame().step),
            }
        }
        let wheel = mouse_wheel().1;
        if wheel != 0.0 {
            self.framed = true;
            self.distance *= (1.0 - 0.1 * wheel.clamp(-3.0, 3.0)).max(0.2);
            println!("distance {:.2} m", self.distance);
        }
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
            println!("{} at step {here}", if self.paused { "paused" } else { "goes on" });
        }
        if self.reader.recording().is_some() {
            let to = [(KeyCode::Right, here + 1), (KeyCode::Left, here.saturating_sub(1))];
            if let Some((_, step)) = to.into_iter().find(|(key, _)| is_key_pressed(*key)) {
                self.seek(step);
                println!("at step {}", self.reader.scene().frame().step);
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
                println!("{key:?} {}", if *layer { "on" } else { "off" });
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
        let next = next.and_then(|source| Some((source, Reader::attach(&self.domain, &source.name).ok()?)));
        if let Some((source, reader)) = next {
            println!("watches {}", source.name);
            self.reader = reader;
            (self.selected, self.paused, self.framed, self.distance) = (None, false, false, 0.0);
            (self.broken, self.breaks) = (0, VecDeque::new());
        }
    }

    /// Goes where everything that can move fits the window, and along with it, until somebody turns or comes nearer.
    fn frame(&mut self) {
        if self.framed {
            return;
        }
        let scene = self.reader.scene();
        let mut boxed = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for shape in scene.shapes() {
            let Some(body) = scene.body(shape.body).filter(|body| body.kind != 0) else { continue };
            let (at, half) = place(body, shape);
            boxed = (boxed.0.min(at - half.as_dvec3()), boxed.1.max(at + half.as_dvec3()));
        }
        if boxed.0.is_finite() {
            let (center, half) = (0.5 * (boxed.0 + boxed.1), (0.5 * (boxed.1 - boxed.0)).as_vec3());
            let distance = MARGIN * self.distance_for(half);
            let share = if self.distance == 0.0 { 1.0 } else { 1.0 - (-get_frame_time() / FOLLOWS_IN).exp() };
            self.center = self.center.lerp(center, share.into());
            self.distance += share * (distance - self.distance);
        }
    }

    /// How far away the eye must be for a box about the centre, of these half extents, to fit the window.
    fn distance_for(&self, half: Direction) -> f32 {
        let (sin, cos) = self.yaw.sin_cos();
        let back = Direction::new(self.pitch.cos() * sin, self.pitch.sin(), self.pitch.cos() * cos);
        let right = Direction::new(cos, 0.0, -sin);
        let high = (0.5 * FIELD).tan();
        let wide = high * screen_width() / screen_height();
        let corners = (0..8).map(|corner| {
            let sign = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            half * Direction::new(sign(0), sign(1), sign(2))
        });
        let needed = |corner: Direction| {
            let beside = (corner.dot(right).abs() / wide).max(corner.dot(back.cross(right)).abs() / high);
            beside + corner.dot(back)
        };
        corners.map(needed).fold(0.0, f32::max)
    }

    fn eye(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        self.distance * vec3(cos * self.yaw.sin(), sin, cos * self.yaw.cos())
    }

    fn camera(&self) -> Camera3D {
        Camera3D { position: self.eye(), target: Vec3::ZERO, up: Vec3::Y, fovy: FIELD, ..Default::default() }
    }

    /// Bodies and what is in front of them, then what is seen through them.
    fn draw(&self, parts: &[(u64, Drawn)], through: &[(u64, Drawn)]) {
        set_camera(&self.camera());
        self.draw_parts(parts);
        set_camera(&Through(self.camera()));
        self.draw_parts(through);
        set_default_camera();
    }

    fn draw_parts(&self, parts: &[(u64, Drawn)]) {
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
                let shade = if chosen { Direction::splat(0.6 + 0.4 * lit) } else { shade };
                let color = Color::new(shade.x, shade.y, shade.z, 1.0);
                let first = mesh.vertices.len() as u16;
                mesh.vertices.extend(corners.map(|at| Vertex::new(at.x, at.y, at.z, 0.0, 0.0, color)));
                mesh.indices.extend([first, first + 1, first + 2]);
                if mesh.vertices.len() + 6 > CALL_VERTICES {
                    draw_mesh(&mesh);
                    mesh.vertices.clear();
                    mesh.indices.clear();
                }
            }
        }
        draw_mesh(&mesh);
    }

    /// Selects the body under a point of the window, or none.
    fn select(&mut self, x: f32, y: f32) {
        let back = self.camera().matrix().inverse();
        let at = |depth: f32| back.project_point3(vec3(2.0 * x / screen_width() - 1.0, 1.0 - 2.0 * y / screen_height(), depth));
        let (eye, along) = (self.eye(), (at(0.9) - self.eye()).normalize());
        let ray = Ray { center: self.center, eye: eye.to_array().into(), along: along.to_array().into() };
        let scene = self.reader.scene();
        let only_bodies = Layers { support: false, unions: false, bounds: false, joints: false, contacts: false, planes: false };
        let parts = of_scene(scene, only_bodies);
        let moves = |body: u64| scene.body(body).is_some_and(|body| body.kind != 0);
        self.selected = ray.body(parts.iter().filter(|(body, _)| moves(*body)));
        match self.selected {
            Some(body) => println!("selected body {body:#x}"),
            None => println!("selected nothing"),
        }
    }
}
