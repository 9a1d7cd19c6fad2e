//! Folders that each hold some samples of the pictures of a data set, and the pictures that they make together.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::DataSet;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::identity::{IDENTITY, OF_PART, read_identity};
use super::made::Made;
use super::make::MakeOptions;
use super::presence::picture;
use crate::pipeline::{LightSource, Monitor, Parts, difference};
use crate::{Error, Invalid, Result};

/// A folder of parts of pictures.
pub struct PartFolder {
    path: PathBuf,
    identity: Value,
}

impl PartFolder {
    /// Whether a folder is that of a data set.
    pub fn is_one(path: &Path) -> bool {
        path.join(IDENTITY).exists()
    }

    /// Reads what a folder is a part of.
    pub fn read(path: &Path) -> Result<Self> {
        let refuse = |message: &str| {
            let help = "give folders that hold a part of a data set";
            Err(Invalid::new("", message).help(help).in_file(path))
        };
        if !Self::is_one(path) {
            return refuse("holds no part of a data set");
        }
        let identity = read_identity(&path.join(IDENTITY))?;
        if identity[OF_PART].is_null() {
            return refuse("holds a whole data set and no part of one");
        }
        Ok(Self { path: path.to_owned(), identity })
    }

    /// Where the data set file was.
    pub fn input(&self) -> PathBuf {
        PathBuf::from(self.identity[OF_PART]["path"].as_str().unwrap_or_default())
    }

    /// The overrides that it was made with.
    pub fn arguments(&self) -> Vec<String> {
        let arguments = self.identity["overrides"].as_array().into_iter().flatten();
        arguments.filter_map(Value::as_str).map(str::to_owned).collect()
    }

    /// Refuses parts of another data set.
    fn check(&self, whole: &Value) -> Result<()> {
        if self.identity["fingerprint"] == whole["fingerprint"] {
            return Ok(());
        }
        let difference = difference(&self.identity, whole);
        let message = format!("{} is a part of another data set: {difference}", self.path.display());
        Err(Error::Usage { message, help: Some("give parts of one data set, and its file as it was".into()) })
    }

    /// The part of a picture, if it is there.
    fn picture(&self, camera: &str, number: u32) -> Option<PathBuf> {
        Some(picture(&self.path, camera, number)).filter(|path| path.exists())
    }
}

impl DataSet {
    /// Makes the pictures of these frames of the parts in all folders together. What is missing shows before anything
    /// is made, unless the run keeps going.
    pub fn merge(
        &self,
        parts: &[PartFolder],
        frames: &Frames,
        path: &Path,
        monitor: &dyn Monitor,
        options: MakeOptions,
    ) -> Result<(DatasetFolder, Made)> {
        parts.iter().try_for_each(|part| part.check(&self.identity))?;
        let of_picture = |camera: &str, number: u32| {
            let found: Vec<PathBuf> = parts.iter().filter_map(|part| part.picture(camera, number)).collect();
            if found.is_empty() {
                let message = format!("frame {number} of camera {camera} is in none of the folders");
                let help = "give the command of the missing part again: it goes on where it was broken off";
                return Err(Error::Usage { message, help: Some(help.into()) });
            }
            Parts::read(&found)
        };
        if !options.keeps_going {
            for number in frames.numbers() {
                self.cameras().try_for_each(|camera| of_picture(camera, number).map(drop))?;
            }
        }
        let folder = self.claim(path)?;
        let light = |camera: &str, number| of_picture(camera, number).map(LightSource::Merged);
        let made = self.make(frames, &folder, monitor, options, light)?;
        Ok((folder, made))
    }
}
