//! Pictures and turntables, without a window.

use std::fs::File;
use std::path::Path;

use longspan::Pose;
use longspan::glam::{DVec3, Quat};
use longspan_scenes::picture::{Drawn, draw, write_png};
use longspan_stream::Reader;

use crate::Outcome;
use crate::parts::{Layers, of_scene};

/// Pictures of a turntable, and how long each is seen (in hundredths of a second).
const TURNS: u32 = 36;
const DELAY: u16 = 8;

fn parts(reader: &Reader) -> Vec<Drawn> {
    of_scene(reader.scene(), Layers::ALL).into_iter().map(|(_, part)| part).collect()
}

/// Writes what a reader shows as PNG.
pub fn picture(reader: &Reader, to: &Path, (width, height): (usize, usize)) -> Outcome<()> {
    write_png(to, &draw(&parts(reader), width, height))?;
    let scene = reader.scene();
    println!("step {} with hash {:016x}: {}", scene.frame().step, scene.hash(), to.display());
    Ok(())
}

/// Writes what a reader shows from all around as an animated GIF.
pub fn turntable(reader: &Reader, to: &Path, (width, height): (usize, usize)) -> Outcome<()> {
    let parts = parts(reader);
    let mut encoder = gif::Encoder::new(File::create(to)?, u16::try_from(width)?, u16::try_from(height)?, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for turn in 0..TURNS {
        let angle = std::f32::consts::TAU * turn as f32 / TURNS as f32;
        let turned = Pose { position: DVec3::ZERO, rotation: Quat::from_rotation_y(angle) };
        let around: Vec<Drawn> = parts.iter().map(|part| Drawn { pose: turned.transform(&part.pose), ..part.clone() }).collect();
        let image = draw(&around, width, height);
        let mut frame = gif::Frame::from_rgb_speed(image.width as u16, image.height as u16, &image.rgb, 20);
        frame.delay = DELAY;
        encoder.write_frame(&frame)?;
    }
    println!("{TURNS} pictures: {}", to.display());
    Ok(())
}
