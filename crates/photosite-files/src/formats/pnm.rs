//! Portable greymaps and pixmaps.

use std::fs::File;
use std::io::{self, BufReader};

use super::FileImage;
use super::decoded::{ImageFile, interleaved};
use photosite_core::Invalid;
use photosite_core::output::Sink;
use photosite_raw::{Cfa, Pixels, read_pnm};

pub(super) fn read(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    let raw = read_pnm(file)?;
    let numbers = raw.data.iter().copied().map(f32::from);
    let image =
        interleaved(name, [raw.width, raw.height], raw.cfa.samples_per_pixel(), numbers, Some(raw.white_level_dn));
    image.map(ImageFile::silent)
}

pub(super) fn fits_raw(cfa: &Cfa) -> Result<(), Invalid> {
    let samples = cfa.samples_per_pixel();
    if [1, 3].contains(&samples) {
        return Ok(());
    }
    let message = format!("PGM and PPM have no pixels of {samples} numbers");
    Err(Invalid::new("raw", message).help("write raw = [\"tiff\"] or [\"npy\"], which hold any channels"))
}

pub(super) fn write(image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
    let kind = if image.channels == 1 { "P5" } else { "P6" };
    let [width, height] = image.size;
    write!(to, "{kind}\n{width} {height}\n{}\n", image.largest)?;
    to.write_all(&image.big_endian()?)
}
