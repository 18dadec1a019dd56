//! The viewer beside a host in C: each scene of the paper watched live in a window, recorded, and played.
//!
//! The scenes are those of the library of scenes. Each goes to the host as a snapshot; `examples_c/saved.c` takes it up, steps it and
//! publishes it.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use longspan_scenes::{LongspanEngine, build};

use crate::compiler::{Language, compile};
use crate::display::{Display, Running};
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository, succeed};

/// A figure of the paper as a scene, and what is to be seen of it.
struct Figure {
    name: &'static str,
    what: &'static str,
    scene: &'static str,
    keys: &'static [(&'static str, &'static str)],
    /// The frame that is to be seen (a step of the world, of which the snapshot has had some).
    step: u32,
    /// How much slower than it is.
    slower: u32,
    /// The moving body that is selected in the window.
    selected: u32,
}

/// Length of what a snapshot is taken of (s): three steps, so that there are contacts, loads and verdicts.
const BEGUN: (&str, &str) = ("seconds", "0.05");

const FIGURES: [Figure; 11] = [
    figure("fig1", "two cars pull the third up", "cable_car", &[("cars", "3"), BEGUN], 120, 1, 101),
    figure("fig4", "a track, which is no chain that hangs from something", "track", &[BEGUN], 200, 1, 0),
    // Its own length; one step later what is not supported is on its way.
    figure("fig11-12", "supporting contacts and supported bodies", "support_gallery", &[], 6, 8, 4),
    figure("fig9-13", "a loop of hinges with an offset, struck sideways", "hinge_loop", &[BEGUN], 40, 2, 50),
    figure("fig14", "ten tonnes on a chain", "hanging_chain", &[("solver", "gs"), BEGUN], 120, 1, 30),
    figure("fig15", "the rope bridge of 1132 joints", "rope_bridge", &[("solver", "gs"), BEGUN], 60, 1, 60),
    figure("fig16-bent", "the crossbow as it is modelled", "crossbow", &[("solver", "gs"), ("seconds", "0.02")], 3, 8, 2),
    figure("fig16", "the crossbow a quarter of a second later", "crossbow", &[("solver", "gs"), ("seconds", "0.02")], 15, 8, 2),
    figure("fig17", "the vase in one piece", "vase", &[BEGUN], 60, 2, 30),
    figure("fig17-broken", "the vase that breaks", "vase", &[("break", "2e5"), BEGUN], 60, 2, 30),
    // The ball comes after 0.1 s.
    figure("fig18", "the tower", "tower", &[("stand", "0.1"), ("support", "on"), ("seconds", "0.12")], 32, 8, 900),
];

const fn figure(
    name: &'static str,
    what: &'static str,
    scene: &'static str,
    keys: &'static [(&'static str, &'static str)],
    step: u32,
    slower: u32,
    selected: u32,
) -> Figure {
    Figure { name, what, scene, keys, step, slower, selected }
}

/// How long a host goes on after the frame that is looked at (s).
const AFTERWARDS: f64 = 0.5;

/// Least part of a picture that is neither of its three commonest colours: sky, ground and paper.
const MIN_SEEN: f64 = 0.004;

/// Fewest colours of a picture with bodies in the light.
const FEWEST_COLORS: usize = 12;

/// `to` is where pictures go; those of the window are NAME.png, those without one NAME-still.png. With `only`, the others are left out.
pub fn run(to: Option<&str>, only: Option<&str>) -> Outcome<()> {
    let stage = Stage::set(to)?;
    let chosen = FIGURES.iter().filter(|figure| only.is_none_or(|only| figure.name == only));
    let mut shown = 0;
    for figure in chosen {
        stage.show(figure).map_err(|problem| format!("{}: {problem}", figure.name))?;
        shown += 1;
    }
    if only.is_none() {
        sheet(&FIGURES.map(|figure| stage.pictures.join(format!("{}.png", figure.name))), &stage.pictures.join("sheet.png"))?;
    }
    if shown == 0 {
        let names: Vec<&str> = FIGURES.iter().map(|figure| figure.name).collect();
        return Err(format!("no figure is called so; the figures are: {}", names.join(", ")).into());
    }
    println!("{shown} scenes live from a host in C, each frame the same when played");
    Ok(())
}

/// What all figures share.
struct Stage {
    display: Display,
    viewer: PathBuf,
    host: PathBuf,
    folder: PathBuf,
    pictures: PathBuf,
}

impl Stage {
    fn set(to: Option<&str>) -> Outcome<Self> {
        let folder = output_folder("viewer")?;
        let pictures = to.map_or_else(|| folder.clone(), PathBuf::from);
        std::fs::create_dir_all(&pictures)?;
        Ok(Self { display: Display::open()?, viewer: viewer()?, host: host(&folder)?, folder, pictures })
    }

    /// Shows a figure in a window while it runs, records it, and compares what is played with what was seen.
    fn show(&self, figure: &Figure) -> Outcome<()> {
        let name = figure.name;
        let file = |end: &str| self.folder.join(format!("{name}{end}"));
        let picture = |end: &str| self.pictures.join(format!("{name}{end}"));
        let (saved, recording) = (file(".snapshot"), file(".lsr"));
        let (window, still) = (picture(".png"), picture("-still.png"));
        save(figure.scene, figure.keys, &saved)?;

        let mut record = Command::new(&self.viewer);
        let recorder = record.args(["record", name]).arg(&recording).arg("1000").stdout(Stdio::piped()).spawn()?;
        let mut watch = Command::new(&self.viewer);
        watch.args(["watch", name, "--step", &figure.step.to_string(), "--select", &figure.selected.to_string(), "--shot"]);
        let shown = self.display.start(watch.arg(&window))?;
        shown.says("a window is open")?;

        let seconds = f64::from(figure.step) / 60.0 + AFTERWARDS;
        let mut host = Command::new(&self.host);
        host.arg(&saved).arg(seconds.to_string()).env("LONGSPAN_STREAM", name);
        let host = Running::start(host.env("LONGSPAN_STREAM_SLOWER", figure.slower.to_string()).stdout(Stdio::null()))?;
        let seen = shown.says("step ")?;
        shown.finish()?;
        host.finish()?;
        let recorded = String::from_utf8(recorder.wait_with_output()?.stdout)?;

        let (step, hash) = step_and_hash(&seen).ok_or("the window does not say what it has shown")?;
        let played = printed(Command::new(&self.viewer).arg("picture").arg(&recording).arg(&still).args(["--step", step]))?;
        if step_and_hash(played.trim().strip_prefix("step ").unwrap_or_default()) != Some((step, hash)) {
            return Err(format!("step {step} with hash {hash} was seen, and played: {played}").into());
        }
        let all = printed(Command::new(&self.viewer).arg("frames").arg(&recording))?;
        if all_frames(&recorded).is_none() || all_frames(&recorded) != all_frames(&all) {
            return Err(format!("recorded: {recorded}played: {all}").into());
        }
        println!("{name}: {}; step {step} with hash {hash} live and played; {}", figure.what, recorded.trim());
        look(&window)?;
        look(&still)
    }
}

/// Writes a scene of the library as a snapshot.
pub fn save(scene: &str, keys: &[(&str, &str)], file: &Path) -> Outcome<()> {
    let keys: Vec<(String, String)> = keys.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    Ok(std::fs::write(file, LongspanEngine::snapshot(build(scene, &keys)?)?)?)
}

/// `examples_c/saved.c`, with a library that has streams.
pub fn host(folder: &Path) -> Outcome<PathBuf> {
    let library = Library::build_with_streams()?;
    let program = folder.join("saved");
    compile(&repository().join("examples_c/saved.c"), &program, Language::C99, &library)?;
    Ok(program)
}

/// Of "STEP with hash HASH: FILE".
fn step_and_hash(said: &str) -> Option<(&str, &str)> {
    let (step, rest) = said.split_once(" with hash ")?;
    Some((step, rest.split_once(':')?.0))
}

/// Of "COUNT frames …, what they show has hash HASH".
fn all_frames(said: &str) -> Option<(&str, &str)> {
    let (count, rest) = said.split_once(" frames ")?;
    Some((count, rest.split_once("has hash ")?.1.trim()))
}

/// The viewer, built in its own workspace, or the one that `LONGSPAN_VIEWER` names.
pub fn viewer() -> Outcome<PathBuf> {
    if let Some(viewer) = std::env::var_os("LONGSPAN_VIEWER") {
        return Ok(viewer.into());
    }
    let folder = repository().join("viewer");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    succeed(cargo.current_dir(&folder).args(["build", "--release"]))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| folder.join("target"), PathBuf::from);
    Ok(target.join("release/longspan-viewer"))
}

/// A picture as rows of red, green and blue.
struct Pixels {
    width: usize,
    height: usize,
    bytes: Vec<[u8; 3]>,
}

fn read(picture: &Path) -> Outcome<Pixels> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(picture)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut bytes)?;
    let pixels = bytes[..info.buffer_size()].chunks_exact(info.color_type.samples());
    let bytes = pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Pixels { width: info.width as usize, height: info.height as usize, bytes })
}

/// All pictures on one, three to a row, each a third as wide as it is.
fn sheet(pictures: &[PathBuf], to: &Path) -> Outcome<()> {
    const ACROSS: usize = 3;
    let pictures = pictures.iter().map(|picture| read(picture)).collect::<Outcome<Vec<Pixels>>>()?;
    let Some(&Pixels { width, height, .. }) = pictures.first() else { return Ok(()) };
    let (small, low) = (width / ACROSS, height / ACROSS);
    let size = (ACROSS * small, pictures.len().div_ceil(ACROSS) * low);
    let mut sheet = vec![[255; 3]; size.0 * size.1];
    for (number, picture) in pictures.iter().enumerate() {
        for (x, y) in (0..low).flat_map(|y| (0..small).map(move |x| (x, y))) {
            let of_block = (0..ACROSS * ACROSS).map(|at| (ACROSS * y + at / ACROSS) * picture.width + ACROSS * x + at % ACROSS);
            let sum = of_block.fold([0_usize; 3], |sum, at| [0, 1, 2].map(|c| sum[c] + usize::from(picture.bytes[at][c])));
            let place = (number / ACROSS * low + y) * size.0 + number % ACROSS * small + x;
            sheet[place] = sum.map(|channel| (channel / (ACROSS * ACROSS)) as u8);
        }
    }
    let mut encoder = png::Encoder::new(File::create(to)?, size.0 as u32, size.1 as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(sheet.as_flattened())?;
    Ok(())
}

/// Whether a picture shows bodies, and not just what is behind them.
fn look(picture: &Path) -> Outcome<()> {
    let Pixels { width, height, bytes } = read(picture)?;
    let mut colors: HashMap<[u8; 3], usize> = HashMap::new();
    for pixel in bytes {
        *colors.entry(pixel).or_default() += 1;
    }
    let mut counts: Vec<usize> = colors.values().copied().collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let seen = counts.iter().skip(3).sum::<usize>() as f64 / (width * height) as f64;
    println!("{}: {} colours, {:.1} % of the picture is something", picture.display(), counts.len(), 100.0 * seen);
    if counts.len() < FEWEST_COLORS || seen < MIN_SEEN {
        return Err(format!("{}: there is nothing to be seen", picture.display()).into());
    }
    Ok(())
}
