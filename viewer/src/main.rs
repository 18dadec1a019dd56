//! Watches a longspan stream, or looks through a recording of one.
//!
//! With a window (macroquad, which draws on a graphics card or on Mesa's software one), or without: pictures and turntables come
//! from the renderer of `longspan-scenes`, which needs neither a window nor a graphics driver.

mod export;
mod gltf;
mod parts;
mod pick;
mod window;

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use longspan_stream::{Domain, Poll, Reader, Scene};

const USAGE: &str = "longspan-viewer COMMAND

    list                              streams that are published now
    watch [NAME]                      a window on a stream, or on any
    play FILE                         a window on a recording
    picture NAME|FILE OUT.png         what a stream or a recording shows, without a window
    turntable NAME|FILE OUT.gif       the same from all around
    record NAME FILE SECONDS          writes a stream to a file, from its first frame on
    frames FILE                       how many frames a recording has, and a hash of what all of them show
    gltf FILE OUT.gltf                a recording as an animation for other programs
    config                            what a configuration file of iceoryx2's says that its tunnel finds streams by

    --domain NAME    where to look for streams
    --step N         the frame of this step: of a recording (else its last), or of --shot (else that after two seconds)
    --size WxH       of pictures (960x600)
    --select N       watch and play: begin with the N-th moving body selected, from 0
    --shot OUT.png   watch and play: save the window, and end";

/// What the command line says.
#[derive(Debug, Default)]
pub struct Options {
    words: Vec<String>,
    domain: String,
    step: Option<u64>,
    size: Option<(usize, usize)>,
    shot: Option<String>,
    select: Option<usize>,
}

/// Any failure, as text.
type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn options() -> Outcome<Options> {
    let mut options = Options::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
        match argument.as_str() {
            "--domain" => options.domain = value()?,
            "--step" => options.step = Some(value()?.parse()?),
            "--shot" => options.shot = Some(value()?),
            "--select" => options.select = Some(value()?.parse()?),
            "--size" => {
                let text = value()?;
                let (width, height) = text.split_once('x').ok_or("--size is WIDTHxHEIGHT")?;
                options.size = Some((width.parse()?, height.parse()?));
            }
            _ => options.words.push(argument),
        }
    }
    Ok(options)
}

fn main() -> ExitCode {
    match options().and_then(|options| run(&options)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Outcome<()> {
    let domain = Domain::named(&options.domain)?;
    let size = options.size.unwrap_or((960, 600));
    match options.words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["list"] => {
            for source in domain.sources()? {
                println!("{} (process {}, stream {}, schema {})", source.name, source.process, source.number, source.schema);
            }
            Ok(())
        }
        ["watch"] => window::open(Reader::attach(&domain, "")?, &domain, options),
        ["watch", name] => window::open(Reader::attach(&domain, name)?, &domain, options),
        ["play", file] => window::open(Reader::open(Path::new(file))?, &domain, options),
        ["picture", from, to] => export::picture(&still(&domain, from, options.step)?, Path::new(to), size),
        ["turntable", from, to] => export::turntable(&still(&domain, from, options.step)?, Path::new(to), size),
        ["record", name, file, seconds] => record(&domain, name, file, seconds.parse()?),
        ["frames", file] => frames(&mut Reader::open(Path::new(file))?),
        ["config"] => {
            print!("{}", domain.settings()?);
            Ok(())
        }
        ["gltf", file, to] => gltf::write(Reader::open(Path::new(file))?, Path::new(to)),
        _ => Err(USAGE.into()),
    }
}

/// A reader that shows one whole frame: of a recording at a step, or of a stream now.
fn still(domain: &Domain, from: &str, step: Option<u64>) -> Outcome<Reader> {
    if Path::new(from).is_file() {
        let mut reader = Reader::open(Path::new(from))?;
        let last = reader.recording().and_then(|recording| recording.steps).ok_or("the recording has no frames")?.1;
        reader.seek(step.unwrap_or(last))?;
        return Ok(reader);
    }
    let mut reader = Reader::attach(domain, from)?;
    for _ in 0..100 {
        let found = matches!(reader.wait(Duration::from_millis(100))?, Poll::Frame { .. });
        if found && reader.scene().is_complete() {
            return Ok(reader);
        }
    }
    Err(format!("no stream named {from} within ten seconds").into())
}

/// Frames that a reader has come by, and what all of them show.
#[derive(Debug, Default)]
struct Seen {
    frames: u64,
    hash: u64,
}

impl Seen {
    /// The hash depends on each frame and on their order.
    fn add(&mut self, scene: &Scene) {
        self.frames += 1;
        self.hash = self.hash.rotate_left(1) ^ scene.hash();
    }
}

fn record(domain: &Domain, name: &str, file: &str, seconds: f64) -> Outcome<()> {
    let mut reader = Reader::attach(domain, name)?;
    reader.record(Some(Path::new(file)))?;
    let mut end: Option<Instant> = None;
    let (mut seen, mut lost) = (Seen::default(), 0);
    while end.is_none_or(|end| Instant::now() < end) {
        match reader.poll_next()? {
            Poll::Frame { lost_frames, .. } => {
                end.get_or_insert_with(|| Instant::now() + Duration::from_secs_f64(seconds));
                seen.add(reader.scene());
                lost += lost_frames;
                reader.forget_events();
            }
            Poll::Gone if end.is_some() => break,
            _ => std::thread::sleep(Duration::from_micros(500)),
        }
    }
    let step = reader.scene().frame().step;
    reader.record(None)?;
    println!("{} frames to step {step}, {lost} lost, what they show has hash {:016x}", seen.frames, seen.hash);
    Ok(())
}

fn frames(reader: &mut Reader) -> Outcome<()> {
    let mut seen = Seen::default();
    while let Poll::Frame { .. } = reader.poll_next()? {
        seen.add(reader.scene());
        reader.forget_events();
    }
    let step = reader.scene().frame().step;
    println!("{} frames to step {step}, what they show has hash {:016x}", seen.frames, seen.hash);
    Ok(())
}
