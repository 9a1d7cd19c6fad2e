//! Raw pictures as OpenEXR: the digital numbers as 32-bit floats, which hold those of 16 bits exactly.
//!
//! The planes are those that [`read_picture_file`](super::picture_file::read_picture_file) makes of any raw file: `raw`, or
//! one for each channel where every pixel has all. Attributes: `unit` "DN", `cfa`, `blackLevel` (the mean), `whiteLevel`.

use std::io::{self, BufRead, Seek, Write};

use super::exr::{Attribute, read_exr, write_exr};
use crate::Invalid;
use crate::raw::{BlackLevel, Cfa, RawImage};
use crate::validation::Picture;

/// Writes an EXR file. The picture must have pixels.
pub fn write_raw_exr<W: Write + Seek>(raw: &RawImage, to: W) -> io::Result<()> {
    let attributes = [
        ("unit", Attribute::Text("DN".to_owned())),
        ("cfa", Attribute::Text(raw.cfa.to_string())),
        ("blackLevel", Attribute::Number(raw.black_level_dn.mean().into())),
        ("whiteLevel", Attribute::Number(raw.white_level_dn.into())),
    ];
    write_exr(&Picture::from_raw(String::new(), raw.clone()).mean, &attributes, to)
}

/// Reads what [`write_raw_exr`] writes. Numbers are rounded to whole ones.
pub fn read_raw_exr<R: BufRead + Seek>(from: R) -> Result<RawImage, Invalid> {
    let picture = read_exr(from)?;
    let (Some("DN"), Some(cfa)) = (picture.text("unit"), picture.text("cfa")) else {
        let help = "give a raw.exr that photosite wrote, or a DNG, 16-bit TIFF, PGM, PPM or NPY file";
        return Err(Invalid::new("", "is no raw picture: it has no attributes unit = \"DN\" and cfa").help(help));
    };
    let cfa = Cfa::parse(cfa)?;
    let planes = &picture.planes;
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
        let level = picture.number(name).unwrap_or(otherwise);
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
    fn raw_pictures_come_back() {
        for cfa in ["GRBG", "mono", "x-trans", "full:RGB"] {
            let cfa = Cfa::parse(cfa).expect("known");
            let data = (0..7 * 5 * cfa.samples_per_pixel()).map(|i| (i * 37 % 4096) as u16).collect();
            let (black_level_dn, white_level_dn) = (64.into(), 4095);
            let raw = RawImage {
                width: 7,
                height: 5,
                data,
                cfa,
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
    fn other_pictures_are_refused() {
        let planes = crate::image::Planes::zeros(2, 2, ["raw"]);
        let dn = ("unit", Attribute::Text("DN".to_owned()));
        let cfa = |cfa: &str| ("cfa", Attribute::Text(cfa.to_owned()));
        for attributes in [
            vec![],
            vec![dn.clone()],
            vec![dn.clone(), cfa("RGBGR")],
            vec![dn.clone(), cfa("full:RGB")],
            vec![dn, cfa("mono"), ("whiteLevel", Attribute::Number(f64::NAN))],
        ] {
            let mut file = Cursor::new(Vec::new());
            write_exr(&planes, &attributes, &mut file).expect("written");
            file.set_position(0);
            assert!(read_raw_exr(file).expect_err("refused").help.is_some(), "{attributes:?}");
        }
    }
}
