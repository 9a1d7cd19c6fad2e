//! Checkpoints: what a render has traced so far, so that one that is killed goes on where it was.
//!
//! A checkpoint is a file in the output folder, `checkpoint.film` (numbered where a camera moves): a line of JSON that says what
//! is rendered, then the films ([`write_unfinished`]). It appears whole or not at all, stays when a render ends before
//! its results are there, and goes with the last of them. Samples have their random numbers by their place in the whole
//! render and sums are exact, so that what goes on gives the bytes of a render in one go.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use photosite::film::Film;
use photosite::io::film_file::{add_unfinished, write_unfinished};
use photosite::io::output::write_whole;
use photosite::{Error, Invalid, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::fingerprint::difference;
use super::output_folder::{OutputFolder, named};

/// A checkpoint is written after this many times as long as the last one took: large films take a while.
const PATIENCE: u32 = 20;
const STEM: &str = "checkpoint";
const KIND: &str = "film";
/// Bytes of the longest first line.
const LONGEST_HEADER: u64 = 1 << 24;

/// The first line.
#[derive(Deserialize, Serialize)]
struct Header {
    /// Seconds that were spent on it.
    elapsed_s: f64,
    /// Whether the film of a pilot follows that of the picture.
    has_pilot: bool,
    /// The first sample of every pixel, and the one after the last.
    samples: [u32; 2],
    /// Everything that decides what is traced.
    makings: Map<String, Value>,
}

/// The checkpoints of one film.
pub(super) struct Checkpoints<'a> {
    path: PathBuf,
    samples: [u32; 2],
    /// Whether another render's may be replaced.
    force: bool,
    makings: &'a Map<String, Value>,
    interval: Option<Duration>,
    /// When the next one is due.
    due: Option<Instant>,
}

impl<'a> Checkpoints<'a> {
    pub(super) fn new(
        folder: &OutputFolder,
        number: Option<u32>,
        samples: Range<u32>,
        makings: &'a Map<String, Value>,
        interval: Option<Duration>,
    ) -> Self {
        let due = interval.and_then(|interval| Instant::now().checked_add(interval));
        let path = folder.path().join(named(STEM, number, KIND));
        Self { path, samples: [samples.start, samples.end], force: folder.is_forced(), makings, interval, due }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Fills empty films with those of the checkpoint, if there is one, and returns the time that was spent on them. One of
    /// another render is refused.
    pub(super) fn resume(&self, film: &mut Film, pilot: Option<&mut Film>) -> Result<Option<Duration>> {
        let file = match File::open(&self.path) {
            Ok(file) => file,
            Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(reason) => return Err(Error::io(&self.path, "read", reason)),
        };
        let mut from = BufReader::new(file);
        let damaged = |what: &dyn std::fmt::Display| {
            let invalid = Invalid::new("", format!("is a damaged checkpoint: {what}"));
            invalid.help("remove it, and the render starts anew").in_file(&self.path)
        };
        let mut line = Vec::new();
        from.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut line).map_err(|reason| damaged(&reason))?;
        let header: Header = serde_json::from_slice(&line).map_err(|error| damaged(&error))?;
        let [earlier, now] = [&header.makings, self.makings];
        let another = if earlier.get("fingerprint") != now.get("fingerprint") {
            let [earlier, now] = [earlier, now].map(|makings| Value::Object(makings.clone()));
            Some(difference(&earlier, &now).to_owned())
        } else {
            let [from, to] = header.samples;
            (header.samples != self.samples).then(|| format!("it has the samples {from}..{to}"))
        };
        match another {
            Some(_) if self.force => return Ok(None),
            Some(difference) => {
                let message = format!("is the checkpoint of another render: {difference}");
                let help =
                    "undo the change to go on with it, add --force to start anew, or choose another folder with -o";
                return Err(Invalid::new("", message).help(help).in_file(&self.path));
            }
            None => {}
        }
        if header.has_pilot != pilot.is_some() {
            return Err(damaged(&"it has not the films that this render has"));
        }
        let mut read = |film: &mut Film| add_unfinished(film, &mut from).map_err(|invalid| damaged(&invalid.message));
        read(film)?;
        pilot.map_or(Ok(()), read)?;
        Duration::try_from_secs_f64(header.elapsed_s).map(Some).map_err(|error| damaged(&error))
    }

    /// Writes one if it is time for it.
    pub(super) fn keep(&mut self, film: &Film, pilot: Option<&Film>, elapsed: Duration) -> Result<()> {
        let Some(interval) = self.interval.filter(|_| self.due.is_some_and(|due| Instant::now() >= due)) else {
            return Ok(());
        };
        let start = Instant::now();
        let header = Header {
            elapsed_s: elapsed.as_secs_f64(),
            has_pilot: pilot.is_some(),
            samples: self.samples,
            makings: self.makings.clone(),
        };
        write_whole(&self.path, |mut to| {
            serde_json::to_writer(&mut to, &header)?;
            to.write_all(b"\n")?;
            write_unfinished(film, &mut to)?;
            pilot.map_or(Ok(()), |pilot| write_unfinished(pilot, &mut to))
        })?;
        let now = Instant::now();
        self.due = now.checked_add(interval.max((now - start).saturating_mul(PATIENCE)));
        Ok(())
    }
}

/// The checkpoints in a folder.
fn all(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let is_one = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.strip_prefix(STEM).and_then(|rest| rest.strip_suffix(KIND)).is_some_and(|rest| {
            rest == "."
                || rest.strip_prefix('-').and_then(|r| r.strip_suffix('.')).is_some_and(|n| n.parse::<u32>().is_ok())
        })
    };
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).filter(is_one)
}

/// Whether a render was broken off in a folder.
pub(super) fn are_in(folder: &Path) -> bool {
    all(folder).next().is_some()
}

/// Removes all of a folder.
pub(super) fn remove(folder: &Path) -> Result<()> {
    all(folder).try_for_each(|path| fs::remove_file(&path).map_err(|reason| Error::io(&path, "remove", reason)))
}
