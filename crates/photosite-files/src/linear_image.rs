//! Images as linear sRGB, by their files' statements of colours. Colours outside of sRGB's gamut lie outside of 0 to 1.
//!
//! | file | says it by |
//! |---|---|
//! | PNG | code points (cICP), else an ICC profile, else gAMA and cHRM |
//! | TIFF, JPEG | an ICC profile |
//! | EXR, HDR | its header, as [`linear`](photosite_scene_io::linear) has it |
//!
//! Files without a statement are sRGB. Profiles of tables and curves for high dynamic range are refused by name.

use photosite_core::{Help, Remedy};
use std::path::Path;

use glam::{DMat3, DVec3};
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve, TransferCharacteristics};
use rayon::prelude::*;

use super::exr::read_exr_file;
use super::formats::{EXR, Format, HDR};
use super::image_file::ImageFile;
use super::image_notes::ImageNotes;
use super::stated_colours::StatedColours;
use photosite_core::colour::adaptation::D50;
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_core::image::{Channel, NotFinite, Planes};
use photosite_core::input;
use photosite_core::{Error, Invalid, Result};
use photosite_measure::validation::ComparedImage;
use photosite_raw::Pixels;
use photosite_scene_io::linear::colours::to_srgb;
use photosite_scene_io::linear::{LinearImage, decode_radiance, of_exr};

/// Meaning of an image's pixel values.
struct Meaning {
    /// Curves of R, G and B, from code (0 to 1) to linear light.
    curves: [Curve; 3],
    /// Transform from linear R, G and B to linear sRGB.
    to_srgb: DMat3,
}

type Curve = Box<dyn Fn(f32) -> f32 + Send + Sync>;

impl Meaning {
    fn new(transfer: Transfer, to_srgb: DMat3) -> Self {
        Self { curves: [(); 3].map(|()| -> Curve { Box::new(move |code| transfer.decode(code)) }), to_srgb }
    }
}

/// Linear light of an image file, with the file's other statements.
#[derive(Clone, Debug)]
pub struct LinearFile {
    /// Linear light; its warnings are in the notes.
    pub light: LinearImage,
    /// Other statements of the file. Its warnings also name pixels that are filled in, assumed or not finite.
    pub notes: ImageNotes,
}

/// Reads an image as linear light: R, G and B of sRGB, or grey, white at 1 where the file has codes. `is_linear` says
/// that codes are proportional to light, whatever the file states. Digital numbers and quantities stay as they are.
/// Values that are not finite stay, too, with a warning.
pub fn read_linear_image(path: &Path, is_linear: bool, pixels: Pixels) -> Result<LinearFile> {
    let in_file = |invalid: Invalid| invalid.in_file(path);
    let (mut light, mut notes) = match read(path, pixels)? {
        Held::Light(light) => (light, ImageNotes::default()),
        Held::Numbers(file) => {
            let ImageFile { image, notes } = *file;
            let stated = meaning(&notes.colours).map_err(in_file)?;
            let mut light = if is_digital_numbers(&image) && stated.is_none() || is_quantity(&image) {
                let whole = image.whole().map_err(in_file)?;
                LinearImage { components: 0, ..LinearImage::plain(whole.mean) }
            } else {
                LinearImage::plain(linear(image, stated, is_linear).map_err(in_file)?)
            };
            light.pixel_aspect = notes.pixel_aspect.unwrap_or(1.0);
            (light, notes)
        }
    };
    let not_finite = NotFinite::of(&light.planes).map(|found| format!("{found}; they stay as they are"));
    let of_light = light.warnings.drain(..).chain(not_finite);
    notes.left_out.extend(of_light.map(|what| format!("{}: {what}", path.display())));
    Ok(LinearFile { light, notes })
}

/// Content of an image file.
enum Held {
    /// Linear light by the file's header.
    Light(LinearImage),
    /// Pixel values whose meaning is yet to be found.
    Numbers(Box<ImageFile>),
}

fn read(path: &Path, pixels: Pixels) -> Result<Held> {
    let in_file = |invalid: Invalid| invalid.in_file(path);
    match Format::of(path) {
        Some(format) if *format == HDR => {
            let bytes = input::read(path).map_err(|source| Error::io(path, "read", source))?;
            decode_radiance(&bytes).map(Held::Light).map_err(in_file)
        }
        Some(format) if *format == EXR => {
            let image = read_exr_file(path)?;
            let keys = ["unit", "emissiveUnits", "spectralLayoutVersion"];
            if keys.iter().any(|key| image.text(key).is_some()) {
                let image = ImageFile::of_exr(image, path.display().to_string(), pixels);
                return image.map(Box::new).map(Held::Numbers).map_err(in_file);
            }
            of_exr(image).map(Held::Light).map_err(in_file)
        }
        Some(_) | None => ImageFile::read(path, pixels).map(Box::new).map(Held::Numbers),
    }
}

/// Light of an image.
pub struct ImageLight {
    /// Planes proportional to light; white at 1 where the file has integers.
    pub planes: Planes,
    /// Assumption about the pixel values.
    pub assumed: String,
    /// Warnings about the file.
    pub notes: Vec<String>,
}

/// Reads an image as [`read_linear_image`] does, and scales integers of any kind so that the largest becomes 1.
pub fn read_image_light(path: &Path, is_linear: bool) -> Result<ImageLight> {
    let name = path.display();
    let in_proportion = format!("the pixel values of {name} are taken to be proportional to light");
    let ImageFile { image, notes } = match read(path, Pixels::Active)? {
        Held::Light(LinearImage { planes, warnings, white_luminance_nit, .. }) => {
            let level = white_luminance_nit.map(|nit| format!("its whiteLuminance, {nit} cd/m², has no effect"));
            let notes = warnings.into_iter().chain(level).map(|warning| format!("{name}: {warning}")).collect();
            return Ok(ImageLight { planes, assumed: in_proportion, notes });
        }
        Held::Numbers(file) => *file,
    };
    let in_file = |invalid: Invalid| invalid.in_file(path);
    let stated = meaning(&notes.colours).map_err(in_file)?;
    let is_stated = stated.is_some();
    let (planes, assumed) = match image.full_scale {
        None if is_quantity(&image) => (image.whole().map_err(in_file)?.mean, in_proportion),
        None => (linear(image, stated, is_linear).map_err(in_file)?, in_proportion),
        Some(white) if is_digital_numbers(&image) && !is_stated => {
            let assumed = format!("the pixel values of {name} are taken to be proportional to light, {white} for 1");
            (image.mean.scaled(1.0 / white), assumed)
        }
        Some(white) => {
            let assumed = match (is_linear, is_stated) {
                (true, _) => format!("the codes of {name} are taken to be proportional to light, {white} for 1"),
                (false, true) => {
                    format!("the codes of {name} are decoded to linear light as the file says, {white} to 1")
                }
                (false, false) => format!(
                    "the codes of {name}, which says nothing of them, are decoded to linear light as sRGB, {white} to 1"
                ),
            };
            (linear(image, stated, is_linear).map_err(in_file)?, assumed)
        }
    };
    Ok(ImageLight { planes, assumed, notes: notes.of_pixels_as_they_lie(&name.to_string()) })
}

/// Linear light of each code of R, G and B (and of grey: R) from 0 to `largest`, 1 for white; and whether the file
/// states it: otherwise it is that of sRGB.
pub fn light_of_codes(colours: &StatedColours, largest: u16) -> Result<([Vec<f32>; 3], bool), Invalid> {
    let stated = meaning(colours)?;
    let is_stated = stated.is_some();
    let Meaning { curves, .. } = stated.unwrap_or_else(|| Meaning::new(Transfer::Srgb, DMat3::IDENTITY));
    let of_codes = |curve: &Curve| (0..=largest).map(|code| curve(f32::from(code) / f32::from(largest))).collect();
    Ok((curves.each_ref().map(of_codes), is_stated))
}

/// Whether the pixel values are digital numbers of a sensor, unless the file says otherwise.
fn is_digital_numbers(image: &ComparedImage) -> bool {
    image.unit.as_deref() == Some("DN")
}

/// Whether the pixel values are those of a quantity with a unit.
fn is_quantity(image: &ComparedImage) -> bool {
    image.full_scale.is_none() && image.unit.is_some()
}

/// Linear sRGB of codes, or of floating-point values in another space.
fn linear(image: ComparedImage, stated: Option<Meaning>, is_linear: bool) -> Result<Planes, Invalid> {
    let Meaning { mut curves, to_srgb } = stated.unwrap_or_else(|| Meaning::new(Transfer::Srgb, DMat3::IDENTITY));
    if is_linear || image.full_scale.is_none() {
        curves = Meaning::new(Transfer::Linear, to_srgb).curves;
    }
    let mut planes = image.mean;
    let [width, height] = [planes.width(), planes.height()];
    if let Some(full_scale) = image.full_scale {
        for channel in planes.channels_mut() {
            let curve = &curves[["R", "G", "B"].iter().position(|name| channel.name == *name).unwrap_or(0)];
            let table: Vec<f32> =
                (0..=full_scale as usize).map(|code| curve(code as f32 / full_scale as f32)).collect();
            channel.data.par_iter_mut().for_each(|code| *code = table[(*code as usize).min(table.len() - 1)]);
            if channel.name == "raw" {
                channel.name = "Y".to_owned();
            }
        }
    }
    let [Some(r), Some(g), Some(b)] = ["R", "G", "B"].map(|name| planes.plane(name)) else { return Ok(planes) };
    if to_srgb == DMat3::IDENTITY {
        return Ok(planes);
    }
    let converted = ["R", "G", "B"].into_iter().enumerate().map(|(row, name)| {
        let DVec3 { x, y, z } = to_srgb.row(row);
        let value = |i: usize| (x * f64::from(r[i]) + y * f64::from(g[i]) + z * f64::from(b[i])) as f32;
        Channel { name: name.to_owned(), data: (0..width * height).into_par_iter().map(value).collect() }
    });
    Planes::new(width, height, converted.collect())
}

/// Meaning of the pixel values by the file's statements of colours.
fn meaning(colours: &StatedColours) -> Result<Option<Meaning>, Invalid> {
    if let Some([primaries, transfer]) = colours.code_points {
        return of_code_points(primaries, transfer).map(Some);
    }
    if let Some(profile) = &colours.profile {
        return of_profile(profile).map(Some);
    }
    if colours.srgb.is_some() {
        return Ok(Some(Meaning::new(Transfer::Srgb, DMat3::IDENTITY)));
    }
    let to_srgb = colours.chromaticities.map_or(Ok(DMat3::IDENTITY), |points| {
        to_srgb(points).map_err(|invalid| Invalid { key: "cHRM".to_owned(), ..invalid })
    })?;
    let gamma = colours.gamma.filter(|gamma| *gamma > 0.0);
    Ok(gamma.map(|gamma| Meaning::new(Transfer::Gamma(1.0 / gamma), to_srgb)))
}

/// Meaning by code points of H.273.
fn of_code_points(primaries: u8, transfer: u8) -> Result<Meaning, Invalid> {
    let space = match primaries {
        1 => ColourSpace::Srgb,
        9 => ColourSpace::Rec2020,
        12 => ColourSpace::DisplayP3,
        other => return Err(not_read("cICP", &format!("primaries of the number {other} (H.273)"))),
    };
    // Those of PQ and HLG tell the light of a screen, others nothing.
    let curve = TransferCharacteristics::try_from(transfer).ok().filter(|_| ![0, 2, 3, 16, 18].contains(&transfer));
    let Some(curve) = curve else {
        return Err(not_read("cICP", &format!("the transfer function of the number {transfer} (H.273)")));
    };
    let to_srgb = if space == ColourSpace::Srgb {
        DMat3::IDENTITY
    } else {
        ColourSpace::Srgb.from_xyz(space.white()) * space.to_xyz()
    };
    let curves = match transfer {
        13 => return Ok(Meaning::new(Transfer::Srgb, to_srgb)),
        _ => [(); 3].map(|()| -> Curve { Box::new(move |code| curve.linearize(f64::from(code)) as f32) }),
    };
    Ok(Meaning { curves, to_srgb })
}

fn of_profile(bytes: &[u8]) -> Result<Meaning, Invalid> {
    let damaged =
        |error: moxcms::CmsError| Invalid::new("ICC profile", format!("cannot be read: {error}")).help(convert());
    let profile = ColorProfile::new_from_slice(bytes).map_err(damaged)?;
    let curve = |trc: &Option<ToneReprCurve>| -> Result<Curve, Invalid> {
        let Some(trc) = trc else { return Err(not_read("ICC profile", "tables in place of curves and a matrix")) };
        let evaluator = trc.make_linear_evaluator().map_err(damaged)?;
        Ok(Box::new(move |code| evaluator.evaluate_value(code)))
    };
    if profile.color_space == DataColorSpace::Gray {
        let [r, g, b] = [(); 3].map(|()| curve(&profile.gray_trc));
        return Ok(Meaning { curves: [r?, g?, b?], to_srgb: DMat3::IDENTITY });
    }
    if profile.color_space == DataColorSpace::Rgb {
        let [r, g, b] = [&profile.red_trc, &profile.green_trc, &profile.blue_trc].map(curve);
        let colorants = [profile.red_colorant, profile.green_colorant, profile.blue_colorant];
        let to_xyz = colorants.map(|c| DVec3::new(c.x, c.y, c.z));
        let to_xyz = DMat3::from_cols(to_xyz[0], to_xyz[1], to_xyz[2]);
        return Ok(Meaning { curves: [r?, g?, b?], to_srgb: ColourSpace::Srgb.from_xyz(D50) * to_xyz });
    }
    Err(not_read("ICC profile", &format!("colours of the kind {:?}", profile.color_space)))
}

fn convert() -> Help {
    Help::any(["convert the image to sRGB first".into(), Remedy::Linear])
}

fn not_read(key: &str, what: &str) -> Invalid {
    Invalid::new(key, format!("{what} are not read")).help(convert())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::developed::{write_encoded, write_linear};
    use crate::formats::{JPEG, PNG, PPM, TIFF};
    use photosite_core::output::write_whole;
    use photosite_develop::{Codes, EncodedImage, Encoding, encode};

    /// Test colours, the same in each space.
    fn planes(space: ColourSpace) -> Planes {
        let from_srgb = space.from_xyz(ColourSpace::Srgb.white()) * ColourSpace::Srgb.to_xyz();
        let colours = [[0.2, 0.4, 0.6], [0.9, 0.3, 0.1], [0.5, 0.5, 0.5], [0.05, 0.1, 0.7]];
        let colours = colours.map(|rgb| from_srgb * DVec3::from_array(rgb));
        let names = if space == ColourSpace::Xyz { ["X", "Y", "Z"] } else { ["R", "G", "B"] };
        let plane = |(i, name): (usize, &str)| Channel {
            name: name.to_owned(),
            data: colours.iter().map(|colour| colour[i] as f32).collect(),
        };
        Planes::new(2, 2, names.into_iter().enumerate().map(plane).collect()).expect("right sizes")
    }

    #[test]
    fn every_space_and_format_gives_the_same_colours() {
        let folder = tempfile::tempdir().expect("a folder");
        let expected = planes(ColourSpace::Srgb);
        let check = |path: &Path, tolerance: f32| {
            let found = read_linear_image(path, false, Pixels::Active).expect("read").light.planes;
            for channel in expected.channels() {
                let found = found.plane(&channel.name).expect("R, G and B");
                let largest = channel.data.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(largest < tolerance, "{}: {} is off by {largest}", path.display(), channel.name);
            }
        };
        for space in ColourSpace::ALL {
            let path = folder.path().join(format!("{space:?}.exr"));
            write_whole(&path, |to| write_linear(&planes(space), space, 1.0, to)).expect("written");
            // Chromaticities are 32-bit floats.
            check(&path, 1e-5);
            for transfer in [Transfer::Linear, Transfer::Srgb, Transfer::Gamma(2.2), Transfer::Gamma(1.8)] {
                let encoding = Encoding {
                    colour_space: space,
                    transfer,
                    bits: 16,
                    dither: false,
                    sharpening: 0.0,
                    sharpening_radius_px: 1.0,
                };
                if space == ColourSpace::Xyz {
                    continue;
                }
                let image = encode(planes(space), &encoding);
                for (format, extension) in [(PNG, "png"), (TIFF, "tiff")] {
                    let path = folder.path().join(format!("{space:?}-{transfer:?}.{extension}"));
                    write_whole(&path, |to| write_encoded(&image, &format, to)).expect("written");
                    // Profiles have 16 bits behind the point, as codes have; wide spaces and steep curves multiply
                    // that.
                    check(&path, 2e-4);
                }
            }
        }
    }

    #[test]
    fn what_says_nothing_is_srgb_and_jpeg_has_a_profile() {
        let folder = tempfile::tempdir().expect("a folder");
        let (colour_space, transfer) = (ColourSpace::DisplayP3, Transfer::Srgb);
        // JPEG halves the resolution of colours: one colour for all pixels.
        let codes = Codes::U8([180, 90, 60].repeat(64));
        let image =
            EncodedImage { width: 8, height: 8, components: 3, codes, colour_space, transfer, pixel_aspect: 1.0 };
        for (format, name) in [(JPEG, "a.jpg"), (PPM, "a.ppm")] {
            let path = folder.path().join(name);
            write_whole(&path, |to| write_encoded(&image, &format, to)).expect("written");
            let found = read_linear_image(&path, false, Pixels::Active).expect("read").light.planes;
            let rgb = DVec3::from_array([180.0f32, 90.0, 60.0].map(|code| transfer.decode(code / 255.0).into()));
            let expected = match format.has_profile {
                true => ColourSpace::Srgb.from_xyz(colour_space.white()) * colour_space.to_xyz() * rgb,
                false => rgb,
            };
            for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
                // Three codes of JPEG, of up to 2/255/2.4 each in linear light, through a matrix.
                let found = found.plane(name).expect("three channels")[27];
                assert!((f64::from(found) - expected[i]).abs() < 0.02, "{name} of {format:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn what_cannot_be_converted_is_refused_by_name() {
        for (primaries, transfer, named) in [(2, 13, "primaries of the number 2"), (9, 16, "function of the number 16")]
        {
            let error = of_code_points(primaries, transfer).err().expect("refused");
            assert!(error.message.contains(named) && error.help.is_some(), "{error}");
        }
        assert_eq!(of_profile(b"nothing of the kind").err().expect("refused").key, "ICC profile");
        let mut tables = ColorProfile::new_srgb();
        tables.green_trc = None;
        assert!(of_profile(&tables.encode().expect("encoded")).is_err());
    }
}
