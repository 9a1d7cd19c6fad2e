//! The pictures that parts of a data set make together.

use std::path::{Path, PathBuf};

use super::DataSet;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::made::Made;
use super::make::MakeOptions;
use super::parts::PartFolder;
use crate::pipeline::{LightSource, Monitor, Parts};
use crate::{Error, Result};

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
                let help = "run the command of the missing part again: it continues where it stopped";
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
