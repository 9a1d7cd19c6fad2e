//! Checkpoints: the light that a render has traced so far, so that one that is killed goes on where it was.
//!
//! A checkpoint is a file in the output folder, `checkpoint.film` (numbered where a camera moves): a line of JSON that
//! says what is rendered, then the films ([`write_unfinished`]) of the rows that are traced, then a line with the
//! checksum of all that. Rows before those are done and lie in `checkpoint.rows` beside it, whose checksum the first
//! line has. A checkpoint appears whole or not at all, stays when a render ends before its results are there, and goes
//! with the last of them; the one before it, `checkpoint.film.before`, stays as long, in case that the disk damages the
//! newer one. Samples have their random numbers by their place in the whole render and sums are exact, so that what
//! goes on gives the bytes of a render in one go.

use photosite_core::{Help, Remedy, input};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, ErrorKind, IntoInnerError, Read, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use photosite_core::output::write_beside;
use photosite_core::{Error, Invalid, Result};
use photosite_files::checksum::{GrowingSum, Summing, check_last_line};
use photosite_files::film_file::{add_unfinished, read_samples, write_samples, write_unfinished};
use photosite_transport::film::Film;
use photosite_transport::integrator::Pilot;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::file_names::named;
use super::provenance::{FINGERPRINT, difference};
use super::throttle::Throttle;
use crate::prepare::strips::Strips;

const STEM: &str = "checkpoint";
/// Kinds of the files of a checkpoint.
const FILM: &str = "film";
const BEFORE: &str = "film.before";
const ROWS: &str = "rows";
/// Bytes of the longest first line.
const LONGEST_HEADER: u64 = 1 << 24;

/// First line of a checkpoint.
#[derive(Deserialize, Serialize)]
struct Header {
    /// Seconds that were spent on the render.
    elapsed_s: f64,
    /// Whether the film of a pilot follows that of the image, and the samples that it wants.
    has_pilot: bool,
    /// Whether the checkpoint is of a part of a render, of which the sums of completed rows are kept.
    is_part: bool,
    /// The first sample of every pixel, and the one after the last.
    samples: [u32; 2],
    /// The first row of the film, before which all are done, and the one after its last; the same where no film
    /// follows.
    rows: [usize; 2],
    /// CRC-32 of the file of the rows that are done, up to where the film begins; `None` where none lie in a file.
    done_crc32: Option<String>,
    /// Provenance: everything that decides what is traced.
    provenance: Map<String, Value>,
}

/// Checkpoints of one image.
pub(crate) struct Checkpoints<'a> {
    path: PathBuf,
    /// Path of the checkpoint before the last.
    before_path: PathBuf,
    rows_path: PathBuf,
    is_part: bool,
    samples: [u32; 2],
    /// Whether a checkpoint of another render may be replaced.
    force: bool,
    provenance: &'a Map<String, Value>,
    throttle: Throttle,
    rows: Option<DoneRows>,
}

/// The file of the rows that are done, to be synced before a checkpoint counts them.
struct DoneRows {
    file: File,
    /// Length of the file, bytes, when all rows before one are done.
    bytes_before: Box<dyn Fn(usize) -> u64 + Send>,
    sum: GrowingSum,
}

/// Contents of a checkpoint.
pub(crate) struct Resumed {
    /// Rows of the film that was under way; empty where a strip was just done. All rows before these are done.
    pub rows: Range<usize>,
    /// Time that was spent on the render.
    pub elapsed: Duration,
    /// The films of the strip from that row on.
    pub films: Option<SavedFilms>,
    /// Warning about the checkpoint, if there is one.
    pub warning: Option<String>,
    /// Path of the file that the checkpoint was read from.
    pub path: PathBuf,
}

/// Reason why a render cannot go on from a checkpoint.
enum Unusable {
    /// Checkpoint that does not exist.
    Missing,
    /// Checkpoint whose bytes are not those that were written.
    Damaged(Error),
    /// Checkpoint of another render, or one that cannot be read.
    Other(Error),
}

/// The films of a strip that was under way.
pub(crate) struct SavedFilms {
    path: PathBuf,
    from: BufReader<File>,
    has_pilot: bool,
}

impl SavedFilms {
    /// Fills empty films with those of the checkpoint.
    pub(crate) fn fill(mut self, film: &mut Film, pilot: Option<&mut Pilot>) -> Result<()> {
        let (path, from) = (&self.path, &mut self.from);
        if self.has_pilot != pilot.is_some() {
            return Err(damaged(path, &"it does not have the films of this render"));
        }
        let read = || -> Result<(), Invalid> {
            add_unfinished(film, &mut *from)?;
            let Some(pilot) = pilot else { return Ok(()) };
            add_unfinished(&mut pilot.film, &mut *from)?;
            pilot.wanted = read_samples([film.width(), film.height()], &mut *from)?;
            Ok(())
        };
        read().map_err(|invalid| damaged(path, &invalid.message))
    }
}

fn damaged(path: &Path, what: &dyn std::fmt::Display) -> Error {
    let invalid = Invalid::new("", format!("is a damaged checkpoint: {what}"));
    invalid.help("remove it, and the render starts again").in_file(path)
}

impl<'a> Checkpoints<'a> {
    pub(crate) fn new(
        folder: &Path,
        is_forced: bool,
        number: Option<u32>,
        is_part: bool,
        samples: Range<u32>,
        provenance: &'a Map<String, Value>,
        interval: Option<Duration>,
    ) -> Self {
        let [path, before_path, rows_path] = [FILM, BEFORE, ROWS].map(|kind| folder.join(named(STEM, number, kind)));
        let samples = [samples.start, samples.end];
        let (force, throttle) = (is_forced, Throttle::every(interval));
        Self { path, before_path, rows_path, is_part, samples, force, provenance, throttle, rows: None }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the file of completed rows.
    pub(crate) fn rows_path(&self) -> &Path {
        &self.rows_path
    }

    /// Reads the checkpoint, if there is one, or the one before it where the last is damaged. One of another render, or
    /// whose films are not those of a strip, is refused. `bytes_before` is the length of the file of rows that are done
    /// when all before one are.
    pub(crate) fn resume(&self, strips: &Strips, bytes_before: impl Fn(usize) -> u64) -> Result<Option<Resumed>> {
        let damage = match self.read(&self.path, strips, &bytes_before) {
            Ok(resumed) => return Ok(Some(resumed)),
            Err(Unusable::Other(error)) => return Err(error),
            Err(Unusable::Damaged(error)) => Some(error),
            Err(Unusable::Missing) => None,
        };
        match (self.read(&self.before_path, strips, &bytes_before), damage) {
            (Ok(resumed), None) => Ok(Some(resumed)),
            (Ok(resumed), Some(damage)) => {
                let warning = format!("{damage}, so the render continues from the one before it");
                Ok(Some(Resumed { warning: Some(warning), ..resumed }))
            }
            (Err(Unusable::Missing), None) => Ok(None),
            (Err(_), _) if self.force => Ok(None),
            (Err(_), Some(damage)) | (Err(Unusable::Damaged(damage) | Unusable::Other(damage)), None) => Err(damage),
        }
    }

    fn read(&self, path: &Path, strips: &Strips, bytes_before: &dyn Fn(usize) -> u64) -> Result<Resumed, Unusable> {
        let unreadable = |reason| Unusable::Other(Error::io(path, "read", reason));
        let damaged = |what: &dyn std::fmt::Display| Unusable::Damaged(damaged(path, what));
        let mut file = match input::open(path) {
            Ok(file) => file,
            Err(reason) if reason.kind() == ErrorKind::NotFound => return Err(Unusable::Missing),
            Err(reason) => return Err(unreadable(reason)),
        };
        if !check_last_line(&mut file).map_err(unreadable)? {
            return Err(damaged(&"it does not end with the checksum of what is in it"));
        }
        let mut from = BufReader::new(file);
        let mut line = Vec::new();
        from.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut line).map_err(|reason| damaged(&reason))?;
        let header: Header = serde_json::from_slice(&line).map_err(|error| damaged(&error))?;
        let [earlier, now] = [&header.provenance, self.provenance];
        let ([from_sample, to_sample], [first_row, end]) = (header.samples, header.rows);
        let has_films = first_row < end;
        let another = if earlier.get(FINGERPRINT) != now.get(FINGERPRINT) {
            let [earlier, now] = [earlier, now].map(|provenance| Value::Object(provenance.clone()));
            Some(difference(&earlier, &now).to_owned())
        } else if header.is_part != self.is_part {
            Some(format!("it is of {}", if header.is_part { "a part" } else { "a whole image" }))
        } else if header.samples != self.samples {
            Some(format!("it has the samples {from_sample}..{to_sample}"))
        } else if has_films && !strips.hold(&(first_row..end)) {
            Some(format!("its film has the rows {first_row}..{end}, more than fits into the film memory"))
        } else {
            None
        };
        match another {
            Some(_) if self.force => return Err(Unusable::Missing),
            Some(difference) => {
                let message = format!("is the checkpoint of another render: {difference}");
                let help = Help::any([
                    "undo the change to continue from it".into(),
                    Remedy::StartAnew,
                    Remedy::Elsewhere("another folder".to_owned()),
                ]);
                return Err(Unusable::Other(Invalid::new("", message).help(help).in_file(path)));
            }
            None => {}
        }
        if first_row > 0 {
            self.check_rows(bytes_before(first_row), header.done_crc32.as_deref()).map_err(|what| damaged(&what))?;
        }
        let films = has_films.then(|| SavedFilms { path: path.to_owned(), from, has_pilot: header.has_pilot });
        let elapsed = Duration::try_from_secs_f64(header.elapsed_s).map_err(|error| damaged(&error))?;
        let rows = first_row..end;
        Ok(Resumed { rows, elapsed, films, warning: None, path: path.to_owned() })
    }

    /// Checks the file of completed rows, which must have `bytes` bytes and this checksum; the error says what is
    /// wrong.
    fn check_rows(&self, bytes: u64, sum: Option<&str>) -> Result<(), String> {
        let path = self.rows_path.display();
        let mut file = input::open(&self.rows_path).map_err(|reason| format!("cannot open {path}: {reason}"))?;
        let length = file.metadata().map_err(|reason| format!("cannot read {path}: {reason}"))?.len();
        if length < bytes {
            return Err(format!("{path} holds {length} bytes of {bytes}"));
        }
        let found = GrowingSum::default().up_to(bytes, &mut file);
        let found = found.map_err(|reason| format!("cannot read {path}: {reason}"))?;
        if sum != Some(&*found) {
            return Err(format!("the checksum of {path} does not match what was written"));
        }
        Ok(())
    }

    /// The file of the rows that are done, which all before `first_row` are.
    pub(crate) fn open_rows(
        &mut self,
        first_row: usize,
        bytes_before: impl Fn(usize) -> u64 + Send + 'static,
    ) -> Result<File> {
        let path = &self.rows_path;
        let is_new = first_row == 0;
        let file = input::open_to_change(path, is_new);
        let file = file.map_err(|reason| Error::io(path, "write", reason))?;
        let clone = file.try_clone().map_err(|reason| Error::io(path, "write", reason))?;
        self.rows = Some(DoneRows { file: clone, bytes_before: Box::new(bytes_before), sum: GrowingSum::default() });
        Ok(file)
    }

    /// Writes a checkpoint of films under way if it is time for it.
    pub(crate) fn keep(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> Result<()> {
        if !self.throttle.is_now() {
            return Ok(());
        }
        let start = Instant::now();
        let kept = self.keep_now(film, pilot, elapsed);
        self.throttle.done_since(start);
        kept
    }

    /// Writes a checkpoint at once, if any are to be written at all.
    pub(crate) fn keep_now(&mut self, film: &Film, pilot: Option<&Pilot>, elapsed: Duration) -> Result<()> {
        if self.throttle.is_never() {
            return Ok(());
        }
        let Range { start: first, end } = film.image_rows();
        self.write([first, end], pilot.is_some(), elapsed, |mut to| {
            write_unfinished(film, &mut to)?;
            let Some(pilot) = pilot else { return Ok(()) };
            write_unfinished(&pilot.film, &mut to)?;
            write_samples([film.width(), film.height()], &pilot.wanted, &mut to)
        })
    }

    /// Tells that all rows before this one are in the file of those that are done.
    pub(crate) fn keep_rows(&mut self, first: usize, elapsed: Duration) -> Result<()> {
        self.write([first, first], false, elapsed, |_| Ok(()))
    }

    fn write(
        &mut self,
        rows: [usize; 2],
        has_pilot: bool,
        elapsed: Duration,
        films: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<()> {
        let sum_of_rows = |done: &mut DoneRows| {
            done.file.sync_data()?;
            done.sum.up_to((done.bytes_before)(rows[0]), &mut done.file)
        };
        let done_crc32 = self.rows.as_mut().map(sum_of_rows).transpose();
        let header = Header {
            elapsed_s: elapsed.as_secs_f64(),
            has_pilot,
            is_part: self.is_part,
            samples: self.samples,
            rows,
            done_crc32: done_crc32.map_err(|reason| Error::io(&self.rows_path, "write", reason))?,
            provenance: self.provenance.clone(),
        };
        let next = write_beside(&self.path, |to| {
            // Films come number by number; sums take whole buffers.
            let mut to = BufWriter::new(Summing::new(to));
            serde_json::to_writer(&mut to, &header)?;
            to.write_all(b"\n")?;
            films(&mut to)?;
            to.into_inner().map_err(IntoInnerError::into_error)?.write_last_line()
        })?;
        match fs::rename(&self.path, &self.before_path) {
            Err(reason) if reason.kind() != ErrorKind::NotFound => Err(Error::io(&self.before_path, "write", reason)),
            Ok(()) | Err(_) => next.put_in_place(&self.path),
        }
    }
}

/// The files of checkpoints in a folder, of one of their kinds.
fn all(folder: &Path, kind: &str) -> impl Iterator<Item = PathBuf> {
    let is_one = move |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let numbered =
            name.strip_suffix(kind).and_then(|rest| rest.strip_prefix(STEM)).and_then(|r| r.strip_suffix('.'));
        numbered.is_some_and(|rest| {
            rest.is_empty() || rest.strip_prefix('-').is_some_and(|number| number.parse::<u32>().is_ok())
        })
    };
    input::entries(folder).into_iter().flatten().flatten().map(|entry| entry.path()).filter(is_one)
}

/// Whether a render was broken off in a folder.
pub fn are_in(folder: &Path) -> bool {
    [FILM, BEFORE].into_iter().any(|kind| all(folder, kind).next().is_some())
}

/// Removes all checkpoints of a folder: rows after what says that they are there, should this be killed on the way.
pub(crate) fn remove(folder: &Path) -> Result<()> {
    let mut files = [BEFORE, FILM, ROWS].into_iter().flat_map(|kind| all(folder, kind));
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
