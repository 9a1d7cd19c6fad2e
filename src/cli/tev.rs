//! `--tev HOST:PORT`: the image viewer tev shows a render as it grows.
//!
//! tev is sent two images: the picture, linear and in sRGB's primaries, and the mean electrons of each channel. A thread
//! of its own sends them, so that the render never waits for tev but in the end, and then a few seconds at most.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::Duration;

use super::log::warning;
use super::monitor::TerminalMonitor;
use crate::colour::ColourSpace;
use crate::develop::{DevelopSettings, develop_linear};
use crate::image::Planes;
use crate::io::tev::{new_image, new_pixels, rows_of_messages};
use crate::locked::locked;
use crate::pipeline::{Event, GrowingPicture, Monitor};

/// Between two pictures, at least.
const INTERVAL: Duration = Duration::from_millis(500);
/// How long tev may take to answer, and then to take the last picture.
const PATIENCE: Duration = Duration::from_secs(5);

/// Where tev listens.
#[derive(Clone, Debug)]
pub(super) struct TevAddress(String);

impl TevAddress {
    /// `HOST:PORT`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once(':').filter(|(host, _)| !host.is_empty());
        match parts.and_then(|(_, port)| port.parse::<u16>().ok()).filter(|port| *port > 0) {
            Some(_) => Ok(Self(text.to_owned())),
            None => {
                Err("write a host and a port, for example 127.0.0.1:14158, where tev listens by default".to_owned())
            }
        }
    }

    fn connect(&self) -> io::Result<TcpStream> {
        let mut failure = io::Error::other("the host has no address");
        for address in self.0.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => return Ok(stream),
                Err(reason) => failure = reason,
            }
        }
        Err(failure)
    }
}

/// Tells the user, and shows tev the picture.
pub(super) struct TevMonitor<'a> {
    terminal: &'a TerminalMonitor,
    develop: DevelopSettings,
    line: Arc<Line>,
    /// Whether it was said that there is no picture.
    is_said: Mutex<bool>,
}

/// What goes from the render to the thread that sends it.
struct Line {
    address: TevAddress,
    /// The render, as tev names its images.
    name: String,
    /// Whether warnings are kept from the user.
    quiet: bool,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// What is to be sent next. What comes before it is sent takes its place.
    next: Option<Images>,
    /// Whether nothing comes after it.
    is_last: bool,
    /// Whether the thread is done, because all is sent or because it cannot be.
    is_over: bool,
}

/// The images by their names.
type Images = Vec<(&'static str, Planes)>;

impl<'a> TevMonitor<'a> {
    /// Connects to tev, while the render begins.
    pub(super) fn new(
        terminal: &'a TerminalMonitor,
        (address, quiet): (&TevAddress, bool),
        name: &str,
        develop: &DevelopSettings,
    ) -> Self {
        let (address, name) = (address.clone(), name.to_owned());
        let line = Arc::new(Line { address, name, quiet, state: Mutex::default(), changed: Condvar::new() });
        let sender = Arc::clone(&line);
        if let Err(reason) = thread::Builder::new().spawn(move || sender.send_all()) {
            line.give_up(&reason);
        }
        let develop = DevelopSettings { colour_space: ColourSpace::Srgb, ..develop.clone() };
        Self { terminal, develop, line, is_said: Mutex::new(false) }
    }

    /// Waits until tev has the last picture.
    pub(super) fn finish(&self) {
        let Line { state, changed, .. } = &*self.line;
        let mut now = locked(state);
        now.is_last = true;
        changed.notify_all();
        let waited = changed.wait_timeout_while(now, PATIENCE, |state| !state.is_over);
        // A thread that has panicked sends nothing.
        let is_over = waited.is_ok_and(|(state, _)| state.is_over);
        if !is_over {
            let reason = format!("it has not taken the last picture within {} s", PATIENCE.as_secs());
            self.line.give_up(&reason);
        }
    }

    fn show(&self, picture: &GrowingPicture<'_>) {
        let mut images = Images::new();
        match develop_linear(picture.raw, &self.develop) {
            Ok((planes, _)) => images.push(("image", planes)),
            Err(invalid) => {
                if !std::mem::replace(&mut *locked(&self.is_said), true) {
                    let reason = format!("tev only shows electrons, since they cannot be developed: {invalid}");
                    self.terminal.report(Event::Warning(&reason));
                }
            }
        }
        images.push(("electrons", picture.electrons.clone()));
        let mut state = locked(&self.line.state);
        if !state.is_over {
            state.next = Some(images);
            self.line.changed.notify_all();
        }
    }
}

impl Monitor for TevMonitor<'_> {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::PictureGrows(picture) => self.show(picture),
            Event::Warning(_)
            | Event::TraceBegins { .. }
            | Event::Traced(_)
            | Event::PassEnds { .. }
            | Event::TraceEnds
            | Event::SetBegins { .. }
            | Event::PictureFails { .. }
            | Event::PictureEnds(_)
            | Event::Waiting { .. }
            | Event::SetEnds => self.terminal.report(event),
        }
    }

    fn is_cancelled(&self) -> bool {
        self.terminal.is_cancelled()
    }

    fn picture_interval(&self) -> Option<Duration> {
        (!locked(&self.line.state).is_over).then_some(INTERVAL)
    }
}

impl Line {
    /// Sends what comes until the last is sent.
    fn send_all(&self) {
        match self.address.connect().and_then(|stream| self.send_all_to(stream)) {
            Ok(()) => _ = self.end(),
            Err(reason) => self.give_up(&reason),
        }
    }

    fn send_all_to(&self, mut stream: TcpStream) -> io::Result<()> {
        let mut shown: Vec<[usize; 2]> = Vec::new();
        while let Some(images) = self.next() {
            let sizes: Vec<_> = images.iter().map(|(_, planes)| [planes.width(), planes.height()]).collect();
            for (number, (kind, planes)) in images.iter().enumerate() {
                let name = format!("{}/{kind}", self.name);
                if shown != sizes {
                    stream.write_all(&new_image(&name, planes, number == 0)?)?;
                }
                for rows in rows_of_messages(planes) {
                    stream.write_all(&new_pixels(&name, planes, rows)?)?;
                }
            }
            shown = sizes;
        }
        stream.flush()
    }

    /// What is to be sent next, once it is there; `None` after the last.
    fn next(&self) -> Option<Images> {
        let mut state = locked(&self.state);
        loop {
            if let Some(images) = state.next.take() {
                return Some(images);
            }
            if state.is_last || state.is_over {
                return None;
            }
            state = self.changed.wait(state).ok()?;
        }
    }

    /// Nothing more is sent. Whether that was so before.
    fn end(&self) -> bool {
        let mut state = locked(&self.state);
        state.next = None;
        self.changed.notify_all();
        std::mem::replace(&mut state.is_over, true)
    }

    /// Nothing more is sent, which the user is told once.
    fn give_up(&self, reason: &dyn std::fmt::Display) {
        if !self.end() && !self.quiet {
            warning!("tev at {} no longer shows the render, which continues without it: {reason}", self.address.0);
        }
    }
}
