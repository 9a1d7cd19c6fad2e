//! Electrons from images of other programs, whose pixel values are in proportion to light, given the unit of these
//! values on the sensor.

use rayon::prelude::*;

use photosite_core::Invalid;
use photosite_core::image::{Channel, NotFinite, Planes};
use photosite_core::spectrum::upsampling::unbounded_polynomial;
use photosite_core::spectrum::{Spectrum, cie, illuminant, rgb};

use super::SensorModel;

/// Unit of an image's pixel values on the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImageUnit {
    /// Mean photo-electrons of a pixel during the exposure.
    Electrons,
    /// Parts of the full well, during the exposure.
    FullWell,
    /// Illuminance on the sensor, lx: linear sRGB that is upsampled to multiples of D65
    /// ([`upsampling`](photosite_core::spectrum::upsampling)), (1, 1, 1) being D65 of 1 lx.
    Lux,
    /// Irradiance on the sensor at a single wavelength, W·m⁻²; for images of one plane.
    Irradiance {
        /// Wavelength, nm.
        wavelength_nm: f64,
    },
}

/// Mean electrons that the light of an image frees.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageElectrons {
    /// Electrons of each of the sensor's channels: those of the exposure, or those of a second (e⁻/s).
    pub electrons: Planes,
    /// Whether electrons are those of a second.
    pub per_second: bool,
    /// Warnings about what was assumed or left out.
    pub warnings: Vec<String>,
}

/// The electrons that an image frees whose number 1 is `scale` of a unit. Its planes are R, G and B, or one, or named as
/// the channels of the sensor; transparency (A) is left out.
pub fn image_electrons(
    image: &Planes,
    sensor: &SensorModel,
    unit: ImageUnit,
    scale: f64,
) -> Result<ImageElectrons, Invalid> {
    if !(scale > 0.0 && scale.is_finite()) {
        return Err(Invalid::new("scale", format!("must be above 0, got {scale}")).help("for example 1000"));
    }
    let mut warnings = Vec::new();
    let light = without_negative(image, &mut warnings)?;
    let (channels, per_second) = match unit {
        ImageUnit::Electrons => (by_name(&light, sensor, scale, &mut warnings)?, false),
        ImageUnit::FullWell => (by_name(&light, sensor, scale * sensor.full_well.0, &mut warnings)?, false),
        ImageUnit::Lux => (of_daylight(&light, sensor, scale)?, true),
        ImageUnit::Irradiance { wavelength_nm } => (of_one_wavelength(&light, sensor, scale, wavelength_nm)?, true),
    };
    let electrons = Planes::new(light.width(), light.height(), channels)?;
    if let Some(found) = NotFinite::of(&electrons) {
        let message = format!("as electrons {found}");
        return Err(
            Invalid::new("", message).help("give an image of smaller values, or let a value of 1 be less light")
        );
    }
    Ok(ImageElectrons { electrons, per_second, warnings })
}

/// Planes of light, in which values below 0 are 0; those that are not finite are refused.
pub fn without_negative(image: &Planes, warnings: &mut Vec<String>) -> Result<Planes, Invalid> {
    let (width, height) = (image.width(), image.height());
    let (alpha, channels): (Vec<Channel>, Vec<Channel>) =
        image.clone().into_channels().into_iter().partition(|channel| channel.name == "A");
    if !alpha.is_empty() {
        warnings.push("transparency (A) is not part of the light and is ignored".to_owned());
    }
    let mut light = Planes::new(width, height, channels)?;
    NotFinite::refuse(&light)?;
    let mut negative = 0u64;
    for value in light.channels_mut().iter_mut().flat_map(|channel| &mut channel.data).filter(|value| **value < 0.0) {
        *value = 0.0;
        negative += 1;
    }
    if negative > 0 {
        warnings.push(format!("{negative} pixel values below 0 cannot be light and count as 0"));
    }
    Ok(light)
}

fn names(image: &Planes) -> String {
    image.channels().iter().map(|channel| &channel.name[..]).collect::<Vec<_>>().join(", ")
}

fn scaled(plane: &[f32], factor: f64) -> Vec<f32> {
    plane.iter().map(|&value| (f64::from(value) * factor) as f32).collect()
}

fn red_green_blue(image: &Planes) -> Option<[&[f32]; 3]> {
    match ["R", "G", "B"].map(|name| image.plane(name)) {
        [Some(r), Some(g), Some(b)] => Some([r, g, b]),
        _ => None,
    }
}

/// A channel of the sensor sees the plane of its name, or the only one; a monochrome sensor the luminance of R, G and B.
fn by_name(
    image: &Planes,
    sensor: &SensorModel,
    factor: f64,
    warnings: &mut Vec<String>,
) -> Result<Vec<Channel>, Invalid> {
    let rgb = red_green_blue(image);
    let mut of_channel = |name: &String| {
        let data = match (image.plane(name), image.channels(), rgb) {
            (Some(plane), _, _) => scaled(plane, factor),
            (None, [Channel { data, .. }], _) => scaled(data, factor),
            (None, _, Some([r, g, b])) if sensor.cfa.is_mono() => {
                warnings.push("the monochrome sensor sees the luminance of R, G and B".to_owned());
                let luminance = |i: usize| factor * rgb::luminance([r[i], g[i], b[i]].map(f64::from));
                (0..r.len()).map(|i| luminance(i) as f32).collect()
            }
            (None, _, _) => {
                let message = format!("has the channels {}, but none for {name} of the sensor", names(image));
                let help = "give an image with a channel of that name, or say its light in lux";
                return Err(Invalid::new("", message).help(help));
            }
        };
        Ok(Channel { name: name.clone(), data })
    };
    sensor.cfa.channels().iter().map(&mut of_channel).collect()
}

/// Steps in which spectra of colours, which are smooth, are summed, nm.
const STEP_NM: usize = 5;

/// Electrons a second in light of linear sRGB that is `lux` for white: Σ R_c(λ)·E(λ) with E = r·S(λ)·D65(λ).
fn of_daylight(image: &Planes, sensor: &SensorModel, lux: f64) -> Result<Vec<Channel>, Invalid> {
    let d65 = illuminant::d65();
    let white = d65.scale(lux / cie::luminous(d65));
    let responses = sensor.responses();
    if let [Channel { data, .. }] = image.channels() {
        let grey = |(name, response): (String, Spectrum)| {
            let data = scaled(data, response.product(&white).integral());
            Channel { name, data }
        };
        return Ok(responses.into_iter().map(grey).collect());
    }
    let Some([r, g, b]) = red_green_blue(image) else {
        let message = format!("has the channels {}, and no colours that lux could be of", names(image));
        return Err(Invalid::new("", message).help("give an image of R, G and B, or of one plane"));
    };
    let wavelengths: Vec<f32> = steps(&white).map(|(wavelength, _)| wavelength).collect();
    let of_channel = |(name, response): (String, Spectrum)| {
        let seen = response.product(&white);
        // Sums of steps, made to have the integral that grey has.
        let total: f64 = steps(&seen).map(|(_, sum)| sum).sum();
        let exact = if total > 0.0 { seen.integral() / total } else { 0.0 };
        let weights: Vec<f32> = steps(&seen).map(|(_, sum)| (exact * sum) as f32).collect();
        let rate = |i: usize| {
            let (factor, colour) = unbounded_polynomial([r[i], g[i], b[i]]);
            factor * wavelengths.iter().zip(&weights).map(|(&l, weight)| weight * colour.eval(l)).sum::<f32>()
        };
        Channel { name, data: (0..r.len()).into_par_iter().map(rate).collect() }
    };
    Ok(responses.into_iter().map(of_channel).collect())
}

/// Middle and sum of each step of a spectrum.
fn steps(spectrum: &Spectrum) -> impl Iterator<Item = (f32, f64)> {
    let values: Vec<(f64, f64)> = spectrum.iter().collect();
    let step = |part: &[(f64, f64)]| {
        let middle = 0.5 * (part[0].0 + part[part.len() - 1].0);
        (middle as f32, part.iter().map(|(_, value)| value).sum())
    };
    values.chunks(STEP_NM).map(step).collect::<Vec<_>>().into_iter()
}

/// Electrons a second in light of one wavelength: E·A·η·λ/(hc).
fn of_one_wavelength(
    image: &Planes,
    sensor: &SensorModel,
    irradiance: f64,
    wavelength_nm: f64,
) -> Result<Vec<Channel>, Invalid> {
    let [first, last] = Spectrum::EVERYWHERE_NM.map(f64::from);
    if !(first..=last).contains(&wavelength_nm) {
        let message = format!("must lie from {first} to {last} nm, got {wavelength_nm}");
        return Err(Invalid::new("wavelength_nm", message).help("for example 550"));
    }
    let [Channel { data, .. }] = image.channels() else {
        let message = format!("has the channels {}, but light of one wavelength has no colours", names(image));
        return Err(Invalid::new("", message).help("give an image of one plane, or say its light in lux"));
    };
    let of_channel = |(name, response): (String, Spectrum)| {
        let data = scaled(data, irradiance * f64::from(response.eval(wavelength_nm as f32)));
        Channel { name, data }
    };
    Ok(sensor.responses().into_iter().map(of_channel).collect())
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::presets;
    use photosite_core::spectrum::upsampling::rgb_illuminant;

    fn image(planes: &[(&str, f32)]) -> Planes {
        let channel = |&(name, value): &(&str, f32)| Channel { name: name.to_owned(), data: vec![value; 6] };
        Planes::new(3, 2, planes.iter().map(channel).collect()).expect("right sizes")
    }

    fn model(name: &str) -> SensorModel {
        presets::model(name).expect("a preset")
    }

    fn values(found: &ImageElectrons) -> Vec<f64> {
        found.electrons.channels().iter().map(|channel| f64::from(channel.data[5])).collect()
    }

    #[test]
    fn electrons_and_full_wells_go_to_the_channel_of_their_name() {
        let colour = model(presets::DEFAULT);
        let planes = image(&[("R", 0.25), ("G", 0.5), ("B", 1.0), ("A", 0.3)]);
        let found = image_electrons(&planes, &colour, ImageUnit::Electrons, 8000.0).expect("light");
        assert_eq!((values(&found), found.per_second), (vec![2000.0, 4000.0, 8000.0], false));
        assert!(found.warnings[0].contains("transparency"));
        let grey = image_electrons(&image(&[("raw", 0.5)]), &colour, ImageUnit::FullWell, 0.5).expect("light");
        for value in values(&grey) {
            assert_relative_eq!(value, 0.25 * colour.full_well.0, max_relative = 1e-6);
        }
        let mono = model("sony-imx249-mono");
        let found = image_electrons(&planes, &mono, ImageUnit::Electrons, 1000.0).expect("light");
        let expected = 1000.0 * rgb::luminance([0.25, 0.5, 1.0]);
        assert_relative_eq!(values(&found)[0], expected, max_relative = 1e-6);
        assert!(found.warnings.iter().any(|warning| warning.contains("luminance")));
    }

    #[test]
    fn lux_is_that_of_upsampled_daylight() {
        for sensor in [model(presets::DEFAULT), model("sony-imx249-mono")] {
            for colour in [[1.0f32, 1.0, 1.0], [0.8, 0.1, 0.05], [0.0, 0.3, 2.0]] {
                let planes = image(&[("R", colour[0]), ("G", colour[1]), ("B", colour[2])]);
                let found = image_electrons(&planes, &sensor, ImageUnit::Lux, 30.0).expect("light");
                assert!(found.per_second && found.warnings.is_empty());
                let light = rgb_illuminant(colour).scale(30.0 / cie::luminous(illuminant::d65()));
                for (value, (name, response)) in values(&found).into_iter().zip(sensor.responses()) {
                    // The table of colours is good to 0.002 of the largest channel.
                    let expected = response.product(&light).integral();
                    let white =
                        response.product(illuminant::d65()).integral() * 30.0 / cie::luminous(illuminant::d65());
                    let within = 0.006 * f64::from(colour.into_iter().fold(0.0, f32::max)) * white;
                    assert!((value - expected).abs() < within, "{name} of {colour:?}: {value} for {expected}");
                }
            }
            let grey = image_electrons(&image(&[("Y", 1.0)]), &sensor, ImageUnit::Lux, 30.0).expect("light");
            let white = image(&[("R", 1.0), ("G", 1.0), ("B", 1.0)]);
            let white = image_electrons(&white, &sensor, ImageUnit::Lux, 30.0).expect("light");
            for (grey, white) in values(&grey).into_iter().zip(values(&white)) {
                assert_relative_eq!(grey, white, max_relative = 1e-5);
            }
        }
    }

    #[test]
    fn light_of_one_wavelength_frees_its_photons_times_the_quantum_efficiency() {
        let sensor = model("sony-imx249-mono");
        let unit = ImageUnit::Irradiance { wavelength_nm: 550.0 };
        let found = image_electrons(&image(&[("Y", 2.0)]), &sensor, unit, 1e-3).expect("light");
        // hc/λ of 550 nm is 3.6117e-19 J by hand.
        let photons = 2e-3 * sensor.pixel_area_m2() * sensor.fill_factor / 3.611_720e-19;
        let efficiency = f64::from(sensor.efficiencies()[0].eval(550.0));
        assert_relative_eq!(values(&found)[0], photons * efficiency, max_relative = 1e-5);
    }

    #[test]
    fn what_is_no_light_is_refused_or_named() {
        let sensor = model(presets::DEFAULT);
        let refused = |planes: &[(&str, f32)], unit, scale| {
            image_electrons(&image(planes), &sensor, unit, scale).expect_err("refused").message
        };
        let irradiance = |wavelength_nm| ImageUnit::Irradiance { wavelength_nm };
        for (message, expected) in [
            (
                refused(&[("Y", f32::NAN)], ImageUnit::Lux, 1.0),
                "6 numbers are not finite: the first is NaN, of Y in column 0, row 0",
            ),
            (refused(&[("Y", 1.0)], ImageUnit::Lux, 0.0), "above 0"),
            (refused(&[("Y", 1.0)], ImageUnit::Lux, f64::INFINITY), "above 0"),
            (refused(&[("R", 1.0), ("G", 1.0)], ImageUnit::Electrons, 1.0), "none for B"),
            (refused(&[("U", 1.0), ("V", 1.0)], ImageUnit::Lux, 1.0), "no colours"),
            (refused(&[("Y", 1.0)], irradiance(200.0), 1.0), "from 300 to 1100 nm"),
            (refused(&[("R", 1.0), ("G", 1.0), ("B", 1.0)], irradiance(550.0), 1.0), "no colours"),
        ] {
            assert!(message.contains(expected), "{message}");
        }
        let found = image_electrons(&image(&[("Y", -1.0)]), &sensor, ImageUnit::Lux, 1.0).expect("dark");
        assert_eq!(values(&found), [0.0; 3]);
        assert!(found.warnings[0].starts_with("6 pixel values below 0"));
    }
}
