//! Shards for training programs, written by those who make the data set.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use clap::Args;

use super::log::{say, warning};
use crate::dataset::{DatasetFolder, ShardFormat, ShardSize, Shards};
use crate::io::output::create_folder;
use crate::pipeline::{Event, Monitor};
use crate::{Error, Result};

/// How large shards are.
#[derive(Args, Clone, Copy)]
pub(super) struct ShardSizeArgs {
    /// Most bytes of a shard, MiB: the number of frames follows from the first one that is there [default: 256].
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "shard_frames")]
    shard_mb: Option<u32>,
    /// Frames of a shard, however large they are.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    shard_frames: Option<u32>,
}

impl ShardSizeArgs {
    pub(super) fn size(self) -> ShardSize {
        ShardSize { mb: self.shard_mb, frames: self.shard_frames }
    }

    /// Whether a size is asked for.
    pub(super) fn is_given(self) -> bool {
        self.shard_mb.is_some() || self.shard_frames.is_some()
    }
}

/// What is laid out while it is made.
#[derive(Args, Clone)]
pub(super) struct LayoutsArgs {
    /// Write shards for training programs to DIR while the data set grows, those whose frames are all there: webdataset,
    /// parquet or mcap, as `photosite layout` writes them. May be given for several formats.
    #[arg(long = "layout", value_name = "FORMAT=DIR")]
    layouts: Vec<WantedLayout>,
    #[command(flatten)]
    size: ShardSizeArgs,
}

/// A format and its folder.
#[derive(Clone)]
struct WantedLayout {
    format: ShardFormat,
    folder: PathBuf,
}

impl FromStr for WantedLayout {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = "write webdataset=DIR, parquet=DIR or mcap=DIR";
        let (name, folder) = text.split_once('=').filter(|(_, folder)| !folder.is_empty()).ok_or(help)?;
        let unknown = || format!("{name:?} cannot be written while a data set grows: {help}");
        let format = ShardFormat::of_name(name).ok_or_else(unknown)?;
        Ok(Self { format, folder: folder.into() })
    }
}

impl LayoutsArgs {
    /// Takes the folders, of a data set of so many frames.
    pub(super) fn open(&self, dataset: &DatasetFolder, frames: u32, quiet: bool) -> Result<Layouts> {
        if self.layouts.is_empty() && self.size.is_given() {
            let message = "--shard-mb and --shard-frames only apply to shards, but no --layout asks for any".to_owned();
            return Err(Error::Usage { message, help: Some("add --layout webdataset=DIR, or leave them out".into()) });
        }
        for (i, WantedLayout { folder, .. }) in self.layouts.iter().enumerate() {
            if self.layouts[..i].iter().any(|other| other.folder == *folder) {
                let message = format!("--layout: {} would hold the shards of two formats", folder.display());
                return Err(Error::Usage { message, help: Some("choose a folder for each".into()) });
            }
        }
        let open = |WantedLayout { format, folder }: &WantedLayout| {
            // What cannot be written shows before any picture is made.
            create_folder(folder)?;
            Shards::open(dataset.path(), Some(frames), *format, folder, self.size.size(), warner(quiet))
        };
        Ok(Layouts(self.layouts.iter().map(open).collect::<Result<_>>()?))
    }

    /// The same as arguments for a process that is started elsewhere.
    pub(super) fn words(&self) -> Result<Vec<String>> {
        let mut words = Vec::new();
        for WantedLayout { format, folder } in &self.layouts {
            let folder = std::path::absolute(folder).map_err(|reason| Error::io(folder, "find", reason))?;
            words.extend(["--layout".to_owned(), format!("{}={}", format.name(), folder.display())]);
        }
        let ShardSizeArgs { shard_mb, shard_frames } = self.size;
        for (option, number) in [("--shard-mb", shard_mb), ("--shard-frames", shard_frames)] {
            words.extend(number.into_iter().flat_map(|number| [option.to_owned(), number.to_string()]));
        }
        Ok(words)
    }
}

/// Folders of shards.
pub(super) struct Layouts(Vec<Shards>);

impl Layouts {
    /// Hears of pictures for `monitor`, and writes shards as they end.
    pub(super) fn beside<'a>(&'a self, monitor: &'a dyn Monitor) -> GrowingLayouts<'a> {
        GrowingLayouts { layouts: &self.0, monitor, failure: Mutex::default() }
    }
}

/// Shards that are written while pictures are made. Where one cannot be written, the work is called off.
pub(super) struct GrowingLayouts<'a> {
    layouts: &'a [Shards],
    monitor: &'a dyn Monitor,
    failure: Mutex<Option<Error>>,
}

impl GrowingLayouts<'_> {
    /// The outcome of the work, or why shards could not be written.
    pub(super) fn unless_failed<T>(&self, outcome: Result<T>) -> Result<T> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(outcome, Err)
    }

    /// Writes what other processes have left, and says how far it is.
    pub(super) fn finish(&self, quiet: bool) -> Result<()> {
        for shards in self.layouts {
            let progress = shards.finish()?;
            if !quiet {
                let folder = shards.folder().display();
                let present = progress.present;
                match progress.left {
                    Some(left) => say!("{present} of {} shards are in {folder}", present + left),
                    None => say!("no shards are in {folder}: no frame is complete"),
                }
            }
        }
        Ok(())
    }
}

impl Monitor for GrowingLayouts<'_> {
    fn report(&self, event: Event<'_>) {
        let frame = if let Event::PictureEnds(picture) = &event { picture.map(|picture| picture.frame) } else { None };
        self.monitor.report(event);
        let Some(frame) = frame else { return };
        if let Err(error) = self.layouts.iter().try_for_each(|shards| shards.frame_done(frame)) {
            self.failure.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).is_some() || self.monitor.is_cancelled()
    }
}

/// Says what shards leave out.
pub(super) fn warner(quiet: bool) -> impl Fn(&str) + Send + Sync + 'static {
    move |what| {
        if !quiet {
            warning!("{what}");
        }
    }
}
