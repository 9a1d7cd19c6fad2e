//! `irradiance.exr`: spectral irradiance on the sensor in the OpenEXR layout for spectral images
//! ([Fichet21](photosite_core::references#fichet21)).
//!
//! Every band is a channel called `S0.550,0nm` after its central wavelength, W·m⁻²·nm⁻¹ (`S0`: the unpolarised part; a
//! comma, because points separate layers). The attributes `spectralLayoutVersion` and `emissiveUnits` say so. The
//! channels `R`, `G` and `B` are a preview for viewers that know nothing of spectra: linear sRGB, scaled so that one
//! pixel in a hundred is brighter than white.

use std::io::{self, BufRead, Seek, Write};
use std::sync::Mutex;

use glam::DVec3;
use rayon::prelude::*;

use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};
use photosite_core::spectrum::{cie, rgb};

use super::exr::{Attribute, ExrImage, NamedPlane, Values, read_exr, write_planes};
use super::image_rows::ImageRows;

const PREFIX: &str = "S0.";
const SUFFIX: &str = "nm";
const UNITS: &str = "W.m^-2.nm^-1";

/// Writes bands, whose names are their central wavelengths in nm (`550`).
pub fn write_irradiance<W: Write + Seek>(bands: &dyn ImageRows, to: W) -> io::Result<()> {
    let mut wavelengths = Vec::new();
    for name in bands.names() {
        let lambda_nm = name.parse::<f64>().ok().filter(|lambda| lambda.is_finite() && *lambda > 0.0);
        wavelengths.push(lambda_nm.ok_or_else(|| {
            io::Error::other(format!("a spectral band is named by its wavelength in nm, not {name:?}"))
        })?);
    }
    let preview = Preview::new(bands, &wavelengths)?;
    // `{:?}` keeps one decimal of whole numbers, as the layout's own examples have it.
    let names = wavelengths.iter().map(|nm| format!("{PREFIX}{}{SUFFIX}", format!("{nm:?}").replace('.', ",")));
    let planes = names.enumerate().map(|(plane, name)| NamedPlane { name, of: bands, plane });
    let of_preview = preview.names().into_iter().enumerate().map(|(plane, name)| NamedPlane {
        name: name.to_owned(),
        of: &preview,
        plane,
    });
    let attributes = [
        ("spectralLayoutVersion", Attribute::Text("1.0".to_owned())),
        ("emissiveUnits", Attribute::Text(UNITS.to_owned())),
    ];
    write_planes(Values::Noisy, bands.size(), of_preview.chain(planes), &attributes, to)
}

/// Reads bands, sorted by wavelength, named by their central wavelengths in nm.
pub fn read_irradiance<R: BufRead + Seek>(from: R) -> Result<Planes, Invalid> {
    irradiance(read_exr(from)?.whole()?)
}

/// Bands of an EXR image that is in memory, as [`read_irradiance`] reads them from a file.
pub fn irradiance(image: ExrImage) -> Result<Planes, Invalid> {
    if image.text("spectralLayoutVersion").is_none() {
        return Err(Invalid::new("spectralLayoutVersion", "missing, so this is not a spectral image")
            .help("give the irradiance.exr that photosite render wrote"));
    }
    match image.text("emissiveUnits") {
        Some(UNITS) => {}
        found => {
            let message = format!("{} instead of {UNITS}", found.unwrap_or("missing"));
            return Err(
                Invalid::new("emissiveUnits", message).help("only irradiance on a sensor can be exposed, not radiance")
            );
        }
    }
    bands(image.planes)
}

/// Wavelength, nm, of a channel of an EXR file that is a spectral band.
pub fn band_of_channel(name: &str) -> Option<f64> {
    name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)?.replace(',', ".").parse().ok()
}

/// Planes of spectral bands, sorted by wavelength, named by their central wavelengths in nm.
pub(super) fn bands(planes: Planes) -> Result<Planes, Invalid> {
    let (width, height) = (planes.width(), planes.height());
    let mut bands: Vec<(f64, Channel)> =
        planes.into_channels().into_iter().filter_map(|c| Some((band_of_channel(&c.name)?, c))).collect();
    bands.sort_by(|a, b| a.0.total_cmp(&b.0));
    let channel = |(lambda_nm, c): (f64, Channel)| Channel { name: format!("{lambda_nm}"), data: c.data };
    Planes::new(width, height, bands.into_iter().map(channel).collect())
}

/// Preview: R, G and B of the light for the standard observer.
struct Preview<'a> {
    bands: &'a dyn ImageRows,
    /// Weights of each band in the preview's channels.
    weights: Vec<DVec3>,
    scale: f64,
    /// Row that was asked for last, since each row is asked for three times.
    row: Mutex<Option<(usize, Vec<DVec3>)>>,
}

impl<'a> Preview<'a> {
    fn new(bands: &'a dyn ImageRows, wavelengths_nm: &[f64]) -> io::Result<Self> {
        let weight = |&lambda_nm: &f64| {
            let observer = cie::observer().each_ref().map(|bar| f64::from(bar.eval(lambda_nm as f32)));
            *rgb::xyz_to_rgb() * DVec3::from_array(observer)
        };
        let weights = wavelengths_nm.iter().map(weight).collect();
        let preview = Self { bands, weights, scale: 1.0, row: Mutex::new(None) };
        let [width, height] = bands.size();
        let pixels = width * height;
        let mut luminances = vec![0.0; pixels];
        luminances.par_chunks_mut(width.max(1)).enumerate().try_for_each(|(row, luminances)| {
            let colours = preview.colours(row)?;
            luminances.iter_mut().zip(colours).for_each(|(to, colour)| *to = rgb::luminance(colour.to_array()));
            io::Result::Ok(())
        })?;
        let bright = (pixels * 99 / 100).min(pixels.saturating_sub(1));
        let white = if pixels == 0 { 0.0 } else { *luminances.select_nth_unstable_by(bright, f64::total_cmp).1 };
        let scale = if white.is_finite() && white > 0.0 { 1.0 / white } else { 1.0 };
        Ok(Self { scale, ..preview })
    }

    /// Colours of a row.
    fn colours(&self, row: usize) -> io::Result<Vec<DVec3>> {
        let mut values = vec![0.0; self.bands.size()[0]];
        let mut colours = vec![DVec3::ZERO; values.len()];
        for (band, &weight) in self.weights.iter().enumerate() {
            self.bands.read_row(band, row, &mut values)?;
            for (colour, &value) in colours.iter_mut().zip(&values) {
                *colour += weight * f64::from(value);
            }
        }
        Ok(colours)
    }
}

impl ImageRows for Preview<'_> {
    fn size(&self) -> [usize; 2] {
        self.bands.size()
    }

    fn names(&self) -> Vec<&str> {
        vec!["R", "G", "B"]
    }

    fn read_row(&self, plane: usize, row: usize, to: &mut [f32]) -> io::Result<()> {
        let mut last = self.row.lock().expect("nobody panics while holding it");
        let colours = match last.take() {
            Some((number, colours)) if number == row => colours,
            Some(_) | None => self.colours(row)?,
        };
        let colours = &last.insert((row, colours)).1;
        for (value, colour) in to.iter_mut().zip(colours) {
            *value = (colour[plane] * self.scale) as f32;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::exr::write_exr;
    use photosite_core::spectrum::illuminant;

    fn bands(value: impl Fn(f64, usize) -> f64) -> Planes {
        let lambdas = (0..75).map(|i| 355.0 + 10.0 * f64::from(i));
        let channel = |lambda: f64| Channel {
            name: format!("{lambda}"),
            data: (0..6).map(|pixel| value(lambda, pixel) as f32).collect(),
        };
        Planes::new(3, 2, lambdas.map(channel).collect()).expect("right sizes")
    }

    #[test]
    fn bands_come_back_in_order() {
        let planes = bands(|lambda, pixel| lambda * 1e-6 + pixel as f64);
        let mut file = Vec::new();
        write_irradiance(&planes, Cursor::new(&mut file)).expect("written");
        assert_eq!(read_irradiance(Cursor::new(&file)).expect("read"), planes);
        let image = read_exr(Cursor::new(&file)).expect("read");
        assert!(image.planes.plane("S0.355,0nm").is_some() && image.planes.plane("S0.1095,0nm").is_some());
        assert_eq!(image.text("emissiveUnits"), Some("W.m^-2.nm^-1"));
    }

    #[test]
    fn d65_previews_as_white() {
        let planes = bands(|lambda, pixel| f64::from(illuminant::d65().eval(lambda as f32)) * (pixel + 1) as f64);
        let mut file = Vec::new();
        write_irradiance(&planes, Cursor::new(&mut file)).expect("written");
        let image = read_exr(Cursor::new(&file)).expect("read");
        for name in ["R", "G", "B"] {
            let brightest = image.planes.plane(name).expect("a preview")[5];
            // Bands of 10 nm instead of 1 nm: a few tenths of a percent.
            assert!((brightest - 1.0).abs() < 5e-3, "{name} {brightest}");
        }
    }

    #[test]
    fn other_images_and_names_are_refused() {
        let unnamed = Planes::zeros(1, 1, ["R"]);
        assert!(write_irradiance(&unnamed, Cursor::new(Vec::new())).is_err());
        let text = |value: &str| Attribute::Text(value.to_owned());
        for (attributes, key) in [
            (vec![], "spectralLayoutVersion"),
            (vec![("spectralLayoutVersion", text("1.0"))], "emissiveUnits"),
            (vec![("spectralLayoutVersion", text("1.0")), ("emissiveUnits", text("W.m^-2.sr^-1"))], "emissiveUnits"),
        ] {
            let mut file = Vec::new();
            write_exr(&unnamed, &attributes, Cursor::new(&mut file)).expect("written");
            assert_eq!(read_irradiance(Cursor::new(&file)).expect_err("refused").key, key);
        }
    }
}
