//! One side of a stream as a process of its own: for tests that kill it, and to measure.
//!
//! ```text
//! stream_peer publish DOMAIN SCENE SECONDS RATE    steps a scene, RATE times a second (0: as fast as it can), with a stream
//! stream_peer read    DOMAIN SECONDS               reads each newest frame, and says when a publisher's first one comes, and at the
//!                                                  end what was lost and how old frames were (0: until it has gone)
//! stream_peer measure DOMAIN SCENE STEPS READERS   what publishing costs, and whether it shows in the step itself, with so many
//!                                                  readers in as many processes
//! stream_peer endure  DOMAIN SCENE LIVES           publishes while a reader and another publisher are started, stopped and killed
//! stream_peer future  DOMAIN SECONDS               a stream of a schema that is still to come
//! ```
//!
//! SCENE is a scene of the library of scenes and its keys: `pile,n=10000`.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use cpu_time::ThreadTime;
use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, LogLevel, NodeBuilder, Path as FolderName, SemanticString, ipc, set_log_level};
use longspan::World;
use longspan_scenes::{DT, LongspanEngine, build};
use longspan_stream::schema::{LS_STREAM_ABI, LS_STREAM_SCHEMA};
use longspan_stream::{Domain, Poll, Publisher, PublisherDef, Reader};

/// Steps before times count.
const WARM_UP: u32 = 60;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let word = |index: usize| words.get(index).map_or("", String::as_str);
    let number = |index: usize| word(index).parse::<f64>().unwrap_or(1.0);
    let domain = Domain::named(word(1)).expect("a name for a domain");
    match word(0) {
        "publish" => publish(&domain, world(word(2)), number(3), number(4)),
        "measure" => measure(&domain, word(2), number(3) as u32, number(4) as usize),
        "endure" => endure(&domain, word(2), number(3) as u32),
        "read" => read(&domain, number(2)),
        "future" => future(&domain, number(2)),
        other => panic!("no command {other}: see the top of stream_peer.rs"),
    }
}

/// A scene's bodies and joints, on one thread.
fn world(scene: &str) -> LongspanEngine {
    let mut words = scene.split(',');
    let name = words.next().unwrap_or_default();
    let keys = words.map(|word| word.split_once('=').map(|(key, value)| (key.to_owned(), value.to_owned())).expect("KEY=VALUE"));
    LongspanEngine::start(&build(name, &keys.collect::<Vec<_>>()).expect("a scene")).expect("a world")
}

fn open(domain: &Domain, world: &World) -> Publisher {
    let def = PublisherDef { domain: domain.clone(), name: "peer".into(), ..PublisherDef::default() };
    Publisher::open(world, &def).expect("a stream")
}

/// Sleeps until this many periods of the rate are over.
fn wait(start: Instant, periods: usize, rate: f64) {
    if rate > 0.0 {
        let due = start + Duration::from_secs_f64(periods as f64 / rate);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
}

fn publish(domain: &Domain, mut engine: LongspanEngine, seconds: f64, rate: f64) {
    let world = engine.world_mut();
    let mut publisher = open(domain, world);
    println!("ready");
    let (mut stepping, mut publishing) = (Vec::new(), Vec::new());
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < seconds {
        stepping.push(cpu(|| step(world)));
        publishing.push(cpu(|| publisher.publish(world)));
        wait(start, stepping.len(), rate);
    }
    println!("{} steps, {} dropped", stepping.len(), publisher.stats().dropped);
    print_times("step, CPU time", &mut stepping);
    print_times("publication, CPU time", &mut publishing);
}

/// Steps that are published, then as many that are not, and so on.
const BLOCK: usize = 8;

/// Two worlds of one scene step in turn: step for step they do the same work, to the last bit. One is published in every other block
/// of steps, the other never. What the machine does falls on both alike, and how each happens to lie in memory on all its steps
/// alike; so what publishing does to a step is the ratio of the two in published blocks, over that in the others.
fn measure(domain: &Domain, scene: &str, steps: u32, readers: usize) {
    let mut engines = [world(scene), world(scene)];
    for engine in &mut engines {
        for _ in 0..WARM_UP {
            step(engine.world_mut());
        }
    }
    let mut publisher = open(domain, engines[0].world());
    let readers: Vec<Child> = (0..readers).map(|_| reader(domain)).collect();
    std::thread::sleep(Duration::from_millis(500));
    let mut publishing = Vec::new();
    let mut rows: Vec<Row> = Vec::new();
    for number in 0..steps as usize {
        let streams = (number / BLOCK).is_multiple_of(2);
        let mut times = [[0.0; 2]; 2];
        // Each is first every other time.
        for which in [number % 2, 1 - number % 2] {
            let world = engines[which].world_mut();
            let start = Instant::now();
            let own = cpu(|| step(world));
            times[which] = [own, 1e6 * start.elapsed().as_secs_f64()];
        }
        // The first step of a block still has the last one's publication before it.
        if number % BLOCK > 0 {
            rows.push(Row { streams, times });
        }
        if streams {
            publishing.push(cpu(|| publisher.publish(engines[0].world())));
        }
    }
    let stats = *publisher.stats();
    let [published, other] = engines.each_ref().map(LongspanEngine::world);
    assert_eq!(published.state_hash(), other.state_hash(), "the two are one world twice");
    println!("{} of {} bodies awake, {} frames", published.awake_body_count(), published.body_count(), stats.frames);
    println!("{} bytes a publication, {} dropped", stats.bytes / stats.frames.max(1), stats.dropped);
    drop(publisher);
    for mut reader in readers {
        reader.wait().expect("a reader ends when its publisher has gone");
    }
    for (clock, what) in ["CPU time", "time on the clock"].into_iter().enumerate() {
        let column = |which: usize, streams: bool| -> Vec<f64> {
            let mut column: Vec<f64> =
                rows.iter().filter(|row| row.streams == streams).map(|row| row.times[which][clock]).collect();
            column.sort_by(f64::total_cmp);
            column
        };
        let [mut with, with_twin, mut without, without_twin] =
            [(0, true), (1, true), (0, false), (1, false)].map(|(w, s)| column(w, s));
        print_times(&format!("step, published, {what}"), &mut with);
        print_times(&format!("step, not published, {what}"), &mut without);
        let over_twin = |streams: bool| {
            let mut ratios: Vec<f64> =
                rows.iter().filter(|row| row.streams == streams).map(|row| row.times[0][clock] / row.times[1][clock]).collect();
            ratios.sort_by(f64::total_cmp);
            at(&ratios, 0.5)
        };
        println!(
            "published over not, against the twin, {what}: median of single steps {:.4}",
            over_twin(true) / over_twin(false)
        );
        for share in [0.5, 0.9, 0.99] {
            let [a, b, c, d] = [&with, &with_twin, &without, &without_twin].map(|times| at(times, share));
            println!("  p{:.0}: {:.4}", 100.0 * share, a / b / (c / d));
        }
        if clock == 0 {
            publishing.sort_by(f64::total_cmp);
            print_times("publication, CPU time", &mut publishing);
            let share = 100.0 * at(&publishing, 0.5) / at(&without, 0.5);
            println!("publication over step: {share:.2} % of medians");
        }
    }
}

/// One step of both worlds.
struct Row {
    /// Whether the one that is sometimes published was so in the step before.
    streams: bool,
    /// CPU time and time on the clock, of that one and of its twin (µs).
    times: [[f64; 2]; 2],
}

/// This program as another process in the same domain.
fn peer(command: &str, domain: &Domain, words: &[&str]) -> Command {
    let folder = domain.folder();
    let name = folder.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_prefix("d-")).unwrap_or_default();
    let mut peer = Command::new(std::env::current_exe().expect("this program"));
    peer.args([command, name]).args(words);
    peer
}

/// A reader in a process of its own, which prints what it saw when the publisher has gone.
fn reader(domain: &Domain) -> Child {
    peer("read", domain, &["0"]).spawn().expect("a reader")
}

/// Steps of each part of a life: all well; the others hang; the others are dead, or not there yet.
const PART: u32 = 15;

/// Beside the world that is published its twin steps, which nobody sees: what other processes take from any step, they take from both.
fn endure(domain: &Domain, scene: &str, lives: u32) {
    let mut engines = [world(scene), world(scene)];
    let mut publisher = open(domain, engines[0].world());
    let mut times = [const { Vec::new() }; 6];
    let [calm, calm_twin, disturbed, disturbed_twin, calm_publication, disturbed_publication] = &mut times;
    let mut go_on = |steps: &mut Vec<f64>, twins: &mut Vec<f64>, publications: &mut Vec<f64>| {
        for number in 0..PART {
            // Each is first every other time.
            for which in [number % 2, 1 - number % 2] {
                let times = if which == 0 { &mut *steps } else { &mut *twins };
                times.push(cpu(|| step(engines[which as usize].world_mut())));
            }
            publications.push(cpu(|| publisher.publish(engines[0].world())));
        }
    };
    for life in 0..lives {
        go_on(calm, calm_twin, calm_publication);
        let mut others = [peer("read", domain, &["0"]), peer("publish", domain, &["pile,n=30", "1000", "200"])]
            .map(|mut other| other.stdout(Stdio::null()).spawn().expect("another process"));
        let signal = |name: &str| {
            let all = others.iter().map(|other| other.id().to_string());
            Command::new("kill").arg(name).args(all).status().expect("kill is there");
        };
        go_on(disturbed, disturbed_twin, disturbed_publication);
        signal("-STOP");
        go_on(disturbed, disturbed_twin, disturbed_publication);
        // Every other time they die as they hang.
        if life.is_multiple_of(2) {
            signal("-CONT");
            go_on(disturbed, disturbed_twin, disturbed_publication);
        }
        for other in &mut others {
            other.kill().and_then(|()| other.wait()).expect("it was there");
        }
        go_on(disturbed, disturbed_twin, disturbed_publication);
    }
    let stats = *publisher.stats();
    drop(publisher);
    let left = leftovers(domain);
    println!(
        "{lives} lives, {} frames, {} records, {} dropped, {} files left",
        stats.frames,
        stats.records,
        stats.dropped,
        left.len()
    );
    let titles = [
        "step, calm",
        "its twin's, calm",
        "step, disturbed",
        "its twin's, disturbed",
        "publication, calm",
        "publication, disturbed",
    ];
    // Before they are sorted.
    let mut with_publication = [(0, 4), (2, 5)].map(|(step, publication)| -> Vec<f64> {
        times[step].iter().zip(&times[publication]).map(|(step, publication)| step + publication).collect()
    });
    for (what, times) in titles.iter().zip(&mut times) {
        print_times(what, times);
    }
    for (what, times) in ["step and publication, calm", "step and publication, disturbed"].iter().zip(&mut with_publication) {
        print_times(what, times);
    }
    print_ratios("published over not", [&times[0], &times[1], &times[2], &times[3]]);
    print_ratios("step and publication over the twin's step", [&with_publication[0], &times[1], &with_publication[1], &times[3]]);
    assert!(stats.dropped == 0 && left.is_empty(), "dropped or left: {left:?}");
}

/// How two columns compare when disturbed, over how they compare when calm; sorted values of calm, its twin, disturbed, its twin.
fn print_ratios(what: &str, columns: [&[f64]; 4]) {
    for share in [0.5, 0.9, 0.99] {
        let [a, b, c, d] = columns.map(|column| at(column, share));
        println!("{what}, disturbed over calm: p{:.0} {:.4}", 100.0 * share, c / d / (a / b));
    }
}

/// All files of a domain but the lock, and the one that iceoryx2 keeps for good.
fn leftovers(domain: &Domain) -> Vec<String> {
    let prefix = domain.prefix();
    let names = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut left: Vec<PathBuf> = names(Path::new("/dev/shm")).collect();
    left.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(&prefix)));
    let mut open = vec![domain.folder()];
    while let Some(folder) = open.pop() {
        let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) = names(&folder).partition(|path| path.is_dir());
        open.extend(folders);
        left.extend(files);
    }
    let left = left.into_iter().map(|path| path.display().to_string());
    left.filter(|name| !name.contains("global_mgmt") && !name.ends_with("/lock")).collect()
}

/// A service where readers of today find it, of the next schema.
fn future(domain: &Domain, seconds: f64) {
    set_log_level(LogLevel::Fatal);
    // Whoever reads has made the folder.
    let folder = domain.folder();
    std::fs::create_dir_all(&folder).expect("a folder");
    // As every member of a domain does, so that nobody clears it.
    let lock = std::fs::File::create(folder.join("lock")).expect("a lock");
    lock.lock_shared().expect("a lock");
    let mut config = Config::default();
    config.global.set_root_path(&FolderName::new(folder.to_str().expect("plain letters").as_bytes()).expect("a path"));
    config.global.prefix = FileName::new(domain.prefix().as_bytes()).expect("a name");
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>().expect("a node");
    let name = format!("longspan/abi{LS_STREAM_ABI}/schema{}/0/{}/1/future/hot", LS_STREAM_SCHEMA + 1, std::process::id());
    let service = node.service_builder(&name.as_str().try_into().expect("a name")).publish_subscribe::<u64>();
    let service = service.create().expect("a service");
    let _publisher = service.publisher_builder().create().expect("a publisher");
    println!("ready");
    std::thread::sleep(Duration::from_secs_f64(seconds));
}

fn read(domain: &Domain, seconds: f64) {
    let mut reader = Reader::attach(domain, "").expect("a reader");
    println!("ready");
    let (mut ages, mut frames, mut lost, mut records, mut lives, mut problems) = (Vec::new(), 0, 0, 0, 0, 0);
    let start = Instant::now();
    while seconds == 0.0 || start.elapsed().as_secs_f64() < seconds {
        match reader.wait(Duration::from_millis(50)) {
            Ok(Poll::Frame { lost_frames, lost_records, is_first }) => {
                let clock = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64);
                // What waited for a reader that was not there yet is old for another reason.
                if is_first {
                    lives += 1;
                    println!("life {lives}");
                } else {
                    ages.push(clock.saturating_sub(reader.scene().frame().clock) as f64 / 1e3);
                }
                (frames, lost, records) = (frames + 1, lost + lost_frames, records + lost_records);
            }
            Ok(Poll::Gone) if seconds == 0.0 && frames > 0 => break,
            Ok(_) => {}
            Err(problem) => {
                problems += 1;
                eprintln!("{problem}");
            }
        }
    }
    let bodies = reader.scene().bodies().len();
    let complete = reader.scene().is_complete();
    println!("{frames} frames, {lost} lost, {records} records lost, {lives} lives, {problems} problems");
    println!("{bodies} bodies, complete: {complete}");
    print_times("age of a frame when it has been taken in", &mut ages);
}

fn step(world: &mut World) {
    world.step(DT).expect("a step");
}

/// What work costs this thread (µs): time in which it does not run does not count.
fn cpu(work: impl FnOnce()) -> f64 {
    let start = ThreadTime::now();
    work();
    1e6 * start.elapsed().as_secs_f64()
}

/// What this share of sorted values does not exceed.
fn at(sorted: &[f64], share: f64) -> f64 {
    sorted.get((share * sorted.len().saturating_sub(1) as f64).round() as usize).copied().unwrap_or(0.0)
}

fn print_times(what: &str, microseconds: &mut [f64]) {
    microseconds.sort_by(f64::total_cmp);
    if !microseconds.is_empty() {
        let mean = microseconds.iter().sum::<f64>() / microseconds.len() as f64;
        let [p50, p90, p99, max] = [0.5, 0.9, 0.99, 1.0].map(|share| at(microseconds, share));
        println!("{what}: mean {mean:.1} us, p50 {p50:.1}, p90 {p90:.1}, p99 {p99:.1}, max {max:.1}");
    }
}
