//! Description of a sensor as a file states it, before it is checked: the keys of `assets/sensors/*.toml` and of a
//! capture file's `[sensor]` table, in the units that they name. Doc comments become the JSON Schema's descriptions.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ccd::CcdDescription;
use super::cells::CellShapeName;
use super::charge::ChargeDescription;
use super::converter::AdcDescription;
use super::defects::DefectsDescription;
use super::frame_grabber::FrameGrabberDescription;
use super::kind::SensorKind;
use super::noise::NoiseDescription;
use super::shutter::ShutterDescription;
use super::spad::SpadDescription;
use super::spectrum_source::SpectrumSource;
use super::video::VideoDescription;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};

/// Image sensor: pixels, colour filters, noise, charge capacity and converter.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct SensorDescription {
    /// Name of the sensor, which raw files have as the model of their camera. Left out: the name of its preset or file.
    pub name: Option<String>,
    /// Description of the sensor, in a sentence.
    #[serde(default)]
    pub description: String,
    /// Source of its figures.
    #[serde(default)]
    pub source: String,
    /// Technology of the pixels.
    #[serde(default)]
    pub kind: SensorKind,
    /// Serial number of this sensor. Fixed pattern (PRNU, DSNU, defects, columns) belongs to it,
    /// whatever the seed and the frame; another number is another camera of the same make. In the rig of a data set,
    /// cameras that are not told otherwise count on from it.
    #[serde(default)]
    pub serial: u64,
    /// Charge transfer of a CCD.
    pub ccd: Option<CcdDescription>,
    /// Single-photon counting.
    pub spad: Option<SpadDescription>,
    /// Shutter: the times at which rows are exposed. Left out: all at once.
    #[serde(default)]
    pub shutter: ShutterDescription,
    /// Columns and rows of pixels; of a scanning line camera, its pixels and the lines of an image.
    #[schemars(transform = within(1.0..=65_535.0))]
    pub resolution_px: [u32; 2],
    /// Columns of pixels to the left and to the right of these that are covered and see no light.
    #[serde(default)]
    #[schemars(transform = within(0.0..=4096.0))]
    pub masked_columns: [u32; 2],
    /// Covered rows of pixels above and below.
    #[serde(default)]
    #[schemars(transform = within(0.0..=4096.0))]
    pub masked_rows: [u32; 2],
    /// Distance between pixel centres along x and y, µm; they may differ. Of hexagonal cells, along rows and from row
    /// to row.
    #[schemars(transform = above(0.0..))]
    pub pixel_pitch_um: Option<[f64; 2]>,
    /// Size of the whole sensor by the name of its format, in place of pixel_pitch_um, which is that size over the
    /// resolution: "1/3.2", "1/2", "2/3", "1" and other inches, "four-thirds", "aps-c", "full-frame",
    /// "medium-format-44x33" … (`photosite sensors --formats` lists them).
    pub format: Option<String>,
    /// Shape of the pixels. Left out: "rectangular".
    #[serde(default)]
    pub cells: CellShapeName,
    /// Diameter of the circle about the middle of the sensor that light reaches, mm, where it does not reach all of it:
    /// pixels whose centres lie beyond see none. Left out: all of them see light.
    #[schemars(transform = above(0.0..))]
    pub image_circle_mm: Option<f64>,
    /// Part of a pixel's area that is sensitive to light, above 0 up to 1. Leave it at 1 where the quantum efficiency
    /// was measured for whole pixels, as EMVA 1288 does.
    #[serde(default = "one")]
    #[schemars(transform = above(0.0..=1.0))]
    pub fill_factor: f64,
    /// Colour filter array: "mono"; a tile, row by row from the top-left pixel ("RGGB", or "RGRG/GBGB" with its rows
    /// apart); "quad-bayer", "nona-bayer", "x-trans", "rgbw", "rgb-ir", "rccb", "rccc", "ryyb" or "cygm"; or "full:RGB"
    /// for all channels at every pixel.
    pub cfa: String,
    /// Filters in front of all pixels, such as one that blocks infrared.
    #[serde(default)]
    pub filter: FilterDescription,
    /// One table for each letter of the colour filter array, such as R, G and B; Y for a monochrome sensor.
    pub channels: BTreeMap<String, ChannelDescription>,
    /// Crosstalk, where electrons that belong to a pixel are collected: parts of a whole, in rows around that pixel,
    /// such as [[0, 0.01, 0], [0.01, 0.96, 0.01], [0, 0.01, 0]]. Left out: each pixel keeps its own.
    #[schemars(transform = within(0.0..=1.0))]
    pub crosstalk: Option<Vec<Vec<f64>>>,
    /// Noise sources. Left out: none.
    #[serde(default)]
    pub noise: NoiseDescription,
    /// Pixels that do not work as the others.
    #[serde(default)]
    pub defects: DefectsDescription,
    /// Charge storage.
    pub charge: ChargeDescription,
    /// Analogue gain and analogue-to-digital converter.
    pub adc: AdcDescription,
    /// Analogue video signal between sensor and converter. Left out: it arrives unchanged.
    #[serde(default)]
    pub video: VideoDescription,
    /// Frame grabber that samples the video signal for the converter. Left out: one sample for each pixel.
    pub frame_grabber: Option<FrameGrabberDescription>,
}

fn one() -> f64 {
    1.0
}

/// Filters in front of all pixels; light passes one after the other. Each is a transmittance, 0–1 at every wavelength,
/// and 1 where left out.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct FilterDescription {
    /// Transmittance of a filter such as one that blocks infrared.
    pub transmittance: Option<SpectrumSource>,
    /// Transmittance of the cover glass.
    pub cover_glass: Option<SpectrumSource>,
    /// Transmittance of the microlenses.
    pub microlenses: Option<SpectrumSource>,
}

/// One channel of the sensor.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct ChannelDescription {
    /// Photo-electrons per photon that reaches the pixel, colour filter included, 0–1 at every wavelength; for a
    /// single-photon detector, its photon detection probability.
    pub quantum_efficiency: Option<SpectrumSource>,
    /// In its place: the depths of silicon, µm, between which photons are absorbed into this channel, the upper one
    /// first, as in the layers of a stacked pixel. What is reflected before the silicon belongs to the filter.
    #[schemars(transform = within(0.0..))]
    pub depth_um: Option<[f64; 2]>,
    /// Crosstalk of the electrons behind this filter, where it differs from that of the others.
    #[schemars(transform = within(0.0..=1.0))]
    pub crosstalk: Option<Vec<Vec<f64>>>,
}
