//! Raw images as OpenEXR: digital numbers as 32-bit floats, which hold 16-bit integers exactly.
//!
//! The planes are those that [`read_image_file`](super::image_file::read_image_file) makes of any raw file:
//! `raw`, or one for each channel where every pixel has all. Attributes: `unit` "DN", `cfa`, `blackLevel` (the mean),
//! `whiteLevel`, and where there are masked pixels `activeArea`: column, row, width and height of those that see light.

use std::io::{self, BufRead, Seek, Write};

use super::exr::{Attribute, ExrImage, read_exr, write_exr};
use photosite_core::Invalid;
use photosite_measure::validation::ComparedImage;
use photosite_raw::{BlackLevel, Cfa, PixelArea, Pixels, RawImage};

/// Name of the attribute of the active area.
const ACTIVE_AREA: &str = "activeArea";

/// Writes an EXR file. The image must have pixels.
pub fn write_raw_exr<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    let mut attributes = vec![
        ("unit", Attribute::Text("DN".to_owned())),
        ("cfa", Attribute::Text(raw.cfa.to_string())),
        ("blackLevel", Attribute::Number(raw.black_level_dn.mean().into())),
        ("whiteLevel", Attribute::Number(raw.white_level_dn.into())),
    ];
    if let Some(PixelArea { x, y, width, height }) = raw.active_area {
        attributes.push((ACTIVE_AREA, Attribute::Text(format!("{x} {y} {width} {height}"))));
    }
    write_exr(&ComparedImage::from_raw(String::new(), raw.clone(), Pixels::All).mean, &attributes, to)
}

/// Active area: the pixels that see light, where the file states it.
pub(super) fn stated_active_area(image: &ExrImage) -> Result<Option<PixelArea>, Invalid> {
    let Some(text) = image.text(ACTIVE_AREA) else { return Ok(None) };
    let numbers: Option<Vec<usize>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let fits = |first: usize, length: usize, side: usize| {
        length > 0 && first.checked_add(length).is_some_and(|end| end <= side)
    };
    match numbers.as_deref() {
        Some(&[x, y, width, height])
            if fits(x, width, image.planes.width()) && fits(y, height, image.planes.height()) =>
        {
            Ok(Some(PixelArea { x, y, width, height }))
        }
        _ => {
            let message = format!("{text:?} is not a part of the image");
            Err(Invalid::new(ACTIVE_AREA, message).help("it says column, row, width and height: 8 4 640 480"))
        }
    }
}

/// Reads a file of [`write_raw_exr`]. Values are rounded to integers.
pub fn read_raw_exr<R: BufRead + Seek>(from: R) -> Result<RawImage, Invalid> {
    let image = read_exr(from)?.whole()?;
    let (Some("DN"), Some(cfa)) = (image.text("unit"), image.text("cfa")) else {
        let help = "give a raw.exr that photosite wrote, or a DNG, TIFF, PGM, PPM or NPY file";
        return Err(Invalid::new("", "is not a raw image: it has no attributes unit = \"DN\" and cfa").help(help));
    };
    let cfa = Cfa::parse(cfa)?;
    let active_area = stated_active_area(&image)?;
    let planes = &image.planes;
    let names = if cfa.is_full() { cfa.channels() } else { &["raw".to_owned()] };
    let channels: Option<Vec<&[f32]>> = names.iter().map(|name| planes.plane(name)).collect();
    let Some(channels) = channels else {
        return Err(Invalid::new("", format!("has no plane {}", names.join(", "))).help("the file is damaged"));
    };
    let (width, height, samples) = (planes.width(), planes.height(), channels.len());
    let values = (0..width * height * samples).map(|i| channels[i % samples][i / samples].round());
    if values.clone().any(|dn| !(0.0..=65_535.0).contains(&dn)) {
        return Err(Invalid::new("", "its digital numbers do not lie from 0 to 65535").help("the file is damaged"));
    }
    let level = |name: &str, otherwise: f64| {
        let level = image.number(name).unwrap_or(otherwise);
        if (0.0..=65_535.0).contains(&level) {
            return Ok(level);
        }
        Err(Invalid::new(name, format!("must lie from 0 to 65535, got {level}")).help("the file is damaged"))
    };
    let (black, white) = (level("blackLevel", 0.0)?, level("whiteLevel", 65_535.0)?);
    Ok(RawImage {
        width,
        height,
        data: values.map(|dn| dn as u16).collect(),
        cfa,
        active_area,
        bits: (u16::BITS - (white as u16).leading_zeros()).max(8),
        black_level_dn: BlackLevel::uniform(black as f32),
        white_level_dn: white as u16,
        ..RawImage::default()
    })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn raw_images_come_back() {
        let masked = PixelArea { x: 1, y: 2, width: 5, height: 3 };
        for (cfa, active_area) in
            [("GRBG", None), ("mono", None), ("x-trans", Some(masked)), ("full:RGB", Some(masked))]
        {
            let cfa = Cfa::parse(cfa).expect("known");
            let data = (0..7 * 5 * cfa.samples_per_pixel()).map(|i| (i * 37 % 4096) as u16).collect();
            let (black_level_dn, white_level_dn) = (64.into(), 4095);
            let raw = RawImage {
                width: 7,
                height: 5,
                data,
                cfa,
                active_area,
                bits: 12,
                black_level_dn,
                white_level_dn,
                ..RawImage::default()
            };
            let mut file = Cursor::new(Vec::new());
            write_raw_exr(&raw, &mut file).expect("written");
            file.set_position(0);
            assert_eq!(read_raw_exr(file), Ok(raw));
        }
    }

    #[test]
    fn other_images_are_refused() {
        let planes = photosite_core::image::Planes::zeros(2, 2, ["raw"]);
        let dn = ("unit", Attribute::Text("DN".to_owned()));
        let cfa = |cfa: &str| ("cfa", Attribute::Text(cfa.to_owned()));
        for attributes in [
            vec![],
            vec![dn.clone()],
            vec![dn.clone(), cfa("RGBGR")],
            vec![dn.clone(), cfa("full:RGB")],
            vec![dn.clone(), cfa("mono"), ("whiteLevel", Attribute::Number(f64::NAN))],
            vec![dn, cfa("mono"), (ACTIVE_AREA, Attribute::Text("1 0 2 2".to_owned()))],
        ] {
            let mut file = Cursor::new(Vec::new());
            write_exr(&planes, &attributes, &mut file).expect("written");
            file.set_position(0);
            assert!(read_raw_exr(file).expect_err("refused").help.is_some(), "{attributes:?}");
        }
    }
}
