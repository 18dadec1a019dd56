//! What the window says in words: of the frame, of what is selected, of loads, bounds and streams, and what the keys do.

use longspan::glam::Vec3 as Direction;
use longspan_stream::schema::{LS_STREAM_BODY_ASLEEP, LS_STREAM_BODY_SUPPORT_KNOWN, LS_STREAM_BODY_SUPPORTED};
use macroquad::prelude::*;

use super::{BAR, View};

/// What `LsStreamBody.support` means, by its number.
const VERDICTS: [&str; 11] = [
    "supported",
    "held by joints",
    "ground",
    "touches nothing",
    "slides",
    "rests on what is not supported",
    "outside the hull of its contacts",
    "hangs loose",
    "moving",
    "no gravity",
    "braced",
];

/// Height of letters (pixels): the one that macroquad's own font was drawn for, others lose strokes.
const FONT: u16 = 16;

/// What the keys do.
const KEYS: &str = "space pause  arrows step  tab next stream  S support  U unions  B bounds  J joints  C contacts  P planes  F frame  F12 picture";

const PAPER: Color = Color::new(1.0, 1.0, 1.0, 0.75);
const TEXT: Color = Color::new(0.08, 0.09, 0.10, 1.0);

impl View {
    /// Writes it over what has been drawn, with the bar of a recording.
    pub(super) fn write(&self) {
        let scene = self.reader.scene();
        let frame = scene.frame();
        let counts = format!("{} bodies  {} joints", scene.bodies().len(), scene.joints().len());
        let mut lines = vec![format!("step {}  {:.2} s  {counts}  hash {:016x}", frame.step, frame.time, frame.state_hash)];
        let said = [self.status.as_str(), self.problem.as_str(), if self.paused { "paused" } else { "" }];
        lines.extend(said.into_iter().filter(|line| !line.is_empty()).map(str::to_owned));
        if let Some(body) = self.selected.and_then(|body| scene.body(body)) {
            let [x, y, z] = body.position;
            let speed = Direction::from_array(body.linear_velocity).length();
            let turn = Direction::from_array(body.angular_velocity).length();
            let known = body.flags & LS_STREAM_BODY_SUPPORT_KNOWN != 0;
            // Flags come with every frame, the verdict within a second.
            let verdict = match (body.flags & LS_STREAM_BODY_SUPPORTED != 0, body.support) {
                (false, 0..=2) => "not supported any more",
                (true, 3..) => "supported again",
                (_, verdict) => VERDICTS.get(verdict as usize).unwrap_or(&"judged in a way that is not known here"),
            };
            let support = match known {
                // A load that is nothing may have a sign.
                true => format!("{verdict}  margin {:.4} m  load {:.1} N", body.support_margin, body.support_load.max(0.0)),
                false => "support not judged".to_owned(),
            };
            let sleep = if body.flags & LS_STREAM_BODY_ASLEEP != 0 { "asleep" } else { "awake" };
            let union = match scene.bodies().filter(|other| body.union_id != 0 && other.union_id == body.union_id).count() {
                0 => "in no union".to_owned(),
                members => format!("in a union of {members}"),
            };
            lines.extend([
                format!("body {:#x}  word {}  {union}", body.body, body.user_word),
                format!("at {x:.4} {y:.4} {z:.4} m  {speed:.3} m/s  {turn:.3} rad/s  {:.3} kg", body.mass),
                format!("{support}  {sleep}"),
            ]);
        }
        let worst = scene.joint_loads().iter().max_by(|a, b| a.share.total_cmp(&b.share).then(a.force.total_cmp(&b.force)));
        if let Some(load) = worst {
            let limits = scene.joint(load.joint).map_or([0.0; 2], |joint| [joint.break_force, joint.break_torque]);
            let of_limit = if load.share > 0.0 || limits != [0.0; 2] {
                format!("{:.0} % of its limit", 100.0 * load.share)
            } else {
                "no limit".to_owned()
            };
            lines.push(format!("worst joint {:#x}: {:.1} N, {:.1} N m, {of_limit}", load.joint, load.force, load.torque));
        }
        if self.broken > 0 {
            lines.push(format!("{} joints broke so far", self.broken));
        }
        if let Some(bound) = scene.bounds().iter().max_by(|a, b| a.tension.abs().total_cmp(&b.tension.abs())) {
            lines.push(format!("{} bounds, the greatest tension {:.1} N", scene.bounds().len(), bound.tension + 0.0));
        }
        for plane in scene.planes() {
            let [x, y, z] = plane.normal;
            lines.push(format!("plane of a chain of hinges, normal {x:.3} {y:.3} {z:.3}, {:.2} m around", plane.radius));
        }
        for source in &self.sources {
            let here = if self.reader.source() == Some(source) { "> " } else { "  " };
            let place = if source.is_here() { "" } else { " on another machine" };
            lines.push(format!("{here}{} of process {}{place}", source.name, source.process));
        }
        let width = lines.iter().map(|line| measure_text(line, None, FONT, 1.0).width).fold(0.0, f32::max);
        draw_rectangle(0.0, 0.0, width + 20.0, 18.0 * lines.len() as f32 + 10.0, PAPER);
        for (number, line) in lines.iter().enumerate() {
            draw_text(line, 10.0, 20.0 + 18.0 * number as f32, FONT.into(), TEXT);
        }
        draw_text(KEYS, 10.0, screen_height() - BAR - 8.0, FONT.into(), TEXT);
        if let Some((first, last)) = self.reader.recording().and_then(|recording| recording.steps) {
            let share = (frame.step.saturating_sub(first)) as f32 / (last - first).max(1) as f32;
            let (width, height) = (screen_width(), screen_height());
            draw_rectangle(0.0, height - BAR, width, BAR, Color::new(0.6, 0.65, 0.7, 1.0));
            draw_rectangle(0.0, height - BAR, width * share, BAR, Color::new(0.25, 0.45, 0.7, 1.0));
        }
    }
}
