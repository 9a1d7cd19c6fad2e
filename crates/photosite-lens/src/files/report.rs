//! Report of reading a lens file.

use super::format::Format;
use crate::Lens;
use crate::prescription::Prescription;

/// A glass of a lens, with the source of its index.
#[derive(Clone, Debug, PartialEq)]
pub struct GlassOf {
    /// Surfaces in front of the glass, counted from 0.
    pub surfaces: Vec<usize>,
    /// Name of the glass.
    pub name: String,
    /// Index at the d line, n_d.
    pub nd: f64,
    /// Abbe number ν_d.
    pub vd: f64,
    /// Source of the index.
    pub source: String,
    /// Wavelengths that the index formula was fitted to, nm.
    pub range_nm: Option<[f64; 2]>,
}

/// Report of content read, assumed and ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Format of the file.
    pub format: Format,
    /// All glasses.
    pub glasses: Vec<GlassOf>,
    /// Assumptions for content that the file lacks.
    pub assumed: Vec<String>,
    /// Content of the file that is not used.
    pub ignored: Vec<String>,
    /// Suspicious values, with the likely cause.
    pub warnings: Vec<String>,
}

/// A lens read from a file, with its report.
#[derive(Debug)]
pub struct Reading {
    /// Prescription, which a [`Lens`] can be made of.
    pub prescription: Prescription,
    /// Lens in its first position.
    pub lens: Lens,
    /// Report of content read, assumed and ignored.
    pub report: Report,
}

/// Distinct glasses of a prescription.
pub(super) fn glasses_of(prescription: &Prescription) -> Vec<GlassOf> {
    let mut found: Vec<GlassOf> = Vec::new();
    for (number, surface) in prescription.surfaces.iter().enumerate() {
        let Some(glass) = &surface.glass else { continue };
        match found.iter_mut().find(|known| known.name == glass.name && known.source == glass.source) {
            Some(known) => known.surfaces.push(number),
            None => found.push(GlassOf {
                surfaces: vec![number],
                name: glass.name.clone(),
                nd: glass.dispersion.index(photosite_core::spectrum::dispersion::lines::D),
                vd: glass.dispersion.abbe_number(),
                source: glass.source.clone(),
                range_nm: glass.range_nm,
            }),
        }
    }
    found
}

/// Number rounded for display.
pub(super) fn rounded(x: f64) -> f64 {
    photosite_core::math::float::rounded(x, 7)
}
