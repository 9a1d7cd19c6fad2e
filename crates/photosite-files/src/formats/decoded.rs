//! Images of files, as the readers of their formats leave them.

use std::fs::File;
use std::io::{BufReader, Read};

use crate::electrons::VARIANCE;
use crate::exr::ExrImage;
use crate::image_notes::ImageNotes;
use crate::raw_exr::stated_active_area;
use crate::spectral_exr;
use crate::stated_colours::StatedColours;
use photosite_core::image::{Channel, Planes};
use photosite_core::{Invalid, Result};
use photosite_measure::validation::{ComparedImage, MOSAIC};
use photosite_raw::{PixelArea, Pixels, RawImage};
use photosite_scene_io::decode;
use photosite_scene_io::linear::{LinearImage, decode_radiance};

/// Image file: its pixel values and other statements, read once.
#[derive(Clone, Debug)]
pub struct ImageFile {
    /// Image, whose notes are those of the file.
    pub image: ComparedImage,
    /// Other statements of the file, with the file's name before each statement that is left out.
    pub notes: ImageNotes,
}

impl ImageFile {
    /// Image with its pixels as they lie in the file; its notes name what is left out for that.
    pub fn as_it_lies(self) -> ComparedImage {
        let notes = self.notes.of_pixels_as_they_lie(&self.image.name);
        ComparedImage { notes, ..self.image }
    }

    /// Image of an EXR file that was read.
    pub(crate) fn of_exr(image: ExrImage, name: String, pixels: Pixels) -> Result<Self, Invalid> {
        let colours = StatedColours { attributes: image.attributes.clone(), ..StatedColours::default() };
        let image = if pixels == Pixels::All { of_exr(image, name) } else { of_active_area(image, name) };
        Ok(Self { image: image?, notes: ImageNotes { colours, ..ImageNotes::default() } })
    }

    /// Image of a raw file that was read.
    pub fn of_raw(name: String, raw: RawImage, pixels: Pixels) -> Self {
        let orientation = raw.metadata.orientation;
        let mut image = ComparedImage::from_raw(name, raw, pixels);
        let left_out = std::mem::take(&mut image.notes);
        Self { image, notes: ImageNotes { orientation, left_out, ..ImageNotes::default() } }
    }

    /// Image of a file without further statements.
    pub(crate) fn silent(image: ComparedImage) -> Self {
        Self { image, notes: ImageNotes::default() }
    }
}

/// Image of an EXR file: a raw file without its masked pixels, any other whole.
fn of_active_area(image: ExrImage, name: String) -> Result<ComparedImage, Invalid> {
    let active_area = stated_active_area(&image)?;
    let whole = of_exr(image, name)?;
    let Some(PixelArea { x, y, width, height }) = active_area else { return Ok(whole) };
    let row_length = whole.mean.width();
    let part = |channel: Channel| {
        let rows = channel.data.chunks(row_length).skip(y).take(height);
        Channel { data: rows.flat_map(|row| &row[x..x + width]).copied().collect(), ..channel }
    };
    let part = |planes: Planes| Planes::new(width, height, planes.into_channels().into_iter().map(part).collect());
    Ok(ComparedImage { mean: part(whole.mean)?, variance: part(whole.variance)?, active_area, ..whole })
}

fn of_exr(image: ExrImage, name: String) -> Result<ComparedImage, Invalid> {
    let unit = image.text("unit").or(image.text("emissiveUnits")).map(str::to_owned);
    let (stated, warnings) = (image.stated_of_colours(), image.warnings.clone());
    let spectral = image.text("spectralLayoutVersion").is_some();
    let planes = if spectral { spectral_exr::bands(image.planes)? } else { image.planes };
    let (mut mean, mut variance) = (Vec::new(), Vec::new());
    for channel in planes.channels() {
        match channel.name.strip_prefix(VARIANCE).filter(|of| planes.plane(of).is_some()) {
            Some(of) => variance.push(Channel { name: of.to_owned(), data: channel.data.clone() }),
            None => mean.push(channel.clone()),
        }
    }
    if !spectral {
        // A file sorts by name, and nobody says blue, green and red.
        mean.sort_by_key(|c| ["R", "G", "B"].iter().position(|name| c.name == *name).unwrap_or(3));
    }
    let planes = |channels| Planes::new(planes.width(), planes.height(), channels);
    let (mean, variance) = (planes(mean)?, planes(variance)?);
    Ok(ComparedImage { variance, unit, stated, warnings, ..ComparedImage::plain(name, mean) })
}

/// Reads a Radiance HDR file.
pub(crate) fn of_radiance(file: &mut BufReader<File>, name: String, _: Pixels) -> Result<ImageFile, Invalid> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| unreadable("Radiance HDR", &e))?;
    let LinearImage { planes: mean, warnings, .. } = decode_radiance(&bytes)?;
    Ok(ImageFile::silent(ComparedImage { warnings, ..ComparedImage::plain(name, mean) }))
}

/// Reads an image of codes by the `image` library.
pub(crate) fn of_codes(
    file: &mut BufReader<File>,
    name: String,
    kind: &str,
    notes: fn(&[u8]) -> Result<ImageNotes, Invalid>,
) -> Result<ImageFile, Invalid> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| unreadable(kind, &e))?;
    let image = decode(&bytes, "the image").map_err(|error| Invalid { help: None, ..error })?;
    let size = [image.width() as usize, image.height() as usize];
    let components = usize::from(image.color().channel_count());
    let wide = image.color().bytes_per_pixel() as usize == 2 * components;
    let codes = image.as_bytes();
    let image = if wide {
        let codes = codes.as_chunks::<2>().0.iter().map(|&pair| f32::from(u16::from_ne_bytes(pair)));
        interleaved(name, size, components, codes, Some(u16::MAX))
    } else {
        interleaved(name, size, components, codes.iter().map(|&code| f32::from(code)), Some(u8::MAX.into()))
    };
    Ok(ImageFile { image: image?, notes: notes(&bytes)? })
}

/// Refusal of a file of that kind, by the reason of a library.
pub(crate) fn unreadable(kind: &str, error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as {kind}: {error}"))
}

/// Planes of 1–4 interleaved components, named as those of an NPY file; `maximum` is that of integers.
pub fn interleaved(
    name: String,
    [width, height]: [usize; 2],
    components: usize,
    values: impl Iterator<Item = f32>,
    maximum: Option<u16>,
) -> Result<ComparedImage, Invalid> {
    let is_mosaic = components == 1 && maximum == Some(u16::MAX);
    let names: &[&str] = match components {
        1 if is_mosaic => &[MOSAIC],
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let mut channels: Vec<_> = names.iter().map(|&n| Channel { name: n.to_owned(), data: Vec::new() }).collect();
    for (i, value) in values.enumerate() {
        channels[i % components].data.push(value);
    }
    Ok(ComparedImage {
        unit: maximum.map(|m| if is_mosaic { "DN".to_owned() } else { format!("codes up to {m}") }),
        full_scale: maximum.map(f64::from),
        ..ComparedImage::plain(name, Planes::new(width, height, channels)?)
    })
}
