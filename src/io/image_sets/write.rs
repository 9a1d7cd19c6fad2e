//! Taking the images of a set and writing them.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::characterisation::{Descriptor, FlatField, Series, Shot};
use crate::io::output::{Sink, create_folders, write_unsynced};
use crate::raw::{RawImage, write_dng, write_tiff};
use crate::{Error, Invalid, Result};

/// File format of images. All hold the same digital numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// 16-bit grey TIFF.
    Tiff,
    /// DNG, monochrome.
    Dng,
    /// 16-bit grey PNG.
    Png,
}

impl ImageFormat {
    /// Ending of file names.
    pub fn extension(self) -> &'static str {
        match self {
            ImageFormat::Tiff => "tiff",
            ImageFormat::Dng => "dng",
            ImageFormat::Png => "png",
        }
    }

    fn write(self, raw: &RawImage, to: &mut dyn Sink) -> io::Result<()> {
        match self {
            ImageFormat::Tiff => write_tiff(raw, to),
            ImageFormat::Dng => write_dng(raw, to),
            ImageFormat::Png => write_png16(raw, to),
        }
    }
}

fn write_png16(raw: &RawImage, to: impl Write) -> io::Result<()> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    // The encoder takes numbers in the byte order of this machine.
    let bytes: Vec<u8> = raw.data.iter().flat_map(|dn| dn.to_ne_bytes()).collect();
    PngEncoder::new(to)
        .write_image(&bytes, side(raw.width)?, side(raw.height)?, ExtendedColorType::L16)
        .map_err(io::Error::other)
}

/// Takes images of a sensor with noise that is new in each, and writes them to a folder that is synced when it is
/// finished.
#[derive(Debug)]
pub struct SetWriter {
    folder: PathBuf,
    format: ImageFormat,
    seed: u64,
    /// Number of the next image.
    frame: u64,
}

impl SetWriter {
    /// Writes below `folder`, which exists.
    pub fn new(folder: &Path, format: ImageFormat, seed: u64) -> Self {
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
            let name = format!("{}-{i}.{}", shot.name, self.format.extension());
            write_unsynced(&folder.join(&name), |to| self.format.write(&image, to))?;
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
