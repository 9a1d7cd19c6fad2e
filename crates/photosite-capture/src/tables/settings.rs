//! `[exposure]` and `[output]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_calibration::truth::TruthLayer;
use photosite_core::keys::{self, Keys};
use photosite_core::schema_range::{above, within};
use photosite_develop::RawLayout;
use photosite_files::formats::Format;
use photosite_files::noise_maps::NoiseFormat;
use photosite_files::truth::TruthFormat;
use photosite_raw::DngCompression;
use photosite_sensor::{BinningMethod, NoiseMap, Stage};

/// Longest step of a bracket, EV: as from a microsecond to an hour.
pub(crate) const LONGEST_STEP_EV: f64 = 32.0;

/// Exposure time, gain and temperature.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExposureTable {
    /// Exposure time, s. Left out: chosen automatically.
    #[schemars(transform = above(0.0..))]
    pub(crate) time_s: Option<f64>,
    /// Automatic exposure: chooses the time so that the bright parts of the image stay just below saturation. Left out:
    /// true, unless a time is given.
    pub(crate) auto: Option<bool>,
    /// Where automatic exposure puts the bright parts, as a part of saturation. Left out: 0.85.
    #[schemars(transform = above(0.0..=1.0))]
    pub(crate) auto_target: Option<f64>,
    /// Part of the pixels that automatic exposure lets be brighter than that. Left out: 0.005.
    #[schemars(transform = within(0.0..1.0))]
    pub(crate) auto_brighter_part: Option<f64>,
    /// Mean of the image that automatic exposure aims at, as a part of saturation, such as 0.18; in place of
    /// auto_target and auto_brighter_part.
    #[schemars(transform = above(0.0..1.0))]
    pub(crate) auto_mean: Option<f64>,
    /// Exposure compensation, EV: automatic exposure makes the image this much brighter, 1 for twice as bright, -1 for
    /// half. Left out: 0.
    #[schemars(transform = within(-20.0..=20.0))]
    pub(crate) compensation_ev: Option<f64>,
    /// Longest time that automatic exposure may choose, s. Where it would need more, the gain rises, unless it is
    /// stated; where that is not enough either, the image is darker, and a warning says by how much. Left out: 4.
    #[schemars(transform = above(0.0..))]
    pub(crate) max_time_s: Option<f64>,
    /// Largest gain that automatic exposure may choose, analogue and digital together, dB. Left out: the sensor's
    /// largest analogue gain.
    pub(crate) max_gain_db: Option<f64>,
    /// Analogue gain, dB. Left out: 0, or the sensor's smallest above it.
    pub(crate) gain_db: Option<f64>,
    /// Digital gain, a factor of the pixel values behind the converter, dB, 0 to 48. Left out: 0.
    #[schemars(transform = within(0.0..=48.0))]
    pub(crate) digital_gain_db: Option<f64>,
    /// Saturation-based ISO speed in place of the two gains, from the sensor's base ISO on (`photosite info` tells it).
    /// Analogue gain gives as much of it as the sensor has, digital gain the rest.
    #[schemars(transform = above(0.0..))]
    pub(crate) iso: Option<f64>,
    /// Automatic gain control: the analogue gain follows the light from image to image of a series (frames) at a fixed
    /// time, as in video cameras; the first image has gain_db. Left out: the gain stays.
    pub(crate) gain_control: Option<GainControlTable>,
    /// Temperature of the sensor, °C. Left out: 25.
    #[schemars(transform = above(-273.15..))]
    pub(crate) temperature_c: Option<f64>,
    /// Exposures of the same light at these steps in EV from the time, such as [-4, 0, 4], each a raw file of its own
    /// with noise of its own; hdr.exr merges them.
    #[schemars(transform = within(-LONGEST_STEP_EV..=LONGEST_STEP_EV))]
    pub(crate) bracket_ev: Option<Vec<f64>>,
    /// Exposure times of a bracket, s, in place of bracket_ev and time_s; the one in the middle stands for time_s.
    #[schemars(transform = above(0.0..))]
    pub(crate) bracket_times_s: Option<Vec<f64>>,
    /// Number of images to take of the same light. Left out: 1.
    #[schemars(transform = within(1.0..=1e6))]
    pub(crate) frames: Option<u32>,
    /// Time from the start of one image to the start of the next, s. Left out: one exposure follows another.
    #[schemars(transform = above(0.0..))]
    pub(crate) frame_interval_s: Option<f64>,
    /// Region of interest, the part of the sensor that is read out: [first column, first row, columns, rows]. Light is
    /// traced and metered for all of it, so that `photosite expose` can read out another. Left out: all, with covered
    /// pixels.
    pub(crate) region_px: Option<[usize; 4]>,
    /// Columns and rows of pixels of one colour that are read out as one, such as [2, 2]. Left out: [1, 1].
    #[schemars(transform = within(1.0..=16.0))]
    pub(crate) binning: Option<[usize; 2]>,
    /// Method of binning: "charge" adds electrons before they are read out, "sum" adds pixel values, "mean" takes their
    /// mean. Left out: "charge" for a CCD, else "mean".
    pub(crate) binning_method: Option<BinningMethod>,
    /// Stages of the sensor that take part, such as ["shot-noise"] to see that noise alone; [] for none. Left out:
    /// all.
    pub(crate) stages: Option<Vec<Stage>>,
    /// Stages of the sensor to leave out, such as ["read-noise", "full-well"]; the noise of all others stays as it is.
    pub(crate) stages_off: Option<Vec<Stage>>,
}

/// Automatic gain control: from image to image the gain makes up for a part of the difference between the mean and its
/// target, dB.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct GainControlTable {
    /// Mean of an image that gain control aims at, as a part of saturation, above 0 and below 1. Left out: 0.18.
    #[schemars(transform = above(0.0..1.0))]
    pub(crate) target: Option<f64>,
    /// Part of the error, dB, that gain control makes up from one image to the next, above 0 up to 1. Left out: 0.5.
    #[schemars(transform = above(0.0..=1.0))]
    pub(crate) attack: Option<f64>,
    /// Smallest and largest analogue gain, dB. Left out: those of the sensor.
    pub(crate) limits_db: Option<[f64; 2]>,
}

/// Files that are written.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputTable {
    /// Formats of the raw image. Left out: ["dng"].
    pub(crate) raw: Option<Vec<RawFormat>>,
    /// Lossless compression of DNG files: "none"; "packed", with no more bits than pixel values need; "lossless-jpeg",
    /// which every developer reads; or "deflate", for which pixel values become floating-point numbers. Left out:
    /// "none".
    pub(crate) dng_compression: Option<DngCompression>,
    /// Exposure compensation that developers, this one among them, apply to a DNG file by default, EV
    /// (BaselineExposure). Left out: 0.
    #[schemars(transform = within(-10.0..=10.0))]
    pub(crate) dng_baseline_exposure_ev: Option<f64>,
    /// Colour filter array of raw files: that of the "sensor"; a "bayer" mosaic made from blocks of pixels of one
    /// colour (Quad Bayer); or "linear", red, green and blue at every pixel, made from any mosaic of them. Left out:
    /// "sensor".
    pub(crate) raw_layout: Option<RawLayout>,
    /// Spectral irradiance on the sensor: true, or { bands_nm = [first, last, step] }. Wavelengths are drawn for the
    /// image first, and at most a fifth of them for bands where the sensor sees little, which are therefore noisier.
    /// Left out: false.
    pub(crate) irradiance: Option<IrradianceSource>,
    /// Ideal image beside image.png: what an observer with the eyes of the CIE would see, without sensor noise,
    /// mosaic or errors of colour, as ideal.exr and ideal.png. Left out: false.
    pub(crate) ideal: Option<bool>,
    /// Ground truth at each pixel: true for all layers, or a list of "depth" and "distance" (m), "position" (world, m),
    /// "normal", "shading-normal", "uv", "albedo", "object-position" (m), "nocs", "instance", "material", "flow" (px to
    /// the next image), "disparity" (px, left image less right one). At the centres of the pixels of image.png, or of
    /// the raw image where none is developed or image.png is freed of distortion; where something moves, in the middle
    /// of the exposure of each row. Left out: false.
    pub(crate) truth: Option<TruthSource>,
    /// Formats of ground truth: "exr" for one file truth.exr; "npy" or "png" (16 bits) for one file a layer. Left out:
    /// ["exr"].
    pub(crate) truth_formats: Option<Vec<TruthFormat>>,
    /// Step of depth and distance in PNG files, mm. Left out: 1.
    #[schemars(transform = above(0.0..))]
    pub(crate) truth_depth_unit_mm: Option<f64>,
    /// Pose of the other camera of a stereo pair, which has the same lens and sensor, for "disparity"; false where
    /// there is none, so that disparity is left out.
    pub(crate) truth_partner: Option<PartnerSource>,
    /// Changes that lead to the next image, which "flow" points to: keys of this capture as `--set` has them, such as
    /// ["camera.position_m=[0.1, 0, 1]"]; or false where there is no next image, so that no flow is valid. Left out:
    /// time alone, in which camera and scene move on.
    pub(crate) truth_next: Option<NextSource>,
    /// Ground truth of each object in objects.json: pose, boxes, visible and whole masks, visible part, points. Objects
    /// are numbered as in "instance". Left out: false.
    pub(crate) objects: Option<bool>,
    /// Noise maps, what each effect of the sensor has added to each pixel of the raw image: true for all maps, or a
    /// list such as "photon_shot_noise_e", "dark_current_e", "prnu_e", "dsnu_e", "read_noise_e", "quantisation_dn",
    /// "saturated"; e for e⁻, dn for DN. "raw_clean" is the raw image without temporal noise. Left out: false.
    pub(crate) noise: Option<NoiseSource>,
    /// Formats of noise maps: "exr" for one file noise.exr, "npy" for one file a map. Left out: ["exr"].
    pub(crate) noise_formats: Option<Vec<NoiseFormat>>,
    /// Developed image, image.png. Left out: true.
    pub(crate) image: Option<bool>,
    /// Mean electrons of each pixel without the sensor's noise, electrons.exr. Left out: true, and false for the images
    /// of a data set.
    pub(crate) electrons: Option<bool>,
    /// Interval of previews of a render that is under way, s; 0 for none. Left out: 10.
    #[schemars(transform = within(0.0..))]
    pub(crate) preview_interval_s: Option<f64>,
    /// Interval of checkpoints, s, from which the same command continues a render that was interrupted; 0 for none.
    /// Left out: 60.
    #[schemars(transform = within(0.0..))]
    pub(crate) checkpoint_interval_s: Option<f64>,
}

/// Pose of the other camera of a stereo pair, in the axes of this one: x right, y up, looking along −z.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartnerTable {
    /// Centre of its lens, m.
    pub(crate) position_m: [f64; 3],
    /// Point on its optical axis, m. Left out: straight ahead.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// Direction that is up in its image. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
}

/// false, or the pose of the other camera.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected false, or a table such as { position_m = [0.1, 0, 0] }")]
pub(crate) enum PartnerSource {
    /// There is none.
    Flag(bool),
    /// Pose of the partner.
    Place(PartnerTable),
}

/// false, or changes to keys of the capture.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected false, or a list such as [\"camera.position_m=[0.1, 0, 1]\"]")]
pub(crate) enum NextSource {
    /// There is no next image.
    Flag(bool),
    /// `key=value` for each.
    Changes(Vec<String>),
}

/// true, false, or a list of layers.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(
    untagged,
    expecting = "expected true, false, or a list such as [\"depth\", \"normal\"]; `photosite schema` has all layers"
)]
pub(crate) enum TruthSource {
    /// All layers, or none.
    Flag(bool),
    /// These layers.
    Layers(Vec<TruthLayer>),
}

/// true, false, or a list of maps.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(
    untagged,
    expecting = "expected true, false, or a list such as [\"read_noise_e\", \"prnu_e\"]; `photosite schema` has all maps"
)]
pub(crate) enum NoiseSource {
    /// All maps, or none.
    Flag(bool),
    /// These maps.
    Maps(Vec<NoiseMap>),
}

/// true, false, or { bands_nm = [first, last, step] }.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected true, false, or { bands_nm = [400, 700, 10] }")]
pub(crate) enum IrradianceSource {
    /// Whether irradiance is written, in bands of 10 nm from 400 to 700 nm.
    Flag(bool),
    /// In these bands.
    Bands(Bands),
}

/// Spectral bands.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bands {
    /// First edge, last edge and width of the bands, nm.
    #[schemars(transform = above(0.0..=1100.0))]
    pub(crate) bands_nm: [f64; 3],
}

/// Formats of raw images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum RawFormat {
    /// Digital negative.
    Dng,
    /// 16-bit TIFF of the pixel values.
    Tiff,
    /// 16-bit PGM of the pixel values, or PPM where every pixel has three channels.
    Pgm,
    /// NumPy array of the pixel values.
    Npy,
    /// OpenEXR image of the pixel values as 32-bit floats.
    Exr,
}

impl RawFormat {
    /// Format of the files.
    pub fn format(self) -> &'static Format {
        Format::of_ending(keys::name(&self).trim_matches('"')).expect("keys name formats by their endings")
    }
}
