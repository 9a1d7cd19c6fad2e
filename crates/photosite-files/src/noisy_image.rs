//! Image of any program with synthetic noise: read, changed, and ready to be written.

use std::path::Path;

use rayon::prelude::*;

use super::formats::Format;
use super::image_file::{ImageFile, read_image_file};
use super::linear_image::light_of_codes;
use super::plain_image::PlainImage;
use photosite_core::image::{NotFinite, Planes};
use photosite_core::{Error, Invalid, Result};
use photosite_measure::synthetic_noise::{Clipped, Scale, SyntheticNoise, add_noise, round_to_codes};
use photosite_measure::validation::ComparedImage;
use photosite_raw::Pixels;

/// Image with noise.
#[derive(Clone, Debug)]
pub struct NoisyImage {
    /// Pixel values.
    pub image: PlainImage,
    /// Clipped values of an integer image; `None` for floating-point images, which are neither rounded nor clipped.
    pub clipped: Option<Clipped>,
    /// Sentence that says what the noise was added to.
    pub added_to: String,
    /// Pixel value of level 1 (full scale); `None` where unknown.
    pub white: Option<f64>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Reads an image and adds noise, for a file of the given format. In `linear_light`, codes are decoded before and
/// encoded after; levels are then those of light, on the scale of the codes.
pub fn make_noisy(
    path: &Path,
    noise: &SyntheticNoise,
    linear_light: bool,
    seed: u64,
    format: &Format,
) -> Result<NoisyImage> {
    let file = ImageFile::read(path, Pixels::All)?;
    let stated = file.notes.colours.clone();
    let image = file.as_it_lies();
    let of_file: Vec<String> = image.said().collect();
    let ComparedImage { mean: mut planes, full_scale, unit, .. } = image;
    let largest = full_scale.map(|largest| largest as u16);
    let mut warnings = noise.without_effect();
    let scale = Scale { white: noise.full_scale.or(full_scale) };
    let sigma_map = noise.sigma_map.file.as_deref().map(|map| read_sigma_map(map, &mut warnings)).transpose()?;
    warnings.extend(of_file);
    warnings.extend(NotFinite::of(&planes).map(|found| format!("{}: {found}; they stay as they are", path.display())));
    if planes.plane("A").is_some() {
        warnings.push("transparency (A) gets no noise".to_owned());
    }
    let curves = match (linear_light, largest) {
        (false, _) => None,
        (true, Some(largest)) => Some(light_of_codes(&stated, largest).map_err(|invalid| invalid.in_file(path))?),
        (true, None) => {
            return Err(Error::Usage {
                message: format!(
                    "{} holds floating-point numbers, which are not codes that could be decoded",
                    path.display()
                ),
                help: Some("leave --linear out: the noise is added to the pixel values as they are".into()),
            });
        }
    };
    let lights: Option<Vec<Light>> = curves.as_ref().zip(full_scale).map(|((curves, _), white)| {
        let of_channel = |name: &str| {
            let colour = ["R", "G", "B"].iter().position(|colour| *colour == name).unwrap_or(0);
            Light { of_code: &curves[colour], white }
        };
        planes.channels().iter().map(|channel| of_channel(&channel.name)).collect()
    });
    convert(&mut planes, lights.as_deref(), Light::decode);
    let wrong = |invalid: Invalid| match invalid.key.as_str() {
        "sigma_map.file" => match &noise.sigma_map.file {
            Some(map) => Invalid { key: String::new(), ..invalid }.in_file(map),
            None => invalid.in_file(path),
        },
        _ => invalid.in_file(path),
    };
    warnings.extend(noise.without_grain(&planes));
    add_noise(&mut planes, noise, scale, sigma_map.as_ref(), seed).map_err(wrong)?;
    convert(&mut planes, lights.as_deref(), Light::encode);
    let added_to = added_to(path, unit.as_deref(), largest, curves.as_ref().map(|(_, is_stated)| *is_stated));
    let largest = largest.filter(|_| format.holds_whole_numbers());
    let clipped = largest.map(|largest| round_to_codes(&mut planes, largest.into()));
    warnings.extend(stated.lost_in(format, path));
    let image = PlainImage { colours: stated, ..PlainImage::plain(planes, largest) };
    Ok(NoisyImage { image, clipped, added_to, white: scale.white, warnings })
}

fn read_sigma_map(path: &Path, warnings: &mut Vec<String>) -> Result<Planes> {
    let image = read_image_file(path, Pixels::All)?.whole().map_err(|invalid| invalid.in_file(path))?;
    warnings.extend(image.said());
    Ok(image.mean)
}

fn added_to(path: &Path, unit: Option<&str>, largest: Option<u16>, decoded: Option<bool>) -> String {
    match (largest, decoded) {
        (Some(largest), Some(true)) => {
            format!("linear light, decoded as {} says and on the scale of its codes, 0 to {largest}", path.display())
        }
        (Some(largest), Some(false)) => format!(
            "linear light, decoded as sRGB since {} says nothing of its codes, on their scale, 0 to {largest}",
            path.display()
        ),
        (Some(largest), None) if unit == Some("DN") => format!("the pixel values as they are, 0 to {largest}"),
        (Some(largest), None) => format!("the codes as they are, 0 to {largest}, not to linear light (--linear)"),
        (None, _) => match unit {
            Some(unit) => format!("the pixel values as they are, in {unit}"),
            None => "the pixel values as they are".to_owned(),
        },
    }
}

/// Linear light of a channel's codes.
#[derive(Clone, Copy)]
struct Light<'a> {
    /// Linear light of each code, ascending, 1 for white.
    of_code: &'a [f32],
    /// Largest code.
    white: f64,
}

impl Light<'_> {
    /// Linear light of a code, on the scale of the codes.
    fn decode(self, code: f32) -> f32 {
        self.of_code[(code as usize).min(self.of_code.len() - 1)] * self.white as f32
    }

    /// Code of a linear light, interpolated between integers; the last step is extrapolated beyond the ends.
    fn encode(self, light: f32) -> f32 {
        let light = light / self.white as f32;
        let above = self.of_code.partition_point(|&of_code| of_code < light).clamp(1, self.of_code.len() - 1);
        let (low, high) = (self.of_code[above - 1], self.of_code[above]);
        let step = (high - low).max(f32::MIN_POSITIVE);
        (above - 1) as f32 + (light - low) / step
    }
}

fn convert<'a>(planes: &mut Planes, lights: Option<&[Light<'a>]>, change: impl Fn(Light<'a>, f32) -> f32 + Sync) {
    for (channel, &light) in planes.channels_mut().iter_mut().zip(lights.unwrap_or_default()) {
        channel.data.par_iter_mut().for_each(|value| *value = change(light, *value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_undoes_decoding_and_goes_on_beyond_the_ends() {
        let of_code: Vec<f32> =
            (0..=255).map(|code| photosite_core::spectrum::rgb::decode(code as f32 / 255.0)).collect();
        let light = Light { of_code: &of_code, white: 255.0 };
        for code in 0..=255 {
            let code = code as f32;
            assert!((light.encode(light.decode(code)) - code).abs() < 1e-3, "{code}");
        }
        assert!(light.encode(-1.0) < -1.0 && light.encode(300.0) > 256.0);
        // Between codes it is off by no more than the curve bends.
        let exact = 255.0 * photosite_core::spectrum::rgb::encode(0.2);
        assert!((light.encode(0.2 * 255.0) - exact).abs() < 0.02);
    }
}
