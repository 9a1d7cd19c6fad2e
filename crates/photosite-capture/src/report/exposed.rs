//! Report of sensor and exposure.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_develop::SensorCalibration;

/// Sensor at its gains.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct SensorReport {
    /// Name of the sensor.
    pub name: String,
    /// Serial number, which the fixed pattern belongs to.
    pub serial: u64,
    /// Columns and rows of the raw image.
    pub resolution_px: [usize; 2],
    /// Pixel pitch across and down, µm.
    pub pixel_pitch_um: [f64; 2],
    /// Names of the sensor's channels.
    pub channels: Vec<String>,
    /// Bits of a digital number.
    pub bits: u32,
    /// Mean black level, DN.
    pub black_level_dn: f32,
    /// White level: the largest digital number, DN.
    pub white_level_dn: u16,
    /// Table that linearises the digital numbers, to which the levels refer; `null` where these are linear already.
    pub linearisation_dn: Option<Vec<u16>>,
    /// System gain K at the exposure's gains, as photon transfer finds it. Electrons, here and below, are those of the
    /// pixel that is read out: with binning, those of all pixels of a bin together, whatever the binning_method.
    pub system_gain_dn_per_e: f64,
    /// Saturation capacity: the smaller of full well and converter range at these gains, of the pixel that is read out,
    /// e⁻.
    pub saturation_capacity_e: f64,
    /// Standard deviation σ of the amplifiers' noise in the pixel that is read out: where n pixels are added or
    /// averaged, √n times that of one.
    pub read_noise_e: f64,
    /// Response of each channel to a neutral surface in this light; `null` without colours.
    pub as_shot_neutral: Option<Vec<f64>>,
    /// Matrix from XYZ to the camera's channels under D65, row by row; `null` without colours.
    pub colour_matrix_d65: Option<Vec<[f64; 3]>>,
    /// Colour calibration of the channels in A, D65 and D50, so that another exposure need not find it again; `null`
    /// without colours.
    pub calibration: Option<SensorCalibration>,
    /// Warnings about keys that the sensor was made of, and which its values no longer show; none in reports of earlier
    /// versions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// Exposure; an automatic one as it was found.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct ExposureReport {
    /// Exposure time.
    pub time_s: f64,
    /// Whether the exposure was found automatically.
    pub auto: bool,
    /// Analogue gain, dB; under gain control, that of the first image.
    pub gain_db: f64,
    /// Analogue gain of each image, dB, where gain control has found it.
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
    /// Number of images of the series.
    pub frames: u32,
    /// Index of the image in its series, from 0, where it is a later one that was written alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// Graphics card that exposed, with its interface and driver; left out for the processor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// Exposure times of a bracket, s; `null` for none.
    pub bracket_s: Option<Vec<f64>>,
}
