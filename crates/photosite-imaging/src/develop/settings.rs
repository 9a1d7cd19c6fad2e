//! How to develop: the keys of a capture file's `[develop]` table. Doc comments become the JSON Schema's descriptions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::description::RawDescription;
use super::encode::Encoding;
use crate::raw::RawMetadata;
use photosite_core::Invalid;
use photosite_core::colour::{ColourSpace, Transfer, temperature};

/// How raw pictures are developed, step by step in this order.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DevelopSettings {
    /// What the raw file does not say, or says wrong.
    pub raw: RawDescription,
    /// Makes nonlinear numbers of a sensor linear, by the table of the raw file. Left out: true.
    pub linearisation: bool,
    /// Subtracts the black level. Left out: true.
    pub black_level: bool,
    /// What becomes of defective pixels. Left out: "none".
    pub defects: Defects,
    /// Brightens the corners by what the lens darkens them, where the raw file has a map of it. Left out: true.
    pub lens_falloff: bool,
    /// What counts as white. Left out: "as-shot".
    pub white_balance: WhiteBalance,
    /// Colour temperature of white_balance = "temperature", K.
    pub temperature_k: Option<f64>,
    /// Tint of white_balance = "temperature": 3000 times the distance from the blackbodies in CIE 1960 (u, v), positive
    /// for a greenish light. Left out: 0.
    pub tint: Option<f64>,
    /// The grey patch of white_balance = "patch": column and row of its first pixel, columns and rows.
    pub patch_px: Option<[usize; 4]>,
    /// How the channels that a pixel did not see are found. Left out: "auto".
    pub demosaic: Demosaic,
    /// What becomes of pixels that are full in one channel. Left out: "clip".
    pub highlights: Highlights,
    /// Smooths noise. Left out: "none".
    pub noise_filter: NoiseFilter,
    /// Radius of the noise filter's window, pixels. Left out: 1 for mean and median, 2 for gaussian, 3 for bilateral, 5
    /// for non-local-means.
    pub noise_radius_px: Option<usize>,
    /// How much noise bilateral and non-local-means take for noise, in standard deviations of what the raw file states
    /// or, where it says nothing, the picture shows. Left out: 1.
    pub noise_strength: Option<f64>,
    /// Undoes the lens's distortion: the picture is that of a pinhole of the camera's matrix, an omnidirectional lens's
    /// over 1 + ξ. Known of DNG files alone. Lenses whose picture reaches 90° from the axis, and panoramas, keep
    /// theirs. Left out: true.
    pub distortion: bool,
    /// Gives the picture square pixels of the finer pitch, ⌊columns·p_x/p + ½⌋ × ⌊rows·p_y/p + ½⌋ of them with
    /// p = min(p_x, p_y); false keeps the grid of the sensor, and PNG, TIFF, JPEG and EXR files state the shape of its
    /// pixels. Known of DNG files alone. Left out: true.
    pub square_pixels: bool,
    /// Turns the camera's channels into colours by its colour matrix. Left out: true.
    pub colour_matrix: bool,
    /// Colour space of the picture. Left out: "srgb".
    pub colour_space: ColourSpace,
    /// Brightening by 2^exposure_ev. Left out: 0.
    pub exposure_ev: f64,
    /// From linear light to the codes of the picture; EXR files stay linear. Left out: "srgb".
    pub tone_curve: ToneCurve,
    /// Exponent of tone_curve = "gamma". Left out: 2.2.
    pub gamma: Option<f64>,
    /// How much of the difference to a smoothed picture is added to sharpen it (unsharp mask). Left out: 0.
    pub sharpening: f64,
    /// Standard deviation of that smoothing, pixels. Left out: 1.
    pub sharpening_radius_px: Option<f64>,
    /// Bits of the picture's codes, 8 or 16; JPEG has 8, EXR 32-bit floats. Left out: 8.
    pub bits: u8,
    /// Adds noise of one code before rounding, so that flat gradients have no steps and means stay exact. Left out:
    /// false.
    pub dither: bool,
}

/// What becomes of defective pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Defects {
    /// They stay as they are.
    #[default]
    None,
    /// A pixel far outside of what its neighbours of the same channel show becomes their median.
    Median,
}

/// What counts as white.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WhiteBalance {
    /// The camera's response to the scene's light, which the raw file states.
    #[default]
    AsShot,
    /// The mean of all pixels that are not saturated.
    GreyWorld,
    /// The brightest pixels that are not saturated.
    WhitePatch,
    /// A light of temperature_k and tint.
    Temperature,
    /// The mean of patch_px.
    Patch,
    /// Equal numbers in all channels.
    None,
}

/// How the channels that a pixel did not see are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Demosaic {
    /// The best that the filter array allows: menon for Bayer, markesteijn for X-Trans, lmmse for Quad Bayer and
    /// others, guided for large tiles.
    #[default]
    Auto,
    /// The nearest pixel of the channel. Any filter array.
    Nearest,
    /// Linear interpolation between the nearest pixels of the channel. Any filter array.
    Bilinear,
    /// The densest channel first, the others by their differences to it. Any filter array.
    Guided,
    /// Malvar, He and Cutler (2004): bilinear, corrected by the curvature of the pixel's own channel. Bayer.
    Malvar,
    /// Menon, Andriani and Calvagno (2007): along edges, not across. Bayer.
    Menon,
    /// In four directions, of which those where colours change least are taken, after Markesteijn. X-Trans and other
    /// arrays in which green is densest.
    Markesteijn,
    /// Linear estimates of the least mean square error along rows and along columns, the more of either the less
    /// colours change along it, after Zhang and Wu (2005). Any filter array with tiles of up to 64 pixels.
    Lmmse,
}

/// What becomes of pixels that are full in one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Highlights {
    /// All channels are clipped where the most sensitive one is full, so that blown highlights are white.
    #[default]
    Clip,
    /// Keeps the brightness that the other channels still tell, with the weaker colour of clipping.
    Blend,
    /// Full channels follow from the others by the colour of the surroundings.
    Reconstruct,
    /// Nothing: blown highlights take the colour of the white balance.
    None,
}

/// Noise filters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseFilter {
    /// No filter.
    #[default]
    None,
    /// Mean of the window.
    Mean,
    /// Mean weighted by a Gaussian of a third of the radius.
    Gaussian,
    /// Median of the window.
    Median,
    /// Gaussian mean of those pixels of the window that differ by no more than noise.
    Bilateral,
    /// Mean of the pixels whose surroundings look alike.
    NonLocalMeans,
}

/// From linear light to codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ToneCurve {
    /// Codes in proportion to light.
    Linear,
    /// The curve of sRGB, which keeps what the camera saw.
    #[default]
    Srgb,
    /// A power with the exponent 1/gamma.
    Gamma,
    /// Film's soft shoulder in place of hard clipping, then the curve of sRGB.
    Filmic,
}

impl Default for DevelopSettings {
    fn default() -> Self {
        Self {
            raw: RawDescription::default(),
            linearisation: true,
            black_level: true,
            defects: Defects::default(),
            lens_falloff: true,
            white_balance: WhiteBalance::default(),
            temperature_k: None,
            tint: None,
            patch_px: None,
            demosaic: Demosaic::default(),
            highlights: Highlights::default(),
            noise_filter: NoiseFilter::default(),
            noise_radius_px: None,
            noise_strength: None,
            distortion: true,
            square_pixels: true,
            colour_matrix: true,
            colour_space: ColourSpace::default(),
            exposure_ev: 0.0,
            tone_curve: ToneCurve::default(),
            gamma: None,
            sharpening: 0.0,
            sharpening_radius_px: None,
            bits: 8,
            dither: false,
        }
    }
}

/// Largest window of a noise filter: beyond it lies a slip of the pen.
const MAX_RADIUS: usize = 50;

impl DevelopSettings {
    /// Refuses values out of range, and keys that go with a choice that was not made.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.raw.validate().map_err(|invalid| invalid.within("raw"))?;
        let with_temperature = self.white_balance == WhiteBalance::Temperature;
        let smooths = self.noise_filter != NoiseFilter::None;
        let by_noise = matches!(self.noise_filter, NoiseFilter::Bilateral | NoiseFilter::NonLocalMeans);
        for (key, is_given, fits, wanted) in [
            ("temperature_k", self.temperature_k.is_some(), with_temperature, "white_balance = \"temperature\""),
            ("tint", self.tint.is_some(), with_temperature, "white_balance = \"temperature\""),
            (
                "patch_px",
                self.patch_px.is_some(),
                self.white_balance == WhiteBalance::Patch,
                "white_balance = \"patch\"",
            ),
            ("noise_radius_px", self.noise_radius_px.is_some(), smooths, "a noise_filter"),
            (
                "noise_strength",
                self.noise_strength.is_some(),
                by_noise,
                "noise_filter = \"bilateral\" or \"non-local-means\"",
            ),
            ("gamma", self.gamma.is_some(), self.tone_curve == ToneCurve::Gamma, "tone_curve = \"gamma\""),
            ("sharpening_radius_px", self.sharpening_radius_px.is_some(), self.sharpening != 0.0, "sharpening above 0"),
        ] {
            if is_given && !fits {
                return Err(
                    Invalid::new(key, format!("goes only with {wanted}")).help(format!("add it, or remove {key}"))
                );
            }
        }
        let [coldest, hottest] = temperature::TEMPERATURE_RANGE_K;
        let gamma = self.gamma.unwrap_or(2.2);
        for (key, value, range, example) in [
            ("temperature_k", self.temperature_k.unwrap_or(5000.0), coldest..=hottest, "5000"),
            ("tint", self.tint.unwrap_or(0.0), -150.0..=150.0, "10"),
            ("exposure_ev", self.exposure_ev, -20.0..=20.0, "0.5"),
            ("gamma", gamma, 0.1..=10.0, "2.2"),
            ("noise_strength", self.noise_strength(), 0.01..=100.0, "1.5"),
            ("sharpening", self.sharpening, 0.0..=10.0, "0.5"),
            ("sharpening_radius_px", self.sharpening_radius_px(), 0.2..=20.0, "1.0"),
        ] {
            if !range.contains(&value) {
                let message = format!("must lie from {} to {}, got {value}", range.start(), range.end());
                return Err(Invalid::new(key, message).help(format!("for example {key} = {example}")));
            }
        }
        if with_temperature && self.temperature_k.is_none() {
            let help = "for example temperature_k = 5000";
            return Err(Invalid::new("white_balance", "needs temperature_k").help(help));
        }
        if self.white_balance == WhiteBalance::Patch && self.patch_px.is_none() {
            let help = "for example patch_px = [100, 80, 20, 20]";
            return Err(Invalid::new("white_balance", "needs patch_px").help(help));
        }
        if self.noise_filter != NoiseFilter::None && !(1..=MAX_RADIUS).contains(&self.noise_radius_px()) {
            let message = format!("must lie from 1 to {MAX_RADIUS}, got {}", self.noise_radius_px());
            return Err(Invalid::new("noise_radius_px", message).help("for example noise_radius_px = 2"));
        }
        match self.bits {
            8 | 16 => Ok(()),
            other => Err(Invalid::new("bits", format!("must be 8 or 16, got {other}")).help("for example bits = 16")),
        }
    }

    /// Radius of the noise filter's window, pixels.
    pub fn noise_radius_px(&self) -> usize {
        self.noise_radius_px.unwrap_or(match self.noise_filter {
            NoiseFilter::None | NoiseFilter::Mean | NoiseFilter::Median => 1,
            NoiseFilter::Gaussian => 2,
            NoiseFilter::Bilateral => 3,
            NoiseFilter::NonLocalMeans => 5,
        })
    }

    /// Standard deviations of noise that filters take for noise.
    pub fn noise_strength(&self) -> f64 {
        self.noise_strength.unwrap_or(1.0)
    }

    /// Standard deviation of the unsharp mask, pixels.
    fn sharpening_radius_px(&self) -> f64 {
        self.sharpening_radius_px.unwrap_or(1.0)
    }

    /// Width over height of the pixels of a picture that is developed from such a raw file.
    pub fn pixel_aspect(&self, metadata: &RawMetadata) -> f64 {
        if self.square_pixels { 1.0 } else { metadata.pixel_aspect() }
    }

    /// How linear values become the codes of a picture.
    pub fn encoding(&self) -> Encoding {
        Encoding {
            colour_space: self.colour_space,
            transfer: match self.tone_curve {
                ToneCurve::Linear => Transfer::Linear,
                ToneCurve::Srgb | ToneCurve::Filmic => Transfer::Srgb,
                ToneCurve::Gamma => Transfer::Gamma(self.gamma.unwrap_or(2.2)),
            },
            bits: self.bits,
            dither: self.dither,
            sharpening: self.sharpening,
            sharpening_radius_px: self.sharpening_radius_px(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid_and_slips_are_told() {
        let default = DevelopSettings::default;
        assert_eq!(default().validate(), Ok(()));
        for (settings, key) in [
            (DevelopSettings { temperature_k: Some(5000.0), ..default() }, "temperature_k"),
            (DevelopSettings { gamma: Some(2.2), ..default() }, "gamma"),
            (DevelopSettings { white_balance: WhiteBalance::Temperature, ..default() }, "white_balance"),
            (DevelopSettings { white_balance: WhiteBalance::Patch, ..default() }, "white_balance"),
            (DevelopSettings { exposure_ev: f64::NAN, ..default() }, "exposure_ev"),
            (DevelopSettings { bits: 12, ..default() }, "bits"),
            (DevelopSettings { sharpening: -1.0, ..default() }, "sharpening"),
            (DevelopSettings { noise_radius_px: Some(2), ..default() }, "noise_radius_px"),
            (
                DevelopSettings { noise_filter: NoiseFilter::Mean, noise_radius_px: Some(0), ..default() },
                "noise_radius_px",
            ),
            (
                DevelopSettings { noise_filter: NoiseFilter::Mean, noise_strength: Some(2.0), ..default() },
                "noise_strength",
            ),
        ] {
            assert_eq!(settings.validate().expect_err(key).key, key);
        }
    }
}
