//! Reading DNG files: those that [`write_dng`](super::write_dng) writes, and those of other programs as far as they are
//! made alike: one plane or interleaved numbers of 8–16 bits or floating-point numbers, in strips or tiles,
//! without compression, as lossless JPEG or zlib. Lossy files, JPEG XL and makers' own formats are left to programs
//! made for them.

use std::io::{Read, Seek};

use tiff::Directory;
use tiff::tags::Tag;

use super::read_pixel_values::Coding;
use super::whole::Whole;
use super::{colour, filters, opcodes, xmp};
use crate::openable::{ReadSeek, open};
use crate::rules::{self, Kind};
use crate::tag;
use crate::tags::{Tags, unreadable};
use crate::{
    BlackLevel, Cfa, Distortion, LensModel, MAX_SIDE, Orientation, PixelArea, RawImage, RawMetadata, bits_for,
    read_tiff,
};
use photosite_core::Invalid;
use photosite_core::counted;

/// Reads a DNG file.
pub fn read_dng<R: Read + Seek>(mut from: R) -> Result<RawImage, Invalid> {
    read(&mut from)
}

fn read(from: &mut dyn ReadSeek) -> Result<RawImage, Invalid> {
    let (decoder, pointer) = open(from).map_err(unreadable)?;
    let mut file = Tags { decoder };
    let main = file.decoder.read_directory(pointer).map_err(unreadable)?;
    let (beneath, others) = file.find_image(&main)?;
    let image = beneath.as_ref().unwrap_or(&main);
    let [width, height] = [Tag::ImageWidth, Tag::ImageLength].map(|tag| file.number(image, tag));
    let [width, height] = [width?.unwrap_or(0.0), height?.unwrap_or(0.0)];
    let sides = 1.0..=MAX_SIDE as f64;
    if !sides.contains(&width) || !sides.contains(&height) {
        return Err(Invalid::new("ImageWidth", format!("{width} × {height} pixels are not an image")));
    }
    let (width, height) = (width as usize, height as usize);
    let area = file.active_area(image, width, height)?;
    let active = area.unwrap_or(PixelArea { x: 0, y: 0, width, height });
    let cfa = file.cfa(image, active)?;
    let mut left_out = file.left_out(&main, beneath.as_ref())?;
    if others > 0 {
        let which = counted(others, ["more raw image", "more raw images"]);
        left_out.push(format!("{which} in the file {} left out", if others == 1 { "is" } else { "are" }));
    }
    let coding = Coding::read(&mut file, image, cfa.samples_per_pixel())?;
    let black_level_dn = file.black_level(image, &cfa, active)?;
    let whites = file.white_levels(image, &cfa, coding.default_white())?;
    let numbers = coding.numbers(&mut file, image, [width, height])?;
    let Whole { data, black_level_dn, whites, rounded } = Whole::of(numbers, black_level_dn, whites)?;
    left_out.extend(rounded);
    let table: Vec<u16> = file.numbers(image, tag::LINEARIZATION_TABLE)?.into_iter().map(|n| n as u16).collect();
    let white = whites.iter().copied().min().unwrap_or(u16::MAX);
    // The file does not keep the converter's bits; those that its table or the white level needs are what matters.
    let bits = bits_for(if table.is_empty() { white } else { (table.len() - 1).min(0xffff) as u16 });
    let mut metadata = file.metadata(&main, image, [active.width, active.height])?;
    left_out.append(&mut metadata.left_out);
    metadata.left_out = left_out;
    Ok(RawImage {
        width,
        height,
        data,
        cfa,
        active_area: area,
        bits,
        linearisation: (!table.is_empty()).then_some(table),
        black_level_dn,
        white_level_dn: white,
        channel_whites_dn: whites.iter().any(|other| *other != white).then_some(whites),
        metadata,
    })
}

/// Reads a DNG or TIFF file, whichever it is.
pub fn read_dng_or_tiff<R: Read + Seek>(mut from: R) -> Result<RawImage, Invalid> {
    let is_dng = is_dng(&mut from);
    from.rewind().map_err(|error| Invalid::new("", format!("cannot read it: {error}")))?;
    if is_dng { read_dng(from) } else { read_tiff(from) }
}

/// Whether a TIFF file says in its first directory that it is DNG.
fn is_dng(from: &mut dyn ReadSeek) -> bool {
    let version = open(from).and_then(|(mut decoder, pointer)| {
        let main = decoder.read_directory(pointer)?;
        decoder.read_directory_tags(&main).find_tag(tag::DNG_VERSION)
    });
    matches!(version, Ok(Some(_)))
}

impl Tags<'_> {
    /// The directory of the image of full resolution where it is beneath the main one, and how many more there are.
    fn find_image(&mut self, main: &Directory) -> Result<(Option<Directory>, usize), Invalid> {
        let pointers = match self.value(main, Tag::SubIfd)? {
            Some(value) => value.into_ifd_vec().map_err(unreadable)?,
            None => Vec::new(),
        };
        let mut images = Vec::new();
        for pointer in pointers {
            let directory = self.decoder.read_directory(pointer).map_err(unreadable)?;
            if self.is_image(&directory)? {
                images.push(directory);
            }
        }
        if self.is_image(main)? {
            return Ok((None, images.len()));
        }
        if images.is_empty() {
            let invalid = Invalid::new("SubIFDs", "the file holds no raw image");
            return Err(invalid.help("give a raw.dng that photosite wrote"));
        }
        let others = images.len() - 1;
        Ok((Some(images.swap_remove(0)), others))
    }

    fn is_image(&mut self, directory: &Directory) -> Result<bool, Invalid> {
        let photometric = self.number(directory, Tag::PhotometricInterpretation)?;
        let is_raw = [tag::COLOR_FILTER_ARRAY, tag::LINEAR_RAW].into_iter().any(|p| photometric == Some(f64::from(p)));
        Ok(is_raw && self.number(directory, Tag::NewSubfileType)?.unwrap_or(0.0) == 0.0)
    }

    fn active_area(&mut self, image: &Directory, width: usize, height: usize) -> Result<Option<PixelArea>, Invalid> {
        let Some([top, left, bottom, right]) = self.array(image, tag::ACTIVE_AREA)? else { return Ok(None) };
        if !(0.0 <= left
            && left < right
            && right <= width as f64
            && 0.0 <= top
            && top < bottom
            && bottom <= height as f64)
        {
            let message = format!("rows {top} to {bottom} and columns {left} to {right} are not within the image");
            return Err(Invalid::new("ActiveArea", message).help("the file is damaged"));
        }
        let [x, y] = [left, top].map(|n| n as usize);
        let area = PixelArea { x, y, width: right as usize - x, height: bottom as usize - y };
        Ok((area != PixelArea { x: 0, y: 0, width, height }).then_some(area))
    }

    fn cfa(&mut self, image: &Directory, active: PixelArea) -> Result<Cfa, Invalid> {
        let samples = self.number(image, Tag::SamplesPerPixel)?.unwrap_or(1.0);
        let is_linear = self.number(image, Tag::PhotometricInterpretation)? == Some(f64::from(tag::LINEAR_RAW));
        match samples {
            1.0 if is_linear => return Ok(Cfa::mono()),
            3.0 if is_linear => return Cfa::full(["R", "G", "B"]),
            1.0 => {}
            other => {
                let message = format!("{other} values per pixel");
                return Err(Invalid::new("SamplesPerPixel", message).help("photosite reads mosaics, grey and RGB"));
            }
        }
        let size = self.numbers(image, tag::CFA_REPEAT_PATTERN_DIM)?;
        let codes = self.bytes(image, tag::CFA_PATTERN)?;
        let mut planes = self.bytes(image, tag::CFA_PLANE_COLOR)?;
        if planes.is_empty() {
            planes = vec![0, 1, 2];
        }
        let &[rows, columns] = &size[..] else {
            return Err(Invalid::new("CFARepeatPatternDim", format!("{size:?} instead of rows and columns")));
        };
        if rows * columns != codes.len() as f64 || codes.is_empty() {
            let message = format!("{} filters for {rows} rows and {columns} columns", codes.len());
            return Err(Invalid::new("CFAPattern", message).help("the file is damaged"));
        }
        let cfa = filters::mosaic(columns as usize, &codes, &planes)?;
        // The tag counts from the active area, which may begin anywhere in the tile.
        let (width, height) = cfa.tile_size();
        Ok(cfa.from((width - active.x % width) % width, (height - active.y % height) % height))
    }

    fn black_level(&mut self, image: &Directory, cfa: &Cfa, active: PixelArea) -> Result<BlackLevel, Invalid> {
        let samples = cfa.samples_per_pixel();
        let levels: Vec<f32> = self.numbers(image, tag::BLACK_LEVEL)?.into_iter().map(|level| level as f32).collect();
        let columns = self.array::<2>(image, tag::BLACK_LEVEL_REPEAT_DIM)?.map_or(1, |[_, columns]| columns as usize);
        let mut deltas = |tag, first: usize, side: usize| {
            let deltas = self.numbers(image, tag)?;
            if deltas.is_empty() {
                return Ok(Vec::new());
            }
            if deltas.len() != side {
                let message = format!("{} numbers for {side} rows or columns", deltas.len());
                return Err(Invalid::new("BlackLevelDelta", message).help("the file is damaged"));
            }
            Ok(std::iter::repeat_n(0.0, first).chain(deltas.into_iter().map(|delta| delta as f32)).collect())
        };
        let column_deltas: Vec<f32> = deltas(tag::BLACK_LEVEL_DELTA_H, active.x, active.width)?;
        let row_deltas: Vec<f32> = deltas(tag::BLACK_LEVEL_DELTA_V, active.y, active.height)?;
        let level = match &levels[..] {
            [] => BlackLevel::default(),
            [first, rest @ ..] if rest.iter().all(|level| level == first) => BlackLevel::uniform(*first),
            levels => {
                let damaged = |error| Invalid { key: "BlackLevel".to_owned(), ..error };
                let width = columns.saturating_mul(samples);
                let tile = BlackLevel::of_tile(width, levels.to_vec()).map_err(damaged)?;
                let height = levels.len() / width;
                // Like the filters', its tile begins with the active area.
                tile.from(cfa, (columns - active.x % columns) % columns, (height - active.y % height) % height)
            }
        };
        if !level.mean().is_finite() {
            return Err(Invalid::new("BlackLevel", "not a number").help("the file is damaged"));
        }
        if column_deltas.is_empty() && row_deltas.is_empty() {
            return Ok(level);
        }
        Ok(level.with_deltas(cfa, column_deltas, row_deltas))
    }

    /// The level of saturation of each channel, as the file has it.
    fn white_levels(&mut self, image: &Directory, cfa: &Cfa, default: f64) -> Result<Vec<f64>, Invalid> {
        let samples = cfa.samples_per_pixel();
        let stated = self.numbers(image, tag::WHITE_LEVEL)?;
        Ok(match stated[..] {
            [] => vec![default; samples],
            // One for each number of a pixel; a mosaic has one.
            _ if stated.len() == samples => stated,
            [first, ..] => vec![first; samples],
        })
    }

    /// Warnings about tags of the file that are left out, apart from its opcodes.
    fn left_out(&mut self, main: &Directory, beneath: Option<&Directory>) -> Result<Vec<String>, Invalid> {
        let image = beneath.unwrap_or(main);
        let mut left_out = rules::left_out(self, image, Kind::Dng)?;
        if beneath.is_some() {
            left_out.extend(rules::left_out(self, main, Kind::DngMain)?);
        }
        let version = self.numbers(main, tag::DNG_BACKWARD_VERSION)?;
        if version.first_chunk::<2>().is_some_and(|version| *version > [1.0, 7.0]) {
            let version: Vec<String> = version.iter().map(f64::to_string).collect();
            left_out.push(format!("DNGBackwardVersion {}: the file is made for newer readers", version.join(".")));
        }
        if self.value(image, tag::BLACK_LEVEL)?.is_none() && self.value(image, tag::MASKED_AREAS)?.is_some() {
            left_out.push(
                "MaskedAreas is left out: black is taken for 0; develop.raw.black_level_dn says otherwise".to_owned(),
            );
        }
        Ok(left_out)
    }

    /// The part of the active area that is shown, in whole pixels.
    fn default_crop(
        &mut self,
        image: &Directory,
        size: [usize; 2],
        left_out: &mut Vec<String>,
    ) -> Result<Option<PixelArea>, Invalid> {
        let [x, y] = self.array(image, tag::DEFAULT_CROP_ORIGIN)?.unwrap_or([0.0; 2]);
        let Some([width, height]) = self.array(image, tag::DEFAULT_CROP_SIZE)? else { return Ok(None) };
        let fits = |first: f64, length: f64, side: usize| {
            first >= 0.0 && length >= 1.0 && (first.round() + length.round()) <= side as f64
        };
        if !fits(x, width, size[0]) || !fits(y, height, size[1]) {
            left_out.push(format!(
                "DefaultCropSize, {width} × {height} pixels at {x}, {y}, is left out: the active area has {} × {} pixels",
                size[0], size[1]
            ));
            return Ok(None);
        }
        let [x, y, width, height] = [x, y, width, height].map(|n| n.round() as usize);
        Ok(([width, height] != size).then_some(PixelArea { x, y, width, height }))
    }

    fn metadata(&mut self, main: &Directory, image: &Directory, size: [usize; 2]) -> Result<RawMetadata, Invalid> {
        let exif = match self.value(main, Tag::ExifDirectory)? {
            Some(pointer) => {
                let pointer = pointer.into_ifd_pointer().map_err(unreadable)?;
                self.decoder.read_directory(pointer).map_err(unreadable)?
            }
            None => Directory::empty(),
        };
        let camera_model = self.text(main, Tag::Model)?;
        let camera_serial = match self.text(main, tag::CAMERA_SERIAL_NUMBER)? {
            none if none.is_empty() => self.text(&exif, tag::BODY_SERIAL_NUMBER)?,
            serial => serial,
        };
        // Telephones write into the first directory what belongs into that of EXIF.
        let said = [&exif, main, image];
        let noise = self.numbers(image, tag::NOISE_PROFILE)?;
        let [first, second, third] =
            [tag::OPCODE_LIST_1, tag::OPCODE_LIST_2, tag::OPCODE_LIST_3].map(|list| self.bytes(image, list));
        let samples = self.number(image, Tag::SamplesPerPixel)?.unwrap_or(1.0) as usize;
        let mut corrections = opcodes::read([&first?, &second?, &third?], size, samples);
        let orientation = match self.first_number(&[main, image], Tag::Orientation)? {
            None => Orientation::default(),
            Some(number) => Orientation::of_number(number).unwrap_or_else(|| {
                corrections.left_out.push(format!("Orientation {number} is none: the image is not turned"));
                Orientation::default()
            }),
        };
        let mut metadata = RawMetadata {
            camera_model,
            camera_serial,
            pixel_pitch_m: self.pixel_pitch(&said)?,
            is_staggered: self.number(image, tag::CFA_LAYOUT)? == Some(tag::EVEN_ROWS_TO_THE_RIGHT.into()),
            exposure_time_s: self.first_number(&said, tag::EXPOSURE_TIME)?.unwrap_or(0.0),
            iso: self.iso(&said)?,
            f_number: self.first_number(&said, tag::F_NUMBER)?,
            focal_length_m: self.first_number(&said, tag::FOCAL_LENGTH)?.map(|mm| mm * 1e-3),
            noise_profile: noise.as_chunks::<2>().0.to_vec(),
            baseline_exposure_ev: self.number(main, tag::BASELINE_EXPOSURE)?.filter(|ev| ev.is_finite()).unwrap_or(0.0),
            opcodes: corrections.opcodes,
            default_crop: self.default_crop(image, size, &mut corrections.left_out)?,
            distortion: self.lens(main, size)?.map(Distortion::Lens).or(corrections.warp.map(Distortion::Warp)),
            orientation,
            left_out: corrections.left_out,
            ..RawMetadata::default()
        };
        let [across, down] = self.array(image, tag::DEFAULT_SCALE)?.unwrap_or([1.0; 2]);
        let aspect = across / down;
        // What a few roundings leave of equal numbers.
        let differs = (aspect / metadata.pixel_aspect() - 1.0).abs() > 1e-6;
        metadata.stated_pixel_aspect = differs.then_some(aspect);
        colour::read(self, main, &mut metadata)?;
        Ok(metadata)
    }

    /// The model of the lens where our own packet has it.
    fn lens(&mut self, main: &Directory, size: [usize; 2]) -> Result<Option<LensModel>, Invalid> {
        // A packet that is no list of bytes has nothing to say.
        let packet = self.bytes(main, tag::XMP).unwrap_or_default();
        Ok(xmp::read_lens(&packet, size))
    }

    /// ISO speed, which has a tag of its own where 16 bits are too few.
    fn iso(&mut self, said: &[&Directory]) -> Result<Option<u32>, Invalid> {
        for tag in [
            tag::ISO_SPEED,
            tag::PHOTOGRAPHIC_SENSITIVITY,
            tag::RECOMMENDED_EXPOSURE_INDEX,
            tag::STANDARD_OUTPUT_SENSITIVITY,
        ] {
            let iso = self.first_number(said, tag)?.filter(|iso| *iso > 0.0);
            // 65 535 is what EXIF has for more than that, to be said by another tag.
            let iso = iso.filter(|iso| !(tag == tag::PHOTOGRAPHIC_SENSITIVITY && *iso == 65_535.0));
            if let Some(iso) = iso {
                return Ok(Some(iso as u32));
            }
        }
        Ok(None)
    }

    fn pixel_pitch(&mut self, said: &[&Directory]) -> Result<Option<[f64; 2]>, Invalid> {
        let x = self.first_number(said, tag::FOCAL_PLANE_X_RESOLUTION)?;
        let y = self.first_number(said, tag::FOCAL_PLANE_Y_RESOLUTION)?;
        let unit = self.first_number(said, tag::FOCAL_PLANE_RESOLUTION_UNIT)?.unwrap_or(2.0);
        let unit_m = if unit == f64::from(tag::PER_CENTIMETRE) { 0.01 } else { 0.0254 };
        let pitch = |resolution: f64| Some(unit_m / resolution).filter(|pitch| pitch.is_finite() && *pitch > 0.0);
        Ok(x.and_then(pitch).zip(y.and_then(pitch)).map(|(x, y)| [x, y]))
    }
}
