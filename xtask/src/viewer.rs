//! The viewer beside hosts in C: each scene of the paper that there is a sample of, watched live in a window, recorded, and played.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::compiler::{Language, compile};
use crate::library::{Library, output_folder};
use crate::{Outcome, printed, repository, succeed};

/// Samples, how long each is watched until its picture is taken (s), and the moving body that is selected in it.
const SCENES: [(&str, f32, usize); 7] = [
    ("chain", 3.0, 30),
    ("bridge", 3.0, 10),
    ("track", 3.0, 5),
    ("vase", 1.5, 3),
    ("tower", 2.2, 40),
    ("crossbow", 1.5, 2),
    ("keystone", 1.5, 2),
];

/// What a recorded scene is recorded for (s).
const RECORDED: &str = "3";

/// Least part of a picture that is neither of its three commonest colours: sky, ground and paper.
const LEAST_SEEN: f64 = 0.004;

/// Fewest colours of a picture with bodies in the light.
const FEWEST_COLORS: usize = 12;

/// `to` is where pictures go; those of the window are NAME.png, those without one NAME-still.png.
pub fn run(to: Option<&str>) -> Outcome<()> {
    let library = Library::build_with(&["--features", "stream"])?;
    let folder = output_folder("viewer")?;
    let pictures = to.map_or_else(|| folder.clone(), PathBuf::from);
    let viewer = viewer()?;
    for (name, after, selected) in SCENES {
        let source = repository().join("examples_c").join(name).with_extension("c");
        if !std::fs::read_to_string(&source).is_ok_and(|text| text.contains("step_world")) {
            println!("{name}: there is no such sample");
            continue;
        }
        let program = folder.join(name);
        compile(&source, &program, Language::C99, &library)?;
        let (window, still) = (pictures.join(format!("{name}.png")), pictures.join(format!("{name}-still.png")));
        let recording = folder.join(format!("{name}.lsr"));
        let told = watch(&viewer, name, &program, &window, &recording, (after, selected))?;
        look(&window)?;
        let (step, hash) = last_frame(&told).ok_or_else(|| format!("nothing was recorded: {told}"))?;
        let played = printed(Command::new(&viewer).arg("picture").arg(&recording).arg(&still).args(["--step", step]))?;
        print!("{name}: {told}{name}, played: {played}");
        if !played.contains(&format!("step {step},")) || !played.contains(hash) {
            return Err(format!("{name}: the recording shows another frame than was seen").into());
        }
        look(&still)?;
    }
    Ok(())
}

/// A process that ends with us.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a sample with its stream, a window on it and a recorder; returns what the recorder says.
fn watch(
    viewer: &Path,
    name: &str,
    program: &Path,
    window: &Path,
    recording: &Path,
    (after, selected): (f32, usize),
) -> Outcome<String> {
    let recorder = Command::new(viewer).args(["record", name]).arg(recording).arg(RECORDED).stdout(Stdio::piped()).spawn()?;
    let _host = Running(Command::new(program).env("LONGSPAN_STREAM", name).stdout(Stdio::null()).spawn()?);
    let mut shot = Command::new("xvfb-run");
    shot.args(["--auto-servernum", "--server-args", "-screen 0 1280x800x24"]).arg(viewer).args(["watch", name, "--shot"]);
    succeed(shot.arg(window).args(["--after", &after.to_string(), "--select", &selected.to_string()]))?;
    let recorded = recorder.wait_with_output()?;
    Ok(String::from_utf8(recorded.stdout)?)
}

/// Step and hash of the last frame that was recorded.
fn last_frame(told: &str) -> Option<(&str, &str)> {
    let rest = told.split_once("the last one of step ")?.1;
    let (step, hash) = rest.split_once(" with hash ")?;
    Some((step, hash.trim()))
}

/// The viewer, built in its own workspace, or the one that `LONGSPAN_VIEWER` names.
fn viewer() -> Outcome<PathBuf> {
    if let Some(viewer) = std::env::var_os("LONGSPAN_VIEWER") {
        return Ok(viewer.into());
    }
    let folder = repository().join("viewer");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    succeed(cargo.current_dir(&folder).args(["build", "--release"]))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| folder.join("target"), PathBuf::from);
    Ok(target.join("release/longspan-viewer"))
}

/// Whether a picture shows bodies, and not just what is behind them.
fn look(picture: &Path) -> Outcome<()> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(picture)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut bytes)?;
    let mut colors: HashMap<&[u8], usize> = HashMap::new();
    for pixel in bytes[..info.buffer_size()].chunks_exact(info.color_type.samples()) {
        *colors.entry(pixel).or_default() += 1;
    }
    let mut counts: Vec<usize> = colors.values().copied().collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let seen = counts.iter().skip(3).sum::<usize>() as f64 / (info.width * info.height) as f64;
    println!("{}: {} colours, {:.1} % of the picture is something", picture.display(), counts.len(), 100.0 * seen);
    if counts.len() < FEWEST_COLORS || seen < LEAST_SEEN {
        return Err(format!("{}: there is nothing to be seen", picture.display()).into());
    }
    Ok(())
}
