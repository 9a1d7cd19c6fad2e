//! `[exposure]`, `[render]` and `[output]`.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::calibration::truth::TruthLayer;
use crate::develop::RawLayout;
use crate::io::noise_maps::NoiseFormat;
use crate::io::truth::TruthFormat;
use crate::raw::DngCompression;
use crate::sensor::{BinningMethod, NoiseMap, Stage};
use photosite_core::schema_range::{above, within};

/// How long, at what gain and temperature.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExposureTable {
    /// Exposure time, s. Left out: chosen automatically.
    #[schemars(transform = above(0.0..))]
    pub(crate) time_s: Option<f64>,
    /// Chooses the time so that the bright parts of the picture just stay below saturation. Left out: true, unless a time
    /// is given.
    pub(crate) auto: Option<bool>,
    /// Where automatic exposure puts the bright parts, as a part of saturation. Left out: 0.85.
    #[schemars(transform = above(0.0..=1.0))]
    pub(crate) auto_target: Option<f64>,
    /// Part of the pixels that automatic exposure lets be brighter than that. Left out: 0.005.
    #[schemars(transform = within(0.0..1.0))]
    pub(crate) auto_brighter_part: Option<f64>,
    /// In place of these: the mean of the picture that automatic exposure aims at, as a part of saturation, such as
    /// 0.18.
    #[schemars(transform = above(0.0..1.0))]
    pub(crate) auto_mean: Option<f64>,
    /// How much brighter than that automatic exposure makes the picture, EV: 1 for twice as bright, -1 for half. Left
    /// out: 0.
    #[schemars(transform = within(-20.0..=20.0))]
    pub(crate) compensation_ev: Option<f64>,
    /// Longest time that automatic exposure may choose, s. Where it would need more, the gain rises, unless it is
    /// stated; where that is not enough either, the picture is darker, and a warning says by how much. Left out: 4.
    #[schemars(transform = above(0.0..))]
    pub(crate) max_time_s: Option<f64>,
    /// Gain up to which it rises, analogue and digital together, dB. Left out: the sensor's largest analogue gain.
    pub(crate) max_gain_db: Option<f64>,
    /// Analogue gain, dB. Left out: 0, or the sensor's smallest above it.
    pub(crate) gain_db: Option<f64>,
    /// Gain of the numbers behind the converter, dB, 0 to 48. Left out: 0.
    #[schemars(transform = within(0.0..=48.0))]
    pub(crate) digital_gain_db: Option<f64>,
    /// In place of the two gains: saturation-based ISO speed, from the sensor's base ISO on (`photosite info` tells
    /// it). Analogue gain gives as much of it as the sensor has, digital gain the rest.
    #[schemars(transform = above(0.0..))]
    pub(crate) iso: Option<f64>,
    /// Lets the analogue gain follow the light from picture to picture of a series (frames) at a fixed time, as video
    /// cameras do; the first one has gain_db. Left out: the gain stays.
    pub(crate) gain_control: Option<GainControlTable>,
    /// Temperature of the sensor, °C. Left out: 25.
    #[schemars(transform = above(-273.15..))]
    pub(crate) temperature_c: Option<f64>,
    /// Exposures of the same light in steps of so many EV from the time, such as [-4, 0, 4], each a raw file of its own
    /// with noise of its own; hdr.exr merges them.
    pub(crate) bracket_ev: Option<Vec<f64>>,
    /// The same by the times themselves, s, in place of time_s; the one in the middle takes its place.
    #[schemars(transform = above(0.0..))]
    pub(crate) bracket_times_s: Option<Vec<f64>>,
    /// How many pictures to take of the same light. Left out: 1.
    #[schemars(transform = within(1.0..=1e6))]
    pub(crate) frames: Option<u32>,
    /// Time from the start of one picture to that of the next, s. Left out: one exposure follows another.
    #[schemars(transform = above(0.0..))]
    pub(crate) frame_interval_s: Option<f64>,
    /// The part of the sensor that is read out: [first column, first row, columns, rows]. Light is traced and metered
    /// for all of it, so that `photosite expose` can read out another. Left out: all, with covered pixels.
    pub(crate) region_px: Option<[usize; 4]>,
    /// Columns and rows of pixels of one colour that are read out as one, such as [2, 2]. Left out: [1, 1].
    #[schemars(transform = within(1.0..=16.0))]
    pub(crate) binning: Option<[usize; 2]>,
    /// How: "charge" adds electrons before they are read out, "sum" numbers, "mean" takes the mean of numbers. Left
    /// out: "charge" for a CCD, else "mean".
    pub(crate) binning_method: Option<BinningMethod>,
    /// The stages of the sensor that take part, such as ["shot-noise"] to see that noise alone; [] for none. Left out:
    /// all.
    pub(crate) stages: Option<Vec<Stage>>,
    /// Stages of the sensor to leave out, such as ["read-noise", "full-well"]; the noise of all others stays as it is.
    pub(crate) stages_off: Option<Vec<Stage>>,
}

/// Automatic gain control: from picture to picture the gain makes up for a part of what the mean is off its target, dB.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GainControlTable {
    /// Mean of a picture that it aims at, as a part of saturation, above 0 and below 1. Left out: 0.18.
    #[schemars(transform = above(0.0..1.0))]
    pub(crate) target: Option<f64>,
    /// Part of the error, dB, that it makes up from one picture to the next, above 0 up to 1. Left out: 0.5.
    #[schemars(transform = above(0.0..=1.0))]
    pub(crate) attack: Option<f64>,
    /// Smallest and largest analogue gain, dB. Left out: those of the sensor.
    pub(crate) limits_db: Option<[f64; 2]>,
}

/// How light is traced.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderTable {
    /// Samples per pixel; with a time limit or a noise target, at most so many. Left out: 64.
    #[schemars(transform = within(1.0..))]
    pub(crate) samples_per_pixel: Option<u32>,
    /// Stop after so many seconds. Left out: no limit.
    #[schemars(transform = above(0.0..))]
    pub(crate) time_limit_s: Option<f64>,
    /// Stop in each pixel once the noise of rendering is below this part of the sensor's noise there, at the exposure
    /// (ratio of standard deviations).
    #[schemars(transform = above(0.0..))]
    pub(crate) noise_target: Option<f64>,
    /// Most segments of a light path; 1 sees lamps only, 2 direct light. Left out: 16.
    #[schemars(transform = within(1.0..))]
    pub(crate) max_depth: Option<u32>,
    /// Segments after which a path may end by chance (without bias). Left out: 5.
    pub(crate) roulette_depth: Option<u32>,
    /// Paths that go on from the first surface that is no mirror, for each sample, 1 to 256: light that comes off other
    /// surfaces costs less so. Left out: 1.
    #[schemars(transform = within(1.0..=256.0))]
    pub(crate) splitting: Option<u32>,
    /// Neighbouring pixels that share what their paths find beyond the first surface where both are diffuse, 1 to 64:
    /// 16 of them, a square, have as little noise of light off other surfaces as sixteen times the samples, but errors
    /// of neighbours go together. Not where a camera or a scene moves, nor with wavelengths = "own-filter" or
    /// light_paths. Left out: 1.
    #[schemars(transform = within(1.0..=64.0))]
    pub(crate) reuse: Option<u32>,
    /// Paths that set out from surfaces that shine, for each sample, 0 to 64: they look for caustics, what glass,
    /// mirrors and polished metal throw on other surfaces. Not where a camera or a scene moves, on sensors that scan,
    /// nor with wavelengths = "own-filter" or reuse. Left out: 0.
    #[schemars(transform = within(0.0..=64.0))]
    pub(crate) light_paths: Option<f64>,
    /// Whose wavelengths the paths of a pixel carry: "all-filters"; or "own-filter", mostly what the filter above the
    /// pixel lets through, for raw pictures of glass that disperses or through more than four narrow filters: what else
    /// is told of the pixel's light (other filters in electrons.exr, irradiance.exr, ideal.exr) is noisier, and
    /// elsewhere the raw picture too. Without effect where all pixels see the same. Left out: "all-filters".
    pub(crate) wavelengths: Option<WavelengthsName>,
    /// Where random numbers come from. Left out: "sobol".
    pub(crate) sampler: Option<SamplerName>,
    /// Seed of rendering and sensor noise. Left out: 0.
    pub(crate) seed: Option<u64>,
}

/// Whose wavelengths the paths of a pixel carry.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WavelengthsName {
    /// Those that matter to any filter of the sensor.
    AllFilters,
    /// Mostly those that matter to the pixel's own.
    OwnFilter,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum SamplerName {
    /// Owen-scrambled Sobol points.
    Sobol,
    /// Independent random numbers: more noise, but its reported variance is exact.
    Independent,
}

/// What is written.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputTable {
    /// Formats of the raw picture. Left out: ["dng"].
    pub(crate) raw: Option<Vec<RawFormat>>,
    /// How DNG files are compressed, always without loss: "none"; "packed", with no more bits than numbers need;
    /// "lossless-jpeg", which every developer reads; or "deflate", for which numbers become floating-point ones. Left
    /// out: "none".
    pub(crate) dng_compression: Option<DngCompression>,
    /// By how much developers, this one among them, are to brighten a DNG file unasked, EV (BaselineExposure). Left
    /// out: 0.
    #[schemars(transform = within(-10.0..=10.0))]
    pub(crate) dng_baseline_exposure_ev: Option<f64>,
    /// The filters that raw files tell of: those of the "sensor"; a "bayer" mosaic made from blocks of pixels of one
    /// colour (Quad Bayer); or red, green and blue at every pixel, "linear", made from any mosaic of them. Left out:
    /// "sensor".
    pub(crate) raw_layout: Option<RawLayout>,
    /// Spectral irradiance on the sensor: true, or { bands_nm = [first, last, step] }. Wavelengths are drawn for the
    /// picture first, and at most a fifth of them for bands where the sensor sees little, which are noisier therefore.
    /// Left out: false.
    pub(crate) irradiance: Option<IrradianceSource>,
    /// The ideal picture beside image.png: what an observer with the eyes of the CIE would see, without sensor noise,
    /// mosaic or errors of colour, as ideal.exr and ideal.png. Left out: false.
    pub(crate) ideal: Option<bool>,
    /// What is really there at each pixel: true for all layers, or a list of "depth" and "distance" (m), "position"
    /// (world, m), "normal", "shading-normal", "uv", "albedo", "object-position" (m), "nocs", "instance", "material", "flow" (px to the next picture),
    /// "disparity" (px, left picture less right one). At the centres of the pixels of image.png, or of the raw image where
    /// none is developed or image.png is freed of distortion; where something moves, in the middle of the exposure of each
    /// row. Left out: false.
    pub(crate) truth: Option<TruthSource>,
    /// Formats of that: "exr" for one file truth.exr; "npy" or "png" (16 bits) for one file a layer. Left out: ["exr"].
    pub(crate) truth_formats: Option<Vec<TruthFormat>>,
    /// Millimetres that one step of a depth or distance in a PNG file stands for. Left out: 1.
    #[schemars(transform = above(0.0..))]
    pub(crate) truth_depth_unit_mm: Option<f64>,
    /// Where the other camera of a stereo pair is, one of the same kind, for "disparity"; false where there is none, so
    /// that it is left out.
    pub(crate) truth_partner: Option<PartnerSource>,
    /// What makes the next picture, which "flow" leads to: changes to keys of this capture, as `--set` has them, such
    /// as ["camera.position_m=[0.1, 0, 1]"]; or false where there is none, so that no flow is valid. Left out: time
    /// alone, in which camera and scene move on.
    pub(crate) truth_next: Option<NextSource>,
    /// What is known of each object, as objects.json: its pose, boxes, visible and whole masks, visible part, points.
    /// Numbers are those of "instance". Of all pixels of the sensor, as truth. Left out: false.
    pub(crate) objects: Option<bool>,
    /// What each effect of the sensor has added to every number of the raw picture: true for all maps, or a list such
    /// as "photon_shot_noise_e", "dark_current_e", "prnu_e", "dsnu_e", "read_noise_e", "quantisation_dn", "saturated";
    /// e for e⁻, dn for DN. "raw_clean" is the raw picture without temporal noise. Left out: false.
    pub(crate) noise: Option<NoiseSource>,
    /// Formats of that: "exr" for one file noise.exr, "npy" for one file a map. Left out: ["exr"].
    pub(crate) noise_formats: Option<Vec<NoiseFormat>>,
    /// The developed picture, image.png. Left out: true.
    pub(crate) image: Option<bool>,
    /// Mean electrons of every pixel, without noise. Left out: true, and false for the pictures of a data set.
    pub(crate) electrons: Option<bool>,
    /// Seconds between pictures of a render that is under way; 0 for none. Left out: 10.
    #[schemars(transform = within(0.0..))]
    pub(crate) preview_interval_s: Option<f64>,
    /// Seconds between checkpoints, from which a render that is broken off goes on when it is given again; 0 for none.
    /// Left out: 60.
    #[schemars(transform = within(0.0..))]
    pub(crate) checkpoint_interval_s: Option<f64>,
}

/// Where the other camera of a stereo pair is and looks, in the axes of this one: x right, y up, looking along −z.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartnerTable {
    /// Where the centre of its lens is, m.
    pub(crate) position_m: [f64; 3],
    /// A point on its axis, m. Left out: straight ahead.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// What is up in its picture. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
}

/// false, or where the other camera is.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected false, or a table such as { position_m = [0.1, 0, 0] }")]
pub(crate) enum PartnerSource {
    /// There is none.
    Flag(bool),
    /// Where it is.
    Place(PartnerTable),
}

/// false, or changes to keys of the capture.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected false, or a list such as [\"camera.position_m=[0.1, 0, 1]\"]")]
pub(crate) enum NextSource {
    /// There is no next picture.
    Flag(bool),
    /// `key=value` for each.
    Changes(Vec<String>),
}

/// true, false, or a list of layers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected true, false, or { bands_nm = [400, 700, 10] }")]
pub(crate) enum IrradianceSource {
    /// Whether it is written, in bands of 10 nm from 400 to 700 nm.
    Flag(bool),
    /// Which bands.
    Bands(Bands),
}

/// Spectral bands.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bands {
    /// First edge, last edge and width of the bands, nm.
    #[schemars(transform = above(0.0..=1100.0))]
    pub(crate) bands_nm: [f64; 3],
}

/// Formats of raw pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RawFormat {
    /// Digital negative.
    Dng,
    /// 16-bit TIFF of the digital numbers.
    Tiff,
    /// 16-bit PGM of the digital numbers, or PPM where every pixel has three channels.
    Pgm,
    /// NumPy array of the digital numbers.
    Npy,
    /// OpenEXR picture of the digital numbers as 32-bit floats.
    Exr,
}
