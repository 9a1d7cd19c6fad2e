//! Checkpoints: what a render has traced so far, so that one that is killed goes on where it was.
//!
//! A checkpoint is a file in the output folder, `checkpoint.film` (numbered where a camera moves): a line of JSON that says what
//! is rendered, then the films ([`write_unfinished`]) of the rows that are traced. Those before them are done and lie in
//! `checkpoint.rows` beside it. A checkpoint appears whole or not at all, stays when a render ends before its results are
//! there, and goes with the last of them. Samples have their random numbers by their place in the whole render and sums
//! are exact, so that what goes on gives the bytes of a render in one go.

use photosite_core::{Help, Remedy};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::film::Film;
use crate::integrator::Pilot;
use crate::io::film_file::{add_unfinished, read_samples, write_samples, write_unfinished};
use crate::io::output::{Sink, write_whole};
use crate::{Error, Invalid, Result};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::file_names::named;
use super::provenance::difference;
use super::strips::Strips;
use super::throttle::Throttle;

const STEM: &str = "checkpoint";
/// The kinds of its two files.
const FILM: &str = "film";
const ROWS: &str = "rows";
/// Bytes of the longest first line.
const LONGEST_HEADER: u64 = 1 << 24;

/// The first line.
#[derive(Deserialize, Serialize)]
struct Header {
    /// Seconds that were spent on it.
    elapsed_s: f64,
    /// Whether the film of a pilot follows that of the picture.
    has_pilot: bool,
    /// Whether what the pilot wants follows it; earlier versions left it out.
    #[serde(default)]
    has_wanted: bool,
    /// Whether it is of a part of a render, of which the sums are kept of rows that are done.
    is_part: bool,
    /// The first sample of every pixel, and the one after the last.
    samples: [u32; 2],
    /// The first row of the film, before which all are done, and the one after its last; the same where no film follows.
    rows: [usize; 2],
    /// Everything that decides what is traced.
    provenance: Map<String, Value>,
}

/// The checkpoints of one picture.
pub(super) struct Checkpoints<'a> {
    path: PathBuf,
    rows_path: PathBuf,
    is_part: bool,
    samples: [u32; 2],
    /// Whether another render's may be replaced.
    force: bool,
    provenance: &'a Map<String, Value>,
    due: Throttle,
    /// The file of the rows that are done, to be synced before a checkpoint tells of them.
    rows: Option<File>,
}

/// What a checkpoint holds.
pub(super) struct Resumed {
    /// The first row that has not all its samples.
    pub(super) first_row: usize,
    /// Time that was spent on it.
    pub(super) elapsed: Duration,
    /// The films of the strip from that row on.
    pub(super) films: Option<SavedFilms>,
}

/// The films of a strip that was under way.
pub(super) struct SavedFilms {
    path: PathBuf,
    from: BufReader<File>,
    has_pilot: bool,
    has_wanted: bool,
}

impl SavedFilms {
    /// Fills empty films with them.
    pub(super) fn fill(mut self, film: &mut Film, pilot: Option<&mut Pilot>) -> Result<()> {
        let (path, from) = (&self.path, &mut self.from);
        if self.has_pilot != pilot.is_some() {
            return Err(damaged(path, &"it has not the films that this render has"));
        }
        let read = || -> Result<(), Invalid> {
            add_unfinished(film, &mut *from)?;
            let Some(pilot) = pilot else { return Ok(()) };
            add_unfinished(&mut pilot.film, &mut *from)?;
            if self.has_wanted {
                pilot.wanted = read_samples([film.width(), film.height()], &mut *from)?;
            }
            Ok(())
        };
        read().map_err(|invalid| damaged(path, &invalid.message))
    }
}

fn damaged(path: &Path, what: &dyn std::fmt::Display) -> Error {
    let invalid = Invalid::new("", format!("is a damaged checkpoint: {what}"));
    invalid.help("remove it, and the render starts anew").in_file(path)
}

impl<'a> Checkpoints<'a> {
    pub(super) fn new(
        folder: &Path,
        is_forced: bool,
        number: Option<u32>,
        is_part: bool,
        samples: Range<u32>,
        provenance: &'a Map<String, Value>,
        interval: Option<Duration>,
    ) -> Self {
        let [path, rows_path] = [FILM, ROWS].map(|kind| folder.join(named(STEM, number, kind)));
        let samples = [samples.start, samples.end];
        let (force, due) = (is_forced, Throttle::every(interval));
        Self { path, rows_path, is_part, samples, force, provenance, due, rows: None }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Where rows are kept that are done.
    pub(super) fn rows_path(&self) -> &Path {
        &self.rows_path
    }

    /// Reads the checkpoint, if there is one. One of another render, or whose films are not those of a strip, is refused.
    pub(super) fn resume(&self, strips: Strips) -> Result<Option<Resumed>> {
        let path = &self.path;
        let file = match File::open(path) {
            Ok(file) => file,
            Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(reason) => return Err(Error::io(path, "read", reason)),
        };
        let mut from = BufReader::new(file);
        let mut line = Vec::new();
        from.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut line).map_err(|reason| damaged(path, &reason))?;
        let header: Header = serde_json::from_slice(&line).map_err(|error| damaged(path, &error))?;
        let [earlier, now] = [&header.provenance, self.provenance];
        let ([from_sample, to_sample], [first_row, end]) = (header.samples, header.rows);
        let has_films = first_row < end;
        let another = if earlier.get("fingerprint") != now.get("fingerprint") {
            let [earlier, now] = [earlier, now].map(|provenance| Value::Object(provenance.clone()));
            Some(difference(&earlier, &now).to_owned())
        } else if header.is_part != self.is_part {
            Some(format!("it is of {}", if header.is_part { "a part" } else { "a whole picture" }))
        } else if header.samples != self.samples {
            Some(format!("it has the samples {from_sample}..{to_sample}"))
        } else if has_films && strips.from(first_row).next() != Some(first_row..end) {
            Some(format!("it has the rows {first_row}..{end}, as another film memory gives"))
        } else {
            None
        };
        match another {
            Some(_) if self.force => return Ok(None),
            Some(difference) => {
                let message = format!("is the checkpoint of another render: {difference}");
                let help = Help::any([
                    "undo the change to go on with it".into(),
                    Remedy::StartAnew,
                    Remedy::Elsewhere("another folder".to_owned()),
                ]);
                return Err(Invalid::new("", message).help(help).in_file(path));
            }
            None => {}
        }
        let films = has_films.then(|| {
            let Header { has_pilot, has_wanted, .. } = header;
            SavedFilms { path: path.clone(), from, has_pilot, has_wanted }
        });
        let elapsed = Duration::try_from_secs_f64(header.elapsed_s).map_err(|error| damaged(path, &error))?;
        Ok(Some(Resumed { first_row, elapsed, films }))
    }

    /// The file of the rows that are done, of which there are so many bytes.
    pub(super) fn open_rows(&mut self, bytes: u64) -> Result<File> {
        let file = self.rows_file(bytes)?;
        self.rows = Some(file.try_clone().map_err(|reason| Error::io(&self.rows_path, "write", reason))?);
        Ok(file)
    }

    fn rows_file(&self, bytes: u64) -> Result<File> {
        let path = &self.rows_path;
        if bytes == 0 {
            let file = File::options().read(true).write(true).create(true).truncate(true).open(path);
            return file.map_err(|reason| Error::io(path, "write", reason));
        }
        let file = File::options().read(true).write(true).open(path);
        let file = file.map_err(|reason| damaged(&self.path, &format!("cannot open {}: {reason}", path.display())))?;
        let length = file.metadata().map_err(|reason| Error::io(path, "read", reason))?.len();
        if length < bytes {
            return Err(damaged(&self.path, &format!("{} holds {length} bytes of {bytes}", path.display())));
        }
        Ok(file)
    }

    /// Writes one of films under way if it is time for it.
    pub(super) fn keep(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> Result<()> {
        if !self.due.is_now() {
            return Ok(());
        }
        let start = Instant::now();
        self.keep_now(film, pilot, elapsed)?;
        self.due.done_since(start);
        Ok(())
    }

    /// Writes one at once, if any are to be written at all.
    pub(super) fn keep_now(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> Result<()> {
        if self.due.is_never() {
            return Ok(());
        }
        let Range { start: first, end } = film.picture_rows();
        self.write([first, end], pilot.is_some(), elapsed, |mut to| {
            write_unfinished(film, &mut to)?;
            let Some(pilot) = pilot else { return Ok(()) };
            write_unfinished(&pilot.film, &mut to)?;
            write_samples([film.width(), film.height()], &pilot.wanted, &mut to)
        })
    }

    /// Tells that all rows before this one are in the file of those that are done.
    pub(super) fn keep_rows(&self, first: usize, elapsed: Duration) -> Result<()> {
        self.write([first, first], false, elapsed, |_| Ok(()))
    }

    fn write(
        &self,
        rows: [usize; 2],
        has_pilot: bool,
        elapsed: Duration,
        films: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>,
    ) -> Result<()> {
        if let Some(rows) = &self.rows {
            rows.sync_data().map_err(|reason| Error::io(&self.rows_path, "write", reason))?;
        }
        let header = Header {
            elapsed_s: elapsed.as_secs_f64(),
            has_pilot,
            has_wanted: has_pilot,
            is_part: self.is_part,
            samples: self.samples,
            rows,
            provenance: self.provenance.clone(),
        };
        write_whole(&self.path, |mut to| {
            serde_json::to_writer(&mut to, &header)?;
            to.write_all(b"\n")?;
            films(to)
        })
    }
}

/// The files of checkpoints in a folder, of one of their two kinds.
fn all(folder: &Path, kind: &str) -> impl Iterator<Item = PathBuf> {
    let is_one = move |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let numbered =
            name.strip_suffix(kind).and_then(|rest| rest.strip_prefix(STEM)).and_then(|r| r.strip_suffix('.'));
        numbered.is_some_and(|rest| {
            rest.is_empty() || rest.strip_prefix('-').is_some_and(|number| number.parse::<u32>().is_ok())
        })
    };
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).filter(is_one)
}

/// Whether a render was broken off in a folder.
pub(crate) fn are_in(folder: &Path) -> bool {
    all(folder, FILM).next().is_some()
}

/// Removes all of a folder: rows after what says that they are there, should this be killed on the way.
pub(crate) fn remove(folder: &Path) -> Result<()> {
    let mut files = all(folder, FILM).chain(all(folder, ROWS));
    files.try_for_each(|path| fs::remove_file(&path).map_err(|reason| Error::io(&path, "remove", reason)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_as_long_as_a_checkpoint_speaks_of_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let rows: Vec<_> = (0..20).map(|number| folder.path().join(named(STEM, Some(number), ROWS))).collect();
        rows.iter().for_each(|path| fs::write(path, "rows").expect("written"));
        // A folder, which cannot be removed as a file can.
        let film = folder.path().join(named(STEM, Some(10), FILM));
        fs::create_dir(&film).expect("made");
        assert!(are_in(folder.path()) && remove(folder.path()).is_err());
        assert!(rows.iter().all(|path| path.exists()));
        fs::remove_dir(&film).expect("removed");
        assert!(!are_in(folder.path()) && remove(folder.path()).is_ok());
        assert!(!rows.iter().any(|path| path.exists()));
    }
}
