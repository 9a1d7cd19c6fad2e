//! What a prescription says: the neutral form that every file format is read into.
//!
//! Nothing here is checked: readers fill it in as they find it, and a lens that is made of it refuses what cannot be
//! traced.

use photosite_core::spectrum::{Dispersion, Spectrum};

/// A lens as its designer writes it down: surfaces in the order in which light from the scene meets them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prescription {
    /// What the lens is called.
    pub name: String,
    /// Where the numbers come from: a file, a page, a book.
    pub source: Option<String>,
    /// The licence of that source.
    pub licence: Option<String>,
    /// Number and example of the patent.
    pub patent: Option<String>,
    /// What the source claims of the lens, to be compared with what its numbers give.
    pub claims: Claims,
    /// The surfaces, the first one nearest to the scene.
    pub surfaces: Vec<Surface>,
    /// The blades of the stop; `None` for a round opening.
    pub blades: Option<Blades>,
    /// Settings of zoom and focus. Empty for a lens with one setting, that of the surfaces' own thicknesses.
    pub positions: Vec<Position>,
}

/// What the source of a prescription claims, at infinity and in its first position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Claims {
    /// Effective focal length, mm.
    pub focal_length_mm: Option<f64>,
    /// f-number of the open lens.
    pub f_number: Option<f64>,
    /// Half of the angle of view in object space, degrees.
    pub half_field_deg: Option<f64>,
    /// Distance of the corner of the picture from the axis, mm.
    pub image_half_diagonal_mm: Option<f64>,
}

/// A surface, and the gap that follows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Radius of curvature R, mm: the centre is at +R along z from the vertex. `None` is flat.
    pub radius_mm: Option<f64>,
    /// Distance along the axis to the next surface, mm; of the last surface, to the sensor.
    pub thickness_mm: f64,
    /// What fills that gap; `None` is air.
    pub glass: Option<Glass>,
    /// Radius in which light passes, mm: x² + y² at the surface is at most its square. `None` where the source does not
    /// say, which is an error that offers a value.
    pub semi_aperture_mm: Option<f64>,
    /// Conic constant k: 0 for a sphere, −1 for a paraboloid.
    pub conic: f64,
    /// Terms a_m·r^m of the sag as pairs m, a_m (mm^(1 − m)), of any orders from 2 up, even or odd.
    pub asphere: Vec<(u32, f64)>,
    /// Whether this is the aperture stop, which one surface must be.
    pub is_stop: bool,
    /// What the surface is coated with.
    pub coating: Coating,
}

/// A glass of a prescription.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// Its name as reports print it: `N-BK7`, `1.6727/32.1`.
    pub name: String,
    /// Where the index comes from: a catalogue, the Abbe number of a patent.
    pub source: String,
    /// Refractive index relative to air.
    pub dispersion: Dispersion,
    /// Shortest and longest wavelength that the formula was fitted to, nm, where that is known. Beyond, the formula goes
    /// on as it stands.
    pub range_nm: Option<[f64; 2]>,
}

/// The coating of a surface between air and glass. A surface between two glasses is cemented and has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Coating {
    /// Nothing is said, as in every patent.
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
    /// The same at all wavelengths.
    Constant {
        /// Refractive index n.
        n: f64,
        /// Extinction coefficient k.
        k: f64,
    },
    /// From a table.
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
    /// Corners, at least 3.
    pub count: u32,
    /// Angle of the first corner from the x axis towards y, degrees.
    pub rotation_deg: f64,
}

/// A setting of a zoom or of the focus. Semi-apertures stay as they are, but the stop's may change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Position {
    /// What it is called: `24 mm`, `infinity`.
    pub label: String,
    /// Gaps that differ from the surfaces' own: the number of the surface before the gap, counted from 0, and its
    /// thickness, mm.
    pub gaps: Vec<(usize, f64)>,
    /// Half of the angle of view, degrees, where the source says it.
    pub half_field_deg: Option<f64>,
    /// Semi-aperture of the stop, mm, where it differs.
    pub stop_semi_aperture_mm: Option<f64>,
    /// Distance of what is sharp from the first vertex, mm; `None` is infinity.
    pub object_distance_mm: Option<f64>,
    /// Of a position at a distance: the focal length at infinity of the setting of a zoom that it belongs to, mm.
    pub focal_length_mm: Option<f64>,
}
