//! What figures there are.

use photosite_lens::files::GlassOf;
use serde::Serialize;

/// What is not known of the glasses.
pub(super) const ABSORPTION: &str = "Glass absorbs nothing here: internal transmittances are not known.";

/// A lens and its figures.
#[derive(Clone, Debug, Serialize)]
pub struct LensFigures {
    /// What it is called.
    pub name: String,
    /// What its file is written in.
    pub format: &'static str,
    /// Where its numbers come from.
    pub source: Option<String>,
    /// The licence of that source.
    pub licence: Option<String>,
    /// Its patent.
    pub patent: Option<String>,
    /// The f-number that the stop is closed to; null where it is open.
    pub f_number: Option<f64>,
    /// The position of zoom and focus that was asked for; null where all are here.
    pub position: Option<String>,
    /// What the file claims of the lens.
    pub claims: Claims,
    /// What the file does not say, and what stands for it.
    pub assumed: Vec<String>,
    /// What the file says and is not used.
    pub ignored: Vec<String>,
    /// What looks wrong.
    pub warnings: Vec<String>,
    /// Its glasses.
    pub glasses: Vec<GlassRow>,
    /// Its surfaces.
    pub surfaces: Vec<SurfaceRow>,
    /// Its figures in each position of zoom and focus.
    pub positions: Vec<PositionFigures>,
}

impl LensFigures {
    /// Words on the rays of pupils that were not found, where there are some.
    pub fn lost(&self) -> Option<String> {
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

/// What a file claims of its lens.
#[derive(Clone, Debug, Serialize)]
pub struct Claims {
    /// Effective focal length, mm.
    pub efl_mm: Option<f64>,
    /// f-number of the open lens.
    pub f_number: Option<f64>,
    /// Half of the angle of view, degrees.
    pub half_field_deg: Option<f64>,
    /// Distance of the corner of the picture from the axis, mm.
    pub image_half_diagonal_mm: Option<f64>,
}

/// A glass.
#[derive(Clone, Debug, Serialize)]
pub struct GlassRow {
    /// Its name.
    pub name: String,
    /// Surfaces that it is behind, counted from 0.
    pub surfaces: Vec<usize>,
    /// Index at the d line.
    pub nd: f64,
    /// Abbe number.
    pub vd: f64,
    /// Where the index comes from.
    pub source: String,
    /// Wavelengths that its formula is fitted to, nm.
    pub range_nm: Option<[f64; 2]>,
}

impl From<&GlassOf> for GlassRow {
    fn from(glass: &GlassOf) -> Self {
        let GlassOf { surfaces, name, nd, vd, source, range_nm } = glass.clone();
        Self { name, surfaces, nd, vd, source, range_nm }
    }
}

/// A surface.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceRow {
    /// Radius of curvature, mm; null is flat.
    pub radius_mm: Option<f64>,
    /// Distance to the next surface, mm.
    pub thickness_mm: f64,
    /// What fills that gap; null is air.
    pub glass: Option<String>,
    /// Radius in which light passes, mm.
    pub semi_aperture_mm: Option<f64>,
    /// Conic constant.
    pub conic: f64,
    /// Orders and coefficients of the asphere.
    pub asphere: Vec<(u32, f64)>,
    /// Whether this is the stop.
    pub stop: bool,
}

/// The figures of one position, of an object at its distance.
#[derive(Clone, Debug, Serialize)]
pub struct PositionFigures {
    /// What it is called; empty for a lens of one position.
    pub label: String,
    /// Distance of the object from the first vertex, mm; null at infinity.
    pub object_distance_mm: Option<f64>,
    /// First order at F, d, C, of an object at infinity.
    pub first_order: Vec<FirstOrderRow>,
    /// 1/(2·sin u′) of the light that reaches the middle of the picture, traced.
    pub working_f_number: f64,
    /// Distance from the first vertex to the sensor, mm.
    pub length_mm: f64,
    /// How far the focus of C is behind that of F, mm, to first order.
    pub axial_colour_mm: f64,
    /// How far the sensor is behind the paraxial focus at d, mm.
    pub defocus_mm: f64,
    /// Half of the angle of view, degrees.
    pub half_field_deg: f64,
    /// Where that angle comes from.
    pub field_from: &'static str,
    /// Figures by field, from the axis to the edge.
    pub fields: Vec<FieldFigures>,
    /// Figures of chief rays in smaller steps, for curves; none for the text.
    pub curves: Vec<ChiefFigures>,
    /// Spots and illumination at each stop.
    pub stops: Vec<StopFigures>,
}

/// First order at one wavelength.
#[derive(Clone, Debug, Serialize)]
pub struct FirstOrderRow {
    /// The spectral line.
    pub line: &'static str,
    /// Its wavelength, nm.
    pub wavelength_nm: f64,
    /// Effective focal length, mm.
    pub efl_mm: f64,
    /// From the last vertex to the focus, mm.
    pub bfl_mm: f64,
    /// The entrance pupil from the first vertex, mm.
    pub entrance_pupil_mm: f64,
    /// Its diameter, mm.
    pub entrance_pupil_diameter_mm: f64,
    /// The exit pupil from the last vertex, mm.
    pub exit_pupil_mm: f64,
    /// Its diameter, mm.
    pub exit_pupil_diameter_mm: f64,
    /// EFL over the diameter of the entrance pupil.
    pub f_number: f64,
}

/// Figures of the chief ray of a field.
#[derive(Clone, Debug, Serialize)]
pub struct ChiefFigures {
    /// Angle to the axis, degrees.
    pub field_deg: f64,
    /// Height of the chief ray on the sensor at d, mm.
    pub image_height_mm: f64,
    /// 100·(h/h₁ − 1), at d, with the height to first order h₁: f·tan θ, or that of the object times the magnification.
    pub distortion_percent: f64,
    /// Where rays beside the chief ray cross it, in its plane, behind the sensor, mm.
    pub tangential_focus_mm: Option<f64>,
    /// The same across its plane.
    pub sagittal_focus_mm: Option<f64>,
    /// How far the chief ray of F is from that of d, µm.
    pub lateral_colour_f_um: Option<f64>,
    /// The same of C.
    pub lateral_colour_c_um: Option<f64>,
}

/// Figures of one field.
#[derive(Clone, Debug, Serialize)]
pub struct FieldFigures {
    /// Those of its chief ray.
    #[serde(flatten)]
    pub chief: ChiefFigures,
    /// |S|, sr: irradiance over radiance of a uniform scene.
    pub illumination_sr: f64,
    /// The same over that of the axis.
    pub relative_illumination: f64,
    /// Root mean square of the spot at F, d, C, µm.
    pub spot_rms_um: [Option<f64>; 3],
    /// That of all three together.
    pub spot_rms_all_um: Option<f64>,
    /// Modulation transfer at F, d, C; for the text at d.
    pub mtf: [Option<MtfFigures>; 3],
}

/// Modulation transfer at one field and wavelength.
#[derive(Clone, Debug, Serialize)]
pub struct MtfFigures {
    /// Root mean square of the optical path differences, waves.
    pub rms_waves: f64,
    /// The part of the pupil whose rays were not found and count nowhere; 0 unless the lens folds it.
    pub lost: f64,
    /// `wave` from the optical path differences; `rays` from the spot, where they are so large that diffraction adds
    /// nothing.
    pub method: &'static str,
    /// Cycles per mm.
    pub frequency_per_mm: Vec<f64>,
    /// Along the direction from the axis.
    pub tangential: Vec<f64>,
    /// Across it.
    pub sagittal: Vec<f64>,
}

/// Figures of one opening of the stop.
#[derive(Clone, Debug, Serialize)]
pub struct StopFigures {
    /// f-number, EFL over the diameter of the entrance pupil.
    pub f_number: f64,
    /// Irradiance over that of the axis, by field.
    pub relative_illumination: Vec<f64>,
    /// Root mean square of the spot of F, d and C together, µm, by field.
    pub spot_rms_um: Vec<Option<f64>>,
}
