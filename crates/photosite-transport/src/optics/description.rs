//! A lens as a user describes it.

use std::sync::Arc;

use super::{GroundLens, Intrinsics, LateralColour, PointSpread, Projection, Stop, SupplementaryLens};
use photosite_core::spectrum::Spectrum;
use photosite_lens::Prescription;

/// A lens in SI units. Distances are measured from the lens along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LensDescription {
    /// What makes the picture.
    pub kind: LensKind,
    /// The surfaces of [`LensKind::Prescription`]; nothing to others.
    pub prescription: Option<Arc<Prescription>>,
    /// Focal length f of the main lens, m, not 0; below 0 for a diverging lens. Of a pinhole and a hole, the distance
    /// from there to the sensor, above 0; of a prescription, what it is zoomed to; nothing to a bare sensor.
    pub focal_length_m: f64,
    /// f-number N = |f|/D, above 0. For a pinhole it sets the exposure only, to that of a thin lens on its axis.
    pub f_number: f64,
    /// What is sharp. Looked at of a thin lens and a prescription alone. Distances of the latter count from the sensor, as
    /// on the barrel of a lens, and its image distance from the vertex of the last surface.
    pub focus: Focus,
    /// Wavelengths in nm and weights by which a prescription is focused: the spot of these is least. Empty for five from 440 to
    /// 640 nm; nothing to others.
    pub focus_spectrum: Vec<(f64, f64)>,
    /// The nearest that it can be focused on, m from the main lens; `None` for no such limit.
    pub min_focus_distance_m: Option<f64>,
    /// The acceptable circle of confusion, m; `None` for the diagonal of the sensor over 1440.
    pub circle_of_confusion_m: Option<f64>,
    /// The glass of the main lens, whose focal length at the d line is f; `None` for a lens that is the same at all
    /// wavelengths.
    pub ground: Option<GroundLens>,
    /// Lenses before the main one.
    pub supplementary: Vec<SupplementaryLens>,
    /// Aperture blades: 0 for a disk of diameter D, else at least 3, the corners of a polygon within it.
    pub blades: u32,
    /// Rotation of the blades, degrees.
    pub blade_rotation_deg: f64,
    /// Whether irradiance falls off towards the corners.
    pub falloff: Falloff,
    /// Spectral transmittance τ, 0–1.
    pub transmittance: Spectrum,
    /// How directions become places in the picture, at ray level.
    pub projection: Projection,
    /// Angle from the axis beyond which the lens sees nothing, rad; `None` for all that its projection can show.
    pub max_angle_rad: Option<f64>,
    /// The picture of a point; `None` for a point.
    pub point_spread: Option<PointSpread>,
    /// Lateral chromatic aberration; `None` for none.
    pub lateral_colour: Option<LateralColour>,
    /// What cuts off light beside the aperture.
    pub stops: Vec<Stop>,
    /// Intrinsics given directly, in place of those that follow from v and the pixel pitch.
    pub intrinsics: Option<Intrinsics>,
}

/// Lens models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LensKind {
    /// v = f, and everything is sharp; exposure on the axis as through an aperture D = f/N.
    Pinhole,
    /// 1/f = 1/u + 1/v, with depth of field.
    Thin,
    /// A hole of the diameter D = f/N at the distance f before the sensor: light goes straight on.
    Hole,
    /// Surfaces and glasses, which all rays are traced through exactly.
    Prescription,
    /// No lens: each place of the sensor sees all that is in front of it.
    Bare,
}

impl LensKind {
    /// Its name in a capture file.
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

/// What the lens is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// Distance u from the lens along the axis, m, above f.
    Distance(f64),
    /// v = f.
    Infinity,
    /// The sensor stands at this distance v behind the lens, m, above 0, whatever is sharp then.
    ImageDistance(f64),
    /// On what is seen at this pixel position (continuous coordinates).
    Autofocus {
        /// Column, row.
        pixel: [f64; 2],
        /// How its distance is found.
        method: AutofocusMethod,
    },
}

/// How autofocus finds the distance of what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AutofocusMethod {
    /// By the distance of what the chief ray meets.
    Exact,
    /// As cameras do: by the focus at which a part of the picture has the most contrast.
    Contrast(ContrastAutofocus),
}

/// A search for the most contrast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContrastAutofocus {
    /// Width and height of the part of the picture that is looked at, px.
    pub window_px: u32,
    /// Positions of the focus that are tried in each round, at least 5; the next looks between the neighbours of the best.
    pub steps: u32,
    /// What counts as contrast.
    pub measure: Sharpness,
}

/// Measures of the sharpness of a picture g, relative to the square of its mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharpness {
    /// Mean squared gradient, by Sobel's masks (Tenengrad).
    Gradient,
    /// Variance of the Laplacian.
    Laplacian,
    /// Variance.
    Variance,
}

/// Falloff of the irradiance towards the corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// The natural cos⁴θ of each aperture point, for a rectilinear lens; what keeps the étendue for any other.
    Cos4,
    /// As on the axis everywhere: E = τ·Ω·(mean radiance over the aperture), with the Ω of
    /// [`Camera::on_axis_sr`](super::Camera::on_axis_sr), π·sin²θ' of a round aperture, tan θ' = D/2v. Stops still cut
    /// off theirs.
    None,
}

impl LensDescription {
    /// What makes places of directions, as reports name it: the projection, `prescription`, or `none` of a bare sensor.
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
