//! The shards of a data set that may still grow.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde_json::Value;

use super::container::{Container, measure, write_files};
use super::mcap_file::{McapFile, check_cameras};
use super::parquet_file::ParquetFile;
use super::sample::{Samples, SetFacts};
use super::settings::{Settings, ShardFormat, ShardSize, Wanted};
use super::tar_file::TarFile;
use super::wids::write_index;
use crate::dataset::finished::frames_of_manifest;
use crate::dataset::identity::{IDENTITY, OF_PART, read_identity};
use crate::dataset::presence::{damage, picture};
use crate::io::lock::Lock;
use crate::report::{Look, REPORT};
use crate::{Invalid, Result};

/// How far the shards of a folder are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Shards that this process has written.
    pub written: u32,
    /// Shards that are there.
    pub present: u32,
    /// Shards that are not there yet; not known before a frame tells how many there will be.
    pub left: Option<u32>,
}

/// The shards of a data set in a folder. All of its methods may be called by several threads, and by several processes.
pub struct Shards {
    samples: Samples,
    wanted: Wanted,
    folder: PathBuf,
    state: Mutex<State>,
    warn: Box<dyn Fn(&str) + Send + Sync>,
}

#[derive(Default)]
struct State {
    settings: Option<Settings>,
    /// The first frame of each shard that was missing when it was looked at; of those that are there, none.
    waits_for: Vec<Option<u32>>,
    warned: BTreeSet<String>,
    written: u32,
}

impl Shards {
    /// The shards of the data set in the folder `dataset`, which has `frames` frames, or as many as its manifest says.
    /// What they leave out is said by `warn`, each once.
    ///
    /// # Errors
    ///
    /// A folder that holds something else, or shards of another data set or of another size.
    pub fn open(
        dataset: &Path,
        frames: Option<u32>,
        format: ShardFormat,
        folder: &Path,
        size: ShardSize,
        warn: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Self> {
        let path = dataset.join(IDENTITY);
        if !path.is_file() {
            let help = "give the folder that `photosite dataset` fills";
            return Err(Invalid::new("", "does not contain a data set").help(help).in_file(dataset));
        }
        let identity = read_identity(&path)?;
        if identity.get(OF_PART).is_some_and(|part| !part.is_null()) {
            let help = "merge the parts with `photosite merge`, and give the folder that it fills";
            return Err(Invalid::new("", "contains a part of every picture, but no finished pictures")
                .help(help)
                .in_file(dataset));
        }
        let frames = frames.map_or_else(|| frames_of_manifest(dataset), Ok)?;
        let samples = Samples::new(dataset, SetFacts::of_identity(&identity, frames, &path)?);
        if format == ShardFormat::Mcap {
            check_cameras(&samples.facts().cameras).map_err(|invalid| invalid.in_file(&path))?;
        }
        let fingerprint = identity.get("fingerprint").and_then(Value::as_str).unwrap_or_default().to_owned();
        let wanted = Wanted { format, fingerprint, frames, size };
        let mut state = State::default();
        if let Some(settings) = wanted.recorded(folder)? {
            state.know(settings);
        }
        Ok(Self { samples, wanted, folder: folder.to_owned(), state: Mutex::new(state), warn: Box::new(warn) })
    }

    /// Where the shards are.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A picture of this frame is there now: writes the shard that it is in, if all of its pictures are.
    pub fn frame_done(&self, number: u32) -> Result<()> {
        let Some(settings) = self.settings(number..number.saturating_add(1))? else { return Ok(()) };
        self.write_if_whole(&settings, number / settings.frames_per_shard)
    }

    /// Writes all shards whose pictures are there, and the index when there is no other.
    pub fn finish(&self) -> Result<Progress> {
        let Some(settings) = self.settings(0..self.wanted.frames)? else { return Ok(Progress::default()) };
        (0..settings.shards()).try_for_each(|shard| self.write_if_whole(&settings, shard))?;
        let mut present = 0;
        for path in (0..settings.shards()).map(|shard| self.path(shard, 0)).filter(|path| path.exists()) {
            present += 1;
            let lock = self.lock(&path);
            if lock.exists() {
                // Of a dead process: it leaves with who takes it. A living one is about to let go of it.
                drop(Lock::try_take(&lock)?);
            }
        }
        let left = settings.shards() - present;
        if left == 0 && settings.format == ShardFormat::Webdataset {
            write_index(&self.folder, settings.frames as usize * self.samples.facts().cameras.len())?;
        }
        Ok(Progress { written: self.state().written, present, left: Some(left) })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is decided, for which one of these frames must be there.
    fn settings(&self, mut frames: std::ops::Range<u32>) -> Result<Option<Settings>> {
        if let Some(settings) = &self.state().settings {
            return Ok(Some(settings.clone()));
        }
        let Some(number) = frames.find(|&number| self.is_there(number)) else { return Ok(None) };
        // What cannot be laid out shows before there is a folder.
        let samples = self.samples.of_frames(number..number + 1);
        let bytes = match self.wanted.format {
            ShardFormat::Webdataset => measure::<TarFile>(samples, &self.folder),
            ShardFormat::Parquet => measure::<ParquetFile>(samples, &self.folder),
            ShardFormat::Mcap => measure::<McapFile>(samples, &self.folder),
        }?;
        let settings = self.wanted.decide(&self.folder, bytes)?;
        self.state().know(settings.clone());
        Ok(Some(settings))
    }

    /// Whether all pictures of a frame are there.
    fn is_there(&self, number: u32) -> bool {
        let facts = self.samples.facts();
        let path = |camera: &String| picture(self.samples.dataset(), camera, number);
        // Most that are missing lack their folder.
        facts.cameras.iter().all(|camera| path(camera).join(REPORT).exists())
            && facts.cameras.iter().all(|camera| damage(&path(camera), Look::Sizes).is_none())
    }

    fn write_if_whole(&self, settings: &Settings, shard: u32) -> Result<()> {
        let waits_for = self.state().waits_for[shard as usize];
        let Some(first) = waits_for else { return Ok(()) };
        let frames = settings.frames_of(shard);
        let path = self.path(shard, 0);
        if path.exists() {
            self.state().waits_for[shard as usize] = None;
            return Ok(());
        }
        if let Some(missing) = (first..frames.end).find(|&number| !self.is_there(number)) {
            self.state().waits_for[shard as usize] = Some(missing);
            return Ok(());
        }
        // Who has the lock writes it.
        let Some(_lock) = Lock::try_take(&self.lock(&path))? else { return Ok(()) };
        if !path.exists() {
            match settings.format {
                ShardFormat::Webdataset => self.write::<TarFile>(settings, shard),
                ShardFormat::Parquet => self.write::<ParquetFile>(settings, shard),
                ShardFormat::Mcap => self.write::<McapFile>(settings, shard),
            }?;
            self.state().written += 1;
        }
        self.state().waits_for[shard as usize] = None;
        Ok(())
    }

    fn write<C: Container>(&self, settings: &Settings, shard: u32) -> Result<()> {
        let samples = self.samples.of_frames(settings.frames_of(shard));
        let warn = |what: &str| {
            if self.state().warned.insert(what.to_owned()) {
                (self.warn)(what);
            }
        };
        write_files::<C>(samples, settings.limit(), |part| self.path(shard, part), &warn)
    }

    /// The file of a shard, of which there may be several, whose names are in the order of their pictures.
    fn path(&self, shard: u32, part: usize) -> PathBuf {
        let [before, after] = self.wanted.format.affixes();
        let part = if part == 0 { String::new() } else { format!("_{part:02}") };
        self.folder.join(format!("{before}{shard:06}{part}{after}"))
    }

    fn lock(&self, path: &Path) -> PathBuf {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.folder.join(format!(".{name}.lock"))
    }
}

impl State {
    fn know(&mut self, settings: Settings) {
        self.waits_for = (0..settings.shards()).map(|shard| Some(settings.frames_of(shard).start)).collect();
        self.settings = Some(settings);
    }
}
