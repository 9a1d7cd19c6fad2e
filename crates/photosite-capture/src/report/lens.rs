//! Report of the lens: its kind, its focus, and the figures that a photographer asks for.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_transport::optics::{Camera, LensDescription, LensFigures, LensKind, PrescriptionFigures};

/// Lens.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct LensReport {
    /// Kind of lens: `thin`, `pinhole`, `hole`, `prescription`, or `none` of a bare sensor, which has no other entries.
    pub kind: String,
    /// Name of the lens prescription.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prescription: Option<String>,
    /// Focal length f, mm; below 0 of a diverging lens. For a hole, its distance from the sensor.
    pub focal_length_mm: Option<f64>,
    /// F-number N.
    pub f_number: Option<f64>,
    /// Focus distance: distance from the entrance pupil to the plane of focus, m. `null`: focused at infinity, or a
    /// lens without focus. Below 0 where light of one point of the sensor diverges, and nothing is sharp.
    pub focus_distance_m: Option<f64>,
    /// Image distance v from the lens to the sensor, mm; for a prescription, from its last surface.
    pub image_distance_mm: Option<f64>,
    /// State of a lens from a prescription; `null` of other lenses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traced: Option<PrescriptionReport>,
    /// Depth of field, angles, scale. None in reports of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<LensFiguresReport>,
    /// Steps of contrast autofocus, in this order; the sharpest was kept.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub autofocus_steps: Vec<FocusStepReport>,
}

/// Lens from a prescription: zoomed, focused and stopped down. Figures are to first order at the d line, except for
/// those that are traced at 555 nm.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PrescriptionReport {
    /// Effective focal length at this focus; where groups of the lens move for the focus it is not that at infinity.
    pub focal_length_mm: f64,
    /// Working f-number 1/(2·sin u′) of the light that comes to the middle of the image, traced: the exposure follows
    /// from it.
    pub working_f_number: f64,
    /// Diameter of the entrance pupil, mm.
    pub entrance_pupil_mm: f64,
    /// Distance from the entrance pupil to the sensor: distances from the camera's position, which the pupil is, are as
    /// much shorter than those on the barrel of the lens, which count from the sensor.
    pub entrance_pupil_to_sensor_mm: f64,
    /// Diameter of the exit pupil, mm.
    pub exit_pupil_mm: f64,
    /// Distance from the exit pupil to the sensor.
    pub exit_pupil_to_sensor_mm: f64,
    /// Distance from the vertex of the first surface to the sensor.
    pub length_mm: f64,
    /// Distance from the axis on the sensor up to which chief rays pass every aperture, traced. `null`: all of the
    /// image's do. Beyond, light goes beside the middle of the stop, and ground truth is that of the chief ray all the
    /// same.
    pub clear_radius_mm: Option<f64>,
    /// Model of the image of a point.
    #[serde(default)]
    pub point_spread: PrescribedPointSpread,
}

/// Model of the image of a point through a lens from a prescription. Ground truth goes by chief rays with either.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PrescribedPointSpread {
    /// Rays of the glass, without diffraction.
    #[default]
    Rays,
    /// Wave fronts in the plane of focus, with diffraction; before and behind it the pupil's size blurs (`lens.psf`).
    Wave,
}

impl PrescriptionReport {
    fn new(figures: &PrescriptionFigures) -> Self {
        Self {
            focal_length_mm: figures.focal_length_m * 1e3,
            working_f_number: figures.working_f_number,
            entrance_pupil_mm: figures.entrance_pupil_m * 1e3,
            entrance_pupil_to_sensor_mm: figures.entrance_pupil_to_sensor_m * 1e3,
            exit_pupil_mm: figures.exit_pupil_m * 1e3,
            exit_pupil_to_sensor_mm: figures.exit_pupil_to_sensor_m * 1e3,
            length_mm: figures.length_m * 1e3,
            clear_radius_mm: figures.clear_radius_m.map(|radius| radius * 1e3),
            point_spread: if figures.spreads_waves { PrescribedPointSpread::Wave } else { PrescribedPointSpread::Rays },
        }
    }
}

/// Step of autofocus: a focus distance that it has tried.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct FocusStepReport {
    /// Focus distance, m; `null`: at infinity.
    pub focus_distance_m: Option<f64>,
    /// Sharpness by the measure of the capture, over the square of the mean.
    pub sharpness: f64,
}

/// Figures of the lens, focused, in front of the sensor. Distances count from the entrance pupil.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct LensFiguresReport {
    /// Acceptable circle of confusion on the sensor, for which depth of field is stated, µm.
    pub circle_of_confusion_um: f64,
    /// Circle of confusion in pixel widths.
    pub circle_of_confusion_px: f64,
    /// Depth of field: nearest and farthest distance that are as sharp; `null` in place of infinity. `null` as a whole
    /// where everything is sharp, or nothing.
    pub depth_of_field_m: Option<[Option<f64>; 2]>,
    /// Hyperfocal distance: focused on it, depth of field reaches to infinity; `null` of a lens that cannot be focused
    /// there.
    pub hyperfocal_m: Option<f64>,
    /// Diameter of the entrance pupil.
    pub entrance_pupil_mm: f64,
    /// Angles of view from left to right, from top to bottom and from corner to corner, degrees; `null` where an end
    /// sees nothing.
    pub angle_of_view_deg: [Option<f64>; 3],
    /// Width and height of the field at the focus distance, m; `null` where that is at infinity.
    pub field_at_focus_m: Option<[f64; 2]>,
    /// Magnification: size of the image on the sensor over that of the object at the focus distance.
    pub magnification: Option<f64>,
    /// Width and height of a pixel's field at the focus distance, mm.
    pub pixel_at_focus_mm: Option<[f64; 2]>,
    /// Diameter of the first dark ring of diffraction at 550 nm, 2.44·λ·v/D.
    pub diffraction_spot_um: f64,
    /// Diameter of the diffraction spot in pixel widths.
    pub diffraction_spot_px: f64,
}

impl LensReport {
    /// Report of a lens in its place, in front of pixels of that width and height.
    pub fn new(lens: &LensDescription, camera: &Camera, pixel_pitch_m: [f64; 2], steps: &[FocusStepReport]) -> Self {
        let focus = camera.focus_distance_m();
        let of_lens = |value: f64| camera.makes_image().then_some(value);
        Self {
            kind: lens.kind.name().to_owned(),
            prescription: lens.prescription.as_ref().map(|prescription| prescription.name.clone()),
            focal_length_mm: of_lens(lens.focal_length_m * 1e3),
            f_number: of_lens(lens.f_number),
            focus_distance_m: (focus.is_finite() && matches!(lens.kind, LensKind::Thin | LensKind::Prescription))
                .then_some(focus),
            image_distance_mm: of_lens(camera.image_distance_m() * 1e3),
            traced: camera.prescription_figures().as_ref().map(PrescriptionReport::new),
            figures: LensFiguresReport::of(lens, camera, pixel_pitch_m),
            autofocus_steps: steps.to_vec(),
        }
    }
}

impl LensFiguresReport {
    /// Figures of a lens in its place; `None` for a bare sensor.
    pub fn of(lens: &LensDescription, camera: &Camera, pixel_pitch_m: [f64; 2]) -> Option<Self> {
        let figures = camera.figures(lens.circle_of_confusion_m)?;
        Some(Self::new(&figures, pixel_pitch_m))
    }

    fn new(figures: &LensFigures, pixel_pitch_m: [f64; 2]) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        let at_focus_mm = |magnification: f64| pixel_pitch_m.map(|pitch| pitch / magnification * 1e3);
        Self {
            circle_of_confusion_um: figures.circle_of_confusion_m * 1e6,
            circle_of_confusion_px: figures.circle_of_confusion_m / pixel_pitch_m[0],
            depth_of_field_m: figures.depth_of_field_m.map(|limits| limits.map(finite)),
            hyperfocal_m: figures.hyperfocal_m,
            entrance_pupil_mm: figures.entrance_pupil_m * 1e3,
            angle_of_view_deg: figures.angle_of_view_rad.map(|angle| angle.map(f64::to_degrees)),
            field_at_focus_m: figures.field_at_focus_m,
            magnification: figures.magnification,
            pixel_at_focus_mm: figures.magnification.map(at_focus_mm),
            diffraction_spot_um: figures.diffraction_spot_m * 1e6,
            diffraction_spot_px: figures.diffraction_spot_m / pixel_pitch_m[0],
        }
    }
}
