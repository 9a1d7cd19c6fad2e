//! Lens as a user describes it.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

use super::{GroundLens, Intrinsics, LateralColour, PointSpread, Projection, Stop, SupplementaryLens};
use photosite_core::spectrum::Spectrum;
use photosite_lens::Prescription;

/// Description of a lens in SI units. Distances are measured from the lens along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LensDescription {
    /// Lens model.
    pub kind: LensKind,
    /// Surfaces of [`LensKind::Prescription`]; without effect for other kinds.
    pub prescription: Option<Arc<Prescription>>,
    /// Focal length f of the main lens, m, not 0; below 0 for a diverging lens. Of a pinhole and a hole, the distance
    /// from there to the sensor, above 0; of a prescription, what it is zoomed to; nothing to a bare sensor.
    pub focal_length_m: f64,
    /// f-number N = |f|/D, above 0. For a pinhole it sets the exposure only, to that of a thin lens on its axis.
    pub f_number: f64,
    /// Focus of the lens, used for a thin lens and a prescription alone. Distances of the latter count from the sensor,
    /// as on the barrel of a lens, and its image distance from the vertex of the last surface.
    pub focus: Focus,
    /// Wavelengths in nm and weights by which a prescription is focused: the spot of these is least. Empty for five from 440 to
    /// 640 nm; nothing to others.
    pub focus_spectrum: Vec<(f64, f64)>,
    /// Nearest distance on which the lens can be focused, m from the main lens; `None` for no limit.
    pub min_focus_distance_m: Option<f64>,
    /// Diameter of the acceptable circle of confusion, m; `None` for the diagonal of the sensor over 1440.
    pub circle_of_confusion_m: Option<f64>,
    /// The glass of the main lens, whose focal length at the d line is f; `None` for a lens that is the same at all
    /// wavelengths.
    pub ground: Option<GroundLens>,
    /// Supplementary lenses before the main one.
    pub supplementary: Vec<SupplementaryLens>,
    /// Aperture blades: 0 for a disk of diameter D, else at least 3, the corners of a polygon within it.
    pub blades: u32,
    /// Rotation of the aperture blades, degrees.
    pub blade_rotation_deg: f64,
    /// Falloff of irradiance towards the corners.
    pub falloff: Falloff,
    /// Spectral transmittance τ, 0–1.
    pub transmittance: Spectrum,
    /// Projection from directions to places in the image, at ray level.
    pub projection: Projection,
    /// Angle from the axis beyond which the lens sees nothing, rad; `None` for all that its projection can show.
    pub max_angle_rad: Option<f64>,
    /// Point spread of the lens; `None` for sharp points.
    pub point_spread: Option<PointSpread>,
    /// Lateral chromatic aberration; `None` for none.
    pub lateral_colour: Option<LateralColour>,
    /// Stops that cut off light beside the aperture.
    pub stops: Vec<Stop>,
    /// Intrinsics given directly, in place of those that follow from v and the pixel pitch.
    pub intrinsics: Option<Intrinsics>,
}

/// Lens models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensKind {
    /// Pinhole: v = f, and everything is sharp; exposure on the axis as through an aperture D = f/N.
    Pinhole,
    /// Thin lens: 1/f = 1/u + 1/v, with depth of field.
    Thin,
    /// A hole of the diameter D = f/N at the distance f before the sensor: light goes straight on.
    Hole,
    /// Surfaces and glasses, which all rays are traced through exactly.
    Prescription,
    /// Bare sensor without a lens: each place of the sensor sees all that is in front of it.
    Bare,
}

impl LensKind {
    /// Name of the kind in a capture file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::Thin => "thin",
            Self::Hole => "hole",
            Self::Prescription => "prescription",
            Self::Bare => "none",
        }
    }
}

/// Focus of a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// Distance u from the lens along the axis, m, above f.
    Distance(f64),
    /// Focus at infinity, v = f.
    Infinity,
    /// Distance v of the sensor behind the lens, m, above 0, whatever is sharp then.
    ImageDistance(f64),
    /// Autofocus on the surface that is seen at a pixel position (continuous coordinates).
    Autofocus {
        /// Column and row of the pixel position.
        pixel: [f64; 2],
        /// Method that finds the distance.
        method: AutofocusMethod,
    },
}

/// Method by which autofocus finds the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AutofocusMethod {
    /// Distance of the surface that the chief ray meets.
    Exact,
    /// Contrast autofocus as in cameras: the focus at which a part of the image has the most contrast.
    Contrast(ContrastAutofocus),
}

/// Search for the focus of the most contrast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContrastAutofocus {
    /// Width and height of the part of the image whose contrast is measured, px.
    pub window_px: u32,
    /// Number of focus positions that are tried in each round, at least 5; the next looks between the neighbours of the
    /// best.
    pub steps: u32,
    /// Measure of contrast.
    pub measure: Sharpness,
}

/// Measures of sharpness, relative to the square of the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Sharpness {
    /// Mean squared gradient, by Sobel's masks (Tenengrad).
    Gradient,
    /// Variance of the Laplacian.
    Laplacian,
    /// Variance.
    Variance,
}

/// Falloff of light towards the corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Falloff {
    /// Natural cos⁴ of each point of the aperture, for a rectilinear lens; by the étendue for any other.
    Cos4,
    /// Even: as bright everywhere as on the axis of a thin lens of this f-number: π·sin²θ' times the mean radiance over
    /// a round aperture, where tan θ' is its radius over the distance from the lens to the sensor.
    // E = τ·Ω·(mean radiance over the aperture), with the Ω of `Camera::on_axis_sr`. Stops still cut off theirs.
    None,
}

impl LensDescription {
    /// Name in reports of the mapping from directions to places: the projection, `prescription`, or `none` for a bare
    /// sensor.
    pub fn projection_name(&self) -> &'static str {
        match self.kind {
            LensKind::Thin | LensKind::Pinhole | LensKind::Hole => self.projection.name(),
            LensKind::Prescription | LensKind::Bare => self.kind.name(),
        }
    }

    /// A thin lens with a round aperture, clear glass and natural falloff.
    pub fn thin(focal_length_m: f64, f_number: f64, focus: Focus) -> Self {
        Self {
            kind: LensKind::Thin,
            prescription: None,
            focal_length_m,
            f_number,
            focus,
            focus_spectrum: Vec::new(),
            min_focus_distance_m: None,
            circle_of_confusion_m: None,
            ground: None,
            supplementary: Vec::new(),
            blades: 0,
            blade_rotation_deg: 0.0,
            falloff: Falloff::Cos4,
            transmittance: Spectrum::constant(1.0),
            projection: Projection::Perspective,
            max_angle_rad: None,
            point_spread: None,
            lateral_colour: None,
            stops: Vec::new(),
            intrinsics: None,
        }
    }
}
