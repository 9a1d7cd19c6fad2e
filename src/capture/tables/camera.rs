//! `[camera]` and `[lens]`.

use schemars::JsonSchema;
use serde::Deserialize;

use super::CameraMotionTable;
use super::lens_elements::{AutofocusSearchTable, LensmakerTable, SupplementaryTable};
use crate::sensor::SpectrumSource;
use photosite_core::schema_range::{above, within};

/// Where the camera stands and looks: position_m and look_at_m, or gltf_camera.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraTable {
    /// Where the centre of the lens is, m. Left out, as is gltf_camera: where the first camera of the geometry's files is,
    /// or where all of the geometry is in the picture.
    pub(crate) position_m: Option<[f64; 3]>,
    /// A point on the axis, m; needed with position_m.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// What is up in the picture. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
    /// Name of a camera of the glTF files.
    pub(crate) gltf_camera: Option<String>,
    /// How it moves while it records. Left out: not at all.
    pub(crate) motion: Option<CameraMotionTable>,
}

/// The lens.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LensTable {
    /// Left out: "thin".
    #[serde(rename = "type")]
    pub(crate) kind: Option<LensType>,
    /// The surfaces and glasses of a lens, which all rays are traced through exactly: the name of one that ships with
    /// photosite, such as "double-gauss", or a file: photosite's own .toml or .json, .zmx, .seq, Optical Bench .txt, pbrt
    /// .dat, Optiland and DeepLens .json, .roa. Its distortion, colour errors, vignetting, falloff and breathing are in the picture.
    /// focus_distance_m counts from the sensor then, and image_distance_mm from the last surface. Paths carry one
    /// wavelength each.
    pub(crate) prescription: Option<String>,
    /// Focal length, mm; below 0 for a diverging lens; of a prescription, what a zoom is set to. Left out: that of the
    /// prescription's first position, what the lensmaker's equation, the field of view of a
    /// glTF camera or the intrinsics ask for, else 16.
    pub(crate) focal_length_mm: Option<f64>,
    /// In place of focal_length_mm: the angle between what the left and the right edge of the picture see, degrees,
    /// distortion included, with the lens focused at the distance that it states (else at infinity).
    #[schemars(transform = above(0.0..=360.0))]
    pub(crate) horizontal_fov_deg: Option<f64>,
    /// In place of focal_length_mm: the glass of a lens in one piece. Each wavelength has a focus of its own, and
    /// distances are those at 587.6 nm.
    pub(crate) lensmaker: Option<LensmakerTable>,
    /// Lenses before this one, such as close-up lenses. The camera stands where its entrance pupil is, as all these
    /// lenses make it.
    #[serde(default)]
    pub(crate) supplementary: Vec<SupplementaryTable>,
    /// Focal length over the diameter of the aperture, or of the circle through the corners of one with blades. Left
    /// out: 8; of a prescription, that of the open lens; of a hole, as is its diameter, what makes it sharpest at 550 nm, √(distance/2.44·λ).
    #[schemars(transform = above(0.0..))]
    pub(crate) f_number: Option<f64>,
    /// In place of f_number: diameter of the aperture, or of a hole, mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) diameter_mm: Option<f64>,
    /// Distance from the lens to what is sharp, along the axis, m; "infinity"; or "scene", that of the middle of the
    /// geometry (of the picture where that cannot be focused on). Nothing to a pinhole. Left out: what autofocus finds.
    pub(crate) focus_distance_m: Option<FocusDistance>,
    /// Focuses on what is seen at a pixel: column and row from the top-left corner, or "centre". Left out, as is the
    /// distance: "centre". Nothing to a pinhole.
    pub(crate) autofocus_px: Option<AutofocusTable>,
    /// How autofocus finds the distance. Left out: exactly.
    pub(crate) autofocus: Option<AutofocusSearchTable>,
    /// In place of a focus: distance from the lens, or the hole, to the sensor, mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) image_distance_mm: Option<f64>,
    /// The nearest distance that the lens can be focused on, m, without lenses before it. Left out: no limit.
    #[schemars(transform = above(0.0..))]
    pub(crate) min_focus_distance_m: Option<f64>,
    /// The circle of confusion that counts as sharp, µm on the sensor, which depth of field is stated for. Left out: the
    /// diagonal of the sensor over 1440, 30 µm of 36 × 24 mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) circle_of_confusion_um: Option<f64>,
    /// Aperture blades; 0 is a round aperture. Left out: 0, or those of the prescription.
    pub(crate) blades: Option<u32>,
    /// Turns the blades, degrees. Left out: 0.
    pub(crate) blade_rotation_deg: Option<f64>,
    /// Whether it gets darker towards the corners. Left out: "cos4".
    pub(crate) falloff: Option<FalloffName>,
    /// Transmittance, 0–1: a number, the name of a spectrum that ships with photosite, or { file = "lens.csv" }. Left
    /// out: 1.
    pub(crate) transmittance: Option<SpectrumSource>,
    /// How directions become places in the picture. Left out: "fisheye" with distortion of kannala-brandt,
    /// "omnidirectional" with xi, else "perspective".
    pub(crate) projection: Option<ProjectionName>,
    /// Mirror parameter ξ of an omnidirectional lens, which needs it: 0 for a pinhole, 1 for a parabolic mirror.
    #[schemars(transform = within(0.0..))]
    pub(crate) xi: Option<f64>,
    /// Distortion. Left out: none.
    pub(crate) distortion: Option<DistortionTable>,
    /// Angle from the axis beyond which the lens sees nothing: the rim of its image circle. Left out: all that its
    /// projection can show.
    #[schemars(transform = above(0.0..))]
    pub(crate) max_angle_deg: Option<f64>,
    /// The picture of a point. Left out: a point.
    pub(crate) psf: Option<PointSpreadTable>,
    /// Lateral chromatic aberration. Left out: none.
    pub(crate) lateral_colour: Option<LateralColourTable>,
    /// Rings that cut off light beside the aperture. Left out: none.
    #[serde(default)]
    pub(crate) stops: Vec<StopTable>,
    /// The pinhole matrix, in place of the one that follows from focal length and focus.
    pub(crate) intrinsics: Option<IntrinsicsTable>,
}

/// Kinds of lenses.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LensType {
    /// With depth of field.
    Thin,
    /// Everything is sharp, and the picture lies one focal length behind it, without focus; the f-number sets the
    /// exposure only, to that of a thin lens on the axis.
    Pinhole,
    /// A hole of some diameter at the distance of one focal length before the sensor, or image_distance_mm: each point
    /// becomes a spot of its size, and with psf = { kind = "airy" } diffraction widens it.
    Hole,
    /// A bare sensor: each pixel sees all that is in front of it. position_m is the middle of the sensor, which stands
    /// as it does behind a lens: upside down, so that what lies to the right shades the left of the picture.
    None,
}

/// A distance in metres, "infinity" or "scene".
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a distance in metres, \"infinity\" or \"scene\"")]
pub(crate) enum FocusDistance {
    /// m.
    Metres(#[schemars(transform = above(0.0..))] f64),
    /// "infinity" or "scene".
    Name(#[schemars(extend("enum" = ["infinity", "scene"]))] String),
}

/// A pixel: column and row from the top-left corner, or "centre".
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a pixel such as [400, 300], or \"centre\"")]
pub(crate) enum AutofocusTable {
    /// Column and row.
    Pixel(#[schemars(transform = within(0.0..))] [f64; 2]),
    /// "centre".
    Name(#[schemars(extend("const" = "centre"))] String),
}

/// Whether it gets darker towards the corners.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum FalloffName {
    /// By the natural cos⁴ of each point of the aperture, for a rectilinear lens; by the étendue for any other.
    Cos4,
    /// As bright everywhere as on the axis of a thin lens of this f-number: π·sin²θ' times the mean radiance over a
    /// round aperture, where tan θ' is its radius over the distance from the lens to the sensor.
    None,
}

/// How directions become places in the picture.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ProjectionName {
    /// Rectilinear: straight lines stay straight, but for the distortion.
    Perspective,
    /// The radius is the angle from the axis, but for the distortion (Kannala and Brandt; OpenCV's fisheye).
    Fisheye,
    /// A fisheye whose radius is 2f·sin(θ/2) at the angle θ from the axis: equal solid angles are equal areas.
    Equisolid,
    /// A fisheye whose radius is 2f·tan(θ/2): small circles stay circles.
    Stereographic,
    /// A fisheye whose radius is f·sin θ; it sees a half-space.
    Orthographic,
    /// A panorama of longitude and latitude.
    Equirectangular,
    /// The unified model of mirrors and fisheyes, with xi (Mei and Rives; OpenCV's omnidir).
    Omnidirectional,
}

/// How the lens departs from its projection.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DistortionTable {
    /// The model.
    pub(crate) model: DistortionModel,
    /// Radial coefficients: k₁ … k₆ of brown-conrady (k₁, k₂ of an omnidirectional lens), k₁ … k₄ of kannala-brandt,
    /// k₁, k₂ of polynomial, λ of division. Those left out are 0.
    #[serde(default)]
    pub(crate) k: Vec<f64>,
    /// Tangential coefficients p₁, p₂ of brown-conrady.
    #[serde(default)]
    pub(crate) p: Vec<f64>,
    /// Thin-prism coefficients s₁ … s₄ of brown-conrady.
    #[serde(default)]
    pub(crate) s: Vec<f64>,
}

/// Models of distortion.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum DistortionModel {
    /// None.
    None,
    /// Radial, rational, tangential and thin-prism (OpenCV's standard model), from the ideal to the distorted picture.
    BrownConrady,
    /// u = u_d·(1 + k₁r² + k₂r⁴), from the distorted to the ideal picture.
    Polynomial,
    /// u = u_d/(1 + λr²), from the distorted to the ideal picture.
    Division,
    /// The radius θ + k₁θ³ + k₂θ⁵ + k₃θ⁷ + k₄θ⁹ of a fisheye.
    KannalaBrandt,
}

/// The picture of a point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum PointSpreadTable {
    /// The same at all wavelengths.
    Gaussian {
        /// Standard deviation along each axis, µm on the sensor.
        #[schemars(transform = above(0.0..))]
        sigma_um: f64,
    },
    /// Diffraction at a round aperture, for each wavelength.
    Airy,
    /// Of a prescription: its aberrations and the diffraction at its stop together, from the optical path differences over
    /// its pupil in the plane of focus, by place and wavelength. What lies before or behind that plane is blurred by the
    /// size of the pupil alone, and no longer by the aberrated shape that the rays of the glass give.
    Wave,
    /// As measured.
    Kernel {
        /// Distance between the values of the files, µm on the sensor.
        #[schemars(transform = above(0.0..))]
        pitch_um: f64,
        /// At least one; the nearest counts.
        kernels: Vec<KernelTable>,
        /// What of a kernel lies where the lens puts the point. Left out: "centre".
        origin: Option<KernelOrigin>,
    },
}

/// What of a kernel lies where the lens puts the point.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum KernelOrigin {
    /// The middle of its rows and columns: the centre of a value where their number is odd, and where it is even
    /// half-way between two. Light that is not about it shifts the picture, against ground truth as well.
    Centre,
    /// Its light in the mean, so that it shifts nothing.
    Centroid,
}

/// A measured picture of a point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct KernelTable {
    /// CSV file: a row of numbers a line; only their ratios count.
    pub(crate) file: String,
    /// Where in the picture it was measured, from −1 at the left and the top edge to 1 at the opposite ones. Left out:
    /// the middle.
    #[serde(default)]
    pub(crate) at: [f64; 2],
}

/// Size of the picture by wavelength.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct LateralColourTable {
    /// nm, rising.
    pub(crate) wavelength_nm: Vec<f64>,
    /// Magnification about the principal point at each, for example 1.001; linear between them.
    #[schemars(transform = above(0.0..))]
    pub(crate) magnification: Vec<f64>,
}

/// A round opening across the axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StopTable {
    /// Distance before the lens, mm; below 0 behind it.
    pub(crate) distance_mm: f64,
    /// Radius, mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) radius_mm: f64,
}

/// A pinhole matrix in OpenCV's convention: the centre of the top-left pixel is (0, 0).
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct IntrinsicsTable {
    /// Focal length in pixel widths.
    #[schemars(transform = above(0.0..))]
    pub(crate) fx: f64,
    /// Focal length in pixel heights.
    #[schemars(transform = above(0.0..))]
    pub(crate) fy: f64,
    /// Column of the principal point.
    pub(crate) cx: f64,
    /// Row of the principal point.
    pub(crate) cy: f64,
    /// Skew, pixels.
    #[serde(default)]
    pub(crate) skew: f64,
}
