//! `[camera]` and `[lens]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::CameraMotionTable;
use super::lens_elements::{AutofocusSearchTable, LensmakerTable, SupplementaryTable};
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_sensor::SpectrumSource;
use photosite_transport::optics::Falloff;

/// Pose of the camera: position_m and look_at_m, gltf_camera, or calibration_pose.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraTable {
    /// Centre of the lens, m. Left out, as is gltf_camera: the place of the first camera of the geometry's files, or
    /// one from which all of the geometry is in the image.
    pub(crate) position_m: Option<[f64; 3]>,
    /// Point on the optical axis, m; needed with position_m.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// Direction that is up in the image. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
    /// Name of a camera of the glTF files.
    pub(crate) gltf_camera: Option<String>,
    /// Pose that `lens.calibration` holds, by what it is measured from: "world" of OpenCV; "imu", or a camera of the rig
    /// such as "cam0", of Kalibr; "body" of EuRoC; the name of an image of COLMAP's images.txt beside cameras.txt. That
    /// is the world then; a camera of the rig stands at its origin, upright, and looks along −z. Frames of a data set
    /// take it as the place in the rig.
    pub(crate) calibration_pose: Option<String>,
    /// Motion during the exposure. Left out: none.
    pub(crate) motion: Option<CameraMotionTable>,
}

/// The lens.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct LensTable {
    /// Left out: "thin".
    #[serde(rename = "type")]
    pub(crate) kind: Option<LensType>,
    /// Prescription, the surfaces and glasses of a lens through which all rays are traced exactly: the name of one that
    /// ships with photosite, such as "double-gauss", or a file: photosite's own .toml or .json, .zmx, .seq, Optical
    /// Bench .txt, pbrt .dat, Optiland and DeepLens .json, .roa. Its distortion, colour errors, vignetting, falloff and
    /// breathing are in the image. Then focus_distance_m counts from the sensor, and image_distance_mm from the last
    /// surface. Paths carry one wavelength each.
    pub(crate) prescription: Option<String>,
    /// Focal length, mm; below 0 for a diverging lens; of a prescription, the setting of a zoom. Left out: that of the
    /// prescription's first position, what the lensmaker's equation, the field of view of a
    /// glTF camera or the intrinsics ask for, else 16.
    pub(crate) focal_length_mm: Option<f64>,
    /// Horizontal field of view in place of focal_length_mm, the angle between the left and the right edge of the
    /// image, degrees, with distortion, with the lens focused at the distance that it states (else at infinity).
    #[schemars(transform = above(0.0..=360.0))]
    pub(crate) horizontal_fov_deg: Option<f64>,
    /// Glass and curvatures of a single lens in place of focal_length_mm. Each wavelength has a focus of its own, and
    /// distances are those at 587.6 nm.
    pub(crate) lensmaker: Option<LensmakerTable>,
    /// Lenses before this one, such as close-up lenses. position_m is the place of the entrance pupil that all these
    /// lenses make.
    #[serde(default)]
    pub(crate) supplementary: Vec<SupplementaryTable>,
    /// F-number: focal length over the diameter of the aperture, or of the circle through the corners of one with
    /// blades. Left out: 8; of a prescription, that of the open lens; of a hole, as is its diameter, what makes it
    /// sharpest at 550 nm, √(distance/2.44·λ).
    #[schemars(transform = above(0.0..))]
    pub(crate) f_number: Option<f64>,
    /// Diameter of the aperture, or of a pinhole, mm, in place of f_number.
    #[schemars(transform = above(0.0..))]
    pub(crate) diameter_mm: Option<f64>,
    /// Distance from the lens to the plane of focus, along the axis, m; "infinity"; or "scene", that of the middle of
    /// the geometry (of the image where that cannot be focused on). It has no effect on a pinhole. Left out: the
    /// distance that autofocus finds.
    pub(crate) focus_distance_m: Option<FocusDistance>,
    /// Pixel that autofocus focuses on: column and row from the top-left corner, or "centre". Left out, as is the
    /// distance: "centre". It has no effect on a pinhole.
    pub(crate) autofocus_px: Option<AutofocusTable>,
    /// Method of autofocus. Left out: exact.
    pub(crate) autofocus: Option<AutofocusSearchTable>,
    /// Distance from the lens, or the pinhole, to the sensor, mm, in place of a focus.
    #[schemars(transform = above(0.0..))]
    pub(crate) image_distance_mm: Option<f64>,
    /// Nearest distance that the lens can be focused on, m, without lenses before it. Left out: no limit.
    #[schemars(transform = above(0.0..))]
    pub(crate) min_focus_distance_m: Option<f64>,
    /// Circle of confusion that counts as sharp, µm on the sensor, for which depth of field is stated. Left out: the
    /// diagonal of the sensor over 1440, 30 µm of 36 × 24 mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) circle_of_confusion_um: Option<f64>,
    /// Number of aperture blades; 0 is a round aperture. Left out: 0, or those of the prescription.
    pub(crate) blades: Option<u32>,
    /// Turn of the blades, degrees. Left out: 0.
    pub(crate) blade_rotation_deg: Option<f64>,
    /// Falloff of light towards the corners. Left out: "cos4".
    pub(crate) falloff: Option<Falloff>,
    /// Transmittance, 0–1: a number, the name of a spectrum that ships with photosite, or { file = "lens.csv" }. Left
    /// out: 1.
    pub(crate) transmittance: Option<SpectrumSource>,
    /// Projection of directions to places in the image. Left out: "fisheye" with distortion of kannala-brandt,
    /// "omnidirectional" with xi, else "perspective".
    pub(crate) projection: Option<ProjectionKind>,
    /// Mirror parameter ξ of an omnidirectional lens, which needs it: 0 for a pinhole, 1 for a parabolic mirror.
    #[schemars(transform = within(0.0..))]
    pub(crate) xi: Option<f64>,
    /// Distortion. Left out: none.
    pub(crate) distortion: Option<DistortionTable>,
    /// Angle from the axis beyond which the lens sees nothing: the rim of its image circle. Left out: all that its
    /// projection can show.
    #[schemars(transform = above(0.0..))]
    pub(crate) max_angle_deg: Option<f64>,
    /// Point spread function. Left out: none, a point stays a point.
    pub(crate) psf: Option<PointSpreadTable>,
    /// Lateral chromatic aberration. Left out: none.
    pub(crate) lateral_colour: Option<LateralColourTable>,
    /// Rings that vignette, beside the aperture. Left out: none.
    #[serde(default)]
    pub(crate) stops: Vec<StopTable>,
    /// Camera matrix in place of the one that follows from focal length and focus.
    pub(crate) intrinsics: Option<IntrinsicsTable>,
    /// File of a calibration, which states camera matrix, projection and distortion in place of intrinsics, projection,
    /// xi and distortion: Kalibr's camchain.yaml, OpenCV's .yaml, .yml, .xml or .json, camera_info of ROS, COLMAP's
    /// cameras.txt, sensor.yaml of EuRoC. It holds for all pixels of the sensor, or for the image that region_px and
    /// binning leave. focal_length_mm, where it is left out, is that of the matrix at the sensor's pixel pitch.
    pub(crate) calibration: Option<String>,
    /// Camera of the calibration: its name there, such as "cam1" of Kalibr, or its number, "2" of COLMAP. Left out: the
    /// only one, or that of calibration_pose.
    pub(crate) calibration_camera: Option<String>,
    /// Area of the sensor that the calibration's image shows, px: x and y of its first corner, width and height; its
    /// pixels may be binned or scaled. Left out: what region_px and binning leave, where the calibration has as many
    /// pixels, else all of the sensor.
    pub(crate) calibration_area_px: Option<[f64; 4]>,
}

/// Kinds of lenses.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum LensType {
    /// Thin lens with depth of field.
    Thin,
    /// Ideal pinhole: everything is sharp, the image lies one focal length behind it, and there is no focus; the
    /// f-number sets the exposure only, to that of a thin lens on the axis.
    Pinhole,
    /// Hole of a finite diameter, one focal length or image_distance_mm before the sensor: each point
    /// becomes a spot of its size, and with psf = { kind = "airy" } diffraction widens it.
    Hole,
    /// Bare sensor: each pixel receives light from all directions in front of it. position_m is the middle of the
    /// sensor, which stands upside down as behind a lens, so that what lies to the right shades the left of the image.
    None,
}

/// Distance in metres, "infinity" or "scene".
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected a distance in metres, \"infinity\" or \"scene\"")]
pub(crate) enum FocusDistance {
    /// Distance, m.
    Metres(#[schemars(transform = above(0.0..))] f64),
    /// "infinity" or "scene".
    Name(#[schemars(extend("enum" = ["infinity", "scene"]))] String),
}

/// Pixel: column and row from the top-left corner, or "centre".
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(untagged, expecting = "expected a pixel such as [400, 300], or \"centre\"")]
pub(crate) enum AutofocusTable {
    /// Column and row.
    Pixel(#[schemars(transform = within(0.0..))] [f64; 2]),
    /// "centre".
    Name(#[schemars(extend("const" = "centre"))] String),
}

/// Projection of directions to places in the image.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema, PartialEq, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionKind {
    /// Rectilinear: straight lines stay straight, but for the distortion.
    Perspective,
    /// Equidistant: the radius is the angle from the axis, but for the distortion (Kannala and Brandt; OpenCV's
    /// fisheye).
    Fisheye,
    /// Fisheye whose radius is 2f·sin(θ/2) at the angle θ from the axis: equal solid angles are equal areas.
    Equisolid,
    /// Fisheye whose radius is 2f·tan(θ/2): small circles stay circles.
    Stereographic,
    /// Fisheye whose radius is f·sin θ; it sees a half-space.
    Orthographic,
    /// Panorama of longitude and latitude.
    Equirectangular,
    /// Unified model of mirrors and fisheyes, with xi (Mei and Rives; OpenCV's omnidir).
    Omnidirectional,
}

/// Distortion, the departure of the lens from its projection.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct DistortionTable {
    /// Model of distortion.
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
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema, PartialEq, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum DistortionModel {
    /// No distortion.
    None,
    /// Radial, rational, tangential and thin-prism terms (OpenCV's standard model), from the ideal to the distorted
    /// image.
    BrownConrady,
    /// u = u_d·(1 + k₁r² + k₂r⁴), from the distorted to the ideal image.
    Polynomial,
    /// u = u_d/(1 + λr²), from the distorted to the ideal image.
    Division,
    /// Fisheye of radius θ + k₁θ³ + k₂θ⁵ + k₃θ⁷ + k₄θ⁹.
    KannalaBrandt,
}

/// Point spread function.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum PointSpreadTable {
    /// Gaussian function, the same at all wavelengths.
    Gaussian {
        /// Standard deviation along each axis, µm on the sensor.
        #[schemars(transform = above(0.0..))]
        sigma_um: f64,
    },
    /// Diffraction at a round aperture, for each wavelength.
    Airy,
    /// Aberrations of a prescription and diffraction at its stop together, from the optical path differences over
    /// its pupil in the plane of focus, by place and wavelength. Away from that plane, blur has the size
    /// of the pupil alone, without the aberrated shape that rays through the glass give.
    Wave,
    /// Measured kernels.
    Kernel {
        /// Distance between the values of the files, µm on the sensor.
        #[schemars(transform = above(0.0..))]
        pitch_um: f64,
        /// Kernels, at least one; each place takes the nearest.
        kernels: Vec<KernelTable>,
        /// Origin of a kernel, which lies where the lens puts the point. Left out: "centre".
        origin: Option<KernelOrigin>,
    },
}

/// Origin of a kernel, which lies where the lens puts the point.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum KernelOrigin {
    /// The middle of its rows and columns: the centre of a value where their number is odd, and where it is even
    /// half-way between two. A kernel whose light is not about it shifts the image, against ground truth as well.
    Centre,
    /// The centroid of its light, so that the kernel shifts nothing.
    Centroid,
}

/// Measured point spread function.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct KernelTable {
    /// CSV file: a row of numbers a line; only their ratios count.
    pub(crate) file: String,
    /// Place in the image where it was measured, from −1 at the left and the top edge to 1 at the opposite ones. Left
    /// out: the middle.
    #[serde(default)]
    pub(crate) at: [f64; 2],
}

/// Magnification by wavelength.
#[derive(Clone, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct LateralColourTable {
    /// Wavelengths, nm, rising.
    pub(crate) wavelength_nm: Vec<f64>,
    /// Magnification about the principal point at each wavelength, for example 1.001; linear between them.
    #[schemars(transform = above(0.0..))]
    pub(crate) magnification: Vec<f64>,
}

/// Round opening across the axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub(crate) struct StopTable {
    /// Distance before the lens, mm; below 0 behind it.
    pub(crate) distance_mm: f64,
    /// Radius, mm.
    #[schemars(transform = above(0.0..))]
    pub(crate) radius_mm: f64,
}

/// Camera matrix in OpenCV's convention: the centre of the top-left pixel is (0, 0).
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Keys)]
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
