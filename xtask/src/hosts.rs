//! The hosts with a window, built, run under a virtual display, and their pictures looked at.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::compiler::Language;
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository, succeed};

/// A colour that must be seen: its name, its red, green and blue at full light, and the least share of all pixels.
type Seen = (&'static str, [f32; 3], f32);

const GAME: [Seen; 7] = [
    ("ground", [0.36, 0.42, 0.34], 0.05),
    ("bridge", [0.60, 0.36, 0.14], 0.002),
    ("crane", [0.95, 0.78, 0.10], 0.002),
    ("rope", [0.15, 0.15, 0.18], 0.0003),
    ("ball", [0.20, 0.30, 0.85], 0.0005),
    ("tower", [0.55, 0.25, 0.65], 0.002),
    ("wall", [0.85, 0.20, 0.16], 0.002),
];

const IRRLICHT: [Seen; 9] = [
    ("ground", [90.0, 110.0, 85.0], 0.05),
    ("bridge", [170.0, 100.0, 40.0], 0.002),
    ("crane", [240.0, 200.0, 30.0], 0.002),
    ("rope", [40.0, 40.0, 45.0], 0.0003),
    ("ball", [50.0, 80.0, 220.0], 0.0005),
    ("tower", [150.0, 70.0, 170.0], 0.002),
    ("wall", [215.0, 60.0, 45.0], 0.0003),
    ("bricks of broken mortar", [250.0, 150.0, 60.0], 0.001),
    ("cart", [40.0, 190.0, 190.0], 0.001),
];

/// Greatest distance of two colours, each scaled to length one, for them to be the same in another light.
const SAME_COLOR: f32 = 0.06;

pub fn run() -> Outcome<()> {
    let library = Library::build()?;
    let folder = output_folder("hosts")?;
    let hosts = repository().join("examples_c/hosts");

    let mut game = Language::C99.compiler()?;
    game.args(["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O2"]);
    for name in ["main", "scene", "hand", "view"] {
        game.arg(hosts.join(format!("game/{name}.c")));
    }
    build(&mut game, &library, &["-lSDL2", "-lGL"], &folder.join("game"))?;
    let output = show(Command::new(folder.join("game")).arg("--picture"), &folder.join("game.ppm"))?;
    expect(number(&output, "bridge: lowest plank at ")? > 1.5, "the bridge hangs", &output)?;
    expect((number(&output, "crane: three tonnes are ")? - 5.2).abs() < 0.02, "the rope has its length", &output)?;
    expect(number(&output, "wall: ")? >= 5.0, "the wall is broken", &output)?;
    expect(output.contains("grabbed: 1"), "the mouse has found something", &output)?;
    look(&folder.join("game.ppm"), &GAME)?;

    let mut engine = Language::Cpp11.compiler()?;
    engine.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-O2"]);
    engine.arg(hosts.join("irrlicht/main.cpp"));
    build(&mut engine, &library, &["-lIrrlicht"], &folder.join("irrlicht"))?;
    let output = show(&mut Command::new(folder.join("irrlicht")), &folder.join("irrlicht.ppm"))?;
    expect(number(&output, "bridge: lowest plank at ")? > 1.5, "the bridge hangs", &output)?;
    expect((number(&output, "crane: the ball is ")? - 4.5).abs() < 0.02, "the rope has its length", &output)?;
    expect((number(&output, "tower: its top is at ")? - 3.8).abs() < 0.02, "the tower stands", &output)?;
    expect(number(&output, "wall: ")? >= 5.0, "the wall is broken", &output)?;
    expect(output.contains("picked: 1"), "the engine's pixel has found something", &output)?;
    expect(number(&output, "hand: holds a block at ")? > 5.0, "the hand holds it up", &output)?;
    expect(number(&output, "has pushed it from -7 to ")? > -4.0, "the cart has pushed the parcel", &output)?;
    look(&folder.join("irrlicht.ppm"), &IRRLICHT)
}

fn build(compiler: &mut Command, library: &Library, libraries: &[&str], program: &Path) -> Outcome<()> {
    compiler.arg("-I").arg(repository().join("include")).arg(library.archive()).args(libraries);
    succeed(compiler.args(["-lm", "-lpthread", "-ldl", "-o"]).arg(program))
}

/// Runs a host under a virtual display; it saves a picture.
fn show(host: &mut Command, picture: &Path) -> Outcome<String> {
    if picture.exists() {
        fs::remove_file(picture)?;
    }
    let mut command = Command::new("xvfb-run");
    command.args(["--auto-servernum", "--server-args", "-screen 0 1280x800x24"]).arg(host.get_program());
    let output = printed(command.args(host.get_args()).arg(picture))?;
    print!("{output}");
    Ok(output)
}

fn expect(holds: bool, what: &str, output: &str) -> Outcome<()> {
    if holds { Ok(()) } else { Err(format!("not so: {what}\n{output}").into()) }
}

/// The number after some words.
fn number(output: &str, words: &str) -> Outcome<f64> {
    let rest = output.split_once(words).ok_or_else(|| format!("`{words}` is not there\n{output}"))?.1;
    Ok(rest.split_whitespace().next().unwrap_or_default().parse()?)
}

/// Looks for colours in a picture.
fn look(picture: &Path, colors: &[Seen]) -> Outcome<()> {
    let bytes = fs::read(picture)?;
    let pixels = pixels_of(&bytes).ok_or("the picture is not a PPM")?;
    for (name, color, least) in colors {
        let wanted = scaled(*color);
        let is_same = |pixel: &&[u8]| {
            let seen = scaled([f32::from(pixel[0]), f32::from(pixel[1]), f32::from(pixel[2])]);
            wanted.iter().zip(seen).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt() < SAME_COLOR
        };
        let share = pixels.chunks_exact(3).filter(is_same).count() as f32 / (pixels.len() / 3) as f32;
        println!("{}: {name} takes {:.2} % of the picture", picture.display(), share * 100.0);
        if share < *least {
            return Err(format!("{}: no {name} to be seen ({share})", picture.display()).into());
        }
    }
    Ok(())
}

fn scaled(color: [f32; 3]) -> [f32; 3] {
    let length = color.iter().map(|channel| channel * channel).sum::<f32>().sqrt();
    if length > 0.0 { color.map(|channel| channel / length) } else { color }
}

/// Pixels of a binary PPM of 8 bits a channel.
fn pixels_of(bytes: &[u8]) -> Option<&[u8]> {
    let header: Vec<&[u8]> = bytes.splitn(4, |&byte| byte == b'\n').collect();
    let [b"P6", size, b"255", pixels] = header[..] else { return None };
    let size = std::str::from_utf8(size).ok()?;
    let (width, height) = size.split_once(' ')?;
    let count = width.parse::<usize>().ok()? * height.parse::<usize>().ok()? * 3;
    pixels.get(..count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_read_and_a_color_known_in_any_light() {
        assert_eq!(pixels_of(b"P6\n2 1\n255\nabcdef"), Some(&b"abcdef"[..]));
        assert_eq!(pixels_of(b"P6\n2 1\n255\nabcde"), None);
        let [bright, dark] = [scaled([0.85, 0.20, 0.16]), scaled([0.425, 0.1, 0.08])];
        assert!(bright.iter().zip(dark).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}
