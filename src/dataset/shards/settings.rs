//! What is decided once of the shards of a folder, and recorded in it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::lock::Lock;
use crate::io::output::{create_folder, write_new};
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// The file that says what the folder holds.
pub(super) const SETTINGS: &str = "layout.json";

/// Most bytes of a shard where nothing else is asked for, MiB.
const DEFAULT_MB: u32 = 256;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShardFormat {
    /// Tar files of WebDataset.
    Webdataset,
    /// Parquet files of Hugging Face `datasets`.
    Parquet,
    /// MCAP files of ROS 2 messages.
    Mcap,
}

impl ShardFormat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Webdataset, Self::Parquet, Self::Mcap];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Webdataset => "webdataset",
            Self::Parquet => "parquet",
            Self::Mcap => "mcap",
        }
    }

    /// The one of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// What the files of a shard are called: before and after its number.
    pub(super) fn affixes(self) -> [&'static str; 2] {
        match self {
            Self::Webdataset => ["shard-", ".tar"],
            Self::Parquet => ["part-", ".parquet"],
            Self::Mcap => ["part-", ".mcap"],
        }
    }
}

/// How large a shard is. What is left out is as the folder has it, or as many frames as fit into 256 MiB.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShardSize {
    /// Most bytes, MiB.
    pub mb: Option<u32>,
    /// Frames, however large they are.
    pub frames: Option<u32>,
}

/// What is recorded.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) struct Settings {
    pub(super) photosite_version: String,
    pub(super) format: ShardFormat,
    /// Fingerprint of the data set.
    pub(super) fingerprint: String,
    /// Of the whole data set.
    pub(super) frames: u32,
    /// Of each shard but the last.
    pub(super) frames_per_shard: u32,
    /// Most bytes of a file, MiB; none where the number of frames was asked for.
    pub(super) limit_mb: Option<u32>,
}

impl Settings {
    /// The frames of a shard.
    pub(super) fn frames_of(&self, shard: u32) -> std::ops::Range<u32> {
        let start = shard * self.frames_per_shard;
        start..start.saturating_add(self.frames_per_shard).min(self.frames)
    }

    /// How many shards there are in the end.
    pub(super) fn shards(&self) -> u32 {
        self.frames.div_ceil(self.frames_per_shard)
    }

    /// Most bytes of a file.
    pub(super) fn limit(&self) -> u64 {
        self.limit_mb.map_or(u64::MAX, |mb| u64::from(mb) << 20)
    }
}

/// What a folder is wanted for.
pub(super) struct Wanted {
    pub(super) format: ShardFormat,
    pub(super) fingerprint: String,
    pub(super) frames: u32,
    pub(super) size: ShardSize,
}

impl Wanted {
    /// What the folder has recorded, which must be what is wanted; `None` of a new or empty folder.
    pub(super) fn recorded(&self, folder: &Path) -> Result<Option<Settings>> {
        if folder.is_file() {
            return Err(elsewhere(format!("{} is a file, but a folder is needed", folder.display())));
        }
        let path = folder.join(SETTINGS);
        let text = match input::read_text(&path, input::TREE_BYTES) {
            Ok(text) => text,
            Err(reason) if reason.kind() == std::io::ErrorKind::NotFound => {
                let entries = input::entries(folder).into_iter().flatten().flatten();
                let mut names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
                // Another process may have begun meanwhile.
                if names.any(|name| !name.starts_with('.')) && !path.exists() {
                    return Err(elsewhere(format!(
                        "{} is not empty and does not contain {SETTINGS}",
                        folder.display()
                    )));
                }
                return if path.exists() { self.recorded(folder) } else { Ok(None) };
            }
            Err(reason) => return Err(Error::io(&path, "read", reason)),
        };
        let damaged = |why: &str| {
            let help = "remove the folder, whose files can be made again from the data set";
            Invalid::new("", format!("is damaged: {why}")).help(help).in_file(&path)
        };
        let settings: Settings = serde_json::from_str(&text).map_err(|error| damaged(&error.to_string()))?;
        if settings.frames_per_shard == 0 {
            return Err(damaged("a shard without frames"));
        }
        self.difference(&settings)
            .map_or(Ok(Some(settings)), |what| Err(elsewhere(format!("{} {what}", folder.display()))))
    }

    fn difference(&self, known: &Settings) -> Option<String> {
        let version = env!("CARGO_PKG_VERSION");
        if known.format != self.format {
            return Some(format!("holds {} files, and not {}", known.format.name(), self.format.name()));
        }
        if known.fingerprint != self.fingerprint {
            return Some("contains shards of another data set".to_owned());
        }
        if known.photosite_version != version {
            return Some(format!("was written by photosite {}, and this is {version}", known.photosite_version));
        }
        if known.frames != self.frames {
            let (then, now) = (known.frames, self.frames);
            return Some(format!("was started when the data set had {then} frames, and it has {now}"));
        }
        if let Some(frames) =
            self.size.frames.filter(|&frames| (frames, None) != (known.frames_per_shard, known.limit_mb))
        {
            return Some(format!("has shards of {} frames, and not of {frames}", known.frames_per_shard));
        }
        let limit = known.limit_mb;
        self.size.mb.filter(|&mb| limit != Some(mb)).map(|mb| match limit {
            Some(limit) => format!("has shards of at most {limit} MiB, and not of {mb}"),
            None => format!("has shards of {} frames, and not of at most {mb} MiB", known.frames_per_shard),
        })
    }

    /// Decides for a folder that has decided nothing, by the bytes of a frame, unless another process is first.
    pub(super) fn decide(&self, folder: &Path, bytes_of_frame: u64) -> Result<Settings> {
        create_folder(folder)?;
        let _lock = Lock::wait_for_folder(folder)?;
        if let Some(settings) = self.recorded(folder)? {
            return Ok(settings);
        }
        let (frames_per_shard, limit_mb) = match self.size.frames {
            Some(frames) => (frames, None),
            None => {
                let mb = self.size.mb.unwrap_or(DEFAULT_MB);
                (frames_within(u64::from(mb) << 20, bytes_of_frame), Some(mb))
            }
        };
        let settings = Settings {
            photosite_version: env!("CARGO_PKG_VERSION").to_owned(),
            format: self.format,
            fingerprint: self.fingerprint.clone(),
            frames: self.frames,
            frames_per_shard: frames_per_shard.clamp(1, self.frames.max(1)),
            limit_mb,
        };
        let text = serde_json::to_string_pretty(&settings).unwrap_or_default();
        write_new(&folder.join(SETTINGS), |to| writeln!(to, "{text}"))?;
        // Without locks another process may have been first.
        Ok(self.recorded(folder)?.unwrap_or(settings))
    }
}

/// How many frames of this size a shard gets: with a tenth of it left for frames that are larger, and one digit that is
/// not 0, so that the number seldom depends on which frame was first.
fn frames_within(limit: u64, bytes_of_frame: u64) -> u32 {
    let most = limit / 10 * 9 / bytes_of_frame.max(1);
    let power = 10_u64.pow(most.max(1).ilog10());
    u32::try_from(most / power * power).unwrap_or(u32::MAX).max(1)
}

fn elsewhere(message: String) -> Error {
    Error::Usage { message, help: Some("choose a new folder for the shards".into()) }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn wanted(size: ShardSize) -> Wanted {
        Wanted { format: ShardFormat::Parquet, fingerprint: "f00d".to_owned(), frames: 25, size }
    }

    #[test]
    fn shards_have_round_numbers_of_frames_below_their_limit() {
        assert_eq!(frames_within(256 << 20, 3 << 20), 70);
        assert_eq!(frames_within(256 << 20, 3_200_000), 70);
        assert_eq!(frames_within(10, 100), 1);
        assert_eq!(frames_within(1 << 30, 1), 900_000_000);
        assert_eq!(frames_within(1 << 40, 1), u32::MAX);
    }

    #[test]
    fn every_frame_is_in_one_shard() {
        let folder = tempfile::tempdir().expect("a folder");
        let size = ShardSize { frames: Some(10), mb: None };
        let settings = wanted(size).decide(folder.path(), 1).expect("decided");
        let frames: Vec<u32> = (0..settings.shards()).flat_map(|shard| settings.frames_of(shard)).collect();
        assert_eq!((settings.shards(), frames), (3, (0..25).collect()));
    }

    #[test]
    fn what_was_decided_holds_and_another_wish_is_refused() {
        let root = tempfile::tempdir().expect("a folder");
        let folder = root.path().join("out");
        let none = ShardSize::default();
        assert_eq!(wanted(none).recorded(&folder).expect("new"), None);
        let settings = wanted(none).decide(&folder, 100 << 20).expect("decided");
        assert_eq!((settings.frames_per_shard, settings.limit_mb), (2, Some(256)));
        let again = wanted(none).decide(&folder, 1).expect("decided");
        assert_eq!(again, settings);
        let refused = |wanted: Wanted| wanted.recorded(&folder).expect_err("refused").to_string();
        assert!(refused(wanted(ShardSize { mb: Some(9), frames: None })).contains("at most 256 MiB, and not of 9"));
        assert!(refused(wanted(ShardSize { mb: None, frames: Some(2) })).contains("shards of 2 frames"));
        assert!(refused(Wanted { format: ShardFormat::Mcap, ..wanted(none) }).contains("parquet files, and not mcap"));
        assert!(refused(Wanted { fingerprint: "beef".to_owned(), ..wanted(none) }).contains("another data set"));
        assert!(refused(Wanted { frames: 26, ..wanted(none) }).contains("had 25 frames, and it has 26"));
        fs::write(root.path().join("file"), "mine").expect("written");
        assert!(wanted(none).recorded(root.path()).expect_err("refused").to_string().contains("is not empty"));
    }
}
