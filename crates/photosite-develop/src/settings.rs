//! Settings of development: the keys of a capture file's `[develop]` table. Doc comments become the JSON Schema's
//! descriptions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::choices::{
    ColourModel, Defects, Demosaic, Highlights, NoiseFilter, ResizeFilter, Thresholding, ToneCurve, WhiteBalance,
};
use super::description::RawDescription;
use super::encode::Encoding;
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_raw::{Orientation, RawMetadata};

/// Development of raw images, step by step in this order.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct DevelopSettings {
    /// Metadata that the raw file lacks or has wrong.
    pub raw: RawDescription,
    /// Whether nonlinear pixel values are made linear by the table of the raw file. Left out: true.
    pub linearisation: bool,
    /// Subtracts the black level. Left out: true.
    pub black_level: bool,
    /// Correction of defective pixels. Left out: "none".
    pub defects: Defects,
    /// Brightens the corners by what the lens darkens them, where the raw file has a map of it. Left out: true.
    pub lens_falloff: bool,
    /// Shows only the part of the image that the raw file names (DNG DefaultCropOrigin and DefaultCropSize). Left out:
    /// true.
    pub default_crop: bool,
    /// White balance. Left out: "as-shot".
    pub white_balance: WhiteBalance,
    /// Colour temperature of white_balance = "temperature", K.
    #[schemars(transform = within(1000.0..=40_000.0))]
    #[keys(example = "5000")]
    pub temperature_k: Option<f64>,
    /// Tint of white_balance = "temperature": 3000 times the distance from the blackbodies in CIE 1960 (u, v), positive
    /// for a greenish light. Left out: 0.
    #[schemars(transform = within(-150.0..=150.0))]
    #[keys(example = "10")]
    pub tint: Option<f64>,
    /// Grey patch of white_balance = "patch": column and row of its first pixel, columns and rows.
    pub patch_px: Option<[usize; 4]>,
    /// Demosaicking, the interpolation of the channels that a pixel lacks. Left out: "auto".
    pub demosaic: Demosaic,
    /// Treatment of pixels that are saturated in one channel. Left out: "clip".
    pub highlights: Highlights,
    /// Smooths noise. Left out: "none".
    pub noise_filter: NoiseFilter,
    /// Radius of the noise filter's window, pixels. Left out: 1 for mean and median, 2 for gaussian, 3 for bilateral, 5
    /// for non-local-means.
    #[schemars(transform = within(1.0..=50.0))]
    pub noise_radius_px: Option<usize>,
    /// Strength of bilateral and non-local-means: the standard deviation that they take for noise, in multiples of what
    /// the raw file states or, where it says nothing, the image shows. Left out: 1.
    #[schemars(transform = within(0.01..=100.0))]
    #[keys(example = "1.5")]
    pub noise_strength: Option<f64>,
    /// Standard deviation of the weights by distance of gaussian and bilateral, pixels: with noise_radius_px = 2, 1.0
    /// makes gaussian the kernel of cv2.GaussianBlur(image, (5, 5), 1), mirrored at the edges as there. Left out: a
    /// third of the radius, and ½ more for bilateral.
    #[schemars(transform = within(0.01..=100.0))]
    #[keys(example = "1.0")]
    pub noise_sigma_px: Option<f64>,
    /// Standard deviation of the weights by difference of bilateral, where saturation is 1, in place of noise_strength.
    /// The filter is then cv2.bilateralFilter(image, 2·noise_radius_px + 1, noise_sigma_range, noise_sigma_px): its
    /// window is a disk, differences of channels are added up, and edges mirrored. Left out: 3·noise_strength standard
    /// deviations of noise, in a square window that the edges cut off.
    #[schemars(transform = within(1e-6..=1e6))]
    #[keys(example = "0.1")]
    pub noise_sigma_range: Option<f64>,
    /// Numbers that the pixels around each pixel are weighted with, rows from the top, of odd sides:
    /// [[0, -1, 0], [-1, 5, -1], [0, -1, 0]]. Correlation, as cv2.filter2D: the first number weighs the pixel above to
    /// the left; turn the kernel by 180° for a convolution. Edges are mirrored. Kernels of rank 1 are applied along
    /// rows and then along columns. Left out: none.
    #[schemars(transform = within(-1e6..=1e6))]
    pub kernel: Option<Vec<Vec<f64>>>,
    /// Divides the numbers of kernel by their sum. Left out: false.
    pub kernel_normalised: Option<bool>,
    /// Undoes the lens's distortion: the image is that of a pinhole of the camera's matrix, an omnidirectional lens's
    /// over 1 + ξ. Known of DNG files alone. Lenses whose image reaches 90° from the axis, and panoramas, keep
    /// theirs. Left out: true.
    pub distortion: bool,
    /// Gives the image square pixels of the finer pitch, ⌊columns·p_x/p + ½⌋ × ⌊rows·p_y/p + ½⌋ of them with
    /// p = min(p_x, p_y); false keeps the grid of the sensor, and PNG, TIFF, JPEG and EXR files state the shape of its
    /// pixels. Known of DNG files alone. Left out: true.
    pub square_pixels: bool,
    /// Turns the image upright, last of all, where a raw file, TIFF, PNG or JPEG says how it was held (Orientation);
    /// false leaves it as the sensor lay. resize_px is the size of the upright image. Left out: true.
    pub orientation: bool,
    /// Enlarges the middle of the image to all of its pixels: 2 shows the middle half of columns and rows. Left out:
    /// 1.
    #[schemars(transform = within(1.0..=1000.0))]
    #[keys(example = "2.0")]
    pub digital_zoom: f64,
    /// Columns and rows that the image is resized to. Pixel centres stay in proportion as cv2.resize has it, edges
    /// are repeated, and pixels count as having kept their shape. Left out: as many as there are.
    #[schemars(transform = within(1.0..=65_535.0))]
    pub resize_px: Option<[usize; 2]>,
    /// Interpolation of digital_zoom and resize_px. Left out: "cubic".
    pub resize_filter: Option<ResizeFilter>,
    /// Widens the filter by the factor that an image gets smaller by, so that fine patterns become grey; false takes
    /// as few pixels as for a larger one, as cv2.resize does. Of no effect for "nearest". Left out: true.
    pub resize_antialias: Option<bool>,
    /// Whether the camera's channels become colours by its colour matrix. Left out: true.
    pub colour_matrix: bool,
    /// Colour space of the image. Left out: "srgb".
    pub colour_space: ColourSpace,
    /// Colour model of the pixel values. Others than "rgb" and "grey" are for EXR, TIFF and NPY files, as 32-bit
    /// floats. Left out: "rgb".
    pub colour_model: ColourModel,
    /// Brightening by 2^exposure_ev. Left out: 0.
    #[schemars(transform = within(-20.0..=20.0))]
    #[keys(example = "0.5")]
    pub exposure_ev: f64,
    /// Tone curve from linear light to the codes of the image; EXR and NPY files stay linear, but for filmic,
    /// reinhard, log and local, whose light they hold. Left out: "srgb".
    pub tone_curve: ToneCurve,
    /// Luminance that tone_curve = "reinhard" makes of the logarithmic mean: 0.09 is dark, 0.36 bright. Left out: 0.18.
    #[schemars(transform = within(1e-3..=100.0))]
    #[keys(example = "0.18")]
    pub tone_key: Option<f64>,
    /// Smallest L that tone_curve = "reinhard" makes white; inf compresses all to below white. Left out: that of the
    /// brightest pixel.
    #[schemars(transform = within(1e-6..))]
    #[keys(example = "1.0")]
    pub tone_white: Option<f64>,
    /// Bias of tone_curve = "log". Left out: 0.85.
    #[schemars(transform = within(0.1..=1.0))]
    #[keys(example = "0.85")]
    pub tone_bias: Option<f64>,
    /// Ratio of the brightest to the darkest place of the base that tone_curve = "local" leaves. Left out: 50.
    #[schemars(transform = within(1.1..=1e6))]
    #[keys(example = "50")]
    pub tone_contrast: Option<f64>,
    /// Standard deviation by distance of the bilateral filter of tone_curve = "local", pixels. Left out: 2 % of the
    /// longer side.
    #[schemars(transform = within(0.1..=10_000.0))]
    #[keys(example = "40")]
    pub tone_sigma_px: Option<f64>,
    /// Standard deviation by difference of that filter, powers of ten. Left out: 0.4.
    #[schemars(transform = within(0.01..=10.0))]
    #[keys(example = "0.4")]
    pub tone_sigma_range: Option<f64>,
    /// Exponent of tone_curve = "gamma". Left out: 2.2.
    #[schemars(transform = within(0.1..=10.0))]
    #[keys(example = "2.2")]
    pub gamma: Option<f64>,
    /// Makes a binary image of the light that is shown, with colour_model = "rgb" or "grey". Left out: "none".
    pub threshold: Thresholding,
    /// Level of threshold = "level", linear light with white at 1; what is equal becomes black. Left out: 0.5.
    #[schemars(transform = within(0.0..=1e6))]
    #[keys(example = "0.5")]
    pub threshold_level: Option<f64>,
    /// Amount of sharpening (unsharp mask): the part of the difference to a smoothed image that is added. Left out:
    /// 0.
    #[schemars(transform = within(0.0..=10.0))]
    #[keys(example = "0.5")]
    pub sharpening: f64,
    /// Standard deviation of that smoothing, pixels. Left out: 1.
    #[schemars(transform = within(0.2..=20.0))]
    #[keys(example = "1.0")]
    pub sharpening_radius_px: Option<f64>,
    /// Bits of the image's codes, 8 or 16; JPEG has 8, EXR and NPY 32-bit floats. Left out: 8.
    #[schemars(extend("enum" = [8, 16]), transform = within(8.0..=16.0))]
    pub bits: u8,
    /// Adds noise of one code before rounding, so that flat gradients have no steps and means stay exact. Left out:
    /// false.
    pub dither: bool,
    /// Quality of JPEG files, 1–100. Left out: 95.
    #[schemars(transform = within(1.0..=100.0))]
    #[keys(example = "90")]
    pub jpeg_quality: u8,
}

impl Default for DevelopSettings {
    fn default() -> Self {
        Self {
            raw: RawDescription::default(),
            linearisation: true,
            black_level: true,
            defects: Defects::default(),
            lens_falloff: true,
            default_crop: true,
            white_balance: WhiteBalance::default(),
            temperature_k: None,
            tint: None,
            patch_px: None,
            demosaic: Demosaic::default(),
            highlights: Highlights::default(),
            noise_filter: NoiseFilter::default(),
            noise_radius_px: None,
            noise_strength: None,
            noise_sigma_px: None,
            noise_sigma_range: None,
            kernel: None,
            kernel_normalised: None,
            distortion: true,
            square_pixels: true,
            orientation: true,
            digital_zoom: 1.0,
            resize_px: None,
            resize_filter: None,
            resize_antialias: None,
            colour_matrix: true,
            colour_space: ColourSpace::default(),
            colour_model: ColourModel::default(),
            exposure_ev: 0.0,
            tone_curve: ToneCurve::default(),
            tone_key: None,
            tone_white: None,
            tone_bias: None,
            tone_contrast: None,
            tone_sigma_px: None,
            tone_sigma_range: None,
            gamma: None,
            threshold: Thresholding::default(),
            threshold_level: None,
            sharpening: 0.0,
            sharpening_radius_px: None,
            bits: 8,
            dither: false,
            jpeg_quality: 95,
        }
    }
}

impl DevelopSettings {
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

    /// Standard deviation of the noise filter's weights by distance, pixels.
    pub fn noise_sigma_px(&self) -> f64 {
        let third = self.noise_radius_px() as f64 / 3.0;
        self.noise_sigma_px.unwrap_or(if self.noise_filter == NoiseFilter::Bilateral { third + 0.5 } else { third })
    }

    /// Whether the image gets other pixels than those of its grid.
    pub fn resizes(&self) -> bool {
        self.resize_px.is_some() || self.digital_zoom != 1.0
    }

    /// Luminance that "reinhard" makes of the logarithmic mean.
    pub fn tone_key(&self) -> f64 {
        self.tone_key.unwrap_or(0.18)
    }

    /// The bias of "log".
    pub fn tone_bias(&self) -> f64 {
        self.tone_bias.unwrap_or(0.85)
    }

    /// The contrast of the base that "local" leaves.
    pub fn tone_contrast(&self) -> f64 {
        self.tone_contrast.unwrap_or(50.0)
    }

    /// Standard deviation of the bilateral filter of "local" by difference, powers of ten.
    pub fn tone_sigma_range(&self) -> f64 {
        self.tone_sigma_range.unwrap_or(0.4)
    }

    /// The level of threshold = "level".
    pub fn threshold_level(&self) -> f64 {
        self.threshold_level.unwrap_or(0.5)
    }

    /// Standard deviation of the unsharp mask, pixels.
    pub(super) fn sharpening_radius_px(&self) -> f64 {
        self.sharpening_radius_px.unwrap_or(1.0)
    }

    /// Orientation by which an image of such a file is turned.
    pub fn orientation(&self, metadata: &RawMetadata) -> Orientation {
        if self.orientation { metadata.orientation } else { Orientation::default() }
    }

    /// Width over height of the pixels of an image that is developed from such a raw file.
    pub fn pixel_aspect(&self, metadata: &RawMetadata) -> f64 {
        if self.square_pixels { 1.0 } else { metadata.pixel_aspect() }
    }

    /// Transfer function of linear values.
    pub fn transfer(&self) -> Transfer {
        match self.tone_curve {
            ToneCurve::Linear => Transfer::Linear,
            ToneCurve::Srgb | ToneCurve::Filmic | ToneCurve::Reinhard | ToneCurve::Log | ToneCurve::Local => {
                Transfer::Srgb
            }
            ToneCurve::Gamma => Transfer::Gamma(self.gamma.unwrap_or(2.2)),
        }
    }

    /// Encoding of linear values as the codes of an image.
    pub fn encoding(&self) -> Encoding {
        Encoding {
            colour_space: self.colour_space,
            transfer: self.transfer(),
            bits: self.bits,
            dither: self.dither,
            sharpening: self.sharpening,
            sharpening_radius_px: self.sharpening_radius_px(),
        }
    }

    /// Keys that were given and say something of a raw file, of which an image that is light already has nothing.
    pub fn raw_keys(&self) -> Vec<&'static str> {
        let default = Self::default();
        let given = [
            ("raw", self.raw != default.raw),
            ("linearisation", self.linearisation != default.linearisation),
            ("black_level", self.black_level != default.black_level),
            ("defects", self.defects != default.defects),
            ("lens_falloff", self.lens_falloff != default.lens_falloff),
            ("default_crop", self.default_crop != default.default_crop),
            ("white_balance", self.white_balance != default.white_balance),
            ("demosaic", self.demosaic != default.demosaic),
            ("highlights", self.highlights != default.highlights),
            ("distortion", self.distortion != default.distortion),
            ("colour_matrix", self.colour_matrix != default.colour_matrix),
        ];
        given.into_iter().filter_map(|(key, is_given)| is_given.then_some(key)).collect()
    }
}
