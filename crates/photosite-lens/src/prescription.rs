//! Prescriptions: the neutral form that every lens file format is read into.
//!
//! Prescriptions are not checked: readers fill them in as found in files, and [`Lens`](crate::Lens) refuses those that
//! cannot be traced.

use photosite_core::spectrum::{Dispersion, Spectrum};

/// A lens as its designer specifies it: surfaces in the order in which light from the scene meets them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prescription {
    /// Name of the lens.
    pub name: String,
    /// Source of the numbers: a file, a page, a book.
    pub source: Option<String>,
    /// Licence of the source.
    pub licence: Option<String>,
    /// Number and example of the patent.
    pub patent: Option<String>,
    /// Claims of the source, to be compared with results of the prescription.
    pub claims: Claims,
    /// Surfaces, from the scene to the sensor.
    pub surfaces: Vec<Surface>,
    /// Blades of the stop; `None` for a round opening.
    pub blades: Option<Blades>,
    /// Settings of zoom and focus. Empty for a lens with one setting, which has the surfaces' own thicknesses.
    pub positions: Vec<Position>,
}

/// Claims of a prescription's source, at infinity and in the first position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Claims {
    /// Effective focal length, mm.
    pub focal_length_mm: Option<f64>,
    /// f-number of the lens with its stop fully open.
    pub f_number: Option<f64>,
    /// Half of the angle of view in object space, degrees.
    pub half_field_deg: Option<f64>,
    /// Distance of the image corner from the axis, mm.
    pub image_half_diagonal_mm: Option<f64>,
}

/// A surface, and the gap that follows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Radius of curvature R, mm: the centre is at +R along z from the vertex. `None` for a flat surface.
    pub radius_mm: Option<f64>,
    /// Distance along the axis to the next surface, mm; from the last surface, to the sensor.
    pub thickness_mm: f64,
    /// Glass of that gap; `None` is air.
    pub glass: Option<Glass>,
    /// Semi-aperture, mm: light passes where x² + y² at the surface is at most its square. `None` where the source does
    /// not give it, which is an error that offers a value.
    pub semi_aperture_mm: Option<f64>,
    /// Conic constant k: 0 for a sphere, −1 for a paraboloid.
    pub conic: f64,
    /// Terms a_m·r^m of the sag as pairs m, a_m (mm^(1 − m)), of any orders from 2 up, even or odd.
    pub asphere: Vec<(u32, f64)>,
    /// Whether the surface is the aperture stop; one surface must be.
    pub is_stop: bool,
    /// Coating of the surface.
    pub coating: Coating,
}

/// A glass of a prescription.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// Name in reports: `N-BK7`, `1.6727/32.1`.
    pub name: String,
    /// Source of the index: a catalogue, the Abbe number of a patent.
    pub source: String,
    /// Refractive index relative to air.
    pub dispersion: Dispersion,
    /// Shortest and longest wavelength that the formula was fitted to, nm, where that is known. Beyond, the formula is
    /// extrapolated.
    pub range_nm: Option<[f64; 2]>,
}

/// The coating of a surface between air and glass. A surface between two glasses is cemented and has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Coating {
    /// No statement, as in every patent.
    #[default]
    Unknown,
    /// Bare glass.
    Uncoated,
    /// Thin films, from the air side to the glass.
    Layers(Vec<Layer>),
}

/// A thin film.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Complex index of the film.
    pub index: LayerIndex,
    /// Thickness, nm.
    pub thickness_nm: f64,
}

/// The complex refractive index n + ik of a thin film; k is above 0 where it absorbs.
#[derive(Clone, Debug, PartialEq)]
pub enum LayerIndex {
    /// Constant index.
    Constant {
        /// Refractive index n.
        n: f64,
        /// Extinction coefficient k.
        k: f64,
    },
    /// Tabulated index.
    Table {
        /// Refractive index n.
        n: Spectrum,
        /// Extinction coefficient k.
        k: Spectrum,
    },
}

/// Aperture blades: a regular polygon inscribed in the circle of the stop's semi-aperture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blades {
    /// Number of corners, at least 3.
    pub count: u32,
    /// Angle of the first corner from the x axis towards y, degrees.
    pub rotation_deg: f64,
}

/// A setting of zoom or focus. Semi-apertures stay as they are, but the stop's may change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Position {
    /// Label: `24 mm`, `infinity`.
    pub label: String,
    /// Gaps that differ from the surfaces' own: number of the surface before the gap, counted from 0, and thickness,
    /// mm.
    pub gaps: Vec<(usize, f64)>,
    /// Half of the angle of view, degrees, where the source gives it.
    pub half_field_deg: Option<f64>,
    /// Semi-aperture of the stop, mm, where it differs.
    pub stop_semi_aperture_mm: Option<f64>,
    /// Object distance in focus, from the first vertex, mm; `None` is infinity.
    pub object_distance_mm: Option<f64>,
    /// Focal length at infinity, mm, of the zoom setting that a position at a finite distance belongs to.
    pub focal_length_mm: Option<f64>,
}
