//! What the command line takes.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use longspan_scenes::Effort;

/// Our engine's name on the command line.
pub const OURS: &str = "longspan";

/// Every peer, and whether this build has it.
const PEERS: [(&str, bool); 3] =
    [("rapier", cfg!(feature = "peer-rapier")), ("box3d", cfg!(feature = "peer-box3d")), ("jolt", cfg!(feature = "peer-jolt"))];

/// Run time against error: longspan beside other engines on the same scenes.
#[derive(Debug, Parser)]
#[command(name = "longspan-bench", version)]
pub struct Options {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a scene on engines and prints times and errors
    Run(Run),
    /// Prints the scenes with their keys and defaults
    List,
    /// Turns a file of JSON lines into run-time-against-error pictures (SVG), one for each scene and its keys
    Plot {
        /// Lines as `run --json` prints them
        file: PathBuf,
        /// Folder for the pictures, made if need be
        out_dir: PathBuf,
        /// Name of the error to show instead of each scene's first
        #[arg(long)]
        error: Option<String>,
        /// Steps whose median time is shown
        #[arg(long, value_enum, default_value_t = Stretch::Whole)]
        time: Stretch,
    },
    /// Runs every row of the stress scene on our engine and prints the table of what held (Markdown)
    StressTable {
        /// Seeds of each row
        #[arg(long, default_value_t = 100, value_parser = at_least_one)]
        seeds: usize,
    },
    /// Runs scenes at numbers that nothing was tuned for, at other rates and sizes, and prints what they keep of their promises (Markdown)
    HoldoutTable {
        /// Only scenes whose name contains this
        #[arg(default_value = "")]
        of: String,
    },
    /// Takes the time of deriving long-range constraints, of whole worlds and after one joint is gone, and prints a table (Markdown)
    DeriveTable,
    /// Times what a host asks of a world between steps, and prints it as tables (Markdown): snapshots, edits
    HostTable {
        /// How often each snapshot is taken and restored; medians are printed
        #[arg(long, default_value_t = 51, value_parser = at_least_one)]
        repeats: usize,
    },
    /// Says how a scene's steps would scale: what is serial in them, what is divided, and how long so many threads would take by a model
    #[cfg(feature = "trace")]
    Trace(Trace),
    /// Runs a scene on our engine and draws its end
    Picture(Picture),
    /// Runs a scene on our engine and writes its end as a snapshot, which ls_world_restore reads
    Save {
        #[command(flatten)]
        chosen: Chosen,
        /// The snapshot
        out: PathBuf,
    },
    /// Draws bodies from a text file, one a line: `box hx hy hz  px py pz  qx qy qz qw`, `ball r …`, `capsule half_height r …`, `cylinder half_height r …`
    Draw {
        /// The text file
        file: PathBuf,
        /// The picture (PNG)
        out: PathBuf,
        /// Width and height in pixels
        #[arg(long, default_value = "1280x720", value_parser = size)]
        size: (usize, usize),
    },
}

/// Steps that a time is a median of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Stretch {
    /// The whole run
    Whole,
    /// The second of simulated time that takes longest
    Busiest,
    /// The scene's own window, the last quarter of most
    Last,
}

impl Stretch {
    /// Its name in a line of JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Busiest => "busiest",
            Self::Last => "last",
        }
    }
}

/// Which scene, with which keys.
#[derive(Debug, Args)]
pub struct Chosen {
    /// Name of the scene
    pub scene: String,
    /// Sets a key of the scene
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    pub set: Vec<(String, String)>,
    /// Length of the run (s) instead of the scene's own
    #[arg(long)]
    pub seconds: Option<f64>,
}

impl Chosen {
    /// All keys, the length of the run among them.
    pub fn keys(&self) -> Vec<(String, String)> {
        let seconds = self.seconds.map(|seconds| ("seconds".to_owned(), seconds.to_string()));
        self.set.iter().cloned().chain(seconds).collect()
    }
}

#[derive(Debug, Args)]
pub struct Run {
    #[command(flatten)]
    pub chosen: Chosen,
    /// Engines to run it on; all that were built in if not given
    #[arg(long, value_delimiter = ',', value_parser = engine)]
    pub engines: Vec<String>,
    /// Efforts to run it at: `default`, or a number of substeps
    #[arg(long, value_delimiter = ',', default_value = "default", value_parser = effort)]
    pub effort: Vec<Effort>,
    /// Threads
    #[arg(long, default_value_t = 1, value_parser = at_least_one)]
    pub threads: usize,
    /// Prints one JSON object a line
    #[arg(long)]
    pub json: bool,
    /// Takes the times of this many runs of each and prints those of the run with the smallest median over all its steps
    #[arg(long, default_value_t = 1, value_parser = at_least_one)]
    pub repeat: usize,
    /// Does other work, which takes the caches, for this long (ms) before each step, as a game does
    #[arg(long, value_name = "MS", value_parser = milliseconds)]
    pub cold: Option<Duration>,
    /// Runs each with seeds 1 to this and prints the worst of every error, the number of runs that did not hold, and the times of
    /// the seed with the greatest median over all its steps
    #[arg(long, value_parser = at_least_one, conflicts_with = "repeat")]
    pub seeds: Option<usize>,
}

impl Run {
    /// The engines asked for, or all of this build.
    pub fn engines(&self) -> Vec<String> {
        if self.engines.is_empty() { built_in().map(str::to_owned).collect() } else { self.engines.clone() }
    }
}

#[cfg(feature = "trace")]
#[derive(Debug, Args)]
pub struct Trace {
    #[command(flatten)]
    pub chosen: Chosen,
    /// Numbers of threads; stages are printed for the last
    #[arg(long, value_delimiter = ',', default_value = "1,2,4,8,16", value_parser = at_least_one)]
    pub threads: Vec<usize>,
    /// Steps at the start that are left out
    #[arg(long, default_value_t = 10)]
    pub skip: usize,
}

#[derive(Debug, Args)]
pub struct Picture {
    #[command(flatten)]
    pub chosen: Chosen,
    /// The picture (PNG)
    pub out: PathBuf,
    /// Width and height in pixels
    #[arg(long, default_value = "1280x720", value_parser = size)]
    pub size: (usize, usize),
}

fn built_in() -> impl Iterator<Item = &'static str> {
    [OURS].into_iter().chain(PEERS.into_iter().filter(|(_, built)| *built).map(|(name, _)| name))
}

fn engine(name: &str) -> Result<String, String> {
    if built_in().any(|built| built == name) {
        return Ok(name.to_owned());
    }
    let valid = built_in().collect::<Vec<_>>().join(", ");
    match PEERS.iter().find(|(peer, _)| *peer == name) {
        Some(_) => Err(format!("'{name}' was left out of this build (feature peer-{name}); the engines are: {valid}")),
        None => Err(format!("no engine is called '{name}'; the engines are: {valid}")),
    }
}

fn effort(text: &str) -> Result<Effort, String> {
    if text == "default" {
        return Ok(Effort::Default);
    }
    at_least_one(text).map(|count| Effort::N(count as u32)).map_err(|_| "must be `default` or a number from 1 on".to_owned())
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|count| (1..=1_000_000).contains(count)).ok_or_else(|| "must be a number from 1 on".to_owned())
}

fn milliseconds(text: &str) -> Result<Duration, String> {
    let ms = text.parse::<f64>().ok().filter(|ms| (0.0..=10_000.0).contains(ms));
    ms.map(|ms| Duration::from_secs_f64(ms * 1e-3)).ok_or_else(|| "must be a time from 0 to 10000 ms".to_owned())
}

fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| "must be KEY=VALUE".to_owned())?;
    Ok((key.to_owned(), value.to_owned()))
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.parse().ok().filter(|pixels| (1..=16_384).contains(pixels));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "must be WIDTHxHEIGHT in pixels".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_reads_as_the_guide_shows_it() {
        let line = "longspan-bench run hanging_chain --set n=10 --set ratio=100 --engines longspan --effort default,16 --threads 2 --seconds 1 --cold 10 --json";
        let Command::Run(run) = Options::try_parse_from(line.split(' ')).unwrap().command else { panic!("not a run") };
        let keys = [("n", "10"), ("ratio", "100"), ("seconds", "1")].map(|(key, value)| (key.to_owned(), value.to_owned()));
        assert_eq!(run.chosen.keys(), keys);
        assert_eq!((run.effort, run.threads, run.json), (vec![Effort::Default, Effort::N(16)], 2, true));
        assert_eq!(run.cold, Some(Duration::from_millis(10)));
    }

    #[test]
    fn an_unknown_engine_is_refused_with_those_that_exist() {
        let problem = Options::try_parse_from(["longspan-bench", "run", "pile", "--engines", "novodex"]).unwrap_err().to_string();
        assert!(problem.contains("novodex") && problem.contains("longspan"), "{problem}");
    }
}
