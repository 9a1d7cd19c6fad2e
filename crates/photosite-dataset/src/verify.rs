//! Verification: reading every file of the present images, for damage that names and sizes do not show.

use std::path::Path;

use rayon::prelude::*;

use super::DataSet;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::image_folder::{damage, damage_of_report, name};
use super::index::report_sums;
use super::read_dataset::MANIFEST;
use photosite_capture::report::CheckDepth;
use photosite_core::Result;
use photosite_pipeline::{Event, Monitor};

impl DataSet {
    /// Checks every file of the frames' images against its checksum, and warns of damaged ones. With `mends`, damaged
    /// images are removed, to be made again. Returns the number of damaged images that pass for whole ones by the names
    /// and sizes of their files.
    pub fn verify(&self, frames: &Frames, folder: &DatasetFolder, mends: bool, monitor: &dyn Monitor) -> Result<usize> {
        let sums = report_sums(&folder.path().join(MANIFEST));
        let images: Vec<_> = self.images(frames).collect();
        let damage_of = |path: &Path, camera: &str, number: u32| {
            // One that is missing is not damaged.
            if !path.exists() {
                return None;
            }
            let of_report = || damage_of_report(path, sums.get(&name(camera, number))?);
            damage(path, CheckDepth::Contents).or_else(of_report)
        };
        let damaged = images.par_iter().filter_map(|&(number, camera, _)| {
            let what = damage_of(&folder.image(camera, number), camera, number)?;
            Some((camera, number, what))
        });
        let damaged: Vec<_> = damaged.collect();
        for (camera, number, what) in &damaged {
            monitor.report(Event::Warning(&format!("{} is damaged: {what}", name(camera, *number))));
        }
        let is_hidden = |&&(camera, number, _): &&(&str, u32, String)| folder.is_done(camera, number);
        let hidden = damaged.iter().filter(is_hidden).count();
        if mends {
            for (camera, number, _) in &damaged {
                folder.remove(camera, *number, |path| damage_of(path, camera, *number))?;
            }
        }
        Ok(hidden)
    }
}
