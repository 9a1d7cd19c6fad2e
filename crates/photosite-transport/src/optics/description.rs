//! A lens as a user describes it, checked.

use super::{Intrinsics, LateralColour, PointSpread, Projection, Stop};
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;

/// A lens in SI units. Distances are measured from the lens along the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LensDescription {
    /// Pinhole or thin lens.
    pub kind: LensKind,
    /// Focal length f, m, above 0.
    pub focal_length_m: f64,
    /// f-number N = f/D, above 0. For a pinhole it sets the exposure only, to that of a thin lens on its axis.
    pub f_number: f64,
    /// What is sharp. Not looked at for a pinhole, behind which everything is.
    pub focus: Focus,
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
}

/// What the lens is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// Distance u from the lens along the axis, m, above f.
    Distance(f64),
    /// v = f.
    Infinity,
    /// On what the chief ray of this pixel position (continuous coordinates) meets.
    Autofocus {
        /// Column, row.
        pixel: [f64; 2],
    },
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
    /// A thin lens with a round aperture, clear glass and natural falloff.
    pub fn thin(focal_length_m: f64, f_number: f64, focus: Focus) -> Self {
        Self {
            kind: LensKind::Thin,
            focal_length_m,
            f_number,
            focus,
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

    /// Refuses what no lens can be. Keys are those of the capture file's `[lens]` table.
    pub fn validate(&self) -> Result<(), Invalid> {
        let positive = |key: &str, value: f64, unit: &str, example: &str| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(Invalid::new(key, format!("must be above 0, got {value}{unit}"))
                .help(format!("for example {key} = {example}")))
        };
        positive("focal_length_mm", self.focal_length_m * 1e3, " mm", "16.0")?;
        positive("f_number", self.f_number, "", "2.8")?;
        if let (Focus::Distance(u), LensKind::Thin) = (self.focus, self.kind)
            && !(u.is_finite() && u > self.focal_length_m)
        {
            let message = format!("{u} m does not lie beyond the focal length of {} m", self.focal_length_m);
            return Err(Invalid::new("focus_distance_m", message)
                .help("a lens can only focus on what is farther away than its focal length; write a larger distance or \"infinity\""));
        }
        if self.blades == 1 || self.blades == 2 {
            return Err(Invalid::new("blades", format!("{} blades make no opening", self.blades))
                .help("write 0 for a round aperture, or 3 and more"));
        }
        if self.transmittance.min() < 0.0 || self.transmittance.max() > 1.0 {
            return Err(Invalid::new("transmittance", "must lie between 0 and 1 at every wavelength"));
        }
        if let Some(angle) = self.max_angle_rad {
            positive("max_angle_deg", angle.to_degrees(), "°", "85.0")?;
        }
        if !self.stops.is_empty() && !self.projection.is_flat() {
            let message = "a lens that can see more than a half-space has no axis for stops to stand across";
            return Err(Invalid::new("stops", message).help("remove them, or take a perspective lens"));
        }
        if let Some(i) = self.intrinsics {
            positive("intrinsics.fx", i.fx, " px", "1200.0")?;
            positive("intrinsics.fy", i.fy, " px", "1200.0")?;
        }
        Ok(())
    }
}
