//! Reading every file of the pictures that are there, for damage that their names do not show.

use std::path::Path;

use rayon::prelude::*;

use super::DataSet;
use super::finished::MANIFEST;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::index::report_sums;
use super::presence::{damage, damage_of_report, name};
use crate::Result;
use crate::pipeline::{Event, Monitor};
use crate::report::Look;

impl DataSet {
    /// Holds every file of the frames' pictures against its checksum, and warns of those that are damaged. With `mends`
    /// such pictures are taken away, to be made again. Returns how many are damaged that pass for whole ones by the
    /// names and sizes of their files.
    pub fn verify(&self, frames: &Frames, folder: &DatasetFolder, mends: bool, monitor: &dyn Monitor) -> Result<usize> {
        let sums = report_sums(&folder.path().join(MANIFEST));
        let pictures: Vec<_> = self.pictures(frames).collect();
        let damage_of = |path: &Path, camera: &str, number: u32| {
            // One that is missing is not damaged.
            if !path.exists() {
                return None;
            }
            let of_report = || damage_of_report(path, sums.get(&name(camera, number))?);
            damage(path, Look::Contents).or_else(of_report)
        };
        let damaged = pictures.par_iter().filter_map(|&(number, camera, _)| {
            let what = damage_of(&folder.picture(camera, number), camera, number)?;
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
