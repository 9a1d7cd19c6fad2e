//! Taking the images of a set and writing them.

use std::path::{Path, PathBuf};

use crate::formats::{DNG, Format, PNG, TIFF};
use photosite_core::output::{create_folders, write_unsynced};
use photosite_core::{Error, Invalid, Result};
use photosite_measure::characterisation::{Descriptor, FlatField, Series, Shot};
use photosite_raw::DngCompression;

/// File formats of images. All hold the same digital numbers.
pub const IMAGE_FORMATS: [&Format; 3] = [&TIFF, &DNG, &PNG];

/// Writer of image sets: takes images of a sensor with noise that is new in each, and writes them to a folder that is
/// synced when it is finished.
#[derive(Debug)]
pub struct SetWriter {
    folder: PathBuf,
    format: &'static Format,
    seed: u64,
    /// Number of the next image.
    frame: u64,
}

impl SetWriter {
    /// Writer below `folder`, which exists.
    pub fn new(folder: &Path, format: &'static Format, seed: u64) -> Self {
        Self { folder: folder.to_owned(), format, seed, frame: 0 }
    }

    /// Takes the images of a shot and writes them into the folder `images` beside a descriptor in `set`, a folder below
    /// that of the writer. `taken` is called after each, and may end the work.
    pub fn take(
        &mut self,
        set: &str,
        flat: &FlatField<'_>,
        shot: &Shot,
        taken: &dyn Fn() -> Result<()>,
    ) -> Result<Series> {
        let folder = self.folder.join(set).join("images");
        create_folders(&folder).map_err(|reason| Error::io(&folder, "create the folder", reason))?;
        let unfit = |invalid: Invalid| invalid.in_file(&folder);
        let frames = self.frame..self.frame + u64::from(shot.images);
        let mut images = Vec::new();
        for (i, image) in flat.images(shot.light.photons(), shot.time, self.seed, frames).enumerate() {
            let image = image.map_err(unfit)?;
            let name = format!("{}-{i}.{}", shot.name, self.format.ending());
            write_unsynced(&folder.join(&name), |to| self.format.write_raw(&image, DngCompression::None, to))?;
            images.push(format!("images/{name}"));
            taken()?;
        }
        self.frame += u64::from(shot.images);
        Ok(Series { exposure_ns: shot.time.0 * 1e9, light: shot.light, images })
    }

    /// Writes a descriptor at a path below the writer's folder.
    pub fn describe(&self, path: &str, descriptor: &Descriptor) -> Result<()> {
        write_unsynced(&self.folder.join(path), |to| write!(to, "{descriptor}"))
    }
}
