//! A stream from one machine to another, by iceoryx2's own tunnel: two network namespaces stand for the machines.
//!
//! Each has a domain of its own, so that they share no memory, and a tunnel; the two tunnels meet over a pair of virtual network
//! devices. It takes root, and `iox2-link-tunnel-zenoh`:
//! `cargo install iceoryx2-integrations-zenoh-link-tunnel-cli --version 0.10.0`.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::display::Running;
use crate::library::output_folder;
use crate::streams::build_peer;
use crate::viewer::viewer;
use crate::{Outcome, printed, succeed};

/// How the tunnels find each other.
const PLACE: &str = "tcp/10.117.0.1:7447";

/// How long both sides record (s), and how long a reader may take to see that the host has been killed.
const RECORDED: &str = "5";
const GONE_WITHIN: Duration = Duration::from_secs(5);

/// What is published at 60 Hz.
const SCENE: &str = "pile,n=300";

pub fn run() -> Outcome<()> {
    let tunnel = std::env::var_os("LONGSPAN_TUNNEL").map_or_else(|| PathBuf::from("iox2-link-tunnel-zenoh"), PathBuf::from);
    let folder = output_folder("tunnel")?;
    let (viewer, peer) = (viewer()?, build_peer()?);
    let machines = Machines::connect()?;
    let zenoh = [
        format!("listen: {{ endpoints: [\"{PLACE}\"] }}"),
        format!("connect: {{ endpoints: [\"{PLACE}\"] }}, listen: {{ endpoints: [] }}"),
    ];
    let mut tunnels = Vec::new();
    for (side, zenoh) in SIDES.into_iter().zip(zenoh) {
        let place = folder.join(side);
        std::fs::create_dir_all(place.join("config"))?;
        let settings = printed(Command::new(&viewer).args(["config", "--domain", &domain(side)]))?;
        std::fs::write(place.join("config/iceoryx2.toml"), settings)?;
        let zenoh = format!("{{ mode: \"peer\", scouting: {{ multicast: {{ enabled: false }} }}, {zenoh} }}");
        std::fs::write(place.join("zenoh.json5"), zenoh)?;
        let mut command = machines.on(side, &tunnel);
        command.args(["--zenoh-config", "zenoh.json5", "--allow", "longspan/*", "--poll", "2", "--reactive"]);
        tunnels.push(Running::start(command.current_dir(&place).stdout(Stdio::null()))?);
    }

    let mut host =
        machines.on("left", &peer).args(["publish", &domain("left"), SCENE, "1000", "60"]).stdout(Stdio::null()).spawn()?;
    let record = |side: &'static str| -> Outcome<Child> {
        let mut command = machines.on(side, &viewer);
        command.args(["record", "peer"]).arg(file(&folder, side)).args([RECORDED, "--domain", &domain(side)]);
        Ok(command.stdout(Stdio::piped()).spawn()?)
    };
    let recorders = [record("left")?, record("right")?];
    let mut steps = Vec::new();
    for (side, recorder) in SIDES.iter().zip(recorders) {
        let said = String::from_utf8(recorder.wait_with_output()?.stdout)?;
        print!("{side}: {said}");
        let step = said.split_once("to step ").and_then(|(_, rest)| rest.split_once(',')).ok_or("nothing came")?.0;
        steps.push(step.parse::<u64>()?);
    }
    // The last step that both have is a whole scene on both.
    let step = steps.iter().min().ok_or("two sides")?.to_string();
    let mut shown = Vec::new();
    for side in SIDES {
        let to = folder.join(format!("{side}.png"));
        let said = printed(Command::new(&viewer).arg("picture").arg(file(&folder, side)).arg(to).args(["--step", &step]))?;
        print!("{side}: {said}");
        shown.push(said.split_once(':').map(|(seen, _)| seen.to_owned()));
    }
    let outcome = if shown[0] == shown[1] {
        readers_notice(&machines, &peer, &mut host)
    } else {
        Err("the two sides show different frames".into())
    };
    let _ = host.kill().and_then(|()| host.wait());
    drop(tunnels);
    outcome
}

/// Readers on both sides see that a host has been killed, although the tunnel on its own side still writes on its stream.
fn readers_notice(machines: &Machines, peer: &Path, host: &mut Child) -> Outcome<()> {
    let mut readers = Vec::new();
    for side in SIDES {
        readers.push((side, machines.on(side, peer).args(["read", &domain(side), "0"]).stdout(Stdio::piped()).spawn()?));
    }
    sleep(Duration::from_secs(3));
    let killed = Instant::now();
    host.kill()?;
    host.wait()?;
    for (side, mut reader) in readers {
        while reader.try_wait()?.is_none() {
            if killed.elapsed() > GONE_WITHIN {
                reader.kill()?;
                return Err(format!("{side}: a reader does not see that the host has gone").into());
            }
            sleep(Duration::from_millis(10));
        }
        let after = killed.elapsed().as_secs_f64();
        let said = String::from_utf8(reader.wait_with_output()?.stdout)?;
        println!("{side}: sees after {after:.2} s that the host was killed\n{}", said.trim());
    }
    Ok(())
}

const SIDES: [&str; 2] = ["left", "right"];

fn domain(side: &str) -> String {
    format!("tunnel-{side}")
}

fn file(folder: &Path, side: &str) -> PathBuf {
    folder.join(format!("{side}.lsr"))
}

/// Two network namespaces with a cable between them.
struct Machines;

impl Machines {
    fn connect() -> Outcome<Self> {
        for side in SIDES {
            ip(&["netns", "add", &space(side)]).map_err(|problem| format!("{problem} (as root?)"))?;
        }
        let machines = Self;
        let [left, right] = SIDES.map(space);
        ip(&["link", "add", "ls-left", "netns", &left, "type", "veth", "peer", "name", "ls-right", "netns", &right])?;
        for (side, address) in SIDES.into_iter().zip(["10.117.0.1/24", "10.117.0.2/24"]) {
            let (space, device) = (space(side), format!("ls-{side}"));
            ip(&["-n", &space, "address", "add", address, "dev", &device])?;
            ip(&["-n", &space, "link", "set", &device, "up"])?;
            ip(&["-n", &space, "link", "set", "lo", "up"])?;
        }
        Ok(machines)
    }

    /// A program on one of the two.
    fn on(&self, side: &str, program: &Path) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &space(side)]).arg(program);
        command
    }
}

impl Drop for Machines {
    fn drop(&mut self) {
        for side in SIDES {
            let _ = ip(&["netns", "delete", &space(side)]);
        }
    }
}

fn space(side: &str) -> String {
    format!("longspan-{side}")
}

fn ip(words: &[&str]) -> Outcome<()> {
    succeed(Command::new("ip").args(words))
}
