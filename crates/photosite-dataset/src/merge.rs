//! Merging of the parts of a data set into whole images.

use std::path::{Path, PathBuf};

use super::DataSet;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::make::MakeOptions;
use super::outcome::DatasetOutcome;
use super::parts::PartFolder;
use photosite_core::{Error, Result};
use photosite_pipeline::{LightSource, Monitor, Parts};

impl DataSet {
    /// Merges the parts in all folders into the images of these frames. Missing parts are reported before anything is
    /// made, unless the run keeps going.
    pub fn merge(
        &self,
        parts: &[PartFolder],
        frames: &Frames,
        path: &Path,
        monitor: &dyn Monitor,
        options: MakeOptions,
    ) -> Result<(DatasetFolder, DatasetOutcome)> {
        parts.iter().try_for_each(|part| part.check(&self.identity))?;
        let of_image = |camera: &str, number: u32| {
            let found: Vec<PathBuf> = parts.iter().filter_map(|part| part.image(camera, number)).collect();
            if found.is_empty() {
                let message = format!("frame {number} of camera {camera} is in none of the folders");
                let help = "run the command of the missing part again: it continues where it stopped";
                return Err(Error::Usage { message, help: Some(help.into()) });
            }
            Parts::read(&found)
        };
        if !options.keeps_going {
            for number in frames.numbers() {
                self.cameras().try_for_each(|camera| of_image(camera, number).map(drop))?;
            }
        }
        let folder = self.claim(path)?;
        let light = |camera: &str, number| of_image(camera, number).map(LightSource::Merged);
        let made = self.make(frames, &folder, monitor, options, light)?;
        Ok((folder, made))
    }
}
