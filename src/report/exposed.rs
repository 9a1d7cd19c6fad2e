//! What a report says of sensor and exposure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::develop::SensorCalibration;

/// The sensor at its gains.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct SensorReport {
    /// Its name.
    pub name: String,
    /// Fixed pattern belongs to it.
    pub serial: u64,
    /// Columns and rows of the raw image.
    pub resolution_px: [usize; 2],
    /// Across and down.
    pub pixel_pitch_um: [f64; 2],
    /// Names of its channels.
    pub channels: Vec<String>,
    /// Bits of a number.
    pub bits: u32,
    /// Mean black level.
    pub black_level_dn: f32,
    /// Largest number.
    pub white_level_dn: u16,
    /// What makes the numbers linear, which the levels are of; `null` where they are so already.
    pub linearisation_dn: Option<Vec<u16>>,
    /// System gain K at the exposure's gains, as photon transfer finds it. Electrons, here and below, are those of the
    /// pixel that is read out: with binning, those of all pixels of a bin together, whatever the binning_method.
    pub system_gain_dn_per_e: f64,
    /// The smaller of full well and converter range at these gains, of the pixel that is read out.
    pub saturation_capacity_e: f64,
    /// σ of the amplifiers' noise in the pixel that is read out: where the numbers of n pixels are added or averaged, √n
    /// times that of one.
    pub read_noise_e: f64,
    /// What a neutral surface in this light gives, a number for each channel; `null` without colours.
    pub as_shot_neutral: Option<Vec<f64>>,
    /// XYZ to camera under D65, row by row; `null` without colours.
    pub colour_matrix_d65: Option<Vec<[f64; 3]>>,
    /// What the channels mean in A, D65 and D50, so that another exposure need not find it again; `null` without
    /// colours.
    pub calibration: Option<SensorCalibration>,
    /// What the user was warned of about keys that the sensor was made of, and which its values no longer show; none in
    /// reports of earlier versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// The exposure, of an automatic one as it was found.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ExposureReport {
    /// Exposure time.
    pub time_s: f64,
    /// Whether that was found by itself.
    pub auto: bool,
    /// Analogue gain; under gain control, that of the first picture.
    pub gain_db: f64,
    /// Analogue gain of each picture, where gain control has found it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_gains_db: Option<Vec<f64>>,
    /// Digital gain.
    pub digital_gain_db: f64,
    /// Exposure value log₂(N²/t) of f-number and time in seconds; `null` without a lens.
    #[serde(default)]
    pub exposure_value: Option<f64>,
    /// Saturation-based ISO speed at these gains; `null` for logarithmic sensors.
    pub iso: Option<f64>,
    /// Temperature of the sensor.
    pub temperature_c: f64,
    /// Pictures of the series.
    pub frames: u32,
    /// Which of a series this is, counted from 0, where it is a later one that was written alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// The times of a bracket; `null` for none.
    pub bracket_s: Option<Vec<f64>>,
}
