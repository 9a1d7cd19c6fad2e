//! Pictures to be compared, from files of any kind that photosite writes and the like from other programs.
//!
//! | file | channels | unit |
//! |---|---|---|
//! | EXR | as they are named; `variance.X` is the variance of `X`; of spectral pictures the bands, named by their wavelengths in nm, without the preview | attribute `unit` or `emissiveUnits` |
//! | Radiance HDR | `R`, `G`, `B` of linear sRGB | none |
//! | DNG, NPY of 16 bits, PBM, PGM, raw EXR, and TIFF and PNG of one plane of 16 bits | `raw`: a mosaic; `R`, `G`, `B` where every pixel has all of them | DN |
//! | other PNG and TIFF, JPEG, PPM, NPY of 8 bits | `Y`, `R`, `G`, `B`, alpha `A` | codes, as they are encoded |
//! | NPY and TIFF of floating-point numbers | the same | none |
//!
//! DNG and raw EXR files say which pixels see light: unless asked for, the masked ones are left out.

use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use tiff::ColorType::{Gray, GrayA, RGB, RGBA};
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult};

use super::electrons::VARIANCE;
use super::exr::{ExrPicture, read_exr};
use super::picture_notes::{self, PictureNotes};
use super::raw_exr::stated_active_area;
use super::spectral_exr;
use super::stated_colours::StatedColours;
use crate::image::{Channel, Planes};
use crate::raw::{
    self, NpyNumbers, NpyPicture, PixelArea, Pixels, RawImage, read_npy_picture, read_pixels, refuse_planar_tiles,
};
use crate::validation::{MOSAIC, Picture};
use crate::{Error, Invalid, Result};
use photosite_core::input;
use photosite_scene_io::decode;
use photosite_scene_io::linear::{LinearPicture, decode_radiance};

/// An image's file: its pixel values and what it says besides, of one reading.
#[derive(Clone, Debug)]
pub struct PictureFile {
    /// The image. Its notes are those of the file.
    pub picture: Picture,
    /// What the file says besides, with the name of the file before each statement that is left out.
    pub notes: PictureNotes,
}

impl PictureFile {
    /// Reads an image by the kind that the file's name says.
    pub fn read(path: &Path, pixels: Pixels) -> Result<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let name = path.display().to_string();
        let read: fn(&mut BufReader<File>, String, Pixels) -> Result<Self, Invalid> = match extension.as_str() {
            "dng" | "pbm" | "pgm" => return Ok(Self::of_raw(name, raw::read(path)?.linear().into_owned(), pixels)),
            "exr" => |file, name, pixels| Self::of_exr(read_exr(file)?, name, pixels),
            "hdr" | "pic" => |file, name, _| of_radiance(file, name).map(Self::silent),
            "npy" => |file, name, _| of_npy(file, name).map(Self::silent),
            "tif" | "tiff" => |file, name, _| of_tiff(file, name),
            "png" => |file, name, _| of_codes(file, name, "PNG", picture_notes::of_png),
            "jpg" | "jpeg" => |file, name, _| of_codes(file, name, "JPEG", |bytes| Ok(picture_notes::of_jpeg(bytes))),
            "ppm" | "pnm" => |file, name, _| of_pnm(file, name).map(Self::silent),
            _ if path.is_dir() => {
                let example = path.join("image.png");
                return Err(Error::Usage {
                    message: format!("{} is a folder, and a picture is expected here", path.display()),
                    help: Some(format!("give a picture in it, for example {}", example.display()).into()),
                });
            }
            _ => {
                input::metadata(path).map_err(|source| Error::io(path, "read", source))?;
                return Err(Error::Usage {
                    message: format!("{} is not a picture of a kind that photosite knows", path.display()),
                    help: Some("give a .exr, .hdr, .png, .tiff, .jpg, .ppm, .dng, .pgm, .pbm or .npy file".into()),
                });
            }
        };
        let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
        let read = read(&mut BufReader::new(file), name.clone(), pixels).map_err(|invalid| invalid.in_file(path))?;
        Ok(Self { notes: read.notes.of_file(&name), ..read })
    }

    /// The image with its pixels as they lie in the file; what of the file is left out for that is in its notes.
    pub fn as_it_lies(self) -> Picture {
        let notes = self.notes.of_pixels_as_they_lie(&self.picture.name);
        Picture { notes, ..self.picture }
    }

    /// Image of an EXR file that was read.
    pub(super) fn of_exr(picture: ExrPicture, name: String, pixels: Pixels) -> Result<Self, Invalid> {
        let colours = StatedColours { attributes: picture.attributes.clone(), ..StatedColours::default() };
        let picture = if pixels == Pixels::All { of_exr(picture, name) } else { of_active_area(picture, name) };
        Ok(Self { picture: picture?, notes: PictureNotes { colours, ..PictureNotes::default() } })
    }

    /// Image of a raw file that was read.
    pub(super) fn of_raw(name: String, raw: RawImage, pixels: Pixels) -> Self {
        let orientation = raw.metadata.orientation;
        let mut picture = Picture::from_raw(name, raw, pixels);
        let left_out = std::mem::take(&mut picture.notes);
        Self { picture, notes: PictureNotes { orientation, left_out, ..PictureNotes::default() } }
    }

    /// Image of a file that says nothing besides.
    fn silent(picture: Picture) -> Self {
        Self { picture, notes: PictureNotes::default() }
    }
}

/// Reads an image with its pixels as they lie in the file, by the kind that the file's name says.
pub fn read_picture_file(path: &Path, pixels: Pixels) -> Result<Picture> {
    PictureFile::read(path, pixels).map(PictureFile::as_it_lies)
}

/// A raw EXR file without its masked pixels; of other EXR files all.
fn of_active_area(picture: ExrPicture, name: String) -> Result<Picture, Invalid> {
    let active_area = stated_active_area(&picture)?;
    let whole = of_exr(picture, name)?;
    let Some(PixelArea { x, y, width, height }) = active_area else { return Ok(whole) };
    let row_length = whole.mean.width();
    let part = |channel: Channel| {
        let rows = channel.data.chunks(row_length).skip(y).take(height);
        Channel { data: rows.flat_map(|row| &row[x..x + width]).copied().collect(), ..channel }
    };
    let part = |planes: Planes| Planes::new(width, height, planes.into_channels().into_iter().map(part).collect());
    Ok(Picture { mean: part(whole.mean)?, variance: part(whole.variance)?, active_area, ..whole })
}

fn of_exr(picture: ExrPicture, name: String) -> Result<Picture, Invalid> {
    let unit = picture.text("unit").or(picture.text("emissiveUnits")).map(str::to_owned);
    let (stated, warnings) = (picture.stated_of_colours(), picture.warnings.clone());
    let spectral = picture.text("spectralLayoutVersion").is_some();
    let planes = if spectral { spectral_exr::bands(picture.planes)? } else { picture.planes };
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
    Ok(Picture {
        name,
        mean,
        variance,
        unit,
        full_scale: None,
        mosaic: None,
        active_area: None,
        stated,
        warnings,
        notes: Vec::new(),
    })
}

fn of_radiance(file: &mut BufReader<File>, name: String) -> Result<Picture, Invalid> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| unreadable("Radiance HDR", &e))?;
    let LinearPicture { planes: mean, warnings, .. } = decode_radiance(&bytes)?;
    let variance = Planes::zeros(mean.width(), mean.height(), [""; 0]);
    Ok(Picture {
        name,
        mean,
        variance,
        unit: None,
        full_scale: None,
        mosaic: None,
        active_area: None,
        stated: Vec::new(),
        warnings,
        notes: Vec::new(),
    })
}

fn of_codes(
    file: &mut BufReader<File>,
    name: String,
    kind: &str,
    notes: fn(&[u8]) -> Result<PictureNotes, Invalid>,
) -> Result<PictureFile, Invalid> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| unreadable(kind, &e))?;
    let picture = decode(&bytes, "the picture").map_err(|error| Invalid { help: None, ..error })?;
    let size = [picture.width() as usize, picture.height() as usize];
    let components = usize::from(picture.color().channel_count());
    let wide = picture.color().bytes_per_pixel() as usize == 2 * components;
    let codes = picture.as_bytes();
    let picture = if wide {
        let codes = codes.as_chunks::<2>().0.iter().map(|&pair| f32::from(u16::from_ne_bytes(pair)));
        interleaved(name, size, components, codes, Some(u16::MAX))
    } else {
        interleaved(name, size, components, codes.iter().map(|&code| f32::from(code)), Some(u8::MAX.into()))
    };
    Ok(PictureFile { picture: picture?, notes: notes(&bytes)? })
}

fn of_pnm(file: &mut BufReader<File>, name: String) -> Result<Picture, Invalid> {
    let raw = raw::read_pnm(file)?;
    let numbers = raw.data.iter().copied().map(f32::from);
    interleaved(name, [raw.width, raw.height], raw.cfa.samples_per_pixel(), numbers, Some(raw.white_level_dn))
}

fn of_npy(file: &mut BufReader<File>, name: String) -> Result<Picture, Invalid> {
    let NpyPicture { width, height, channels, numbers } = read_npy_picture(file)?;
    let size = [width, height];
    match numbers {
        NpyNumbers::U8(v) => interleaved(name, size, channels, v.into_iter().map(f32::from), Some(u8::MAX.into())),
        NpyNumbers::U16(v) => {
            let picture = interleaved(name, size, channels, v.into_iter().map(f32::from), Some(u16::MAX))?;
            Ok(Picture { unit: Some("DN".to_owned()), ..picture })
        }
        NpyNumbers::F32(v) => interleaved(name, size, channels, v.into_iter(), None),
    }
}

fn of_tiff(file: &mut BufReader<File>, name: String) -> Result<PictureFile, Invalid> {
    let bad = |error: TiffError| unreadable("TIFF", &error);
    let notes = picture_notes::of_tiff(&mut *file)?;
    file.rewind().map_err(|error| bad(error.into()))?;
    let mut decoder = Decoder::new(file).map_err(bad)?;
    let (width, height) = decoder.dimensions().map_err(bad)?;
    let size = [width as usize, height as usize];
    let colours = decoder.colortype().map_err(bad)?;
    let refused = || {
        Invalid::new("", format!("pixels of the kind {colours:?} cannot be compared"))
            .help("write grey or RGB, of 8 or 16 bits or of 32-bit floats")
    };
    let grey_or_rgb = matches!(colours, Gray(_) | GrayA(_) | RGB(_) | RGBA(_));
    if !grey_or_rgb || ![8, 16, 32, 64].contains(&colours.bit_depth()) {
        return Err(refused());
    }
    let components = usize::from(colours.num_samples());
    refuse_planar_tiles(&mut decoder).map_err(bad)??;
    let picture = match read_pixels(&mut decoder).map_err(bad)? {
        DecodingResult::U8(v) => {
            interleaved(name, size, components, v.into_iter().map(f32::from), Some(u8::MAX.into()))
        }
        DecodingResult::U16(v) => interleaved(name, size, components, v.into_iter().map(f32::from), Some(u16::MAX)),
        DecodingResult::F32(v) => interleaved(name, size, components, v.into_iter(), None),
        DecodingResult::F64(v) => interleaved(name, size, components, v.into_iter().map(|x| x as f32), None),
        DecodingResult::U32(_)
        | DecodingResult::U64(_)
        | DecodingResult::F16(_)
        | DecodingResult::I8(_)
        | DecodingResult::I16(_)
        | DecodingResult::I32(_)
        | DecodingResult::I64(_) => Err(refused()),
    };
    Ok(PictureFile { picture: picture?, notes })
}

fn unreadable(kind: &str, error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as {kind}: {error}"))
}

/// Planes of 1–4 components that lie side by side, named as those of an NPY file; `maximum` is that of integers.
pub fn interleaved(
    name: String,
    [width, height]: [usize; 2],
    components: usize,
    values: impl Iterator<Item = f32>,
    maximum: Option<u16>,
) -> Result<Picture, Invalid> {
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
    Ok(Picture {
        name,
        mean: Planes::new(width, height, channels)?,
        variance: Planes::zeros(width, height, [""; 0]),
        unit: maximum.map(|m| if is_mosaic { "DN".to_owned() } else { format!("codes up to {m}") }),
        full_scale: maximum.map(f64::from),
        mosaic: None,
        active_area: None,
        stated: Vec::new(),
        warnings: Vec::new(),
        notes: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Write};

    use image::{DynamicImage, ImageBuffer, ImageFormat};
    use rstest::rstest;
    use tiff::encoder::{TiffEncoder, colortype};

    use super::*;
    use crate::image::Estimate;
    use crate::io::electrons::write_electrons;
    use crate::io::exr::{Attribute, write_exr};
    use crate::io::raw_exr::write_raw_exr;
    use crate::io::spectral_exr::write_irradiance;
    use crate::raw::{Cfa, RawImage, write_dng, write_npy, write_pgm, write_tiff};
    use crate::units::Seconds;

    /// Reads a file of that extension.
    fn read(extension: &str, bytes: &[u8]) -> Result<Picture> {
        let mut file = tempfile::Builder::new().suffix(&format!(".{extension}")).tempfile().expect("a temporary file");
        file.write_all(bytes).expect("written");
        read_picture_file(file.path(), Pixels::Active)
    }

    fn channels(planes: &Planes) -> Vec<(&str, &[f32])> {
        planes.channels().iter().map(|c| (&c.name[..], &c.data[..])).collect()
    }

    #[test]
    fn electrons_come_with_their_variances() {
        let mean = Planes::zeros(2, 2, ["B", "G", "R"]);
        let mut variance = Planes::zeros(2, 2, ["B", "G", "R"]);
        variance.channels_mut()[2].data[3] = 0.25;
        let mut file = Vec::new();
        write_electrons(&Estimate { mean, variance: variance.clone() }, Seconds(1.0), Cursor::new(&mut file))
            .expect("written");
        let picture = read("exr", &file).expect("read");
        assert_eq!(channels(&picture.mean), ["R", "G", "B"].map(|name| (name, &[0.0; 4][..])));
        assert_eq!(picture.variance, variance);
        assert_eq!(picture.unit.as_deref(), Some("e-"));
    }

    #[test]
    fn a_variance_of_nothing_is_a_channel_like_any_other() {
        let mut file = Vec::new();
        let planes = Planes::zeros(1, 1, ["Y", "variance.X"]);
        write_exr(&planes, &[("unit", Attribute::Text("lux".to_owned()))], Cursor::new(&mut file)).expect("written");
        let picture = read("exr", &file).expect("read");
        assert_eq!(picture.mean, planes);
        assert!(picture.variance.channels().is_empty());
    }

    #[test]
    fn spectral_pictures_leave_their_preview_behind() {
        let planes = Planes::zeros(2, 1, ["355", "1095"]);
        let mut file = Vec::new();
        write_irradiance(&planes, Cursor::new(&mut file)).expect("written");
        assert_eq!(read("exr", &file).expect("read").mean, planes);
    }

    #[test]
    fn every_raw_file_holds_the_same_mosaic() {
        let raw = RawImage {
            width: 4,
            height: 2,
            data: vec![0, 1, 255, 256, 4095, 64, 300, 65_535],
            cfa: Cfa::parse("GRBG").expect("known"),
            bits: 12,
            black_level_dn: 64.into(),
            white_level_dn: 4095,
            ..RawImage::default()
        };
        let data: Vec<f32> = raw.data.iter().map(|&dn| f32::from(dn)).collect();
        let [mut dng, mut tiff, mut pgm, mut npy] = [const { Vec::new() }; 4];
        write_dng(&raw, Cursor::new(&mut dng)).expect("written");
        write_tiff(&raw, Cursor::new(&mut tiff)).expect("written");
        write_pgm(&raw, &mut pgm).expect("written");
        write_npy(&raw, &mut npy).expect("written");
        let png = png(DynamicImage::ImageLuma16(ImageBuffer::from_raw(4, 2, raw.data.clone()).expect("8 pixels")));
        let mut exr = Vec::new();
        write_raw_exr(&raw, Cursor::new(&mut exr)).expect("written");
        for (extension, file) in [("dng", dng), ("TIFF", tiff), ("pgm", pgm), ("npy", npy), ("exr", exr), ("png", png)]
        {
            let picture = read(extension, &file).expect("read");
            assert_eq!(channels(&picture.mean), [("raw", &data[..])], "{extension}");
            assert_eq!(picture.unit.as_deref(), Some("DN"));
            assert_eq!(picture.mosaic, (extension == "dng").then_some(raw.cfa.clone()));
        }
    }

    fn png(picture: DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, ImageFormat::Png).expect("encoded");
        bytes.into_inner()
    }

    #[rstest]
    #[case::grey(DynamicImage::ImageLuma8(ImageBuffer::from_raw(1, 1, vec![7]).expect("one pixel")), &[("Y", 7.0)], 255.0)]
    #[case::grey_alpha(DynamicImage::ImageLumaA8(ImageBuffer::from_raw(1, 1, vec![7, 9]).expect("one pixel")), &[("Y", 7.0), ("A", 9.0)], 255.0)]
    #[case::colour(DynamicImage::ImageRgb8(ImageBuffer::from_raw(1, 1, vec![1, 2, 3]).expect("one pixel")), &[("R", 1.0), ("G", 2.0), ("B", 3.0)], 255.0)]
    #[case::colour_16(DynamicImage::ImageRgb16(ImageBuffer::from_raw(1, 1, vec![1, 256, 65535]).expect("one pixel")), &[("R", 1.0), ("G", 256.0), ("B", 65535.0)], 65535.0)]
    #[case::alpha_16(DynamicImage::ImageRgba16(ImageBuffer::from_raw(1, 1, vec![1, 2, 3, 258]).expect("one pixel")), &[("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 258.0)], 65535.0)]
    fn codes_of_png_files_are_kept(
        #[case] picture: DynamicImage,
        #[case] expected: &[(&str, f32)],
        #[case] full_scale: f64,
    ) {
        let read = read("png", &png(picture)).expect("read");
        let found: Vec<_> = read.mean.channels().iter().map(|c| (&c.name[..], c.data[0])).collect();
        assert_eq!(found, expected);
        assert_eq!(read.full_scale, Some(full_scale));
    }

    #[test]
    fn tiff_files_keep_their_numbers() {
        fn tiff<C: colortype::ColorType>(values: &[C::Inner]) -> Vec<u8>
        where
            [C::Inner]: tiff::encoder::TiffValue,
        {
            let mut file = Cursor::new(Vec::new());
            TiffEncoder::new(&mut file).and_then(|mut e| e.write_image::<C>(1, 1, values)).expect("written");
            file.into_inner()
        }
        for (file, expected, full_scale) in [
            (tiff::<colortype::Gray8>(&[7]), vec![("Y", 7.0)], Some(255.0)),
            (tiff::<colortype::RGB8>(&[1, 2, 3]), vec![("R", 1.0), ("G", 2.0), ("B", 3.0)], Some(255.0)),
            (tiff::<colortype::RGB16>(&[1, 258, 3]), vec![("R", 1.0), ("G", 258.0), ("B", 3.0)], Some(65_535.0)),
            (tiff::<colortype::Gray32Float>(&[-0.5]), vec![("Y", -0.5)], None),
            (tiff::<colortype::RGB32Float>(&[0.5, 2.0, 1e9]), vec![("R", 0.5), ("G", 2.0), ("B", 1e9)], None),
        ] {
            let picture = read("tif", &file).expect("read");
            let found: Vec<_> = picture.mean.channels().iter().map(|c| (&c.name[..], c.data[0])).collect();
            assert_eq!((found, picture.full_scale), (expected, full_scale));
        }
        let error = read("tif", &tiff::<colortype::Gray32>(&[7])).expect_err("refused");
        assert!(error.to_string().contains("Gray(32)"), "{error}");
    }

    #[test]
    fn files_that_are_not_what_they_say_are_refused_by_name() {
        for extension in ["exr", "dng", "npy", "pgm", "tif", "png"] {
            let error = read(extension, b"nothing of the kind").expect_err("refused");
            assert!(
                matches!(error, Error::Input(_)) && error.to_string().contains(&format!(".{extension}: ")),
                "{error}"
            );
        }
        assert!(matches!(read("docx", b""), Err(Error::Usage { .. })));
        assert!(matches!(read_picture_file(Path::new("nowhere.exr"), Pixels::Active), Err(Error::Io { .. })));
    }
}
