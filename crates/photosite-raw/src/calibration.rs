//! Colour calibration of a camera in the lights that it was measured in.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A light, by EXIF's number for it ([Dng16](photosite_core::references#dng16), CalibrationIlluminant1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LightSource(pub u16);

impl LightSource {
    /// CIE illuminant A.
    pub const A: Self = Self(17);
    /// CIE illuminant D65.
    pub const D65: Self = Self(21);
    /// CIE illuminant D50.
    pub const D50: Self = Self(23);

    /// Correlated colour temperature of the light, K: that of the illuminant, or the one that Adobe's DNG SDK takes the
    /// name for. Sources without a name count as D65.
    pub fn temperature_k(self) -> f64 {
        match self.0 {
            // Tungsten, and A.
            3 | 17 => 2856.0,
            // Studio lamps.
            24 => 3200.0,
            // White, cool white, day white and daylight fluorescent lamps.
            15 => 3525.0,
            2 | 14 => 4150.0,
            13 => 5050.0,
            12 => 6400.0,
            23 => 5003.0,
            // Daylight, flash, fine weather, B and D55.
            1 | 4 | 9 | 18 | 20 => 5503.0,
            // Shade, and D75.
            11 | 22 => 7504.0,
            // Cloudy weather, C and D65 among them.
            _ => 6504.0,
        }
    }
}

/// Colour calibration of a camera in one light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ColourCalibration {
    /// The light.
    pub light: LightSource,
    /// XYZ → camera, a row per channel in the order of the CFA's channels, scaled so that the largest response to the
    /// light's own white of Y = 1 is 1.
    pub colour_matrix: Vec<[f64; 3]>,
    /// White-balanced camera → XYZ adapted to D50, a column per channel, where it is known.
    pub forward_matrix: Option<Vec<[f64; 3]>>,
}
