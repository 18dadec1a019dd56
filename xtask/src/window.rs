//! The viewer's window under a hand: every key and button that it answers to, on two live streams and on a recording.

use std::process::{Command, Stdio};

use crate::display::{Display, Running, Shown};
use crate::library::output_folder;
use crate::viewer::{host, save, viewer};
use crate::{Outcome, succeed};

/// Middle of the window, where everything that moves is put.
const MIDDLE: (u32, u32) = (600, 380);

/// Width of the window, and a line in the bar at its bottom (pixels).
const WIDTH: u32 = 1200;
const BAR: u32 = 750;

/// Layers that a key switches, and whether they are on at the start.
const LAYERS: [(&str, bool); 6] = [("s", true), ("u", true), ("b", true), ("j", true), ("c", false), ("p", true)];

/// Steps by which the place in the bar may be missed: one pixel is less than half a step.
const MISSED: u64 = 2;

/// `to` is where pictures go.
pub fn run(to: Option<&str>) -> Outcome<()> {
    let folder = output_folder("window")?;
    let (viewer, host, display) = (viewer()?, host(&folder)?, Display::open()?);
    // A single box in the middle of the picture, and something that swings.
    let streams = [("box", "bounce", folder.join("box.snapshot")), ("chain", "swinging_weight", folder.join("chain.snapshot"))];
    let mut hosts = Vec::new();
    for (name, scene, file) in &streams {
        save(scene, &[("seconds", "0.05")], file)?;
        let mut command = Command::new(&host);
        hosts.push(Running::start(command.arg(file).arg("1000").env("LONGSPAN_STREAM", name).stdout(Stdio::null()))?);
    }
    let recording = folder.join("chain.lsr");
    succeed(Command::new(&viewer).args(["record", "chain"]).arg(&recording).arg("5"))?;

    let pictures = std::path::absolute(to.map_or_else(|| folder.clone(), Into::into))?;
    std::fs::create_dir_all(&pictures)?;
    let open = |words: &[&str]| display.start(Command::new(&viewer).args(words).current_dir(&pictures));
    live(&open(&["watch", "box"])?)?;
    let shown = open(&["play", recording.to_str().ok_or("a path that is no text")?])?;
    played(&shown)?;
    shown.press("Escape")?;
    shown.finish()
}

/// What can be done with a live stream.
fn live(shown: &Shown<'_>) -> Outcome<()> {
    shown.says("a window is open")?;
    let window = shown.focus()?;
    std::thread::sleep(std::time::Duration::from_secs(1));
    shown.point(&window, MIDDLE.0, MIDDLE.1)?;
    shown.click("1")?;
    println!("a click on a body: selected body{}", shown.says("selected body")?);
    println!("F12: step {}", picture(shown)?);
    shown.point(&window, MIDDLE.0, 700)?;
    shown.click("1")?;
    shown.says("selected nothing")?;
    println!("a click beside it: nothing is selected");
    shown.press("space")?;
    let held = number(&shown.says("paused at step ")?)?;
    let seen = number(&picture(shown)?)?;
    std::thread::sleep(std::time::Duration::from_secs(1));
    shown.press("space")?;
    let there = number(&shown.says("goes on at step ")?)?;
    std::thread::sleep(std::time::Duration::from_millis(500));
    let after = number(&picture(shown)?)?;
    println!("space: held at step {held} for a second, after half a second more at step {after}");
    expect(held == there && seen == held, "a pause holds the picture")?;
    expect(after >= held + 60, "it follows the newest frame again")?;

    shown.point(&window, MIDDLE.0, MIDDLE.1)?;
    shown.hold(true)?;
    shown.point(&window, MIDDLE.0 + 30, MIDDLE.1)?;
    shown.point(&window, MIDDLE.0 + 90, MIDDLE.1 + 40)?;
    shown.hold(false)?;
    println!("a drag: turned to{}", shown.says("turned to")?);
    let away = |button: &str| -> Outcome<f64> {
        shown.click(button)?;
        Ok(shown.says("distance ")?.trim_end_matches(" m").parse()?)
    };
    let (near, far) = (away("4")?, away("5")?);
    println!("the wheel: {near} m away, and back to {far} m");
    expect(near < far, "the wheel comes nearer and goes back")?;
    for (key, is_on) in LAYERS {
        for now in [!is_on, is_on] {
            shown.press(key)?;
            shown.says(&format!("{} {}", key.to_uppercase(), if now { "on" } else { "off" }))?;
        }
    }
    println!("S U B J C P: each layer goes and comes");
    shown.press("f")?;
    shown.press("Tab")?;
    shown.says("watches chain")?;
    std::thread::sleep(std::time::Duration::from_secs(1));
    println!("tab: watches the other stream; F12: step {}", picture(shown)?);
    shown.press("Tab")?;
    shown.says("watches box")?;
    println!("tab: and the first again");
    shown.press("Escape")
}

/// What can be done with a recording.
fn played(shown: &Shown<'_>) -> Outcome<()> {
    shown.says("a window is open")?;
    let window = shown.focus()?;
    let at_step = || number(&shown.says("at step ")?);
    let click_at = |x: u32| -> Outcome<u64> {
        shown.point(&window, x, BAR)?;
        shown.click("1")?;
        at_step()
    };
    let (first, last) = (click_at(0)?, click_at(WIDTH - 1)?);
    let quarter = click_at(WIDTH / 4)?;
    let expected = first + (last - first) / 4;
    println!("clicks in the bar: steps {first}, {last}, and {quarter} where {expected} was expected");
    expect(quarter.abs_diff(expected) <= MISSED && last > first + 100, "the bar goes where it is clicked")?;
    shown.hold(true)?;
    shown.point(&window, WIDTH / 2, BAR)?;
    // Outside the bar the button still has hold of it.
    shown.point(&window, WIDTH / 2, MIDDLE.1)?;
    std::thread::sleep(std::time::Duration::from_millis(300));
    shown.hold(false)?;
    let half = at_step()?;
    expect(half.abs_diff(first + (last - first) / 2) <= MISSED, "the bar follows a drag")?;
    shown.press("Right")?;
    let right = at_step()?;
    shown.press("Left")?;
    let left = at_step()?;
    println!("a drag to the middle: step {half}; right: {right}; left: {left}");
    expect((right, left) == (half + 1, half), "the arrows go by one step")?;
    let before = number(&picture(shown)?)?;
    shown.press("space")?;
    shown.says("goes on at step ")?;
    std::thread::sleep(std::time::Duration::from_secs(1));
    let after = number(&picture(shown)?)?;
    println!("space: plays on from step {before}, a second later at step {after}");
    expect(before == half && after > before + 10, "a recording plays on")
}

/// Has a picture saved; its step, its hash and its file.
fn picture(shown: &Shown<'_>) -> Outcome<String> {
    shown.press("F12")?;
    shown.says("step ")
}

/// The number that a text begins with.
fn number(text: &str) -> Outcome<u64> {
    Ok(text.split_whitespace().next().unwrap_or_default().parse()?)
}

fn expect(holds: bool, what: &str) -> Outcome<()> {
    if holds { Ok(()) } else { Err(format!("not so: {what}").into()) }
}
