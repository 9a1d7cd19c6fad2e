//! The choices of the `[develop]` table. Doc comments become the JSON Schema's descriptions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::colour::temperature;
use photosite_core::keys::Keys;
use photosite_core::spectrum::{cie, illuminant};

/// Correction of defective pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Defects {
    /// No change.
    #[default]
    None,
    /// A pixel far outside of the range of its neighbours of the same channel becomes their median.
    Median,
}

/// White balance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum WhiteBalance {
    /// Response of the camera to the scene's light, which the raw file states.
    #[default]
    AsShot,
    /// Mean of all pixels that are not saturated.
    GreyWorld,
    /// Brightest pixels that are not saturated.
    WhitePatch,
    /// Light of temperature_k and tint.
    Temperature,
    /// A candle: a blackbody at 1850 K.
    Candle,
    /// An incandescent lamp: CIE illuminant A, 2856 K.
    Incandescent,
    /// A halogen lamp: a blackbody at 3200 K.
    Halogen,
    /// A cool white fluorescent lamp: CIE FL2, 4230 K.
    Fluorescent,
    /// Daylight of 5000 K: CIE D50.
    D50,
    /// A flash, like daylight of 5500 K: CIE D55.
    Flash,
    /// Sunlight and skylight together, 6500 K: CIE D65.
    Daylight,
    /// An overcast sky: CIE daylight of 7000 K.
    Overcast,
    /// The shade under a blue sky: CIE daylight of 8000 K.
    Shade,
    /// A clear blue sky: CIE daylight of 10000 K.
    BlueSky,
    /// Mean of patch_px.
    Patch,
    /// Equal numbers in all channels.
    None,
}

/// Demosaicking, the interpolation of the channels that a pixel lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Demosaic {
    /// Best method for the filter array: menon for Bayer, markesteijn for X-Trans, lmmse for Quad Bayer and
    /// others, guided for large tiles.
    #[default]
    Auto,
    /// Nearest pixel of the channel, for any filter array.
    Nearest,
    /// Linear interpolation between the nearest pixels of the channel. Any filter array.
    Bilinear,
    /// Densest channel first, the others by their differences to it, for any filter array.
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

/// Treatment of pixels that are saturated in one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseFilter {
    /// No filter.
    #[default]
    None,
    /// Mean of the window.
    Mean,
    /// Mean weighted by a Gaussian of noise_sigma_px.
    Gaussian,
    /// Median of the window.
    Median,
    /// Gaussian mean of those pixels of the window that differ by no more than noise, or than noise_sigma_range.
    Bilateral,
    /// Mean of the pixels whose surroundings look alike.
    NonLocalMeans,
}

/// Tone curve from linear light to codes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ToneCurve {
    /// Codes in proportion to light.
    Linear,
    /// Curve of sRGB, without further rendering.
    #[default]
    Srgb,
    /// Power with the exponent 1/gamma.
    Gamma,
    /// Film's soft shoulder in place of hard clipping, then the curve of sRGB.
    Filmic,
    /// Reinhard et al. (2002), one curve for all pixels: luminance over its logarithmic mean, times tone_key, is L, and
    /// becomes L·(1 + L/tone_white²)/(1 + L). Then the curve of sRGB.
    Reinhard,
    /// Drago et al. (2003): a logarithm of luminance whose base grows from 2 in the dark to 10 in the brightest pixel,
    /// the faster the larger tone_bias. Then the curve of sRGB.
    Log,
    /// Durand and Dorsey (2002): a bilateral filter parts the logarithm of luminance in a base, which is compressed to
    /// tone_contrast, and in detail, which stays. Then the curve of sRGB.
    Local,
}

/// Colour model of the pixel values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ColourModel {
    /// Components of the colour space.
    #[default]
    Rgb,
    /// Luminance Y of the colour space, 1 for white.
    Grey,
    /// Luminance Y as the tone curve encodes it, clipped to 0–1: floats where "grey" is linear, in EXR, TIFF and NPY
    /// files; in others the same as "grey".
    EncodedGrey,
    /// Hue in degrees, saturation and value = max(R, G, B) of the encoded components, clipped to 0–1.
    Hsv,
    /// Hue in degrees, saturation and lightness = (max + min)/2 of the encoded components, clipped to 0–1.
    Hsl,
    /// Hue in degrees, saturation and intensity = (R + G + B)/3 of the encoded components, clipped to 0–1 (Gonzalez and
    /// Woods).
    Hsi,
    /// CIE 1976 L\*, a\* and b\* relative to the white of the colour space, L\* = 100 for white.
    Lab,
}

/// Threshold of a binary image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Thresholding {
    /// No change.
    #[default]
    None,
    /// Pixels above threshold_level become white, others black, in each component.
    Level,
    /// Otsu's threshold, the level that parts 256 classes of linear light, ⌊255·v + ½⌋, in the two groups whose means
    /// lie farthest apart (Otsu 1979), in each component.
    Otsu,
}

/// Interpolation of resizing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ResizeFilter {
    /// Nearest pixel.
    Nearest,
    /// Straight lines between pixels.
    Linear,
    /// Cubic convolution of four pixels with a = −0.75 (Keys 1981), as cv2.INTER_CUBIC has it.
    #[default]
    Cubic,
    /// Lanczos' window of eight pixels, sinc(x)·sinc(x/4), as cv2.INTER_LANCZOS4 has it.
    Lanczos,
}

impl WhiteBalance {
    /// Chromaticity (x, y) of the illuminant of that name; `None` for choices without one.
    pub fn lamp(self) -> Option<[f64; 2]> {
        match self {
            Self::AsShot | Self::GreyWorld | Self::WhitePatch | Self::Temperature | Self::Patch | Self::None => None,
            Self::Candle => temperature::chromaticity(1850.0, 0.0),
            Self::Incandescent => cie::chromaticity(&illuminant::a()),
            Self::Halogen => temperature::chromaticity(3200.0, 0.0),
            Self::Fluorescent => cie::chromaticity(&illuminant::illuminant("FL2")?),
            Self::D50 => cie::chromaticity(&illuminant::illuminant("D50")?),
            Self::Flash => cie::chromaticity(&illuminant::illuminant("D55")?),
            Self::Daylight => cie::chromaticity(illuminant::d65()),
            Self::Overcast => illuminant::daylight_chromaticity(7000.0),
            Self::Shade => illuminant::daylight_chromaticity(8000.0),
            Self::BlueSky => illuminant::daylight_chromaticity(10_000.0),
        }
    }
}

impl ColourModel {
    /// Whether codes hold the model's values, and viewers show them as colours.
    pub fn is_shown(self) -> bool {
        match self {
            Self::Rgb | Self::Grey | Self::EncodedGrey => true,
            Self::Hsv | Self::Hsl | Self::Hsi | Self::Lab => false,
        }
    }

    /// Whether the model has one value a pixel.
    pub fn is_grey(self) -> bool {
        match self {
            Self::Grey | Self::EncodedGrey => true,
            Self::Rgb | Self::Hsv | Self::Hsl | Self::Hsi | Self::Lab => false,
        }
    }

    /// Name as people write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgb => "RGB",
            Self::Grey => "grey",
            Self::EncodedGrey => "encoded grey",
            Self::Hsv => "HSV",
            Self::Hsl => "HSL",
            Self::Hsi => "HSI",
            Self::Lab => "CIE L*a*b*",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_have_the_temperatures_that_are_listed() {
        for (lamp, kelvin) in [
            (WhiteBalance::Candle, 1850.0),
            (WhiteBalance::Incandescent, 2856.0),
            (WhiteBalance::Halogen, 3200.0),
            (WhiteBalance::Fluorescent, 4230.0),
            (WhiteBalance::D50, 5003.0),
            (WhiteBalance::Flash, 5503.0),
            (WhiteBalance::Daylight, 6504.0),
            (WhiteBalance::Overcast, 7000.0),
            (WhiteBalance::Shade, 8000.0),
            (WhiteBalance::BlueSky, 10_000.0),
        ] {
            let (found, _) = temperature::temperature_and_tint(lamp.lamp().expect("a lamp"));
            // The CIE's daylight locus is a fit, 0.3 % off at its blue end; FL2 is stated to 10 K.
            assert!((found / kelvin - 1.0).abs() < 4e-3, "{lamp:?}: {found} K");
        }
        assert_eq!(WhiteBalance::AsShot.lamp(), None);
    }
}
