//! Formats of image and raw files: the one table of their endings, their contents, and who reads and writes them.
//! Commands, error messages, the live view and the names of results follow it.

mod decoded;
mod file_image;
mod jpeg;
pub mod lists;
pub(crate) mod png;
mod pnm;
pub(crate) mod tiff;

use std::borrow::Cow;
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek};
use std::path::Path;

use photosite_core::output::Sink;
use photosite_core::{Invalid, Result};
use photosite_raw::{self as raw, Cfa, DngCompression, Pixels, RawImage};

use super::{exr, npy, raw_exr};
pub use decoded::{ImageFile, interleaved};
pub use file_image::{FileImage, Samples};

/// Format of image or raw files.
#[derive(Clone, Copy)]
pub struct Format {
    /// Name, as sentences have it.
    pub name: &'static str,
    /// Endings of file names in lower case, the usual one first.
    pub endings: &'static [&'static str],
    /// Media type.
    pub media_type: &'static str,
    /// First bytes of a file, up to [`MAGIC`] of them, each that there are.
    magic: &'static [&'static [u8]],
    /// Kind of content.
    pub holds: Holds,
    /// Numbers of channels of an image that is written; empty for any.
    pub channels: &'static [usize],
    /// Bits of the integers that it holds.
    pub bits: &'static [u8],
    /// Whether integers may end at any number, not at the largest of their bits alone.
    pub any_largest: bool,
    /// Whether it holds 32-bit floats.
    pub floats: bool,
    /// Whether viewers take its integers for the codes of an image.
    pub is_shown: bool,
    /// Whether pixel values change on the way through a file.
    pub is_lossy: bool,
    /// Whether it states colours by an ICC profile.
    pub has_profile: bool,
    /// Whether a raw file states the meaning of its pixel values.
    pub states_meaning: bool,
    /// Reader of digital numbers, for files that are known by their first bytes.
    pub raw_reader: Option<ReadRaw>,
    /// Reader of images; without one, images are those of digital numbers.
    pub image_reader: Option<ReadImage>,
    /// Refusal of digital numbers that it cannot hold.
    fits_raw: fn(&Cfa) -> Result<(), Invalid>,
    /// Writer of digital numbers; the compression is that of DNG files.
    pub raw_writer: Option<WriteRaw>,
    /// Writer of images that the format can hold.
    pub image_writer: Option<WriteImage>,
}

/// Reader of digital numbers.
pub type ReadRaw = fn(&mut dyn Source) -> Result<RawImage, Invalid>;

/// Reader of an image file of that name.
pub type ReadImage = fn(&mut BufReader<File>, String, Pixels) -> Result<ImageFile, Invalid>;

/// Writer of digital numbers.
pub type WriteRaw = fn(&RawImage, DngCompression, &mut dyn Sink) -> io::Result<()>;

/// Writer of images.
pub type WriteImage = fn(&FileImage<'_>, &mut dyn Sink) -> io::Result<()>;

/// Kind of content of a format's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Digital numbers of a sensor, with their meaning.
    Raw,
    /// Arrays of pixel values that may be digital numbers.
    Arrays,
    /// Linear light, stored or developed.
    Light,
    /// Codes of an image for the eye.
    Codes,
}

/// Source of a file's bytes.
pub trait Source: BufRead + Seek {}
impl<T: BufRead + Seek> Source for T {}

/// Most bytes by which a format is known.
pub(crate) const MAGIC: u64 = 4;

/// Format without readers and writers, of which the rows of the table differ.
const NONE: Format = Format {
    name: "",
    endings: &[],
    media_type: "application/octet-stream",
    magic: &[],
    holds: Holds::Arrays,
    channels: &[],
    bits: &[8, 16],
    any_largest: false,
    floats: false,
    is_shown: false,
    is_lossy: false,
    has_profile: false,
    states_meaning: false,
    raw_reader: None,
    image_reader: None,
    fits_raw: |_| Ok(()),
    raw_writer: None,
    image_writer: None,
};

/// Digital negative.
pub const DNG: Format = Format {
    name: "DNG",
    endings: &["dng"],
    magic: TIFF.magic,
    holds: Holds::Raw,
    states_meaning: true,
    raw_reader: TIFF.raw_reader,
    fits_raw: raw::dng_can_hold,
    raw_writer: Some(|raw, compression, to| raw::write_compressed_dng(raw, compression, to)),
    ..NONE
};

/// Portable network graphics.
pub const PNG: Format = Format {
    name: "PNG",
    endings: &["png"],
    media_type: "image/png",
    magic: &[b"\x89PNG"],
    holds: Holds::Codes,
    channels: &[1, 2, 3, 4],
    is_shown: true,
    has_profile: true,
    image_reader: Some(png::read),
    image_writer: Some(|image, to| png::write(image, to)),
    ..NONE
};

/// Tagged image file format.
pub const TIFF: Format = Format {
    name: "TIFF",
    endings: &["tiff", "tif"],
    magic: &[b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"],
    channels: &[1, 3, 4],
    floats: true,
    is_shown: true,
    has_profile: true,
    raw_reader: Some(|from| raw::read_dng_or_tiff(from)),
    image_reader: Some(tiff::read),
    raw_writer: Some(|raw, _, to| raw::write_tiff(raw, to)),
    image_writer: Some(tiff::write),
    ..NONE
};

/// JPEG.
pub const JPEG: Format = Format {
    name: "JPEG",
    endings: &["jpg", "jpeg"],
    media_type: "image/jpeg",
    magic: &[b"\xff\xd8\xff"],
    holds: Holds::Codes,
    channels: &[1, 3],
    bits: &[8],
    is_shown: true,
    is_lossy: true,
    has_profile: true,
    image_reader: Some(jpeg::read),
    image_writer: Some(jpeg::write),
    ..NONE
};

/// Portable bitmap, which is read alone.
pub const PBM: Format =
    Format { name: "PBM", endings: &["pbm"], magic: &[b"P1", b"P4"], raw_writer: None, image_writer: None, ..PGM };

/// Portable greymap; raw files of three channels are pixmaps of that name.
pub const PGM: Format = Format {
    name: "PGM",
    endings: &["pgm"],
    magic: &[b"P2", b"P5"],
    channels: &[1],
    image_reader: None,
    fits_raw: pnm::fits_raw,
    raw_writer: Some(|raw, _, to| raw::write_pgm(raw, to)),
    ..PPM
};

/// Portable pixmap, or greymap.
pub const PPM: Format = Format {
    name: "PPM",
    endings: &["ppm", "pnm"],
    magic: &[b"P3", b"P6"],
    channels: &[1, 3],
    any_largest: true,
    is_shown: true,
    raw_reader: Some(|from| raw::read_pnm(from)),
    image_reader: Some(pnm::read),
    image_writer: Some(pnm::write),
    ..NONE
};

/// NumPy array.
pub const NPY: Format = Format {
    name: "NPY",
    endings: &["npy"],
    magic: &[b"\x93NUM"],
    any_largest: true,
    floats: true,
    raw_reader: Some(|from| raw::read_npy(from)),
    image_reader: Some(npy::read),
    raw_writer: Some(|raw, _, to| raw::write_npy(raw, to)),
    image_writer: Some(npy::write),
    ..NONE
};

/// OpenEXR.
pub const EXR: Format = Format {
    name: "EXR",
    endings: &["exr"],
    magic: &[b"v/1\x01"],
    holds: Holds::Light,
    bits: &[],
    floats: true,
    states_meaning: true,
    raw_reader: Some(|from| raw_exr::read_raw_exr(from)),
    image_reader: Some(|file, name, pixels| ImageFile::of_exr(exr::read_exr(file)?, name, pixels)),
    raw_writer: Some(|raw, _, to| raw_exr::write_raw_exr(raw, to)),
    image_writer: Some(exr::write_image),
    ..NONE
};

/// Radiance HDR.
pub const HDR: Format = Format {
    name: "HDR",
    endings: &["hdr", "pic"],
    magic: &[b"#?"],
    holds: Holds::Light,
    bits: &[],
    floats: true,
    image_reader: Some(decoded::of_radiance),
    ..NONE
};

/// WebP, which is a texture alone.
pub const WEBP: Format = Format { name: "WebP", endings: &["webp"], magic: &[b"RIFF"], holds: Holds::Codes, ..NONE };

/// All formats, in the order in which messages list them.
pub const FORMATS: [&Format; 11] = [&DNG, &PNG, &TIFF, &JPEG, &PBM, &PGM, &PPM, &NPY, &EXR, &HDR, &WEBP];

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Debug for Format {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.name)
    }
}

impl Format {
    /// Format of files of that name.
    pub fn of(path: &Path) -> Option<&'static Self> {
        Self::of_ending(&path.extension()?.to_string_lossy())
    }

    /// Format of an ending of file names.
    pub fn of_ending(ending: &str) -> Option<&'static Self> {
        let is_known = |format: &&Self| format.endings.iter().any(|known| known.eq_ignore_ascii_case(ending));
        FORMATS.into_iter().find(is_known)
    }

    /// Format of a file of digital numbers that begins with these bytes.
    pub(crate) fn of_magic(begin: &[u8]) -> Option<&'static Self> {
        let is_known = |format: &&Self| format.magic.iter().any(|magic| begin.starts_with(magic));
        FORMATS.into_iter().find(is_known)
    }

    /// Usual ending of file names.
    pub fn ending(&self) -> &'static str {
        self.endings[0]
    }

    /// Whether images are read.
    pub fn reads_images(&self) -> bool {
        self.image_reader.is_some() || self.raw_reader.is_some()
    }

    /// Whether images are written whose pixel values stay as they are.
    pub fn keeps_numbers(&self) -> bool {
        self.image_writer.is_some() && !self.is_lossy
    }

    /// Whether digital numbers of a sensor are written.
    pub fn writes_raw(&self) -> bool {
        self.raw_writer.is_some()
    }

    /// Refuses digital numbers of a layout that the format has no room for.
    pub fn check_raw(&self, cfa: &Cfa) -> Result<(), Invalid> {
        (self.fits_raw)(cfa)
    }

    /// Writes digital numbers of a sensor; as an image where raw files are not of this format.
    pub fn write_raw(&self, raw: &RawImage, compression: DngCompression, to: &mut dyn Sink) -> io::Result<()> {
        if let Some(write) = self.raw_writer {
            return write(raw, compression, to);
        }
        let values = Samples::U16(Cow::Borrowed(&raw.data));
        let image = FileImage::plain([raw.width, raw.height], raw.cfa.samples_per_pixel(), values);
        self.write(&FileImage { is_fast: true, ..image }, to)
    }

    /// Writes an image that the format can hold.
    pub fn write(&self, image: &FileImage<'_>, to: &mut dyn Sink) -> io::Result<()> {
        let refused = |what: String| Err(io::Error::other(format!("{} files hold no {what}", self.name)));
        let is_float = matches!(image.samples, Samples::F32(_));
        match self.image_writer {
            None => refused("images".to_owned()),
            Some(_) if is_float && !self.floats => refused("floating-point values".to_owned()),
            Some(_) if !is_float && self.bits.is_empty() => refused("integers".to_owned()),
            Some(_) if !self.holds_channels(image.channels) => refused(format!("{} channels", image.channels)),
            Some(write) => write(image, to),
        }
    }

    /// Whether images of so many channels are written.
    pub(crate) fn holds_channels(&self, count: usize) -> bool {
        self.channels.is_empty() || self.channels.contains(&count)
    }
}
