//! Figures of a lens, as they are printed in JSON.

use photosite_lens::files::GlassOf;
use serde::Serialize;

/// Note on the transmittance of glasses.
pub(super) const ABSORPTION: &str = "Glass absorbs nothing here: internal transmittances are not known.";

/// Lens and its figures.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LensFigures {
    /// Name of the lens.
    pub name: String,
    /// Format of the lens file.
    pub format: &'static str,
    /// Source of the prescription.
    pub source: Option<String>,
    /// Licence of the source.
    pub licence: Option<String>,
    /// Patent of the lens.
    pub patent: Option<String>,
    /// F-number that the stop is closed to; null where it is open.
    pub f_number: Option<f64>,
    /// Requested position of zoom and focus; null where all are included.
    pub position: Option<String>,
    /// Claims of the file about the lens.
    pub claims: Claims,
    /// Assumptions about what the file does not say.
    pub assumed: Vec<String>,
    /// Statements of the file that are not used.
    pub ignored: Vec<String>,
    /// Warnings of what looks wrong in the file.
    pub warnings: Vec<String>,
    /// Glasses of the lens.
    pub glasses: Vec<GlassRow>,
    /// Surfaces of the lens.
    pub surfaces: Vec<SurfaceRow>,
    /// Figures in each position of zoom and focus.
    pub positions: Vec<PositionFigures>,
}

impl LensFigures {
    /// Warning about rays of pupils that were not found, where there are some.
    pub(crate) fn lost(&self) -> Option<String> {
        let fields = self.positions.iter().flat_map(|position| &position.fields);
        let parts = fields.flat_map(|field| {
            field.mtf.iter().flatten().map(|mtf| (mtf.lost, field.chief.field_deg)).filter(|(lost, _)| *lost > 0.0)
        });
        let (lost, angle) = parts.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!(
            "the lens folds its pupil: path differences and modulation leave out up to {:.1} % of the light, at {angle:.1}°",
            100.0 * lost
        ))
    }
}

/// Claims of a file about its lens.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Claims {
    /// Effective focal length, mm.
    pub efl_mm: Option<f64>,
    /// F-number of the open lens.
    pub f_number: Option<f64>,
    /// Half of the angle of view, degrees.
    pub half_field_deg: Option<f64>,
    /// Distance of the corner of the image from the axis, mm.
    pub image_half_diagonal_mm: Option<f64>,
}

/// Glass of the lens.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct GlassRow {
    /// Name of the glass.
    pub name: String,
    /// Surfaces in front of the glass, counted from 0.
    pub surfaces: Vec<usize>,
    /// Index at the d line.
    pub nd: f64,
    /// Abbe number.
    pub vd: f64,
    /// Source of the index.
    pub source: String,
    /// Wavelength range of the index formula, nm.
    pub range_nm: Option<[f64; 2]>,
}

impl From<&GlassOf> for GlassRow {
    fn from(glass: &GlassOf) -> Self {
        let GlassOf { surfaces, name, nd, vd, source, range_nm } = glass.clone();
        Self { name, surfaces, nd, vd, source, range_nm }
    }
}

/// Surface of the lens.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SurfaceRow {
    /// Radius of curvature, mm; null is flat.
    pub radius_mm: Option<f64>,
    /// Distance to the next surface, mm.
    pub thickness_mm: f64,
    /// Glass between this surface and the next; null is air.
    pub glass: Option<String>,
    /// Semi-aperture: the radius within which light passes, mm.
    pub semi_aperture_mm: Option<f64>,
    /// Conic constant.
    pub conic: f64,
    /// Order and coefficient of each term of the asphere.
    pub asphere: Vec<(u32, f64)>,
    /// Whether this is the stop.
    pub stop: bool,
}

/// Figures of one position, for an object at its distance.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PositionFigures {
    /// Name of the position; empty for a lens of one position.
    pub label: String,
    /// Distance of the object from the first vertex, mm; null at infinity.
    pub object_distance_mm: Option<f64>,
    /// First-order figures at F, d, C, for an object at infinity.
    pub first_order: Vec<FirstOrderRow>,
    /// Working f-number 1/(2·sin u′) of the light that reaches the middle of the image, traced.
    pub working_f_number: f64,
    /// Distance from the first vertex to the sensor, mm.
    pub length_mm: f64,
    /// Axial colour: distance of the focus of C behind that of F, mm, to first order.
    pub axial_colour_mm: f64,
    /// Defocus: distance of the sensor behind the paraxial focus at d, mm.
    pub defocus_mm: f64,
    /// Half of the angle of view, degrees.
    pub half_field_deg: f64,
    /// Source of the half angle of view.
    pub field_from: &'static str,
    /// Figures by field, from the axis to the edge.
    pub fields: Vec<FieldFigures>,
    /// Figures of chief rays in smaller steps, for curves; none for the text.
    pub curves: Vec<ChiefFigures>,
    /// Spots and illumination at each stop.
    pub stops: Vec<StopFigures>,
}

/// First-order figures at one wavelength.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FirstOrderRow {
    /// Name of the spectral line.
    pub line: &'static str,
    /// Wavelength of the line, nm.
    pub wavelength_nm: f64,
    /// Effective focal length, mm.
    pub efl_mm: f64,
    /// Back focal length: distance from the last vertex to the focus, mm.
    pub bfl_mm: f64,
    /// Distance of the entrance pupil from the first vertex, mm.
    pub entrance_pupil_mm: f64,
    /// Diameter of the entrance pupil, mm.
    pub entrance_pupil_diameter_mm: f64,
    /// Distance of the exit pupil from the last vertex, mm.
    pub exit_pupil_mm: f64,
    /// Diameter of the exit pupil, mm.
    pub exit_pupil_diameter_mm: f64,
    /// F-number: EFL over the diameter of the entrance pupil.
    pub f_number: f64,
}

/// Figures of the chief ray of a field.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ChiefFigures {
    /// Angle to the axis, degrees.
    pub field_deg: f64,
    /// Height of the chief ray on the sensor at d, mm.
    pub image_height_mm: f64,
    /// Distortion 100·(h/h₁ − 1) at d, %, with the height to first order h₁: f·tan θ, or that of the object times the
    /// magnification.
    pub distortion_percent: f64,
    /// Tangential focus behind the sensor, mm: the crossing of rays next to the chief ray, in its plane.
    pub tangential_focus_mm: Option<f64>,
    /// Sagittal focus behind the sensor, mm: the crossing of rays next to the chief ray, across its plane.
    pub sagittal_focus_mm: Option<f64>,
    /// Lateral colour of F: distance of its chief ray from that of d, µm.
    pub lateral_colour_f_um: Option<f64>,
    /// Lateral colour of C: distance of its chief ray from that of d, µm.
    pub lateral_colour_c_um: Option<f64>,
}

/// Figures of one field.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct FieldFigures {
    /// Figures of the field's chief ray.
    #[serde(flatten)]
    pub chief: ChiefFigures,
    /// Illumination |S|, sr: irradiance over radiance of a uniform scene.
    pub illumination_sr: f64,
    /// Illumination relative to that on the axis.
    pub relative_illumination: f64,
    /// Root mean square of the spot at F, d and C, µm.
    pub spot_rms_um: [Option<f64>; 3],
    /// Root mean square of the spot of F, d and C together, µm.
    pub spot_rms_all_um: Option<f64>,
    /// Modulation transfer at F, d, C; for the text at d.
    pub mtf: [Option<MtfFigures>; 3],
}

/// Modulation transfer at one field and wavelength.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MtfFigures {
    /// Root mean square of the optical path differences, waves.
    pub rms_waves: f64,
    /// Part of the pupil whose rays were not found and are left out; 0 unless the lens folds the pupil.
    pub lost: f64,
    /// Method: `wave` from the optical path differences; `rays` from the spot, where they are so large that diffraction
    /// adds nothing.
    pub method: &'static str,
    /// Spatial frequencies, cycles per mm.
    pub frequency_per_mm: Vec<f64>,
    /// Modulation along the direction from the axis.
    pub tangential: Vec<f64>,
    /// Modulation across the direction from the axis.
    pub sagittal: Vec<f64>,
}

/// Figures of one opening of the stop.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StopFigures {
    /// F-number: EFL over the diameter of the entrance pupil.
    pub f_number: f64,
    /// Illumination relative to that on the axis, by field.
    pub relative_illumination: Vec<f64>,
    /// Root mean square of the spot of F, d and C together, µm, by field.
    pub spot_rms_um: Vec<Option<f64>>,
}
