//! Environment pictures: Radiance HDR and OpenEXR files of linear sRGB.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, Vec2, read};

use super::picture::decode_picture;
use photosite_core::Invalid;
use photosite_core::warnings::Warnings;
use photosite_core::{input, memory};
use photosite_transport::texture::{Bitmap, Texels};

/// First bytes of an OpenEXR file.
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];
/// Largest picture: 16384 × 8192 texels take 1.6 GB.
const MAX_TEXELS: usize = 1 << 27;
/// Pixels for each byte of a file; no compression of OpenEXR makes more of one.
const MOST_INFLATION: usize = 1 << 12;

/// Reads an environment picture, as [`decode_environment`] does.
pub fn read_environment(path: &Path, warnings: &mut Warnings) -> Result<Bitmap, Invalid> {
    let name = path.display().to_string();
    let bytes = input::read(path).map_err(|source| {
        Invalid::new("", format!("cannot read {name}: {source}"))
            .help("paths are relative to the file that contains them")
    })?;
    decode_environment(&bytes, name, warnings)
}

/// Decodes an environment picture; `name` is for messages. Texels that are not finite are refused; negative ones, which the filters of editing
/// programs leave behind, become zero with a warning.
pub fn decode_environment(bytes: &[u8], name: String, warnings: &mut Warnings) -> Result<Bitmap, Invalid> {
    let mut picture = if bytes.starts_with(EXR_MAGIC) {
        decode_exr(bytes, name)?
    } else {
        let help = "the picture is damaged, or neither Radiance HDR (.hdr) nor OpenEXR (.exr); export it again";
        decode_picture(bytes, name).map_err(|invalid| invalid.help(help))?
    };
    let Texels::Rgb32F(texels) = &mut picture.texels else {
        let message = format!("{} has no more than 16 bits, too few for a sky with a sun", picture.name);
        return Err(Invalid::new("", message).help("use a Radiance HDR (.hdr) or OpenEXR (.exr) picture"));
    };
    if let Some(i) = texels.iter().position(|texel| !texel.iter().all(|c| c.is_finite())) {
        let (x, y) = (i % picture.width, i / picture.width);
        let message = format!("{}: the texel in column {x}, row {y} is not finite: {:?}", picture.name, texels[i]);
        return Err(Invalid::new("", message)
            .help("fix the picture; a sun brighter than 65504 does not fit into half-precision files"));
    }
    let mut negative = 0;
    for component in texels.as_flattened_mut().iter_mut().filter(|component| **component < 0.0) {
        *component = 0.0;
        negative += 1;
    }
    if negative > 0 {
        warnings.once(format!("{}: {negative} negative values are taken to be 0", picture.name));
    }
    Ok(picture)
}

/// Decodes the first layer that has red, green and blue.
fn decode_exr(bytes: &[u8], name: String) -> Result<Bitmap, Invalid> {
    let bad = |problem: &dyn std::fmt::Display| {
        Invalid::new("", format!("cannot decode {name}: {problem}"))
            .help("an environment needs the channels R, G and B")
    };
    // The sizes in the header decide how much is allocated, so they are looked at first.
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| bad(&e))?.headers;
    let texels = |size: Vec2<usize>| size.width().saturating_mul(size.height());
    let most = headers.iter().map(|header| texels(header.layer_size)).max().unwrap_or(0);
    if most > bytes.len().saturating_mul(MOST_INFLATION) {
        return Err(bad(&format!("its {} bytes cannot hold its pixels", bytes.len())));
    }
    // In the file's own planes, and side by side.
    memory::check(most as u64 * 24, &format!("decoding the {most} pixels of {name}"), "make the picture smaller")?;
    if headers.iter().any(|header| header.layer_size.width().saturating_mul(header.layer_size.height()) > MAX_TEXELS) {
        return Err(bad(&format!("it has more than {MAX_TEXELS} pixels")));
    }
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0f32; 3]; size.width() * size.height()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| texels[at.y() * *width + at.x()] = [r, g, b],
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| bad(&e))?;
    let (width, texels) = image.layer_data.channel_data.pixels;
    let height = texels.len() / width.max(1);
    if texels.is_empty() {
        return Err(Invalid::new("", format!("{name} has no pixels")));
    }
    Ok(Bitmap { name, width, height, texels: Texels::Rgb32F(texels) })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const SKY: [[f32; 3]; 2] = [[0.25, 1.0, 2000.0], [0.5, 0.125, 0.0]];

    fn write_exr(path: &Path, texels: [[f32; 3]; 2]) {
        exr::prelude::write_rgb_file(path, 2, 1, |x, _| texels[x].into()).expect("written");
    }

    fn texels(picture: &Bitmap) -> &[[f32; 3]] {
        match &picture.texels {
            Texels::Rgb32F(texels) => texels,
            Texels::Rgba8(_) | Texels::Rgba16(_) => panic!("{:?}", picture.texels),
        }
    }

    #[test]
    fn exr_and_hdr_pictures_are_read_in_linear_rgb() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let exr = folder.path().join("sky.exr");
        write_exr(&exr, SKY);
        let mut warnings = Warnings::default();
        let picture = read_environment(&exr, &mut warnings).expect("valid");
        assert_eq!((picture.width, picture.height, texels(&picture)), (2, 1, &SKY[..]));

        let hdr = folder.path().join("sky.hdr");
        let pixels = image::Rgb32FImage::from_fn(2, 1, |x, _| image::Rgb(SKY[x as usize]));
        pixels.save(&hdr).expect("written");
        let picture = read_environment(&hdr, &mut warnings).expect("valid");
        for (read, written) in texels(&picture).iter().zip(&SKY) {
            // RGBE has 8 bits of mantissa, scaled by the largest component.
            let tolerance = written.iter().fold(0.0f32, |m, c| m.max(*c)) / 128.0;
            assert!(read.iter().zip(written).all(|(r, w)| (r - w).abs() <= tolerance), "{read:?} {written:?}");
        }
        assert!(warnings.into_messages().is_empty());
    }

    #[test]
    fn what_is_not_finite_is_refused_and_what_is_negative_reported() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("sky.exr");
        write_exr(&path, [SKY[0], [1.0, f32::INFINITY, 1.0]]);
        let error = read_environment(&path, &mut Warnings::default()).expect_err("infinite");
        assert!(error.message.contains("column 1, row 0"), "{error}");
        write_exr(&path, [SKY[0], [1.0, -0.5, 1.0]]);
        let mut warnings = Warnings::default();
        let picture = read_environment(&path, &mut warnings).expect("mended");
        assert_eq!(texels(&picture)[1], [1.0, 0.0, 1.0]);
        assert!(warnings.into_messages()[0].contains("1 negative"));
    }

    #[test]
    fn torn_missing_and_unsuitable_pictures_are_refused() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("sky.exr");
        write_exr(&path, SKY);
        let bytes = fs::read(&path).expect("there");
        for len in 0..bytes.len() {
            fs::write(&path, &bytes[..len]).expect("written");
            assert!(read_environment(&path, &mut Warnings::default()).is_err(), "{len} of {} bytes", bytes.len());
        }
        image::RgbImage::new(1, 1).save(folder.path().join("sky.png")).expect("written");
        for name in ["sky.png", "absent.hdr"] {
            let error = read_environment(&folder.path().join(name), &mut Warnings::default()).expect_err(name);
            assert!(error.message.contains(name), "{error}");
        }
    }
}
