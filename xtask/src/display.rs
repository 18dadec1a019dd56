//! A display without a screen, a program with a window on it, and a hand that presses its keys.

use std::fmt::Display as Text;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::{Outcome, printed};

/// How long a program has for what it is expected to say.
const PATIENCE: Duration = Duration::from_secs(60);

/// Longer than the window takes for a picture, so that what is done before and after does not fall in the same one.
const REST: Duration = Duration::from_millis(300);

/// A process that ends with us.
pub struct Running(Child);

impl Running {
    /// Starts a program.
    pub fn start(command: &mut Command) -> Outcome<Self> {
        Ok(Self(command.spawn().map_err(|error| format!("{command:?}: {error}"))?))
    }

    /// Waits until it ends, which it must do without complaint.
    pub fn finish(mut self) -> Outcome<()> {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            if let Some(status) = self.0.try_wait()? {
                return if status.success() { Ok(()) } else { Err(format!("a program ended with {status}").into()) };
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Err("a program does not end".into())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A virtual display.
pub struct Display {
    name: String,
    _server: Running,
}

impl Display {
    /// Starts a server on the first number that is free.
    pub fn open() -> Outcome<Self> {
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"]);
        let mut server = Running::start(server.stdout(Stdio::piped()).stderr(Stdio::null()))?;
        let mut number = String::new();
        BufReader::new(server.0.stdout.take().ok_or("the server says nothing")?).read_line(&mut number)?;
        match number.trim() {
            "" => Err("Xvfb does not start; setup/install.sh --viewer installs it".into()),
            number => Ok(Self { name: format!(":{number}"), _server: server }),
        }
    }

    /// Starts a program that opens a window on it and writes lines.
    pub fn start(&self, command: &mut Command) -> Outcome<Shown<'_>> {
        let mut running = Running::start(command.env("DISPLAY", &self.name).stdout(Stdio::piped()))?;
        let output = running.0.stdout.take().ok_or("a program says nothing")?;
        let (sender, lines) = channel();
        std::thread::spawn(move || BufReader::new(output).lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Ok(Shown { display: self, running, lines })
    }

    /// Moves the pointer, presses keys: `xdotool`.
    fn hand(&self, words: &[&str]) -> Outcome<String> {
        printed(Command::new("xdotool").args(words).env("DISPLAY", &self.name))
    }
}

/// A program with a window.
pub struct Shown<'a> {
    display: &'a Display,
    running: Running,
    lines: Receiver<String>,
}

impl Shown<'_> {
    /// Waits for a line that begins with these words and returns what follows them.
    pub fn says(&self, words: &str) -> Outcome<String> {
        let end = Instant::now() + PATIENCE;
        loop {
            let Ok(line) = self.lines.recv_timeout(end.saturating_duration_since(Instant::now())) else {
                return Err(format!("the window does not say \"{words}\"").into());
            };
            if let Some(rest) = line.strip_prefix(words) {
                return Ok(rest.to_owned());
            }
        }
    }

    /// The window's number; the window has the keyboard afterwards.
    pub fn focus(&self) -> Outcome<String> {
        let found = self.display.hand(&["search", "--sync", "--name", "^longspan$"])?;
        let window = found.lines().last().ok_or("there is no window")?.to_owned();
        // There is no manager of windows that would do it.
        self.display.hand(&["windowfocus", "--sync", &window])?;
        Ok(window)
    }

    /// Presses a key.
    pub fn press(&self, key: &str) -> Outcome<()> {
        self.display.hand(&["key", key]).map(|_| ())
    }

    /// Puts the pointer at a point of the window.
    pub fn point(&self, window: &str, x: impl Text, y: impl Text) -> Outcome<()> {
        self.display.hand(&["mousemove", "--sync", "--window", window, &x.to_string(), &y.to_string()]).map(|_| ())
    }

    /// Clicks with a button: 1 is the left one, 4 and 5 are the wheel.
    pub fn click(&self, button: &str) -> Outcome<()> {
        self.display.hand(&["click", button]).map(|_| ())
    }

    /// Holds the left button down, or lets it go; before and after, as a hand does, it rests.
    pub fn hold(&self, down: bool) -> Outcome<()> {
        std::thread::sleep(REST);
        self.display.hand(&[if down { "mousedown" } else { "mouseup" }, "1"])?;
        std::thread::sleep(REST);
        Ok(())
    }

    /// Waits until the program has ended by itself.
    pub fn finish(self) -> Outcome<()> {
        self.running.finish()
    }
}
